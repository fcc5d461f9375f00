//! Which parts nothing sees: their angles are as uncertain as the priors alone leave them.
//!
//! The priors alone are p(m) and p(mᵢ | mᵢ₋₁, …), linearised at the same motions; their H is the same chain without data.

use nalgebra::DVector;

use super::{FittedFrame, Warning};
use crate::body::{BodyModel, Layout, Motion};
use crate::inference::motion_prior::MotionPrior;

/// An angle whose standard deviation is at least this share of what the priors leave has learnt nothing from the data.
const UNTOUCHED: f64 = 0.9;

/// Standard deviations of every frame's angles if nothing were seen, rad; `None` where the priors leave them free.
///
/// `seconds[i]` lie between frames i − 1 and i.
pub fn prior_angles_sd(
    model: &BodyModel,
    motion_prior: &MotionPrior,
    motions: &[Motion],
    seconds: &[f64],
) -> Option<Vec<DVector<f64>>> {
    let layout = Layout::new(model);
    let (m, root) = (layout.motion(), layout.root());

    let chain = motion_prior.alone(motions, seconds);
    let mut all = Vec::with_capacity(motions.len());
    let complete = chain.marginals(|_, marginal| {
        let variances = marginal.frame.diagonal().rows(root, m - root).into_owned();
        all.push(variances.map(f64::sqrt));
    });
    all.reverse();
    complete.then_some(all)
}

/// The parts all of whose own angles keep their prior in most of the frames that anything sees.
pub(super) fn warning(
    model: &BodyModel,
    frames: &[FittedFrame],
    prior: &[DVector<f64>],
) -> Option<Warning> {
    let seen: Vec<(&DVector<f64>, &DVector<f64>)> = frames
        .iter()
        .zip(prior)
        .filter(|(f, _)| f.is_observed())
        .filter_map(|(f, prior)| Some((&f.uncertainty.as_ref()?.angles_sd, prior)))
        .collect();

    let keeps = |part: usize| {
        let own = own_joints(model, part);
        let untouched = |(sd, prior): &&(&DVector<f64>, &DVector<f64>)| {
            own.iter().all(|j| sd[*j] >= UNTOUCHED * prior[*j])
        };
        !own.is_empty() && 2 * seen.iter().filter(untouched).count() > seen.len()
    };
    let parts: Vec<String> = (0..model.parts.len())
        .filter(|part| keeps(*part))
        .map(|part| model.parts[part].name.clone())
        .collect();
    (!parts.is_empty()).then_some(Warning::KeepsPrior { parts })
}

/// The joints between a part and the part that it hangs on.
pub(super) fn own_joints(model: &BodyModel, part: usize) -> Vec<usize> {
    let last = model.parts[part].joint;
    let is_other = |joint| {
        let mut others = model.parts.iter().filter(|p| p.joint != last);
        others.any(|p| p.joint == Some(joint))
    };
    let chain = model.chain(last).into_iter().rev();
    chain.take_while(|joint| !is_other(*joint)).map(|joint| joint.0).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Vector3;

    use super::*;
    use crate::inference::covariance::FrameUncertainty;
    use crate::inference::frame::FrameFit;
    use crate::pipeline::PointQuality;
    use crate::silhouette::FrameIndex;

    const SEEN: Option<PointQuality> = Some(PointQuality {
        frame: FrameIndex(0),
        points: 1,
        outside: 0.0,
        outside_m: None,
        off_skin_m: None,
    });

    /// What a frame shows, and how uncertain its angles are.
    type Case = ([f64; 4], Option<PointQuality>);

    fn frame(model: &BodyModel, (angles_sd, points): &Case) -> FittedFrame {
        FittedFrame {
            frame: FrameIndex(0),
            fit: FrameFit {
                motion: Motion::rest(model),
                data: 0.0,
                pose: 0.0,
                step: 0.0,
                observations: 0.0,
                recovered: false,
            },
            uncertainty: Some(FrameUncertainty {
                position_sd_m: Vector3::zeros(),
                parts_sd: Vec::new(),
                angles_sd: DVector::from_row_slice(angles_sd),
                points: Vec::new(),
                apart: Vec::new(),
            }),
            points_world: Vec::new(),
            views: Vec::new(),
            points: *points,
            detections: Vec::new(),
        }
    }

    fn said(frames: &[Case]) -> Option<String> {
        let model = crate::io::model::load("arm", Path::new("")).unwrap();
        let fitted: Vec<FittedFrame> = frames.iter().map(|case| frame(&model, case)).collect();
        let prior = vec![DVector::repeat(4, 0.5); frames.len()];
        Some(warning(&model, &fitted, &prior)?.to_string())
    }

    #[test]
    fn a_part_whose_angles_keep_their_prior_in_most_frames_is_named() {
        let (blind, sure) = ([0.1, 0.1, 0.1, 0.48], [0.1; 4]);
        let forearm = "forearm: no camera shows how it is turned, so it keeps its prior";
        let frames = [(blind, SEEN), (blind, SEEN), (sure, SEEN)];
        assert_eq!(said(&frames).unwrap(), forearm);
        assert_eq!(said(&[(blind, SEEN), (sure, SEEN), (sure, SEEN)]), None);
        let all = [0.5; 4];
        assert_eq!(
            said(&[(all, SEEN)]).unwrap(),
            "upper_arm, forearm: no camera shows how they are turned, so they keep their priors"
        );
    }

    #[test]
    fn one_angle_of_three_that_is_unseen_is_no_part() {
        assert_eq!(said(&[([0.1, 0.1, 0.5, 0.1], SEEN)]), None);
    }

    #[test]
    fn frames_in_which_nothing_is_seen_at_all_do_not_count() {
        assert_eq!(said(&[([0.5; 4], None), ([0.1; 4], SEEN)]), None);
        assert_eq!(said(&[([0.5; 4], None)]), None);
    }
}
