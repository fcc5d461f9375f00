//! Notes on a recording: odd, but not wrong.

use std::path::PathBuf;

use crate::pipeline::Frames;

fn counted_people(others: usize) -> String {
    if others == 1 { "another person is seen".into() } else { format!("{others} others are seen") }
}

/// A note for the user on where cameras were calibrated, in one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationNote {
    /// A calibration above the recording's folder.
    #[error("calibration: read from {}, as the recording's own folder has none", path.display())]
    Above {
        /// Where it was found.
        path: PathBuf,
    },
    /// Cameras with a lens and no pose, or the other way round.
    #[error("calibration: only one of intri.yml and extri.yml has {}: not used", cameras.join(", "))]
    Unpaired {
        /// The cameras.
        cameras: Vec<String>,
    },
}

/// A note for the user on a recording, in one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Note {
    /// Where the cameras were calibrated.
    #[error(transparent)]
    Calibration(#[from] CalibrationNote),
    /// Keys of the manifest that are not used because there are masks.
    #[error("{}: not used, because there are masks", keys.join(", "))]
    Ignored {
        /// The keys.
        keys: Vec<&'static str>,
    },
    /// A camera of the manifest without masks, while others have some.
    #[error("camera {camera}: no masks in the manifest: not used")]
    WithoutMasks {
        /// The camera.
        camera: String,
    },
    /// A folder of masks whose name is no calibrated camera's.
    #[error(
        "masks/{camera}: no camera of this name is calibrated (did you mean {nearest}?): not used"
    )]
    Uncalibrated {
        /// Name of the folder.
        camera: String,
        /// The calibrated camera whose name is most like it.
        nearest: String,
    },
    /// Calibrated cameras for which there is no folder of masks.
    #[error("no masks for {}: not used", cameras.join(", "))]
    Unmasked {
        /// The cameras.
        cameras: Vec<String>,
    },
    /// Images whose names hold no number.
    #[error("camera {camera}: {files} images without a frame number in their names: not used")]
    Unnumbered {
        /// The camera.
        camera: String,
        /// How many.
        files: usize,
    },
    /// Masks that `offset_frames` moves before frame 0.
    #[error("camera {camera}: offset_frames puts {files} masks before frame 0: not used")]
    BeforeFirst {
        /// The camera.
        camera: String,
        /// How many.
        files: usize,
    },
    /// Masks that are not there, while other cameras have theirs.
    #[error("camera {camera}: {} of {of} masks are missing ({frames})", frames.0.len())]
    MasksMissing {
        /// The camera.
        camera: String,
        /// The frames.
        frames: Frames,
        /// How many there should be.
        of: usize,
    },
    /// What was odd about the pictures that masks, contours or points were made of.
    #[error("{line}")]
    Pictures {
        /// In one line.
        line: String,
    },
    /// Points that no stage of the fit compares with the body.
    #[error(
        "points: not fitted to: the body {body} is compared by its ellipsoids: choose a body with metaballs, or --likelihood metaballs"
    )]
    PointsUnfitted {
        /// Name of the body.
        body: String,
    },
    /// A camera whose pictures are of other moments than those of all others.
    #[error(
        "camera {camera}: none of its frames ({first} to {last}) is one of the other cameras' ({others_first} to {others_last}), so it says nothing: check offset_frames, start_s and offsets.toml"
    )]
    NeverTogether {
        /// The camera.
        camera: String,
        /// Number of its first frame.
        first: usize,
        /// Of its last.
        last: usize,
        /// Of the others' first.
        others_first: usize,
        /// Of the others' last.
        others_last: usize,
    },
    /// No frame is seen by two cameras.
    #[error(
        "no frame has masks from two cameras: do the file numbers agree? offset_frames shifts them"
    )]
    NoCommonFrame,
    /// Detections of other people.
    #[error(
        "detections: {} for half as long or longer than the one seen longest, and not fitted; --people says how many are",
        counted_people(*others)
    )]
    OtherPeople {
        /// How many.
        others: usize,
    },
    /// Several people are fitted.
    #[error(
        "{people} people are seen: person {person} is measured here, the others are in people/; --person and --people choose"
    )]
    SeveralPeople {
        /// How many.
        people: usize,
        /// Who is measured.
        person: usize,
    },
    /// No detection is of whom the masks show.
    #[error("detections: none is of the person whom the masks show: not used")]
    NobodyDetected,
    /// A camera whose detections are of nobody whom the others see.
    #[error(
        "camera {camera}: none of its detections is of the person whom the others see: check its calibration, the size of the pictures that they were made from, and offset_frames"
    )]
    DetectedElsewhere {
        /// The camera.
        camera: String,
    },
    /// Point clouds without a number in their names.
    #[error("points: {files} files without a frame number in their names: not used")]
    UnnumberedPoints {
        /// How many.
        files: usize,
    },
    /// Only some of the frames have points.
    #[error("points: {with} of {frames} frames have points")]
    PointsMissing {
        /// How many frames have points.
        with: usize,
        /// How many frames there are.
        frames: usize,
    },
    /// Point clouds without a usable point.
    #[error("points: no usable points in frames {frames}")]
    PointsEmpty {
        /// The frames.
        frames: Frames,
    },
    /// Points that are not finite or have no positive spread.
    #[error(
        "points: {points} points left out in frames {frames}: not finite, or a spread that is not positive"
    )]
    PointsUnusable {
        /// How many.
        points: usize,
        /// The frames that have them.
        frames: Frames,
    },
    /// Clouds of more points than are used.
    #[error("points: up to {most_points} in a frame; thinned evenly to {used} in frames {frames}")]
    PointsThinned {
        /// The largest of them.
        most_points: usize,
        /// How many are used of each.
        used: usize,
        /// The frames.
        frames: Frames,
    },
}
