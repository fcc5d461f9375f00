//! What is wrong with a recording that shows without a body.

use super::cameras::CameraFaults;
use super::cause::{Cause, camera_causes, name};
use super::cropped::cropped;
use super::room::{alone_shares, stale_shares};
use super::thin::{LEAST_THIN, thin_share};
use super::volume::{size_m, volumes};
use crate::body::{BodyModel, Root};
use crate::camera::{CameraId, Rig};
use crate::pipeline::scene::body_size;
use crate::silhouette::FrameObservations;

/// Still parts and volumes beside the body count from here on, over the silhouette's area and in litres (a child of five: 18).
pub(super) const STILL_PART: f64 = 0.25;
/// Silhouettes below this share of the body's height show less than all of it: three standard deviations of stature.
pub(super) const WHOLE: f64 = 0.8;

/// A recording of which no body is known.
#[derive(Debug, Clone, Copy)]
pub(in crate::pipeline) struct Seen<'a> {
    /// The body that is sought.
    pub(in crate::pipeline) model: &'a BodyModel,
    pub(in crate::pipeline) rig: &'a Rig,
    pub(in crate::pipeline) faults: &'a CameraFaults,
    pub(in crate::pipeline) observations: &'a [FrameObservations],
}

impl Seen<'_> {
    /// The first hypothesis that holds, where no body could be found.
    pub(in crate::pipeline) fn causes(&self) -> Vec<Cause> {
        let is_person = self.model.root != Root::Fixed;
        if let Some(cropped) = self.cropped() {
            return vec![cropped];
        }
        if let Some(cut_off) = self.cut_off().filter(|_| is_person) {
            return vec![cut_off];
        }
        if let Some(pieces) = self.stale_picture().or_else(|| self.pieces_of_room()) {
            return vec![pieces];
        }
        let is_thin = || thin_share(self.observations).is_some_and(|share| share < LEAST_THIN);
        if !self.faults.explain_nearly_all() && is_person && is_thin() {
            return vec![Cause::ThinPartsGone];
        }
        camera_causes(self.rig, self.faults)
    }

    /// Masks that end at an upright line inside the picture, in half of the cameras or more.
    pub(super) fn cropped(&self) -> Option<Cause> {
        cropped(self.rig, self.observations)
    }

    /// What all silhouettes together hold is lower than a standing person.
    fn cut_off(&self) -> Option<Cause> {
        let size_m = size_m(&volumes(self.rig, self.observations, &self.faults.readings))?;
        cut_off(body_size(self.model), size_m.z)
    }

    /// A picture of the person in all masks of half of the cameras: a body that stays there covers them fairly.
    pub(super) fn stale_picture(&self) -> Option<Cause> {
        let shares = stale_shares(self.rig, self.observations);
        let is_in_half = 2 * shares.len() >= self.rig.cameras.len();
        is_in_half.then(|| still_parts(self.rig, &shares, 0.0)).flatten()
    }

    /// Pieces of the room, elsewhere in each camera: they look like lenses that are wrong. A camera that is elsewhere shows the person
    /// where no other does, so where nothing speaks of lenses they are not looked for.
    pub(super) fn pieces_of_room(&self) -> Option<Cause> {
        if !self.faults.is_any_of_lenses() {
            return None;
        }
        still_parts(self.rig, &alone_shares(self.rig, self.observations), STILL_PART)
    }
}

/// Silhouettes that hold something lower than a person who stands and is `usual_m` tall.
pub(super) fn cut_off(usual_m: f64, height_m: f64) -> Option<Cause> {
    (height_m < WHOLE * usual_m).then_some(Cause::CutOff { height_m })
}

/// What stands still in more than `least` of a camera's silhouettes.
pub(super) fn still_parts(rig: &Rig, shares: &[(CameraId, f64)], least: f64) -> Option<Cause> {
    let large = || shares.iter().filter(|(_, share)| *share > least);
    let share = large().map(|(_, share)| *share).reduce(f64::max)?;
    Some(Cause::StillParts { cameras: large().map(|(id, _)| name(rig, *id)).collect(), share })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Mask;
    use crate::pipeline::diagnosis::figures::Figures;

    /// What is said of a person who is shown as `kept` leaves them: by which share of the way down a picture.
    fn said(kept: f64) -> Vec<Cause> {
        let figures = Figures::new();
        let masks = figures.masks(&figures.standing(0.0, 0.0));
        let cut = |mask: &Mask| {
            let rows = (0..mask.height()).filter(|y| mask.row(*y).contains(&1));
            let rows: Vec<usize> = rows.collect();
            let last = rows[0] + (kept * rows.len() as f64) as usize;
            Mask::from_fn(mask.width(), mask.height(), |x, y| y < last && mask.is_foreground(x, y))
        };
        let masks: Vec<Mask> = masks.iter().map(cut).collect();
        let observations: Vec<_> = (0..3).map(|i| figures.frame(i, &masks)).collect();
        let (model, rig) = (&figures.model, &figures.rig);
        let faults = &CameraFaults::of(rig, &observations);
        Seen { model, rig, faults, observations: &observations }.causes()
    }

    #[test]
    fn a_person_without_legs_is_cut_off_before_any_body_is_found_and_a_whole_one_is_not() {
        assert_eq!(said(1.0), []);
        let found = said(0.5);
        assert!(matches!(found[..], [Cause::CutOff { height_m }] if height_m < 1.2), "{found:?}");
    }
}
