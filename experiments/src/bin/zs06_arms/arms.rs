//! How far a fitted arm is from the true one.

use experiments::metrics::{Flexion, point};
use maquette::io::points::trc::Trajectories;
use maquette::math::stats::mean;
use nalgebra::Vector3;

/// Shoulder, elbow and wrist.
#[derive(Clone, Copy)]
pub(crate) struct Arm {
    pub(crate) name: &'static str,
    pub(crate) points: [&'static str; 3],
}

pub(crate) const ARMS: [Arm; 2] = [
    Arm { name: "right", points: ["RShoulder", "RElbow", "RWrist"] },
    Arm { name: "left", points: ["LShoulder", "LElbow", "LWrist"] },
];

/// Joints farther than this from the truth are lost, as is an elbow's angle that is this far off.
const LOST_M: f64 = 0.1;
const LOST_DEG: f64 = 30.0;
/// Arms straighter than this bend to no side.
const STRAIGHT_DEG: f64 = 10.0;

/// One frame of one arm, fitted against true.
pub(crate) struct Error {
    pub(crate) elbow_m: f64,
    pub(crate) wrist_m: f64,
    /// Between the directions of the upper arms.
    pub(crate) shoulder_deg: f64,
    /// Difference of the flexions.
    pub(crate) flexion_deg: f64,
    /// Whether the forearm leaves the upper arm's line to the other side.
    pub(crate) wrong_way: bool,
}

impl Error {
    pub(crate) fn is_lost(&self) -> bool {
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
    pub(crate) fn flexion(self) -> Flexion {
        let [shoulder, elbow, wrist] = self.points;
        Flexion(shoulder, elbow, wrist)
    }

    pub(crate) fn error(
        self,
        truth: &Trajectories,
        fit: &Trajectories,
        frame: usize,
    ) -> Option<Error> {
        let (truth, fit) = (Bend::of(self, truth, frame)?, Bend::of(self, fit, frame)?);
        let off = |k: usize| (truth.points[k] - fit.points[k]).norm();
        let bent = truth.flexion_deg.min(fit.flexion_deg) > STRAIGHT_DEG;
        Some(Error {
            elbow_m: off(1),
            wrist_m: off(2),
            shoulder_deg: truth.upper().angle(&fit.upper()).to_degrees(),
            flexion_deg: fit.flexion_deg - truth.flexion_deg,
            wrong_way: bent && truth.side().dot(&fit.side()) < 0.0,
        })
    }
}

/// What one way makes of some frames of both arms.
pub(crate) struct Summary {
    pub(crate) lost: usize,
    pub(crate) wrong_way: usize,
    pub(crate) shoulder_deg: f64,
    pub(crate) elbow_deg: f64,
    pub(crate) wrist_median_mm: f64,
    pub(crate) wrist_p95_mm: f64,
}

impl Summary {
    /// Both arms in the frames that `counts` chooses.
    pub(crate) fn of(
        truth: &Trajectories,
        fit: &Trajectories,
        counts: impl Fn(usize) -> bool,
    ) -> Self {
        let frames = (0..truth.frames.len()).filter(|&f| counts(f));
        let each = frames.map(|f| ARMS.map(|arm| arm.error(truth, fit, f)));
        let each: Vec<Vec<Error>> = each.map(|e| e.into_iter().flatten().collect()).collect();
        let all = || each.iter().flatten();
        let any = |is: fn(&Error) -> bool| each.iter().filter(|f| f.iter().any(is)).count();
        let rms = |value: fn(&Error) -> f64| {
            mean(all().map(|e| value(e).powi(2))).map_or(f64::NAN, f64::sqrt)
        };
        let wrist = |q| {
            let mut wrists: Vec<f64> = all().map(|e| 1e3 * e.wrist_m).collect();
            wrists.sort_by(f64::total_cmp);
            let place = (q * wrists.len() as f64) as usize;
            wrists.get(place).copied().unwrap_or(f64::NAN)
        };
        Self {
            lost: any(Error::is_lost),
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
