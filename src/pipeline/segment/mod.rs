//! From pictures of several cameras to masks of the one person whom all of them see.
//!
//! 1. [`Training`]: every pixel learns an adaptive mixture of Gaussians, of pictures of the empty scene where there are
//!    some, else of the recording itself.
//! 2. [`Training::learn`]: on some key frames, in turn, until they agree:
//!    - which mode of each pixel is the empty scene: that which is there most, and whose colour is rather that of the
//!      surroundings than the person's;
//!    - evidence of each pixel, ln p(x | person) − ln p(x | empty), with p(x | person) the colours of the masks so far;
//!    - support of each pixel by the other cameras along its line of sight ([`Support`]);
//!    - masks: evidence and support, made to hold together ([`relax`]), specks and small holes removed.
//! 3. [`Segmenter::segment`]: the same for every frame, with what was learned; then the border by how much of each of
//!    its pixels is covered ([`sharpen`]).
//!
//! [`segment`] does all of this with the pictures of a recording.
//!
//! Where the person is nothing has to say: it is whoever moves in the volume that all cameras see. Detections of their joints may say it
//! (`figures.rs`), and who of several is where.
//!
//! [`Support`]: crate::silhouette::Support
//! [`relax`]: crate::image::relax
//! [`sharpen`]: crate::image::sharpen

mod cut;
mod figures;
mod learn;
mod notes;
mod sequence;
mod subject;
mod train;
mod view;

pub use cut::{Cut, CutQuality, Segmenter};
pub use sequence::{MaskQuality, Segmented, SegmentedFrame, segment};
pub use train::Training;

use crate::image::{BorderOptions, CleanOptions, RelaxOptions, ShadowOptions};
use crate::silhouette::SupportOptions;

/// Settings of the segmentation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentOptions {
    /// Pictures of more pixels are shrunk by a whole factor (default 700 000).
    pub most_px: usize,
    /// Frames that are learned from, evenly spaced (default 16).
    pub key_frames: usize,
    /// How often masks and what is learned of them take turns (default 5).
    pub rounds: usize,
    /// No more pictures of a camera than these teach its background, evenly spaced (default 200).
    pub training_pictures: usize,
    /// Evidence of one pixel counts at most so much, either way (default 8).
    pub most_evidence: f32,
    /// What it counts that no other camera sees the person along a line of sight (default 10, more than a pixel's own
    /// evidence; half with two cameras only).
    pub against_weight: f32,
    /// What it counts that all others do (default 1: their lines of sight enclose more than the person).
    pub allowed_weight: f32,
    /// The same where the empty scene is not known (default 6).
    pub unknown_weight: f32,
    /// How sure the most frequent colour of a pixel is the empty scene's before colours are looked at, as a logarithm
    /// of odds (default 3).
    pub background_odds: f32,
    /// Shadows.
    pub shadow: ShadowOptions,
    /// Neighbouring pixels.
    pub relax: RelaxOptions,
    /// Other cameras.
    pub support: SupportOptions,
    /// Specks and holes.
    pub clean: CleanOptions,
    /// Pixels on the border.
    pub border: BorderOptions,
}

impl Default for SegmentOptions {
    fn default() -> Self {
        Self {
            most_px: 700_000,
            key_frames: 16,
            rounds: 5,
            training_pictures: 200,

            // weights of a pixel's evidence
            most_evidence: 8.0,
            against_weight: 10.0,
            allowed_weight: 1.0,
            unknown_weight: 6.0,
            background_odds: 3.0,

            shadow: ShadowOptions::default(),
            relax: RelaxOptions::default(),
            support: SupportOptions::default(),
            clean: CleanOptions { part_fraction: 0.1, ..CleanOptions::default() },
            border: BorderOptions::default(),
        }
    }
}
