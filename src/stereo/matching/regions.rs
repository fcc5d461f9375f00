//! The Voronoi regions of the seeds, and the way through one (PFD99 Fig. 2).

use std::collections::BTreeMap;

use nalgebra::Point2;
use rayon::prelude::*;

use super::multi_image::{Match, Plane3};
use super::seeds::Seed;
use super::{Grid, MatchOptions, Stage};
use crate::image::{NearestPoints, Plane};

/// How often a place is tried, from different neighbours.
const MOST_TRIES: u8 = 2;

/// A place of the grid: column and row.
type Node = (usize, usize);

/// Goes through the region of each seed; every place belongs to the nearest one.
pub(super) fn grow(stage: &Stage<'_>, seeds: &[Seed], options: &MatchOptions) -> Grid {
    let spacing = options.spacing_px;
    let image = &stage.template.image;
    let (columns, rows) = (
        image.width().div_ceil(spacing),
        image.height().div_ceil(spacing),
    );
    let owners = owners(seeds, (columns, rows), spacing);
    let mut grid = Plane::filled(columns, rows, None);
    let found: Vec<BTreeMap<Node, Match>> = (0..seeds.len())
        .into_par_iter()
        .map(|owner| {
            Region {
                stage,
                options,
                owners: &owners,
                owner,
                found: BTreeMap::new(),
                tries: BTreeMap::new(),
            }
            .grow(&seeds[owner])
        })
        .collect();
    for ((column, row), found) in found.into_iter().flatten() {
        grid.row_mut(row)[column] = Some(found);
    }
    grid
}

/// The nearest seed of every place.
fn owners(seeds: &[Seed], (columns, rows): (usize, usize), spacing: usize) -> Plane<usize> {
    let places = seeds
        .iter()
        .map(|seed| Point2::new(seed.pixel.0 as f64, seed.pixel.1 as f64));
    let mut nearest = NearestPoints::new(places);
    let mut owners = Plane::filled(columns, rows, usize::MAX);
    for row in 0..rows {
        let into = owners.row_mut(row);
        nearest.along_row(
            (row * spacing) as f64,
            (0.0, spacing as f64),
            columns,
            |i, owner| into[i] = owner,
        );
    }
    owners
}

struct Region<'a> {
    stage: &'a Stage<'a>,
    options: &'a MatchOptions,
    owners: &'a Plane<usize>,
    owner: usize,
    found: BTreeMap<Node, Match>,
    tries: BTreeMap<Node, u8>,
}

impl Region<'_> {
    /// From the seed horizontally, from all that is found vertically, and so on until nothing more is found.
    fn grow(mut self, seed: &Seed) -> BTreeMap<Node, Match> {
        let spacing = self.options.spacing_px;
        let start = (seed.pixel.0 / spacing, seed.pixel.1 / spacing);
        let offset = |node: usize, pixel: usize| (node * spacing) as f64 - pixel as f64;
        let plane = seed
            .plane
            .moved(offset(start.0, seed.pixel.0), offset(start.1, seed.pixel.1));
        self.visit(start, &plane);
        let mut along = [(1, 0), (-1, 0)];
        let mut across = [(0, 1), (0, -1)];
        let mut fresh: Vec<Node> = self.found.keys().copied().collect();
        let mut before = Vec::new();
        while !fresh.is_empty() {
            let mut found = Vec::new();
            for node in before.iter().chain(&fresh) {
                for step in along {
                    found.extend(self.walk(*node, step));
                }
            }
            std::mem::swap(&mut along, &mut across);
            before = std::mem::replace(&mut fresh, found);
        }
        self.found
    }

    /// On from a found place as long as the next one is found.
    fn walk(&mut self, from: Node, (dx, dy): (isize, isize)) -> Vec<Node> {
        let mut found = Vec::new();
        let mut here = from;
        while let (Some(x), Some(y)) =
            (here.0.checked_add_signed(dx), here.1.checked_add_signed(dy))
        {
            let Some(plane) = self.found.get(&here).map(|found| found.plane) else {
                break;
            };
            let spacing = self.options.spacing_px as f64;
            let expected = plane.moved(dx as f64 * spacing, dy as f64 * spacing);
            if !self.visit((x, y), &expected) {
                break;
            }
            here = (x, y);
            found.push(here);
        }
        found
    }

    /// Whether a place is of this region, was not found before, and is found now.
    fn visit(&mut self, node: Node, expected: &Plane3) -> bool {
        let mine = self.owners.get(node.0, node.1) == Some(self.owner);
        let pixel = (
            node.0 * self.options.spacing_px,
            node.1 * self.options.spacing_px,
        );
        if !mine || self.found.contains_key(&node) || !self.stage.shows_subject(pixel.0, pixel.1) {
            return false;
        }
        let tries = self.tries.entry(node).or_default();
        if *tries == MOST_TRIES {
            return false;
        }
        *tries += 1;
        let found = self.stage.find_adaptively(pixel, expected, self.options);
        found.is_ok_and(|found| self.found.insert(node, found).is_none())
    }
}
