//! The masks of one frame.

use rayon::prelude::*;

use super::SegmentOptions;
use super::figures::{Figures, Told};
use super::view::SegmentedView;
use crate::camera::CameraId;
use crate::image::{
    Mask, Picture, Plane, Region, Runs, box_mean, clean, enlarge, relax, sharpen, shrink,
};
use crate::silhouette::{FrameIndex, ShrunkSize, Support};

/// Below this evidence a pixel does not tell by itself what it shows.
const UNDECIDED: f32 = 1.0;
/// A picture of which more than this share differs from the empty scene shows another light, or moved; nobody is so large.
const LARGEST_CHANGE: f64 = 0.5;
/// Pixels around what may be the person, in which neighbours are looked at.
const MARGIN: usize = 6;

/// What was learned of a recording, ready to segment its frames.
#[derive(Clone, Debug)]
pub struct Segmenter {
    pub(super) views: Vec<SegmentedView>,
    pub(super) support: Option<Support>,
    pub(super) shrunk: Vec<ShrunkSize>,
    pub(super) figures: Figures,
    pub(super) options: SegmentOptions,
}

/// The person in one picture.
#[derive(Clone, Debug)]
pub struct Cut {
    /// Where the person is.
    pub mask: Mask,
    /// Whose each of its pixels is, from 1 on, and 0 elsewhere, where detections show several people.
    pub labels: Option<Plane<u8>>,
    /// How probable it is that a pixel shows the person, of each pixel.
    pub probability: Plane<f32>,
    /// How good the mask is likely to be.
    pub quality: CutQuality,
}

/// Figures of a mask that tell a good one from a bad one without the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutQuality {
    /// Pixels of the mask.
    pub area_px: usize,
    /// Connected pieces of it.
    pub pieces: usize,
    /// Whether it reaches the edge of the picture.
    pub touches_edge: bool,
    /// Share of its pixels whose own colour does not decide: neighbours and other cameras did.
    pub undecided: f64,
    /// Pixels that this camera alone takes for the person and the others do not support, over the mask's.
    pub unsupported: f64,
    /// Share of its pixels that this camera alone takes for background.
    pub filled_in: f64,
}

/// Of each camera that has a picture.
struct Evidence {
    own: Vec<Option<Plane<f32>>>,
    together: Vec<Option<Plane<f32>>>,
    support: Vec<Option<Plane<f32>>>,
    told: Vec<Option<Told>>,
}

/// Of each camera that has a picture.
pub(super) struct KeyMasks {
    pub(super) masks: Vec<Option<Plane<u8>>>,
    pub(super) support: Vec<Option<Plane<f32>>>,
    pub(super) told: Vec<Option<Told>>,
}

impl Segmenter {
    /// Whether the cameras agree on where the person is, so that they help each other.
    pub fn is_consistent(&self) -> bool {
        self.support.is_some()
    }

    /// For each camera the share of the person's pixels, over all frames, whose background was never seen for sure.
    pub(super) fn unseen_background(&self) -> Vec<f64> {
        let share = |view: &SegmentedView| {
            let trusts = || view.background.values().iter().map(|e| e.trust);
            let doubtful = trusts().filter(|trust| *trust < 0.5).count();
            let near = trusts().filter(|trust| *trust < 1.0).count();
            doubtful as f64 / near.max(1) as f64
        };
        self.views.iter().map(share).collect()
    }

    /// The person in each picture of a frame; `None` for a camera without a picture, and for a picture most of which is
    /// other than the empty scene.
    pub fn segment(&self, frame: FrameIndex, pictures: &[Option<Picture>]) -> Vec<Option<Cut>> {
        let small: Vec<Option<Picture>> = pictures
            .par_iter()
            .zip(&self.shrunk)
            .map(|(picture, shrunk)| Some(shrink(picture.as_ref()?, shrunk.factor)))
            .collect();
        let Evidence { own, together, told, .. } = self.evidence(frame, &small);

        let cut = |c: usize| {
            let (full, picture) = (pictures[c].as_ref()?, small[c].as_ref()?);
            let (own, together) = (own[c].as_ref()?, together[c].as_ref()?);

            // labels of the shrunk picture, then the border in the whole one
            let labels = self.labels(together, picture);
            let shrunk = &self.shrunk[c];
            let probability = enlarge(&labels, shrunk.factor, full.width(), full.height());
            let runs = Runs::from_mask(&Mask::brighter_than(&probability, 0.5));
            let coarse = clean(&runs, &self.options.clean).mask();
            let mask = sharpen(&coarse, full, &self.options.border.scaled(shrunk.factor));

            let runs = Runs::from_mask(&mask);
            let several = told[c].as_ref().filter(|_| self.figures.people() > 1);
            Some(Cut {
                quality: quality(&runs, own, together, shrunk.factor),
                labels: several.map(|told| told.labels(&mask, shrunk.factor)),
                mask,
                probability,
            })
        };
        (0..small.len()).into_par_iter().map(cut).collect()
    }

    /// The masks of a key frame, of its shrunk pictures, and what the other cameras say.
    pub(super) fn key_masks(&self, frame: FrameIndex, pictures: &[Option<Picture>]) -> KeyMasks {
        let Evidence { together, support, told, .. } = self.evidence(frame, pictures);
        let mask = |((evidence, picture), told): ((&Option<_>, &Option<_>), &Option<Told>)| {
            let labels = self.labels(evidence.as_ref()?, picture.as_ref()?);
            let runs = Runs::from_mask(&Mask::brighter_than(&labels, 0.5));
            let mut mask = painted(&clean(&runs, &self.options.clean));
            told.iter().for_each(|told| told.add_bones(&mut mask));
            Some(mask)
        };
        let views = together.par_iter().zip(pictures).zip(&told);
        KeyMasks { masks: views.map(mask).collect(), support, told }
    }

    /// Each camera's own evidence, and that with the support of the others.
    fn evidence(&self, frame: FrameIndex, small: &[Option<Picture>]) -> Evidence {
        let own: Vec<Option<Plane<f32>>> = small
            .par_iter()
            .zip(&self.views)
            .map(|(picture, view)| Some(view.evidence(picture.as_ref()?, &self.options)))
            .map(|own| own.filter(|own| !is_another_scene(own)))
            .collect();
        let told: Vec<Option<Told>> = (self.shrunk.par_iter().enumerate())
            .map(|(c, shrunk)| self.figures.told(frame, CameraId(c), shrunk))
            .collect();

        // what the other cameras say, and what is told
        let others = match &self.support {
            Some(support) => support.by_others(&own),
            None => vec![None; own.len()],
        };
        let support: Vec<Option<Plane<f32>>> = (others.into_par_iter().zip(&told))
            .map(|(others, told)| match told {
                Some(told) => Some(told.over(others)),
                None => others,
            })
            .collect();

        let count = own.iter().flatten().count().saturating_sub(1);
        let together: Vec<Option<Plane<f32>>> = (support.par_iter().zip(&own).zip(&self.views))
            .map(|((support, own), view)| match (own, support) {
                (Some(own), Some(support)) => {
                    Some(view.supported(own, support, count, &self.options))
                }
                (own, _) => own.clone(),
            })
            .collect();
        Evidence { own, together, support, told }
    }

    /// The labels, found within the box about what may be the person; background elsewhere.
    fn labels(&self, evidence: &Plane<f32>, picture: &Picture) -> Plane<f32> {
        let mut labels = Plane::filled(evidence.width(), evidence.height(), 0.0);
        let likely = Mask::brighter_than(&box_mean(evidence, 1), 0.0);
        let Some(region) = Runs::from_mask(&likely).region() else {
            return labels;
        };
        let region = region.grown(MARGIN, evidence.width(), evidence.height());
        let inner =
            relax(&evidence.cropped(&region), &picture.cropped(&region), &self.options.relax);
        for y in region.top..region.bottom {
            labels.row_mut(y)[region.left..region.right].copy_from_slice(inner.row(y - region.top));
        }
        labels
    }
}

/// Whether the light, the exposure or the camera changed, and not a person came.
fn is_another_scene(own: &Plane<f32>) -> bool {
    let changed = own.values().iter().filter(|l| **l > 0.0).count();
    changed as f64 > LARGEST_CHANGE * own.values().len() as f64
}

fn painted(runs: &Runs) -> Plane<u8> {
    let whole = Region { left: 0, top: 0, right: runs.width(), bottom: runs.height() };
    runs.painted(&whole, 0)
}

fn quality(runs: &Runs, own: &Plane<f32>, together: &Plane<f32>, factor: usize) -> CutQuality {
    let (components, _) = runs.components(crate::image::Connectivity::Eight);
    let mask = painted(runs);

    // pixels of the mask where the evidence is, one for each shrunk pixel
    let (mut area, mut undecided, mut filled, mut unsupported) = (0.0, 0.0, 0.0, 0.0);
    for y in 0..own.height() {
        for (x, (own, together)) in own.row(y).iter().zip(together.row(y)).enumerate() {
            let is_person = mask.get(x * factor + factor / 2, y * factor + factor / 2) == Some(1);
            area += f64::from(u8::from(is_person));
            undecided += f64::from(u8::from(is_person && own.abs() < UNDECIDED));
            filled += f64::from(u8::from(is_person && *own < -UNDECIDED));
            unsupported += f64::from(u8::from(!is_person && *own > UNDECIDED && *together < 0.0));
        }
    }

    let share = |count: f64| if area > 0.0 { count / area } else { 0.0 };
    CutQuality {
        area_px: runs.area(),
        pieces: components.len(),
        touches_edge: components.iter().any(|c| c.touches_image_edge),
        undecided: share(undecided),
        unsupported: share(unsupported),
        filled_in: share(filled),
    }
}
