//! `maquette fit`: read, fit, write.

mod arguments;
mod contoured;
mod input;
mod made;

use std::fs;
use std::time::Instant;

pub(super) use arguments::{ABOUT, EXAMPLES, FitArguments};
use input::{Input, identity, read};

use super::error::{CliError, one_line};
use super::progress::{Bars, Watched};
use super::summary::Summary;
use super::{complain, print};
use maquette::inference::Sequence;
use maquette::io::folder::journal::DiskJournal;
use maquette::io::folder::overlays;
use maquette::io::folder::{Existing, OutError, OutFolder};
use maquette::io::points::trc::write_trc;
use maquette::io::result::{Provenance, ResultFile, trajectories};
use maquette::pipeline::{self, Fit, Progress};

/// Fits a recording and writes the result.
pub(super) fn run(arguments: &FitArguments) -> Result<(), CliError> {
    arguments.threads.run(|| fit(arguments))
}

fn fit(arguments: &FitArguments) -> Result<(), CliError> {
    let start = Instant::now();
    // 1. read and check everything; nothing is written until it is known to be usable
    let input = read(arguments)?;
    // 2. fit, keeping what is finished
    let out = OutFolder::open(&arguments.out)?;
    let journal = journal(&out, arguments.existing(), &input)?;
    let fitted =
        search(&input, &journal, &arguments.quiet.progress()).inspect_err(|_| out.abandon())?;
    // 3. write the result, and only then replace an older one
    let result = write(&out, &input, &fitted, arguments)?;
    if let Some(fault) = journal.fault() {
        complain(
            "note",
            &one_line(&format!("the result is complete; {fault}")),
        );
    }
    // 4. say what was found
    let summary = Summary {
        result: &result,
        out: &arguments.out,
        seconds: start.elapsed().as_secs_f64(),
    };
    match (arguments.json, arguments.quiet.is_on()) {
        (true, _) => print(&summary.json()),
        (false, false) => print(&summary.text()),
        (false, true) => {}
    }
    Ok(())
}

fn journal(out: &OutFolder, existing: Existing, input: &Input) -> Result<DiskJournal, CliError> {
    let (folder, identity) = (out.journal(), identity(input));
    match existing {
        Existing::Resume => Ok(DiskJournal::resume(&folder, &identity)?),
        Existing::Refuse | Existing::Overwrite => {
            let created = DiskJournal::create(&folder, &identity);
            Ok(created.inspect_err(|_| out.abandon())?)
        }
    }
}

fn search(input: &Input, journal: &DiskJournal, bars: &Bars) -> Result<Fit, CliError> {
    let frames = input.observations.len();
    let keyframes = frames.div_ceil(input.options.search.keyframe_spacing(frames));
    let watched = Watched::new(journal, bars, keyframes, frames);
    let sequence = Sequence {
        frames: &input.observations,
        fps: input.recording.fps,
    };
    let rig = &input.recording.rig;
    let fitted = pipeline::fit(&input.model, rig, sequence, &input.options, &watched);
    watched.finish();
    Ok(fitted?)
}

fn write(
    out: &OutFolder,
    input: &Input,
    fit: &Fit,
    arguments: &FitArguments,
) -> Result<ResultFile, CliError> {
    let Input {
        options,
        recording,
        model,
        observations,
        checksums,
    } = input;
    let result = ResultFile::new(
        fit,
        Provenance {
            recording,
            observations,
            inputs: checksums,
            model,
            options,
        },
    );
    let scratch = out.scratch()?;
    if arguments.overlays {
        let pictures = fit.frames.len() * recording.rig.cameras.len();
        let progress = arguments.quiet.progress();
        progress.begin("overlays", pictures);
        let folder = scratch.path().join("overlays");
        overlays::write(&folder, recording, model, fit, &|| progress.step())?;
        progress.end();
    }
    let joints = write_trc(&trajectories(fit, model, recording.fps), "joints.trc");
    for (name, bytes) in [
        ("joints.trc", joints.into_bytes()),
        ("result.json", result.text()?),
    ] {
        let path = scratch.path().join(name);
        fs::write(&path, bytes).map_err(|source| OutError::Write {
            path: arguments.out.join(name),
            source,
        })?;
    }
    out.publish(scratch)?;
    Ok(result)
}
