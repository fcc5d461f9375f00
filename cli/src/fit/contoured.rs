//! Observations by the joint pipeline of silhouettes, instead of masks.

use std::path::Path;

use super::arguments::FitArguments;
use super::made::measure;
use crate::error::CliError;
use crate::silhouettes::{self, DEFAULT_BODY};
use maquette::io::model;
use maquette::io::recording::footage::Footage;
use maquette::io::recording::{DerivedFiles, ObservationFiles, Recording};
use maquette::likelihood::Measure;
use maquette::pipeline::check_measure;
use maquette::silhouette::FrameObservations;
use maquette::stereo::SideBySide;

/// Silhouettes and points of the frames, where no file holds them.
pub(super) type Observed = Option<Vec<FrameObservations>>;

/// Whether the joint pipeline is the only good way, where there are no masks: depth is seen and the empty scene is not.
pub(super) fn is_only_way(footage: &Footage) -> bool {
    let is_empty_seen = footage.cameras.iter().any(|c| c.background.is_some());
    !is_empty_seen && SideBySide::choose(&footage.rig).is_ok()
}

/// Silhouettes and points of the frames to be fitted; masks and contours are kept in OUT.
///
/// The points are those before the still scene and near the body that the pipeline itself fits to, and, asked for with `--stereo`, what is
/// measured within the contours: surer, but not on a leg of which a camera sees little behind the other.
pub(super) fn observe(
    recording: &Recording,
    footage: &Footage,
    arguments: &FitArguments,
) -> Result<(ObservationFiles, Observed), CliError> {
    let all = footage.frames();
    let frames = arguments.frames.unwrap_or_default().select(&all)?;
    let body = arguments.body.as_deref().unwrap_or(DEFAULT_BODY);
    let model = model::load(body, Path::new(""))?;
    check_measure(&model, Some(Measure::Metaballs))?;
    let progress = arguments.quiet.progress();
    let kept = (footage, frames, arguments.out.as_path());
    let (mut observed, notes) = silhouettes::observe(kept, &model, &progress)?;
    arguments.quiet.print_notes(&notes);
    let open = |has_points: bool| {
        recording.with_derived(DerivedFiles {
            footage,
            folder: &arguments.out,
            has_masks: true,
            has_points,
        })
    };
    let Some(method) = arguments.stereo else {
        return Ok((open(false)?, Some(observed)));
    };
    measure(footage, &open(false)?, method, arguments)?;
    let files = open(true)?;
    for frame in &mut observed {
        files.load_points(frame)?;
    }
    Ok((files, Some(observed)))
}
