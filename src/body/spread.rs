//! What the places of the joints in the flesh leave open: of points, and of the angles between bones.
//!
//! What is seen is flesh. Where in it a joint lies is known to [`Part::sd_m`](super::Part::sd_m), where an exported point lies to
//! [`NamedPoint::sd_m`](super::NamedPoint::sd_m). Let them lie δ from where the model has them. The bone of part p, L from its
//! own joint to the next part's, then points elsewhere in its flesh: against the flesh it is turned by
//!
//! ω_p = L × (δ_end − δ_start)/‖L‖²
//!
//! (not about itself: that, the flesh shows). Angles are those of the bones. A fit brings its flesh to where the person's is, so its
//! bones are off by e_p = ρ + Σ aⱼ dθⱼ, over the joints j that carry p with their axes a, ρ the root's, as near to ω_p as
//! the joints allow: a shank cannot be tilted sideways against its thigh, so a thigh that turns about itself takes that up, and
//! turns the farther the straighter the knee is. dθ is where
//!
//! Σ_p (e_p − ω_p)ᵀ W_p (e_p − ω_p),  W_p = 1 − (1 − w)·uuᵀ
//!
//! is least, u the bone's direction: flesh about a bone is nearly round, and shows a turn about it w times as well as other turns.
//! Flesh without a bone shows all alike. dθ is linear in the δ, which are independent: to first order.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::{BodyModel, JointId, Layout, PartId, Posed};

/// w: sections of limbs depart from circles about the bone by about a centimetre, which shows a turn about it; a turn of the
/// bone shows by a lever of L/√12, eight: (1/8)² (E).
const ABOUT_ITSELF: f64 = 0.015;

impl Posed<'_> {
    /// Covariance in the world of where an exported point lies in the flesh, square metres.
    pub fn point_spread(&self, index: usize) -> Matrix3<f64> {
        self.scattered(&self.axes_of_point(index), index)
    }

    /// Covariance in the world of the way between two exported points for where they lie in the flesh, square metres.
    ///
    /// A left point lies as the mirror image of the right one: δ of one is (δx, −δy, δz) of the other, each along the axes of its
    /// part. Others are independent.
    pub fn way_spread(&self, from: usize, to: usize) -> Matrix3<f64> {
        let are_pair = |&(right, left): &(usize, usize)| {
            (right, left) == (from, to) || (right, left) == (to, from)
        };
        if !self.model.point_pairs().iter().any(are_pair) {
            return self.point_spread(from) + self.point_spread(to);
        }
        let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0));
        let moved = self.axes_of_point(to) - self.axes_of_point(from) * mirror;
        self.scattered(&moved, to)
    }

    /// Axes of a point's (first) part in the world.
    fn axes_of_point(&self, index: usize) -> Matrix3<f64> {
        let first = self.model.points[index].places.first();
        let frame = first.map_or(self.frames[0], |(part, _)| *self.frame(*part));
        frame.world_from_frame
    }

    /// M·diag(sd²)·Mᵀ.
    fn scattered(&self, moved: &Matrix3<f64>, index: usize) -> Matrix3<f64> {
        let sd = &self.model.points[index].sd_m;
        moved * Matrix3::from_diagonal(&sd.component_mul(sd)) * moved.transpose()
    }

    /// Variance of each angle for where the ends of the bones lie in the flesh, square radians; by joint.
    pub fn angle_spread(&self) -> DVector<f64> {
        let layout = Layout::of(self.model);
        let unknowns = layout.motion();
        let bones = self.model.bones();
        // N dθ = B δ, δ in standard deviations; what nothing turns stays
        let mut normal = DMatrix::identity(unknowns, unknowns) * 1e-9;
        let mut pulls = DMatrix::zeros(unknowns, 3 * bones.len());
        for (part, end) in bones.into_iter().enumerate() {
            let start = PartId(part);
            let turns = self.rotation_jacobian(start);
            let turns = self.world_from_part(start) * turns.columns(0, unknowns);
            let Some(end) = end else {
                normal += turns.tr_mul(&turns);
                continue;
            };
            let along = self.origin_of_part(end) - self.origin_of_part(start);
            let length = along.norm().max(1e-6);
            let u = along / length;
            let weight = Matrix3::identity() - u * u.transpose() * (1.0 - ABOUT_ITSELF);
            let weighed = turns.tr_mul(&weight);
            normal += &weighed * &turns;
            let turned = weighed * (u.cross_matrix() / length);
            for (joint, sign) in [(end, 1.0), (start, -1.0)] {
                let sd = Matrix3::from_diagonal(&self.model.parts[joint.0].sd_m);
                let mut pull = pulls.columns_mut(3 * joint.0, 3);
                pull += &turned * (self.world_from_part(joint) * sd * sign);
            }
        }
        let solved = normal.cholesky().map(|factor| factor.solve(&pulls));
        let variance = |row: usize| solved.as_ref().map_or(0.0, |s| s.row(row).norm_squared());
        let angles = (layout.root()..unknowns).map(variance);
        DVector::from_iterator(unknowns - layout.root(), angles)
    }
}

impl BodyModel {
    /// How far publications leave open where in the flesh a part's joint lies: standard deviations along the part's axes,
    /// metres; what no pivot says, and the pivot's.
    pub fn scatter_m(&self, part: PartId) -> Vector3<f64> {
        let part = &self.parts[part.0];
        let covariance = &self.statistics.covariance;
        let mut variance = part.sd_m.component_mul(&part.sd_m);
        let pairs = part
            .pivot
            .iter()
            .flat_map(|a| part.pivot.iter().map(move |b| (a, b)));
        for (a, b) in pairs {
            let shared = covariance[(a.coefficient.0, b.coefficient.0)];
            variance += a.direction.component_mul(&b.direction) * shared;
        }
        variance.map(f64::sqrt)
    }

    /// The part at whose joint each part's bone ends, which begins at its own; none of a part without a joint of its own or
    /// without a part beyond, or that branches to both sides only.
    pub(crate) fn bones(&self) -> Vec<Option<PartId>> {
        let parents = self.part_parents();
        let own_joint = |part: usize| self.own_joints(part, parents[part]).first().copied();
        let is_middle = |joint: JointId| self.joints[joint.0].translation.value.y == 0.0;
        let bone = |part: usize| {
            own_joint(part)?;
            let beyond = (0..parents.len()).filter(|&child| parents[child] == Some(part));
            let beyond: Vec<(usize, JointId)> =
                beyond.filter_map(|c| Some((c, own_joint(c)?))).collect();
            let mut middle = beyond.iter().filter(|(_, joint)| is_middle(*joint));
            let next = match beyond.as_slice() {
                [only] => Some(only),
                _ => middle.next().filter(|_| middle.next().is_none()),
            };
            next.map(|(child, _)| PartId(*child))
        };
        (0..parents.len()).map(bone).collect()
    }

    /// The joints between a part and the one that carries it.
    pub(crate) fn own_joints(&self, part: usize, parent: Option<usize>) -> Vec<JointId> {
        let joint_of = |part: usize| self.parts[part].joint;
        let below = parent.and_then(joint_of);
        let mut own = self.chain(joint_of(part));
        let carried = own.iter().position(|&j| Some(j) == below);
        own.drain(..carried.map_or(0, |i| i + 1));
        own
    }
}
