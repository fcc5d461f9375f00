//! Where colours change, and how fast.
//!
//! The derivative is that of the picture blurred by a Gaussian of σ pixels: the scale at which edges are looked for. A
//! colour picture has one edge, not three: of the tensor J = Σ ∇I ∇Iᵀ over the channels the larger eigenvalue is the
//! squared magnitude, and its eigenvector the direction (Di Zenzo, *A note on the gradient of a multi-image*, CVGIP 33, 1986).

use nalgebra::{Point2, Vector2};

use super::{Mask, Plane};

/// Widths of the Gaussian after which its kernel ends.
const KERNEL_REACH: f64 = 3.0;

/// Magnitude and direction of the strongest change of a picture; across an edge, towards either side.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// Along x and y, grey levels per pixel; 0 where nothing is known.
    vectors: Plane<[f32; 2]>,
}

impl Gradient {
    /// The gradient of a picture's channels at the scale σ; 0 where a channel is not finite within 3 σ.
    ///
    /// Beyond its border the picture goes on as it ends. Channels of another size than the first are left out.
    pub fn of(channels: &[Plane<f32>], sigma_px: f64) -> Self {
        let Some(first) = channels.first() else {
            return Self {
                vectors: Plane::filled(0, 0, [0.0; 2]),
            };
        };
        let (width, height) = (first.width(), first.height());
        let (blur, slope) = kernels(sigma_px);
        let mut tensors = Plane::filled(width, height, [0.0f32; 3]);
        let same = |c: &&Plane<f32>| (c.width(), c.height()) == (width, height);
        for channel in channels.iter().filter(same) {
            let across = down(&along(channel, &slope), &blur);
            let downwards = down(&along(channel, &blur), &slope);
            for y in 0..height {
                let slopes = across.row(y).iter().zip(downwards.row(y));
                for (t, (gx, gy)) in tensors.row_mut(y).iter_mut().zip(slopes) {
                    *t = [t[0] + gx * gx, t[1] + gx * gy, t[2] + gy * gy];
                }
            }
        }
        Self {
            vectors: tensors.map(strongest),
        }
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
        self.vectors.map(|[x, y]| x.hypot(y))
    }

    /// The gradient at a place between pixels, from its four neighbours; 0 beyond the picture.
    ///
    /// Vectors of opposite sense are the same edge: each neighbour is turned to the sense of `towards`.
    pub fn at(&self, place: &Point2<f64>, towards: &Vector2<f64>) -> Vector2<f64> {
        if !(place.x >= 0.0 && place.y >= 0.0) {
            return Vector2::zeros();
        }
        let (x, y) = (place.x as usize, place.y as usize);
        let (s, t) = (place.x - x as f64, place.y - y as f64);
        let (upper, lower) = (self.vectors.row(y), self.vectors.row(y + 1));
        let (Some([a, b]), Some([c, d])) = (upper.get(x..x + 2), lower.get(x..x + 2)) else {
            return Vector2::zeros();
        };
        let turned = |v: &[f32; 2]| {
            let v = Vector2::new(f64::from(v[0]), f64::from(v[1]));
            if v.dot(towards) < 0.0 { -v } else { v }
        };
        (turned(a) * (1.0 - s) + turned(b) * s) * (1.0 - t)
            + (turned(c) * (1.0 - s) + turned(d) * s) * t
    }

    /// What of it lies on the foreground of a mask.
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

    /// What of it is above `high`, or above `low` beside a pixel that is above `high` (PF02 § 4.2).
    ///
    /// **Differs** from Canny, as the paper does: one step from a strong pixel, not a chain of them.
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
                let own = vector[0].hypot(vector[1]);
                if !(own >= high || (own >= low && strong_near(x, y))) {
                    *vector = [0.0; 2];
                }
            }
        }
        kept
    }
}

/// Gaussian and derivative of the Gaussian: of a constant the one makes the constant, of a slope of 1 the other makes 1.
fn kernels(sigma_px: f64) -> (Vec<f32>, Vec<f32>) {
    let sigma = sigma_px.max(0.3);
    let reach = (KERNEL_REACH * sigma).ceil() as i32;
    let gauss = |i: i32| (-0.5 * (f64::from(i) / sigma).powi(2)).exp();
    let sum: f64 = (-reach..=reach).map(gauss).sum();
    let moment: f64 = (-reach..=reach).map(|i| f64::from(i * i) * gauss(i)).sum();
    (-reach..=reach)
        .map(|i| {
            let value = gauss(i);
            ((value / sum) as f32, (f64::from(i) * value / moment) as f32)
        })
        .unzip()
}

/// Each row weighed by the kernel; the ends of a row go on.
fn along(plane: &Plane<f32>, kernel: &[f32]) -> Plane<f32> {
    let reach = kernel.len() / 2;
    let mut result = Plane::filled(plane.width(), plane.height(), 0.0);
    let mut row = Vec::with_capacity(plane.width() + 2 * reach);
    for y in 0..plane.height() {
        let values = plane.row(y);
        let (Some(first), Some(last)) = (values.first(), values.last()) else {
            continue;
        };
        row.clear();
        row.extend(std::iter::repeat_n(*first, reach));
        row.extend_from_slice(values);
        row.extend(std::iter::repeat_n(*last, reach));
        let windows = row.windows(kernel.len());
        for (out, window) in result.row_mut(y).iter_mut().zip(windows) {
            *out = window.iter().zip(kernel).map(|(v, k)| v * k).sum();
        }
    }
    result
}

/// Each column weighed by the kernel; the ends of a column go on.
fn down(plane: &Plane<f32>, kernel: &[f32]) -> Plane<f32> {
    let reach = kernel.len() / 2;
    let mut result = Plane::filled(plane.width(), plane.height(), 0.0);
    let last = plane.height().saturating_sub(1);
    for y in 0..plane.height() {
        for (i, weight) in kernel.iter().enumerate() {
            let from = plane.row((y + i).saturating_sub(reach).min(last));
            for (out, value) in result.row_mut(y).iter_mut().zip(from) {
                *out += weight * value;
            }
        }
    }
    result
}

/// √λ of the larger eigenvalue of a tensor xx, xy, yy, along its eigenvector; 0 where it is not finite.
fn strongest([xx, xy, yy]: [f32; 3]) -> [f32; 2] {
    let half = 0.5 * (xx - yy);
    let root = half.hypot(xy);
    let larger = (0.5 * (xx + yy) + root).max(0.0);
    // the double angle of the eigenvector is that of (half, xy); without one, any
    let cosine = if root > 0.0 { half / root } else { 1.0 };
    let along = |sign: f32| (0.5 * larger * (1.0 + sign * cosine)).max(0.0).sqrt();
    let vector = [along(1.0), along(-1.0).copysign(xy)];
    if vector.iter().all(|v| v.is_finite()) {
        vector
    } else {
        [0.0; 2]
    }
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
            let gradient = Gradient::of(std::slice::from_ref(&slope), sigma_px);
            let found = gradient.at(&Point2::new(20.3, 15.6), &Vector2::new(1.0, 0.0));
            approx::assert_relative_eq!(found, Vector2::new(3.0, 4.0), epsilon = 1e-3);
        }
    }

    #[test]
    fn an_edge_that_only_colour_shows_is_seen() {
        let left = plane(|x, _| if x < 20.0 { 0.0 } else { 100.0 });
        let right = plane(|x, _| if x < 20.0 { 100.0 } else { 0.0 });
        let gradient = Gradient::of(&[left, right], 1.0);
        let found = gradient.at(&Point2::new(19.5, 15.0), &Vector2::new(-1.0, 0.0));
        assert!(found.x < -30.0 && found.y.abs() < 1e-3, "{found}");
    }

    #[test]
    fn what_is_not_known_has_no_gradient_and_nothing_lies_beyond() {
        let holed = plane(|x, y| if x > 30.0 { f32::NAN } else { (x + y) as f32 });
        let gradient = Gradient::of(&[holed], 1.0);
        let any = Vector2::new(1.0, 0.0);
        for (x, y) in [(35.0, 10.0), (-1.0, 3.0), (39.5, 3.0), (3.0, f64::NAN)] {
            assert!(gradient.at(&Point2::new(x, y), &any).norm() < 1e-9);
        }
        assert_eq!(Gradient::of(&[], 1.0).width(), 0);
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
