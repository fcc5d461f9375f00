//! Ellipsoids as a camera sees them.
//!
//! An ellipsoid with centre c and shape matrix A = R·diag(a², b², c²)·Rᵀ has the dual quadric
//! Q* = \[A − ccᵀ, −c; −cᵀ, −1\] (design: T·diag(a²,b²,c²,−1)·Tᵀ). A camera P = \[M | p₄\] sees the dual
//! conic C* = P Q* Pᵀ = B − hhᵀ with B = M A Mᵀ, h = M c + p₄. With κ = h₃² − B₃₃ it is the ellipse
//!
//! - centre xₖ = (hₖ h₃ − Bₖ₃)/κ,
//! - shape Σₖₗ = (Bₖₗ − hₖ hₗ)/κ + xₖ xₗ, so that the outline is (x − c)ᵀ Σ⁻¹ (x − c) = 1.
//!
//! κ > 0 with h₃ > 0 says that the whole ellipsoid lies in front of the camera's principal plane.
//! Everything is linear in (c, A) but the division by κ, so derivatives need no differences.
//! `docs/ellipse-distance.md` derives all of this, with a figure.

use nalgebra::{Matrix2, Matrix3, Matrix3x4, SMatrix, Vector2, Vector3};

/// An ellipsoid in the world: 9 numbers, in the order of [`Ellipsoid::INDEX`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipsoid {
    /// c, metres.
    pub centre: Vector3<f64>,
    /// A, square metres, symmetric.
    pub shape: Matrix3<f64>,
}

impl Ellipsoid {
    /// Whether a point lies within: (x − c)ᵀ S⁻¹ (x − c) ≤ 1.
    pub fn contains(&self, point: &Vector3<f64>) -> bool {
        let offset = point - self.centre;
        let solved = self.shape.cholesky().map(|root| root.solve(&offset));
        solved.is_some_and(|solved| offset.dot(&solved) <= 1.0)
    }

    /// Places of the numbers 3..9 in A; the numbers 0..3 are the centre.
    pub const INDEX: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
}

/// An ellipse in an image: 5 numbers, cx cy Σxx Σxy Σyy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipse {
    /// c, pixels.
    pub centre: Vector2<f64>,
    /// Σ, square pixels, symmetric positive definite.
    pub shape: Matrix2<f64>,
}

/// ∂(ellipse)/∂(ellipsoid), 5 × 9.
pub type ProjectionJacobian = SMatrix<f64, 5, 9>;

/// The dual conic before the division by κ: B, h and κ of the module's text.
struct DualConic {
    b: Matrix3<f64>,
    h: Vector3<f64>,
    kappa: f64,
}

impl DualConic {
    /// `None` where the ellipsoid is behind or around the camera.
    fn new(projection: &Matrix3x4<f64>, ellipsoid: &Ellipsoid) -> Option<Self> {
        let m = projection.fixed_columns::<3>(0);
        let b = m * ellipsoid.shape * m.transpose();
        let h = m * ellipsoid.centre + projection.column(3);
        let kappa = h[2] * h[2] - b[(2, 2)];
        (h[2] > 0.0 && kappa > 1e-9 * h[2] * h[2]).then_some(Self { b, h, kappa })
    }

    fn ellipse(&self) -> Option<Ellipse> {
        let Self { b, h, kappa } = self;
        let centre = Vector2::new(h[0] * h[2] - b[(0, 2)], h[1] * h[2] - b[(1, 2)]) / *kappa;
        let flat = |k: usize, l: usize| (b[(k, l)] - h[k] * h[l]) / kappa + centre[k] * centre[l];
        let shape = Matrix2::new(flat(0, 0), flat(0, 1), flat(0, 1), flat(1, 1));
        (shape[(0, 0)] > 0.0 && shape.determinant() > 0.0).then_some(Ellipse { centre, shape })
    }
}

/// The ellipse that an ellipsoid projects to; `None` where it is behind or around the camera.
///
/// `projection` is K·\[R | t\], world metres to undistorted pixels.
///
/// # Source
/// ZS06, App. C; Hartley & Zisserman 2004, result 8.9.
pub fn project(projection: &Matrix3x4<f64>, ellipsoid: &Ellipsoid) -> Option<Ellipse> {
    DualConic::new(projection, ellipsoid)?.ellipse()
}

/// [`project`], with the derivative of the ellipse's 5 numbers with respect to the ellipsoid's 9.
pub fn project_with_jacobian(
    projection: &Matrix3x4<f64>,
    ellipsoid: &Ellipsoid,
) -> Option<(Ellipse, ProjectionJacobian)> {
    let conic = DualConic::new(projection, ellipsoid)?;
    let ellipse = conic.ellipse()?;
    let m = projection.fixed_columns::<3>(0);
    let mut jacobian = ProjectionJacobian::zeros();

    // ∂h/∂c = M
    for i in 0..3 {
        let dh = m.column(i).into_owned();
        jacobian.set_column(i, &differential(&conic, &ellipse, &Matrix3::zeros(), &dh));
    }

    // ∂B/∂Aᵣₛ = mᵣmₛᵀ + mₛmᵣᵀ, once on the diagonal
    for (i, (r, s)) in Ellipsoid::INDEX.into_iter().enumerate() {
        let outer = m.column(r) * m.column(s).transpose();
        let db = if r == s { outer } else { outer + outer.transpose() };
        jacobian.set_column(3 + i, &differential(&conic, &ellipse, &db, &Vector3::zeros()));
    }

    Some((ellipse, jacobian))
}

/// The change of the ellipse's 5 numbers when B and h change by `db` and `dh`.
fn differential(
    conic: &DualConic,
    ellipse: &Ellipse,
    db: &Matrix3<f64>,
    dh: &Vector3<f64>,
) -> SMatrix<f64, 5, 1> {
    let DualConic { b, h, kappa } = conic;
    let x = &ellipse.centre;
    let dkappa = 2.0 * h[2] * dh[2] - db[(2, 2)];
    let dx: Vector2<f64> =
        Vector2::from_fn(|k, _| (dh[k] * h[2] + h[k] * dh[2] - db[(k, 2)] - x[k] * dkappa) / kappa);
    let dshape = |k: usize, l: usize| {
        let outer = b[(k, l)] - h[k] * h[l];
        let douter = db[(k, l)] - dh[k] * h[l] - h[k] * dh[l];
        (douter - outer * dkappa / kappa) / kappa + dx[k] * x[l] + x[k] * dx[l]
    };
    SMatrix::from([[dx[0], dx[1], dshape(0, 0), dshape(0, 1), dshape(1, 1)]])
}

#[cfg(test)]
mod tests {
    use nalgebra::{DVector, Rotation3};

    use super::*;
    use crate::math::central_differences;

    fn camera() -> Matrix3x4<f64> {
        let k = Matrix3::new(760.0, 0.3, 399.5, 0.0, 755.0, 299.5, 0.0, 0.0, 1.0);
        let r = Rotation3::from_euler_angles(0.3, -0.4, 0.2);
        let mut rt = Matrix3x4::zeros();
        rt.fixed_columns_mut::<3>(0).copy_from(r.matrix());
        rt.set_column(3, &Vector3::new(0.1, -0.2, 4.0));
        k * rt
    }

    fn ellipsoid(numbers: &[f64]) -> Ellipsoid {
        let mut shape = Matrix3::zeros();
        for (i, (r, s)) in Ellipsoid::INDEX.into_iter().enumerate() {
            shape[(r, s)] = numbers[3 + i];
            shape[(s, r)] = numbers[3 + i];
        }
        Ellipsoid { centre: Vector3::new(numbers[0], numbers[1], numbers[2]), shape }
    }

    const NUMBERS: [f64; 9] = [0.1, -0.3, 0.2, 0.02, 0.003, -0.002, 0.05, 0.004, 0.03];

    #[test]
    fn a_point_on_the_outline_is_the_image_of_a_tangent_ray() {
        let (p, e) = (camera(), ellipsoid(&NUMBERS));
        let ellipse = project(&p, &e).unwrap();
        let l = ellipse.shape.cholesky().unwrap().l();
        // the plane through the camera and a tangent of the outline touches the ellipsoid: πᵀQ*π = 0
        for k in 0..12 {
            let (sin, cos) = (f64::from(k) * 0.5).sin_cos();
            let x = ellipse.centre + l * Vector2::new(cos, sin);
            let n = ellipse.shape.lu().solve(&(x - ellipse.centre)).unwrap();
            let line = Vector3::new(n[0], n[1], -n.dot(&x));
            let plane = p.transpose() * line;
            let normal = plane.fixed_rows::<3>(0);
            let tangency =
                normal.dot(&(e.shape * normal)) - (normal.dot(&e.centre) + plane[3]).powi(2);
            approx::assert_abs_diff_eq!(tangency / normal.norm_squared(), 0.0, epsilon = 1e-9);
        }
    }

    #[test]
    fn the_jacobian_is_that_of_the_projection() {
        let p = camera();
        let (_, jacobian) = project_with_jacobian(&p, &ellipsoid(&NUMBERS)).unwrap();
        let numeric = central_differences(9, 1e-4, |delta| {
            let numbers: Vec<f64> = NUMBERS.iter().zip(delta.iter()).map(|(a, b)| a + b).collect();
            let e = project(&p, &ellipsoid(&numbers)).unwrap();
            let s = e.shape;
            DVector::from_vec(vec![e.centre[0], e.centre[1], s[(0, 0)], s[(0, 1)], s[(1, 1)]])
        });
        for (a, n) in jacobian.iter().zip(numeric.iter()) {
            approx::assert_relative_eq!(a, n, max_relative = 1e-6, epsilon = 1e-3);
        }
    }

    #[test]
    fn an_ellipsoid_behind_or_around_the_camera_has_no_outline() {
        let p = Matrix3x4::identity();
        let ball =
            |z: f64| Ellipsoid { centre: Vector3::new(0.0, 0.0, z), shape: Matrix3::identity() };
        assert!(project(&p, &ball(5.0)).is_some());
        assert!(project(&p, &ball(0.5)).is_none());
        assert!(project(&p, &ball(-5.0)).is_none());
    }
}
