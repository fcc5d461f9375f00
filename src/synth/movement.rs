//! What a person does who does not walk: movements between key poses.
//!
//! Between two key poses at times a and b each angle, and each turn of the pelvis, takes the path of least jerk,
//!
//! θ(t) = θ_a + (θ_b − θ_a)(10τ³ − 15τ⁴ + 6τ⁵),  τ = (t − a)/(b − a),
//!
//! as a hand does between two places (T. Flash, N. Hogan, *The coordination of arm movements*, J. Neurosci. 5, 1985, eq. 2). The key poses
//! themselves are E: what such a movement looks like. The lowest place of the body is on the floor, but who jumps flies ½g(t − a)(b − t) high, and the
//! pelvis of who runs goes up and down by 4 cm. What carries the body stays where it is.

use nalgebra::{DVector, Rotation3, Vector2, Vector3};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

use super::WalkError;
use super::movement_keys::{Key, Keys, Rise, Support};
use super::walk::{checked_rate, within_limits};
use crate::body::{BodyModel, Joint, Motion, Posed, Shape};

/// Something that people do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Movement {
    /// Squats with the arms held out, and stands up.
    Squat,
    /// Jumping jacks, with both feet on the floor.
    Jacks,
    /// Turns from side to side, the hands on the hips.
    HandsOnHips,
    /// Turns from side to side, the arms crossed.
    ArmsCrossed,
    /// Kicks with the right leg.
    Kick,
    /// Bends down to the floor and comes up.
    PickUp,
    /// A long step ahead and back.
    Lunge,
    /// Reaches up with both arms.
    Reach,
    /// Runs on the spot.
    Run,
    /// Stands up from a seat, and sits down.
    StandUp,
    /// Turns from side to side, the arms held aside.
    TPose,
    /// Turns around on the spot.
    Spin,
    /// Jumps up from both feet.
    Jump,
    /// Throws with the right arm.
    Throw,
    /// Crawls on the spot.
    AllFours,
    /// Lies on the back and draws up a knee.
    Lie,
}

/// Standard deviation between persons of how fast and how far they move, relative (E).
const VARIES: f64 = 0.08;
/// g, m/s².
const GRAVITY: f64 = 9.81;
/// Times in a period at which a body that bounces is kept above the floor.
const SAMPLES: i32 = 64;

impl Movement {
    /// All of them.
    pub const ALL: [Self; 16] = [
        Self::Squat,
        Self::Jacks,
        Self::HandsOnHips,
        Self::ArmsCrossed,
        Self::Kick,
        Self::PickUp,
        Self::Lunge,
        Self::Reach,
        Self::Run,
        Self::StandUp,
        Self::TPose,
        Self::Spin,
        Self::Jump,
        Self::Throw,
        Self::AllFours,
        Self::Lie,
    ];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Squat => "squat",
            Self::Jacks => "jacks",
            Self::HandsOnHips => "hands-on-hips",
            Self::ArmsCrossed => "arms-crossed",
            Self::Kick => "kick",
            Self::PickUp => "pick-up",
            Self::Lunge => "lunge",
            Self::Reach => "reach",
            Self::Run => "run",
            Self::StandUp => "stand-up",
            Self::TPose => "t-pose",
            Self::Spin => "spin",
            Self::Jump => "jump",
            Self::Throw => "throw",
            Self::AllFours => "all-fours",
            Self::Lie => "lie",
        }
    }

    /// Seconds from its beginning until it begins anew, of a person of mean tempo.
    pub fn period_s(self) -> f64 {
        self.keys().period_s()
    }

    /// One motion per frame, of a person who moves at a tempo and as far as `rng` says, in a direction of its choice.
    ///
    /// # Errors
    /// [`WalkError::Rate`] if `fps` is impossible.
    pub fn motions(
        self,
        model: &BodyModel,
        shape: &Shape,
        (fps, frames): (f64, usize),
        middle_world: Vector2<f64>,
        rng: &mut impl Rng,
    ) -> Result<Vec<Motion>, WalkError> {
        checked_rate(fps)?;
        let mut varied = || -> f64 {
            let z: f64 = StandardNormal.sample(rng);
            1.0 + VARIES * z.clamp(-2.0, 2.0)
        };
        let (tempo, extent) = (varied(), varied());
        let heading = rng.random_range(0.0..std::f64::consts::TAU);
        let keys = self.keys();

        let posed = |time_s: f64| {
            let mut motion = keys.motion(model, time_s, extent);
            motion.position_world = keys.place(model, shape, &motion);
            motion
        };
        let height = keys.height(|time_s| posed(time_s).position_world.z);
        let of_frame = |frame: usize| {
            let time_s = (tempo * frame as f64 / fps).rem_euclid(keys.period_s());
            let Motion { position_world, world_from_root, angles } = posed(time_s);
            let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), heading);
            let mut position_world = turn * position_world + middle_world.push(0.0);
            position_world.z = height(time_s, position_world.z);
            Motion { position_world, world_from_root: turn * world_from_root, angles }
        };
        Ok((0..frames).map(of_frame).collect())
    }
}

impl Keys {
    fn period_s(&self) -> f64 {
        self.keys.last().map_or(1.0, |key| key.at_s)
    }

    /// Angles and turns at a time, the root at the origin.
    fn motion(&self, model: &BodyModel, time_s: f64, extent: f64) -> Motion {
        let after =
            self.keys.partition_point(|key| key.at_s <= time_s).clamp(1, self.keys.len() - 1);
        let (from, to) = (&self.keys[after - 1], &self.keys[after]);
        let share = least_jerk((time_s - from.at_s) / (to.at_s - from.at_s));
        let between = |a: f64, b: f64| (a + share * (b - a)).to_radians();

        let [tilt, lean, heading] =
            [0, 1, 2].map(|k| between(from.pelvis_deg[k], to.pelvis_deg[k]));
        let about = |axis: Vector3<f64>| Rotation3::from_scaled_axis(axis);
        let angle = |joint: &Joint| {
            let rest_deg = joint.rest.to_degrees();
            let of = |key: &Key| {
                key.angle_deg(&joint.name)
                    .map_or(rest_deg, |angle| rest_deg + extent * (angle - rest_deg))
            };
            within_limits(joint, between(of(from), of(to)))
        };
        Motion {
            position_world: Vector3::zeros(),
            world_from_root: about(Vector3::z() * heading)
                * about(Vector3::x() * lean)
                * about(Vector3::y() * tilt),
            angles: DVector::from_iterator(model.joints.len(), model.joints.iter().map(angle)),
        }
    }

    /// Where the root of a motion at the origin belongs: above what carries the body, whose lowest place is on the floor.
    fn place(&self, model: &BodyModel, shape: &Shape, motion: &Motion) -> Vector3<f64> {
        let body = Posed::new(model, shape, motion);
        let lowest = body.bounds().map_or(0.0, |(least, _)| least.z);
        let points = body.points();
        let of_point =
            |name: &str| model.point(name).map_or(Vector3::zeros(), |i| points[i].coords);
        let carries = match self.support {
            Support::Pelvis => Vector3::zeros(),
            Support::Feet => 0.5 * (of_point("RAnkle") + of_point("LAnkle")),
            Support::LeftFoot => of_point("LAnkle"),
        };
        (-carries.xy()).push(-lowest)
    }

    /// How high the root is at a time, from how high it is on the floor then.
    fn height(&self, on_floor: impl Fn(f64) -> f64) -> impl Fn(f64, f64) -> f64 {
        let (rise, period_s) = (self.rise, self.period_s());
        let bounce = move |by_m: f64, lowest_at_s: f64, time_s: f64| {
            -by_m * (2.0 * std::f64::consts::TAU * (time_s - lowest_at_s) / period_s).cos()
        };
        // a body that bounces is as low as its feet let it
        let middle = match rise {
            Rise::Bounces { by_m, lowest_at_s } => (0..SAMPLES)
                .map(|i| period_s * f64::from(i) / f64::from(SAMPLES))
                .map(|time_s| on_floor(time_s) - bounce(by_m, lowest_at_s, time_s))
                .fold(f64::NEG_INFINITY, f64::max),
            _ => 0.0,
        };
        move |time_s, on_floor| match rise {
            Rise::Never => on_floor,
            Rise::Flies { from_s, to_s } => {
                on_floor + 0.5 * GRAVITY * (time_s - from_s).max(0.0) * (to_s - time_s).max(0.0)
            }
            Rise::Bounces { by_m, lowest_at_s } => middle + bounce(by_m, lowest_at_s, time_s),
        }
    }
}

/// The share of the way from a key pose to the next.
fn least_jerk(tau: f64) -> f64 {
    let tau = tau.clamp(0.0, 1.0);
    tau.powi(3) * (10.0 + tau * (6.0 * tau - 15.0))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::io::model;

    #[test]
    fn the_body_touches_the_floor_but_in_flight() {
        let model = model::load("walker-metaballs", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        for movement in Movement::ALL {
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let at = (30.0, 60);
            let motions = movement.motions(&model, &shape, at, Vector2::zeros(), &mut rng).unwrap();
            let lowest = |motion: &Motion| Posed::new(&model, &shape, motion).bounds().unwrap().0.z;
            let heights: Vec<f64> = motions.iter().map(lowest).collect();
            let highest = heights.iter().copied().fold(0.0, f64::max);
            assert!(heights.iter().all(|z| *z > -1e-3), "{movement:?}");
            let flies = matches!(movement, Movement::Jump | Movement::Run);
            assert_eq!(highest > 0.02, flies, "{movement:?}: {highest}");
        }
    }

    #[test]
    fn every_key_names_joints_of_the_model() {
        let model = model::load("walker-metaballs", Path::new("")).unwrap();
        let sided = |name: &str| {
            let names = [name.to_owned(), format!("{name}_r"), format!("{name}_l")];
            names.iter().any(|name| model.joint(name).is_some())
        };
        for movement in Movement::ALL {
            let keys = movement.keys();
            let named = keys.keys.iter().flat_map(|key| key.angles_deg);
            named.for_each(|(name, _)| assert!(sided(name), "{movement:?}: {name}"));
            assert!(keys.keys.windows(2).all(|pair| pair[0].at_s < pair[1].at_s), "{movement:?}");
        }
    }

    #[test]
    fn a_way_of_least_jerk_begins_and_ends_at_rest() {
        let h = 1e-4;
        assert!([0.0, 0.5, 1.0].into_iter().all(|tau| (least_jerk(tau) - tau).abs() < 1e-12));
        assert!(least_jerk(h) < 1e-10 && 1.0 - least_jerk(1.0 - h) < 1e-10);
        assert!((least_jerk(0.5 + h) - least_jerk(0.5 - h) - 2.0 * h * 1.875).abs() < 1e-7);
    }
}
