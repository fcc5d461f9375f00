//! The Voronoi regions of the seeds, and the way through one (PFD99 Fig. 2).

use std::collections::BTreeMap;

use nalgebra::Point2;
use rayon::prelude::*;

use super::multi_image::{DepthPlane, Match};
use super::seeds::Seed;
use super::{Grid, MatchOptions, MatchViews, Place};
use crate::image::{EvenSteps, NearestPoints, Plane};

/// Most tries of one place, from different neighbours.
const MOST_TRIES: u8 = 2;

/// Goes through the region of each seed; every place belongs to the nearest one.
pub(super) fn grow(views: &MatchViews<'_>, seeds: &[Seed], options: &MatchOptions) -> Grid {
    let image = &views.template.image;
    let columns = image.width().div_ceil(options.spacing_px);
    let rows = image.height().div_ceil(options.spacing_px);
    let mut grid = Plane::filled(columns, rows, None);
    let owners = owners(seeds, &grid, options);

    let found: Vec<BTreeMap<Place, Match>> = (0..seeds.len())
        .into_par_iter()
        .map(|owner| {
            let region = Region {
                views,
                options,
                owners: &owners,
                owner,
                found: BTreeMap::new(),
                tries: BTreeMap::new(),
            };
            region.grow(&seeds[owner])
        })
        .collect();

    for (place, found) in found.into_iter().flatten() {
        grid.row_mut(place.row)[place.column] = Some(found);
    }
    grid
}

/// The nearest seed of every place.
fn owners(seeds: &[Seed], grid: &Grid, options: &MatchOptions) -> Plane<usize> {
    let places = seeds.iter().map(|seed| Point2::new(seed.pixel.0 as f64, seed.pixel.1 as f64));
    let mut nearest = NearestPoints::new(places);
    let mut owners = Plane::filled(grid.width(), grid.height(), usize::MAX);
    let columns = EvenSteps { first: 0.0, step: options.spacing_px as f64, count: grid.width() };
    for row in 0..grid.height() {
        let y = (row * options.spacing_px) as f64;
        let owners = owners.row_mut(row);
        nearest.along_row(y, columns, |i, owner| owners[i] = owner);
    }
    owners
}

/// The region of one seed.
struct Region<'a> {
    views: &'a MatchViews<'a>,
    options: &'a MatchOptions,
    /// The seed of every place.
    owners: &'a Plane<usize>,
    /// This region's seed.
    owner: usize,
    found: BTreeMap<Place, Match>,
    tries: BTreeMap<Place, u8>,
}

impl Region<'_> {
    /// From the seed horizontally, from all that is found vertically, and so on until nothing more is found.
    fn grow(mut self, seed: &Seed) -> BTreeMap<Place, Match> {
        let start = Place {
            column: seed.pixel.0 / self.options.spacing_px,
            row: seed.pixel.1 / self.options.spacing_px,
        };
        let pixel = start.pixel(self.options);
        let plane = seed
            .plane
            .moved(pixel.0 as f64 - seed.pixel.0 as f64, pixel.1 as f64 - seed.pixel.1 as f64);
        self.visit(start, &plane);

        let mut along = [(1, 0), (-1, 0)];
        let mut across = [(0, 1), (0, -1)];
        let mut fresh: Vec<Place> = self.found.keys().copied().collect();
        let mut before = Vec::new();
        while !fresh.is_empty() {
            let mut found = Vec::new();
            for place in before.iter().chain(&fresh) {
                for (right, down) in along {
                    found.extend(self.walk(*place, right, down));
                }
            }
            std::mem::swap(&mut along, &mut across);
            before = std::mem::replace(&mut fresh, found);
        }
        self.found
    }

    /// From a found place step by step, as long as the next one is found.
    fn walk(&mut self, from: Place, right: isize, down: isize) -> Vec<Place> {
        let spacing = self.options.spacing_px as f64;
        let mut found = Vec::new();
        let mut here = from;
        while let Some(next) = here.beside(right, down) {
            let Some(plane) = self.found.get(&here).map(|found| found.plane) else {
                break;
            };
            let expected = plane.moved(right as f64 * spacing, down as f64 * spacing);
            if !self.visit(next, &expected) {
                break;
            }

            here = next;
            found.push(here);
        }
        found
    }

    /// Tries a place; whether it is of this region, was not found before, and is found now.
    fn visit(&mut self, place: Place, expected: &DepthPlane) -> bool {
        let is_own = self.owners.get(place.column, place.row) == Some(self.owner);
        let (x, y) = place.pixel(self.options);
        if !is_own || self.found.contains_key(&place) || !self.views.shows_subject(x, y) {
            return false;
        }

        let tries = self.tries.entry(place).or_default();
        if *tries == MOST_TRIES {
            return false;
        }
        *tries += 1;

        let found = self.views.find_adaptively((x, y), expected, self.options);
        found.is_ok_and(|found| self.found.insert(place, found).is_none())
    }
}
