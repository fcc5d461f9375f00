use super::*;
use std::path::Path;

use crate::inference::search::NoJournal;
use crate::io::model;
use crate::pipeline::fit;
use crate::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
use crate::synth::{Recipe, Ring, Synthetic};

/// A few frames of a person's trial before three cameras.
fn walk(seed: u64, trial: u64) -> (Synthetic, Vec<FrameObservations>) {
    let ring = Ring { cameras: 4, ..Ring::default() };
    let recipe = Recipe { seed, trial, frames: Some(4), fps: 10.0, ring, ..Recipe::default() };
    let walker = model::load("walker-ellipsoids", Path::new(""));
    let walker = walker.or_else(|_| model::load("walker-metaballs", Path::new(""))).unwrap();
    let truth = recipe.walker(&walker).unwrap();
    let observed = (0..truth.frames()).map(|i| {
        let mut seen = FrameObservations::nothing(FrameIndex(i));
        for (id, camera) in truth.rig.iter() {
            let mask = truth.mask(FrameIndex(i), id).unwrap();
            let silhouette = extract(&mask, camera, &SilhouetteOptions::default());
            seen.views.push((id, silhouette.unwrap()));
        }
        seen
    });
    let observed = observed.collect();
    (truth, observed)
}

/// The fit of a trial alone.
fn alone(found: &Fit) -> AloneFit {
    AloneFit {
        shape: found.shape.clone(),
        covariance: found.uncertainty.as_ref().map(|u| u.covariance.clone()),
        motions: found.frames.iter().map(|frame| frame.fit.motion.clone()).collect(),
        recovered: vec![false; found.frames.len()],
        cameras: found.cameras.iter().map(|camera| camera.found).collect(),
        confidence: found.confidence.clone(),
    }
}

#[test]
fn two_trials_have_one_body_that_is_surer_and_one_pose_of_each_camera() {
    let body = model::load("human-ellipsoids", Path::new("")).unwrap();
    let options = EstimateOptions::default();
    let walks = [walk(3, 0), walk(3, 1)];
    assert_eq!(walks[0].0.shape, walks[1].0.shape);
    let trials: Vec<SessionTrial<'_>> = walks
        .iter()
        .map(|(truth, observed)| {
            let sequence = Sequence { frames: observed, fps: truth.fps };
            let found = fit(&body, &truth.rig, sequence, &options, &NoJournal).unwrap();
            let (rig, options) = (&truth.rig, &options);
            SessionTrial { name: "walk", rig, sequence, options, alone: alone(&found) }
        })
        .collect();

    let session = fit_session(&body, &trials, &NoProgress).unwrap();
    let [first, second] = session.fits.as_slice() else { panic!("two trials") };
    assert!(session.other_calibrations.is_empty());
    assert_eq!((&first.shape, &first.lengths_m), (&second.shape, &second.lengths_m));
    assert_eq!((first.frames.len(), second.frames.len()), (4, 4));
    for (a, b) in first.cameras.iter().zip(&second.cameras) {
        let pose = |camera: &crate::pipeline::CameraQuality| camera.found.pose.map(|p| p.turn_deg);
        assert_eq!(pose(a), pose(b));
    }

    // with twice as much seen, each length is surer than alone, and the trial's place is its own
    let sd = |fit: &Fit| fit.uncertainty.clone().unwrap().lengths_sd_m;
    let alone_sd: Vec<f64> = trials[0]
        .alone
        .covariance
        .as_ref()
        .map(|covariance| {
            let slopes = crate::inference::covariance::lengths_slopes(
                &body.detailed(),
                &trials[0].alone.shape,
            );
            (&slopes * covariance * slopes.transpose())
                .diagonal()
                .map(f64::sqrt)
                .as_slice()
                .to_vec()
        })
        .unwrap();
    let mean = |sd: &[f64]| sd.iter().sum::<f64>() / sd.len() as f64;
    assert!(mean(&sd(first)) < mean(&alone_sd), "{:?} {alone_sd:?}", sd(first));
    let place = |fit: &Fit| fit.frames[0].fit.motion.position_world;
    assert!((place(first) - walks[0].0.motions[0].position_world).norm() < 0.1);
    assert!((place(second) - walks[1].0.motions[0].position_world).norm() < 0.1);
}

#[test]
fn a_camera_of_another_calibration_is_named_and_its_pose_is_its_own() {
    let (truth, observed) = walk(3, 0);
    let mut moved = truth.rig.clone();
    moved.cameras[1].camera_from_world.translation.vector.x += 0.01;
    let none = AloneFit {
        shape: Shape(DVector::zeros(0)),
        covariance: None,
        motions: Vec::new(),
        recovered: Vec::new(),
        cameras: Vec::new(),
        confidence: ShapeConfidence::from_trials(
            &truth.model,
            &[],
            &truth.shape,
            &truth.model.rest_lengths_m(&truth.shape),
            &Default::default(),
        ),
    };
    let options = EstimateOptions::default();
    let sequence = Sequence { frames: &observed, fps: 10.0 };
    let trial =
        |name, rig| SessionTrial { name, rig, sequence, options: &options, alone: none.clone() };
    let trials = [trial("a", &truth.rig), trial("b", &truth.rig), trial("c", &moved)];
    let shared = SharedRig::new(&trials);
    let same: Vec<Option<usize>> = (0..4).map(Some).collect();
    assert_eq!(shared.same[4..8], same);
    assert_eq!(shared.same[8..], [Some(0), None, Some(2), Some(3)]);
    let line = shared.others[0].to_string();
    let name = &truth.rig.cameras[1].name;
    assert!(line.contains(&format!("trial c has another one of {name} than trial a")), "{line}");
}
