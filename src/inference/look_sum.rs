//! What looks add to the chain: each at a body whose place is moved by its camera's offset, and whose time by its clock's.
//!
//! A look has equations H, B, g of its own with respect to the body m̃ that it shows, and to s ([`CameraOffset`], [`Instant`]). With
//!
//! δm̃ = M Σⱼ wⱼ δmⱼ + D δc,
//!
//! M = diag(SRᵀ, 1) for the root's place and wⱼ the weights of the frames about its moment, it adds
//!
//! Hⱼₖ = wⱼwₖ MᵀHM,  H_cj = wⱼ DᵀHM,  H_cc = DᵀHD,  H_sj = wⱼ BM,  H_sc = BD,  gⱼ = wⱼ Mᵀg,  g_c = Dᵀg.

use nalgebra::{DMatrix, Matrix3};

use super::Look;
use super::camera_offset::{AHEAD, COMPONENTS, CameraOffset};
use super::camera_prior::{CameraRows, Free};
use super::instant::Instant;
use crate::body::Motion;
use crate::camera::Camera;
use crate::solver::{BorderedChain, Link, NormalEquations};

/// Frames before and after its own to which the parabola of a look may reach.
pub(super) const REACH: usize = 2;

/// A camera that is an unknown.
pub(super) struct Unknown<'a> {
    /// Where its components stand after those of the shape.
    pub(super) rows: CameraRows,
    pub(super) offset: CameraOffset,
    pub(super) free: Free,
    pub(super) calibrated: &'a Camera,
}

/// A look at a state.
pub(super) struct Placed<'a> {
    /// The frame in which it was recorded.
    pub(super) recorded: usize,
    pub(super) look: &'a Look<'a>,
    /// Its camera, where that is an unknown.
    pub(super) camera: Option<Unknown<'a>>,
    /// When it is.
    pub(super) instant: Instant,
    /// m̃.
    pub(super) seen: Motion,
}

impl Placed<'_> {
    /// The frame in whose chunk it is summed.
    pub(super) fn middle(&self) -> usize {
        self.instant.frames[self.instant.frames.len() / 2].0
    }
}

/// What a run of looks adds to a chain.
pub(super) struct LookSum {
    /// The frame of the first link.
    first: usize,
    links: Vec<Link>,
    corner: NormalEquations,
    /// −log p of what they show.
    pub(super) cost: f64,
}

impl LookSum {
    /// Nothing yet, of looks about these frames: m components of a motion, and so many that all share.
    pub(super) fn new(placed: &[Placed<'_>], m: usize, shared: usize) -> Self {
        let about = placed.iter().flat_map(|look| look.instant.frames.iter().map(|(i, _)| *i));
        let first = about.clone().min().unwrap_or(0);
        let end = about.max().unwrap_or(0) + 1;
        let widest = placed.iter().map(|look| look.instant.frames.len() - 1).max();
        Self {
            first,
            links: BorderedChain::zeros(end - first, m, shared, widest.unwrap_or(0)).links,
            corner: NormalEquations::zeros(shared),
            cost: 0.0,
        }
    }

    /// m.
    fn motion(&self) -> usize {
        self.links.first().map_or(0, |link| link.gradient.len())
    }

    /// Adds a look's equations of motion, and of motion and shape, to the frames about it and to its camera.
    pub(super) fn carry(&mut self, placed: &Placed<'_>, equations: &NormalEquations, weight: f64) {
        let m = self.motion();
        let p = equations.gradient.len() - m;
        let mut hessian = equations.hessian.view((0, 0), (m, m)) * weight;
        let mut border = equations.hessian.view((m, 0), (p, m)) * weight;
        let mut gradient = equations.gradient.rows(0, m) * weight;

        // of the camera
        let of_camera = placed.camera.as_ref().map(|camera| {
            hessian.fill_upper_triangle_with_lower_triangle();
            let (back, slopes) = camera.slopes(placed);
            let mut moved = &hessian * &slopes;
            let own = slopes.tr_mul(&moved);
            let with_shape = (&border * &slopes).transpose();
            let pulls = slopes.tr_mul(&gradient);
            let rows = camera.rows.all().map(|row| p + row);
            for (k, row) in rows.into_iter().enumerate() {
                for (l, column) in rows.into_iter().enumerate() {
                    self.corner.hessian[(row, column)] += own[(k, l)];
                }
                let mut of_shape = self.corner.hessian.view_mut((row, 0), (1, p));
                of_shape += with_shape.row(k);
                self.corner.gradient[row] += pulls[k];
            }

            // from the body that the camera shows to the one in the world
            moved = moved.transpose();
            if camera.free.pose {
                for columns in [&mut moved, &mut border, &mut hessian] {
                    turn_columns(columns, &back);
                }
                hessian.transpose_mut();
                turn_columns(&mut hessian, &back);
                let turned = back.transpose() * gradient.fixed_rows::<3>(0);
                gradient.fixed_rows_mut::<3>(0).copy_from(&turned);
            }
            (rows, moved)
        });

        for (n, (j, w)) in placed.instant.frames.iter().enumerate() {
            let link = &mut self.links[j - self.first];
            link.gradient.axpy(*w, &gradient, 1.0);
            link.diagonal += &hessian * (w * w);
            let mut of_shape = link.border.rows_mut(0, p);
            of_shape += &border * *w;
            if let Some((rows, moved)) = &of_camera {
                for (k, row) in rows.iter().enumerate() {
                    let mut of_camera = link.border.row_mut(*row);
                    of_camera += moved.row(k) * *w;
                }
            }
            for (k, v) in &placed.instant.frames[..n] {
                link.couplings[j - k - 1] += &hessian * (w * v);
            }
        }
    }

    /// Adds the equations of the shape alone.
    pub(super) fn add_shape(&mut self, equations: &NormalEquations, weight: f64) {
        let m = self.motion();
        let p = equations.gradient.len() - m;
        let mut corner = self.corner.hessian.view_mut((0, 0), (p, p));
        corner += equations.hessian.view((m, m), (p, p)) * weight;
        self.corner.gradient.rows_mut(0, p).axpy(weight, &equations.gradient.rows(m, p), 1.0);
    }

    /// Adds all of it to the chain.
    pub(super) fn add_to(self, chain: &mut BorderedChain) {
        chain.corner += self.corner.hessian;
        chain.corner_gradient += self.corner.gradient;
        for (link, own) in chain.links[self.first..].iter_mut().zip(self.links) {
            link.diagonal += own.diagonal;
            link.border += own.border;
            link.gradient += own.gradient;
            for (coupling, own) in link.couplings.iter_mut().zip(own.couplings) {
                *coupling += own;
            }
        }
    }
}

impl Unknown<'_> {
    /// SRᵀ, the part of M that is not 1, and D.
    fn slopes(&self, placed: &Placed<'_>) -> (Matrix3<f64>, DMatrix<f64>) {
        let mut slopes = DMatrix::zeros(placed.seen.angles.len() + 6, COMPONENTS);
        if self.free.clock {
            slopes.set_column(AHEAD, &placed.instant.velocity);
        }
        let (back, of_pose) = self.offset.slopes(self.calibrated, &placed.instant.motion);
        if self.free.pose {
            let along = back * slopes.fixed_view::<3, 1>(0, AHEAD);
            slopes.fixed_view_mut::<3, 1>(0, AHEAD).copy_from(&along);
            slopes.fixed_view_mut::<6, AHEAD>(0, 0).copy_from(&of_pose);
        }
        (back, slopes)
    }
}

/// Multiplies the first three columns by a matrix from the right.
fn turn_columns(matrix: &mut DMatrix<f64>, by: &Matrix3<f64>) {
    let turned = matrix.fixed_columns::<3>(0) * by;
    matrix.fixed_columns_mut::<3>(0).copy_from(&turned);
}
