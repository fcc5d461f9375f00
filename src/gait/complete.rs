//! Places without a marker, found from those that have one.

use nalgebra::{Matrix3, Vector3};

use super::landmark::{Landmark, Paired, Side};
use super::movement::{Movement, Track};

/// Where the back of the heel lies from the ankle, in lengths of the line from ankle to toe: backwards along that line,
/// and downwards square to it.
///
/// From the foot of `data/models/human-ellipsoids.toml`: ankle at 0, toe (0.180, −0.055), heel (−0.055, −0.045) metres
/// forwards and upwards (docs/anthropometry.md).
const HEEL: (f64, f64) = (0.21, 0.31);

impl Movement {
    /// Adds the joint centres, hips, middle of the hips and heels that other places determine.
    pub(super) fn complete(&mut self) {
        for side in Side::BOTH {
            self.middle(side, Paired::Knee, Paired::KneeMedial);
            self.middle(side, Paired::Ankle, Paired::AnkleMedial);
        }
        self.hips_from_pelvis();
        for side in Side::BOTH {
            self.heel_from_foot(side);
        }
        self.middle_of_hips();
    }

    /// The middle of a lateral and a medial marker is the joint's centre.
    fn middle(&mut self, side: Side, lateral: Paired, medial: Paired) {
        let landmark = Landmark::Of(side, lateral);
        let (Some(outer), Some(inner)) =
            (self.paired_track(side, lateral), self.paired_track(side, medial))
        else {
            return;
        };
        let middle: Track = outer.iter().zip(inner).map(|(a, b)| (a + b) * 0.5).collect();
        self.tracks.insert(landmark, middle);
        if let Some(used) = self.used.iter_mut().find(|u| u.landmark == landmark) {
            used.from += " and its medial partner, their middle";
        }
    }

    /// Hip joint centres from the four spines of the pelvis.
    ///
    /// From the middle of the ASIS, in the ISB pelvis frame (X forwards, Y up, Z right), mm: x = −0.24·PD − 9.9,
    /// y = −0.30·PW − 10.9, z = ±(0.33·PW + 7.3), with PD the depth (ASIS to PSIS) and PW the width (ASIS to ASIS).
    ///
    /// # Source
    /// Harrington et al., J. Biomech. 40 (2007) 595–602, the regressions without leg length.
    fn hips_from_pelvis(&mut self) {
        if self.paired_track(Side::Right, Paired::Hip).is_some()
            || self.paired_track(Side::Left, Paired::Hip).is_some()
        {
            return;
        }
        let Some(spines) = self.spines() else { return };

        let mut hips: [Track; 2] = Default::default();
        for [left, right, back] in &spines {
            let front = (left + right) * 0.5;
            let frame = pelvis_frame(left, right, back);
            let (depth, width) = ((front - back).norm(), (right - left).norm());
            for (side, track) in Side::BOTH.into_iter().zip(&mut hips) {
                let place = Vector3::new(
                    -0.24 * depth - 0.0099,
                    -0.30 * width - 0.0109,
                    side.sign() * (0.33 * width + 0.0073),
                );
                let none = Vector3::repeat(f64::NAN);
                track.push(frame.map_or(none, |axes| front + axes * place));
            }
        }

        for (side, track) in Side::BOTH.into_iter().zip(hips) {
            let from = "ASIS and PSIS, by the regression of Harrington 2007".to_owned();
            self.insert(Landmark::Of(side, Paired::Hip), track, from);
        }
    }

    /// Left ASIS, right ASIS and the middle of the back of the pelvis, frame by frame.
    pub(super) fn spines(&self) -> Option<Vec<[Vector3<f64>; 3]>> {
        let left = self.paired_track(Side::Left, Paired::Asis)?;
        let right = self.paired_track(Side::Right, Paired::Asis)?;
        let back: Track = match (
            self.paired_track(Side::Left, Paired::Psis),
            self.paired_track(Side::Right, Paired::Psis),
        ) {
            (Some(l), Some(r)) => l.iter().zip(r).map(|(l, r)| (l + r) * 0.5).collect(),
            _ => self.track(Landmark::Sacrum)?.clone(),
        };
        let rows = left.iter().zip(right).zip(back);
        Some(rows.map(|((l, r), b)| [*l, *r, b]).collect())
    }

    fn middle_of_hips(&mut self) {
        if self.track(Landmark::MidHip).is_some() {
            return;
        }
        let (Some(l), Some(r)) = (
            self.paired_track(Side::Left, Paired::Hip),
            self.paired_track(Side::Right, Paired::Hip),
        ) else {
            return;
        };
        let middle = l.iter().zip(r).map(|(l, r)| (l + r) * 0.5).collect();
        self.insert(Landmark::MidHip, middle, "both hips, their middle".into());
    }

    /// A heel without a marker is fixed to the foot.
    fn heel_from_foot(&mut self, side: Side) {
        if self.paired_track(side, Paired::Heel).is_some() {
            return;
        }
        let places = [Paired::Knee, Paired::Ankle, Paired::Toe].map(|p| self.paired_track(side, p));
        let [Some(knee), Some(ankle), Some(toe)] = places else {
            return;
        };

        let heel = |i: usize| {
            let along = toe[i] - ankle[i];
            let length = along.norm();
            let along = along / length;
            let up = knee[i] - ankle[i];
            let up = up - along * up.dot(&along);
            let up = up / up.norm();
            ankle[i] - length * (HEEL.0 * along + HEEL.1 * up)
        };

        let track = (0..self.frames).map(heel).collect();
        let from = "ankle and toe: a point where the heel of a mean foot is".to_owned();
        self.insert(Landmark::Of(side, Paired::Heel), track, from);
    }
}

/// ISB axes of the pelvis as columns: X forwards in the plane of the spines, Y up, Z to the right.
pub(super) fn pelvis_frame(
    left: &Vector3<f64>,
    right: &Vector3<f64>,
    back: &Vector3<f64>,
) -> Option<Matrix3<f64>> {
    let z = (right - left).try_normalize(1e-9)?;
    let forward = (left + right) * 0.5 - back;
    let x = (forward - z * forward.dot(&z)).try_normalize(1e-9)?;
    Some(Matrix3::from_columns(&[x, z.cross(&x), z]))
}
