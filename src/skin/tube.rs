//! Control points of a tube's patch: rows of samples from one end to the other.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};

use super::SkinError;
use super::axis::{Axis, Frame, Station};
use super::flesh::{Flesh, Hit, TubeFlesh};
use super::plan::Chain;
use super::section::{Section, end};
use crate::body::{PartId, Posed};
use crate::math::quadric::Ellipsoid;

/// Distance between cross-sections, metres.
const SPACING: f64 = 0.02;
/// How far the first cross-section of a limb stands beyond its rim, over the rim's mean radius.
const CLEARANCE: f64 = 0.25;
/// The latest place of that cross-section on its segment, a share of its length.
const LATEST: f64 = 0.6;
/// Least share of the limb's own metaballs in F there.
const OWN: f64 = 0.7;
/// How far up the first segment of the trunk two legs separate, a share of its length.
const FORK: f64 = 0.75;
/// How far a joint between rim and limb bulges: length of the curve's tangents, over its chord.
const TANGENTS: [f64; 2] = [0.7, 1.0];

/// Rows of control points, each counter-clockwise about the way to the next.
#[derive(Debug, Clone)]
pub(super) struct Tube {
    pub(super) rows: Vec<Vec<Vector3<f64>>>,
    /// Rows between a rim and the first cross-section, the rim included.
    pub(super) joint: usize,
}

/// Where the parts of a chain begin, in the world.
pub(super) fn origin(body: &Posed<'_>, part: PartId) -> Vector3<f64> {
    body.origin_of_part(part).coords
}

/// The joints between the parts of a chain.
fn joints(body: &Posed<'_>, chain: &Chain) -> Vec<Vector3<f64>> {
    let is_child = |child: PartId, parent: PartId| {
        let joints = body.model.chain(body.model.parts[child.0].joint);
        let joint = body.model.parts[parent.0].joint;
        child != parent && joint.is_none_or(|j| joints.contains(&j))
    };
    let between = |pair: &[PartId]| match is_child(pair[1], pair[0]) {
        true => origin(body, pair[1]),
        false => origin(body, pair[0]),
    };
    chain.parts.windows(2).map(between).collect()
}

/// The trunk's samples, from where two legs separate, or from its one end, to the other.
pub(super) fn trunk(
    body: &Posed<'_>,
    chain: &Chain,
    flesh: &Flesh,
    around: usize,
) -> Result<Tube, SkinError> {
    // from the far end to between the hips, or to the other end
    let joints = joints(body, chain);
    let far = tip(body, chain, End::Last, joints.last().copied(), flesh)?;
    let hips = chain.fork().map(|pair| pair.map(|leg| origin(body, leg.parts[0])));
    let near = match hips {
        Some([a, b]) => {
            let middle = (a + b) * 0.5;
            let (to, share) = joints.first().map_or((far, 0.5 * FORK), |j| (*j, FORK));
            middle + (to - middle) * share
        }
        None => {
            let joint = joints.first().copied().unwrap_or(far);
            tip(body, chain, End::First, Some(joint), flesh)?
        }
    };
    let nodes: Vec<_> = std::iter::once(near).chain(joints).chain([far]).collect();
    let axis = Axis::new(&nodes, flesh);
    let along = (nodes[1] - nodes[0]).try_normalize(1e-9);
    let along = along.ok_or_else(|| thin(body, chain))?;

    // angles count from the front where there are legs: across the line between them
    let right = hips.map_or(Vector3::zeros(), |[a, b]| (b - a).cross(&along));
    let frame = Frame::new(near, along, right);

    let far_round = roundness(&axis.at_end(1), &frame, flesh);
    let near_round = match hips {
        Some(_) => 0.0,
        None => roundness(&axis.at_end(0), &frame, flesh),
    };
    let stations = axis.stations(SPACING, [near_round, far_round]);
    let sections = sections(body, chain, &stations, frame, flesh)?;

    let angles = (0..around).map(|j| TAU * j as f64 / around as f64);
    let angles: Vec<f64> = angles.collect();
    let mut rows = Vec::new();
    if hips.is_none() {
        rows.push(vec![near; around]);
    }
    rows.extend(sections.iter().filter_map(|s| s.samples(flesh, &angles)));
    rows.push(vec![far; around]);
    Ok(Tube { rows, joint: 0 })
}

/// A limb's samples: its rim, the joint, its cross-sections, its tip.
///
/// `straight_on` is the direction into the limb in a pose in which it does not bend; `None`: square to the rim.
pub(super) fn limb(
    body: &Posed<'_>,
    chain: &Chain,
    rim: &[Vector3<f64>],
    straight_on: Option<Vector3<f64>>,
    flesh: TubeFlesh<'_>,
) -> Result<Tube, SkinError> {
    let too_thin = || thin(body, chain);
    let own = flesh.own;
    let root = origin(body, chain.parts[0]);
    let joints = joints(body, chain);
    let last = joints.last().copied().unwrap_or(root);
    let far = tip(body, chain, End::Last, Some(last), own)?;
    let next = joints.first().copied().unwrap_or(far);
    let along = (next - root).try_normalize(1e-6).ok_or_else(too_thin)?;
    let (middle, outwards) = middle_and_normal(rim).ok_or_else(too_thin)?;

    // the axis, from the first cross-section to the tip
    let latest = LATEST * (next - root).norm();
    let mut nodes = vec![first_centre(&root, &along, rim, &middle, latest, own)];
    nodes.extend(joints);
    nodes.push(far);
    let axis = Axis::new(&nodes, own);

    // cross-sections, their angles carried over from the rim
    let straight_on = straight_on.unwrap_or(outwards);
    let rim_frame = Frame::new(middle, straight_on, rim[0] - middle);
    let frame = rim_frame.carried(nodes[0], along);
    let stations = axis.stations(SPACING, [0.0, roundness(&axis.at_end(1), &frame, own)]);
    let sections = sections(body, chain, &stations, frame, own)?;
    let angles = rim_angles(rim, &rim_frame);
    let mut samples = sections.iter().filter_map(|s| s.samples(own, &angles));
    let first = samples.next().ok_or_else(too_thin)?;

    let junction = Junction {
        middles: [middle, sections[0].frame.origin],
        ways: [outwards, along],
        rings: [rim, &first],
        turn: UnitQuaternion::rotation_between(&straight_on, &along)
            .unwrap_or_else(UnitQuaternion::identity),
    };
    let mut rows = vec![rim.to_vec()];
    rows.extend(junction.rows(flesh.with_base));
    let joint = rows.len();
    rows.push(first);
    rows.extend(samples);
    rows.push(vec![far; rim.len()]);
    Ok(Tube { rows, joint })
}

/// The middle of a limb's first cross-section: beyond all of the rim, and where the limb's own flesh is most of what there
/// is, at most `latest` from the root.
fn first_centre(
    root: &Vector3<f64>,
    along: &Vector3<f64>,
    rim: &[Vector3<f64>],
    middle: &Vector3<f64>,
    latest: f64,
    own: &Flesh,
) -> Vector3<f64> {
    let radius = rim.iter().map(|p| (p - middle).norm()).sum::<f64>() / rim.len() as f64;
    let heights = rim.iter().map(|p| (p - root).dot(along));
    let mut place = heights.fold(0.0, f64::max) + CLEARANCE * radius;
    while place < latest && own.own_share(&(root + along * place)) < OWN {
        place += SPACING;
    }
    root + along * place.min(latest)
}

/// Radius of a limb a quarter down its first segment, without the part that it grows out of; metres.
pub(super) fn root_radius(body: &Posed<'_>, chain: &Chain) -> f64 {
    let flesh = Flesh::new(body, chain).alone();
    let root = origin(body, chain.parts[0]);
    let next = joints(body, chain).first().copied();
    let next = next.or_else(|| tip(body, chain, End::Last, Some(root), &flesh).ok());
    let to = next.unwrap_or(root) - root;
    let along = to.try_normalize(1e-6).unwrap_or_else(Vector3::z);
    let station = Station { origin: root + to * 0.25, along, walls: Vec::new() };
    let frame = Frame::new(station.origin, along, Vector3::zeros());
    roundness(&station, &frame, &flesh)
}

/// Equal angles, turned as far as the points of a rim are on average.
fn rim_angles(rim: &[Vector3<f64>], frame: &Frame) -> Vec<f64> {
    let equal = |j: usize| TAU * j as f64 / rim.len() as f64;
    let ahead = |(j, p): (usize, &Vector3<f64>)| frame.angle_of(p) - equal(j);

    // the mean of angles is that of their directions
    let (mut sin, mut cos) = (0.0, 0.0);
    for angle in rim.iter().enumerate().map(ahead) {
        sin += angle.sin();
        cos += angle.cos();
    }

    let ahead = f64::atan2(sin, cos);
    (0..rim.len()).map(|j| ahead + equal(j)).collect()
}

/// What joins a rim to the first cross-section of a limb.
struct Junction<'a> {
    /// Middles of the two.
    middles: [Vector3<f64>; 2],
    /// The way into the rim, and on from the cross-section.
    ways: [Vector3<f64>; 2],
    /// Their points.
    rings: [&'a [Vector3<f64>]; 2],
    /// The turn from one to the other.
    turn: UnitQuaternion<f64>,
}

impl Junction<'_> {
    /// Rows between the two: rays from an axis that curves from middle to middle, in directions that turn from those of
    /// the rim to those of the cross-section. A ray that finds no skin near by ends where both would have it.
    fn rows(&self, flesh: &Flesh) -> Vec<Vec<Vector3<f64>>> {
        let [rim, ring] = self.rings;
        let count = rim.len() as f64;
        let chords = rim.iter().zip(ring).map(|(a, b)| (b - a).norm());
        let steps = (chords.sum::<f64>() / count / SPACING).ceil().max(3.0) as usize;
        let radii = rim.iter().map(|p| (p - self.middles[0]).norm());
        let radius = radii.sum::<f64>() / count;

        let rows = (1..steps).map(|step| {
            let t = step as f64 / steps as f64;
            let middle = self.middle(t);
            let pairs = rim.iter().zip(ring);
            let guesses = pairs.map(|(a, b)| self.direction(a, b, t));
            guesses.map(|to| middle + on_skin(flesh, &middle, to, radius)).collect()
        });
        rows.collect()
    }

    /// A Hermite curve from middle to middle.
    fn middle(&self, t: f64) -> Vector3<f64> {
        let [a, b] = self.middles;
        let chord = (b - a).norm();
        let [out, on] = [0, 1].map(|k| self.ways[k] * (TANGENTS[k] * chord));
        let (t2, t3) = (t * t, t * t * t);
        a * (2.0 * t3 - 3.0 * t2 + 1.0)
            + out * (t3 - 2.0 * t2 + t)
            + b * (3.0 * t2 - 2.0 * t3)
            + on * (t3 - t2)
    }

    /// From the axis to the guessed place of a point between one of the rim and one of the cross-section.
    fn direction(&self, a: &Vector3<f64>, b: &Vector3<f64>, t: f64) -> Vector3<f64> {
        let (first, last) = (a - self.middles[0], b - self.middles[1]);
        let lengths = [first.norm().max(1e-9), last.norm().max(1e-9)];
        let unturned = self.turn.inverse() * last;
        let between = first * ((1.0 - t) / lengths[0]) + unturned * (t / lengths[1]);
        let length = lengths[0] * (1.0 - t) + lengths[1] * t;
        self.turn.powf(t) * between * (length / between.norm().max(1e-3))
    }
}

/// From the middle to the skin, in the direction of the guess `to`; the guess itself where no skin is near it.
fn on_skin(flesh: &Flesh, middle: &Vector3<f64>, to: Vector3<f64>, radius: f64) -> Vector3<f64> {
    let distance = to.norm();
    let ray = to / distance.max(1e-9);
    let farthest = (2.5 * distance).min(1.6 * distance.max(radius));
    match flesh.cast(middle, &ray, farthest) {
        Hit::Skin(found) if found > 0.6 * distance => ray * found,
        _ => to,
    }
}

/// Middle of a loop of points, and the direction about which it runs counter-clockwise.
fn middle_and_normal(points: &[Vector3<f64>]) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let next = points.iter().cycle().skip(1);
    let twice: Vector3<f64> =
        points.iter().zip(next).map(|(a, b)| (a - middle).cross(&(b - middle))).sum();
    Some((middle, twice.try_normalize(1e-9)?))
}

/// The cross-sections at stations, angles carried along from `frame`; those without flesh are left out.
fn sections(
    body: &Posed<'_>,
    chain: &Chain,
    stations: &[Station],
    frame: Frame,
    flesh: &Flesh,
) -> Result<Vec<Section>, SkinError> {
    let mut neighbour = frame;
    let mut sections = Vec::with_capacity(stations.len());
    for station in stations {
        neighbour = neighbour.carried(station.origin, station.along);
        sections.extend(Section::at(station, &neighbour, flesh));
    }
    let enough = sections.len() >= 3 && 2 * sections.len() > stations.len();
    enough.then_some(sections).ok_or_else(|| thin(body, chain))
}

/// Mean radius of the cross-section a little before a tip, metres.
fn roundness(station: &Station, frame: &Frame, flesh: &Flesh) -> f64 {
    let radius = || {
        let section = Section::at(station, frame, flesh)?;
        let angles: Vec<f64> = (0..8).map(|k| TAU * f64::from(k) / 8.0).collect();
        let samples = section.samples(flesh, &angles)?;
        let radii = samples.iter().map(|p| (p - section.frame.origin).norm());
        Some(radii.sum::<f64>() / 8.0)
    };
    radius().unwrap_or(0.02)
}

/// The ends of a chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    First,
    Last,
}

/// The point of the skin at an end of a chain: of the end part's metaballs, the point farthest from its joint, and on
/// from there to the skin.
fn tip(
    body: &Posed<'_>,
    chain: &Chain,
    which: End,
    joint: Option<Vector3<f64>>,
    flesh: &Flesh,
) -> Result<Vector3<f64>, SkinError> {
    // the end part, or the nearest one before it that carries metaballs
    let carries = |part: &&PartId| body.model.metaballs.iter().any(|m| m.part == **part);
    let part = match which {
        End::First => chain.parts.iter().find(carries),
        End::Last => chain.parts.iter().rev().find(carries),
    };
    let too_thin = || thin(body, chain);
    let part = *part.ok_or_else(too_thin)?;
    let from = joint.unwrap_or_else(|| origin(body, part));

    let balls = body.model.metaballs.iter().filter(|m| m.part == part);
    let balls = balls.map(|m| body.primitive(m));
    let ends = balls.map(|ball| (ball.centre, farthest(&ball, &from)));
    let far = ends.max_by(|a, b| (a.1 - from).norm().total_cmp(&(b.1 - from).norm()));
    let (centre, point) = far.ok_or_else(too_thin)?;

    // on from the ball's middle to the skin of all
    let along = (point - centre).try_normalize(1e-9).ok_or_else(too_thin)?;
    let reach = end(flesh, &centre, &along).ok_or_else(too_thin)?;
    Ok(centre + along * reach)
}

/// The point of a metaball's own skin that is farthest from a place, by fixed-point iteration.
fn farthest(ball: &Ellipsoid, from: &Vector3<f64>) -> Vector3<f64> {
    let towards = (ball.centre - from).try_normalize(1e-9);
    let mut towards = towards.unwrap_or_else(Vector3::z);
    let mut point = ball.centre;
    for _ in 0..20 {
        let reach = towards.dot(&(ball.shape * towards)).max(1e-12).sqrt();
        point = ball.centre + ball.shape * towards * (0.59 / reach);
        towards = (point - from).try_normalize(1e-9).unwrap_or(towards);
    }
    point
}

/// The error that a chain has no skin all along.
pub(super) fn thin(body: &Posed<'_>, chain: &Chain) -> SkinError {
    let name = |part: &PartId| body.model.parts[part.0].name.as_str();
    let parts = match chain.parts.as_slice() {
        [first, .., last] => format!("parts {} to {}", name(first), name(last)),
        [only] => format!("part {}", name(only)),
        [] => String::new(),
    };
    SkinError::Thin { parts }
}
