//! Where colours change, and how fast.
//!
//! The picture is blurred by a Gaussian of σ pixels, the scale of its edges, and differentiated. The three channels of a
//! colour picture have one edge between them: the larger eigenvalue of the tensor J = Σ ∇I ∇Iᵀ over the channels is the
//! squared magnitude, and its eigenvector the direction (Di Zenzo, *A note on the gradient of a multi-image*, CVGIP 33, 1986).

use nalgebra::{Point2, Vector2};

use super::{Mask, Plane};

/// Reach of the Gaussian's kernel, in σ.
const KERNEL_REACH: f64 = 3.0;

/// Magnitude and direction of the strongest change of a picture. The direction is across the edge, towards either side.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// Along x and y, grey levels per pixel; 0 where unknown.
    vectors: Plane<[f32; 2]>,
}

/// The four pixels around a place, and where it lies between them.
struct Neighbours {
    /// Their vectors: upper left and right, lower left and right.
    vectors: [[[f32; 2]; 2]; 2],
    /// Distance from the left ones, px.
    right: f64,
    /// Distance from the upper ones, px.
    down: f64,
}

impl Gradient {
    /// The gradient of a picture's channels at the scale σ; 0 where a channel is not finite within 3 σ.
    ///
    /// The picture counts as constant beyond its border. Channels of another size than the first are left out.
    pub fn new(channels: &[Plane<f32>], sigma_px: f64) -> Self {
        let kernels = Kernels::new(sigma_px);
        let size = channels.first().map(|c| (c.width(), c.height()));
        let same = |c: &&Plane<f32>| Some((c.width(), c.height())) == size;
        let mut slopes = channels.iter().filter(same).map(|c| slopes(c, &kernels));
        let mut vectors = slopes.next().unwrap_or_else(|| Plane::filled(0, 0, [0.0; 2]));

        // the eigenvector of one channel's tensor is its gradient
        if let Some(second) = slopes.next() {
            let mut tensors = vectors.map(tensor);
            for channel in std::iter::once(second).chain(slopes) {
                for y in 0..tensors.height() {
                    for (sum, slope) in tensors.row_mut(y).iter_mut().zip(channel.row(y)) {
                        let own = tensor(*slope);
                        *sum = [0, 1, 2].map(|k| sum[k] + own[k]);
                    }
                }
            }
            vectors = tensors.map(strongest);
        }

        for y in 0..vectors.height() {
            for vector in vectors.row_mut(y) {
                let is_known = (vector[0] + vector[1]).is_finite();
                *vector = if is_known { *vector } else { [0.0; 2] };
            }
        }
        Self { vectors }
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.vectors.width()
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.vectors.height()
    }

    /// How fast the picture changes in each pixel, grey levels per pixel.
    pub fn magnitude(&self) -> Plane<f32> {
        self.vectors.map(length)
    }

    /// The gradient at a place between pixels, from its four neighbours; 0 beyond the picture.
    ///
    /// Opposite vectors are the same edge, so each neighbour is first turned to the side of `towards`.
    pub fn at(&self, place: &Point2<f64>, towards: &Vector2<f64>) -> Vector2<f64> {
        let turned = |[x, y]: [f32; 2]| {
            let v = Vector2::new(f64::from(x), f64::from(y));
            if v.dot(towards) < 0.0 { -v } else { v }
        };
        let Some(neighbours) = self.neighbours(place) else {
            return Vector2::zeros();
        };
        let [[a, b], [c, d]] = neighbours.vectors;
        let (s, t) = (neighbours.right, neighbours.down);
        (turned(a) * (1.0 - s) + turned(b) * s) * (1.0 - t)
            + (turned(c) * (1.0 - s) + turned(d) * s) * t
    }

    /// How fast the picture changes along a unit vector: that component of [`Gradient::at`] towards it.
    #[inline]
    pub fn along(&self, place: &Point2<f64>, direction: &Vector2<f64>) -> f64 {
        let Some(neighbours) = self.neighbours(place) else {
            return 0.0;
        };
        let (x, y) = (direction.x as f32, direction.y as f32);
        let change = |v: [f32; 2]| (v[0] * x + v[1] * y).abs();
        let [upper, lower] = neighbours.vectors.map(|[left, right]| {
            let (left, right) = (change(left), change(right));
            left + (right - left) * neighbours.right as f32
        });
        f64::from(upper + (lower - upper) * neighbours.down as f32)
    }

    /// The four neighbours of a place between pixels; `None` beyond the picture.
    #[inline]
    fn neighbours(&self, place: &Point2<f64>) -> Option<Neighbours> {
        if !(place.x >= 0.0 && place.y >= 0.0) {
            return None;
        }
        let (x, y) = (place.x as u32, place.y as u32);
        Some(Neighbours {
            vectors: self.vectors.square(x as usize, y as usize)?,
            right: place.x - f64::from(x),
            down: place.y - f64::from(y),
        })
    }

    /// The gradient on the foreground of a mask, 0 elsewhere.
    pub fn within(&self, mask: &Mask) -> Self {
        let mut kept = self.clone();
        for y in 0..kept.height() {
            for (x, vector) in kept.vectors.row_mut(y).iter_mut().enumerate() {
                if !mask.is_foreground(x, y) {
                    *vector = [0.0; 2];
                }
            }
        }
        kept
    }

    /// The gradient where it is above `high`, or above `low` beside a pixel above `high`; 0 elsewhere (PF02 § 4.2).
    ///
    /// **Differs** from Canny, as the paper does: edges continue one pixel beside a strong one, not along a chain.
    pub fn hysteresis(&self, low: f32, high: f32) -> Self {
        let magnitude = self.magnitude();
        let strong_near = |x: usize, y: usize| {
            let rows = y.saturating_sub(1)..y + 2;
            rows.flat_map(|y| {
                magnitude
                    .row(y)
                    .get(x.saturating_sub(1)..)
                    .unwrap_or(&[])
                    .iter()
                    .take(3 - usize::from(x == 0))
            })
            .any(|m| *m >= high)
        };

        let mut kept = self.clone();
        for y in 0..kept.height() {
            for (x, vector) in kept.vectors.row_mut(y).iter_mut().enumerate() {
                let own = length(*vector);
                if !(own >= high || (own >= low && strong_near(x, y))) {
                    *vector = [0.0; 2];
                }
            }
        }
        kept
    }
}

/// The Gaussian and its derivative: the one keeps a constant, the other makes 1 of a slope of 1.
struct Kernels {
    blur: Kernel,
    slope: Kernel,
}

/// An even or odd kernel.
struct Kernel {
    /// From the middle outwards.
    weights: Vec<f32>,
    /// 1 if even, −1 if odd: the factor of the weights before the middle.
    mirrored: f32,
}

impl Kernels {
    fn new(sigma_px: f64) -> Self {
        let sigma = sigma_px.max(0.3);
        let reach = (KERNEL_REACH * sigma).ceil() as i32;
        let gauss = |i: i32| (-0.5 * (f64::from(i) / sigma).powi(2)).exp();
        let sum: f64 = (-reach..=reach).map(gauss).sum();
        let moment: f64 = (-reach..=reach).map(|i| f64::from(i * i) * gauss(i)).sum();
        let kernel = |weight: &dyn Fn(i32) -> f64, mirrored| Kernel {
            weights: (0..=reach).map(|i| weight(i) as f32).collect(),
            mirrored,
        };
        Self {
            blur: kernel(&|i| gauss(i) / sum, 1.0),
            slope: kernel(&|i| f64::from(i) * gauss(i) / moment, -1.0),
        }
    }
}

impl Kernel {
    /// Σ kᵢ vᵢ, with the values vᵢ of all places in `shifted(i)`; i is negative before the middle.
    #[inline(always)]
    fn weigh<'v>(&self, shifted: impl Fn(isize) -> &'v [f32], sums: &mut [f32]) {
        for (sum, value) in sums.iter_mut().zip(shifted(0)) {
            *sum = self.weights[0] * value;
        }
        for (i, weight) in (1..).zip(&self.weights[1..]) {
            let pairs = shifted(-i).iter().zip(shifted(i));
            for (sum, (before, after)) in sums.iter_mut().zip(pairs) {
                *sum += weight * (after + self.mirrored * before);
            }
        }
    }
}

/// ∂x and ∂y of a channel, blurred.
fn slopes(channel: &Plane<f32>, kernels: &Kernels) -> Plane<[f32; 2]> {
    let mut slopes = Plane::filled(channel.width(), channel.height(), [0.0; 2]);
    if channel.width() > 0 {
        let mut buffers = RowBuffers::new(channel.width(), kernels);
        for y in 0..channel.height() {
            slopes_of_row(channel, y, kernels, &mut buffers, slopes.row_mut(y));
        }
    }
    slopes
}

/// Memory for one row.
struct RowBuffers {
    /// The row blurred, and differentiated, downwards; continued at both ends as far as the kernels reach.
    down: [Vec<f32>; 2],
    /// The first of these differentiated, the second blurred, along the row: ∂x and ∂y.
    along: [Vec<f32>; 2],
}

impl RowBuffers {
    fn new(width: usize, kernels: &Kernels) -> Self {
        let ends = 2 * (kernels.blur.weights.len() - 1);
        Self {
            down: [(); 2].map(|()| vec![0.0; width + ends]),
            along: [(); 2].map(|()| vec![0.0; width]),
        }
    }
}

/// The bits are the same for every instruction set; only the width of the loops differs.
#[multiversion::multiversion(targets("x86_64+avx2", "x86_64+avx512f+avx512vl"))]
fn slopes_of_row(
    channel: &Plane<f32>,
    y: usize,
    kernels: &Kernels,
    buffers: &mut RowBuffers,
    slopes: &mut [[f32; 2]],
) {
    let Kernels { blur, slope } = kernels;
    let (width, reach) = (slopes.len(), blur.weights.len() - 1);
    let last = channel.height() - 1;

    let downwards = |i: isize| channel.row(y.saturating_add_signed(i).min(last));
    for (row, kernel) in buffers.down.iter_mut().zip([blur, slope]) {
        kernel.weigh(downwards, &mut row[reach..reach + width]);
        let (first, last) = (row[reach], row[reach + width - 1]);
        row[..reach].fill(first);
        row[reach + width..].fill(last);
    }

    let pairs = buffers.down.iter().zip(&mut buffers.along);
    for ((row, along), kernel) in pairs.zip([slope, blur]) {
        kernel.weigh(|i| &row[reach.wrapping_add_signed(i)..][..width], along);
    }

    let [along_x, along_y] = &buffers.along;
    for (slope, (x, y)) in slopes.iter_mut().zip(along_x.iter().zip(along_y)) {
        *slope = [*x, *y];
    }
}

/// J of one channel's slopes: xx, xy, yy.
fn tensor([x, y]: [f32; 2]) -> [f32; 3] {
    [x * x, x * y, y * y]
}

/// √λ·v of a tensor xx, xy, yy, with its larger eigenvalue λ and the unit eigenvector v.
fn strongest([xx, xy, yy]: [f32; 3]) -> [f32; 2] {
    let half = 0.5 * (xx - yy);
    let root = length([half, xy]);
    let larger = (0.5 * (xx + yy) + root).max(0.0);
    // twice the angle of the eigenvector is the angle of (half, xy), or any if that is zero
    let cosine = if root > 0.0 { half / root } else { 1.0 };
    let along = |sign: f32| (0.5 * larger * (1.0 + sign * cosine)).max(0.0).sqrt();
    [along(1.0), along(-1.0).copysign(xy)]
}

fn length([x, y]: [f32; 2]) -> f32 {
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(value: impl Fn(f64, f64) -> f32) -> Plane<f32> {
        let values = (0..40 * 30).map(|i| value(f64::from(i % 40), f64::from(i / 40)));
        Plane::from_values(40, 30, values.collect()).unwrap()
    }

    #[test]
    fn a_slope_has_its_own_gradient_at_every_scale() {
        let slope = plane(|x, y| (3.0 * x + 4.0 * y) as f32);
        for sigma_px in [0.7, 1.0, 2.0] {
            let gradient = Gradient::new(std::slice::from_ref(&slope), sigma_px);
            let found = gradient.at(&Point2::new(20.3, 15.6), &Vector2::new(1.0, 0.0));
            approx::assert_relative_eq!(found, Vector2::new(3.0, 4.0), epsilon = 1e-3);
            for (x, y, fast) in [(0.6, 0.8, 5.0), (-1.0, 0.0, 3.0), (0.8, -0.6, 0.0)] {
                let along = gradient.along(&Point2::new(20.3, 15.6), &Vector2::new(x, y));
                approx::assert_relative_eq!(along, fast, epsilon = 1e-3);
            }
        }
    }

    #[test]
    fn an_edge_that_only_colour_shows_is_seen() {
        let left = plane(|x, _| if x < 20.0 { 0.0 } else { 100.0 });
        let right = plane(|x, _| if x < 20.0 { 100.0 } else { 0.0 });
        let gradient = Gradient::new(&[left, right], 1.0);
        let found = gradient.at(&Point2::new(19.5, 15.0), &Vector2::new(-1.0, 0.0));
        assert!(found.x < -30.0 && found.y.abs() < 1e-3, "{found}");
    }

    #[test]
    fn what_is_not_known_has_no_gradient_and_nothing_lies_beyond() {
        let holed = plane(|x, y| if x > 30.0 { f32::NAN } else { (x + y) as f32 });
        let gradient = Gradient::new(&[holed], 1.0);
        let any = Vector2::new(1.0, 0.0);
        for (x, y) in [(35.0, 10.0), (-1.0, 3.0), (39.5, 3.0), (3.0, f64::NAN)] {
            assert!(gradient.at(&Point2::new(x, y), &any).norm() < 1e-9);
        }
        assert_eq!(Gradient::new(&[], 1.0).width(), 0);
    }

    #[test]
    fn hysteresis_keeps_the_weak_only_beside_the_strong() {
        let mut vectors = Plane::filled(6, 1, [0.0f32; 2]);
        vectors.row_mut(0).copy_from_slice(&[
            [9.0, 0.0],
            [5.0, 0.0],
            [5.0, 0.0],
            [0.0, 0.0],
            [5.0, 0.0],
            [0.0, 9.0],
        ]);
        let kept = Gradient { vectors }.hysteresis(4.0, 8.0).magnitude();
        assert_eq!(kept.values(), [9.0, 5.0, 0.0, 0.0, 5.0, 9.0]);
    }
}
