//! Two trials of one person, fitted alone and with one body.

use std::path::Path;

use maquette::inference::Sequence;
use maquette::inference::covariance::lengths_slopes;
use maquette::inference::search::NoJournal;
use maquette::io::model;
use maquette::pipeline::{
    CameraQuality, EstimateOptions, Fit, NoProgress, SessionTrial, fit, fit_session,
};
use maquette::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
use maquette::synth::{Recipe, Ring, Synthetic};

/// A few frames of a person's trial before three cameras.
fn walk(seed: u64, trial: u64) -> (Synthetic, Vec<FrameObservations>) {
    let ring = Ring { cameras: 4, ..Ring::default() };
    let recipe = Recipe { seed, trial, frames: Some(4), fps: 10.0, ring, ..Recipe::default() };
    let walker = model::load("walker-metaballs", Path::new("")).expect("a shipped model");
    let truth = recipe.walker(&walker).expect("it is there");
    let observed = (0..truth.frames()).map(|i| {
        let mut seen = FrameObservations::nothing(FrameIndex(i));
        for (id, camera) in truth.rig.iter() {
            let mask = truth.mask(FrameIndex(i), id).expect("it is there");
            let silhouette = extract(&mask, camera, &SilhouetteOptions::default());
            seen.views.push((id, silhouette.expect("it is there")));
        }
        seen
    });
    let observed = observed.collect();
    (truth, observed)
}

#[test]
fn two_trials_have_one_body_that_is_surer_and_one_pose_of_each_camera() {
    let body = model::load("human-ellipsoids", Path::new("")).expect("it is there");
    let options = EstimateOptions::default();
    let walks = [walk(3, 0), walk(3, 1)];
    assert_eq!(walks[0].0.shape, walks[1].0.shape);
    let trials: Vec<SessionTrial<'_>> = walks
        .iter()
        .map(|(truth, observed)| {
            let sequence = Sequence { frames: observed, fps: truth.fps };
            let found =
                fit(&body, &truth.rig, sequence, &options, &NoJournal).expect("it is there");
            let (rig, options) = (&truth.rig, &options);
            SessionTrial { name: "walk", rig, sequence, options, alone: (&found).into() }
        })
        .collect();

    let session = fit_session(&body, &trials, &NoProgress).expect("it is there");
    let [first, second] = session.fits.as_slice() else { panic!("two trials") };
    assert!(session.other_calibrations.is_empty());
    assert_eq!((&first.shape, &first.lengths_m), (&second.shape, &second.lengths_m));
    assert_eq!((first.frames.len(), second.frames.len()), (4, 4));
    for (a, b) in first.cameras.iter().zip(&second.cameras) {
        let pose = |camera: &CameraQuality| camera.found.pose.map(|p| p.turn_deg);
        assert_eq!(pose(a), pose(b));
    }

    // the keyframes of all are hypotheses of the one body
    let of_each = trials.iter().map(|trial| trial.alone.keyframes.len());
    assert_eq!(first.confidence.keyframes(), of_each.sum::<usize>());
    assert_eq!(first.confidence, second.confidence);

    // with twice as much seen, each length is surer than alone, and the trial's place is its own
    let sd = |fit: &Fit| fit.uncertainty.clone().expect("it is there").lengths_sd_m;
    let alone_sd: Vec<f64> = trials[0]
        .alone
        .covariance
        .as_ref()
        .map(|covariance| {
            let slopes = lengths_slopes(&body.detailed(), &trials[0].alone.shape);
            (&slopes * covariance * slopes.transpose())
                .diagonal()
                .map(f64::sqrt)
                .as_slice()
                .to_vec()
        })
        .expect("it is there");
    let mean = |sd: &[f64]| sd.iter().sum::<f64>() / sd.len() as f64;
    assert!(mean(&sd(first)) < mean(&alone_sd), "{:?} {alone_sd:?}", sd(first));
    let place = |fit: &Fit| fit.frames[0].fit.motion.position_world;
    assert!((place(first) - walks[0].0.motions[0].position_world).norm() < 0.1);
    assert!((place(second) - walks[1].0.motions[0].position_world).norm() < 0.1);
}
