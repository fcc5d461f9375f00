//! The border of a mask, exact to the pixel, from how much of each border pixel the person covers.
//!
//! Labels tell the person from the empty scene by the colours that each can have. A pixel on the border shows a mixture,
//! α·F + (1 − α)·B, that neither can have, and so falls to the side whose colours are known less well. But F and B, the
//! colours on either side of the border, stand right beside it, so α can be measured.

use super::{Mask, Picture, Plane, Runs, box_mean};

/// Settings of [`sharpen`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BorderOptions {
    /// Only pixels this near to the border may change, px (default 1).
    pub reach_px: usize,
    /// F and B are mean colours over so many columns and rows to each side, px (default 4).
    pub window_px: usize,
    /// A pixel shows the person where the mean coverage of 3 × 3 pixels exceeds this (default 0.4: hand-made and rendered
    /// masks both begin a little below half).
    pub coverage: f32,
    /// Least difference of F and B for α to be measured, grey levels (default 20).
    pub least_contrast: f32,
    /// Least squared difference of F and B, over the sum of the two sides' variances (default 4).
    pub least_separation: f32,
}

impl Default for BorderOptions {
    fn default() -> Self {
        Self {
            reach_px: 1,
            window_px: 4,
            coverage: 0.4,
            least_contrast: 20.0,
            least_separation: 4.0,
        }
    }
}

impl BorderOptions {
    /// For a mask from a picture that was shrunk by `factor`: its border may be off by so many times as much.
    pub fn scaled(self, factor: usize) -> Self {
        Self { reach_px: self.reach_px * factor, window_px: self.window_px * factor, ..self }
    }
}

/// Least share of the window that must belong to a side for its colour to be known.
const LEAST_SHARE: f32 = 0.037;
/// Neighbours to each side over which coverage is averaged, px.
const SMOOTHED_PX: usize = 1;

/// The mask with its border moved to where the picture has it; unchanged where the two sides look alike.
///
/// Within `reach_px` of the border α = (x − B)·(F − B)/‖F − B‖², with F and B the mean colours on either side beyond that
/// reach; a pixel is decided by the mean α of 3 × 3 pixels.
pub fn sharpen(mask: &Mask, picture: &Picture, options: &BorderOptions) -> Mask {
    let runs = Runs::from_mask(mask);
    let Some(region) = runs.region() else {
        return mask.clone();
    };

    // only the person's surroundings are looked at
    let margin = options.reach_px + options.window_px;
    let region = region.grown(margin, mask.width(), mask.height());
    let inner = runs.painted(&region, 0).map(f32::from);
    let measured = Coverage::new(&inner, &picture.cropped(&region), options);
    let coverage = box_mean(&measured.alpha, SMOOTHED_PX);

    Mask::from_fn(mask.width(), mask.height(), |x, y| {
        let (Some(column), Some(row)) = (x.checked_sub(region.left), y.checked_sub(region.top))
        else {
            return mask.is_foreground(x, y);
        };
        match measured.is_measured.get(column, row) {
            Some(true) => coverage.row(row)[column] > options.coverage,
            _ => mask.is_foreground(x, y),
        }
    })
}

/// α of each pixel: measured, or else what the mask says.
struct Coverage {
    alpha: Plane<f32>,
    is_measured: Plane<bool>,
}

impl Coverage {
    fn new(mask: &Plane<f32>, picture: &Picture, options: &BorderOptions) -> Self {
        // the colours of either side, from pixels beyond the reach
        let near = box_mean(mask, options.reach_px);
        let inside = near.map(|share| f32::from(u8::from(share > 0.999)));
        let outside = near.map(|share| f32::from(u8::from(share < 0.001)));
        let person = side_colours(picture, &inside, options.window_px);
        let scene = side_colours(picture, &outside, options.window_px);

        let mut alpha = mask.clone();
        let mut is_measured = mask.map(|_| false);
        for y in 0..mask.height() {
            for x in 0..mask.width() {
                if inside.row(y)[x] + outside.row(y)[x] > 0.0 {
                    continue;
                }
                let (f, b) = (person.row(y)[x], scene.row(y)[x]);
                if let Some(covered) = mixed(picture.row(y)[x], f, b, options) {
                    alpha.row_mut(y)[x] = covered;
                    is_measured.row_mut(y)[x] = true;
                }
            }
        }
        Self { alpha, is_measured }
    }
}

/// α of a colour between two others; `None` where these are not known or too much alike.
fn mixed(colour: [u8; 3], f: SideColour, b: SideColour, options: &BorderOptions) -> Option<f32> {
    let difference = |i: usize| f.mean[i] - b.mean[i];
    let squared: f32 = (0..3).map(|i| difference(i).powi(2)).sum();
    let along: f32 = (0..3).map(|i| (f32::from(colour[i]) - b.mean[i]) * difference(i)).sum();
    let is_known = f.share.min(b.share) >= LEAST_SHARE;
    let is_clear = squared > options.least_contrast.powi(2)
        && squared > options.least_separation * (f.variance + b.variance + 1.0);
    (is_known && is_clear).then(|| (along / squared).clamp(0.0, 1.0))
}

/// The colour of one side of the border around a pixel.
#[derive(Clone, Copy)]
struct SideColour {
    /// Share of the window that belongs to this side.
    share: f32,
    mean: [f32; 3],
    /// Sum over red, green and blue.
    variance: f32,
}

/// The colour of a side, which is 1 in `side`, around each pixel.
fn side_colours(picture: &Picture, side: &Plane<f32>, window_px: usize) -> Plane<SideColour> {
    // Σ value/window over the side's pixels
    let mean = |value: &dyn Fn([f32; 3]) -> f32| {
        let mut values = side.clone();
        for y in 0..side.height() {
            for (weighted, colour) in values.row_mut(y).iter_mut().zip(picture.row(y)) {
                *weighted *= value(colour.map(f32::from));
            }
        }
        box_mean(&values, window_px)
    };
    let share = mean(&|_| 1.0);
    let sums = [0, 1, 2].map(|channel| mean(&|colour| colour[channel]));
    let squares = mean(&|colour| colour.iter().map(|v| v * v).sum());

    let nothing = SideColour { share: 0.0, mean: [0.0; 3], variance: 0.0 };
    let mut colours = Plane::filled(side.width(), side.height(), nothing);
    for y in 0..side.height() {
        for (x, colour) in colours.row_mut(y).iter_mut().enumerate() {
            let share = share.row(y)[x];
            let per = 1.0 / share.max(1e-6);
            let mean = [0, 1, 2].map(|channel: usize| sums[channel].row(y)[x] * per);
            let squared: f32 = mean.iter().map(|v| v * v).sum();
            *colour =
                SideColour { share, mean, variance: (squares.row(y)[x] * per - squared).max(0.0) };
        }
    }
    colours
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERSON: f32 = 200.0;
    const SCENE: f32 = 60.0;

    /// A bright person to the left of `border_px`, blurred over a pixel.
    fn edge(border_px: f32) -> Picture {
        let colour = |x: usize| {
            let covered = (border_px - x as f32 + 0.5).clamp(0.0, 1.0);
            [(SCENE + covered * (PERSON - SCENE)) as u8; 3]
        };
        let values = (0..20).flat_map(|_| (0..30).map(colour)).collect();
        Picture::from_values(30, 20, values).unwrap()
    }

    fn width(mask: &Mask) -> usize {
        (0..30).filter(|x| mask.is_foreground(*x, 10)).count()
    }

    #[test]
    fn a_border_that_is_a_pixel_off_goes_where_the_picture_has_it() {
        for off in [14, 15, 16] {
            let mask = Mask::from_fn(30, 20, |x, _| x < off);
            let sharp = sharpen(&mask, &edge(14.5), &BorderOptions::default());
            assert_eq!(width(&sharp), 15, "{off}");
        }
    }

    #[test]
    fn a_border_between_like_colours_stays() {
        let mask = Mask::from_fn(30, 20, |x, _| x < 12);
        let plain = Picture::filled(30, 20, [90; 3]);
        assert_eq!(sharpen(&mask, &plain, &BorderOptions::default()), mask);
        let none = Mask::from_fn(30, 20, |_, _| false);
        assert_eq!(sharpen(&none, &plain, &BorderOptions::default()), none);
    }
}
