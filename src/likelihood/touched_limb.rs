//! The limb that a line of sight touches, and whether it shares the border there ([`shared_border`](super::shared_border)).
//!
//! Limbs do not blend, and each has its own summit on the line. The line touches the limb whose r is least. That is not always the
//! one with the largest F: the same F is another distance from a thick limb than from a thin one, and the person's surface may
//! lie further outside the model's on one than on the other ([`skin_term`](super::skin_term)). Chosen by F, r would jump where another limb comes to
//! be touched.

use nalgebra::Vector3;

use super::RayOptions;
use super::contact::RayField;
use super::part_offset::{PartOffset, displace};
use super::shared_border::SharedBorder;
use super::skin_distance::{PosedScale, SkinResidual};
use crate::body::metaball::{Field, FieldSample};
use crate::body::{PartId, Posed};

/// Where a line may touch the person.
#[derive(Debug, Default)]
pub(super) struct Contender {
    pub(super) sample: FieldSample,
    pub(super) offsets: Vec<PartOffset>,
}

/// The search for the limb that a line of sight touches.
pub(super) struct LimbSearch<'a> {
    body: &'a Posed<'a>,
    field: &'a Field,
    scale: &'a PosedScale<'a>,
    options: &'a RayOptions,
    near: Vec<usize>,
    pub(super) touched: Contender,
    other: Contender,
}

impl<'a> LimbSearch<'a> {
    pub(super) fn new(
        body: &'a Posed<'a>,
        field: &'a Field,
        scale: &'a PosedScale<'a>,
        options: &'a RayOptions,
    ) -> Self {
        let (touched, other) = (Contender::default(), Contender::default());
        Self { body, field, scale, options, near: Vec::new(), touched, other }
    }

    /// Finds the limb that a line is least outside of: `touched`, and r there; `None` if there is no metaball before the camera.
    pub(super) fn touch(
        &mut self,
        rays: &mut RayField,
        direction: &Vector3<f64>,
    ) -> Option<SkinResidual> {
        let residual = self.options.residual;
        // the nearest first, to rule out most of the others
        let nearest = rays.turn_to(direction)?;
        let others = (0..self.field.limbs.len()).filter(|limb| *limb != nearest);

        let mut least: Option<SkinResidual> = None;
        for limb in std::iter::once(nearest).chain(others) {
            let least_m = least.map_or(f64::INFINITY, |r| r.distance_m);
            let may_win = |most: f64| self.scale.least_m(residual, limb, most) < least_m;
            let Some(t) = rays.contact(limb, may_win) else { continue };

            let r = self.meet(rays, limb, &rays.point(direction, t));
            if r.distance_m < least_m {
                least = Some(r);
                std::mem::swap(&mut self.touched, &mut self.other);
            }
        }
        least
    }

    /// The residual where the person's surface lies beside the summit of a limb, of which `other` becomes the place.
    fn meet(&mut self, rays: &RayField, limb: usize, summit: &Vector3<f64>) -> SkinResidual {
        let Self { body, field, near, other, options, .. } = self;
        rays.near(limb, near);
        other.sample.update_limb(field, limb, summit, near);
        displace(body, field, near, &mut other.sample, &mut other.offsets);
        self.scale.residual(options.residual, options.derivatives, &self.other.sample)
    }

    /// Whether a line touches a part of a limb, and another part apart from it is within a distance.
    pub(super) fn shares(
        &mut self,
        border: &SharedBorder,
        rays: &mut RayField,
        direction: &Vector3<f64>,
        within_m: f64,
    ) -> bool {
        let touched = self.touch(rays, direction).and_then(|_| self.part(&self.touched));
        let Some(part) = touched.filter(|part| border.may_be_of(*part)) else { return false };

        let own = self.touched.sample.limb;
        let mut others = (0..self.field.limbs.len()).filter(|limb| *limb != own);
        others.any(|limb| {
            let may_be = |most| self.scale.least_m(self.options.residual, limb, most) < within_m;
            let Some(t) = rays.contact(limb, may_be) else { return false };
            let r = self.meet(rays, limb, &rays.point(direction, t));
            let is_beside = self.part(&self.other).is_some_and(|other| border.is_of(part, other));
            is_beside && r.distance_m < within_m
        })
    }

    /// The part that a contender is on.
    fn part(&self, contender: &Contender) -> Option<PartId> {
        let source = self.field.source(contender.sample.heaviest()?)?;
        Some(self.body.model.metaballs[source].part)
    }
}
