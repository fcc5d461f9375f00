//! Why nothing could be fitted.

use super::Cause;
use super::diagnosis::joined;
use super::scene::MOST_EMPTY_FRAMES;
use crate::camera::PoseForm;
use crate::silhouette::{FrameIndex, InvalidOption, Rejected};

/// Why nothing could be fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// An option outside its range.
    #[error(transparent)]
    Option(#[from] InvalidOption),
    /// No frame at all.
    #[error("no frame to fit")]
    NoFrames,
    /// Numbers that no recording has.
    #[error(
        "the frames are numbered from {first} to {last}, and {empty} numbers between have none ({MOST_EMPTY_FRAMES} at most): number the files by frame, from 0"
    )]
    Sparse {
        /// The first number.
        first: FrameIndex,
        /// The last.
        last: FrameIndex,
        /// How many between them are of no frame.
        empty: usize,
    },
    /// No mask shows anybody.
    #[error(
        "none of the {masks} masks shows a person: camera {camera}, {frame}: {reason}, and so on"
    )]
    NothingSeen {
        /// How many masks there are.
        masks: usize,
        /// A camera.
        camera: String,
        /// A frame.
        frame: FrameIndex,
        /// Why its mask shows nobody.
        reason: Rejected,
    },
    /// A person who was not found.
    #[error(
        "person {person} was asked for, and {}",
        if *people == 1 { "one person is seen".into() } else { format!("{people} people are seen: --person 1 to {people}") }
    )]
    NoPerson {
        /// Who was asked for.
        person: usize,
        /// How many there are.
        people: usize,
    },
    /// No detection of anybody.
    #[error(
        "the detections of {frames} frames show nobody: every confidence is 0, or no file lists people"
    )]
    NobodyDetected {
        /// How many frames there are.
        frames: usize,
    },
    /// Poses in another form.
    #[error(
        "the pictures of all cameras agree if the calibration is read so that {}, and not as it is: write poses = \"{form}\" in sequence.toml",
        form.formula()
    )]
    PosesWritten {
        /// How they must be written.
        form: PoseForm,
    },
    /// Detections of pictures of another size.
    #[error(
        "the detections look as if they were made from pictures of {:.2} times the size of the calibration's: if they were, write detections_scale = {scale} in sequence.toml",
        1.0 / scale
    )]
    DetectionsScaled {
        /// How many of the calibration's pixels one of theirs is.
        scale: f64,
    },
    /// Detections that are not of one person.
    #[error(
        "no two cameras see one person: the lines of sight to the joints in {pictures} pictures of {frames} frames miss each other; check the calibration, and that the numbers in the names of the files agree between cameras"
    )]
    DetectionsApart {
        /// How many pictures show people.
        pictures: usize,
        /// Of how many frames.
        frames: usize,
    },
    /// Points without silhouettes, and too few of them.
    #[error(
        "no frame shows the person to two cameras and none has as many as {least} points ({most} at most): a search begins at one or the other"
    )]
    FewPoints {
        /// How many points show where a body is.
        least: usize,
        /// How many there are.
        most: usize,
    },
    /// No frame shows the person to two cameras.
    #[error(
        "no frame shows the person to two cameras at once (most are shown by camera {camera}: {frames}), so how far away and how large the person is cannot be told apart; do the numbers in the names of the masks agree between cameras?"
    )]
    NeverTwo {
        /// The camera that sees most.
        camera: String,
        /// In how many frames.
        frames: usize,
    },
    /// Cameras that look elsewhere.
    #[error(
        "{} {} no volume in common with the other cameras ({why}): check {} calibration, and unit and up in sequence.toml",
        listed(cameras), if cameras.len() == 1 { "sees" } else { "see" }, if cameras.len() == 1 { "its" } else { "their" }
    )]
    NoCommonView {
        /// The cameras.
        cameras: Vec<String>,
        /// Where the first of them has what the others see.
        why: String,
    },
    /// Silhouettes that the edges of the images cut, and that do not meet.
    #[error(
        "{} and the other cameras show the person at different places, but most masks are cut by the edge of the picture: is the person in view yet? Give the frames in which they are with --frames FIRST:LAST; else check calibration, unit and up",
        listed(cameras)
    )]
    NotInView {
        /// The cameras that disagree.
        cameras: Vec<String>,
    },
    /// Cameras that look elsewhere, and why.
    #[error("the cameras do not see one scene: {}", joined(.0))]
    Cameras(Vec<Cause>),
    /// Cameras that see nothing in common, however their pictures are read.
    #[error(
        "the cameras do not see one scene: even the outlines of {}, which agree best, miss each other by {:.0} cm; is the calibration that of these recordings, and its rotations in radians?",
        listed(cameras), 100.0 * miss_m
    )]
    NoneAgree {
        /// Those that miss each other least.
        cameras: Vec<String>,
        /// By how much, m.
        miss_m: f64,
    },
    /// Nobody is so tall.
    #[error(
        "masks or points show something {seen_m:.3} m large, the body {body} is {body_m:.2} m: check unit in sequence.toml (m or mm), and the body"
    )]
    Size {
        /// Size of what is seen, m.
        seen_m: f64,
        /// Name of the body.
        body: String,
        /// Its size, m.
        body_m: f64,
    },
    /// The body has not what was asked to be compared.
    #[error("the body {model} has no {lacking}: choose another body or another --likelihood")]
    Primitives {
        /// Name of the body.
        model: String,
        /// What it lacks.
        lacking: &'static str,
    },
    /// Points alone, to be compared with ellipses.
    #[error(
        "points can only be compared with the skin of metaballs: leave --likelihood out, or use metaballs"
    )]
    PointsOnEllipses,
    /// No hypothesis could be followed through the sequence.
    #[error("no hypothesis could be followed through the {frames} frames{}", because(causes))]
    NoHypothesis {
        /// How many frames there are.
        frames: usize,
        /// What is wrong with the recording, if that is known.
        causes: Vec<Cause>,
    },
}

/// What is wrong, or where to look.
fn because(causes: &[Cause]) -> String {
    match causes.is_empty() {
        true => ": look at the masks, and check `up` and the calibration".to_owned(),
        false => format!(": {}", joined(causes)),
    }
}

fn listed(cameras: &[String]) -> String {
    let word = if cameras.len() == 1 { "camera" } else { "cameras" };
    format!("{word} {}", cameras.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_that_found_nothing_says_what_is_wrong_or_where_to_look() {
        let told = |causes| FitError::NoHypothesis { frames: 126, causes }.to_string();
        assert!(told(vec![Cause::ThinPartsGone]).contains("thin parts"));
        assert!(
            told(Vec::new()).ends_with("look at the masks, and check `up` and the calibration")
        );
    }
}
