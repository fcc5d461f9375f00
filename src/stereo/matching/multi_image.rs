//! Least-squares matching of one patch in several images at once.
//!
//! The template's patch f and each other image's g_i obey f(p) = a_i·g_i(u_i(p)) + b_i + noise. Collinearity holds for
//! every pixel p of the patch: u_i(p) is where the point at inverse depth w(p) on p's line of sight is seen
//! ([`super::epipolar`]), and on a plane w is linear, w(p) = w + w_x·Δx + w_y·Δy. So three geometric unknowns place the patch
//! in all images; the affine maps follow from them. Contrast a_i and brightness b_i are eliminated: at each step they are
//! the regression of f on g_i.
//!
//! # Source
//! PFD99 § 2.1; Gruen 1985, *Adaptive least squares correlation*; Gruen & Baltsavias 1988, *Geometrically constrained
//! multiphoto matching*. **Differs**: there each image has an affine map of its own and collinearity is a weighted
//! observation of the patch's middle alone; here it binds every pixel, with 3 unknowns instead of 6 an image.

use nalgebra::{Matrix3, Point2, Vector3};

use super::{MatchOptions, MatchViews, OtherView};
use crate::image::{Mask, Plane};
use crate::stereo::bicubic::sample;

/// Steps after which a patch that still moves is given up.
const MOST_STEPS: usize = 12;
/// A patch that moves less in every image is at rest, px.
const AT_REST_PX: f64 = 0.01;
/// Largest step in any image, px.
const LARGEST_STEP_PX: f64 = 1.5;
/// How far a patch may move from where it was expected, px.
const FARTHEST_PX: f64 = 4.0;
/// Share of the template's patch that an image must show.
const LEAST_SHOWN: f64 = 0.6;
/// Standard deviation of the slope of disparity that is expected, px/px.
const SLOPE_SD: f64 = 0.5;

/// A plane in front of the template's camera: inverse depth at a pixel and its slopes, 1/m and 1/(m·px).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::stereo) struct DepthPlane {
    pub(in crate::stereo) w: f64,
    pub(in crate::stereo) slope: [f64; 2],
}

impl DepthPlane {
    /// The same plane at the pixel (dx, dy) farther.
    pub(super) fn moved(&self, dx: f64, dy: f64) -> Self {
        Self { w: self.w + self.slope[0] * dx + self.slope[1] * dy, ..*self }
    }
}

/// A patch that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::stereo) struct Match {
    pub(in crate::stereo) plane: DepthPlane,
    /// Standard deviation of w, 1/m, from the normal matrix.
    pub(super) sigma: f64,
    /// The same in the image where it is largest, px.
    pub(super) sigma_px: f64,
    /// Least correlation coefficient with any image used.
    pub(super) correlation: f64,
    /// Images used, one bit each.
    pub(super) images: u32,
}

/// Why no match was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::stereo) enum Unmatched {
    /// An image shows too little of the patch.
    Unseen,
    /// The normal matrix says that it cannot be placed.
    NoTexture,
    /// It does not come to rest near where it was expected.
    Astray,
    /// It looks different from the template.
    Different,
    /// It comes to rest, but its standard deviation is too large.
    Unsure,
}

/// A pixel of a patch.
#[derive(Debug, Clone, Copy)]
pub(in crate::stereo) struct PatchPixel {
    /// Place relative to the middle of the patch, px.
    pub(in crate::stereo) dx: f64,
    pub(in crate::stereo) dy: f64,
    /// Brightness.
    pub(in crate::stereo) value: f32,
}

/// The template's patch.
#[derive(Debug, Clone)]
pub(in crate::stereo) struct Patch {
    middle: Point2<f64>,
    pixels: Vec<PatchPixel>,
    /// Pixels of a whole patch.
    whole: usize,
}

impl Patch {
    /// The patch of (2·radius + 1)² pixels around a pixel, without those outside the mask or the image.
    pub(super) fn at(views: &MatchViews<'_>, pixel: (usize, usize), radius: usize) -> Self {
        let (x, y) = pixel;
        let image = &views.template.image;
        let within = |middle: usize, size: usize| {
            middle.saturating_sub(radius)..=(middle + radius).min(size.saturating_sub(1))
        };

        let mut pixels = Vec::with_capacity((2 * radius + 1).pow(2));
        for row in within(y, image.height()) {
            for column in within(x, image.width()) {
                let value = image.row(row)[column];
                if value.is_finite() && views.shows_subject(column, row) {
                    pixels.push(PatchPixel {
                        dx: column as f64 - x as f64,
                        dy: row as f64 - y as f64,
                        value,
                    });
                }
            }
        }

        Self { middle: Point2::new(x as f64, y as f64), pixels, whole: (2 * radius + 1).pow(2) }
    }

    /// The patch around a place between the pixels.
    pub(in crate::stereo) fn around(
        views: &MatchViews<'_>,
        middle: Point2<f64>,
        radius: usize,
    ) -> Self {
        let pixels = pixels_around(&views.template.image, views.mask, middle, radius);
        Self { middle, pixels, whole: (2 * radius + 1).pow(2) }
    }

    pub(super) fn middle(&self) -> Point2<f64> {
        self.middle
    }

    pub(in crate::stereo) fn pixels(&self) -> &[PatchPixel] {
        &self.pixels
    }
}

/// Brightness around a place between the pixels, one pixel apart, without what the mask or the image does not show.
pub(in crate::stereo) fn pixels_around(
    image: &Plane<f32>,
    mask: Option<&Mask>,
    middle: Point2<f64>,
    radius: usize,
) -> Vec<PatchPixel> {
    let side = 2 * radius + 1;
    let pixels = (0..side * side).filter_map(|i| {
        let [dx, dy] = [i % side, i / side].map(|k| k as f64 - radius as f64);
        let place = Point2::new(middle.x + dx, middle.y + dy);
        let value = sample(image, place.x, place.y)?.value;
        // a sample lies at (1, 1) or further
        let shown = mask
            .is_none_or(|m| m.is_foreground(place.x.round() as usize, place.y.round() as usize));
        (value.is_finite() && shown).then_some(PatchPixel { dx, dy, value })
    });
    pixels.collect()
}

/// Sums over a patch in one image: of f, of g, of J = ∂g/∂(w, w_x, w_y), and of their products.
#[derive(Debug, Clone, Copy)]
struct PatchSums {
    /// |∂u/∂w| at the middle, px·m.
    reach: f64,
    count: f64,
    f: f64,
    ff: f64,
    g: f64,
    gg: f64,
    fg: f64,
    j: Vector3<f64>,
    fj: Vector3<f64>,
    gj: Vector3<f64>,
    jj: Matrix3<f64>,
}

impl PatchSums {
    fn zero(reach: f64) -> Self {
        Self {
            reach,
            count: 0.0,
            f: 0.0,
            ff: 0.0,
            g: 0.0,
            gg: 0.0,
            fg: 0.0,
            j: Vector3::zeros(),
            fj: Vector3::zeros(),
            gj: Vector3::zeros(),
            jj: Matrix3::zeros(),
        }
    }

    fn add(&mut self, f: f64, g: f64, j: &Vector3<f64>) {
        self.count += 1.0;
        self.f += f;
        self.ff += f * f;
        self.g += g;
        self.gg += g * g;
        self.fg += f * g;
        self.j += j;
        self.fj += j * f;
        self.gj += j * g;
        self.jj += j * j.transpose();
    }
}

/// The normal equations of one image, without contrast and brightness.
struct ReducedEquations {
    normal: Matrix3<f64>,
    right: Vector3<f64>,
    squares: f64,
    count: f64,
    correlation: f64,
    /// |∂u/∂w| at the middle, px·m.
    reach: f64,
}

/// The sums of one image at a plane; `None` if it shows too little of the patch.
fn patch_sums(other: &OtherView<'_>, patch: &Patch, plane: &DepthPlane) -> Option<PatchSums> {
    let OtherView { view, epipolar } = other;
    let direction = epipolar.direction(&patch.middle);
    let middle = epipolar.image(&direction, plane.w)?;
    let mut sums = PatchSums::zero(middle.by_inverse_depth.norm());

    let [right, down] = epipolar.steps();
    for PatchPixel { dx, dy, value: f } in patch.pixels.iter().copied() {
        let direction = direction + right * dx + down * dy;
        let Some(image) = epipolar.image(&direction, plane.moved(dx, dy).w) else {
            continue;
        };
        let Some(g) = sample(&view.image, image.pixel.x, image.pixel.y) else {
            continue;
        };

        // ∂g/∂w = ∇g · ∂u/∂w
        let along = f64::from(g.slope[0]) * image.by_inverse_depth.x
            + f64::from(g.slope[1]) * image.by_inverse_depth.y;
        if along.is_finite() && g.value.is_finite() {
            let j = Vector3::new(along, along * dx, along * dy);
            sums.add(f64::from(f), f64::from(g.value), &j);
        }
    }
    (sums.count >= LEAST_SHOWN * patch.whole as f64).then_some(sums)
}

/// Eliminates contrast and brightness; `None` without contrast.
fn reduced(sums: &PatchSums) -> Option<ReducedEquations> {
    let n = sums.count;
    let (ff, gg) = (sums.ff - sums.f * sums.f / n, sums.gg - sums.g * sums.g / n);
    let fg = sums.fg - sums.f * sums.g / n;
    // less than a grey level of contrast is none
    if ff < n || gg < n {
        return None;
    }

    let fj = sums.fj - sums.j * (sums.f / n);
    let gj = sums.gj - sums.j * (sums.g / n);
    let jj = sums.jj - sums.j * sums.j.transpose() / n;
    let contrast = fg / gg;
    Some(ReducedEquations {
        normal: (jj - gj * gj.transpose() / gg) * (contrast * contrast),
        right: (fj - gj * contrast) * contrast,
        squares: ff - fg * contrast,
        count: n,
        correlation: fg / (ff * gg).sqrt(),
        reach: sums.reach,
    })
}

/// Moves the plane until the patch looks alike in all `images` (one bit each), by Gauss–Newton.
pub(in crate::stereo) fn fit(
    views: &MatchViews<'_>,
    patch: &Patch,
    start: &DepthPlane,
    images: u32,
    options: &MatchOptions,
) -> Result<Match, Unmatched> {
    if (patch.pixels.len() as f64) < LEAST_SHOWN * patch.whole as f64 {
        return Err(Unmatched::Unseen);
    }

    let mut plane = *start;
    for _ in 0..MOST_STEPS {
        let equations = image_equations(views, patch, &plane, images)?;
        let reach = equations.iter().map(|e| e.reach).fold(0.0, f64::max);
        let (normal, right, variance) = combined(&equations, &plane, reach);
        let factor = normal.cholesky().ok_or(Unmatched::NoTexture)?;

        let mut step = factor.solve(&right);
        let longest = step.x.abs() * reach;
        if !longest.is_finite() {
            return Err(Unmatched::NoTexture);
        }
        step *= (LARGEST_STEP_PX / longest).min(1.0);
        plane.w += step.x;
        plane.slope = [plane.slope[0] + step.y, plane.slope[1] + step.z];

        if (plane.w - start.w).abs() * reach > FARTHEST_PX {
            return Err(Unmatched::Astray);
        }
        if longest < AT_REST_PX {
            let sigma = (variance * factor.solve(&Vector3::x()).x).sqrt();
            let correlations = equations.iter().map(|e| e.correlation);
            let found = Match {
                plane,
                sigma,
                sigma_px: sigma * reach,
                correlation: correlations.fold(1.0, f64::min),
                images,
            };
            return accepted(found, options);
        }
    }
    Err(Unmatched::Astray)
}

/// A match, if it looks alike enough and is sure enough.
fn accepted(found: Match, options: &MatchOptions) -> Result<Match, Unmatched> {
    if found.correlation < options.least_correlation {
        Err(Unmatched::Different)
    } else if found.sigma_px <= options.most_sigma_px && found.plane.w > 0.0 {
        Ok(found)
    } else {
        Err(Unmatched::Unsure)
    }
}

/// The equations of each image used.
fn image_equations(
    views: &MatchViews<'_>,
    patch: &Patch,
    plane: &DepthPlane,
    images: u32,
) -> Result<Vec<ReducedEquations>, Unmatched> {
    let used = (0..views.others.len()).filter(|i| images >> i & 1 == 1);
    let equations = used.map(|i| {
        let sums = patch_sums(&views.others[i], patch, plane).ok_or(Unmatched::Unseen)?;
        reduced(&sums).ok_or(Unmatched::NoTexture)
    });
    equations.collect()
}

/// The normal equations of all images with the prior of the slopes, and the variance of the brightness.
fn combined(
    images: &[ReducedEquations],
    plane: &DepthPlane,
    reach: f64,
) -> (Matrix3<f64>, Vector3<f64>, f64) {
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    let (mut squares, mut count) = (0.0, 0.0);
    for image in images {
        normal += image.normal;
        right += image.right;
        squares += image.squares;
        count += image.count;
    }

    let unknowns = 3.0 + 2.0 * images.len() as f64;
    // brightness is rounded: no less than its variance
    let variance = (squares / (count - unknowns).max(1.0)).max(1.0 / 12.0);
    let precision = variance * (reach / SLOPE_SD).powi(2);
    for (axis, slope) in plane.slope.iter().enumerate() {
        normal[(axis + 1, axis + 1)] += precision;
        right[axis + 1] -= precision * slope;
    }
    (normal, right, variance)
}
