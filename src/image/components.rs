//! Masks without specks and small holes.

use super::{Component, Connectivity, Runs};

/// Which specks and holes a mask is cleaned of: four fractions of the person's own size in the image, so they hold at any
/// resolution.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CleanOptions {
    /// Components of at least this fraction of the largest one's area are kept wherever they are (default 0.05: a leg
    /// cut off by an occluder has 0.1 and more).
    pub part_fraction: f64,
    /// Smaller components of at least this fraction are kept if they are near a kept one (default 0.004: a hand cut off
    /// at the wrist has 0.005 to 0.02).
    pub fragment_fraction: f64,
    /// How near: the gap between a fragment's box and a kept component, over the longer side of the largest
    /// component's box (default 0.04, the width of a forearm).
    pub fragment_gap: f64,
    /// Holes below this fraction of the foreground's area are filled (default 0.002). The gap between an arm and the trunk
    /// can be as small: if it is filled, its border is lost.
    pub hole_fraction: f64,
}

impl Default for CleanOptions {
    fn default() -> Self {
        Self {
            part_fraction: 0.05,
            fragment_fraction: 0.004,
            fragment_gap: 0.04,
            hole_fraction: 0.002,
        }
    }
}

/// The mask without specks (8-connected foreground) and without small holes (4-connected background).
///
/// Background that reaches the image edge is never a hole.
pub fn clean(mask: &Runs, options: &CleanOptions) -> Runs {
    without_small_holes(&without_specks(mask, options), options.hole_fraction)
}

fn without_specks(mask: &Runs, options: &CleanOptions) -> Runs {
    let (components, labels) = mask.components(Connectivity::Eight);
    let Some(largest) = components.iter().max_by_key(|component| component.area) else {
        return mask.clone();
    };

    // large components, and fragments near them
    let is_at_least =
        |c: &Component, fraction: f64| c.area as f64 >= fraction * largest.area as f64;
    let is_part = |i: usize| is_at_least(&components[labels[i]], options.part_fraction);
    let parts = mask.filtered(is_part);
    let reach = (options.fragment_gap * longer_side(largest)) as usize;
    let is_kept: Vec<bool> = components
        .iter()
        .map(|c| {
            is_at_least(c, options.part_fraction)
                || (is_at_least(c, options.fragment_fraction) && parts.comes_near(&c.region, reach))
        })
        .collect();

    mask.filtered(|i| is_kept[labels[i]])
}

fn without_small_holes(mask: &Runs, fraction: f64) -> Runs {
    let background = mask.complement();
    let (components, labels) = background.components(Connectivity::Four);
    let least = fraction * mask.area() as f64;
    let is_kept = |c: &Component| c.touches_image_edge || c.area as f64 >= least;
    background.filtered(|i| is_kept(&components[labels[i]])).complement()
}

fn longer_side(component: &Component) -> f64 {
    let region = &component.region;
    (region.right - region.left).max(region.bottom - region.top) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Mask;

    /// A trunk of 100 × 200 pixels in an image of 400 × 300, with `extra` pixels set and `bitten` ones cleared.
    fn person(extra: impl Fn(usize, usize) -> bool, bitten: impl Fn(usize, usize) -> bool) -> Runs {
        Runs::from_mask(&Mask::from_fn(400, 300, |x, y| {
            let trunk = (100..200).contains(&x) && (50..250).contains(&y);
            (trunk || extra(x, y)) && !bitten(x, y)
        }))
    }

    fn square(x: usize, y: usize, left: usize, side: usize) -> bool {
        (left..left + side).contains(&x) && (100..100 + side).contains(&y)
    }

    #[test]
    fn a_speck_goes_and_the_person_stays() {
        let noisy = person(|x, y| square(x, y, 203, 6), |_, _| false);
        let cleaned = clean(&noisy, &CleanOptions::default());
        assert_eq!(cleaned, person(|_, _| false, |_, _| false));
    }

    #[test]
    fn a_hand_cut_off_by_a_bite_stays_and_the_same_blob_far_away_goes() {
        let near = person(|x, y| square(x, y, 205, 12), |_, _| false);
        assert_eq!(clean(&near, &CleanOptions::default()), near);
        let far = person(|x, y| square(x, y, 300, 12), |_, _| false);
        let cleaned = clean(&far, &CleanOptions::default());
        assert_eq!(cleaned.area(), 20_000);
    }

    #[test]
    fn a_large_part_stays_wherever_it_is() {
        let cut = person(|x, y| square(x, y, 300, 40), |_, _| false);
        assert_eq!(clean(&cut, &CleanOptions::default()), cut);
    }

    #[test]
    fn a_small_hole_is_filled_and_a_large_one_is_kept() {
        let small = person(|_, _| false, |x, y| square(x, y, 150, 5));
        assert_eq!(clean(&small, &CleanOptions::default()).area(), 20_000);
        let large = person(|_, _| false, |x, y| square(x, y, 150, 10));
        assert_eq!(clean(&large, &CleanOptions::default()), large);
    }

    #[test]
    fn every_option_changes_the_result() {
        let noisy = person(
            |x, y| square(x, y, 205, 12) || square(x, y, 300, 40),
            |x, y| square(x, y, 150, 5),
        );
        let defaults = CleanOptions::default();
        let usual = clean(&noisy, &defaults);
        let changed = [
            CleanOptions { part_fraction: 0.1, ..defaults },
            CleanOptions { fragment_fraction: 0.01, ..defaults },
            CleanOptions { fragment_gap: 0.01, ..defaults },
            CleanOptions { hole_fraction: 0.001, ..defaults },
        ];
        for options in changed {
            assert_ne!(clean(&noisy, &options), usual, "{options:?}");
        }
    }

    #[test]
    fn an_empty_and_a_full_mask_are_left_alone() {
        for value in [false, true] {
            let mask = Runs::from_mask(&Mask::from_fn(20, 10, |_, _| value));
            assert_eq!(clean(&mask, &CleanOptions::default()), mask);
        }
    }
}
