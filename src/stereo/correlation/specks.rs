//! Removing small isolated regions of disparities.

use crate::image::Plane;

/// Neighbours in one region differ by at most so many pixels.
const MOST_STEP_PX: f32 = 1.0;

/// Sets the disparities of every region of fewer than `least` pixels to NaN; returns how many pixels that were.
///
/// Two pixels side by side or one above the other are of one region if their disparities differ by at most 1 px.
pub(in crate::stereo) fn remove(disparities: &mut Plane<f32>, least: usize) -> usize {
    let (runs, mut regions) = regions(disparities);
    let mut removed = 0;
    for run in runs {
        let root = regions.root(run.region);
        if regions.sizes[root] < least {
            disparities.row_mut(run.y)[run.from..run.to].fill(f32::NAN);
            removed += run.to - run.from;
        }
    }
    removed
}

/// Pixels of a row that hang together.
#[derive(Debug, Clone, Copy)]
struct Run {
    y: usize,
    from: usize,
    to: usize,
    region: usize,
}

/// Which runs are of one region, as a forest.
#[derive(Debug, Default)]
struct Regions {
    parents: Vec<usize>,
    sizes: Vec<usize>,
}

impl Regions {
    /// A new region.
    fn add(&mut self, size: usize) -> usize {
        self.parents.push(self.parents.len());
        self.sizes.push(size);
        self.parents.len() - 1
    }

    /// The region that stands for all that were joined.
    fn root(&mut self, mut region: usize) -> usize {
        while self.parents[region] != region {
            self.parents[region] = self.parents[self.parents[region]];
            region = self.parents[region];
        }
        region
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        if a != b {
            let (kept, lost) = (a.min(b), a.max(b));
            self.parents[lost] = kept;
            self.sizes[kept] += self.sizes[lost];
        }
    }
}

/// All runs of all rows, joined where they touch one of the row above.
fn regions(disparities: &Plane<f32>) -> (Vec<Run>, Regions) {
    let (mut runs, mut regions) = (Vec::new(), Regions::default());
    let mut above = 0..0;
    for y in 0..disparities.height() {
        let first = runs.len();
        add_runs(disparities.row(y), y, &mut runs, &mut regions);
        let here = first..runs.len();

        // both rows' runs from left to right, the one that ends first going on
        let row_above = y.checked_sub(1).map_or(&[][..], |y| disparities.row(y));
        let (mut i, mut k) = (above.start, here.start);
        while i < above.end && k < here.end {
            let (a, b): (Run, Run) = (runs[i], runs[k]);
            let overlap = a.from.max(b.from)..a.to.min(b.to);
            let row = disparities.row(y);
            if overlap.into_iter().any(|x| near(row[x], row_above[x])) {
                regions.join(a.region, b.region);
            }
            if a.to < b.to { i += 1 } else { k += 1 }
        }

        above = here;
    }
    (runs, regions)
}

/// Adds the runs of one row, each a region of its own.
fn add_runs(row: &[f32], y: usize, runs: &mut Vec<Run>, regions: &mut Regions) {
    let mut from = 0;
    while from < row.len() {
        if row[from].is_nan() {
            from += 1;
            continue;
        }

        let mut to = from + 1;
        while to < row.len() && near(row[to], row[to - 1]) {
            to += 1;
        }

        let region = regions.add(to - from);
        runs.push(Run { y, from, to, region });
        from = to;
    }
}

/// NaN is near nothing.
fn near(a: f32, b: f32) -> bool {
    (a - b).abs() <= MOST_STEP_PX
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: f32 = f32::NAN;

    #[test]
    fn regions_hang_together_around_corners_and_end_at_steps() {
        let values = vec![
            5.0, N, 5.5, 9.0, //
            5.2, 5.3, 5.4, 9.1, //
            N, N, N, 9.2, //
            1.0, 1.0, N, N,
        ];
        let mut disparities = Plane::from_values(4, 4, values).unwrap();
        assert_eq!(remove(&mut disparities, 3), 2);
        assert!(disparities.row(3).iter().all(|d| d.is_nan()));
        assert_eq!(remove(&mut disparities, 5), 3);
        assert_eq!(disparities.get(3, 1).map(f32::is_nan), Some(true));
        assert_eq!(disparities.get(2, 0), Some(5.5));
    }

    #[test]
    fn nothing_known_is_nothing_removed() {
        assert_eq!(remove(&mut Plane::filled(5, 3, N), 100), 0);
        assert_eq!(remove(&mut Plane::filled(0, 0, 1.0), 100), 0);
    }
}
