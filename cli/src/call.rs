//! Commands for a program of another language: the words of the command line in, values out, nothing printed.
//!
//! Options, their defaults and what is wrong with them are the program's, because the words are parsed as the program's are.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, Parser};
use maquette::io::recording::InputChecksum;
use maquette::pipeline::Progress;
use maquette::workflow::FittedSession;
use maquette::{FittedRecording, GaitStudy};
use serde_json::Value;

use crate::calibrate::CalibrateArguments;
use crate::compare::CompareArguments;
use crate::error::CliError;
use crate::export::ExportArguments;
use crate::fit::FitArguments;
use crate::gait::GaitArguments;
use crate::report::ReportArguments;
use crate::segment::SegmentArguments;
use crate::session::SessionArguments;
use crate::silhouettes::SilhouettesArguments;
use crate::simulate::SimulateArguments;
use crate::skin::SkinArguments;
use crate::stereo::StereoArguments;
use crate::sync::SyncArguments;
use crate::synth::SynthArguments;

/// The words of one command, without its name.
#[derive(Debug, Parser)]
#[command(no_binary_name = true)]
struct Words<T: Args> {
    #[command(flatten)]
    arguments: T,
}

fn parsed<T: Args>(words: &[OsString]) -> Result<T, CliError> {
    let words = Words::try_parse_from(words).map_err(|fault| CliError::arguments(&fault))?;
    Ok(words.arguments)
}

/// What `maquette fit` with these words finds and writes.
///
/// # Errors
/// [`CliError`], whose line is the program's. A fit that cannot be used is none: its verdict is in the result.
pub fn fit(words: &[OsString], progress: &dyn Progress) -> Result<FittedRecording, CliError> {
    parsed::<FitArguments>(words)?.call(progress)
}

/// Fingerprints of everything that `maquette fit` with these words reads.
///
/// # Errors
/// [`CliError`], whose line is the program's.
pub fn inputs(words: &[OsString]) -> Result<Vec<InputChecksum>, CliError> {
    parsed::<FitArguments>(words)?.inputs()
}

/// What `maquette gait` with these words finds of a fit; its input and the folder it writes into count for nothing.
///
/// # Errors
/// [`CliError`], whose line is the program's.
pub fn gait(fit: &FittedRecording, words: &[OsString]) -> Result<GaitStudy, CliError> {
    parsed::<GaitArguments>(words)?.study(fit)
}

/// The page that `maquette report` with these words writes of a fit.
///
/// # Errors
/// [`CliError`], whose line is the program's.
pub fn report(
    fit: &FittedRecording,
    words: &[OsString],
    progress: &dyn Progress,
) -> Result<String, CliError> {
    parsed::<ReportArguments>(words)?.page(fit, progress)
}

/// The page of all trials that `maquette report` with these words writes of a session.
///
/// # Errors
/// [`CliError`], whose line is the program's.
pub fn session_page(words: &[OsString]) -> Result<String, CliError> {
    parsed::<ReportArguments>(words)?.session_page()
}

/// Writes a fit as `maquette export` with these words does, but into the folder itself, and says where.
///
/// # Errors
/// [`CliError`], whose line is the program's.
pub fn export(fit: &FittedRecording, words: &[OsString]) -> Result<Vec<PathBuf>, CliError> {
    parsed::<ExportArguments>(words)?.written(fit)
}

/// What `maquette session` with these words finds and writes.
///
/// # Errors
/// [`CliError`], whose line is the program's. A trial that cannot be used is none: it is named in the session.
pub fn session(words: &[OsString], progress: &dyn Progress) -> Result<FittedSession, CliError> {
    parsed::<SessionArguments>(words)?.call(progress)
}

/// What `maquette compare --json` with these words prints, and its page; nothing is written.
///
/// # Errors
/// [`CliError`], whose line is the program's.
pub fn compare(words: &[OsString]) -> Result<(Value, String), CliError> {
    parsed::<CompareArguments>(words)?.call()
}

/// Writes what `maquette synth` with these words writes.
///
/// # Errors
/// [`CliError`], whose line is the program's.
pub fn synth(words: &[OsString]) -> Result<(), CliError> {
    parsed::<SynthArguments>(words)?.written().map(drop)
}

/// Writes what `maquette simulate` with these words writes.
///
/// # Errors
/// [`CliError`], whose line is the program's.
pub fn simulate(words: &[OsString]) -> Result<(), CliError> {
    parsed::<SimulateArguments>(words)?.said().map(drop)
}

/// What `maquette calibrate --json` with these words prints; the calibration is written.
///
/// # Errors
/// [`CliError`], whose line is the program's.
pub fn calibrate(words: &[OsString], progress: &dyn Progress) -> Result<Value, CliError> {
    Ok(parsed::<CalibrateArguments>(words)?.said(progress)?.json)
}

/// What `maquette sync --json` with these words prints; the offsets are written.
///
/// # Errors
/// [`CliError`], whose line is the program's.
pub fn sync(words: &[OsString], progress: &dyn Progress) -> Result<Value, CliError> {
    Ok(parsed::<SyncArguments>(words)?.said(progress)?.json)
}

/// What `maquette segment --json` with these words prints; the masks are written.
///
/// # Errors
/// [`CliError`], whose line is the program's.
pub fn segment(words: &[OsString], progress: &dyn Progress) -> Result<Value, CliError> {
    Ok(parsed::<SegmentArguments>(words)?.said(progress)?.json)
}

/// What `maquette silhouettes --json` with these words prints; the silhouettes are written.
///
/// # Errors
/// [`CliError`], whose line is the program's. Silhouettes that are nobody's are none: `failure` says why.
pub fn silhouettes(words: &[OsString], progress: &dyn Progress) -> Result<Value, CliError> {
    Ok(parsed::<SilhouettesArguments>(words)?.found(progress)?.said.json)
}

/// What `maquette stereo --json` with these words prints; the points are written.
///
/// # Errors
/// [`CliError`], whose line is the program's.
pub fn stereo(words: &[OsString], progress: &dyn Progress) -> Result<Value, CliError> {
    Ok(parsed::<StereoArguments>(words)?.said(progress)?.json)
}

/// What `maquette skin --json` with these words prints; the skins are written.
///
/// # Errors
/// [`CliError`], whose line is the program's.
pub fn skin(words: &[OsString], progress: &dyn Progress) -> Result<Value, CliError> {
    Ok(parsed::<SkinArguments>(words)?.said(progress)?.json)
}
