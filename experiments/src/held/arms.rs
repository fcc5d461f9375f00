//! How far a fitted arm is from the true one.

use maquette::io::points::trc::Trajectories;
use maquette::math::stats::mean;
use nalgebra::Vector3;

use crate::metrics::{Flexion, point};

/// Shoulder, elbow and wrist.
#[derive(Debug, Clone, Copy)]
pub struct Arm {
    /// Its side.
    pub name: &'static str,
    /// Their names.
    pub points: [&'static str; 3],
}

/// Both arms.
pub const ARMS: [Arm; 2] = [
    Arm { name: "right", points: ["RShoulder", "RElbow", "RWrist"] },
    Arm { name: "left", points: ["LShoulder", "LElbow", "LWrist"] },
];

/// Joints farther than this from the truth are lost, as is an elbow's angle that is this far off.
const LOST_M: f64 = 0.1;
const LOST_DEG: f64 = 30.0;
/// Arms straighter than this bend to no side.
const STRAIGHT_DEG: f64 = 10.0;

/// One frame of one arm, fitted against true.
#[derive(Debug)]
pub struct ArmError {
    /// Distance of the shoulders.
    pub shoulder_m: f64,
    /// Distance of the elbows.
    pub elbow_m: f64,
    /// Distance of the wrists.
    pub wrist_m: f64,
    /// Between the directions of the upper arms.
    pub shoulder_deg: f64,
    /// Difference of the flexions.
    pub flexion_deg: f64,
    /// Whether the forearm leaves the upper arm's line to the other side.
    pub wrong_way: bool,
}

impl ArmError {
    /// A joint or the elbow's angle is far from the truth.
    pub fn is_lost(&self) -> bool {
        self.elbow_m > LOST_M || self.wrist_m > LOST_M || self.flexion_deg.abs() > LOST_DEG
    }
}

/// An arm as three points.
struct Bend {
    points: [Vector3<f64>; 3],
    flexion_deg: f64,
}

impl Bend {
    fn of(arm: Arm, of: &Trajectories, frame: usize) -> Option<Self> {
        let [a, b, c] = arm.points.map(|name| point(of, name, frame));
        Some(Self {
            points: [a?.coords, b?.coords, c?.coords],
            flexion_deg: arm.flexion().deg(of, frame)?,
        })
    }

    fn upper(&self) -> Vector3<f64> {
        self.points[1] - self.points[0]
    }

    /// The part of the forearm that is across the upper arm.
    fn side(&self) -> Vector3<f64> {
        let (upper, fore) = (self.upper(), self.points[2] - self.points[1]);
        fore - upper * (fore.dot(&upper) / upper.norm_squared())
    }
}

impl Arm {
    /// The elbow's flexion.
    pub fn flexion(self) -> Flexion {
        let [shoulder, elbow, wrist] = self.points;
        Flexion(shoulder, elbow, wrist)
    }

    /// Shoulder, elbow and wrist in the first frame, metres; `None` where one is not known.
    pub fn places(self, of: &Trajectories) -> Option<[[f64; 3]; 3]> {
        let [a, b, c] = self.points.map(|name| point(of, name, 0));
        Some([a?, b?, c?].map(|place| place.coords.into()))
    }

    /// One frame of a fit against the truth; `None` where a joint is not known.
    pub fn error(self, truth: &Trajectories, fit: &Trajectories, frame: usize) -> Option<ArmError> {
        let (truth, fit) = (Bend::of(self, truth, frame)?, Bend::of(self, fit, frame)?);
        let off = |k: usize| (truth.points[k] - fit.points[k]).norm();
        let bent = truth.flexion_deg.min(fit.flexion_deg) > STRAIGHT_DEG;
        Some(ArmError {
            shoulder_m: off(0),
            elbow_m: off(1),
            wrist_m: off(2),
            shoulder_deg: truth.upper().angle(&fit.upper()).to_degrees(),
            flexion_deg: fit.flexion_deg - truth.flexion_deg,
            wrong_way: bent && truth.side().dot(&fit.side()) < 0.0,
        })
    }
}

/// What one way makes of some frames of both arms.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Frames in which an arm is lost.
    pub lost: usize,
    /// Frames in which an elbow bends to the other side.
    pub wrong_way: usize,
    /// Direction of the upper arms, root mean square.
    pub shoulder_deg: f64,
    /// Flexion of the elbows, root mean square.
    pub elbow_deg: f64,
    /// Distance of the wrists, median.
    pub wrist_median_mm: f64,
    /// Distance of the wrists that 95 % do not exceed.
    pub wrist_p95_mm: f64,
}

impl Summary {
    /// Both arms in the frames that `counts` chooses.
    pub fn of(truth: &Trajectories, fit: &Trajectories, counts: impl Fn(usize) -> bool) -> Self {
        let frames = (0..truth.frames.len()).filter(|&f| counts(f));
        let each = frames.map(|f| ARMS.map(|arm| arm.error(truth, fit, f)));
        let each: Vec<Vec<ArmError>> = each.map(|e| e.into_iter().flatten().collect()).collect();
        let all = || each.iter().flatten();
        let any = |is: fn(&ArmError) -> bool| each.iter().filter(|f| f.iter().any(is)).count();
        let rms = |value: fn(&ArmError) -> f64| {
            mean(all().map(|e| value(e).powi(2))).map_or(f64::NAN, f64::sqrt)
        };
        let wrist = |q| {
            let mut wrists: Vec<f64> = all().map(|e| 1e3 * e.wrist_m).collect();
            wrists.sort_by(f64::total_cmp);
            let place = (q * wrists.len() as f64) as usize;
            wrists.get(place).copied().unwrap_or(f64::NAN)
        };
        Self {
            lost: any(ArmError::is_lost),
            wrong_way: any(|e| e.wrong_way),
            shoulder_deg: rms(|e| e.shoulder_deg),
            elbow_deg: rms(|e| e.flexion_deg),
            wrist_median_mm: wrist(0.5),
            wrist_p95_mm: wrist(0.95),
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    /// Both arms hang from (0, 0, 1.4), the forearm bent forwards or backwards.
    fn person(bend_deg: f64) -> Trajectories {
        let (sin, cos) = bend_deg.to_radians().sin_cos();
        let arm = [
            Point3::new(0.0, 0.0, 1.4),
            Point3::new(0.0, 0.0, 1.1),
            Point3::new(0.25 * sin, 0.0, 1.1 - 0.25 * cos),
        ];
        let names = ARMS.iter().flat_map(|a| a.points).map(str::to_owned);
        Trajectories {
            names: names.collect(),
            rate_hz: 50.0,
            first_frame: 0,
            frames: vec![arm.iter().chain(&arm).map(|p| Some(*p)).collect()],
        }
    }

    #[test]
    fn an_elbow_that_bends_to_the_other_side_is_the_wrong_way_though_its_flexion_is_right() {
        let error = ARMS[0].error(&person(25.0), &person(-25.0), 0).unwrap();
        assert!(error.wrong_way && error.is_lost());
        assert!(error.flexion_deg.abs() < 1e-9 && error.elbow_m < 1e-12);
        let error = ARMS[0].error(&person(25.0), &person(40.0), 0).unwrap();
        assert!(!error.wrong_way && !error.is_lost());
    }

    #[test]
    fn a_nearly_straight_arm_bends_to_no_side() {
        let error = ARMS[0].error(&person(25.0), &person(-8.0), 0).unwrap();
        assert!(!error.wrong_way);
    }

    #[test]
    fn a_frame_with_both_arms_lost_counts_once() {
        let summary = Summary::of(&person(25.0), &person(70.0), |_| true);
        assert_eq!((summary.lost, summary.wrong_way), (1, 0));
        assert!((summary.elbow_deg - 45.0).abs() < 1e-9);
    }
}
