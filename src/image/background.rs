//! How probable a colour is where nobody stands.

use super::{Colours, Plane};

/// Settings of the density of a [`Background`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowOptions {
    /// Share of background pixels that lie in a shadow (default 0.2: around a person, most of the floor).
    pub share: f32,
    /// The least part of the light that a shadow leaves (default 0.4).
    pub darkest: f32,
    /// Noise of the hue in a shadow, as a multiple of the background's σ (default 1.5).
    pub hue_spread: f32,
}

impl Default for ShadowOptions {
    fn default() -> Self {
        Self { share: 0.2, darkest: 0.4, hue_spread: 1.5 }
    }
}

/// Share of background pixels that may have any colour: what changes without being the person.
const OUTLIERS: f32 = 0.01;
/// A shadow's most light: rounding and reflections make it up to a little brighter than the background.
const BRIGHTEST: f32 = 1.05;

/// Colours of the empty scene in one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BackgroundPixel {
    /// μ: red, green, blue.
    pub mean: [f32; 3],
    /// σ of the brightness, along μ, grey levels.
    pub along: f32,
    /// σ of the hue, in both directions across μ, grey levels: cameras and codecs blur hue but leave grain.
    pub across: f32,
    /// Probability that μ is the colour of the empty scene, and not of a person who stood there all the time.
    pub trust: f32,
}

/// Colours of the empty scene in every pixel.
pub type Background = Plane<BackgroundPixel>;

impl BackgroundPixel {
    /// ln p(x | no person here), in 1/(grey level)³.
    ///
    /// p = t·((1 − s − o)·N(x) + s·S(x) + o/256³) + (1 − t)·q(x): t is the trust, s the share of shadows, o that of outliers,
    /// and q the density of the colours `around`. With x = a·μ + e, e ⟂ μ: N is a Gaussian of (a − 1)‖μ‖ and of e; S, the
    /// density in a shadow, is uniform in a between `darkest` and 1.05, and a Gaussian of e.
    ///
    /// # Source
    /// Horprasert, Harwood & Davis, *A statistical approach for real-time robust background subtraction and shadow
    /// detection*, 1999, for a and e. **Differs**: a density takes the place of thresholds.
    pub fn log_density(
        &self,
        colour: [u8; 3],
        around: Option<&Colours>,
        shadow: &ShadowOptions,
    ) -> f32 {
        use std::f32::consts::TAU;
        let (x, mean) = (colour.map(f32::from), self.mean);
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

        // a, (a − 1)²‖μ‖² and ‖e‖²
        let squared = dot(mean, mean).max(1.0);
        let light = dot(x, mean) / squared;
        let brighter = (light - 1.0) * (light - 1.0) * squared;
        let hue = (dot(x, x) - light * light * squared).max(0.0);

        let gauss = |squared: f32, sigma: f32| (-0.5 * squared / (sigma * sigma)).exp();
        let plain = gauss(brighter, self.along) / (TAU.sqrt() * self.along)
            * gauss(hue, self.across)
            / (TAU * self.across * self.across);

        let in_shadow = if light > shadow.darkest && light < BRIGHTEST {
            let spread = self.across * shadow.hue_spread;
            let length = (BRIGHTEST - shadow.darkest) * squared.sqrt();
            gauss(hue, spread) / (TAU * spread * spread * length)
        } else {
            0.0
        };

        let any = OUTLIERS / 256_f32.powi(3);
        let known = (1.0 - shadow.share - OUTLIERS) * plain + shadow.share * in_shadow + any;
        match around {
            Some(around) if self.trust < 1.0 => {
                let unknown = around.log_density(colour).exp();
                (self.trust * known + (1.0 - self.trust) * unknown).ln()
            }
            _ => known.ln(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ColourCount;

    const FLOOR: BackgroundPixel =
        BackgroundPixel { mean: [120.0, 100.0, 80.0], along: 3.0, across: 3.0, trust: 1.0 };

    fn density(empty: BackgroundPixel, colour: [u8; 3]) -> f32 {
        empty.log_density(colour, None, &ShadowOptions::default())
    }

    #[test]
    fn a_shadow_is_less_probable_than_the_floor_and_much_more_than_another_colour() {
        let floor = density(FLOOR, [120, 100, 80]);
        let shadow = density(FLOOR, [84, 70, 56]);
        let shirt = density(FLOOR, [56, 70, 84]);
        assert!(floor > shadow + 2.0 && shadow > shirt + 5.0, "{floor} {shadow} {shirt}");
    }

    #[test]
    fn a_highlight_and_darkness_are_no_shadows() {
        assert!(density(FLOOR, [180, 150, 120]) < density(FLOOR, [84, 70, 56]) - 5.0);
        assert!(density(FLOOR, [24, 20, 16]) < density(FLOOR, [84, 70, 56]) - 5.0);
    }

    #[test]
    fn where_the_background_is_not_known_the_surroundings_speak() {
        let mut wood = ColourCount::default();
        wood.add([200, 150, 90]);
        let (wood, doubtful) = (wood.density(), BackgroundPixel { trust: 0.01, ..FLOOR });
        let with = |colour| doubtful.log_density(colour, Some(&wood), &ShadowOptions::default());
        assert!(with([200, 150, 90]) > density(FLOOR, [200, 150, 90]) + 3.0);
        assert!(with([120, 100, 80]) < density(FLOOR, [120, 100, 80]) - 3.0);
    }

    #[test]
    fn a_black_background_is_no_fault() {
        let black = BackgroundPixel { mean: [0.0; 3], ..FLOOR };
        assert!(density(black, [0; 3]).is_finite() && density(black, [255; 3]).is_finite());
    }
}
