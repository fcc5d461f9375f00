//! Where matching begins: corners of the template, found in all images without knowing their depth.

use nalgebra::{Matrix2, Point2, Point3};
use rayon::prelude::*;

use super::multi_image::{DepthPlane, Patch};
use super::{MatchOptions, MatchViews, OtherView};
use crate::stereo::bicubic::sample;

/// Length of a step along the epipolar line, px in the image with the longest.
const STEP_PX: f64 = 0.7;
/// Most steps along the line.
const MOST_STEPS: usize = 2000;
/// A third of an image: the largest shift that is tried where no depth is given.
const LARGEST_SHIFT: f64 = 1.0 / 3.0;
/// By how much the correlation coefficient of the best place exceeds that of any other, at least.
const LEAST_LEAD: f64 = 0.05;
/// Places nearer to each other than this count as one, px.
const SAME_PX: f64 = 3.0;
/// Radius of the patch that is correlated, px.
const RADIUS_PX: usize = 5;
/// Least mean squared slope in the direction in which it is least, (grey levels/px)².
pub(super) const LEAST_TEXTURE: f64 = 4.0;

/// A pixel of the template whose depth is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seed {
    pub(super) pixel: (usize, usize),
    pub(super) plane: DepthPlane,
}

/// The given seeds and those found, row by row; each matched by least squares.
pub(super) fn find(
    views: &MatchViews<'_>,
    given: &[Point3<f64>],
    options: &MatchOptions,
) -> Vec<Seed> {
    let cell = options.seed_cell_px;
    let (width, height) = (views.template.image.width(), views.template.image.height());
    let (columns, rows) = (width.div_ceil(cell), height.div_ceil(cell));

    let refined = |seed: Seed| {
        let found = views.find(seed.pixel, &seed.plane, options.radius_px, options).ok()?;
        Some(Seed { plane: found.plane, ..seed })
    };
    let given = given.iter().filter_map(|point| given_seed(views, point));
    let mut seeds: Vec<Seed> = given.filter_map(refined).collect();

    let found: Vec<Option<Seed>> = (0..columns * rows)
        .into_par_iter()
        .map(|i| {
            let corner = corner(views, i % columns * cell, i / columns * cell, cell)?;
            refined(along_the_line(views, corner, options)?)
        })
        .collect();
    seeds.extend(found.into_iter().flatten());
    seeds
}

fn given_seed(views: &MatchViews<'_>, point_world: &Point3<f64>) -> Option<Seed> {
    let camera = &views.template.camera;
    let pixel = camera.project_undistorted(point_world)?;
    let depth = (camera.camera_from_world * point_world).z;
    let inside = pixel.x >= 0.0 && pixel.y >= 0.0;
    inside.then_some(Seed {
        pixel: (pixel.x.round() as usize, pixel.y.round() as usize),
        plane: DepthPlane { w: 1.0 / depth, slope: [0.0; 2] },
    })
}

/// The pixel with the most texture in the square cell whose first pixel is (left, top).
fn corner(views: &MatchViews<'_>, left: usize, top: usize, cell: usize) -> Option<(usize, usize)> {
    let pixels = (0..cell * cell).step_by(2).map(|i| (left + i % cell, top + i / cell));
    let usable = pixels.filter(|(x, y)| views.shows_subject(*x, *y));
    let rated = usable.map(|pixel| (texture(views, pixel, RADIUS_PX), pixel));
    let best = rated.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 >= LEAST_TEXTURE).then_some(best.1)
}

/// The smaller eigenvalue of the mean of ∇f·∇fᵀ around a pixel; 0 near the edge.
///
/// # Source
/// Shi & Tomasi 1994, *Good features to track*.
pub(super) fn texture(views: &MatchViews<'_>, pixel: (usize, usize), radius: usize) -> f64 {
    let (x, y) = pixel;
    let image = &views.template.image;
    let margin = radius + 1;
    if x < margin || y < margin || x + margin >= image.width() || y + margin >= image.height() {
        return 0.0;
    }

    let mut tensor = [0.0f32; 3];
    for row in y - radius..=y + radius {
        let (above, here, below) = (image.row(row - 1), image.row(row), image.row(row + 1));
        for column in x - radius..=x + radius {
            let dx = 0.5 * (here[column + 1] - here[column - 1]);
            let dy = 0.5 * (below[column] - above[column]);
            tensor[0] += dx * dx;
            tensor[1] += dx * dy;
            tensor[2] += dy * dy;
        }
    }

    let [xx, xy, yy] = tensor.map(|sum| f64::from(sum) / (2 * radius + 1).pow(2) as f64);
    let least = Matrix2::new(xx, xy, xy, yy).symmetric_eigenvalues().min();
    if least.is_finite() { least } else { 0.0 }
}

/// A place on the epipolar lines of a pixel.
#[derive(Debug, Clone, Copy)]
struct LinePlace {
    /// How far from the first place, px.
    shift: f64,
    /// Inverse depth, 1/m.
    w: f64,
}

/// The inverse depth at which the corner looks most alike in all images, if it is the only one.
fn along_the_line(
    views: &MatchViews<'_>,
    pixel: (usize, usize),
    options: &MatchOptions,
) -> Option<Seed> {
    let patch = Patch::at(views, pixel, RADIUS_PX);
    let rated = places(views, pixel, options).into_iter();
    let rated = rated.filter_map(|place| {
        let coefficients = (0..views.others.len()).map(|i| correlation(views, &patch, i, place.w));
        // the image with the least correlation counts; those that do not see the place do not
        let mut known: Vec<f64> = coefficients.flatten().collect();
        known.sort_by(f64::total_cmp);
        let is_enough = known.len() >= options.least_images;
        is_enough.then(|| known.first().map(|least| (*least, place)))?
    });
    let rated: Vec<(f64, LinePlace)> = rated.collect();

    let (best, place) = *rated.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let elsewhere = rated.iter().filter(|(_, other)| (other.shift - place.shift).abs() > SAME_PX);
    let next = elsewhere.map(|other| other.0).fold(-1.0, f64::max);
    let is_found = best >= options.least_correlation && next <= best - LEAST_LEAD;
    is_found.then_some(Seed { pixel, plane: DepthPlane { w: place.w, slope: [0.0; 2] } })
}

/// The places that are tried, a step apart.
fn places(views: &MatchViews<'_>, pixel: (usize, usize), options: &MatchOptions) -> Vec<LinePlace> {
    let (mut w, last, most) = match options.depth {
        Some((near, far)) => (1.0 / far, 1.0 / near, f64::INFINITY),
        None => {
            let width = views.template.image.width() as f64;
            (0.0, f64::INFINITY, LARGEST_SHIFT * width)
        }
    };

    let (mut places, mut shift) = (Vec::new(), 0.0);
    while w <= last && shift <= most && places.len() < MOST_STEPS {
        places.push(LinePlace { shift, w });
        let reach = views.reach(pixel, w);
        if reach <= 0.0 {
            break;
        }
        w += STEP_PX / reach;
        shift += STEP_PX;
    }
    places
}

/// Correlation coefficient of the patch, parallel to the image plane, with one image; `None` where it is not seen.
fn correlation(views: &MatchViews<'_>, patch: &Patch, image: usize, w: f64) -> Option<f64> {
    let OtherView { view, epipolar } = &views.others[image];
    let direction = epipolar.direction(&patch.middle());
    let middle = epipolar.image(&direction, w)?.pixel;
    let [right, down] = epipolar.steps();
    // across a small patch the map is affine
    let right = epipolar.image(&(direction + right), w)?.pixel - middle;
    let down = epipolar.image(&(direction + down), w)?.pixel - middle;

    let mut sums = [0.0; 6];
    for pixel in patch.pixels() {
        let place: Point2<f64> = middle + right * pixel.dx + down * pixel.dy;
        let g = f64::from(sample(&view.image, place.x, place.y)?.value);
        let f = f64::from(pixel.value);
        for (sum, term) in sums.iter_mut().zip([1.0, f, g, f * f, g * g, f * g]) {
            *sum += term;
        }
    }

    let [n, f, g, ff, gg, fg] = sums;
    let (ff, gg, fg) = (ff - f * f / n, gg - g * g / n, fg - f * g / n);
    // less than a grey level of contrast is none
    (ff > n && gg > n).then(|| fg / (ff * gg).sqrt())
}
