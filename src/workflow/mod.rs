//! The front door: from a recording to a fitted body, its gait, a report and the files of other programs, in one call each.
//!
//! A room of its own above [`pipeline`](crate::pipeline), [`io`](crate::io) and `report`: it joins what is computed with
//! what is read and written, and computes nothing itself. The program `maquette` calls nothing else.
//!
//! | file          | holds                                                                        |
//! |---------------|------------------------------------------------------------------------------|
//! | `options.rs`  | [`FitOptions`]: how a recording is fitted                                     |
//! | `fit.rs`      | `Recording::fit`, in memory, and `Recording::fit_into` a folder               |
//! | `input.rs`    | everything that a fit is made from                                            |
//! | `body.rs`     | which body is fitted                                                          |
//! | `mistakes.rs` | usual mistakes that are told before anything is searched                      |
//! | `people.rs`   | what is fitted of each person of several                                     |
//! | `derived.rs`  | what a recording lacks, made of its pictures: masks, contours, points         |
//! | `given.rs`    | what a recording has before that, and fingerprints of what a fit reads        |
//! | `masks.rs`, `silhouettes.rs`, `surface.rs` | masks cut out of pictures, silhouettes found in clutter, points measured by stereo, as files |
//! | `fitted.rs`   | [`FittedRecording`]: lengths, angles, `result.json`                           |
//! | `gait.rs`     | [`GaitStudy`]: a gait analysis, of a fit or of points of any system           |
//! | `own_norm.rs` | [`NormPeople`]: a norm of several people's walks                              |
//! | `report.rs`   | its report, with the feature `report`                                         |
//! | `export.rs`   | its files for other programs                                                  |
//! | `calibrate.rs` | [`RefinedRig`]: a calibration refined by a person who moves                  |
//! | `lenses.rs`   | [`LensRig`]: the same of cameras of which the lenses alone are known         |
//! | `sync/`       | [`SyncedRecording`]: when each camera began                                   |
//! | `session/`    | [`Session`]: several trials of one person, with one body for all              |
//! | `fitted_source.rs` | a fit that either of them looks at                                      |
//! | `fitted_files.rs` | what a fit was made from, for its report and its simulation             |
//! | `simulate.rs` | the recording that its cameras would have made of a fitted body              |
//! | `skin.rs`     | the skins of a fitted body                                                    |
//! | `error.rs`    | [`Error`]                                                                     |

mod body;
mod calibrate;
mod derived;
mod detections;
mod error;
mod export;
mod fit;
mod fitted;
mod fitted_files;
mod fitted_source;
mod gait;
mod given;
mod input;
mod lenses;
mod masks;
mod mistakes;
mod options;
mod own_norm;
mod people;
#[cfg(feature = "report")]
mod report;
mod session;
mod silhouettes;
mod simulate;
mod skin;
mod surface;
mod sync;

pub use body::DEFAULT_BODY;
pub use calibrate::{CalibrateError, RefinedCamera, RefinedRig, UsedRecording};
pub use error::Error;
pub use export::ExportFormat;
pub use fit::FitFolder;
pub use fitted::{AngleTrack, FittedRecording, Length};
pub use gait::{EventChoice, GaitSource, GaitStudy, NormChoice, StandingError};
pub use lenses::LensRig;
pub use masks::{MaskFiles, WrittenMasks};
pub use options::{FitOptions, SilhouetteSource};
pub use own_norm::{NormPeople, OwnNormError};
#[cfg(feature = "report")]
pub use report::ReportedRecording;
pub use session::{Comparison, FittedSession, Session, SessionError, SessionFolder, SessionStudy};
pub use silhouettes::{SilhouetteFiles, WrittenSilhouettes};
pub use simulate::Simulation;
pub use skin::{RestingBody, SkinFiles, SkinnedPoses};
pub use surface::SurfaceFiles;
pub use sync::{
    FoundOffset, SoundCheck, SyncError, SyncOptions, SyncedCamera, SyncedRecording, WINDOW,
};
