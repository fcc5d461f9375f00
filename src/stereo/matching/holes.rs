//! Closing the holes that the regions leave, from all directions, and removing false matches.

use nalgebra::Point2;
use rayon::prelude::*;

use super::multi_image::Match;
use super::{Grid, MatchOptions, MatchViews, OtherView, Place};
use crate::image::Plane;
use crate::stereo::correlation::remove_specks;

/// Most rounds; each extends the matched area by a ring.
const MOST_ROUNDS: usize = 40;
/// Most rounds in which one place is tried.
const MOST_TRIES: u8 = 3;
/// Most neighbours from which a place is tried in one round.
const MOST_NEIGHBOURS: usize = 3;
/// Of two points on one pixel of another image, the nearer hides the other if their disparities differ by more, px.
const HIDDEN_PX: f64 = 2.0;
/// The eight neighbours.
const AROUND: [(isize, isize); 8] =
    [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];

/// Tries every unmatched place beside a matched one, round by round until no more are found.
pub(super) fn close(views: &MatchViews<'_>, grid: &mut Grid, options: &MatchOptions) {
    let mut tries: Plane<u8> = Plane::filled(grid.width(), grid.height(), 0);
    for _ in 0..MOST_ROUNDS {
        let places: Vec<Place> =
            places(grid).filter(|place| is_open(views, grid, &tries, *place, options)).collect();
        let found: Vec<Option<Match>> =
            places.par_iter().map(|place| attempt(views, grid, *place, options)).collect();

        for (place, found) in places.iter().zip(&found) {
            tries.row_mut(place.row)[place.column] += 1;
            grid.row_mut(place.row)[place.column] = *found;
        }
        if found.iter().all(Option::is_none) {
            break;
        }
    }
}

/// All places of a grid, row by row.
fn places(grid: &Grid) -> impl Iterator<Item = Place> + use<> {
    let (columns, rows) = (grid.width(), grid.height());
    (0..rows).flat_map(move |row| (0..columns).map(move |column| Place { column, row }))
}

/// Whether a place shows the subject, is unmatched beside a matched one, and may still be tried.
fn is_open(
    views: &MatchViews<'_>,
    grid: &Grid,
    tries: &Plane<u8>,
    place: Place,
    options: &MatchOptions,
) -> bool {
    let (x, y) = place.pixel(options);
    place.found(grid).is_none()
        && tries.row(place.row)[place.column] < MOST_TRIES
        && views.shows_subject(x, y)
        && neighbours(grid, place).next().is_some()
}

/// The matched neighbours of a place, each with the step to it.
fn neighbours(grid: &Grid, place: Place) -> impl Iterator<Item = ((isize, isize), Match)> {
    let found = move |step: &(isize, isize)| place.beside(step.0, step.1)?.found(grid);
    AROUND.iter().filter_map(move |step| Some((*step, found(step)?)))
}

/// Matches a place, starting from the planes of its surest neighbours.
fn attempt(
    views: &MatchViews<'_>,
    grid: &Grid,
    place: Place,
    options: &MatchOptions,
) -> Option<Match> {
    let spacing = options.spacing_px as isize;
    let mut neighbours: Vec<_> = neighbours(grid, place).collect();
    neighbours.sort_by(|a, b| a.1.sigma_px.total_cmp(&b.1.sigma_px));
    let mut surest = neighbours.iter().take(MOST_NEIGHBOURS);
    surest.find_map(|((dx, dy), found)| {
        let back = |steps: isize| -(steps * spacing) as f64;
        let expected = found.plane.moved(back(*dx), back(*dy));
        views.find_adaptively(place.pixel(options), &expected, options).ok()
    })
}

/// Removes points that are hidden behind another in an image in which they were found, and small regions.
pub(super) fn prune(views: &MatchViews<'_>, grid: &mut Grid, options: &MatchOptions) {
    for image in 0..views.others.len() {
        remove_hidden(views, grid, image, options);
    }

    // inverse depths as disparities in the middle of the template, over the spacing: regions end at steps of 1
    let middle = (views.template.image.width() / 2, views.template.image.height() / 2);
    let scale = views.reach(middle, 0.0) / options.spacing_px as f64;
    let mut disparities =
        grid.map(|found| found.map_or(f32::NAN, |found| (found.plane.w * scale) as f32));
    remove_specks(&mut disparities, options.least_region);
    for row in 0..grid.height() {
        for (found, disparity) in grid.row_mut(row).iter_mut().zip(disparities.row(row)) {
            *found = found.filter(|_| !disparity.is_nan());
        }
    }
}

/// Removes the points found in one of the other images that are hidden behind another there.
fn remove_hidden(views: &MatchViews<'_>, grid: &mut Grid, image: usize, options: &MatchOptions) {
    let other = &views.others[image];
    let nearest = nearest_points(other, grid, options);
    for place in places(grid) {
        let Some(found) = place.found(grid).filter(|found| found.images >> image & 1 == 1) else {
            continue;
        };
        let Some(cell) = ImageCell::new(other, place, &found, options) else {
            continue;
        };

        let nearest = nearest.get(cell.x, cell.y);
        if nearest.is_some_and(|w| (w - found.plane.w) * cell.reach > HIDDEN_PX) {
            grid.row_mut(place.row)[place.column] = None;
        }
    }
}

/// The largest inverse depth of the points in each cell of another image, 0 without any.
fn nearest_points(other: &OtherView<'_>, grid: &Grid, options: &MatchOptions) -> Plane<f64> {
    let cells = |pixels: usize| pixels.div_ceil(options.spacing_px);
    let image = &other.view.image;
    let mut nearest: Plane<f64> = Plane::filled(cells(image.width()), cells(image.height()), 0.0);
    for place in places(grid) {
        let Some(found) = place.found(grid) else {
            continue;
        };
        let Some(cell) = ImageCell::new(other, place, &found, options) else {
            continue;
        };

        if let Some(nearest) = nearest.row_mut(cell.y).get_mut(cell.x) {
            *nearest = nearest.max(found.plane.w);
        }
    }
    nearest
}

/// Where a point is seen in another image.
struct ImageCell {
    /// Column and row of its cell, which has the size of the grid's spacing.
    x: usize,
    y: usize,
    /// |∂u/∂w|, px·m.
    reach: f64,
}

impl ImageCell {
    fn new(
        other: &OtherView<'_>,
        place: Place,
        found: &Match,
        options: &MatchOptions,
    ) -> Option<Self> {
        let (x, y) = place.pixel(options);
        let direction = other.epipolar.direction(&Point2::new(x as f64, y as f64));
        let image = other.epipolar.image(&direction, found.plane.w)?;
        let cell = |x: f64| (x.round().max(0.0) as usize) / options.spacing_px;
        Some(Self {
            x: cell(image.pixel.x),
            y: cell(image.pixel.y),
            reach: image.by_inverse_depth.norm(),
        })
    }
}
