//! What silhouettes alone leave open: which way a person faces, and which limb is left.

use nalgebra::Vector2;

use super::Warning;
use super::diagnosis::stature_m;
use super::fitted::{FittedFrame, TriedHypothesis};
use super::hidden::hidden_warning;
use crate::body::{BodyModel, Motion, Root, Shape};
use crate::camera::Rig;
use crate::inference::Evidence;
use crate::inference::facing::trial_faces_away;
use crate::silhouette::FrameObservations;

/// Log odds below which the other way of facing is worth a word: a thousand to one.
const CERTAIN: f64 = 6.9;
/// Lines of sight nearer to one line than this show one outline, degrees.
const ONE_LINE_DEG: f64 = 25.0;

/// Says so if the person may face the other way: the best hypothesis that faces there is nearly as probable as the winner, or
/// there was none.
pub(super) fn facing_warning(
    evidence: &Evidence<'_>,
    hypotheses: &[TriedHypothesis],
    winner: usize,
    data_weight: f64,
) -> Option<Warning> {
    if evidence.model.root == Root::Fixed {
        return None;
    }
    match facing_log_odds(hypotheses, winner, data_weight) {
        None => Some(Warning::FacingUntried),
        Some(log_odds) => {
            (log_odds < CERTAIN).then(|| Warning::Facing { odds: log_odds.max(0.0).exp() })
        }
    }
}

/// Log odds of the winner against the best hypothesis that faces the other way; `None` if there was none.
///
/// `data_weight` is what the recording's own noise leaves of the residuals' stated weight. A hypothesis that was dropped on its
/// way costs as much in the frames that it was spared as in those that it was followed through.
fn facing_log_odds(hypotheses: &[TriedHypothesis], winner: usize, data_weight: f64) -> Option<f64> {
    let won = &hypotheses[winner].trial;
    let energy = |tried: &TriedHypothesis| {
        let followed = tried.fitted.max(1) as f64 / tried.trial.frames.len().max(1) as f64;
        tried.trial.energy() / followed
    };

    let away = hypotheses.iter().filter(|other| trial_faces_away(won, &other.trial)).map(energy);
    Some(data_weight * (away.reduce(f64::min)? - won.energy()))
}

/// Says how tall the body is if nobody said how tall the person is: cameras and person may both be larger.
pub(super) fn scale_warning(
    model: &BodyModel,
    shape: &Shape,
    height_m: Option<f64>,
) -> Option<Warning> {
    let is_unchecked = model.root != Root::Fixed && height_m.is_none();
    is_unchecked.then(|| Warning::ScaleUnchecked { found_m: stature_m(model, shape) })
}

/// What few outlines leave open: that there is but one, and limbs that are hidden in most of them.
pub(super) fn outline_warnings(
    evidence: &Evidence<'_>,
    frames: &[FrameObservations],
    shape: &Shape,
    fitted: &[FittedFrame],
) -> impl Iterator<Item = Warning> {
    let motions: Vec<&Motion> = fitted.iter().map(|frame| &frame.fit.motion).collect();
    let hidden = hidden_warning(evidence, frames, shape, &motions);
    one_outline_warning(evidence.rig, frames).into_iter().chain(hidden)
}

/// Says so if all cameras that see the person look along one line, from one end or from both: they show one outline, and what
/// is left in it may be right. Points and detections tell.
fn one_outline_warning(rig: &Rig, frames: &[FrameObservations]) -> Option<Warning> {
    let tells =
        |frame: &FrameObservations| !(frame.points.is_empty() && frame.detections.is_empty());
    let has_more = frames.iter().any(tells);
    let sees = |id: usize| frames.iter().any(|f| f.views.iter().any(|(c, _)| c.0 == id));
    // seen from above
    let axes = (0..rig.cameras.len()).filter(|id| sees(*id));
    let axes = axes.map(|id| rig.cameras[id].optical_axis().direction_world.xy());
    let axes: Vec<Vector2<f64>> = axes.filter_map(|axis| axis.try_normalize(1e-3)).collect();

    let first = axes.first()?;
    let along = ONE_LINE_DEG.to_radians().cos();
    let is_one_line = axes.iter().all(|axis| first.dot(axis).abs() > along);
    (axes.len() >= 2 && is_one_line && !has_more).then_some(Warning::OneOutline)
}

#[cfg(test)]
pub(super) mod tests {
    use std::f64::consts::PI;
    use std::path::Path;

    use super::*;
    use crate::camera::CameraId;
    use crate::image::Mask;
    use crate::inference::frame::FrameFit;
    use crate::inference::search::{Hypothesis, Origin, Trial};
    use crate::likelihood::{LikelihoodOptions, Measure};
    use crate::math::Rigid3;
    use crate::silhouette::{FrameIndex, SilhouetteOptions, extract};
    use crate::synth::Ring;
    use nalgebra::Vector3;

    /// Cameras that look at the world's origin from these headings, and a frame in which all show something.
    pub(in crate::pipeline) fn before_cameras(headings_deg: &[f64]) -> (Rig, FrameObservations) {
        let mut rig = Ring::default().regular();
        let first = rig.cameras[0].clone();
        let headed = |deg: &f64| {
            let mut camera = first.clone();
            camera.camera_from_world *= Rigid3::rotation(Vector3::z() * deg.to_radians());
            camera
        };
        rig.cameras = headings_deg.iter().map(headed).collect();

        let (w, h) = (first.width_px as usize, first.height_px as usize);
        let mask = Mask::from_fn(w, h, |x, y| x > w / 3 && x < w / 2 && y > h / 3 && y < h / 2);
        let silhouette = extract(&mask, &first, &SilhouetteOptions::default()).unwrap();
        let mut frame = FrameObservations::nothing(FrameIndex(0));
        frame.views = (0..rig.cameras.len()).map(|i| (CameraId(i), silhouette.clone())).collect();
        (rig, frame)
    }

    fn warning(headings_deg: &[f64]) -> Option<Warning> {
        let (rig, frame) = before_cameras(headings_deg);
        one_outline_warning(&rig, &[frame])
    }

    #[test]
    fn cameras_on_one_line_show_one_outline_and_others_do_not() {
        assert_eq!(warning(&[0.0, 180.0]), Some(Warning::OneOutline));
        assert_eq!(warning(&[0.0, 10.0, 190.0]), Some(Warning::OneOutline));
        assert_eq!(warning(&[0.0, 90.0]), None);
        assert_eq!(warning(&[0.0, 180.0, 60.0]), None);
        assert_eq!(warning(&[0.0]), None);
    }

    /// A hypothesis of four frames, `fitted` of them followed at this cost each, whose person faces this way.
    fn facing(model: &BodyModel, heading: f64, fitted: usize, cost: f64) -> TriedHypothesis {
        let mut motion = Motion::rest(model);
        motion.world_from_root = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), heading);
        let fit = FrameFit {
            motion: motion.clone(),
            data: cost,
            pose: 0.0,
            step: 0.0,
            observations: 1.0,
            recovered: false,
        };
        let hypothesis = Hypothesis {
            origin: Origin::Prior,
            keyframe: 0,
            shape: Shape(model.statistics.mean.clone()),
            motion,
            keyframe_cost: 0.0,
        };
        let frames = (0..4).map(|i| (i < fitted).then(|| fit.clone())).collect();
        TriedHypothesis {
            trial: Trial { hypothesis, shape_cost: 0.0, frames },
            keyframe: FrameIndex(0),
            fitted,
            iou: None,
        }
    }

    #[test]
    fn the_other_way_of_facing_is_said_unless_it_is_a_thousand_times_less_probable() {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let rig = Ring::default().regular();
        let evidence = Evidence::new(&model, &rig, LikelihoodOptions::default(), Measure::Ellipses);
        let said = |other: TriedHypothesis, data_weight: f64| {
            let hypotheses = [facing(&model, 0.1, 4, 10.0), other];
            facing_warning(&evidence, &hypotheses, 0, data_weight)
        };
        let odds = |warning: Option<Warning>| match warning {
            Some(Warning::Facing { odds }) => odds,
            other => panic!("{other:?}"),
        };

        // e², e⁸; with residuals that weigh a tenth e⁰·⁸
        approx::assert_relative_eq!(odds(said(facing(&model, PI, 4, 10.5), 1.0)), 2f64.exp());
        assert_eq!(said(facing(&model, PI, 4, 12.0), 1.0), None);
        approx::assert_relative_eq!(odds(said(facing(&model, PI, 4, 12.0), 0.1)), 0.8f64.exp());

        // dropped on its way, at the same cost a frame
        assert_eq!(said(facing(&model, PI, 2, 12.0), 1.0), None);

        // none that faces away
        assert_eq!(said(facing(&model, 0.3, 4, 10.5), 1.0), Some(Warning::FacingUntried));
    }
}
