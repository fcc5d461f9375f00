//! The points that a pair of cameras would see on the skin.

use nalgebra::{Matrix3, Point2, Vector3};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

use crate::body::Posed;
use crate::body::metaball::{Field, Metaball, THRESHOLD};
use crate::camera::{Camera, Ray};
use crate::stereo::{CloudPoint, Spread};

/// A ray is followed where d of a metaball is less than this: e^(−2·3) = 0.0025, and 200 farther metaballs together do not
/// reach T.
const FARTHEST: f64 = 3.0;
/// Steps along a ray for each of the thinnest metaball's smallest semi-axes.
const STEPS_PER_AXIS: f64 = 6.0;
/// Halvings of a step, down to 10⁻⁹ of it.
const HALVINGS: usize = 30;

/// A second camera beside a given one, how well the two images are matched, and where they are not.
///
/// A disparity error of σ_d pixels displaces a point at depth z by σ_z = z² σ_d / (f b) along the line of sight; an error of
/// the match by σ_d pixels displaces it by z σ_d / f across. Each point states the errors from which its own are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StereoPair {
    /// b, distance between the two cameras, metres.
    pub baseline: f64,
    /// σ_d, standard deviation of a disparity on a surface that faces the camera.
    pub disparity_sd_px: f64,
    /// One match in so many columns and rows.
    pub step_px: u32,
    /// Greatest angle between line of sight and surface normal at which a surface is still matched, radians. On a slanted
    /// surface the disparity errs by 1/cos as much (PF02 § 3: it “becomes unreliable when the surface slants away from the
    /// cameras”).
    pub steepest: f64,
    /// Share of the matches that are false.
    pub outliers: f64,
    /// False matches lie anywhere between 1 − this and 1 + this of the true depth.
    pub outlier_range: f64,
}

impl Default for StereoPair {
    /// Cameras 30 cm apart, a third of a pixel, every fourth pixel, up to 70° from facing, one false match in fifty.
    fn default() -> Self {
        Self {
            baseline: 0.3,
            disparity_sd_px: 0.33,
            step_px: 4,
            steepest: 70.0_f64.to_radians(),
            outliers: 0.02,
            outlier_range: 0.15,
        }
    }
}

impl StereoPair {
    /// The points on the skin that are seen from `camera` and matched, in the order of its pixels.
    ///
    /// Every pixel of the grid draws the same number of random values, whether it sees anything or not.
    pub fn points(&self, camera: &Camera, body: &Posed<'_>, rng: &mut impl Rng) -> Vec<CloudPoint> {
        let skin = Skin::new(body);
        let step = self.step_px.max(1) as usize;
        let mut points = Vec::new();
        for y in (0..camera.height_px).step_by(step) {
            for x in (0..camera.width_px).step_by(step) {
                let drawn = Draws::new(rng);
                let pixel = camera.undistort(&Point2::new(f64::from(x), f64::from(y)));
                let ray = pixel.map(|pixel| camera.ray(&pixel));
                points.extend(ray.and_then(|ray| self.point(camera, &skin, &ray, &drawn)));
            }
        }
        points
    }

    fn point(&self, camera: &Camera, skin: &Skin, ray: &Ray, drawn: &Draws) -> Option<CloudPoint> {
        let distance = skin.first_hit(ray)?;
        let place = ray.point_at(distance);
        let (_, gradient) = skin.field.value_and_gradient(&place.coords);
        // the gradient points into the body, as the ray does
        let inward = gradient.try_normalize(0.0)?;
        let facing = inward.dot(&ray.direction_world);
        if facing < self.steepest.cos() {
            return None;
        }

        // standard deviations across the line of sight and along it
        let depth = (camera.camera_from_world * place).z;
        let focal_px = camera.intrinsics.focal_px();
        let across = depth * self.disparity_sd_px / focal_px;
        let along = across * depth / (self.baseline * facing);

        let d = ray.direction_world.as_ref();
        let d_dt = d * d.transpose();
        let error = drawn.normal * across + d * (d.dot(&drawn.normal) * (along - across));
        let stray = if drawn.outlier < self.outliers {
            d * (distance * self.outlier_range * drawn.stray)
        } else {
            Vector3::zeros()
        };
        Some(CloudPoint {
            position_world: place + error + stray,
            spread: Spread::Full(
                d_dt * (along * along) + (Matrix3::identity() - d_dt) * (across * across),
            ),
        })
    }
}

/// The random values of one pixel.
struct Draws {
    normal: Vector3<f64>,
    /// Uniform in 0 to 1.
    outlier: f64,
    /// Uniform in −1 to 1.
    stray: f64,
}

impl Draws {
    fn new(rng: &mut impl Rng) -> Self {
        Self {
            normal: Vector3::from_fn(|_, _| StandardNormal.sample(rng)),
            outlier: rng.random_range(0.0..1.0),
            stray: rng.random_range(-1.0..1.0),
        }
    }
}

/// The field of a body, and the metaballs that show where a ray can meet it.
struct Skin {
    field: Field,
    metaballs: Vec<Metaball>,
    /// Metres between the places on a ray at which F is evaluated.
    step: f64,
}

impl Skin {
    fn new(body: &Posed<'_>) -> Self {
        let primitives = body.model.metaballs.iter();
        let metaballs: Vec<Metaball> =
            primitives.filter_map(|primitive| Metaball::new(body.primitive(primitive))).collect();
        let smallest = metaballs.iter().map(|m| {
            let squared = m.ellipsoid.shape.symmetric_eigenvalues();
            squared.min().max(0.0).sqrt()
        });
        Self {
            field: Field::from_body(body),
            step: smallest.fold(f64::INFINITY, f64::min).max(1e-3) / STEPS_PER_AXIS,
            metaballs,
        }
    }

    /// Distance along a ray to where F first reaches T, metres.
    fn first_hit(&self, ray: &Ray) -> Option<f64> {
        let (near, far) = self.reach(ray)?;
        let is_inside = |t: f64| self.field.value(&ray.point_at(t).coords) >= THRESHOLD;
        let steps = ((far - near) / self.step).ceil() as usize;

        // the first step into the body, halved
        let first = (1..=steps).find(|k| is_inside(near + *k as f64 * self.step))?;
        let mut outside = near + (first - 1) as f64 * self.step;
        let mut inside = outside + self.step;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (outside + inside);
            if is_inside(middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        Some(inside)
    }

    /// Where the ray, before its origin, is near any metaball.
    fn reach(&self, ray: &Ray) -> Option<(f64, f64)> {
        let spans = self.metaballs.iter().filter_map(|m| {
            let offset = ray.origin_world.coords - m.ellipsoid.centre;
            let d = ray.direction_world.as_ref();
            let pull = m.precision * d;
            let (a, b) = (d.dot(&pull), offset.dot(&pull));
            let c = offset.dot(&(m.precision * offset)) - FARTHEST;
            let root = (b * b - a * c).sqrt();
            let far = (-b + root) / a;
            // NaN where the ray passes by
            (far > 0.0).then(|| (((-b - root) / a).max(0.0), far))
        });
        spans.reduce(|one, other| (one.0.min(other.0), one.1.max(other.1)))
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::body::{BodyModel, Motion, Shape};
    use crate::synth::Ring;

    const EXACT: StereoPair = StereoPair {
        baseline: 0.3,
        disparity_sd_px: 0.0,
        step_px: 6,
        steepest: 1.5,
        outliers: 0.0,
        outlier_range: 0.2,
    };

    fn walker() -> BodyModel {
        let text = include_str!("../../data/models/walker-metaballs.toml");
        crate::io::model::parse(text, std::path::Path::new("walker-metaballs.toml")).unwrap()
    }

    /// A standing person 1 m above the origin, seen by one camera.
    fn seen(pair: &StereoPair, seed: u64, mut test: impl FnMut(&Camera, &Field, &[CloudPoint])) {
        let model = walker();
        let mut motion = Motion::rest(&model);
        motion.position_world = Vector3::new(0.0, 0.0, 0.95);
        let shape = Shape(model.statistics.mean.clone());
        let body = Posed::new(&model, &shape, &motion);
        let camera = &Ring::default().regular().cameras[0];
        let points = pair.points(camera, &body, &mut ChaCha8Rng::seed_from_u64(seed));
        test(camera, &Field::from_body(&body), &points);
    }

    #[test]
    fn without_errors_points_are_on_the_skin_and_the_first_of_their_line_of_sight() {
        seen(&EXACT, 1, |camera, field, points| {
            assert!(points.len() > 150, "{}", points.len());
            for point in points {
                let place = point.position_world;
                let value = field.value(&place.coords);
                approx::assert_relative_eq!(value, THRESHOLD, epsilon = 1e-6);
                let to_camera = camera.centre_world() - place;
                let before = (1..400).map(|k| place + to_camera * (f64::from(k) * 1e-3 + 1e-4));
                assert!(before.into_iter().all(|p| field.value(&p.coords) < THRESHOLD));
            }
        });
    }

    #[test]
    fn errors_have_the_spread_that_points_state_and_grow_with_the_square_of_the_depth() {
        let pair = StereoPair { disparity_sd_px: 0.2, step_px: 3, ..EXACT };
        let mut exact = Vec::new();
        let same_pixels = StereoPair { disparity_sd_px: 0.0, ..pair };
        seen(&same_pixels, 1, |_, _, points| exact.extend(points.to_vec()));
        seen(&pair, 1, |camera, _, points| {
            assert_eq!(points.len(), exact.len());
            let (mut along, mut across) = (0.0, 0.0);
            for (point, true_point) in points.iter().zip(&exact) {
                let error = point.position_world - true_point.position_world;
                let d =
                    camera.ray(&camera.project_undistorted(&true_point.position_world).unwrap());
                let d = d.direction_world.into_inner();
                let side = nalgebra::Unit::new_normalize(d.cross(&Vector3::z())).into_inner();
                along += (error.dot(&d) / point.spread.along(&d).unwrap()).powi(2);
                across += (error.dot(&side) / point.spread.along(&side).unwrap()).powi(2);
                let depth = (camera.camera_from_world * true_point.position_world).z;
                let least = depth * depth * 0.2 / (660.0 * 0.3);
                assert!(point.spread.along(&d).unwrap() > 0.999 * least);
            }
            // χ² of about 1000 errors: 1 ± 0.14 (3 σ)
            let count = points.len() as f64;
            assert!(count > 700.0, "{count}");
            for mean in [along / count, across / count] {
                assert!((0.84..1.16).contains(&mean), "{mean}");
            }
        });
    }

    #[test]
    fn what_slants_away_is_not_matched() {
        let pair = StereoPair { steepest: 0.7, ..EXACT };
        seen(&pair, 1, |camera, field, points| {
            assert!(points.len() > 30);
            for point in points {
                let (_, gradient) = field.value_and_gradient(&point.position_world.coords);
                let sight = point.position_world - camera.centre_world();
                assert!(gradient.angle(&sight) < 0.7 + 1e-6);
            }
        });
    }

    /// 2000 points and a share of 0.3: ± 0.03 (3 σ).
    #[test]
    fn false_matches_have_their_share_and_stay_in_their_range() {
        let pair = StereoPair { outliers: 0.3, step_px: 2, ..EXACT };
        seen(&pair, 1, |camera, field, points| {
            let is_off =
                |p: &&CloudPoint| (field.value(&p.position_world.coords) - THRESHOLD).abs() > 1e-6;
            let share = points.iter().filter(is_off).count() as f64 / points.len() as f64;
            assert!((0.26..0.34).contains(&share), "{share}");
            let distance = |p: &CloudPoint| (p.position_world - camera.centre_world()).norm();
            assert!(points.iter().map(distance).all(|d| (3.0..6.5).contains(&d)));
        });
    }

    #[test]
    fn the_seed_decides() {
        let pair = StereoPair { step_px: 8, ..StereoPair::default() };
        let mut clouds = Vec::new();
        for seed in [5, 5, 6] {
            let mut cloud = Vec::new();
            seen(&pair, seed, |_, _, points| cloud.extend(points.to_vec()));
            clouds.push(cloud);
        }
        assert!(clouds[0] == clouds[1] && clouds[0] != clouds[2]);
    }
}
