//! B-spline patches: one for each tube of the body.

use nalgebra::Vector3;

/// A uniform cubic B-spline surface that is periodic around and clamped along.
///
/// S(u, v) = Σᵢ Σⱼ Nᵢ(v) Bⱼ(u) Pᵢⱼ with u and v in \[0, 1\]: once around for u, from the first row of control points to
/// the last for v. The first and the last row's own curves bound the patch; a row of equal points is a pole. The
/// sampled points of the skin are the control points Pᵢⱼ, so the patch smooths them a little.
///
/// # Source
/// PFD99 § 3.1; Piegl & Tiller 1997, §§ 2.2, 3.4.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Patch {
    rows: usize,
    columns: usize,
    control: Vec<Vector3<f64>>,
}

impl Patch {
    /// The patch of rows of control points; `None` unless there are four rows or more, of one length of three or more.
    pub(super) fn new(control: &[Vec<Vector3<f64>>]) -> Option<Self> {
        let columns = control.first()?.len();
        let fits = control.len() >= 4 && columns >= 3 && control.iter().all(|r| r.len() == columns);
        fits.then(|| Self { rows: control.len(), columns, control: control.concat() })
    }

    /// Number of rows of control points.
    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// Where along the patch a row of control points pulls most: its Greville abscissa.
    pub(super) fn place_of_row(&self, row: usize) -> f64 {
        let sum: f64 = (1..=3).map(|k| self.knot(row + k)).sum();
        sum / (3.0 * self.spans())
    }

    /// The point at (u, v); u may be any number, v is brought into \[0, 1\].
    pub(super) fn at(&self, u: f64, v: f64) -> Vector3<f64> {
        let (first_column, around) = self.around_weights(u);
        let (first_row, along) = self.along_weights(v);
        let mut point = Vector3::zeros();
        for (i, along) in along.into_iter().enumerate() {
            let row = (first_row + i) * self.columns;
            let mut value = Vector3::zeros();
            for (j, around) in around.into_iter().enumerate() {
                value += self.control[row + (first_column + j) % self.columns] * around;
            }
            point += value * along;
        }
        point
    }

    /// The first of the four columns that count at u, and their weights.
    fn around_weights(&self, u: f64) -> (usize, [f64; 4]) {
        let x = u.rem_euclid(1.0) * self.columns as f64;
        let column = (x.floor() as usize).min(self.columns - 1);
        let f = x - column as f64;
        let g = 1.0 - f;
        let weights = [
            g.powi(3),
            3.0 * f.powi(3) - 6.0 * f * f + 4.0,
            3.0 * g.powi(3) - 6.0 * g * g + 4.0,
            f.powi(3),
        ];
        (column + self.columns - 1, weights.map(|w| w / 6.0))
    }

    /// The first of the four rows that count at v, and their weights.
    fn along_weights(&self, v: f64) -> (usize, [f64; 4]) {
        let x = v.clamp(0.0, 1.0) * self.spans();
        let first = (x.floor() as usize).min(self.rows - 4);

        // Cox–de Boor, degree by degree: after degree p, basis[k] is that of the knots from first + k on
        let mut basis = [0.0, 0.0, 0.0, 1.0, 0.0];
        for degree in 1..=3 {
            let below = basis;
            for k in 3 - degree..4 {
                let i = first + k;
                let rising = self.ratio(x - self.knot(i), i, i + degree) * below[k];
                let falling =
                    self.ratio(self.knot(i + degree + 1) - x, i + 1, i + degree + 1) * below[k + 1];
                basis[k] = rising + falling;
            }
        }

        (first, [basis[0], basis[1], basis[2], basis[3]])
    }

    /// A number over the distance of two knots; 0 where they coincide.
    fn ratio(&self, number: f64, low: usize, high: usize) -> f64 {
        let distance = self.knot(high) - self.knot(low);
        if distance > 0.0 { number / distance } else { 0.0 }
    }

    /// Four equal knots at each end, and steps of 1 between.
    fn knot(&self, index: usize) -> f64 {
        (index.saturating_sub(3) as f64).min(self.spans())
    }

    fn spans(&self) -> f64 {
        (self.rows - 3) as f64
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// A tube of radius 1 about z, 6 rows of 24 points, wobbling a little.
    fn tube() -> Patch {
        let point = |i: usize, j: usize| {
            let (sin, cos) = (TAU * j as f64 / 24.0).sin_cos();
            let radius = 1.0 + 0.05 * ((3 * i + 5 * j) % 7) as f64;
            Vector3::new(radius * cos, radius * sin, 0.5 * i as f64)
        };
        let row = |i: usize| (0..24).map(|j| point(i, j)).collect();
        Patch::new(&(0..6).map(row).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn it_closes_around_without_a_seam_and_ends_in_its_outer_rows() {
        let patch = tube();
        let (before, after) = (patch.at(1.0 - 1e-9, 0.4), patch.at(1e-9, 0.4));
        approx::assert_relative_eq!(before, after, epsilon = 1e-6);
        approx::assert_relative_eq!(patch.at(0.3, 0.0).z, 0.0);
        approx::assert_relative_eq!(patch.at(0.3, 1.0).z, 2.5, epsilon = 1e-12);
    }

    #[test]
    fn equal_control_points_are_kept_and_lines_stay_straight() {
        let places = tube();
        let row = |i: usize| vec![Vector3::new(1.0, 2.0, places.place_of_row(i)); 5];
        let patch = Patch::new(&(0..6).map(row).collect::<Vec<_>>()).unwrap();
        for v in [0.0, 0.1, 0.4, 0.83, 1.0] {
            let point = patch.at(0.37, v);
            approx::assert_relative_eq!(point, Vector3::new(1.0, 2.0, v), epsilon = 1e-12);
        }
    }

    #[test]
    fn too_few_or_ragged_rows_are_no_patch() {
        let row = vec![Vector3::zeros(); 5];
        assert!(Patch::new(&vec![row.clone(); 3]).is_none());
        assert!(Patch::new(&vec![vec![Vector3::zeros(); 2]; 4]).is_none());
        let mut ragged = vec![row; 4];
        ragged[2].pop();
        assert!(Patch::new(&ragged).is_none());
    }
}
