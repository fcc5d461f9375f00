//! Limbs that lie before or behind the body: where fewer than two cameras show a limb apart from it, the silhouettes leave it
//! anywhere along the lines of sight, and an optimum says nothing of the other places.

use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

use super::Warning;
use super::overlap::{Covering, projected};
use crate::body::{BodyModel, Motion, PartId, Posed, Primitive, Root, Shape, towards_root};
use crate::camera::Camera;
use crate::inference::Evidence;
use crate::silhouette::FrameObservations;

/// Points of each ellipse's outline that are looked at.
const SAMPLES: usize = 16;
/// A camera shows a limb if more than this share of its outline is apart from the rest of the body.
const SHOWN: f64 = 0.25;
/// Limbs that are hidden in more than this share of the frames are named.
const OFTEN: f64 = 0.1;

/// The limbs that fewer than two cameras show apart from the body in many of the frames, and in which share of them.
pub(super) fn hidden_warning(
    evidence: &Evidence<'_>,
    frames: &[FrameObservations],
    shape: &Shape,
    motions: &[&Motion],
) -> Option<Warning> {
    let Evidence { model, rig, .. } = *evidence;
    let limbs = limbs(model);
    let observed: Vec<usize> = (0..frames.len()).filter(|i| frames[*i].views.len() >= 2).collect();
    if observed.is_empty() || model.root == Root::Fixed {
        return None;
    }

    let hidden_in = |frame: &usize| {
        let body = Posed::new(model, shape, motions[*frame]);
        let views = &frames[*frame].views;
        let is_hidden = |limb: &Vec<PartId>| {
            let shown = views.iter().filter(|(id, _)| is_shown(&rig.cameras[id.0], &body, limb));
            shown.take(2).count() < 2
        };
        limbs.iter().map(is_hidden).collect::<Vec<bool>>()
    };
    let hidden: Vec<Vec<bool>> = observed.par_iter().map(hidden_in).collect();

    let share = |limb: usize| {
        hidden.iter().filter(|frame| frame[limb]).count() as f64 / hidden.len() as f64
    };
    let name = |limb: usize| model.parts[limbs[limb][0].0].name.clone();
    let often = (0..limbs.len()).map(|limb| (name(limb), share(limb)));
    let limbs: Vec<(String, f64)> = often.filter(|(_, share)| *share > OFTEN).collect();
    (!limbs.is_empty()).then_some(Warning::HiddenLimbs { limbs })
}

/// The chains of parts from each tip to where the body branches, which is left out.
fn limbs(model: &BodyModel) -> Vec<Vec<PartId>> {
    let parents = model.part_parents();
    let children = |part: usize| parents.iter().filter(|p| **p == Some(part)).count();
    let tips = (0..model.parts.len()).filter(|part| children(*part) == 0);
    let limb = |tip: usize| {
        let chain = towards_root(&parents, tip);
        chain.take_while(|part| children(*part) < 2).map(PartId).collect::<Vec<PartId>>()
    };
    tips.map(limb).filter(|limb| !limb.is_empty()).collect()
}

fn is_shown(camera: &Camera, body: &Posed<'_>, limb: &[PartId]) -> bool {
    let ellipsoids = body.model.ellipsoids.iter();
    let (own, rest): (Vec<&Primitive>, Vec<&Primitive>) =
        ellipsoids.partition(|e| limb.contains(&e.part));
    let rest: Vec<Covering> = projected(camera, body, rest).iter().map(Covering::new).collect();

    let outlines = projected(camera, body, own);
    let outline: Vec<Point2<f64>> = outlines
        .iter()
        .filter_map(|ellipse| Some((ellipse.centre, ellipse.shape.cholesky()?.l())))
        .flat_map(|(centre, root)| {
            (0..SAMPLES).map(move |k| {
                let (sin, cos) = (std::f64::consts::TAU * k as f64 / SAMPLES as f64).sin_cos();
                Point2::from(centre + root * Vector2::new(cos, sin))
            })
        })
        .collect();
    let is_apart = |pixel: &&Point2<f64>| !rest.iter().any(|covering| covering.contains(pixel));
    outline.iter().filter(is_apart).count() as f64 > SHOWN * outline.len() as f64
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Vector3;

    use super::*;
    use crate::likelihood::{LikelihoodOptions, Measure};
    use crate::pipeline::ambiguity::tests::before_cameras;

    /// What is said of a person whose arms hang, before cameras that stand at these headings; 0 is before the face.
    fn said(headings_deg: &[f64]) -> Option<Warning> {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let (rig, frame) = before_cameras(headings_deg);
        let shape = Shape(model.statistics.mean.clone());
        let mut motion = Motion::rest(&model);
        motion.position_world = Vector3::new(0.0, 0.0, 0.95);
        let evidence = Evidence::new(&model, &rig, LikelihoodOptions::default(), Measure::Ellipses);
        hidden_warning(&evidence, &[frame], &shape, &[&motion])
    }

    fn names(warning: Option<Warning>) -> Vec<String> {
        match warning {
            Some(Warning::HiddenLimbs { limbs }) => {
                limbs.into_iter().map(|(name, _)| name).collect()
            }
            None => Vec::new(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn arms_that_the_trunk_hides_from_the_side_are_named_and_from_the_front_nothing_is() {
        assert_eq!(names(said(&[0.0, 40.0, 180.0])), Vec::<String>::new());
        let found = names(said(&[0.0, 90.0]));
        assert!(found.iter().any(|name| name.starts_with("hand")), "{found:?}");
        assert!(!found.iter().any(|name| name == "head"), "{found:?}");
    }
}
