//! From matches to points, and how far each errs.
//!
//! The normal matrix of a match knows the noise of the images, and takes the surface for a plane. Where the surface bends, or
//! where a patch lies across the edge of a limb, a match errs by more. Its neighbours show how much more: on a plane the
//! inverse depth is the mean of those of the two matches one radius to either side. On a surface of curvature κ it differs
//! by ½κr²; the patch's plane lies ⅔ of that off the surface at its middle, and up to all of it at an edge. So
//! σ² = σ_n² + σ_m² + b², with b the root mean square of these differences over four directions.

use nalgebra::{Matrix3, Point2, Point3};
use rayon::prelude::*;

use super::multi_image::Match;
use super::{
    Grid, MatchOptions, MatchViews, MatchedPoint, MatchedSurface, Place, point_world, seeds,
};
use crate::camera::Camera;
use crate::stereo::{CloudPoint, Spread};

/// The directions in which a match is compared with its neighbours.
const DIRECTIONS: [(isize, isize); 4] = [(1, 0), (0, 1), (1, 1), (1, -1)];

/// The points of all matches whose standard deviation is not too large, and how much was not matched.
pub(super) fn points(
    views: &MatchViews<'_>,
    grid: &Grid,
    seeds: usize,
    options: &MatchOptions,
) -> MatchedSurface {
    let rows: Vec<MatchedSurface> = (0..grid.height())
        .into_par_iter()
        .map(|row| row_points(views, grid, row, options))
        .collect();

    let mut surface = MatchedSurface { seeds, ..MatchedSurface::default() };
    for row in rows {
        surface.points.extend(row.points);
        surface.unmatched += row.unmatched;
        surface.without_texture += row.without_texture;
    }
    surface
}

/// The points of one row of the grid.
fn row_points(
    views: &MatchViews<'_>,
    grid: &Grid,
    row: usize,
    options: &MatchOptions,
) -> MatchedSurface {
    let mut surface = MatchedSurface::default();
    for (column, found) in grid.row(row).iter().enumerate() {
        let place = Place { column, row };
        let pixel = place.pixel(options);
        let point = found.as_ref();
        let point = point.and_then(|found| {
            let bend = bend(grid, place, options);
            point_of_match(views, pixel, found, bend, options)
        });

        if let Some(point) = point {
            surface.points.push(point);
        } else if views.shows_subject(pixel.0, pixel.1) {
            let texture = seeds::texture(views, pixel, options.radius_px);
            surface.unmatched += 1;
            surface.without_texture += usize::from(texture < seeds::LEAST_TEXTURE);
        }
    }
    surface
}

/// b: how far the inverse depth of a match is from that expected by the matches a patch's radius away, 1/m; 0 without any.
///
/// Two matches on opposite sides expect their mean. Where no direction has two, each match expects the depth of its plane.
fn bend(grid: &Grid, place: Place, options: &MatchOptions) -> f64 {
    let steps = (options.radius_px / options.spacing_px).max(1) as isize;
    let neighbour = |direction: &(isize, isize), sign: isize| -> Option<Match> {
        let (right, down) = (sign * steps * direction.0, sign * steps * direction.1);
        place.beside(right, down)?.found(grid)
    };
    let Some(here) = place.found(grid) else {
        return 0.0;
    };

    let pairs = DIRECTIONS.iter().filter_map(|direction| {
        let (ahead, behind) = (neighbour(direction, 1)?, neighbour(direction, -1)?);
        Some(here.plane.w - 0.5 * (ahead.plane.w + behind.plane.w))
    });
    let pairs: Vec<f64> = pairs.collect();
    if !pairs.is_empty() {
        return rms(&pairs);
    }

    let reach_px = (steps * options.spacing_px as isize) as f64;
    let singles = DIRECTIONS.iter().flat_map(|d| [(d, 1), (d, -1)]);
    let singles = singles.filter_map(|(direction, sign)| {
        let back = |d: isize| -(sign * d) as f64 * reach_px;
        let plane = neighbour(direction, sign)?.plane;
        let expected = plane.moved(back(direction.0), back(direction.1));
        Some(here.plane.w - expected.w)
    });
    rms(&singles.collect::<Vec<f64>>())
}

fn rms(values: &[f64]) -> f64 {
    let squares: f64 = values.iter().map(|v| v * v).sum();
    (squares / values.len().max(1) as f64).sqrt()
}

/// The point of a match; `None` if its standard deviation is too large.
fn point_of_match(
    views: &MatchViews<'_>,
    pixel: (usize, usize),
    found: &Match,
    bend: f64,
    options: &MatchOptions,
) -> Option<MatchedPoint> {
    let reach = views.reach(pixel, found.plane.w).max(f64::MIN_POSITIVE);
    if found.sigma_px.hypot(bend * reach) > options.most_sigma_px {
        return None;
    }

    let sigma_w = found.sigma.hypot(bend);
    let sigma_w = sigma_w.hypot(options.model_sigma_px / reach);
    let camera = &views.template.camera;
    let place = Point2::new(pixel.0 as f64, pixel.1 as f64);
    let position_world = point_world(camera, &place, found.plane.w);
    let spread = covariance(camera, &position_world, found.plane.w, sigma_w, options);

    Some(MatchedPoint {
        pixel,
        point: CloudPoint { position_world, spread: Spread::Full(spread) },
        sigma_px: found.sigma_px,
        correlation: found.correlation,
        images: found.images,
        plane: found.plane,
    })
}

/// Along the line of sight from σ_w, across it from the error of the model; world, m².
fn covariance(
    camera: &Camera,
    position: &Point3<f64>,
    w: f64,
    sigma_w: f64,
    options: &MatchOptions,
) -> Matrix3<f64> {
    let ray = position - camera.centre_world();
    let along = ray * (sigma_w / w);
    let across = options.model_sigma_px / (camera.intrinsics.fx_px * w);
    Matrix3::identity() * across.powi(2) + along * along.transpose()
}

#[cfg(test)]
mod tests {
    use super::super::DepthPlane;
    use super::*;

    /// A grid of 21 × 21 matches of this inverse depth, a pixel apart, each with the plane that touches it.
    fn grid(w: impl Fn(f64, f64) -> f64, is_there: impl Fn(usize, usize) -> bool) -> Grid {
        let mut grid = Grid::filled(21, 21, None);
        for row in 0..21 {
            for (column, place) in grid.row_mut(row).iter_mut().enumerate() {
                let (x, y) = (column as f64 - 10.0, row as f64 - 10.0);
                let slope = [w(x + 0.5, y) - w(x - 0.5, y), w(x, y + 0.5) - w(x, y - 0.5)];
                *place = is_there(column, row).then(|| Match {
                    plane: DepthPlane { w: w(x, y), slope },
                    sigma: 0.0,
                    sigma_px: 0.0,
                    correlation: 1.0,
                    images: 3,
                });
            }
        }
        grid
    }

    fn middle(grid: &Grid) -> f64 {
        let options = MatchOptions { spacing_px: 1, ..MatchOptions::default() };
        bend(grid, Place { column: 10, row: 10 }, &options)
    }

    #[test]
    fn a_plane_does_not_bend_and_a_parabola_bends_by_half_its_curvature_times_the_radius_squared() {
        let plane = grid(|x, y| 1.0 + 0.02 * x - 0.01 * y, |_, _| true);
        approx::assert_relative_eq!(middle(&plane), 0.0, epsilon = 1e-12);
        // ½κr² in one direction, 0 across it, half of twice that along both diagonals
        let half = 0.5 * 0.004 * 25.0_f64;
        let parabola = grid(|x, _| 1.0 - 0.002 * x * x, |_, _| true);
        let expected = (3.0 * half * half / 4.0).sqrt();
        approx::assert_relative_eq!(middle(&parabola), expected, max_relative = 1e-9);
    }

    #[test]
    fn beside_a_step_and_where_only_one_side_is_matched_it_bends_too() {
        let step = grid(|x, _| if x > 2.0 { 1.1 } else { 1.0 }, |_, _| true);
        assert!(middle(&step) > 0.04, "{}", middle(&step));
        let one_sided = |column: usize, row: usize| row == 10 && column >= 10;
        let plane = grid(|x, _| 1.0 + 0.02 * x, one_sided);
        approx::assert_relative_eq!(middle(&plane), 0.0, epsilon = 1e-12);
        let parabola = grid(|x, _| 1.0 - 0.002 * x * x, one_sided);
        approx::assert_relative_eq!(middle(&parabola), 0.05, max_relative = 1e-9);
        let alone = grid(|_, _| 1.0, |column, row| (column, row) == (10, 10));
        approx::assert_relative_eq!(middle(&alone), 0.0);
    }
}
