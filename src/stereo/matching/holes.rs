//! Closing the holes that the regions leave, from all directions, and taking away what cannot be.

use rayon::prelude::*;

use super::multi_image::Match;
use super::{Grid, MatchOptions, Stage};
use crate::image::Plane;
use crate::stereo::correlation::remove_specks;

/// Rounds at most; each closes a ring around what is known.
const MOST_ROUNDS: usize = 40;
/// Rounds in which a place is tried.
const MOST_TRIES: u8 = 3;
/// Neighbours from which a place is tried in one round.
const MOST_NEIGHBOURS: usize = 3;
/// Points that fall on one pixel of another image and differ more hide each other, px.
const HIDDEN_PX: f64 = 2.0;
/// The eight neighbours.
const AROUND: [(isize, isize); 8] = [
    (-1, 0),
    (1, 0),
    (0, -1),
    (0, 1),
    (-1, -1),
    (1, -1),
    (-1, 1),
    (1, 1),
];

/// Tries every unmatched place beside a matched one, round by round until no more are found.
pub(super) fn close(stage: &Stage<'_>, grid: &mut Grid, options: &MatchOptions) {
    let mut tries: Plane<u8> = Plane::filled(grid.width(), grid.height(), 0);
    for _ in 0..MOST_ROUNDS {
        let places: Vec<(usize, usize)> = (0..grid.height())
            .flat_map(|row| (0..grid.width()).map(move |column| (column, row)))
            .filter(|place| is_open(stage, grid, &tries, *place, options))
            .collect();
        let found: Vec<Option<Match>> = places
            .par_iter()
            .map(|place| attempt(stage, grid, *place, options))
            .collect();
        for ((column, row), found) in places.iter().zip(&found) {
            tries.row_mut(*row)[*column] += 1;
            grid.row_mut(*row)[*column] = *found;
        }
        if found.iter().all(Option::is_none) {
            break;
        }
    }
}

fn is_open(
    stage: &Stage<'_>,
    grid: &Grid,
    tries: &Plane<u8>,
    (column, row): (usize, usize),
    options: &MatchOptions,
) -> bool {
    let spacing = options.spacing_px;
    grid.row(row)[column].is_none()
        && tries.row(row)[column] < MOST_TRIES
        && stage.shows_subject(column * spacing, row * spacing)
        && neighbours(grid, (column, row)).next().is_some()
}

/// The matched neighbours, and how far they are, places.
fn neighbours(
    grid: &Grid,
    (column, row): (usize, usize),
) -> impl Iterator<Item = ((isize, isize), Match)> {
    AROUND.iter().filter_map(move |(dx, dy)| {
        let place = (
            column.checked_add_signed(*dx)?,
            row.checked_add_signed(*dy)?,
        );
        Some(((*dx, *dy), grid.get(place.0, place.1)??))
    })
}

fn attempt(
    stage: &Stage<'_>,
    grid: &Grid,
    (column, row): (usize, usize),
    options: &MatchOptions,
) -> Option<Match> {
    let spacing = options.spacing_px;
    let mut from: Vec<_> = neighbours(grid, (column, row)).collect();
    from.sort_by(|a, b| a.1.sigma_px.total_cmp(&b.1.sigma_px));
    from.iter()
        .take(MOST_NEIGHBOURS)
        .find_map(|((dx, dy), found)| {
            let by = |steps: isize| -(steps * spacing as isize) as f64;
            let expected = found.plane.moved(by(*dx), by(*dy));
            stage
                .find_adaptively((column * spacing, row * spacing), &expected, options)
                .ok()
        })
}

/// Takes away what is hidden behind another point in an image in which it was found, and small regions.
pub(super) fn prune(stage: &Stage<'_>, grid: &mut Grid, options: &MatchOptions) {
    for image in 0..stage.others.len() {
        remove_hidden(stage, grid, image, options);
    }
    let middle = (
        stage.template.image.width() / 2,
        stage.template.image.height() / 2,
    );
    let scale = stage.reach(middle, 0.0) / options.spacing_px as f64;
    let mut disparities =
        grid.map(|found| found.map_or(f32::NAN, |found| (found.plane.w * scale) as f32));
    remove_specks(&mut disparities, options.least_region);
    for row in 0..grid.height() {
        for (found, disparity) in grid.row_mut(row).iter_mut().zip(disparities.row(row)) {
            *found = found.filter(|_| !disparity.is_nan());
        }
    }
}

fn remove_hidden(stage: &Stage<'_>, grid: &mut Grid, image: usize, options: &MatchOptions) {
    let other = &stage.others[image];
    let (width, height) = (other.view.image.width(), other.view.image.height());
    let spacing = options.spacing_px;
    let mut nearest: Plane<f64> =
        Plane::filled(width.div_ceil(spacing), height.div_ceil(spacing), 0.0);
    let place = |column: usize, row: usize, found: &Match| {
        let pixel = nalgebra::Point2::new((column * spacing) as f64, (row * spacing) as f64);
        let seen = other
            .epipolar
            .seen(&other.epipolar.direction(&pixel), found.plane.w)?;
        let cell = |x: f64| (x.round().max(0.0) as usize) / spacing;
        Some((
            cell(seen.pixel.x),
            cell(seen.pixel.y),
            seen.by_inverse_depth.norm(),
        ))
    };
    for row in 0..grid.height() {
        for (column, found) in grid.row(row).iter().enumerate() {
            let Some((x, y, _)) = found.as_ref().and_then(|found| place(column, row, found)) else {
                continue;
            };
            if let (Some(nearest), Some(found)) = (nearest.row_mut(y).get_mut(x), found) {
                *nearest = nearest.max(found.plane.w);
            }
        }
    }
    for row in 0..grid.height() {
        for column in 0..grid.width() {
            let Some(found) = grid.row(row)[column].filter(|found| found.images >> image & 1 == 1)
            else {
                continue;
            };
            let Some((x, y, reach)) = place(column, row, &found) else {
                continue;
            };
            let hidden = nearest
                .get(x, y)
                .is_some_and(|w| (w - found.plane.w) * reach > HIDDEN_PX);
            if hidden {
                grid.row_mut(row)[column] = None;
            }
        }
    }
}
