//! The body model: what never changes while a recording is fitted.

use nalgebra::{DMatrix, DVector, Rotation3, UnitVector3, Vector3};

use super::{Motion, Posed, ScaledVector, Shape, Shift, SurfaceOffsets};

/// Index of a joint in [`BodyModel::joints`]; parents come first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JointId(pub usize);

/// Index of a frame: 0 is the root's, 1 + j that of joint j, then those of [`BodyModel::followers`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FrameId(pub usize);

impl FrameId {
    /// The frame of a joint, or the root's.
    pub fn from_joint(joint: Option<JointId>) -> Self {
        Self(joint.map_or(0, |j| j.0 + 1))
    }
}

/// Index of a part in [`BodyModel::parts`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PartId(pub usize);

/// Index of a shape coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CoefficientId(pub usize);

/// A joint: a static transform, then one rotation about one axis (PFD99 eq. 3, D = Rot(θ)·D_ini).
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name of the angle, as exported.
    pub name: String,
    /// The joint before it; `None` is the root.
    pub parent: Option<JointId>,
    /// Static rotation D_ini.
    pub parent_from_joint: Rotation3<f64>,
    /// Static translation in the parent's frame.
    pub translation: ScaledVector,
    /// Axis of rotation in the joint's frame.
    pub axis: UnitVector3<f64>,
    /// Lower and upper limit, radians.
    pub limits: (f64, f64),
    /// Angle at rest, radians.
    pub rest: f64,
    /// Standard deviation of the angle about rest when nothing else is known, radians.
    pub spread: f64,
    /// Standard deviation of the angle's velocity, rad/s.
    pub speed: f64,
}

/// How a frame turns against another: about a joint's axis, by a share of the joint's angle.
///
/// Flesh near a joint is tied to both of its bones and turns by less than the farther one, as in linear blend skinning.
/// The frame of such flesh has a share below 1; at angle 0 it coincides with the joint's own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// The frame against which it turns; lower than its own.
    pub parent: FrameId,
    /// The joint whose translation, axis and angle it takes.
    pub joint: JointId,
    /// Part of the angle, 0 to 1; 1 is the joint itself.
    pub share: f64,
}

/// An ellipsoid fixed to a part: a solid (ZS06), or the distance function of a metaball (PF02 eq. 6).
#[derive(Debug, Clone, PartialEq)]
pub struct Primitive {
    /// The part it belongs to.
    pub part: PartId,
    /// The frame it is fixed to: its part's, or one that follows it by less.
    pub frame: FrameId,
    /// Centre in its frame.
    pub centre: ScaledVector,
    /// The same in the mean body; only of a [detailed](BodyModel::detailed) body, whose offsets are found by it.
    pub home: Vector3<f64>,
    /// Semi-axes along the primitive's own axes.
    pub radii: ScaledVector,
    /// Orientation in its frame.
    pub part_from_primitive: Rotation3<f64>,
}

/// A rigid part: the frame after a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Name, unique.
    pub name: String,
    /// The joint whose frame it is; `None` is the root's.
    pub joint: Option<JointId>,
    /// How shape coefficients shift its own joint within the flesh, along the part's axes: already contained in the
    /// translations of the joint and of all that the part carries.
    pub pivot: Vec<Shift>,
    /// How uncertain the joint's place in the flesh is: standard deviations along the part's axes, metres. Sources differ on
    /// where a joint is, and no silhouette shows it.
    pub sd_m: Vector3<f64>,
    /// Whether the skin at its joint folds as it bends.
    pub folds: bool,
}

/// A point fixed to a part, as exported: a joint centre or a landmark.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedPoint {
    /// Export name (Pose2Sim's for joint centres).
    pub name: String,
    /// The parts whose points are averaged: one, or two for a midpoint such as `Hip`.
    pub places: Vec<(PartId, ScaledVector)>,
    /// How uncertain its place in the flesh is: standard deviations along the axes of its (first) part, metres. Not used for a
    /// joint's centre, which has the part's.
    pub sd_m: Vector3<f64>,
    /// Of a keypoint, how far from there a detector means it to be, along the axes of a frame.
    pub meant: Option<(FrameId, ScaledVector)>,
}

/// Gaussian of the shape coefficients, p(s).
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeStatistics {
    /// Mean, n.
    pub mean: DVector<f64>,
    /// Covariance, n × n: ΛΛᵀ + diag(ψ²).
    pub covariance: DMatrix<f64>,
}

/// How the root moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Root {
    /// Not at all: the root frame is the world.
    Fixed,
    /// Freely.
    Free {
        /// Standard deviation of the root's velocity, m/s.
        speed: f64,
        /// Standard deviation of the root's angular velocity, rad/s.
        turn: f64,
    },
}

/// Which limbs a canonical pose bends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Limbs {
    /// Legs: such poses are tried first, at every heading.
    Legs,
    /// Arms: such poses are tried on the best of those.
    Arms,
}

/// A pose from which a search may start.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// Name.
    pub name: String,
    /// The limbs that it bends.
    pub limbs: Limbs,
    /// Angles that it sets, radians; the others stay.
    pub angles: Vec<(JointId, f64)>,
}

impl Pose {
    /// Sets the pose's angles in a motion.
    pub fn apply(&self, motion: &mut super::Motion) {
        self.angles.iter().for_each(|(joint, angle)| motion.angles[joint.0] = *angle);
    }
}

/// An articulated body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyModel {
    /// Name of the model.
    pub name: String,
    /// Names of the shape coefficients.
    pub coefficients: Vec<String>,
    /// p(s).
    pub statistics: ShapeStatistics,
    /// How the root moves.
    pub root: Root,
    /// Joints, parents first.
    pub joints: Vec<Joint>,
    /// Frames of flesh that follows a joint by less than its angle; parents first.
    pub followers: Vec<Turn>,
    /// Parts.
    pub parts: Vec<Part>,
    /// Ellipsoids (ZS06, § Human body model).
    pub ellipsoids: Vec<Primitive>,
    /// Metaballs (PF02 § 2.2, eq. 2–4).
    pub metaballs: Vec<Primitive>,
    /// How far the surface of a person lies outside that of the model; `None`: nowhere.
    pub offsets: Option<SurfaceOffsets>,
    /// Exported points.
    pub points: Vec<NamedPoint>,
    /// Exported points as a detector means them ([`BodyModel::with_keypoints`]); none in a model's file.
    pub keypoints: Vec<NamedPoint>,
    /// Canonical poses.
    pub poses: Vec<Pose>,
    /// Lengths that are reported: name and the two points between which they are measured.
    pub lengths: Vec<(String, usize, usize)>,
}

/// Why a model cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A length that must be positive is not.
    #[error("part {part}: radius {radius_m} m is not positive")]
    Radius {
        /// Part.
        part: String,
        /// Radius found.
        radius_m: f64,
    },
    /// A joint's lower limit lies above its upper one.
    #[error("joint {joint}: limits {low} to {high} rad are not in order")]
    Limits {
        /// Joint.
        joint: String,
        /// Lower.
        low: f64,
        /// Upper.
        high: f64,
    },
    /// The covariance of p(s) has no inverse.
    #[error(
        "the shape coefficients' covariance is not positive definite: give each coefficient an sd > 0"
    )]
    Covariance,
    /// A number that must be finite, or finite and positive, is not.
    #[error("{place}: {value} is not a usable number")]
    Number {
        /// Where.
        place: String,
        /// Found.
        value: f64,
    },
    /// No primitive at all.
    #[error("the model has neither ellipsoids nor metaballs")]
    Empty,
}

impl BodyModel {
    /// Points whose names make them mirror images, such as `RAnkle` and `LAnkle`: (right, left), in the order of the right ones.
    pub fn point_pairs(&self) -> Vec<(usize, usize)> {
        let names: Vec<&str> = self.points.iter().map(|p| p.name.as_str()).collect();
        pairs(&names, |right| Some(format!("L{}", right.strip_prefix('R')?)))
    }

    /// Parts whose names make them mirror images, such as `foot_r` and `foot_l`: (right, left), in the order of the right ones.
    pub fn part_pairs(&self) -> Vec<(usize, usize)> {
        let names: Vec<&str> = self.parts.iter().map(|p| p.name.as_str()).collect();
        pairs(&names, |right| Some(format!("{}_l", right.strip_suffix("_r")?)))
    }

    /// Joints that are mirror images of each other, the right one first.
    pub fn joint_pairs(&self) -> Vec<(usize, usize)> {
        let names: Vec<&str> = self.joints.iter().map(|j| j.name.as_str()).collect();
        pairs(&names, |right| Some(format!("{}_l", right.strip_suffix("_r")?)))
    }

    /// Checks what kinematics and priors rely on: positive radii, ordered limits, a usable covariance.
    ///
    /// # Errors
    /// The first fault found.
    pub fn validate(&self) -> Result<(), ModelError> {
        let mut primitives = self.ellipsoids.iter().chain(&self.metaballs);
        if primitives.clone().next().is_none() {
            return Err(ModelError::Empty);
        }

        primitives.try_for_each(|primitive| self.check_primitive(primitive))?;
        self.joints.iter().try_for_each(check_joint)?;
        for part in &self.parts {
            check_sd(&part.sd_m, "part", &part.name)?;
        }
        for point in &self.points {
            check_sd(&point.sd_m, "point", &point.name)?;
        }

        let n = self.coefficients.len();
        if n > 0 && self.statistics.covariance.clone().cholesky().is_none() {
            return Err(ModelError::Covariance);
        }
        Ok(())
    }

    fn check_primitive(&self, primitive: &Primitive) -> Result<(), ModelError> {
        let part = || self.parts[primitive.part.0].name.clone();
        let mut radii = primitive.radii.value.iter();
        if let Some(&radius_m) = radii.find(|r| r.is_nan() || **r <= 0.0) {
            let part = part();
            return Err(ModelError::Radius { part, radius_m });
        }
        let place = || format!("centre of part {}", part());
        check(&primitive.centre.value, f64::is_finite, place)
    }

    /// The joints from the root to a joint, that joint last.
    pub fn chain(&self, joint: Option<JointId>) -> Vec<JointId> {
        let mut chain: Vec<_> = std::iter::successors(joint, |j| self.joints[j.0].parent).collect();
        chain.reverse();
        chain
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        1 + self.joints.len() + self.followers.len()
    }

    /// How a frame turns; `None` for the root's.
    pub fn turn(&self, frame: FrameId) -> Option<Turn> {
        let joint = frame.0.checked_sub(1)?;
        match self.joints.get(joint) {
            Some(own) => Some(Turn {
                parent: FrameId::from_joint(own.parent),
                joint: JointId(joint),
                share: 1.0,
            }),
            None => self.followers.get(joint - self.joints.len()).copied(),
        }
    }

    /// A frame and the frames that carry it, up to the one on the root.
    pub fn path(&self, frame: FrameId) -> impl Iterator<Item = (FrameId, Turn)> {
        let with_turn = |frame| Some((frame, self.turn(frame)?));
        std::iter::successors(with_turn(frame), move |(_, turn)| with_turn(turn.parent))
    }

    /// The lengths of a body, metres, in the order of [`BodyModel::lengths`], measured at rest.
    ///
    /// A length within a part is the same in every pose; one across a joint is stated at the joints' rest angles.
    pub fn rest_lengths_m(&self, shape: &Shape) -> Vec<f64> {
        let points = Posed::new(self, shape, &Motion::rest(self)).points();
        let length = |(_, from, to): &(String, usize, usize)| (points[*to] - points[*from]).norm();
        self.lengths.iter().map(length).collect()
    }

    /// Index of an exported point.
    pub fn point(&self, name: &str) -> Option<usize> {
        self.points.iter().position(|p| p.name == name)
    }

    /// Index of a joint angle.
    pub fn joint(&self, name: &str) -> Option<JointId> {
        self.joints.iter().position(|j| j.name == name).map(JointId)
    }
}

/// Indices (right, left) of names that have a left counterpart among them.
fn pairs(names: &[&str], left_of: impl Fn(&str) -> Option<String>) -> Vec<(usize, usize)> {
    let twin = |(right, name): (usize, &&str)| {
        let left = left_of(name)?;
        Some((right, names.iter().position(|other| **other == left)?))
    };
    names.iter().enumerate().filter_map(twin).collect()
}

fn check_joint(joint: &Joint) -> Result<(), ModelError> {
    let (low, high) = joint.limits;
    if low.is_nan() || high.is_nan() || low >= high {
        let joint = joint.name.clone();
        return Err(ModelError::Limits { joint, low, high });
    }
    let place = || format!("spread or speed of joint {}", joint.name);
    check([joint.spread, joint.speed].iter(), |v| v > 0.0, place)
}

/// The place of a joint or point in the flesh is uncertain by at most a metre.
fn check_sd(sd_m: &Vector3<f64>, kind: &str, name: &str) -> Result<(), ModelError> {
    let place = || format!("sd of {kind} {name}");
    check(sd_m, |sd| (0.0..=1.0).contains(&sd), place)
}

/// The first number that is not right is a fault.
fn check<'a>(
    numbers: impl IntoIterator<Item = &'a f64>,
    is_right: impl Fn(f64) -> bool,
    place: impl Fn() -> String,
) -> Result<(), ModelError> {
    match numbers.into_iter().find(|value| !is_right(**value)) {
        Some(&value) => Err(ModelError::Number { place: place(), value }),
        None => Ok(()),
    }
}
