//! A person who walks before cameras, and a short search for them.

use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::camera::Rig;
use maquette::inference::Sequence;
use maquette::inference::search::{NoJournal, SearchOptions};
use maquette::inference::start::StartOptions;
use maquette::pipeline::{EstimateOptions, Fit, fit};
use maquette::silhouette::FrameObservations;
use maquette::synth::draw_shape;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::ellipsoid_person::{human, observe, walk};

pub(crate) const FPS: f64 = 25.0;

/// A walker, and where the cameras are taken to be.
pub(crate) struct Walker {
    pub(crate) model: BodyModel,
    pub(crate) rig: Rig,
    shape: Shape,
    motions: Vec<Motion>,
}

impl Walker {
    pub(crate) fn new(rig: Rig, moments: usize) -> Self {
        let model = human();
        let shape = draw_shape(&model, &mut ChaCha8Rng::seed_from_u64(70));
        let motions = walk(&model, &shape, FPS, moments);
        Self { model, rig, shape, motions }
    }

    /// What a rig sees of a moment, with the number of a frame.
    pub(crate) fn seen_by(&self, rig: &Rig, moment: usize, number: usize) -> FrameObservations {
        observe(&self.posed(moment), rig, number)
    }

    pub(crate) fn fitted(&self, frames: &[FrameObservations], keyframe_every: usize) -> Fit {
        let search = SearchOptions {
            keyframe_every: Some(keyframe_every),
            start: StartOptions { headings: 4, iterations: 6, kept: 2 },
            ..SearchOptions::default()
        };
        let options = EstimateOptions { search, ..EstimateOptions::default() };
        let sequence = Sequence { frames, fps: FPS };
        fit(&self.model, &self.rig, sequence, &options, &NoJournal).expect("a fit")
    }

    /// Mean distance of all points from the truth, mm, of a fit whose first frame shows this moment.
    pub(crate) fn error_mm(&self, fit: &Fit, first: usize) -> f64 {
        let of_frame = |i: usize| {
            let truth = self.posed(first + i).points();
            let found = &fit.frames[i].points_world;
            let each = truth.iter().zip(found).map(|(a, b)| 1e3 * (a - b).norm());
            each.sum::<f64>() / truth.len() as f64
        };
        (0..fit.frames.len()).map(of_frame).sum::<f64>() / fit.frames.len() as f64
    }

    fn posed(&self, moment: usize) -> Posed<'_> {
        Posed::new(&self.model, &self.shape, &self.motions[moment])
    }
}
