//! Which points of a row lie inside polygons.

use nalgebra::Point2;

/// Equidistant coordinates, first + i·step for i = 0 … count − 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EvenSteps {
    /// Coordinate 0.
    pub first: f64,
    /// Distance of two neighbours.
    pub step: f64,
    /// Number of coordinates.
    pub count: usize,
}

impl EvenSteps {
    /// Coordinate i.
    pub fn at(self, i: usize) -> f64 {
        self.first + i as f64 * self.step
    }
}

/// Closed polygons cut by equidistant rows: for each row the abscissas where a polygon crosses it.
///
/// A point is inside by the even–odd rule, so an inner border cuts a hole whichever way it runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scanlines {
    rows: EvenSteps,
    /// `crossings[first[r]..first[r + 1]]` are those of row r, left to right.
    first: Vec<u32>,
    crossings: Vec<f32>,
}

impl Scanlines {
    /// Cuts `polygons` by rows; their step must be positive.
    pub fn new(polygons: &[Vec<Point2<f64>>], rows: EvenSteps) -> Self {
        let row_at = |y: f64| {
            let row = ((y - rows.first) / rows.step).ceil().max(0.0) as usize;
            row.min(rows.count)
        };

        let mut cuts: Vec<(u32, f32)> = Vec::new();
        for polygon in polygons {
            for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
                let slope = (b.x - a.x) / (b.y - a.y);
                for r in row_at(a.y.min(b.y))..row_at(a.y.max(b.y)) {
                    let x = a.x + slope * (rows.at(r) - a.y);
                    cuts.push((r as u32, x as f32));
                }
            }
        }
        Self::from_cuts(cuts, rows)
    }

    /// What lies in runs of rows: the row, and where the run begins and ends.
    pub fn from_runs(runs: impl IntoIterator<Item = (usize, [f64; 2])>, rows: EvenSteps) -> Self {
        let cuts = runs.into_iter().flat_map(|(row, ends)| ends.map(|x| (row as u32, x as f32)));
        Self::from_cuts(cuts.collect(), rows)
    }

    fn from_cuts(mut cuts: Vec<(u32, f32)>, rows: EvenSteps) -> Self {
        cuts.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));

        // cumulative counts of the rows
        let mut first = vec![0; rows.count + 1];
        for (row, _) in &cuts {
            first[*row as usize + 1] += 1;
        }
        for r in 0..rows.count {
            first[r + 1] += first[r];
        }

        Self { rows, first, crossings: cuts.into_iter().map(|(_, x)| x).collect() }
    }

    /// Abscissas where the polygons cross row r, left to right; empty if there is no such row.
    pub fn row(&self, r: usize) -> &[f32] {
        match (self.first.get(r), self.first.get(r + 1)) {
            (Some(start), Some(end)) => &self.crossings[*start as usize..*end as usize],
            _ => &[],
        }
    }

    /// Whether a point is inside, judged on the row nearest to it.
    pub fn contains(&self, point: &Point2<f64>) -> bool {
        // rounded without a call: what is below 0 is no row
        let r = (point.y - self.rows.first) / self.rows.step + 0.5;
        if !(r >= 0.0 && r < self.first.len() as f64) {
            return false;
        }
        let left = self.row(r as usize).iter().filter(|x| f64::from(**x) <= point.x);
        left.count() % 2 == 1
    }

    /// Bytes on the heap.
    pub fn heap_bytes(&self) -> usize {
        4 * (self.first.capacity() + self.crossings.capacity())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(first: f64, step: f64, count: usize) -> EvenSteps {
        EvenSteps { first, step, count }
    }

    fn square(from: f64, to: f64) -> Vec<Point2<f64>> {
        [(from, from), (to, from), (to, to), (from, to)].map(|(x, y)| Point2::new(x, y)).to_vec()
    }

    #[test]
    fn a_frame_contains_its_rim_and_not_its_hole() {
        let frame = Scanlines::new(&[square(0.0, 10.0), square(3.0, 7.0)], steps(-1.0, 0.5, 30));
        for (x, y, inside) in [
            (1.0, 5.0, true),
            (5.0, 5.0, false),
            (8.0, 5.0, true),
            (5.0, 1.0, true),
            (-1.0, 5.0, false),
            (11.0, 5.0, false),
            (5.0, -3.0, false),
            (5.0, 40.0, false),
            (f64::NAN, 5.0, false),
            (5.0, f64::NAN, false),
        ] {
            assert_eq!(frame.contains(&Point2::new(x, y)), inside, "({x}, {y})");
        }
    }

    #[test]
    fn the_lengths_of_the_rows_add_up_to_the_area() {
        let triangle = vec![Point2::new(0.0, 0.0), Point2::new(8.0, 1.0), Point2::new(2.0, 9.0)];
        let lines = Scanlines::new(&[triangle], steps(0.005, 0.01, 900));
        let covered: f32 = (0..900).map(|r| lines.row(r)).map(|row| row[1] - row[0]).sum();
        approx::assert_relative_eq!(covered * 0.01, 35.0, epsilon = 1e-2);
    }
}
