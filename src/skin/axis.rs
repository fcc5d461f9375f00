//! The axis of a tube, rounded at the joints so that its cross-sections do not cross in a bent knee or elbow.

use nalgebra::{Unit, UnitQuaternion, Vector3};

use super::flesh::{Flesh, Hit};

/// Radius of a rounded joint, over that of the flesh on the inner side of the bend.
const ROOM: f64 = 1.25;
/// Farthest distance at which the skin on the inner side is looked for, metres.
const THICKEST: f64 = 0.12;
/// Largest share of a segment that the rounding of one joint takes, at a free end and between two joints.
const SHARES: [f64; 2] = [0.75, 0.45];
/// Largest angle between two cross-sections of a bend, radians.
const FINEST_TURN: f64 = 0.3;
/// Angles at which the cross-sections of a rounded tip stand, radians from its rim.
const TIP: [f64; 6] = [0.0, 0.3, 0.6, 0.88, 1.14, 1.38];

/// A plane of section with its axes: `along` is its normal, angles count from `right` counter-clockwise about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub(super) origin: Vector3<f64>,
    pub(super) along: Vector3<f64>,
    pub(super) right: Vector3<f64>,
}

impl Frame {
    /// A frame whose angles count from near `right`, or from anywhere if that is along its normal.
    pub(super) fn new(origin: Vector3<f64>, along: Vector3<f64>, right: Vector3<f64>) -> Self {
        let flat = |v: Vector3<f64>| (v - along * v.dot(&along)).try_normalize(1e-6);
        let any = || Vector3::ith(along.iamin(), 1.0);
        let right = flat(right).or_else(|| flat(any())).unwrap_or(right);
        Self { origin, along, right }
    }

    /// The frame at another place with another normal, turned no more than it must.
    pub(super) fn carried(&self, origin: Vector3<f64>, along: Vector3<f64>) -> Self {
        // not Rotation3's: of two directions that differ by rounding alone, it takes the arc cosine of more than 1
        let turn = UnitQuaternion::rotation_between(&self.along, &along)
            .unwrap_or_else(|| UnitQuaternion::new(self.right * std::f64::consts::PI));
        Self::new(origin, along, turn * self.right)
    }

    /// The direction at an angle.
    pub(super) fn direction(&self, angle: f64) -> Vector3<f64> {
        let (sin, cos) = angle.sin_cos();
        self.right * cos + self.along.cross(&self.right) * sin
    }

    /// The angle at which a point is seen from the axis.
    pub(super) fn angle_of(&self, point: &Vector3<f64>) -> f64 {
        let to = point - self.origin;
        to.dot(&self.along.cross(&self.right)).atan2(to.dot(&self.right))
    }
}

/// A plane that rays do not cross; they come from the side from which `normal` points away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wall {
    pub(super) point: Vector3<f64>,
    pub(super) normal: Vector3<f64>,
}

/// A place on the axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Station {
    pub(super) origin: Vector3<f64>,
    pub(super) along: Vector3<f64>,
    pub(super) walls: Vec<Wall>,
}

/// A joint on the axis, rounded.
#[derive(Debug, Clone, Copy)]
struct Bend {
    /// Where the cross-sections of the bend meet.
    centre: Vector3<f64>,
    /// Axis about which they turn.
    axis: Unit<Vector3<f64>>,
    /// Angle by which they turn.
    angle: f64,
    /// Length of the segment before and after it that it takes.
    reach: f64,
    /// Radius of the flesh on the inner side.
    thickness: f64,
    /// The plane that halves the bend.
    halving: Wall,
}

/// An axis: nodes with straight segments between them, rounded at the inner nodes.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    nodes: Vec<Vector3<f64>>,
    /// One for each node; `None` at the ends and where the axis goes straight on.
    bends: Vec<Option<Bend>>,
}

impl Axis {
    /// The axis through nodes, the first and last of which are its ends; nodes within 1 cm of another are left out.
    pub(super) fn new(nodes: &[Vector3<f64>], flesh: &Flesh) -> Self {
        let mut kept: Vec<Vector3<f64>> = Vec::with_capacity(nodes.len());
        for (i, node) in nodes.iter().enumerate() {
            let is_far = |other: &Vector3<f64>| (other - node).norm() > 0.01;
            let is_last = i + 1 == nodes.len();
            // the last node stays: the one before it gives way
            if is_last && kept.len() > 1 && kept.last().is_some_and(|n| !is_far(n)) {
                kept.pop();
            }
            if is_last || kept.last().is_none_or(is_far) {
                kept.push(*node);
            }
        }

        let mut axis = Self { bends: vec![None; kept.len()], nodes: kept };
        for node in 1..axis.nodes.len().saturating_sub(1) {
            axis.bends[node] = axis.bend(node, flesh);
        }
        axis
    }

    /// Length and direction of the segment after a node.
    fn segment(&self, node: usize) -> (f64, Vector3<f64>) {
        let to = self.nodes[node + 1] - self.nodes[node];
        let length = to.norm();
        (length, to / length.max(1e-9))
    }

    /// The rounding of a node; `None` where the axis goes straight on.
    fn bend(&self, node: usize, flesh: &Flesh) -> Option<Bend> {
        let (before, a) = self.segment(node - 1);
        let (after, b) = self.segment(node);
        let inwards = (b - a).try_normalize(1e-3)?;
        let axis = Unit::try_new(a.cross(&b), 1e-6)?;
        let angle = a.angle(&b);

        // the thicker the flesh on the inner side, the larger the radius
        let thickness = match flesh.cast(&self.nodes[node], &inwards, THICKEST) {
            Hit::Skin(distance) | Hit::Flesh(distance) => distance,
            Hit::Nothing => 0.02,
        };

        // but no larger than the segments have room for
        let share = |is_end: bool| if is_end { SHARES[0] } else { SHARES[1] };
        let room = f64::min(before * share(node == 1), after * share(node + 2 == self.nodes.len()));
        let tangent = (0.5 * angle).tan();
        let reach = (ROOM * thickness * tangent).min(room);
        let radius = reach / tangent;

        let halving = Wall { point: self.nodes[node], normal: (a + b).try_normalize(1e-6)? };
        Some(Bend {
            centre: self.nodes[node] - a * reach + axis.cross(&a) * radius,
            axis,
            angle,
            reach,
            thickness,
            halving,
        })
    }

    /// Places on the axis for cross-sections, `spacing` apart, and closer together towards ends that are round.
    ///
    /// `rounding` are the radii of the two ends; 0 for an end that is open, where a station stands.
    pub(super) fn stations(&self, spacing: f64, rounding: [f64; 2]) -> Vec<Station> {
        let mut stations = Vec::new();
        let last = self.nodes.len().saturating_sub(2);
        for node in 0..=last {
            if let Some(bend) = &self.bends[node] {
                self.around_bend(node, bend, spacing, &mut stations);
            }

            // the straight part of the segment, without what its bends take
            let (length, along) = self.segment(node);
            let reach = |node: usize| self.bends[node].map_or(0.0, |b| b.reach);
            let (first, end) = (reach(node), length - reach(node + 1));
            let round = [
                if node == 0 { rounding[0] } else { 0.0 },
                if node == last { rounding[1] } else { 0.0 },
            ];

            for place in places(first, end, spacing, round) {
                stations.push(Station {
                    origin: self.nodes[node] + along * place,
                    along,
                    walls: self.walls(node, node + 1),
                });
            }
        }
        stations
    }

    /// A place 4 cm before an end (0 the first, 1 the last), or halfway on a shorter segment.
    pub(super) fn at_end(&self, end: usize) -> Station {
        let last = self.nodes.len().saturating_sub(2);
        let node = if end == 0 { 0 } else { last };
        let (length, along) = self.segment(node);
        let inset = f64::min(0.04, 0.5 * length);
        let place = if end == 0 { inset } else { length - inset };
        Station {
            origin: self.nodes[node] + along * place,
            along,
            walls: self.walls(node, node + 1),
        }
    }

    /// Stations within a bend, without those at its ends, which stand on the segments.
    fn around_bend(&self, node: usize, bend: &Bend, spacing: f64, stations: &mut Vec<Station>) {
        let (_, a) = self.segment(node - 1);
        let begin = self.nodes[node] - a * bend.reach - bend.centre;
        let outside = begin.norm() + bend.thickness;
        let steps = (bend.angle / FINEST_TURN).max(bend.angle * outside / spacing);
        let steps = steps.ceil() as usize;

        for step in 1..steps {
            let turned = bend.angle * step as f64 / steps as f64;
            let turn = UnitQuaternion::from_axis_angle(&bend.axis, turned);
            let from_centre = turn * begin;

            // rays end at the plane that halves the bend, and at its centre
            let is_before = turned < 0.5 * bend.angle;
            let mut walls = match is_before {
                true => self.walls(node - 1, node),
                false => self.walls(node, node + 1),
            };
            if let Some(inwards) = (-from_centre).try_normalize(1e-9) {
                walls.push(Wall { point: bend.centre, normal: inwards });
            }

            stations.push(Station { origin: bend.centre + from_centre, along: turn * a, walls });
        }
    }

    /// The planes that halve the bends at the two ends of a segment.
    fn walls(&self, before: usize, after: usize) -> Vec<Wall> {
        let back =
            self.bends[before].map(|bend| Wall { normal: -bend.halving.normal, ..bend.halving });
        let ahead = self.bends[after].map(|bend| bend.halving);
        back.into_iter().chain(ahead).collect()
    }
}

/// Places from one end of a segment to the other, both included unless they are round.
fn places(first: f64, end: f64, spacing: f64, rounding: [f64; 2]) -> Vec<f64> {
    let length = (end - first).max(0.0);
    let [near, far] = rounding.map(|r| r.min(0.45 * length));
    let (low, high) = (first + near, end - far);
    let steps = ((high - low) / spacing).ceil() as usize;

    let mut places = Vec::new();
    if near > 0.0 {
        let round = TIP[1..].iter().rev();
        places.extend(round.map(|angle| low - near * angle.sin()));
    }
    let between = (0..=steps).map(|i| low + (high - low) * i as f64 / steps.max(1) as f64);
    places.extend(between);
    if far > 0.0 {
        places.extend(TIP[1..].iter().map(|angle| high + far * angle.sin()));
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_carried_straight_on_stays_finite_whatever_the_last_bits_are() {
        for i in 0..2000 {
            let unit = |v: Vector3<f64>| v.try_normalize(0.0).unwrap();
            let way = unit(Vector3::new(f64::from(i).sin(), f64::from(i).cos(), 0.3));
            let nearly = unit(way + Vector3::new(3e-16, -2e-16, 4e-16));
            let frame = Frame::new(Vector3::zeros(), way, Vector3::x());
            let carried = frame.carried(Vector3::zeros(), nearly);
            approx::assert_relative_eq!(carried.right, frame.right, epsilon = 1e-7);
        }
    }
}
