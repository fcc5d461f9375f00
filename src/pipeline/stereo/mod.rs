//! Points of the surface, frame by frame, from cameras that stand side by side.
//!
//! | file          | holds                                                                  |
//! |---------------|------------------------------------------------------------------------|
//! | `options.rs`  | [`StereoOptions`]: how points are found, and with which cameras         |
//! | `surface.rs`  | [`SurfaceFrame`]: what one frame shows                                  |
//! | `views.rs`    | the pictures and masks of a frame                                      |
//! | `tracks.rs`   | [`SurfaceTracks`]: points followed through ten frames at a time         |
//! | `summary.rs`  | [`SurfaceSummary`]: what was measured in all frames                     |
//! | `error.rs`    | [`StereoError`]                                                        |

mod error;
mod options;
mod summary;
mod surface;
mod tracks;
mod views;

pub use error::StereoError;
pub use options::{StereoMethod, StereoOptions};
pub use summary::{SurfaceSummary, unmasked_note};
pub use surface::{DisparityMap, MeasuredSurface, SurfaceFrame};
pub use tracks::SurfaceTracks;

use super::{MaskSource, PictureSource, Progress, span};
use crate::silhouette::FrameIndex;
use surface::Measurement;

/// Measures the surface in some frames, where there are masks that of the person, and hands each to `take` as soon as it is done.
///
/// Pictures are matched in all cameras at once, or correlated pair by pair. Matched points can be followed: tracks end
/// after ten frames, where a picture is missing, and with the last frame.
///
/// # Errors
/// [`StereoError`] for cameras that cannot be matched, and whatever `take` fails with.
pub fn measure_surface<E: From<StereoError>>(
    pictures: &dyn PictureSource,
    masks: Option<&dyn MaskSource>,
    frames: &[FrameIndex],
    options: &StereoOptions,
    progress: &dyn Progress,
    mut take: impl FnMut(SurfaceFrame) -> Result<(), E>,
) -> Result<SurfaceSummary, E> {
    let mut measurement = Measurement::new(pictures, masks, options)?;
    let mut summary = SurfaceSummary::new(options);

    progress.begin("stereo", frames.len());
    let mut stream = pictures.pictures(span(frames));
    let mut next = stream.next();
    while let Some((frame, pictures)) = next {
        let mut measured = measurement.measure(frame, &pictures)?;
        // looked for only now: whoever decodes ahead may do so while the frame is measured
        next = stream.next();
        if next.is_none() {
            measured.ended_tracks.extend(measurement.end_tracks());
        }

        summary.count(&measured);
        take(measured)?;
        progress.step();
    }
    progress.end();

    summary.finish(stream.notes());
    Ok(summary)
}
