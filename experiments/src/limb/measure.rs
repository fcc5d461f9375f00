//! How far a fitted arm is from the true one.

use maquette::body::metaball::{Field, THRESHOLD};
use maquette::body::{PartId, Posed};
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};

/// Places along a bone at which it is measured, as parts of its length.
const STATIONS: [f64; 5] = [0.2, 0.35, 0.5, 0.65, 0.8];
/// Directions about a bone in which its thickness is measured.
const DIRECTIONS: u32 = 12;
/// No arm is thicker, metres.
const THICKEST: f64 = 0.4;

/// Errors of one arm: upper arm, then forearm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimbErrors {
    /// Mean distance of the stations on the true bones from the fitted bones, mm.
    pub axis_mm: f64,
    /// Mean radius over the true one, less 1, in per cent.
    pub width_pct: [f64; 2],
    /// Length less the true one, mm.
    pub length_mm: [f64; 2],
    /// Angle between fitted and true bone, degrees.
    pub direction_deg: [f64; 2],
    /// Bend of the elbow less the true one, degrees.
    pub elbow_deg: f64,
    /// Mean distance of shoulder, elbow and wrist, mm.
    pub joints_mm: f64,
}

/// Which arm of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arm {
    /// The only one, of a model that is an arm.
    Only,
    /// The right one of a person.
    Right,
    /// The left one of a person.
    Left,
}

impl Arm {
    /// What the names of its points begin with, and those of its parts end with.
    fn affixes(self) -> (&'static str, &'static str) {
        match self {
            Self::Only => ("", ""),
            Self::Right => ("R", "_r"),
            Self::Left => ("L", "_l"),
        }
    }

    /// The names of shoulder, elbow and wrist.
    pub fn joint_names(self) -> [String; 3] {
        ["Shoulder", "Elbow", "Wrist"].map(|joint| format!("{}{joint}", self.affixes().0))
    }
}

/// Shoulder, elbow and wrist; points of a model that has none of such names are the origin.
pub fn joints(body: &Posed<'_>) -> [Point3<f64>; 3] {
    joints_of(body, Arm::Only)
}

/// Shoulder, elbow and wrist of one arm; as [`joints`].
fn joints_of(body: &Posed<'_>, arm: Arm) -> [Point3<f64>; 3] {
    let (points, names) = (body.points(), &body.model.points);
    let of = |name: String| {
        names.iter().position(|p| p.name == name).map_or_else(Point3::origin, |i| points[i])
    };
    arm.joint_names().map(of)
}

/// Fitted against true.
pub fn limb_errors(fitted: &Posed<'_>, truth: &Posed<'_>) -> LimbErrors {
    arm_errors(fitted, truth, Arm::Only)
}

/// Fitted against true, of one arm.
pub fn arm_errors(fitted: &Posed<'_>, truth: &Posed<'_>, arm: Arm) -> LimbErrors {
    let (fit, real) = (joints_of(fitted, arm), joints_of(truth, arm));
    let bones = |[shoulder, elbow, wrist]: [Point3<f64>; 3]| [(shoulder, elbow), (elbow, wrist)];
    let (fit_bones, real_bones) = (bones(fit), bones(real));
    let (fit_limb, real_limb) = (Limb::new(fitted, arm), Limb::new(truth, arm));
    let both = |value: &dyn Fn(usize) -> f64| [value(0), value(1)];
    let along = |(a, b): (Point3<f64>, Point3<f64>)| b - a;
    let stations = (0..2).flat_map(|k| {
        let (a, b) = real_bones[k];
        STATIONS.map(|u| distance_to(fit_bones[k], &(a + (b - a) * u)))
    });
    let bend = |[upper, fore]: [(Point3<f64>, Point3<f64>); 2]| along(upper).angle(&along(fore));
    let each = fit.iter().zip(&real).map(|(a, b)| (a - b).norm());
    LimbErrors {
        axis_mm: 1000.0 * stations.sum::<f64>() / (2 * STATIONS.len()) as f64,
        width_pct: both(&|k| {
            let ratio = fit_limb.radius(k, fit_bones[k]) / real_limb.radius(k, real_bones[k]);
            100.0 * (ratio - 1.0)
        }),
        length_mm: both(&|k| 1000.0 * (along(fit_bones[k]).norm() - along(real_bones[k]).norm())),
        direction_deg: both(&|k| along(fit_bones[k]).angle(&along(real_bones[k])).to_degrees()),
        elbow_deg: (bend(fit_bones) - bend(real_bones)).to_degrees(),
        joints_mm: 1000.0 * each.sum::<f64>() / 3.0,
    }
}

/// Distance of a point from a segment.
fn distance_to((a, b): (Point3<f64>, Point3<f64>), point: &Point3<f64>) -> f64 {
    let along = b - a;
    let place = (point - a).dot(&along) / along.norm_squared();
    (point - (a + along * place.clamp(0.0, 1.0))).norm()
}

/// The flesh of an arm.
struct Limb<'a> {
    body: &'a Posed<'a>,
    field: Field,
    /// Upper arm and forearm.
    parts: [Option<PartId>; 2],
}

impl<'a> Limb<'a> {
    fn new(body: &'a Posed<'a>, arm: Arm) -> Self {
        let part = |name: &str| {
            let name = format!("{name}{}", arm.affixes().1);
            body.model.parts.iter().position(|part| part.name == name).map(PartId)
        };
        Self { body, field: Field::from_body(body), parts: ["upper_arm", "forearm"].map(part) }
    }

    /// Mean over stations and directions of the way from the bone out to the surface, metres: to the skin, and what lies on it.
    fn radius(&self, bone: usize, (a, b): (Point3<f64>, Point3<f64>)) -> f64 {
        let Some(axis) = Unit::try_new(b - a, 1e-9) else {
            return f64::NAN;
        };
        let aside = if axis.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
        let first = axis.cross(&aside);
        let mut sum = 0.0;
        for station in STATIONS {
            let from = a + (b - a) * station;
            for k in 0..DIRECTIONS {
                let turn = std::f64::consts::TAU * f64::from(k) / f64::from(DIRECTIONS);
                let direction = UnitQuaternion::from_axis_angle(&axis, turn) * first;
                let direction = direction.scale(1.0 / first.norm());
                let way = way_out(&self.field, &from, &direction);
                sum += way + self.offset(bone, &(from + direction * way));
            }
        }
        sum / (STATIONS.len() as f64 * f64::from(DIRECTIONS))
    }

    /// How far outside the skin the surface is, metres.
    fn offset(&self, bone: usize, place: &Point3<f64>) -> f64 {
        let offset = self.parts[bone]
            .and_then(|part| self.body.surface_offset(part, &self.body.in_part(part, place)));
        offset.map_or(0.0, |offset| offset.value_m)
    }
}

/// How far a point can go in a direction before it is out of the skin; 0 if it is out already.
fn way_out(field: &Field, from: &Point3<f64>, direction: &Vector3<f64>) -> f64 {
    let is_inside = |t: f64| field.value(&(from.coords + direction * t)) >= THRESHOLD;
    let step = 0.002;
    let most = (THICKEST / step) as u32;
    let steps = (0..most).find(|k| !is_inside(f64::from(*k) * step));
    let (mut low, mut high) = match steps {
        Some(0) => return 0.0,
        Some(k) => (f64::from(k - 1) * step, f64::from(k) * step),
        None => return THICKEST,
    };
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        if is_inside(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Where the skin is on both sides of each bone, along the part of `side` that is across the bone.
pub fn edges(body: &Posed<'_>, side: &Vector3<f64>) -> Vec<Vec<Point3<f64>>> {
    let field = Field::from_body(body);
    let [shoulder, elbow, wrist] = joints(body);
    let mut edges = Vec::new();
    for (a, b) in [(shoulder, elbow), (elbow, wrist)] {
        let along = b - a;
        let across = side - along * (side.dot(&along) / along.norm_squared());
        let Some(across) = across.try_normalize(1e-6) else {
            continue;
        };
        for direction in [across, -across] {
            let stations = (0..=40).map(|k| a + along * (f64::from(k) / 40.0));
            edges.push(
                stations
                    .map(|from| from + direction * way_out(&field, &from, &direction))
                    .collect(),
            );
        }
    }
    edges
}
