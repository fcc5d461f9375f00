//! Whether the masks have lost what is thin: arms, hands and feet, which a clean-up with too large a disk takes away.
//!
//! Forearms, ankles, hands and feet are thinner than a seventeenth of a person's height. Of every person from some side and in
//! some frame they are a good part of the silhouette: 11 to 47 % of nine recordings, bare, dressed and real, and 1.2 % at most once
//! a disk has been through.

use nalgebra::Point2;
use rayon::prelude::*;

use super::shown_by_two;
use crate::image::{Mask, opened};
use crate::silhouette::{FrameObservations, Silhouette};

/// Silhouettes of which less is thin have lost arms, hands and feet.
pub(super) const LEAST_THIN: f64 = 0.02;
/// Frames that are looked at.
const SAMPLED_FRAMES: usize = 4;
/// Rows into which a silhouette is sampled, and the radius of the disk.
const ROWS: f64 = 240.0;
const RADIUS: u8 = 7;

/// The largest share of a silhouette that is thinner than a seventeenth of its height, over all views of some frames.
pub(super) fn thin_share(frames: &[FrameObservations]) -> Option<f64> {
    let sampled = shown_by_two(frames, SAMPLED_FRAMES).into_iter();
    let views: Vec<&Silhouette> =
        sampled.flat_map(|i| frames[i].views.iter().map(|(_, silhouette)| silhouette)).collect();
    views.into_par_iter().map(share).reduce_with(f64::max)
}

fn share(silhouette: &Silhouette) -> f64 {
    let (least, greatest) = silhouette.bounds;
    let step = (greatest.y - least.y).max(1.0) / ROWS;
    let columns = ((greatest.x - least.x) / step).ceil() as usize;

    // a disk's width of nothing around it
    let margin = usize::from(RADIUS) + 1;
    let whole = Mask::from_fn(columns + 2 * margin, ROWS as usize + 2 * margin, |x, y| {
        let [x, y] = [x, y].map(|i| (i as f64 - margin as f64 + 0.5) * step);
        silhouette.contains(&Point2::new(least.x + x, least.y + y))
    });
    1.0 - area(&opened(&whole, RADIUS)) / area(&whole).max(1.0)
}

fn area(mask: &Mask) -> f64 {
    let rows = (0..mask.height()).flat_map(|y| mask.row(y));
    rows.filter(|value| **value > 0).count() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::diagnosis::figures::Figures;

    #[test]
    fn a_person_has_thin_parts_and_one_who_was_cleaned_too_well_has_none() {
        let figures = Figures::new();
        let masks = figures.masks(&figures.standing(0.0, 0.0));
        let share = |masks: &[Mask]| thin_share(&[figures.frame(0, masks)]).unwrap();
        let cleaned = |mask: &Mask| {
            let rows = (0..mask.height()).filter(|y| mask.row(*y).contains(&1)).count();
            opened(mask, (rows / 24) as u8)
        };
        let whole = share(&masks);
        assert!(whole > 0.05, "{whole}");
        let cleaned = share(&masks.iter().map(cleaned).collect::<Vec<_>>());
        assert!(cleaned < 0.02, "{cleaned}");
    }
}
