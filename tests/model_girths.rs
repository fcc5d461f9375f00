//! The skin of the shipped bodies against the measurements that they were drawn from: docs/anthropometry.md.

use std::path::Path;

use maquette::body::metaball::{Field, THRESHOLD};
use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::io::model;
use maquette::math::quadric::Ellipsoid;
use nalgebra::{Point2, Rotation3, Vector2, Vector3};

const LEG: &[&str] = &["foot_r", "shank_r", "thigh_r", "pelvis"];
const OTHER_LEG: &[&str] = &["foot_l", "shank_l", "thigh_l", "pelvis"];
const ARM: &[&str] = &["hand_r", "forearm_r", "upper_arm_r", "thorax"];
const TRUNK: &[&str] = &["thorax", "abdomen", "pelvis"];
const HEAD: &[&str] = &["head", "neck", "thorax"];

const DIRECTIONS: u32 = 72;

/// A cross-section of the mean body: where it is, and what is measured there, in metres; 0 is not measured.
struct Station {
    name: &'static str,
    /// The limbs that meet there.
    limbs: &'static [&'static [&'static str]],
    /// The part in whose frame the section is given.
    part: &'static str,
    inside: [f64; 3],
    /// The plane's turn about y, degrees.
    lean_deg: f64,
    girth: f64,
    breadth: f64,
    depth: f64,
}

const LEVEL: Station = Station {
    name: "",
    limbs: &[],
    part: "pelvis",
    inside: [0.0; 3],
    lean_deg: 0.0,
    girth: 0.0,
    breadth: 0.0,
    depth: 0.0,
};

/// Section 11 of docs/anthropometry.md. Heads and only heads carry 9 mm of hair.
#[rustfmt::skip]
const STATIONS: [Station; 18] = [
    Station { name: "hips", limbs: &[TRUNK, LEG, OTHER_LEG], inside: [0.0, 0.0, -0.03], girth: 1.022, breadth: 0.351, depth: 0.240, ..LEVEL },
    Station { name: "waist", limbs: &[TRUNK], part: "abdomen", inside: [0.01, 0.0, 0.015], girth: 0.901, breadth: 0.314, depth: 0.227, ..LEVEL },
    Station { name: "chest", limbs: &[TRUNK], part: "thorax", inside: [0.03, 0.0, 0.061], girth: 1.003, depth: 0.250, ..LEVEL },
    Station { name: "neck", limbs: &[HEAD], part: "neck", inside: [0.0, 0.0, 0.028], lean_deg: 22.0, girth: 0.364, ..LEVEL },
    Station { name: "head", limbs: &[HEAD], part: "head", inside: [0.015, 0.0, 0.045], breadth: 0.160, depth: 0.204, ..LEVEL },
    Station { name: "thigh at 20 %", limbs: &[LEG], part: "thigh_r", inside: [0.0, 0.0, -0.0825], girth: 0.618, ..LEVEL },
    Station { name: "thigh at 50 %", limbs: &[LEG], part: "thigh_r", inside: [0.0, 0.0, -0.206], girth: 0.528, ..LEVEL },
    Station { name: "thigh at 88 %", limbs: &[LEG], part: "thigh_r", inside: [0.0, 0.0, -0.363], girth: 0.407, ..LEVEL },
    Station { name: "knee", limbs: &[LEG], part: "shank_r", breadth: 0.106, depth: 0.118, ..LEVEL },
    Station { name: "calf", limbs: &[LEG], part: "shank_r", inside: [-0.016, 0.0, -0.125], girth: 0.381, ..LEVEL },
    Station { name: "ankle", limbs: &[LEG], part: "shank_r", inside: [-0.006, 0.0, -0.362], girth: 0.223, ..LEVEL },
    Station { name: "malleoli", limbs: &[LEG], part: "foot_r", inside: [-0.006, 0.0, 0.0], breadth: 0.072, ..LEVEL },
    Station { name: "biceps", limbs: &[ARM], part: "upper_arm_r", inside: [0.0, 0.0, -0.136], girth: 0.308, ..LEVEL },
    Station { name: "above the elbow", limbs: &[ARM], part: "upper_arm_r", inside: [0.0, 0.0, -0.231], girth: 0.258, ..LEVEL },
    Station { name: "elbow", limbs: &[ARM], part: "forearm_r", breadth: 0.078, ..LEVEL },
    Station { name: "forearm", limbs: &[ARM], part: "forearm_r", inside: [0.0, 0.0, -0.055], girth: 0.273, ..LEVEL },
    Station { name: "wrist", limbs: &[ARM], part: "hand_r", girth: 0.165, breadth: 0.044, depth: 0.060, ..LEVEL },
    Station { name: "hand", limbs: &[ARM], part: "hand_r", inside: [0.003, 0.0, -0.075], depth: 0.102, ..LEVEL },
];

fn human() -> (BodyModel, Shape, Motion) {
    let model = model::load("human-metaballs", Path::new("")).expect("shipped models are right");
    let shape = Shape(model.statistics.mean.clone());
    let mut motion = Motion::rest(&model);
    motion.angles.fill(0.0);
    // away from the trunk, so that an arm's section is the arm's
    for name in ["shoulder_abduction_r", "shoulder_abduction_l"] {
        motion.angles[model.joint(name).expect("it has shoulders").0] = 30_f64.to_radians();
    }
    (model, shape, motion)
}

/// The sum of the metaballs of some parts.
fn limb(body: &Posed<'_>, parts: &[&str]) -> Field {
    let model = body.model;
    let is_in = |part: usize| parts.contains(&model.parts[part].name.as_str());
    let balls = model.metaballs.iter().filter(|m| is_in(m.part.0));
    Field::new(balls.map(|m| body.primitive(m)))
}

/// The first place on a ray from inside where F falls to T, to a hundredth of a millimetre.
fn skin(value: impl Fn(&Vector3<f64>) -> f64, inside: &Vector3<f64>, ray: &Vector3<f64>) -> f64 {
    let outside = |t: f64| value(&(inside + ray * t)) < THRESHOLD;
    let step = 1e-3;
    let mut low = 0.0;
    assert!(!outside(low), "{inside} is not inside");
    while !outside(low + step) {
        low += step;
        assert!(low < 0.5, "no skin on the ray");
    }
    let mut high = low + step;
    while high - low > 1e-5 {
        let middle = 0.5 * (low + high);
        (low, high) = if outside(middle) { (low, middle) } else { (middle, high) };
    }
    0.5 * (low + high)
}

/// A frame whose origin and z axis a part has, from the part's three points in the model.
fn frame(body: &Posed<'_>, part: &str) -> (Vector3<f64>, Rotation3<f64>) {
    let model = body.model;
    let id = maquette::body::PartId(model.parts.iter().position(|p| p.name == part).expect(part));
    let at = |value: Vector3<f64>| {
        let place = maquette::body::ScaledVector::fixed(value);
        body.point(id, &place).coords
    };
    let origin = at(Vector3::zeros());
    let columns = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| at(axis) - origin);
    (origin, Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_columns(&columns)))
}

/// Girth as a tape measures it, breadth (along y) and depth of a section.
fn section(body: &Posed<'_>, station: &Station) -> [f64; 3] {
    let limbs: Vec<Field> = station.limbs.iter().map(|parts| limb(body, parts)).collect();
    let value = |p: &Vector3<f64>| limbs.iter().map(|f| f.value(p)).fold(0.0, f64::max);
    let (origin, turn) = frame(body, station.part);
    let inside = origin + turn * Vector3::from(station.inside);
    let lean = Rotation3::from_axis_angle(&Vector3::y_axis(), station.lean_deg.to_radians());
    let outline: Vec<Point2<f64>> = (0..DIRECTIONS)
        .map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(DIRECTIONS);
            let direction = Vector2::new(angle.cos(), angle.sin());
            let ray = turn * (lean * direction.push(0.0));
            Point2::from(direction * skin(value, &inside, &ray))
        })
        .collect();
    let extent = |k: usize| {
        let values = outline.iter().map(|p| p[k]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    [tape(&outline), extent(1), extent(0)]
}

/// Perimeter of the convex hull: a tape spans hollows (Cauchy: mean width times π).
fn tape(outline: &[Point2<f64>]) -> f64 {
    let count = 720;
    let width = |i: i32| {
        let angle = std::f64::consts::PI * f64::from(i) / f64::from(count);
        let direction = Vector2::new(angle.cos(), angle.sin());
        let along = outline.iter().map(|p| p.coords.dot(&direction));
        along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
    };
    std::f64::consts::PI * (0..count).map(width).sum::<f64>() / f64::from(count)
}

#[test]
fn cross_sections_have_the_girths_that_were_measured() {
    let (model, shape, motion) = human();
    let body = Posed::new(&model, &shape, &motion);
    for station in &STATIONS {
        let reached = section(&body, station);
        let targets = [station.girth, station.breadth, station.depth];
        for ((what, reached), target) in
            ["girth", "breadth", "depth"].iter().zip(reached).zip(targets)
        {
            let name = station.name;
            if target > 0.0 {
                assert!(
                    (reached / target - 1.0).abs() < 0.04,
                    "{name}: {what} {reached} m, expected {target}"
                );
            }
        }
    }
}

#[test]
fn the_skin_is_as_tall_as_the_ellipsoids_and_as_its_source() {
    let (model, shape, motion) = human();
    let body = Posed::new(&model, &shape, &motion);
    let (head, foot) = (limb(&body, HEAD), limb(&body, LEG));
    let centre = frame(&body, "head").0 + Vector3::new(0.01, 0.0, 0.07);
    let top = centre.z + skin(|p| head.value(p), &centre, &Vector3::z());
    let ankle = frame(&body, "foot_r").0;
    let sole = |x: f64| {
        let inside = ankle + Vector3::new(x, 0.0, -0.05);
        inside.z - skin(|p| foot.value(p), &inside, &-Vector3::z())
    };
    let sole = [-0.04, -0.02, 0.0, 0.1, 0.13].map(sole).into_iter().fold(f64::MAX, f64::min);
    let height = |sign: f64| {
        let each = body.ellipsoids().into_iter();
        each.map(|e| sign * e.centre.z + e.shape[(2, 2)].sqrt()).fold(f64::MIN, f64::max)
    };
    approx::assert_relative_eq!(top - sole, 1.70, epsilon = 0.017);
    approx::assert_relative_eq!(top - sole, height(1.0) + height(-1.0), epsilon = 0.012);
}

#[test]
fn the_left_skin_is_the_mirror_image_of_the_right() {
    let (model, shape, motion) = human();
    let body = Posed::new(&model, &shape, &motion);
    let field = Field::from_body(&body);
    for ball in &field.metaballs {
        let point = ball.ellipsoid.centre + Vector3::new(0.03, -0.05, 0.02);
        let mirrored = Vector3::new(point.x, -point.y, point.z);
        approx::assert_relative_eq!(field.value(&point), field.value(&mirrored), epsilon = 1e-12);
    }
}

#[test]
fn no_limb_has_a_hole() {
    let (model, shape, motion) = human();
    let body = Posed::new(&model, &shape, &motion);
    let place = |part: &str, at: [f64; 3]| {
        let (origin, turn) = frame(&body, part);
        origin + turn * Vector3::from(at)
    };
    let leg = [
        place("thigh_r", [0.0; 3]),
        place("shank_r", [0.0; 3]),
        place("foot_r", [0.0, 0.0, -0.01]),
    ];
    let foot = [leg[2], place("foot_r", [0.06, 0.0, -0.045]), place("foot_r", [0.165, 0.0, -0.06])];
    let arm =
        [place("upper_arm_r", [0.0; 3]), place("forearm_r", [0.0; 3]), place("hand_r", [0.0; 3])];
    let hand = [arm[2], place("hand_r", [0.003, 0.0, -0.14])];
    let trunk = [
        place("pelvis", [0.0, 0.0, -0.02]),
        place("abdomen", [0.02, 0.0, 0.0]),
        place("thorax", [0.02, 0.0, 0.0]),
        place("neck", [-0.01, 0.0, 0.0]),
        place("head", [0.01, 0.0, 0.09]),
    ];
    let lines: [(&[Vector3<f64>], &[&str]); 5] =
        [(&leg, LEG), (&foot, LEG), (&arm, ARM), (&hand, ARM), (&trunk[..3], TRUNK)];
    for (line, parts) in lines.into_iter().chain([(&trunk[2..], HEAD)]) {
        let field = limb(&body, parts);
        for ends in line.windows(2) {
            for i in 0..=50 {
                let point = ends[0].lerp(&ends[1], f64::from(i) / 50.0);
                assert!(
                    field.value(&point) > 1.0,
                    "{} at {point} of {parts:?}",
                    field.value(&point)
                );
            }
        }
    }
}

#[test]
fn every_ball_of_a_leg_and_of_the_trunk_can_shift_in_its_part() {
    let (model, ..) = human();
    assert!(model.coefficients.len() < 95, "{}", model.coefficients.len());
    for ball in &model.metaballs {
        let part = model.parts[ball.part.0].name.as_str();
        let mut shifts = ball.centre.shifts.iter();
        let shifts = shifts.any(|shift| shift.direction.x != 0.0);
        let fixed =
            part.starts_with("foot") || part.starts_with("hand") || part.starts_with("forearm");
        assert!(shifts || fixed, "{part}: {:?}", ball.centre);
    }
}

/// Section 6 of docs/anthropometry.md: .38 of the depth ahead of the olecranon's skin; and 35 mm, which is .42 of it.
#[test]
fn the_elbow_lies_as_far_ahead_of_the_skin_as_its_sources_have_it() {
    for name in ["human-metaballs", "human-ellipsoids"] {
        let model = model::load(name, Path::new("")).expect("shipped models are right");
        let shape = Shape(model.statistics.mean.clone());
        let mut motion = Motion::rest(&model);
        motion.angles.fill(0.0);
        let body = Posed::new(&model, &shape, &motion);
        let field = limb(&body, ARM);
        let ellipsoids = body.ellipsoids();
        // (p − c)ᵀ A⁻¹ (p − c) is 1 on an ellipsoid, F is T on the skin: either is enough
        let depth = |e: &Ellipsoid, p: &Vector3<f64>| {
            let factor = e.shape.cholesky().expect("it has a volume");
            THRESHOLD + 1.0 - (p - e.centre).dot(&factor.solve(&(p - e.centre)))
        };
        let deepest = |p: &Vector3<f64>| {
            let depths = ellipsoids.iter().map(|e| depth(e, p));
            depths.fold(field.value(p), f64::max)
        };
        let (elbow, turn) = frame(&body, "forearm_r");
        let [back, front] = [-1.0, 1.0].map(|x| skin(deepest, &elbow, &(turn * Vector3::x() * x)));
        let share = back / (back + front);
        assert!((0.38..0.42).contains(&share), "{name}: {share}");
    }
}

/// Skin or ellipsoids, whichever reaches further: how deep a point lies in these parts, T on the surface.
struct Flesh {
    skin: Vec<Field>,
    ellipsoids: Vec<Ellipsoid>,
}

impl Flesh {
    /// Of the limbs that meet at a station.
    fn at(body: &Posed<'_>, limbs: &[&[&str]]) -> Self {
        let of_limbs = |part: usize| limbs.concat().contains(&body.model.parts[part].name.as_str());
        let each = body.model.ellipsoids.iter().zip(body.ellipsoids());
        let ellipsoids = each.filter(|(e, _)| of_limbs(e.part.0)).map(|(_, e)| e).collect();
        let has_skin = !body.model.metaballs.is_empty();
        let skin = limbs.iter().filter(|_| has_skin).map(|parts| limb(body, parts)).collect();
        Self { skin, ellipsoids }
    }

    fn depth(&self, p: &Vector3<f64>) -> f64 {
        if !self.skin.is_empty() {
            return self.skin.iter().map(|f| f.value(p)).fold(0.0, f64::max);
        }
        // (p − c)ᵀ A⁻¹ (p − c) is 1 on an ellipsoid
        let depth = |e: &Ellipsoid| {
            let factor = e.shape.cholesky().expect("it has a volume");
            THRESHOLD + 1.0 - (p - e.centre).dot(&factor.solve(&(p - e.centre)))
        };
        self.ellipsoids.iter().map(depth).fold(f64::MIN, f64::max)
    }
}

/// Section 6 of docs/anthropometry.md: how far ahead of the line between the joints a section's middle lies, metres. Section 3: the
/// hip's centre is 91 mm behind the front. The skin follows the sections better than one or two ellipsoids can.
#[test]
fn flesh_lies_about_the_leg_s_joints_where_its_sources_have_it() {
    let thigh = |share: f64| ("thigh_r", [0.0, 0.0, -0.4125 * share]);
    let shank = |share: f64| ("shank_r", [0.0, 0.0, -0.4165 * share]);
    let trunk: &[&[&str]] = &[TRUNK, LEG, OTHER_LEG];
    let stations = [
        ("hips", ("pelvis", [0.0, 0.0, -0.02]), trunk, -0.029),
        ("middle of the thigh", thigh(0.5), &[LEG], 0.0),
        ("above the knee", thigh(0.85), &[LEG], 0.006),
        ("knee", shank(0.0), &[LEG], 0.007),
        ("calf", shank(0.3), &[LEG], -0.016),
        ("above the ankle", shank(0.9), &[LEG], -0.006),
    ];
    for (name, tolerance) in [("human-metaballs", 0.003), ("human-ellipsoids", 0.005)] {
        let model = model::load(name, Path::new("")).expect("shipped models are right");
        let shape = Shape(model.statistics.mean.clone());
        let mut motion = Motion::rest(&model);
        motion.angles.fill(0.0);
        let body = Posed::new(&model, &shape, &motion);
        for (station, (part, inside), limbs, ahead) in stations {
            let flesh = Flesh::at(&body, limbs);
            let (origin, turn) = frame(&body, part);
            // the buttocks reach furthest beside the middle
            let aside: &[f64] = if station == "hips" { &[-0.065, 0.0, 0.065] } else { &[0.0] };
            let reach = |sign: f64| {
                let rays = aside.iter().map(|y| {
                    let from = origin + turn * (Vector3::from(inside) + Vector3::y() * *y);
                    skin(|p| flesh.depth(p), &from, &(turn * Vector3::x() * sign))
                });
                rays.fold(0.0, f64::max)
            };
            let (front, back) = (reach(1.0), reach(-1.0));
            let found = 0.5 * (front - back);
            assert!((found - ahead).abs() < tolerance, "{name}, {station}: {found} m, not {ahead}");
            let hip = station != "hips" || (front - 0.091).abs() < 0.005;
            assert!(hip, "{name}: the hip's centre lies {front} m behind the front");
        }
    }
}
