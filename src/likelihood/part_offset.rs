//! By how far the person's surface lies outside the model's where parts meet: b = Σ Wₖ bₖ(pₖ), see [`skin_term`](super::skin_term).

use nalgebra::Vector3;

use crate::body::metaball::{Field, FieldSample, Share};
use crate::body::{Offset, PartId, Posed, Primitive};

/// Parts of which less than this is at a place say nothing of its offset.
const LEAST_WEIGHT: f64 = 1e-4;

/// What one part says of how far the person's surface lies outside, where an observation touches the skin: b = Σ W bₖ over the
/// parts, W the sum of the weights of a part's metaballs.
#[derive(Debug, Clone, Copy)]
pub(super) struct PartOffset {
    pub(super) part: PartId,
    /// W.
    pub(super) weight: f64,
    /// p: where the mean body has the place, in the part's axes.
    pub(super) home: Vector3<f64>,
    /// bₖ; none as long as p is summed up.
    pub(super) offset: Option<Offset>,
}

impl PartOffset {
    /// W bₖ, metres.
    pub(super) fn outside_m(&self) -> f64 {
        self.offset.map_or(0.0, |offset| self.weight * offset.value_m)
    }
}

/// Moves a sample from x to x − b n, n the normal outwards: the person's surface at x is the model's there. `offsets` receives b.
///
/// The residual of x − b n is not that of x less b: deep inside a limb the skin distance is shorter than a distance, and a fat
/// body with its surface far inside would seem to err less.
pub(super) fn displace(
    body: &Posed<'_>,
    field: &Field,
    metaballs: &[usize],
    sample: &mut FieldSample,
    offsets: &mut Vec<PartOffset>,
) {
    let b_m = offset_m(body, field, sample, offsets);
    let Some(inwards) = sample.log_gradient.try_normalize(f64::MIN_POSITIVE) else { return };
    if !offsets.is_empty() {
        sample.update_limb(field, sample.limb, &(sample.point_world + inwards * b_m), metaballs);
    }
}

/// By how far the person's surface lies outside the model's at a sample: b, metres. `offsets` receives what each part says.
pub(super) fn offset_m(
    body: &Posed<'_>,
    field: &Field,
    sample: &FieldSample,
    offsets: &mut Vec<PartOffset>,
) -> f64 {
    offsets.clear();
    if body.model.offsets.is_none() {
        return 0.0;
    }

    // the parts that are at the place, and where the mean body has it
    for share in sample.shares.iter().filter(|share| share.weight > LEAST_WEIGHT) {
        let Some((ball, home)) = home(body, field, sample, share) else { continue };
        let weighted = home * share.weight;
        match offsets.iter_mut().find(|own| own.part == ball.part) {
            Some(own) => {
                own.weight += share.weight;
                own.home += weighted;
            }
            None => offsets.push(PartOffset {
                part: ball.part,
                weight: share.weight,
                home: weighted,
                offset: None,
            }),
        }
    }
    for own in offsets.iter_mut() {
        own.home /= own.weight;
        own.offset = body.surface_offset(own.part, &own.home);
    }

    offsets.iter().map(PartOffset::outside_m).sum()
}

/// The metaball of a share in the model, and where the mean body has the place of the sample by it, in the axes of its part.
pub(super) fn home<'b>(
    body: &'b Posed<'_>,
    field: &Field,
    sample: &FieldSample,
    share: &Share,
) -> Option<(&'b Primitive, Vector3<f64>)> {
    let ball = &body.model.metaballs[field.source(share.metaball)?];
    let from_centre = sample.point_world - field.metaballs[share.metaball].ellipsoid.centre;
    Some((ball, body.home(ball, &from_centre)))
}
