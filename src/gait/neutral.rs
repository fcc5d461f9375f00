//! A standing pose as the zero of angles.
//!
//! Two systems, or two bodies fitted to one recording, agree on how far a joint moves and not on where its zero is: the tilt of the bony pelvis
//! and the line along a foot differ by degrees. Somebody who stands still shows what a system calls zero. With α of a walk and ᾱ the
//! median of the same angle over a standing trial, the angle *from the standing pose* is α − ᾱ. What both trials err by alike cancels.
//! So does what the person cannot do: of a knee that never straightens it shows nothing.
//!
//! Some angles stay as they are. Those against the direction of walking have no standing pose: rotation of pelvis and trunk, and foot progression. And an
//! arm that hangs straight does not show how the shoulder is rotated.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::angle::Angle;
use super::angles::AngleTracks;
use super::landmark::Side;
use super::{Curve, GaitAnalysis};
use crate::math::stats::{mean, mean_and_sd, median};

/// What angles are counted from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Zero {
    /// The axes of the parts, where docs/gait.md has them.
    #[default]
    Anatomical,
    /// A standing pose.
    Standing,
}

/// How somebody stands.
#[derive(Debug, Clone, PartialEq)]
pub struct NeutralPose {
    /// The trial that shows it.
    pub source: String,
    /// Its angles, radians.
    pub angles: BTreeMap<(Side, Angle), f64>,
}

/// Why a trial shows no standing pose.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NeutralError {
    /// The person moves.
    #[error(
        "the {side} {angle} varies by ± {sd_deg:.0}° there: expected somebody who stands still, within ± {STILL_DEG}°"
    )]
    Moves {
        /// Whose.
        side: &'static str,
        /// The angle.
        angle: &'static str,
        /// Its standard deviation over time, degrees.
        sd_deg: f64,
    },
    /// No angle is known.
    #[error("no angle of a leg is known there")]
    NoAngles,
}

/// Standard deviation over time that a leg's angles of somebody who stands still have at most.
const STILL_DEG: f64 = 3.0;
/// Angles of a leg that must be still.
const OF_A_LEG: [Angle; 3] = [Angle::HipFlexion, Angle::KneeFlexion, Angle::AnkleDorsiflexion];

impl NeutralPose {
    /// The pose of somebody who stands still throughout a trial of this name.
    ///
    /// # Errors
    /// [`NeutralError`].
    pub fn of(gait: &GaitAnalysis, source: &str) -> Result<Self, NeutralError> {
        check_still(&gait.angles)?;
        let standing = gait.angles.iter().filter(|((_, angle), _)| angle.has_standing_zero());
        let pose =
            |(key, track): (&(Side, Angle), &Vec<f64>)| Some((*key, median(&mut known(track))?));
        Ok(Self { source: source.into(), angles: standing.filter_map(pose).collect() })
    }

    /// The mean of several; `None` of none.
    pub fn mean_of(poses: &[Self]) -> Option<Self> {
        let first = poses.first()?;
        let in_all = |key: &(Side, Angle)| -> Option<f64> {
            let values: Option<Vec<f64>> =
                poses.iter().map(|pose| pose.angles.get(key).copied()).collect();
            mean(values?)
        };
        let angles = first.angles.keys().filter_map(|key| Some((*key, in_all(key)?))).collect();
        let names: Vec<&str> = poses.iter().map(|pose| pose.source.as_str()).collect();
        Some(Self { source: names.join(", "), angles })
    }

    /// Counts a curve from here. How sure it is then is not known: most of the fit's standard deviation is alike in both and cancels.
    fn shift(&self, curve: &mut Curve) {
        let Some(zero) = self.angles.get(&(curve.side, curve.angle)) else { return };
        let strides = curve.strides.iter_mut().flatten();
        strides.chain(&mut curve.mean).for_each(|value| *value -= zero);
        curve.fit_sd = None;
    }
}

impl GaitAnalysis {
    /// What its angles are counted from.
    pub fn zero(&self) -> Zero {
        if self.neutral.is_some() { Zero::Standing } else { Zero::Anatomical }
    }

    /// The same with angles from a standing pose, for those that it has.
    pub fn counted_from(mut self, pose: &NeutralPose) -> Self {
        for (key, zero) in &pose.angles {
            let values = self.angles.get_mut(key).into_iter().flatten();
            values.for_each(|value| *value -= zero);
        }
        self.curves.iter_mut().for_each(|curve| pose.shift(curve));
        self.neutral = Some(pose.clone());
        self
    }
}

impl Angle {
    /// Whether somebody who stands shows its zero: not where it is measured against the direction of walking, nor the turn of an upper
    /// arm, which a straight elbow does not show.
    pub(super) fn has_standing_zero(self) -> bool {
        let against_heading =
            matches!(self, Self::PelvisRotation | Self::TrunkRotation | Self::FootProgression);
        !against_heading && self != Self::ShoulderRotation
    }
}

fn known(track: &[f64]) -> Vec<f64> {
    track.iter().copied().filter(|value| value.is_finite()).collect()
}

fn check_still(angles: &AngleTracks) -> Result<(), NeutralError> {
    let of_legs = angles.iter().filter(|((_, angle), _)| OF_A_LEG.contains(angle));
    let spread =
        |(key, track): (&(Side, Angle), &Vec<f64>)| Some((*key, mean_and_sd(&known(track))?.1?));
    let spreads: Vec<((Side, Angle), f64)> = of_legs.filter_map(spread).collect();
    let widest = spreads.iter().max_by(|a, b| a.1.total_cmp(&b.1)).ok_or(NeutralError::NoAngles)?;

    let ((side, angle), sd_deg) = (widest.0, widest.1.to_degrees());
    if sd_deg > STILL_DEG {
        let (side, angle) = (side.name(), angle.name());
        return Err(NeutralError::Moves { side, angle, sd_deg });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gait::{GaitOptions, Landmark, Movement, Paired, analyse};
    use nalgebra::Point3;

    /// Somebody who faces X with knees bent by an angle, which grows by `growth` a frame; radians.
    fn standing(bend: f64, growth: f64) -> GaitAnalysis {
        let places = [Paired::Hip, Paired::Knee, Paired::Ankle, Paired::Heel, Paired::Toe];
        let names = Side::BOTH.map(|side| places.map(|place| Landmark::Of(side, place)));
        let names: Vec<String> = names.iter().flatten().map(named).collect();
        let frame = |i: usize| -> Vec<Option<Point3<f64>>> {
            let bend = bend + growth * i as f64;
            let (knee, ankle) = (0.42 * bend.sin(), 0.1 + 0.42 * bend.cos());
            let leg = |y: f64| {
                [
                    (0.0, ankle + 0.4),
                    (0.0, ankle),
                    (-knee, 0.1),
                    (-knee - 0.05, 0.03),
                    (0.2 - knee, 0.03),
                ]
                .map(|(x, z)| Some(Point3::new(x, y, z)))
            };
            [leg(0.1), leg(-0.1)].concat()
        };
        let frames: Vec<_> = (0..40).map(frame).collect();
        let movement = Movement::from_points(50.0, 0, &names, &frames).unwrap();
        analyse(&movement, &GaitOptions::default()).unwrap()
    }

    /// The name that a file of points would have for a place.
    fn named(landmark: &Landmark) -> String {
        let Landmark::Of(side, place) = landmark else { unreachable!("all have a side") };
        let side = if *side == Side::Left { "L" } else { "R" };
        let place = match place {
            Paired::Hip => "Hip",
            Paired::Knee => "Knee",
            Paired::Ankle => "Ankle",
            Paired::Heel => "Heel",
            _ => "BigToe",
        };
        format!("{side}{place}")
    }

    #[test]
    fn angles_are_counted_from_the_standing_pose_and_those_against_the_direction_stay() {
        let (stands, bends) = (standing(0.1, 0.0), standing(0.35, 0.0));
        let pose = NeutralPose::of(&stands, "standing").unwrap();
        let turned = &bends.angles[&(Side::Left, Angle::FootProgression)];
        let from = bends.clone().counted_from(&pose);
        assert_eq!((bends.zero(), from.zero()), (Zero::Anatomical, Zero::Standing));
        assert_eq!(&from.angles[&(Side::Left, Angle::FootProgression)], turned);
        for side in Side::BOTH {
            let knee = &from.angles[&(side, Angle::KneeFlexion)];
            approx::assert_relative_eq!(knee[20], 0.25, epsilon = 1e-6);
        }
    }

    #[test]
    fn who_moves_shows_no_standing_pose() {
        let fault = NeutralPose::of(&standing(0.1, 0.01), "walk").unwrap_err();
        assert!(fault.to_string().contains("flexion varies by"), "{fault}");
    }

    #[test]
    fn several_poses_count_by_their_mean() {
        let [a, b] = [0.1, 0.2].map(|bend| NeutralPose::of(&standing(bend, 0.0), "s").unwrap());
        let both = NeutralPose::mean_of(&[a, b]).unwrap();
        approx::assert_relative_eq!(
            both.angles[&(Side::Left, Angle::KneeFlexion)],
            0.15,
            epsilon = 1e-6
        );
        assert_eq!(both.source, "s, s");
        assert!(NeutralPose::mean_of(&[]).is_none());
    }
}
