//! A mask as the runs of its rows: small, quick to label, and exact.

use super::{Mask, Plane};

/// Which neighbours belong to the same component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connectivity {
    /// Those to the left, to the right, above and below.
    Four,
    /// Those and the diagonal ones.
    Eight,
}

/// Whole pixels from (`left`, `top`) to just before (`right`, `bottom`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// First column.
    pub left: usize,
    /// First row.
    pub top: usize,
    /// One past the last column.
    pub right: usize,
    /// One past the last row.
    pub bottom: usize,
}

impl Region {
    /// The region with a margin around it, within `width` × `height` pixels.
    pub fn grown(&self, margin: usize, width: usize, height: usize) -> Self {
        Self {
            left: self.left.saturating_sub(margin),
            top: self.top.saturating_sub(margin),
            right: (self.right + margin).min(width),
            bottom: (self.bottom + margin).min(height),
        }
    }
}

/// A connected set of runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Component {
    /// Number of pixels.
    pub area: usize,
    /// Smallest region that holds it.
    pub region: Region,
    /// Whether one of its pixels is in the first or last row or column of the image.
    pub touches_image_edge: bool,
}

/// Foreground pixels `start..end` of one row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Run {
    start: u32,
    end: u32,
}

/// A mask as the runs of foreground of each row, left to right, top to bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct Runs {
    width: usize,
    /// `runs[first[y]..first[y + 1]]` are those of row y.
    first: Vec<usize>,
    runs: Vec<Run>,
}

impl Runs {
    /// The runs of a mask.
    pub fn from_mask(mask: &Mask) -> Self {
        let mut encoded = Self::empty(mask.width());
        for y in 0..mask.height() {
            let row = mask.row(y);
            let mut x = position_of(row, 0, 1);
            while x < row.len() {
                let end = position_of(row, x, 0);
                encoded.push(x, end);
                x = position_of(row, end, 1);
            }
            encoded.end_row();
        }
        encoded
    }

    /// Columns of the image.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows of the image.
    pub fn height(&self) -> usize {
        self.first.len() - 1
    }

    /// The mask that has these runs.
    pub fn mask(&self) -> Mask {
        let whole = Region { left: 0, top: 0, right: self.width, bottom: self.height() };
        Mask::from_ones(self.painted(&whole, 0))
    }

    /// Number of foreground pixels.
    pub fn area(&self) -> usize {
        self.runs.iter().map(Run::len).sum()
    }

    /// Smallest region that holds the foreground; `None` if there is none.
    pub fn region(&self) -> Option<Region> {
        let occupied = |y: &usize| !self.row(*y).is_empty();
        Some(Region {
            left: self.runs.iter().map(|run| run.start).min()? as usize,
            top: (0..self.height()).find(occupied)?,
            right: self.runs.iter().map(|run| run.end).max()? as usize,
            bottom: (0..self.height()).rev().find(occupied)? + 1,
        })
    }

    /// The mask with foreground and background exchanged.
    pub(super) fn complement(&self) -> Self {
        let mut background = Self::empty(self.width);
        for y in 0..self.height() {
            let mut x = 0;
            for run in self.row(y) {
                background.push(x, run.start as usize);
                x = run.end as usize;
            }
            background.push(x, self.width);
            background.end_row();
        }
        background
    }

    /// The connected components in the order of their first pixels, and for each run the index of its component.
    pub fn components(&self, connectivity: Connectivity) -> (Vec<Component>, Vec<usize>) {
        let mut labels = self.roots(connectivity);
        let mut components: Vec<Component> = Vec::new();
        let mut number_of_root = vec![usize::MAX; labels.len()];

        // roots become numbers in the order in which they occur
        for y in 0..self.height() {
            for (run, label) in self.row(y).iter().zip(&mut labels[self.first[y]..]) {
                let number = &mut number_of_root[*label];
                if *number == usize::MAX {
                    *number = components.len();
                    components.push(Component::new(y));
                }
                *label = *number;
                components[*number].add(run, y, self.width, self.height());
            }
        }
        (components, labels)
    }

    /// Only the runs i for which `is_kept(i)` holds, counted as in [`Runs::components`].
    pub fn filtered(&self, is_kept: impl Fn(usize) -> bool) -> Self {
        let mut kept = Self::empty(self.width);
        for y in 0..self.height() {
            for (run, i) in self.row(y).iter().zip(self.first[y]..) {
                if is_kept(i) {
                    kept.push(run.start as usize, run.end as usize);
                }
            }
            kept.end_row();
        }
        kept
    }

    /// Ones and zeros over `region`, widened on each side by `margin` pixels of zeros.
    pub fn painted(&self, region: &Region, margin: usize) -> Plane<u8> {
        let width = region.right.saturating_sub(region.left);
        let height = region.bottom.saturating_sub(region.top);
        let mut plane = Plane::filled(width + 2 * margin, height + 2 * margin, 0);
        for y in region.top..region.bottom.min(self.height()) {
            let row = plane.row_mut(y - region.top + margin);
            for run in self.row(y) {
                let start = (run.start as usize).clamp(region.left, region.right);
                let end = (run.end as usize).clamp(region.left, region.right);
                row[start - region.left + margin..end - region.left + margin].fill(1);
            }
        }
        plane
    }

    /// Whether a pixel of this mask lies within `reach` pixels of one of `region`, in x and in y.
    pub(super) fn comes_near(&self, region: &Region, reach: usize) -> bool {
        let top = region.top.saturating_sub(reach);
        let bottom = region.bottom.saturating_add(reach).min(self.height());
        (top..bottom).any(|y| {
            self.row(y).iter().any(|run| {
                (run.start as usize) < region.right.saturating_add(reach)
                    && run.end as usize > region.left.saturating_sub(reach)
            })
        })
    }

    fn empty(width: usize) -> Self {
        Self { width, first: vec![0], runs: Vec::new() }
    }

    fn row(&self, y: usize) -> &[Run] {
        &self.runs[self.first[y]..self.first[y + 1]]
    }

    fn push(&mut self, start: usize, end: usize) {
        if start < end {
            self.runs.push(Run { start: start as u32, end: end as u32 });
        }
    }

    fn end_row(&mut self) {
        self.first.push(self.runs.len());
    }

    /// For each run the representative of its component (union–find over neighbouring rows).
    fn roots(&self, connectivity: Connectivity) -> Vec<usize> {
        let reach = match connectivity {
            Connectivity::Four => 0,
            Connectivity::Eight => 1,
        };
        let mut parents: Vec<usize> = (0..self.runs.len()).collect();

        // two rows are walked together, always the run that ends first
        for y in 1..self.height() {
            let (mut above, mut here) = (self.first[y - 1], self.first[y]);
            while above < self.first[y] && here < self.first[y + 1] {
                let (a, b) = (self.runs[above], self.runs[here]);
                if a.start < b.end + reach && b.start < a.end + reach {
                    join(&mut parents, above, here);
                }
                if a.end < b.end {
                    above += 1;
                } else {
                    here += 1;
                }
            }
        }

        (0..parents.len()).map(|i| root(&mut parents, i)).collect()
    }
}

impl Run {
    fn len(&self) -> usize {
        (self.end - self.start) as usize
    }
}

impl Component {
    fn new(y: usize) -> Self {
        Self {
            area: 0,
            region: Region { left: usize::MAX, top: y, right: 0, bottom: y },
            touches_image_edge: false,
        }
    }

    /// Adds a run of row y of an image of `width` × `height` pixels.
    fn add(&mut self, run: &Run, y: usize, width: usize, height: usize) {
        self.area += run.len();
        self.region.left = self.region.left.min(run.start as usize);
        self.region.right = self.region.right.max(run.end as usize);
        self.region.bottom = y + 1;
        self.touches_image_edge |=
            run.start == 0 || run.end as usize == width || y == 0 || y + 1 == height;
    }
}

/// The first position at or after `from` that holds `value` (0 or 1), or else the length; searched eight pixels at a time.
fn position_of(row: &[u8], from: usize, value: u8) -> usize {
    let other = u64::from_ne_bytes([1 - value; 8]);
    let mut x = from;
    for eight in row[from..].chunks_exact(8) {
        if let Ok(bytes) = <[u8; 8]>::try_from(eight)
            && u64::from_ne_bytes(bytes) != other
        {
            break;
        }
        x += 8;
    }
    x + row[x..].iter().position(|pixel| *pixel == value).unwrap_or(row.len() - x)
}

fn root(parents: &mut [usize], mut i: usize) -> usize {
    while parents[i] != i {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    i
}

fn join(parents: &mut [usize], a: usize, b: usize) {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b)] = a.min(b);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(rows: &[&str]) -> Mask {
        let bytes: Vec<_> = rows.iter().map(|row| row.as_bytes()).collect();
        Mask::from_fn(bytes[0].len(), rows.len(), |x, y| bytes[y][x] == b'#')
    }

    #[test]
    fn painting_the_runs_gives_the_mask_back() {
        let mask = Mask::from_fn(67, 31, |x, y| (x * x + 3 * y * x + y) % 7 < 3);
        let runs = Runs::from_mask(&mask);
        assert_eq!(runs.mask(), mask);
        let region = runs.region().unwrap();
        let painted = runs.painted(&region, 2);
        for y in 0..31 {
            for x in 0..67 {
                let expected = u8::from(mask.is_foreground(x, y));
                assert_eq!(painted.get(x + 2 - region.left, y + 2 - region.top), Some(expected));
            }
        }
        assert_eq!(runs.area() + runs.complement().area(), 67 * 31);
        assert_eq!(runs.complement().complement(), runs);
    }

    #[test]
    fn diagonal_neighbours_are_joined_by_eight_and_not_by_four() {
        let runs = Runs::from_mask(&mask(&["##..", "..##", "#..."]));
        assert_eq!(runs.components(Connectivity::Eight).0.len(), 2);
        assert_eq!(runs.components(Connectivity::Four).0.len(), 3);
    }

    #[test]
    fn two_arms_that_meet_below_are_one_component() {
        let runs = Runs::from_mask(&mask(&["......", ".#..#.", ".#..#.", ".####.", "......"]));
        let (components, labels) = runs.components(Connectivity::Four);
        assert_eq!(components.len(), 1);
        assert_eq!(components[0].area, 8);
        assert!(!components[0].touches_image_edge);
        assert_eq!(components[0].region, runs.region().unwrap());
        assert!(labels.iter().all(|label| *label == 0));
        let holes = runs.complement().components(Connectivity::Four).0;
        assert_eq!(holes.len(), 1, "open above: background is in one piece");
    }

    #[test]
    fn nothing_has_no_region() {
        let runs = Runs::from_mask(&mask(&["....", "...."]));
        assert_eq!(runs.region(), None);
        assert_eq!(runs.components(Connectivity::Eight).0, vec![]);
        assert_eq!(Runs::from_mask(&Mask::from_fn(0, 0, |_, _| true)).region(), None);
    }
}
