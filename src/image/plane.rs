//! A rectangle of values.

use rayon::slice::ParallelSliceMut;

use super::Region;

/// A `width × height` rectangle of values, row by row, without padding.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane<T> {
    width: usize,
    height: usize,
    values: Vec<T>,
}

impl<T: Copy> Plane<T> {
    /// A plane that holds `value` everywhere.
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        Self { width, height, values: vec![value; width * height] }
    }

    /// A plane of the given row-major values; `None` unless there are exactly `width · height` of them.
    pub fn from_values(width: usize, height: usize, values: Vec<T>) -> Option<Self> {
        (width.checked_mul(height)? == values.len()).then_some(Self { width, height, values })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Value at column `x` of row `y`; `None` outside.
    pub fn get(&self, x: usize, y: usize) -> Option<T> {
        self.row(y).get(x).copied()
    }

    /// The values at columns `x` and `x` + 1 of rows `y` and `y` + 1; `None` unless all four lie inside.
    #[inline]
    pub fn square(&self, x: usize, y: usize) -> Option<[[T; 2]; 2]> {
        if x >= self.width.saturating_sub(1) || y >= self.height.saturating_sub(1) {
            return None;
        }
        let first = y * self.width + x;
        let pair = |at: usize| self.values.get(at..)?.first_chunk().copied();
        Some([pair(first)?, pair(first + self.width)?])
    }

    /// Row `y`; empty if there is no such row.
    pub fn row(&self, y: usize) -> &[T] {
        let start = y.saturating_mul(self.width);
        self.values.get(start..start.saturating_add(self.width)).unwrap_or(&[])
    }

    /// Row `y`, to be written; empty if there is no such row.
    pub fn row_mut(&mut self, y: usize) -> &mut [T] {
        let start = y.saturating_mul(self.width);
        self.values.get_mut(start..start.saturating_add(self.width)).unwrap_or(&mut [])
    }

    /// All rows, to be written in parallel.
    pub(super) fn par_rows_mut(&mut self) -> rayon::slice::ChunksExactMut<'_, T>
    where
        T: Send,
    {
        self.values.par_chunks_exact_mut(self.width.max(1))
    }

    /// The plane of `f` of each value.
    pub fn map<U: Copy>(&self, f: impl FnMut(T) -> U) -> Plane<U> {
        Plane {
            width: self.width,
            height: self.height,
            values: self.values.iter().copied().map(f).collect(),
        }
    }

    /// The part of the plane within a region.
    pub fn cropped(&self, region: &Region) -> Self {
        let (left, right) = (region.left.min(self.width), region.right.min(self.width));
        let (top, bottom) = (region.top.min(self.height), region.bottom.min(self.height));
        let rows = (top..bottom).flat_map(|y| &self.row(y)[left..right.max(left)]);
        Self {
            width: right.saturating_sub(left),
            height: bottom.saturating_sub(top),
            values: rows.copied().collect(),
        }
    }

    /// All values, row by row.
    pub fn values(&self) -> &[T] {
        &self.values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_follow_each_other_and_nothing_lies_outside() {
        let plane = Plane::from_values(3, 2, vec![1, 2, 3, 4, 5, 6]).unwrap();
        assert_eq!(plane.row(1), &[4, 5, 6]);
        assert_eq!(plane.get(2, 0), Some(3));
        assert_eq!(plane.get(3, 0), None);
        assert_eq!(plane.get(0, 2), None);
        assert_eq!(plane.square(1, 0), Some([[2, 3], [5, 6]]));
        for (x, y) in [(2, 0), (0, 1), (usize::MAX, 0), (0, usize::MAX)] {
            assert_eq!(plane.square(x, y), None);
        }
        assert!(plane.row(usize::MAX).is_empty());
    }

    #[test]
    fn a_part_of_a_plane_is_a_plane() {
        let plane = Plane::from_values(3, 3, (0..9).collect()).unwrap();
        let region = |left, top, right, bottom| Region { left, top, right, bottom };
        let corner = plane.cropped(&region(1, 1, 7, 3));
        assert_eq!((corner.width(), corner.values()), (2, &[4, 5, 7, 8][..]));
        assert_eq!(plane.cropped(&region(5, 2, 4, 1)).values().len(), 0);
    }

    #[test]
    fn a_wrong_number_of_values_is_no_plane() {
        assert!(Plane::from_values(3, 2, vec![0; 5]).is_none());
        assert!(Plane::<u8>::from_values(usize::MAX, 2, vec![]).is_none());
    }
}
