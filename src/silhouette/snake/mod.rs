//! Active contours: curves that are drawn to the edges of a picture and resist being bent (PF02 § 4).
//!
//! A curve x(s) minimises
//!
//! E = ½ ∫ α‖d′‖² + β‖d″‖² ds + ½ ∫ w ‖x − e‖² + (1 − w) κ ‖d‖² ds,   d = x − x⁰,
//!
//! with e an edge of the filtered gradient G on the curve's normal: the external energy. Of the edges on a normal, the one
//! with the largest g·exp(−½(‖e − x⁰‖/ρ)²) counts, g = |G·n|: strong, and near to where the contour is expected. Its weight
//! is w = g/(g + g₀)·exp(−½(‖e − x⁰‖/ρ)²); where there is no edge, the model's outline holds the curve by κ. √α and ⁴√β are
//! lengths: over them the edges' displacements are smoothed, and gaps without an edge are bridged.
//!
//! The internal energy is that of the *displacement* from the expected curve x⁰, the outline of the model.
//! **Differs** from PF02 § 4 (and from Kass, Witkin & Terzopoulos, 1988), whose snake is at rest when it is straight: theirs
//! "forced it to retract from the sections of high curvature" and cut the elbow in its frame 100. [`Rest::Straight`] is theirs.
//!
//! Each step is implicit in the internal energy and explicit in the external one: (I + τA) d ← d + τ w (e − x), solved in
//! O(n) (`banded.rs`), factored once for all steps between two resamplings. It ends when no point moves.

mod banded;
mod crossing;
mod curve;

use nalgebra::{Point2, Vector2};

use crate::image::Gradient;
use crate::math::parabola::summit;
use banded::Banded;
pub use crossing::area_on_the_left;
pub use curve::{Ends, outward};
use curve::{evenly, normal, sides};

/// Where the internal energy is at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// In the shape of the curve that it started from.
    Expected,
    /// Straight and short, as published.
    Straight,
}

/// Settings of an active contour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SnakeOptions {
    /// α, px². Default 4: displacements are smoothed over 2 px.
    pub tension: f64,
    /// β, px⁴. Default 80: displacements bend over 3 px, which bridges gaps in an edge and keeps the shape of a finger.
    pub stiffness: f64,
    /// τ. Default 1: with full weight an edge is reached in one step.
    pub time_step: f64,
    /// h: distance of neighbouring points, px. Default 2.
    pub spacing_px: f64,
    /// How far from the curve edges are looked for on either side, px. Default 8.
    pub search_px: f64,
    /// ρ: standard deviation of the border about where it is expected, px. Default 4.
    pub prior_px: f64,
    /// κ: weight of the expected curve where there is no edge, against a sure edge; only with [`Rest::Expected`]. Default 0.1:
    /// a sure edge that is off by ½ρ is followed to 99 %, by ρ to 94 %; one farther away may be another's, and counts less.
    pub hold: f64,
    /// g₀: the edge that counts half, grey levels per pixel. Default 5.
    pub edge: f64,
    /// The contour is at rest when no point moves farther than this in a step, px. Default 0.05.
    pub rest_px: f64,
    /// Steps at most. Default 60.
    pub most_steps: usize,
    /// Where the internal energy is at rest. Default [`Rest::Expected`].
    pub rest: Rest,
}

impl Default for SnakeOptions {
    fn default() -> Self {
        Self {
            tension: 4.0,
            stiffness: 80.0,
            time_step: 1.0,
            spacing_px: 2.0,
            search_px: 8.0,
            prior_px: 4.0,
            hold: 0.1,
            edge: 5.0,
            rest_px: 0.05,
            most_steps: 60,
            rest: Rest::Expected,
        }
    }
}

/// A point of an active contour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SnakePoint {
    /// Where, undistorted px.
    pub pixel: Point2<f64>,
    /// Where it was expected.
    pub expected: Point2<f64>,
    /// How sure it is that the border is here, 0 to 1, from the strength of the edge, its direction, and its distance from
    /// where it was expected; see [`Snake::points`].
    pub reliability: f64,
}

/// An active contour.
#[derive(Clone, Debug)]
pub struct Snake {
    options: SnakeOptions,
    ends: Ends,
    expected: Vec<Point2<f64>>,
    points: Vec<Point2<f64>>,
    step: Banded,
}

/// Points nearer to the picture's border than this are held where they are expected: beyond it, nothing is known.
const HELD_PX: f64 = 3.0;
/// The curve is resampled when a side is longer than this many times the mean.
const UNEVEN: f64 = 2.0;
/// Steps between two such tests.
const RESAMPLED_EVERY: usize = 10;
/// Loops of less than this share of the curve's area are folds.
const FOLD: f64 = 0.02;

impl Snake {
    /// A contour expected along a curve, with the inside on the left as seen on the screen.
    ///
    /// `None` if the curve is not finite, or too short for eight points.
    pub fn new(curve: &[Point2<f64>], ends: Ends, options: SnakeOptions) -> Option<Self> {
        let places = evenly(curve, ends, options.spacing_px);
        let expected: Vec<Point2<f64>> = places.iter().map(|p| p.on(curve)).collect();
        if expected.len() < 8 || !expected.iter().all(|p| p.x.is_finite() && p.y.is_finite()) {
            return None;
        }
        Some(Self {
            step: factored(&expected, ends, &options)?,
            points: expected.clone(),
            expected,
            ends,
            options,
        })
    }

    /// The contour as it is, to go on with other settings.
    pub fn with(self, options: SnakeOptions) -> Option<Self> {
        Some(Self { step: factored(&self.points, self.ends, &options)?, options, ..self })
    }

    /// Moves the contour until it is at rest on the edges of a gradient; `false` if it runs out of steps before.
    pub fn settle(&mut self, gradient: &Gradient) -> bool {
        for step in 1..=self.options.most_steps {
            let moved = self.advance(gradient);
            if moved < self.options.rest_px {
                return true;
            }
            if step % RESAMPLED_EVERY == 0 {
                self.resample_if_uneven();
            }
        }
        false
    }

    /// One step: (I + τA) d ← d + τ w (e − x); how far the point went that went farthest, px.
    fn advance(&mut self, gradient: &Gradient) -> f64 {
        let tau = self.options.time_step;
        // x⁰, from which displacements count
        let rest = |i: usize| match self.options.rest {
            Rest::Expected => self.expected[i].coords,
            Rest::Straight => Vector2::zeros(),
        };
        let pulled = |i: usize| self.points[i].coords - rest(i) + self.pull(gradient, i) * tau;
        let mut moved: Vec<Vector2<f64>> = (0..self.points.len()).map(pulled).collect();
        self.step.solve(&mut moved);

        let mut farthest: f64 = 0.0;
        for (i, displacement) in moved.into_iter().enumerate() {
            let to = Point2::from(rest(i) + displacement);
            farthest = farthest.max((to - self.points[i]).norm());
            self.points[i] = to;
        }
        farthest
    }

    /// w (e − x) + (1 − w) κ (x⁰ − x).
    fn pull(&self, gradient: &Gradient, i: usize) -> Vector2<f64> {
        if is_held(&self.expected[i], gradient) {
            return self.expected[i] - self.points[i];
        }
        let Some(normal) = normal(&self.points, self.ends, i) else {
            return Vector2::zeros();
        };

        let home = match self.options.rest {
            Rest::Expected => (self.expected[i] - self.points[i]) * self.options.hold,
            Rest::Straight => Vector2::zeros(),
        };
        let Some((to, g)) = self.edge(gradient, i, &normal) else {
            return home;
        };
        let weight = g / (g + self.options.edge) * self.nearness(i, &(self.points[i] + to));
        to * weight + home * (1.0 - weight)
    }

    /// e − x, and g there; `None` without an edge within reach.
    fn edge(
        &self,
        gradient: &Gradient,
        i: usize,
        normal: &Vector2<f64>,
    ) -> Option<(Vector2<f64>, f64)> {
        let change = |s: f64| gradient.along(&(self.points[i] + normal * s), normal);
        let reach = self.options.search_px.round() as i32;

        let mut best = (0, 0.0);
        for s in -reach..=reach {
            let g = change(f64::from(s));
            // nearness is 1 at most, so most places need not ask for it
            if g > best.1 {
                let score = g * self.nearness(i, &(self.points[i] + normal * f64::from(s)));
                if score > best.1 {
                    best = (s, score);
                }
            }
        }
        if best.1 <= 0.0 {
            return None;
        }

        // between the pixels: the summit of the parabola through three values of g, without the nearness
        let at = f64::from(best.0);
        let offset = summit([at - 1.0, at, at + 1.0].map(change));
        Some((normal * (at + offset), change(at + offset)))
    }

    /// exp(−½(‖x − x⁰‖/ρ)²); without an expected shape, from where the curve is.
    fn nearness(&self, i: usize, place: &Point2<f64>) -> f64 {
        let from = match self.options.rest {
            Rest::Expected => &self.expected[i],
            Rest::Straight => &self.points[i],
        };
        let rho = self.options.prior_px;
        (-0.5 * (place - from).norm_squared() / (rho * rho)).exp()
    }

    /// Points at equal distances again, and the expected curve with them.
    fn resample_if_uneven(&mut self) {
        let sides = sides(&self.points, self.ends);
        let mean = sides.iter().sum::<f64>() / sides.len().max(1) as f64;
        if !sides.iter().any(|side| *side > UNEVEN * mean) {
            return;
        }

        let places = evenly(&self.points, self.ends, self.options.spacing_px);
        let points: Vec<_> = places.iter().map(|p| p.on(&self.points)).collect();
        if let Some(step) = factored(&points, self.ends, &self.options) {
            self.expected = places.iter().map(|p| p.on(&self.expected)).collect();
            self.points = points;
            self.step = step;
        }
    }

    /// The points of the contour.
    ///
    /// Reliability is w·cos²·exp(−½(‖x − x⁰‖/ρ)²): w of the edge under the point, the cosine between the gradient there and the
    /// expected curve's normal; 0 at the picture's border.
    pub fn points(&self, gradient: &Gradient) -> Vec<SnakePoint> {
        (0..self.points.len())
            .map(|i| SnakePoint {
                pixel: self.points[i],
                expected: self.expected[i],
                reliability: self.reliability(gradient, i),
            })
            .collect()
    }

    fn reliability(&self, gradient: &Gradient, i: usize) -> f64 {
        let expected = normal(&self.expected, self.ends, i);
        let Some(expected) = expected.filter(|_| !is_held(&self.expected[i], gradient)) else {
            return 0.0;
        };
        let there = gradient.at(&self.points[i], &expected);
        let g = there.norm();
        let cosine = there.dot(&expected) / g.max(f64::MIN_POSITIVE);
        let rho = self.options.prior_px;
        let off = (self.points[i] - self.expected[i]).norm_squared() / (rho * rho);
        g / (g + self.options.edge) * cosine * cosine * (-0.5 * off).exp()
    }

    /// The simple loops of the curve, as indices into its points; an open curve is one loop.
    ///
    /// A closed curve that crosses itself is cut into loops. Those that run around the other side are folds, and left out.
    pub fn loops(&self) -> Vec<Vec<usize>> {
        if self.ends == Ends::Open {
            return vec![(0..self.points.len()).collect()];
        }

        let area = area_on_the_left(&self.expected);
        let is_loop = |curve: &Vec<usize>| {
            let points: Vec<_> = curve.iter().map(|&i| self.points[i]).collect();
            points.len() >= 8 && area_on_the_left(&points) / area > FOLD
        };
        crossing::loops(&self.points).into_iter().filter(is_loop).collect()
    }
}

fn factored(points: &[Point2<f64>], ends: Ends, options: &SnakeOptions) -> Option<Banded> {
    let sides = sides(points, ends);
    let h = sides.iter().sum::<f64>() / sides.len().max(1) as f64;
    let tau = options.time_step;
    let bend = [tau * options.tension / (h * h), tau * options.stiffness / h.powi(4)];
    Banded::new(points.len(), ends, bend)
}

fn is_held(place: &Point2<f64>, gradient: &Gradient) -> bool {
    let inside = |x: f64, size: usize| x >= HELD_PX && x <= size as f64 - 1.0 - HELD_PX;
    !(inside(place.x, gradient.width()) && inside(place.y, gradient.height()))
}

#[cfg(test)]
mod tests;
