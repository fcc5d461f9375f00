//! Where matching begins: corners of the template, found in all images without knowing their depth.

use nalgebra::{Matrix2, Point2, Point3};
use rayon::prelude::*;

use super::multi_image::{Patch, Plane3};
use super::{MatchOptions, Stage};
use crate::stereo::bicubic::sample;

/// Steps along the epipolar line, px in the image in which it moves most.
const STEP_PX: f64 = 0.7;
/// Steps at most.
const MOST_STEPS: usize = 2000;
/// A third of an image: the largest shift that is tried where no depth is given.
const LARGEST_SHIFT: f64 = 1.0 / 3.0;
/// How much less any other place must have.
const LEAST_LEAD: f64 = 0.05;
/// Places nearer than this are the same place, px.
const SAME_PX: f64 = 3.0;
/// Radius of the patch that is correlated, px.
const RADIUS_PX: usize = 5;
/// Least mean squared slope in the direction in which it is least, (grey levels/px)².
pub(super) const LEAST_TEXTURE: f64 = 4.0;

/// A pixel of the template whose depth is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seed {
    pub(super) pixel: (usize, usize),
    pub(super) plane: Plane3,
}

/// The given seeds and those found, row by row; each matched by least squares.
pub(super) fn find(stage: &Stage<'_>, given: &[Point3<f64>], options: &MatchOptions) -> Vec<Seed> {
    let cell = options.seed_cell_px;
    let (width, height) = (stage.template.image.width(), stage.template.image.height());
    let (columns, rows) = (width.div_ceil(cell), height.div_ceil(cell));
    let given = given.iter().filter_map(|point| given_seed(stage, point));
    let refined = |seed: Seed| {
        let found = stage
            .find(seed.pixel, &seed.plane, options.radius_px, options)
            .ok()?;
        Some(Seed {
            plane: found.plane,
            ..seed
        })
    };
    let mut seeds: Vec<Seed> = given.filter_map(refined).collect();
    let found: Vec<Option<Seed>> = (0..columns * rows)
        .into_par_iter()
        .map(|i| {
            let corner = corner(stage, (i % columns * cell, i / columns * cell), cell)?;
            refined(along_the_line(stage, corner, options)?)
        })
        .collect();
    seeds.extend(found.into_iter().flatten());
    seeds
}

fn given_seed(stage: &Stage<'_>, point_world: &Point3<f64>) -> Option<Seed> {
    let camera = &stage.template.camera;
    let pixel = camera.project_undistorted(point_world)?;
    let depth = (camera.camera_from_world * point_world).z;
    let inside = pixel.x >= 0.0 && pixel.y >= 0.0;
    inside.then_some(Seed {
        pixel: (pixel.x.round() as usize, pixel.y.round() as usize),
        plane: Plane3 {
            w: 1.0 / depth,
            slope: [0.0; 2],
        },
    })
}

/// The pixel of a cell with the most texture.
fn corner(stage: &Stage<'_>, (left, top): (usize, usize), cell: usize) -> Option<(usize, usize)> {
    let pixels = (0..cell * cell)
        .step_by(2)
        .map(|i| (left + i % cell, top + i / cell));
    let usable = pixels.filter(|(x, y)| stage.shows_subject(*x, *y));
    let rated = usable.map(|pixel| (texture(stage, pixel, RADIUS_PX), pixel));
    let best = rated.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 >= LEAST_TEXTURE).then_some(best.1)
}

/// The smaller eigenvalue of the mean of ∇f·∇fᵀ around a pixel; 0 near the edge.
///
/// # Source
/// Shi & Tomasi 1994, *Good features to track*.
pub(super) fn texture(stage: &Stage<'_>, (x, y): (usize, usize), radius: usize) -> f64 {
    let image = &stage.template.image;
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

/// The inverse depth at which the corner looks most alike in all images, if it is the only one.
fn along_the_line(
    stage: &Stage<'_>,
    pixel: (usize, usize),
    options: &MatchOptions,
) -> Option<Seed> {
    let patch = Patch::at(stage, pixel, RADIUS_PX);
    let rated = places(stage, pixel, options)
        .into_iter()
        .filter_map(|(shift, w)| {
            let alike = (0..stage.others.len()).map(|i| correlation(stage, &patch, i, w));
            // the image with the least correlation; those that do not see the place do not count
            let mut seen: Vec<f64> = alike.flatten().collect();
            seen.sort_by(f64::total_cmp);
            (seen.len() >= options.least_images)
                .then(|| seen.first().map(|least| (*least, shift, w)))?
        });
    let rated: Vec<(f64, f64, f64)> = rated.collect();
    let best = rated.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let elsewhere = rated
        .iter()
        .filter(|place| (place.1 - best.1).abs() > SAME_PX);
    let next = elsewhere.map(|place| place.0).fold(-1.0, f64::max);
    (best.0 >= options.least_correlation && next <= best.0 - LEAST_LEAD).then_some(Seed {
        pixel,
        plane: Plane3 {
            w: best.2,
            slope: [0.0; 2],
        },
    })
}

/// Inverse depths a step apart, each with the shift from the first, px.
fn places(stage: &Stage<'_>, pixel: (usize, usize), options: &MatchOptions) -> Vec<(f64, f64)> {
    let (mut w, last) = options
        .depth
        .map_or((0.0, f64::INFINITY), |(near, far)| (1.0 / far, 1.0 / near));
    let most = if options.depth.is_some() {
        f64::INFINITY
    } else {
        LARGEST_SHIFT * stage.template.image.width() as f64
    };
    let (mut places, mut shift) = (Vec::new(), 0.0);
    while w <= last && shift <= most && places.len() < MOST_STEPS {
        places.push((shift, w));
        let reach = stage.reach(pixel, w);
        if reach <= 0.0 {
            break;
        }
        w += STEP_PX / reach;
        shift += STEP_PX;
    }
    places
}

/// Correlation coefficient of the patch, parallel to the image plane, with one image; `None` where it is not seen.
fn correlation(stage: &Stage<'_>, patch: &Patch, image: usize, w: f64) -> Option<f64> {
    let other = &stage.others[image];
    let direction = other.epipolar.direction(&patch.middle());
    let middle = other.epipolar.seen(&direction, w)?.pixel;
    let [right, down] = other.epipolar.steps();
    // across a small patch the map is affine
    let step = |by: nalgebra::Vector3<f64>| {
        Some(other.epipolar.seen(&(direction + by), w)?.pixel - middle)
    };
    let (right, down) = (step(right)?, step(down)?);
    let mut sums = [0.0; 6];
    for (dx, dy, f) in patch.pixels() {
        let place: Point2<f64> = middle + right * *dx + down * *dy;
        let g = f64::from(sample(&other.view.image, place.x, place.y)?.value);
        let f = f64::from(*f);
        for (sum, term) in sums.iter_mut().zip([1.0, f, g, f * f, g * g, f * g]) {
            *sum += term;
        }
    }
    let [n, f, g, ff, gg, fg] = sums;
    let (ff, gg, fg) = (ff - f * f / n, gg - g * g / n, fg - f * g / n);
    // less than a grey level of contrast is none
    (ff > n && gg > n).then(|| fg / (ff * gg).sqrt())
}
