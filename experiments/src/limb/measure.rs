//! How far a fitted arm is from the true one.

use maquette::body::metaball::{Field, THRESHOLD};
use maquette::body::{BodyModel, Posed};
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

/// Shoulder, elbow and wrist; points of a model that has none of such names are the origin.
pub fn joints(body: &Posed<'_>) -> [Point3<f64>; 3] {
    let points = body.points();
    let of = |name: &str| index(body.model, name).map_or_else(Point3::origin, |i| points[i]);
    ["Shoulder", "Elbow", "Wrist"].map(of)
}

fn index(model: &BodyModel, name: &str) -> Option<usize> {
    model.points.iter().position(|p| p.name.ends_with(name))
}

/// Fitted against true.
pub fn limb_errors(fitted: &Posed<'_>, truth: &Posed<'_>) -> LimbErrors {
    let (fit, real) = (joints(fitted), joints(truth));
    let bones = |[shoulder, elbow, wrist]: [Point3<f64>; 3]| [(shoulder, elbow), (elbow, wrist)];
    let (fit_bones, real_bones) = (bones(fit), bones(real));
    let fields = (Field::from_body(fitted), Field::from_body(truth));
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
            let ratio = radius(&fields.0, fit_bones[k]) / radius(&fields.1, real_bones[k]);
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

/// Mean over stations and directions of the way from the bone out to the skin, metres.
fn radius(field: &Field, (a, b): (Point3<f64>, Point3<f64>)) -> f64 {
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
            sum += way_out(field, &from, &direction.scale(1.0 / first.norm()));
        }
    }
    sum / (STATIONS.len() as f64 * f64::from(DIRECTIONS))
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
