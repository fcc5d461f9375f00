//! Offsets of the surface: what flesh, cloth, hair and shoes have that the model has not.
//!
//! The surface of a person lies b(p) outside that of the model, along its normal, at the place p of a part:
//!
//! b(p) = Σₖ φₖ(p) bₖ
//!
//! with coefficients bₖ in metres, constant over a recording; φ are the hat functions of a [`Grid`] of each part.
//!
//! A border point that lies d outside the model's outline lies d − b(p) outside the person's.
//!
//! p is a place of the *flesh*: the place that the mean body has there, in the axes of its part. What lies x from the centre of an
//! ellipsoid or metaball i, in the axes of its frame, is the mean body's place pᵢ = hᵢ + x, hᵢ its centre there. Where several metaballs of
//! a part meet, p is the mean of their pᵢ with their shares of the field. So lengths, and the places of joints, move flesh and
//! grid together. A grid in the part's own axes would slide over the flesh as they change, and the data would choose them by where its nodes fit
//! best: of a person who stands still, with arms akimbo, knees and hips were found 4 cm behind their places in the flesh, at 4.5 standard
//! deviations (see docs/decisions, 0026).

use nalgebra::{DMatrix, Matrix3, Point3, Vector3};

use super::offset_grid::{Grid, GridSide};
use super::{BodyModel, CoefficientId, Motion, PartId, Posed, Primitive, Shape};

/// The grids of all parts.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceOffsets {
    /// By part; `None` for a part without flesh.
    grids: Vec<Option<Grid>>,
    /// b₀.
    first: CoefficientId,
    /// The part of each coefficient; of mirror images, the right one.
    owners: Vec<PartId>,
}

/// b at a place, and what it depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offset {
    /// b(p), metres.
    pub value_m: f64,
    /// φ of the four coefficients that are not 0 there.
    pub slopes: [(CoefficientId, f64); 4],
    /// ∂b/∂p, in the part's axes.
    pub gradient: Vector3<f64>,
}

impl SurfaceOffsets {
    /// Standard deviation of bare flesh about a model that has its person's girths, metres.
    pub(crate) const FLESH_SD_M: f64 = 0.004;
    /// Grids for the parts of a model, measured on its mean body; their coefficients come after those that it has.
    pub(super) fn new(model: &BodyModel) -> Self {
        let mean = Shape(model.statistics.mean.clone());
        let straight = Motion::straight(model);
        let body = Posed::new(model, &mean, &straight);
        let pairs = model.part_pairs();

        let mut owners = Vec::new();
        let mut grids: Vec<Option<Grid>> = Vec::new();
        for part in (0..model.parts.len()).map(PartId) {
            let is_left = pairs.iter().any(|(_, left)| *left == part.0);
            let is_right = pairs.iter().any(|(right, _)| *right == part.0);
            let side = if is_right { GridSide::Right } else { GridSide::Middle };
            let grid = match is_left {
                true => None,
                false => flesh_box(&body, part).map(|ends| Grid::new(ends, side, owners.len())),
            };
            owners.extend(std::iter::repeat_n(part, grid.map_or(0, Grid::nodes)));
            grids.push(grid);
        }

        // the left ones are those of the right
        for (right, left) in pairs {
            grids[left] = grids[right].map(Grid::mirrored);
        }
        Self { grids, first: CoefficientId(model.coefficients.len()), owners }
    }

    /// Number of coefficients.
    pub fn count(&self) -> usize {
        self.owners.len()
    }

    /// The first of them.
    pub fn first(&self) -> CoefficientId {
        self.first
    }

    /// The part of each of them; of mirror images, the right one.
    pub fn owners(&self) -> &[PartId] {
        &self.owners
    }
}

impl BodyModel {
    /// The body of the joint optimum: its coefficients say also where its joints lie in the flesh (standard normal), and how far
    /// its surface lies outside (metres).
    pub fn detailed(&self) -> Self {
        let mut detailed = self.with_places();
        let mean = Shape(detailed.statistics.mean.clone());
        for primitive in detailed.ellipsoids.iter_mut().chain(&mut detailed.metaballs) {
            primitive.home = primitive.centre.at(&mean);
        }
        let offsets = SurfaceOffsets::new(&detailed);
        let names: Vec<String> =
            offsets.owners.iter().enumerate().map(|(k, part)| self.offset_name(k, *part)).collect();
        let count = offsets.count();
        let variance = SurfaceOffsets::FLESH_SD_M.powi(2);
        detailed.add_coefficients(&names, &DMatrix::from_diagonal_element(count, count, variance));
        detailed.offsets = Some(offsets);
        detailed
    }

    fn offset_name(&self, index: usize, part: PartId) -> String {
        format!("{} offset {index}", self.parts[part.0].name.trim_end_matches("_r"))
    }
}

/// The box around the flesh of a part in its own axes: its least and greatest x, y, z.
fn flesh_box(body: &Posed<'_>, part: PartId) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let (primitives, size) = body.solids();
    let part_from_world = body.world_from_part(part).transpose();
    let own = primitives.iter().filter(|primitive| primitive.part == part);
    let boxes = own.map(|primitive| {
        let solid = body.primitive(primitive);
        let centre = body.in_part(part, &solid.centre.into());
        let shape: Matrix3<f64> = part_from_world * solid.shape * part_from_world.transpose();
        let half = shape.diagonal().map(f64::sqrt) * size;
        (centre - half, centre + half)
    });
    boxes.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)))
}

impl Posed<'_> {
    /// The greatest b anywhere on a part, metres, not less than 0.
    pub(crate) fn greatest_offset_m(&self, part: PartId) -> f64 {
        let Some(offsets) = &self.model.offsets else { return 0.0 };
        let Some(grid) = offsets.grids[part.0] else { return 0.0 };
        let all = self.shape.0.rows(offsets.first.0, offsets.count());
        all.rows_range(grid.coefficients()).max().max(0.0)
    }

    /// The place that the mean body has so far from the centre of a primitive, in the axes of its part.
    pub(crate) fn home(
        &self,
        primitive: &Primitive,
        from_centre_world: &Vector3<f64>,
    ) -> Vector3<f64> {
        primitive.home + self.world_from_frame_of(primitive).tr_mul(from_centre_world)
    }

    /// Orientation of the frame of a primitive in the world.
    pub(crate) fn world_from_frame_of(&self, primitive: &Primitive) -> Matrix3<f64> {
        self.frames[primitive.frame.0].world_from_frame
    }

    /// b at a place of the world on a part: that of the mean of the places by its metaballs, or where the body has none by its ellipsoids,
    /// each with its share exp(−2d) of a field; `None` for a model without offsets and a part without flesh.
    pub(crate) fn surface_offset_at(&self, part: PartId, place: &Point3<f64>) -> Option<Offset> {
        let primitives = match self.model.metaballs.as_slice() {
            [] => &self.model.ellipsoids,
            metaballs => metaballs,
        };
        let own = primitives.iter().filter(|primitive| primitive.part == part);
        let near = own.filter_map(|primitive| {
            let solid = self.primitive(primitive);
            let x = place.coords - solid.centre;
            let distance = x.dot(&solid.shape.cholesky()?.solve(&x));
            Some((distance, self.home(primitive, &x)))
        });
        let near: Vec<(f64, Vector3<f64>)> = near.collect();

        let least = near.iter().map(|(distance, _)| *distance).fold(f64::INFINITY, f64::min);
        let share = |distance: &f64| (-2.0 * (distance - least)).exp();
        let weighted = near.iter().map(|(distance, home)| home * share(distance));
        let sum = weighted.reduce(|sum, home| sum + home)?;
        let total: f64 = near.iter().map(|(distance, _)| share(distance)).sum();
        self.surface_offset(part, &(sum / total))
    }

    /// b at a place of a part, as the mean body has it, in the part's axes; `None` for a model without offsets.
    pub fn surface_offset(&self, part: PartId, home: &Vector3<f64>) -> Option<Offset> {
        let offsets = self.model.offsets.as_ref()?;
        let cell = offsets.grids[part.0]?.cell(home);
        let coefficient = |node: usize| CoefficientId(offsets.first.0 + node);
        let slopes = cell.hats().map(|(node, phi)| (coefficient(node), phi));
        let value_m = slopes.iter().map(|(c, phi)| phi * self.shape.0[c.0]).sum();
        let gradient = cell.gradient(|node| self.shape.0[coefficient(node).0]);
        Some(Offset { value_m, slopes, gradient })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::DVector;

    use super::*;

    fn body() -> BodyModel {
        crate::io::model::load("human-ellipsoids", Path::new("")).unwrap().detailed()
    }

    fn part(model: &BodyModel, name: &str) -> PartId {
        PartId(model.parts.iter().position(|p| p.name == name).unwrap())
    }

    fn offset(model: &BodyModel, shape: &Shape, part: PartId, place: [f64; 3]) -> Offset {
        let rest = Motion::rest(model);
        Posed::new(model, shape, &rest).surface_offset(part, &place.into()).unwrap()
    }

    fn bumps(model: &BodyModel) -> Shape {
        let mut shape = Shape(model.statistics.mean.clone());
        let first = model.offsets.as_ref().unwrap().first().0;
        (first..shape.0.len()).for_each(|k| shape.0[k] = 1e-3 * (k as f64 * 2.9).sin());
        shape
    }

    #[test]
    fn the_hats_add_up_to_one_and_do_not_jump() {
        let model = body();
        let shape = bumps(&model);
        for name in ["thigh_r", "foot_l", "thorax", "head"] {
            let part = part(&model, name);
            let mut before: Option<f64> = None;
            for k in 0..2000 {
                let (sin, cos) = (k as f64 * 0.00315).sin_cos();
                let place = [0.07 * cos, 0.07 * sin, -0.2 + 0.0002 * k as f64];
                let offset = offset(&model, &shape, part, place);
                let sum: f64 = offset.slopes.iter().map(|(_, phi)| phi).sum();
                approx::assert_relative_eq!(sum, 1.0, epsilon = 1e-12);
                if let Some(before) = before {
                    assert!((offset.value_m - before).abs() < 2e-5, "{name} {k}");
                }
                before = Some(offset.value_m);
            }
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_offset() {
        let model = body();
        let shape = bumps(&model);
        for (name, place) in [
            ("thigh_r", [0.05, 0.03, -0.21]),
            ("foot_l", [0.08, 0.03, -0.02]),
            ("thorax", [-0.06, -0.09, 0.11]),
            ("shank_l", [-0.03, 0.02, -0.14]),
        ] {
            let part = part(&model, name);
            let numeric = crate::math::central_differences(3, 1e-6, |d| {
                let moved = [place[0] + d[0], place[1] + d[1], place[2] + d[2]];
                DVector::from_element(1, offset(&model, &shape, part, moved).value_m)
            });
            let analytic = offset(&model, &shape, part, place).gradient;
            assert!(analytic.norm() > 1e-3, "{name}: {analytic}");
            for k in 0..3 {
                approx::assert_relative_eq!(analytic[k], numeric[(0, k)], epsilon = 1e-8);
            }
        }
    }

    #[test]
    fn flesh_keeps_its_offset_when_the_place_of_a_joint_or_a_length_changes() {
        let model = crate::io::model::load("human-metaballs", Path::new("")).unwrap().detailed();
        let thigh = part(&model, "thigh_r");
        let of_thigh = model.metaballs.iter().filter(|ball| ball.part == thigh);
        let from_middle = |ball: &Primitive| (ball.centre.value.z + 0.2).abs();
        let nearer = |a: &&Primitive, b: &&Primitive| from_middle(a).total_cmp(&from_middle(b));
        let ball = of_thigh.min_by(nearer).unwrap();
        let rest = Motion::rest(&model);
        let beside = Vector3::new(0.07, -0.02, 0.03);
        let place = |body: &Posed<'_>| Point3::from(body.primitive(ball).centre + beside);

        let shape = bumps(&model);
        let body = Posed::new(&model, &shape, &rest);
        let before = body.surface_offset_at(thigh, &place(&body)).unwrap().value_m;
        for (name, change) in [("thigh place forward", 4.0), ("thigh_length", 0.2)] {
            let mut shape = shape.clone();
            shape.0[model.coefficients.iter().position(|c| c == name).unwrap()] += change;
            let changed = Posed::new(&model, &shape, &rest);
            let slid =
                changed.in_part(thigh, &place(&changed)) - body.in_part(thigh, &place(&body));
            assert!(slid.norm() > 0.01, "{name}: the flesh moved by {slid} only");

            let off = |offset: Option<Offset>| (offset.unwrap().value_m - before).abs();
            let by_flesh = off(changed.surface_offset_at(thigh, &place(&changed)));
            let by_part = changed.in_part(thigh, &place(&changed));
            let by_part = off(changed.surface_offset(thigh, &by_part));
            assert!(by_part > 5e-5 && by_flesh < 0.4 * by_part, "{name}: {by_flesh} {by_part}");
        }
    }

    #[test]
    fn both_sides_are_alike() {
        let model = body();
        let shape = bumps(&model);
        let (right, left) = (part(&model, "shank_r"), part(&model, "shank_l"));
        let at = |part, y| offset(&model, &shape, part, [0.03, y, -0.21]).value_m;
        approx::assert_relative_eq!(at(right, 0.02), at(left, -0.02), epsilon = 1e-12);
        assert!((at(right, 0.02) - at(left, 0.02)).abs() > 1e-5);
        let trunk = part(&model, "abdomen");
        approx::assert_relative_eq!(at(trunk, 0.1), at(trunk, -0.1), epsilon = 1e-12);
    }
}
