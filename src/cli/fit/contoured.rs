//! Observations by the joint pipeline of silhouettes, instead of masks.

use std::path::Path;

use super::arguments::FitArguments;
use super::input::tell;
use crate::cli::error::CliError;
use crate::cli::frame_range::FrameRange;
use crate::cli::silhouettes::{self, DEFAULT_BODY};
use crate::io::frames::{Footage, FramesError};
use crate::io::model;
use crate::io::recording::{Made, Recording};
use crate::likelihood::Measure;
use crate::pipeline::check_measure;
use crate::silhouette::FrameObservations;
use crate::stereo::SideBySide;

/// The pictures, if silhouettes are to be found by the joint pipeline: asked for, or the only good way.
pub(super) fn wanted(arguments: &FitArguments) -> Result<Option<Footage>, CliError> {
    let open = || Footage::open(&arguments.recording, arguments.fps);
    if let Some(asked) = arguments.silhouettes {
        return match asked.is_joint() {
            true => Ok(Some(open()?)),
            false => Ok(None),
        };
    }
    let given = Recording::open(&arguments.recording, arguments.fps);
    if arguments.stereo.is_some() || given.is_ok_and(|r| r.has_masks() || r.has_points()) {
        return Ok(None);
    }
    match open() {
        Err(FramesError::NoPictures { .. }) => Ok(None),
        opened => Ok(Some(opened?).filter(is_only_way)),
    }
}

/// Whether depth is seen and the empty scene is not.
fn is_only_way(footage: &Footage) -> bool {
    let is_empty_seen = footage.cameras.iter().any(|c| c.background.is_some());
    !is_empty_seen && SideBySide::of(&footage.rig).is_ok()
}

/// Silhouettes and points of the frames to be fitted; masks and contours are kept in OUT.
pub(super) fn observe(
    footage: &Footage,
    arguments: &FitArguments,
) -> Result<(Recording, Vec<FrameObservations>), CliError> {
    let all = footage.frames();
    let frames = FrameRange::of(arguments.frames, &all)?;
    let body = arguments.body.as_deref().unwrap_or(DEFAULT_BODY);
    let model = model::load(body, Path::new(""))?;
    check_measure(&model, Some(Measure::Metaballs))?;
    let progress = arguments.quiet.progress();
    let kept = (footage, frames, arguments.out.as_path());
    let (observed, notes) = silhouettes::observe(kept, &model, progress)?;
    tell(&notes, arguments);
    let made = Made {
        masks: true,
        points: false,
    };
    let recording = Recording::open_made(&arguments.recording, footage, &arguments.out, made)?;
    Ok((recording, observed))
}
