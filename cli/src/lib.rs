//! The command line: arguments in, tables out; the only room that knows the terminal and the clock.
//!
//! [`run`] is the program. A program of another language calls [`call`], which gives values instead of tables.
//!
//! | file          | holds                                                          |
//! |---------------|----------------------------------------------------------------|
//! | `main.rs`     | the program: its words in, its exit code out                    |
//! | `call.rs`     | commands that give values                                       |
//! | `fit.rs`      | `maquette fit`                                                  |
//! | `session.rs`  | `maquette session`                                              |
//! | `study.rs`    | where `maquette study` is                                       |
//! | `segment.rs`  | `maquette segment`                                              |
//! | `silhouettes.rs` | `maquette silhouettes`                                       |
//! | `export.rs`   | `maquette export`                                               |
//! | `gait.rs`     | `maquette gait`                                                 |
//! | `report.rs`   | `maquette report`                                               |
//! | `compare.rs`  | `maquette compare`                                              |
//! | `norm.rs`     | `maquette norm`                                                 |
//! | `subject.rs`  | who was recorded, for `gait` and `report`                       |
//! | `synth.rs`    | `maquette synth`                                                |
//! | `simulate.rs` | `maquette simulate`                                             |
//! | `models.rs`   | `maquette models`                                               |
//! | `skin.rs`     | `maquette skin`, and the skins of `maquette models`             |
//! | `stereo.rs`   | `maquette stereo`                                               |
//! | `calibrate.rs` | `maquette calibrate`                                           |
//! | `sync.rs`     | `maquette sync`                                                 |
//! | `camera_fit.rs` | the fit and the files of both                                 |
//! | `choice.rs`   | arguments that choose a value of the library by its name        |
//! | `pictures.rs` | the recording, frames and folder of `segment`, `silhouettes`, `stereo` |
//! | `said.rs`     | what a command has to say, for a person and as JSON             |
//! | `schema.rs`   | `maquette schema`; the schemas are in `cli/schemas`             |
//! | `shell.rs`    | `maquette completions`, `maquette man`                          |
//! | `progress.rs` | a bar for each stage                                            |
//! | `summary.rs`  | the summary of a fit, for a person and as JSON                  |
//! | `table.rs`    | columns                                                         |
//! | `interrupt.rs` | a signal to stop                                               |
//! | `error.rs`    | what went wrong, in one line                                    |
//!
//! Exit code 0; 2 for arguments or input that cannot be used, and 3 for a fit that cannot be used, with one line on standard
//! error; 130, 143 and 129 after SIGINT, SIGTERM and SIGHUP, with one line that says how to go on.

mod calibrate;
pub mod call;
mod camera_fit;
mod choice;
mod compare;
mod error;
mod export;
mod fit;
mod gait;
mod interrupt;
mod lenses_found;
mod models;
mod norm;
mod page;
mod pictures;
mod progress;
mod report;
mod said;
mod schema;
mod segment;
mod session;
mod shell;
mod silhouettes;
mod simulate;
mod skin;
mod stereo;
mod study;
mod subject;
mod summary;
mod switches;
mod sync;
mod synth;
mod table;

use std::ffi::OsString;
use std::io::Write;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};

pub use error::CliError;
use error::printable;

/// Measure how a person is built and how they move, from cameras that see them from several sides.
///
/// Maquette fits a jointed body to the outlines of a person in calibrated recordings, without markers, clicks or a
/// start pose. It gives segment lengths, joint centres and joint angles, and says how sure it is.
#[derive(Debug, Parser)]
#[command(name = "maquette", version, arg_required_else_help = true, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  the sample recording:
    maquette fit data/sequences/walker --out out/walker
  a folder of your own with calibration.* and masks/<camera>/:
    maquette fit my-recording --fps 50 --out out/me
  the same again, with pictures of the fit:
    maquette fit my-recording --fps 50 --out out/me --overwrite --overlays
  the fitted body's skin, a mesh and a picture for each frame (models with metaballs):
    maquette skin out/me --picture
  a folder of walks of one person, and what changed since the last session:
    maquette session walks --out out/after
    maquette compare out/before out/after --out out/change
  a recording of somebody else, with the truth:
    maquette synth out/somebody --seed 7

What a recording may hold and what the results mean: docs/formats.md";

#[derive(Debug, Subcommand)]
enum Command {
    /// Fit a body to a recording: shape, motion and confidence
    #[command(long_about = fit::ABOUT, after_help = fit::EXAMPLES)]
    Fit(fit::FitArguments),
    /// Fit several trials of one person with one body
    #[command(long_about = session::ABOUT, after_help = session::EXAMPLES)]
    Session(session::SessionArguments),
    /// Fit the trials of many people, and gather one dataset (with the Python package)
    #[command(long_about = study::ABOUT)]
    Study(study::StudyArguments),
    /// Cut the person out of images or videos: masks for every camera and frame
    #[command(long_about = segment::ABOUT, after_help = segment::EXAMPLES)]
    Segment(segment::SegmentArguments),
    /// Find the person's outline before clutter, with a body that predicts where to look
    #[command(long_about = silhouettes::ABOUT, after_help = silhouettes::EXAMPLES)]
    Silhouettes(silhouettes::SilhouettesArguments),
    /// Write the skin of a fitted body as meshes and pictures
    #[command(long_about = skin::ABOUT, after_help = skin::EXAMPLES)]
    Skin(skin::SkinArguments),
    /// Measure points on the surface with cameras that stand side by side
    #[command(long_about = stereo::ABOUT, after_help = stereo::EXAMPLES)]
    Stereo(stereo::StereoArguments),
    /// Refine a calibration by a person who moves before the cameras
    #[command(long_about = calibrate::ABOUT, after_help = calibrate::EXAMPLES)]
    Calibrate(calibrate::CalibrateArguments),
    /// Find when each camera began, from the person that they show
    #[command(long_about = sync::ABOUT, after_help = sync::EXAMPLES)]
    Sync(sync::SyncArguments),
    /// Analyse a walk: events, steps, angles over the gait cycle, scores
    #[command(long_about = gait::ABOUT, after_help = gait::EXAMPLES)]
    Gait(gait::GaitArguments),
    /// Write a report for clinicians
    #[command(long_about = report::ABOUT, after_help = report::EXAMPLES)]
    Report(report::ReportArguments),
    /// Compare two sessions of one person
    #[command(long_about = compare::ABOUT, after_help = compare::EXAMPLES)]
    Compare(compare::CompareArguments),
    /// Make a norm of walks of healthy people
    #[command(long_about = norm::ABOUT, after_help = norm::EXAMPLES)]
    Norm(norm::NormArguments),
    /// Convert a fit to other programs' formats
    #[command(long_about = export::ABOUT, after_help = export::EXAMPLES)]
    Export(export::ExportArguments),
    /// List the body models that come with the program, or show one
    #[command(long_about = models::ABOUT)]
    Models(models::ModelsArguments),
    /// Make a synthetic recording of a walking person, with the truth
    #[command(long_about = synth::ABOUT)]
    Synth(synth::SynthArguments),
    /// Make a synthetic recording of a fitted body, by the fit's own cameras
    #[command(long_about = simulate::ABOUT, after_help = simulate::EXAMPLES)]
    Simulate(simulate::SimulateArguments),
    /// Print the JSON Schema of what a command prints with --json
    #[command(long_about = schema::ABOUT)]
    Schema(schema::SchemaArguments),
    /// Print completions for a shell
    #[command(long_about = shell::COMPLETIONS)]
    Completions(shell::CompletionsArguments),
    /// Print the manual, for `man`
    #[command(long_about = shell::MAN)]
    Man,
}

impl Command {
    fn run(&self) -> Result<(), CliError> {
        match self {
            Self::Fit(arguments) => fit::run(arguments),
            Self::Session(arguments) => session::run(arguments),
            Self::Study(arguments) => study::run(arguments),
            Self::Segment(arguments) => segment::run(arguments),
            Self::Silhouettes(arguments) => silhouettes::run(arguments),
            Self::Skin(arguments) => skin::run(arguments),
            Self::Stereo(arguments) => stereo::run(arguments),
            Self::Calibrate(arguments) => calibrate::run(arguments),
            Self::Sync(arguments) => sync::run(arguments),
            Self::Gait(arguments) => gait::run(arguments),
            Self::Report(arguments) => report::run(arguments),
            Self::Compare(arguments) => compare::run(arguments),
            Self::Norm(arguments) => norm::run(arguments),
            Self::Export(arguments) => export::run(arguments),
            Self::Models(arguments) => models::run(arguments),
            Self::Synth(arguments) => synth::run(arguments),
            Self::Simulate(arguments) => simulate::run(arguments),

            // what the program says of itself
            Self::Schema(arguments) => {
                schema::run(arguments);
                Ok(())
            }
            Self::Completions(arguments) => {
                shell::completions(Arguments::command(), arguments);
                Ok(())
            }
            Self::Man => {
                shell::man(Arguments::command()).map_err(|e| maquette::Error::from(e).into())
            }
        }
    }

    /// How to go on after a signal to stop.
    fn after_an_interruption(&self) -> &'static str {
        match self {
            Self::Fit(_) | Self::Session(_) => {
                "what was finished is kept in OUT: the same command with --resume, and without --overwrite, goes on there"
            }
            Self::Segment(_) | Self::Silhouettes(_) | Self::Stereo(_) => {
                "OUT is not complete: the same command with --overwrite begins anew"
            }
            _ => "the same command begins anew",
        }
    }
}

/// Does what these words say, the program's name first, and gives the exit code.
pub fn run(words: impl IntoIterator<Item = OsString>) -> u8 {
    let done = match Arguments::try_parse_from(words) {
        Ok(arguments) => {
            interrupt::watch(arguments.command.after_an_interruption());
            arguments.command.run()
        }
        Err(fault) if is_help(fault.kind()) => {
            print(&fault.render().to_string());
            Ok(())
        }
        Err(fault) => Err(CliError::arguments(&fault)),
    };

    match done {
        Ok(()) => 0,
        Err(fault) => {
            complain("error", &fault.line());
            fault.exit_code()
        }
    }
}

fn is_help(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::DisplayHelp
            | ErrorKind::DisplayVersion
            | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
    )
}

/// Prints to standard output. If the reader has closed it, as `| head` does, that is no error.
fn print(text: &str) {
    let _ = std::io::stdout().lock().write_all(printable(text).as_bytes());
}

/// Prints one line to standard error.
fn complain(kind: &str, line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{kind}: {line}");
}
