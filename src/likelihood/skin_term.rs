//! What lines of sight and points have in common: each touches the field at one place and gives one row of the normal equations.
//!
//! A person's surface lies b outside the model's ([`SurfaceOffsets`](crate::body::SurfaceOffsets)), so the residual at x is the
//! skin distance r at x − b n, n the normal outwards. Where parts meet, b = Σ Wₖ bₖ(pₖ): Wₖ is the sum of the weights w of the
//! metaballs of part k, and pₖ = Σ wᵢ pᵢ/Wₖ the place that x has in the mean body, by each of them. With u = ∂r/∂b, the derivative of r
//! along −n,
//!
//! dr/dθ = ∂r/∂θ at a fixed b + u Σ Wₖ (φ of bₖ) + u Σ wᵢ ∇bᵢ·(dx − vᵢ) + u Σ (bᵢ + ∇bᵢ·(pᵢ − pₖ) − b) wᵢ ∂ ln fᵢ/∂θ,
//!
//! dx the motion of x along its line, vᵢ that of metaball i with its centre past it, bᵢ and ∇bᵢ those of its part. The last two sums say
//! that the surface's unevenness is fixed to the flesh. x, where F is largest on a line, and the slopes of F are taken at x − b n: what
//! that leaves out is of second order in b.
//!
//! A point is compared by its foot ([`foot`](super::foot)), and there nothing is left out: the residual is r − b, b at the foot, and
//! the foot's own motion is in its row.

use nalgebra::{Point3, Vector2, Vector3};

use super::foot::Foot;
use super::limb_sums::LimbSums;
use super::offset_row::OffsetRow;
use super::part_offset::{PartOffset, home};
use super::skin_distance::{PosedScale, SkinResidual};
use super::{PlacedResidual, Source};
use crate::body::metaball::{BallChange, Field, FieldRow, FieldSample, FieldSlopes};
use crate::body::{Layout, PartId, Posed};
use crate::solver::{Loss, NormalEquations};

/// One observation where it touches the field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinTouch {
    /// Where it comes from.
    pub source: Source,
    /// Distance of the skin, positive where the place lies outside it, m.
    pub residual_m: f64,
    /// Its standard deviation, m.
    pub sigma_m: f64,
    /// The same in the unit of its source, see [`PlacedResidual::sigma`].
    pub sigma: f64,
    /// Number of independent observations that it stands for.
    pub weight: f64,
    /// See [`PlacedResidual::outward_px`].
    pub outward_px: Vector2<f64>,
    /// Where it touches.
    pub place_world: Point3<f64>,
    /// The metaball of largest weight there: index in [`Field::metaballs`].
    pub metaball: usize,
}

impl SkinTouch {
    /// Of a touch and the field there.
    pub(super) fn new(touch: &Touch<'_>, sample: &FieldSample) -> Self {
        Self {
            source: touch.source,
            residual_m: touch.residual.distance_m,
            sigma_m: touch.sigma_m,
            sigma: touch.sigma,
            weight: touch.weight,
            outward_px: touch.outward_px,
            place_world: Point3::from(sample.point_world),
            metaball: sample.heaviest().unwrap_or_default(),
        }
    }

    /// The same, placed on a part of the body.
    pub(super) fn placed(
        &self,
        body: &Posed<'_>,
        field: &Field,
        loss: Loss,
    ) -> Option<PlacedResidual> {
        let (part, place_part) = place(body, field, self.metaball, &self.place_world)?;
        let value = self.residual_m / self.sigma_m;
        Some(PlacedResidual {
            source: self.source,
            value,
            trust: loss.evaluate(value).1,
            sigma: self.sigma,
            weight: self.weight,
            outward_px: self.outward_px,
            part,
            place_part,
        })
    }
}

/// An observation at one state.
pub(super) struct Touch<'a> {
    pub(super) source: Source,
    /// Its position among the data of its source.
    pub(super) index: usize,
    pub(super) sigma_m: f64,
    pub(super) sigma: f64,
    pub(super) weight: f64,
    /// How many times its cost counts.
    pub(super) counts: f64,
    pub(super) outward_px: Vector2<f64>,
    pub(super) residual: SkinResidual,
    /// By how far the person's surface lies outside; empty for a model without offsets.
    pub(super) offsets: &'a [PartOffset],
    /// How the place moves with the body.
    pub(super) place: TouchPlace<'a>,
}

/// How the place where an observation touches the field moves with the body.
#[derive(Debug, Clone, Copy)]
pub(super) enum TouchPlace<'a> {
    /// It stays where it is.
    Fixed,
    /// It is the summit of F on a line of this direction.
    Summit(&'a Vector3<f64>),
    /// It is the foot of a point; r/σ changes besides by `by_normal`·dn for each 1/σ.
    Foot {
        /// The foot.
        foot: Foot,
        /// ∂/∂n, metres.
        by_normal: Vector3<f64>,
    },
}

/// A line along which the curvature of ln F is above this has no defined summit, 1/m².
const FLATTEST: f64 = -1e-3;

impl Touch<'_> {
    /// (ρ, what a row weighs in units of 1/m²), ρ with its weight.
    pub(super) fn loss(&self, loss: Loss) -> (f64, f64) {
        let (rho, slope) = loss.evaluate(self.residual.distance_m / self.sigma_m);
        let precision = 1.0 / (self.sigma_m * self.sigma_m);
        let weight = self.weight * self.counts;
        (weight * rho, weight * slope * precision)
    }

    /// b: what the place's own motion along its line adds.
    fn along(&self, field: &Field, sample: &FieldSample, changes: &[BallChange]) -> Vector3<f64> {
        // only the local length and the offset change with the motion: F is at its summit
        let changes_with =
            self.residual.gamma.abs() >= f64::MIN_POSITIVE || !self.offsets.is_empty();
        let TouchPlace::Summit(r) = self.place else {
            return Vector3::zeros();
        };
        if !changes_with {
            return Vector3::zeros();
        }
        let curvature = sample.log_curvature(field, r);
        if curvature > FLATTEST {
            return Vector3::zeros();
        }
        r * (-slope_in_space(sample, changes).dot(r) / curvature)
    }

    /// α and b of the distance from a foot, and of what the offset adds as the foot moves.
    fn foot_slopes(
        &self,
        field: &Field,
        sample: &FieldSample,
        changes: &mut [BallChange],
    ) -> Vector3<f64> {
        let TouchPlace::Foot { foot, by_normal } = &self.place else {
            return Vector3::zeros();
        };
        let by_place = slope_in_space(sample, changes);
        let row = foot.row(field, sample, 1.0, (by_normal, &by_place));
        for change in changes {
            change.alpha += row.alpha;
        }
        row.b
    }

    /// ∂r/∂b; what b changes with the metaballs is added to `changes`.
    fn linearize_offset(
        &self,
        body: &Posed<'_>,
        field: &Field,
        sample: &FieldSample,
        changes: &mut [BallChange],
    ) -> f64 {
        let inwards = sample.log_gradient.try_normalize(f64::MIN_POSITIVE);
        let Some(inwards) = inwards.filter(|_| !self.offsets.is_empty()) else {
            return 0.0;
        };
        let slope = match self.place {
            TouchPlace::Foot { .. } => -1.0,
            _ => slope_in_space(sample, changes).dot(&inwards),
        };

        // ∂wᵢ = wᵢ (∂ ln fᵢ − Σ wⱼ ∂ ln fⱼ), and places move with their metaballs
        let mean: f64 = self.offsets.iter().map(PartOffset::outside_m).sum();
        for (share, change) in sample.shares.iter().zip(changes) {
            change.alpha -= slope * mean;
            let Some((ball, home)) = home(body, field, sample, share) else { continue };
            let own = self.offsets.iter().find(|own| own.part == ball.part);
            let Some((own, offset)) = own.and_then(|own| Some((own, own.offset?))) else {
                continue;
            };
            let here = offset.value_m + offset.gradient.dot(&(home - own.home));
            change.alpha += slope * here;
            change.place += body.world_from_frame_of(ball) * offset.gradient * slope;
        }
        slope
    }
}

/// The gradient of a residual in its place.
fn slope_in_space(sample: &FieldSample, changes: &[BallChange]) -> Vector3<f64> {
    let each = sample.shares.iter().zip(changes);
    each.map(|(s, c)| (c.place - s.pull * (4.0 * c.alpha)) * s.weight).sum()
}

/// A likelihood whose observations touch the skin.
pub(super) trait SkinTerm {
    /// The robust loss.
    fn loss(&self) -> Loss;
    /// The scale that turns the field into a distance.
    fn scale(&self, body: &Posed<'_>, field: &Field) -> PosedScale<'_>;
    /// ∂ ln σ/∂p of what comes from a source, p the place of the body's root: how its standard deviation grows.
    fn sigma_slope(&self, _body: &Posed<'_>, _source: Source) -> Vector3<f64> {
        Vector3::zeros()
    }
    /// Calls `each` for every observation that touches the field, with the field there.
    fn touches(
        &self,
        body: &Posed<'_>,
        field: &Field,
        scale: &PosedScale<'_>,
        each: impl FnMut(&Touch<'_>, &FieldSample),
    );
}

/// The part of a metaball, and a place in its axes.
pub(super) fn place(
    body: &Posed<'_>,
    field: &Field,
    metaball: usize,
    place_world: &Point3<f64>,
) -> Option<(PartId, Vector3<f64>)> {
    let part = body.model.metaballs[field.source(metaball)?].part;
    Some((part, body.in_part(part, place_world)))
}

/// ½ Σ w ρ.
pub(super) fn cost(term: &impl SkinTerm, body: &Posed<'_>) -> f64 {
    let field = Field::from_body(body);
    let mut cost = 0.0;
    term.touches(body, &field, &term.scale(body, &field), |touch, _| {
        cost += 0.5 * touch.loss(term.loss()).0;
    });
    cost
}

/// The same, and its rows added to the equations.
pub(super) fn linearize(
    term: &impl SkinTerm,
    body: &Posed<'_>,
    equations: &mut NormalEquations,
) -> f64 {
    let field = Field::from_body(body);
    let slopes = FieldSlopes::new(body, &field);
    let mut sums = LimbSums::new(&slopes, equations.gradient.len());
    let mut cost = 0.0;
    let mut of_sigmas = Vector3::zeros();

    rows(term, body, &field, &slopes, |touch, row| {
        let (rho, weight) = touch.loss(term.loss());
        cost += 0.5 * rho;

        let residual_m = touch.residual.distance_m;
        of_sigmas -= term.sigma_slope(body, touch.source) * (weight * residual_m * residual_m);
        sums.add(row.limb, row.values, residual_m, weight);
        if row.offsets.iter().all(|offset| offset.is_free(equations)) {
            OffsetRow::add_own(row.offsets, residual_m, weight, equations);
            for offset in row.offsets {
                sums.add_offset(row.limb, row.values, offset, weight);
            }
        }
    });
    sums.add_to(&slopes, equations);
    if Layout::new(body.model).root() > 0 {
        let mut of_root = equations.gradient.fixed_rows_mut::<3>(0);
        of_root += of_sigmas;
    }
    cost
}

/// dr/dθ of one observation.
pub(super) struct SkinRow<'a> {
    pub(super) limb: usize,
    /// One for each of the limb's components.
    pub(super) values: &'a [f64],
    /// What the offsets of each part there add.
    pub(super) offsets: &'a [OffsetRow],
}

/// Calls `each` for every observation that touches the field.
pub(super) fn rows(
    term: &impl SkinTerm,
    body: &Posed<'_>,
    field: &Field,
    slopes: &FieldSlopes,
    mut each: impl FnMut(&Touch<'_>, &SkinRow<'_>),
) {
    let scale = term.scale(body, field);
    let layout = Layout::new(body.model);
    let mut row = FieldRow::default();
    let (mut changes, mut offsets) = (Vec::new(), Vec::new());

    term.touches(body, field, &scale, |touch, sample| {
        let shares = sample.shares.iter();
        changes.clear();
        changes.extend(shares.map(|share| scale.change(&touch.residual, field, share)));
        let slope = touch.linearize_offset(body, field, sample, &mut changes);
        let b = match touch.place {
            TouchPlace::Foot { .. } => touch.foot_slopes(field, sample, &mut changes),
            _ => touch.along(field, sample, &changes),
        };
        slopes.row_from_changes(sample, &changes, &b, &mut row);

        offsets.clear();
        let row_of =
            |own: &PartOffset| Some(OffsetRow::new(&own.offset?, layout, own.weight * slope));
        offsets.extend(touch.offsets.iter().filter_map(row_of));
        each(touch, &SkinRow { limb: sample.limb, values: &row.values, offsets: &offsets });
    });
}

/// Every observation that touches the field, in the order of the data.
pub(super) fn all_touches(term: &impl SkinTerm, body: &Posed<'_>) -> Vec<SkinTouch> {
    let field = Field::from_body(body);
    let mut all = Vec::new();
    term.touches(body, &field, &term.scale(body, &field), |touch, sample| {
        all.push(SkinTouch::new(touch, sample));
    });
    all
}

/// The same, placed on the parts of the body.
pub(super) fn placed(term: &impl SkinTerm, body: &Posed<'_>) -> Vec<PlacedResidual> {
    let field = Field::from_body(body);
    let mut all = Vec::new();
    term.touches(body, &field, &term.scale(body, &field), |touch, sample| {
        all.extend(SkinTouch::new(touch, sample).placed(body, &field, term.loss()));
    });
    all
}
