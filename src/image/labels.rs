//! From the evidence of single pixels to coherent labels.

use super::{Picture, Plane};

/// Settings of [`relax`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelaxOptions {
    /// λ: the cost of a border per pixel of its length where the picture has no edge, in units of evidence (default 8).
    pub border_cost: f32,
    /// Number of iterations (default 80).
    pub steps: usize,
}

impl Default for RelaxOptions {
    fn default() -> Self {
        Self { border_cost: 8.0, steps: 80 }
    }
}

/// Step of u; τ·ς·8 = 1 keeps the iteration stable.
const TAU: f32 = 0.1;
/// Step of p.
const VARSIGMA: f32 = 1.25;

/// The probability u of foreground in each pixel; above ½ is foreground.
///
/// Minimises Σ −L u + Σ g ‖∇u‖ with L the evidence, ln p(x | foreground) − ln p(x | background), and
/// g = λ·exp(−‖∇I‖²/2β), β the mean of ‖∇I‖² over the picture: a border is cheap where the picture I has an edge. The
/// problem is convex, and any threshold of its solution is the best labelling at that threshold's cost (the continuous
/// counterpart of a graph cut). Fifty to a hundred primal–dual iterations solve it well enough. The evidence must be as
/// large as the picture.
///
/// # Source
/// Nikolova, Esedoglu & Chan 2006 (exactness); Chambolle & Pock, *A first-order primal-dual algorithm*, 2011,
/// Algorithm 1; Boykov & Jolly 2001 for g.
pub fn relax(evidence: &Plane<f32>, picture: &Picture, options: &RelaxOptions) -> Plane<f32> {
    let (width, height) = (evidence.width(), evidence.height());
    let bound = bounds(picture, options.border_cost);
    let mut u = evidence.map(|l| if l > 0.0 { 1.0 } else { 0.0 });
    let mut ahead = u.clone();
    let mut flow = Flow::zeros(width, height);

    for _ in 0..options.steps {
        for y in 0..height {
            flow.ascend(y, &ahead, bound.row(y));
        }
        for y in 0..height {
            flow.descend(y, u.row_mut(y), ahead.row_mut(y), evidence.row(y));
        }
    }
    u
}

/// p, the dual of ∇u.
struct Flow {
    /// Towards the right neighbour.
    x: Plane<f32>,
    /// Towards the neighbour below.
    y: Plane<f32>,
    /// What flows into the first row from above.
    zeros: Vec<f32>,
}

impl Flow {
    fn zeros(width: usize, height: usize) -> Self {
        Self {
            x: Plane::filled(width, height, 0.0),
            y: Plane::filled(width, height, 0.0),
            zeros: vec![0.0; width],
        }
    }

    /// Row y of p ← projection of p + ς ∇ū onto ‖p‖ ≤ g, with g the `bound`.
    fn ascend(&mut self, y: usize, ahead: &Plane<f32>, bound: &[f32]) {
        let here = ahead.row(y);
        let below = match y + 1 < ahead.height() {
            true => ahead.row(y + 1),
            false => here,
        };
        // slices of one known length: no bounds are checked in the loops
        let width = here.len();
        let (px, py) = (&mut self.x.row_mut(y)[..width], &mut self.y.row_mut(y)[..width]);
        let (below, bound) = (&below[..width], &bound[..width]);

        for x in 0..width {
            py[x] += VARSIGMA * (below[x] - here[x]);
        }
        for (p, pair) in px.iter_mut().zip(here.windows(2)) {
            *p += VARSIGMA * (pair[1] - pair[0]);
        }
        for x in 0..width {
            let norm = (px[x] * px[x] + py[x] * py[x]).sqrt();
            let scale = bound[x] / norm.max(bound[x]).max(1e-9);
            px[x] *= scale;
            py[x] *= scale;
        }
    }

    /// Row y of u ← projection of u + τ (div p + L) onto [0, 1], with L the `evidence`; ū, which is `ahead`, extrapolates.
    fn descend(&self, y: usize, u: &mut [f32], ahead: &mut [f32], evidence: &[f32]) {
        let above = match y.checked_sub(1) {
            Some(above) => self.y.row(above),
            None => &self.zeros,
        };
        // slices of one known length: no bounds are checked in the loop
        let width = u.len();
        let (px, py) = (&self.x.row(y)[..width], &self.y.row(y)[..width]);
        let (above, ahead, evidence) = (&above[..width], &mut ahead[..width], &evidence[..width]);

        let mut left = 0.0;
        for x in 0..width {
            let divergence = px[x] - left + py[x] - above[x];
            left = px[x];
            let next = (u[x] + TAU * (divergence + evidence[x])).clamp(0.0, 1.0);
            ahead[x] = 2.0 * next - u[x];
            u[x] = next;
        }
    }
}

/// g of each pixel; the picture counts as constant beyond its edge.
fn bounds(picture: &Picture, border_cost: f32) -> Plane<f32> {
    let height = picture.height();
    let mut squares = picture.map(|_| 0.0_f32);

    // ‖∇I‖² from differences to the right and downwards
    for y in 0..height {
        let here = picture.row(y);
        let below = if y + 1 < height { picture.row(y + 1) } else { here };
        for (x, square) in squares.row_mut(y).iter_mut().enumerate() {
            let right = here.get(x + 1).unwrap_or(&here[x]);
            *square = distance(&here[x], right) + distance(&here[x], &below[x]);
        }
    }

    let count = squares.values().len().max(1) as f64;
    let mean = squares.values().iter().map(|v| f64::from(*v)).sum::<f64>() / count;
    let scale = -0.5 / (mean as f32).max(1e-3);
    squares.map(|square| border_cost * (scale * square).exp())
}

/// Squared distance of two colours.
fn distance(a: &[u8; 3], b: &[u8; 3]) -> f32 {
    let square = |i: usize| (f32::from(a[i]) - f32::from(b[i])).powi(2);
    square(0) + square(1) + square(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture with a bright disk, and evidence that is right but for noise.
    fn disk(noise: impl Fn(usize, usize) -> f32) -> (Plane<f32>, Picture) {
        let is_in = |x: usize, y: usize| (x as f32 - 20.0).hypot(y as f32 - 15.0) < 10.0;
        let places = || (0..30).flat_map(|y| (0..40).map(move |x| (x, y)));
        let evidence = places().map(|(x, y)| if is_in(x, y) { 1.0 } else { -1.0 } + noise(x, y));
        let picture = places().map(|(x, y)| [if is_in(x, y) { 200 } else { 50 }; 3]);
        (
            Plane::from_values(40, 30, evidence.collect()).unwrap(),
            Picture::from_values(40, 30, picture.collect()).unwrap(),
        )
    }

    fn area(u: &Plane<f32>) -> usize {
        u.values().iter().filter(|u| **u > 0.5).count()
    }

    #[test]
    fn single_wrong_pixels_do_as_their_neighbours() {
        let (clean, picture) = disk(|_, _| 0.0);
        let (noisy, _) = disk(|x, y| if (7 * x + 11 * y) % 10 == 0 { 2.5 } else { 0.0 });
        let options = RelaxOptions::default();
        let expected = clean.values().iter().filter(|l| **l > 0.0).count();
        assert_eq!(area(&relax(&clean, &picture, &options)), expected);
        assert_eq!(area(&relax(&noisy, &picture, &options)), expected);
    }

    #[test]
    fn a_border_without_an_edge_of_the_picture_is_dearer() {
        let (evidence, picture) = disk(|_, _| 0.0);
        let flat = Picture::filled(40, 30, [90; 3]);
        let dear = RelaxOptions { border_cost: 6.0, ..RelaxOptions::default() };
        assert!(area(&relax(&evidence, &picture, &dear)) > 250);
        assert_eq!(area(&relax(&evidence, &flat, &dear)), 0, "2πr·6 > πr²·2");
    }

    #[test]
    fn both_options_change_the_result() {
        let (evidence, picture) = disk(|x, y| ((x * 13 + y * 7) % 5) as f32 - 2.0);
        let usual = relax(&evidence, &picture, &RelaxOptions::default());
        let few = RelaxOptions { steps: 5, ..RelaxOptions::default() };
        let free = RelaxOptions { border_cost: 0.0, ..RelaxOptions::default() };
        assert_ne!(relax(&evidence, &picture, &few), usual);
        assert_ne!(relax(&evidence, &picture, &free), usual);
    }

    #[test]
    fn an_empty_picture_is_no_fault() {
        let u = relax(
            &Plane::filled(0, 0, 0.0),
            &Picture::filled(0, 0, [0; 3]),
            &RelaxOptions::default(),
        );
        assert_eq!(u.values().len(), 0);
    }
}
