//! The limb that a point is compared with, and the residual there.
//!
//! The skin is that of all limbs together, so a point is compared with the limb whose surface it is least outside of: the distance of
//! a union of bodies. Which limbs may be that one is told by the first-order distance of
//! [`Residual::Metric`](super::Residual::Metric), which is right to a third.

use nalgebra::Vector3;

use super::foot::Foot;
use super::part_offset::{PartOffset, displace, offset_m};
use super::skin_distance::{Derivatives, PosedScale, Residual, SkinResidual};
use super::skin_term::TouchPlace;
use super::{PointOptions, PointResidual, SurfacePoint};
use crate::body::Posed;
use crate::body::metaball::{Field, FieldSample, Sampler};

/// Limbs whose skin is farther away than this and this share of the distance, by about, are not looked at, metres.
const MARGIN_M: f64 = 0.02;
const MARGIN: f64 = 0.15;

/// Where a point meets the person.
#[derive(Debug, Default)]
pub(super) struct Meeting {
    pub(super) sample: FieldSample,
    pub(super) offsets: Vec<PartOffset>,
}

/// The residual of a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Met {
    pub(super) residual: SkinResidual,
    pub(super) sigma_m: f64,
    pub(super) place: TouchPlace<'static>,
}

/// The search for the limb that a point belongs to.
pub(super) struct NearestLimb<'a> {
    body: &'a Posed<'a>,
    field: &'a Field,
    scale: &'a PosedScale<'a>,
    options: PointOptions,
    sampler: Sampler<'a>,
    pub(super) met: Meeting,
    other: Meeting,
}

impl<'a> NearestLimb<'a> {
    pub(super) fn new(
        body: &'a Posed<'a>,
        field: &'a Field,
        scale: &'a PosedScale<'a>,
        options: PointOptions,
    ) -> Self {
        let sampler = Sampler::new(field);
        let (met, other) = (Meeting::default(), Meeting::default());
        Self { body, field, scale, options, sampler, met, other }
    }

    /// The residual of a point on the limb that it is nearest to, with `met` there; `None` for a body without metaballs.
    pub(super) fn meet(&mut self, point: &SurfacePoint) -> Option<Met> {
        let x = &point.position_world.coords;
        match self.options.residual {
            PointResidual::Distance => self.find(x).map(|foot| self.met_at(point, &foot)),
            PointResidual::Field => {
                self.sampler.sample(x, &mut self.met.sample).then(|| self.meet_field(point))
            }
        }
    }

    /// By the field at the point itself, which `met` has sampled.
    fn meet_field(&mut self, point: &SurfacePoint) -> Met {
        let Self { body, field, scale, options, met, .. } = self;
        let metaballs = &field.limbs[met.sample.limb];
        displace(body, field, metaballs, &mut met.sample, &mut met.offsets);
        Met {
            residual: scale.residual(Residual::Field, Derivatives::Complete, &met.sample),
            sigma_m: point.mean_sigma_m().hypot(options.sigma_m),
            place: TouchPlace::Fixed,
        }
    }

    /// The foot of a point on the limb whose surface it is least outside of; `met` is there.
    fn find(&mut self, x: &Vector3<f64>) -> Option<(Foot, f64)> {
        self.sampler.turn_to(x);
        let about_m = |limb: usize| {
            let (log_value, ball) = self.sampler.limb_value(limb)?;
            Some((self.scale.about_m(log_value, ball), limb))
        };
        let limbs = (0..self.field.limbs.len()).filter_map(about_m);
        let mut limbs: Vec<(f64, usize)> = limbs.collect();
        limbs.sort_by(|a, b| a.0.total_cmp(&b.0));

        let mut least: Option<(Foot, f64)> = None;
        for (about_m, limb) in limbs {
            let least_m = least.map_or(f64::INFINITY, |(_, r)| r);
            if about_m > least_m + MARGIN_M + MARGIN * least_m.abs() {
                break;
            }
            let found = self.foot_on(limb, x).filter(|f| f.1 < least_m);
            if found.is_some() {
                least = found;
                std::mem::swap(&mut self.met, &mut self.other);
            }
        }
        least
    }

    /// The residual of a point with a foot, whose σ is along the normal.
    fn met_at(&self, point: &SurfacePoint, (foot, distance_m): &(Foot, f64)) -> Met {
        let along = point.covariance * foot.normal;
        let variance = foot.normal.dot(&along) + self.options.sigma_m * self.options.sigma_m;
        Met {
            residual: SkinResidual { distance_m: *distance_m, alpha: 0.0, gamma: 0.0 },
            sigma_m: variance.sqrt(),
            place: TouchPlace::Foot { foot: *foot, by_normal: along * (-distance_m / variance) },
        }
    }

    /// The foot of a point on a limb and how far outside the person's surface the point lies; `other` is there then.
    fn foot_on(&mut self, limb: usize, x: &Vector3<f64>) -> Option<(Foot, f64)> {
        let Self { body, field, scale, sampler, other, .. } = self;
        let metaballs = sampler.sample_limb(limb, x, &mut other.sample);
        let foot = Foot::find(field, scale.of_model(), metaballs, &mut other.sample)?;
        let b_m = offset_m(body, field, &other.sample, &mut other.offsets);
        Some((foot, foot.distance_m - b_m))
    }
}
