//! How often a colour occurs.

/// Bins of each channel.
const BINS: usize = 16;
/// Share of the density that is the same for every colour: no colour is impossible.
const UNIFORM: f64 = 0.1;
/// Weights of a bin and its neighbours in one channel: (1 2 1)/4 applied twice, σ² = 1 bin².
const BLUR: [f64; 5] = [0.0625, 0.25, 0.375, 0.25, 0.0625];

/// A density over colours: a histogram of 16 × 16 × 16 bins, blurred by one bin, and a tenth of the uniform density.
#[derive(Clone, Debug, PartialEq)]
pub struct Colours {
    /// ln of the density in 1/(grey level)³.
    log_density: Vec<f32>,
}

/// A count of colours.
#[derive(Clone, Debug)]
pub struct ColourCount(Vec<f64>);

impl Default for ColourCount {
    fn default() -> Self {
        Self(vec![0.0; BINS * BINS * BINS])
    }
}

impl ColourCount {
    /// Counts a colour.
    pub fn add(&mut self, colour: [u8; 3]) {
        self.0[bin(colour)] += 1.0;
    }

    /// How many colours were counted.
    pub fn total(&self) -> f64 {
        self.0.iter().sum()
    }

    /// The density of what was counted; the uniform one if nothing was.
    pub fn density(&self) -> Colours {
        let mut counts = self.0.clone();
        for stride in [1, BINS, BINS * BINS] {
            counts = blurred(&counts, stride);
        }

        let total: f64 = counts.iter().sum();
        let per_bin = (256.0 / BINS as f64).powi(3);
        let (uniform, scale) = match total > 0.0 {
            true => (UNIFORM, (1.0 - UNIFORM) / (total * per_bin)),
            false => (1.0, 0.0),
        };
        let density = |count: &f64| (count * scale + uniform / 256_f64.powi(3)).ln() as f32;
        Colours { log_density: counts.iter().map(density).collect() }
    }
}

impl Colours {
    /// ln of the density of a colour, in 1/(grey level)³.
    pub fn log_density(&self, colour: [u8; 3]) -> f32 {
        self.log_density[bin(colour)]
    }
}

/// Index of the bin of a colour.
fn bin(colour: [u8; 3]) -> usize {
    let [r, g, b] = colour.map(|value| usize::from(value) * BINS / 256);
    (r * BINS + g) * BINS + b
}

/// Counts blurred along one channel; what would leave at an end stays in the last bin.
fn blurred(counts: &[f64], stride: usize) -> Vec<f64> {
    let mut blurred = vec![0.0; counts.len()];
    for (i, count) in counts.iter().enumerate() {
        let at = (i / stride % BINS) as isize;
        for (offset, weight) in (-2..=2).zip(BLUR) {
            let to = (at + offset).clamp(0, BINS as isize - 1);
            blurred[i.wrapping_add_signed((to - at) * stride as isize)] += weight * count;
        }
    }
    blurred
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_density_adds_up_to_one() {
        let mut count = ColourCount::default();
        for i in 0..=255 {
            count.add([i, 255 - i, 3]);
        }
        let density = count.density();
        let volume = (256.0 / BINS as f64).powi(3);
        let sum: f64 = density.log_density.iter().map(|l| f64::from(*l).exp() * volume).sum();
        approx::assert_relative_eq!(sum, 1.0, epsilon = 1e-5);
        approx::assert_relative_eq!(count.total(), 256.0);
    }

    #[test]
    fn a_colour_that_was_counted_is_more_probable_than_its_neighbour_and_that_than_others() {
        let mut count = ColourCount::default();
        count.add([100, 100, 100]);
        let density = count.density();
        let [own, near, far] =
            [[100; 3], [118, 100, 100], [250; 3]].map(|c| density.log_density(c));
        assert!(own > near && near > far);
    }

    #[test]
    fn of_nothing_all_colours_are_alike() {
        let density = ColourCount::default().density();
        approx::assert_relative_eq!(
            density.log_density([7; 3]),
            -3.0 * 256_f32.ln(),
            epsilon = 1e-5
        );
    }
}
