//! Cells of a level plane.

use nalgebra::{Point2, Vector2};

/// Which square cells of a level square are in something.
#[derive(Debug, Clone)]
pub(super) struct Level {
    /// Of the least x and y.
    corner: Point2<f64>,
    cell_m: f64,
    /// Cells along each side.
    across: usize,
    /// Row by row.
    is_in: Vec<bool>,
}

impl Level {
    /// The cells whose middles are in it, of those that lie so far from a place at most.
    pub(super) fn new(
        middle: &Point2<f64>,
        reach_m: f64,
        cell_m: f64,
        is_in: impl Fn(&Point2<f64>) -> bool,
    ) -> Self {
        let across = (2.0 * reach_m / cell_m) as usize;
        let corner = middle - Vector2::repeat(reach_m);
        let along = |k: usize| (k as f64 + 0.5) * cell_m;
        let cells = 0..across * across;
        let place = |cell| corner + Vector2::new(along(cell % across), along(cell / across));
        let is_in = cells.map(|cell| is_in(&place(cell))).collect();
        Self { corner, cell_m, across, is_in }
    }

    pub(super) fn contains(&self, place: &Point2<f64>) -> bool {
        let [column, row] = [place.x - self.corner.x, place.y - self.corner.y]
            .map(|along| (along / self.cell_m).floor());
        let is_inside = |k: f64| (0.0..self.across as f64).contains(&k);
        is_inside(column)
            && is_inside(row)
            && self.is_in[row as usize * self.across + column as usize]
    }

    pub(super) fn area_m2(&self) -> f64 {
        self.is_in.iter().filter(|is_in| **is_in).count() as f64 * self.cell_m * self.cell_m
    }

    /// With what lies so near, along both axes.
    #[must_use]
    pub(super) fn widened(&self, by_m: f64) -> Self {
        let by = (by_m / self.cell_m).round() as usize;
        self.joined(by, 1).joined(by, self.across)
    }

    /// With those that are so many cells before or behind one that is in it, `stride` apart.
    fn joined(&self, by: usize, stride: usize) -> Self {
        let is_in = |cell: usize| {
            let at = cell / stride % self.across;
            let (first, last) = (at.saturating_sub(by), (at + by).min(self.across - 1));
            (first..=last).any(|k| self.is_in[cell + k * stride - at * stride])
        };
        Self { is_in: (0..self.is_in.len()).map(is_in).collect(), ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_has_its_area_and_ends_where_it_does() {
        let middle = Point2::new(3.0, -1.0);
        let disk = Level::new(&middle, 1.0, 0.02, |place| nalgebra::distance(place, &middle) < 0.5);
        approx::assert_relative_eq!(
            disk.area_m2(),
            std::f64::consts::PI * 0.25,
            max_relative = 0.02
        );
        let at = |x: f64, y: f64| Point2::new(middle.x + x, middle.y + y);
        assert!(disk.contains(&at(0.45, 0.0)) && !disk.contains(&at(0.4, 0.4)));
        assert!(!disk.contains(&at(1.2, 0.0)));

        let wider = disk.widened(0.2);
        assert!(wider.contains(&at(0.65, 0.0)) && wider.contains(&at(0.0, -0.65)));
        assert!(wider.contains(&at(0.5, 0.5)) && !wider.contains(&at(0.75, 0.0)));
    }

    #[test]
    fn at_the_edge_nothing_comes_back_on_the_other_side() {
        let middle = Point2::origin();
        let edge = Level::new(&middle, 1.0, 0.1, |place| place.x > 0.9);
        let wider = edge.widened(0.2);
        assert!(
            wider.contains(&Point2::new(0.75, 0.0)) && !wider.contains(&Point2::new(-0.95, 0.0))
        );
    }
}
