//! How shape coefficients scale a length, and where a joint lies in the flesh.
//!
//! A part's `pivot` names coefficients that move its joint within flesh that stays in place.

use nalgebra::{Rotation3, Vector3};

use super::ModelFileError;
use super::build::Builder;
use super::side::Side;
use super::spec::PartSpec;
use crate::body::{CoefficientId, Scale, ScaledVector, Shift};

impl Builder<'_> {
    pub(super) fn scaled(
        &self,
        value: Vector3<f64>,
        names: Option<&[String; 3]>,
        side: Side,
        place: &str,
    ) -> Result<ScaledVector, ModelFileError> {
        let mut vector = ScaledVector::fixed(value);
        for (axis, text) in names.into_iter().flatten().enumerate() {
            match text.strip_prefix("shift:") {
                Some(name) => vector.shifts.push(self.shift(name, axis, side, place)?),
                None => vector.scale[axis] = self.scale(text, side, place)?,
            }
        }
        Ok(vector)
    }

    /// "" is fixed, "name" eˢ, "share:name" and "rest:name" the parts of a total.
    fn scale(&self, text: &str, side: Side, place: &str) -> Result<Scale, ModelFileError> {
        if text.is_empty() {
            return Ok(Scale::Fixed);
        }
        let (kind, name) = text.split_once(':').unwrap_or(("", text));
        match (kind, self.coefficient(name, side)) {
            ("", Some(id)) => Ok(Scale::Log(id)),
            ("share", Some(id)) => Ok(Scale::Share(id)),
            ("rest", Some(id)) => Ok(Scale::Rest(id)),
            _ => Err(self.missing(place, "coefficient", text)),
        }
    }

    /// s along one axis; the left side's is the mirror image.
    fn shift(
        &self,
        name: &str,
        axis: usize,
        side: Side,
        place: &str,
    ) -> Result<Shift, ModelFileError> {
        let coefficient = self.coefficient(name, side);
        Ok(Shift {
            coefficient: coefficient.ok_or_else(|| self.missing(place, "coefficient", name))?,
            direction: side.place(Vector3::ith(axis, 1.0).into()),
        })
    }

    /// A coefficient by its name in the file, on this side or of both.
    fn coefficient(&self, name: &str, side: Side) -> Option<CoefficientId> {
        let find = |wanted: &str| {
            let mut coefficients = self.model.coefficients.iter();
            coefficients.position(|c| c == wanted).map(CoefficientId)
        };
        find(&side.suffix(name)).or_else(|| find(name))
    }

    /// The shifts of a part's joint in the flesh, along the part's axes.
    pub(super) fn pivot(
        &self,
        spec: &PartSpec,
        side: Side,
        place: &str,
    ) -> Result<Vec<Shift>, ModelFileError> {
        let named = spec.pivot.iter().flatten().enumerate();
        let given = named.filter(|(_, name)| !name.is_empty());
        let shift = |(axis, name): (usize, &String)| self.shift(name, axis, side, place);
        given.map(shift).collect()
    }

    /// Moves a part's joints, the first of them `first`, by its pivot; returns the way back, in the part's frame.
    ///
    /// R₀ = Π D_ini turns the part's axes to those of its parent at angles 0. The first joint's translation becomes
    /// t + R₀p, and what was at x in the part's frame is at x − p: at angles 0 all flesh stays where it is.
    pub(super) fn displace(&mut self, first: usize, pivot: &[Shift]) -> Vec<Shift> {
        let turns = self.model.joints[first..].iter();
        let at_zero = turns.fold(Rotation3::identity(), |r, j| r * j.parent_from_joint);
        let turned = |(shift, direction)| Shift { direction, ..shift };
        let there = pivot.iter().map(|s| (*s, at_zero * s.direction));
        let shifts = &mut self.model.joints[first].translation.shifts;
        shifts.extend(there.map(turned));
        pivot.iter().map(|s| (*s, -s.direction)).map(turned).collect()
    }
}
