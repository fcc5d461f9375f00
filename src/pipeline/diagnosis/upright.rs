//! Whether the person stands along another axis of the world than the one that is said to point up.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::camera::Rig;
use crate::inference::Evidence;
use crate::inference::start::{StartOptions, readings};
use crate::math::Rigid3;
use crate::silhouette::FrameObservations;

/// The axis of the world along which a person's head points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HeadAxis {
    /// +X.
    X,
    /// −X.
    MinusX,
    /// +Y.
    Y,
    /// −Y.
    MinusY,
    /// −Z: upside down.
    MinusZ,
}

impl HeadAxis {
    /// Both ways along an axis of the world, but for z.
    fn along(axis: usize) -> &'static [Self] {
        match axis {
            0 => &[Self::X, Self::MinusX],
            1 => &[Self::Y, Self::MinusY],
            _ => &[Self::MinusZ],
        }
    }

    /// `−Z`.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "X",
            Self::MinusX => "−X",
            Self::Y => "Y",
            Self::MinusY => "−Y",
            Self::MinusZ => "−Z",
        }
    }

    /// The turn that takes the axis to z.
    fn to_up(self) -> Rigid3 {
        Rigid3::rotation(match self {
            Self::X => Vector3::y() * -FRAC_PI_2,
            Self::MinusX => Vector3::y() * FRAC_PI_2,
            Self::Y => Vector3::x() * FRAC_PI_2,
            Self::MinusY => Vector3::x() * -FRAC_PI_2,
            Self::MinusZ => Vector3::x() * PI,
        })
    }
}

/// A person along another axis must cost less than this share of what one along z costs, at the best of the frames.
const CLEARLY: f64 = 0.6;

/// Which way the head points along the longest axis of what is seen, if a body fits much better that way than along z.
///
/// Each way is judged by the frame of which it makes most: in single frames also the right way may find no good start.
pub(super) fn head_axis(
    evidence: &Evidence<'_>,
    frames: &[&FrameObservations],
    longest: usize,
) -> Option<HeadAxis> {
    let cost = |rig: &Rig| {
        let of_frame = |frame: &&FrameObservations| {
            let found = readings(&evidence.with_rig(rig), frame, &StartOptions::default());
            found.first().map(|reading| reading.cost)
        };
        frames.par_iter().filter_map(of_frame).min_by(f64::total_cmp)
    };
    let turned = |axis: &HeadAxis| {
        let world_from_turned = axis.to_up().inverse();
        let mut rig = evidence.rig.clone();
        rig.cameras.iter_mut().for_each(|c| c.camera_from_world *= world_from_turned);
        Some((*axis, cost(&rig)?))
    };

    let upright = cost(evidence.rig)?;
    let all = HeadAxis::along(longest).iter().filter_map(turned);
    let best = all.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (best.1 < CLEARLY * upright).then_some(best.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likelihood::{LikelihoodOptions, Measure};
    use crate::pipeline::diagnosis::figures::Figures;

    #[test]
    fn a_person_who_stands_along_another_axis_is_found_and_one_upright_is_not() {
        let figures = Figures::new();
        let frame = figures.frame(0, &figures.masks(&figures.standing(0.0, 0.0)));
        let found = |rig: &Rig, longest: usize| {
            let body =
                crate::io::model::load("human-ellipsoids", std::path::Path::new("")).unwrap();
            let likelihood = LikelihoodOptions::default();
            head_axis(&Evidence::new(&body, rig, likelihood, Measure::Ellipses), &[&frame], longest)
        };
        assert_eq!(found(&figures.rig, 2), None);

        // z becomes y
        let mut turned = figures.rig.clone();
        let world_from_turned = HeadAxis::Y.to_up();
        turned.cameras.iter_mut().for_each(|c| c.camera_from_world *= world_from_turned);
        assert_eq!(found(&turned, 1), Some(HeadAxis::Y));
    }
}
