//! Dense points by least-squares matching in several images at once (PFD99 § 2.1).
//!
//! One image is the template. [`match_surface`] finds seeds: corners that look alike in all images, by correlation along the
//! epipolar lines. It cuts the template into the seeds' Voronoi regions and goes from each seed through its region,
//! horizontally and then vertically, each match starting from the plane of the one before. It closes holes from all
//! directions, and gives every matched pixel as a point with its covariance.
//!
//! | file             | holds                                                               |
//! |------------------|---------------------------------------------------------------------|
//! | `epipolar.rs`    | where a pixel of the template is seen in another image, by its depth |
//! | `multi_image.rs` | least-squares matching of one patch in all images                    |
//! | `seeds.rs`       | seeds                                                               |
//! | `regions.rs`     | Voronoi regions, and the way through one                             |
//! | `holes.rs`       | closing holes, and removing false matches                            |
//! | `surface.rs`     | from matches to points with their covariance                         |

mod epipolar;
mod holes;
mod multi_image;
mod regions;
mod seeds;
mod surface;

use nalgebra::{Point2, Point3};

use super::CloudPoint;
use super::view::StereoView;
use crate::image::{Mask, Plane};
use epipolar::Epipolar;
pub(super) use epipolar::point_world;
pub(super) use multi_image::{DepthPlane, Match, Patch, PatchPixel, pixels_around};
use multi_image::{Unmatched, fit};

/// How surfaces are matched.
#[derive(Debug, Clone, PartialEq)]
pub struct MatchOptions {
    /// A patch has (2·radius + 1)² pixels. 5: 11 × 11; 6 is PFD99's 13 × 13 (§ 2.1), too large for a curved limb far away.
    pub radius_px: usize,
    /// The larger patch where that one fails. 8: 17 × 17.
    pub larger_radius_px: usize,
    /// Distance of neighbouring points in the template. 2.
    pub spacing_px: usize,
    /// Images besides the template in which a point must be found. 2: triplets (PFD99 § 2.1).
    pub least_images: usize,
    /// Least correlation coefficient of the template's patch with that of any image. Noise lowers the coefficient without
    /// harm; the standard deviation is the stricter test. 0.6.
    pub least_correlation: f64,
    /// Largest standard deviation of a match by its normal matrix, and of a point with its bend from its neighbours, px. 0.2.
    pub most_sigma_px: f64,
    /// Error of a match that neither the normal matrix nor its neighbours show (calibration, brightness), px. 0.05.
    pub model_sigma_px: f64,
    /// Nearest and farthest depth of seeds, metres; by default from a shift of a third of an image to infinity.
    pub depth: Option<(f64, f64)>,
    /// Side of the squares in each of which one seed is looked for, px. 16.
    pub seed_cell_px: usize,
    /// Regions of fewer connected points are removed. 20.
    pub least_region: usize,
}

impl Default for MatchOptions {
    fn default() -> Self {
        Self {
            radius_px: 5,
            larger_radius_px: 8,
            spacing_px: 2,
            least_images: 2,
            least_correlation: 0.6,
            most_sigma_px: 0.2,
            model_sigma_px: 0.05,
            depth: None,
            seed_cell_px: 16,
            least_region: 20,
        }
    }
}

/// Why nothing can be matched.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MatchError {
    /// Too few or too many images.
    #[error("{found} images beside the template: expected {expected} to 32")]
    Images {
        /// Needed.
        expected: usize,
        /// Given.
        found: usize,
    },
    /// Two cameras in one place.
    #[error(
        "cameras {template} and {other} are in one place: expected a distance between them, to measure depth by"
    )]
    NoBaseline {
        /// The template's camera.
        template: String,
        /// The other one.
        other: String,
    },
    /// An option outside its range.
    #[error("{name} is {found}: expected {expected}")]
    Option {
        /// Which.
        name: &'static str,
        /// As given.
        found: f64,
        /// What it may be.
        expected: &'static str,
    },
}

/// A pixel of the template that was found in other images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchedPoint {
    /// Column and row in the template.
    pub pixel: (usize, usize),
    /// Where it is, with its covariance.
    pub point: CloudPoint,
    /// Standard deviation by the normal matrix, in the image in which it is largest, px.
    pub sigma_px: f64,
    /// Least correlation coefficient with any image used.
    pub correlation: f64,
    /// The images used, one bit each, in the order given.
    pub images: u32,
    /// The plane of the patch, for neighbours and other frames.
    pub(super) plane: DepthPlane,
}

/// The points that were matched, and how much was not.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MatchedSurface {
    /// The points, row by row of the template.
    pub points: Vec<MatchedPoint>,
    /// Seeds that were found.
    pub seeds: usize,
    /// Pixels of the subject, at the spacing of the grid, that have no point.
    pub unmatched: usize,
    /// Of these, pixels around which the template has no texture.
    pub without_texture: usize,
}

/// An image in which patches of the template are looked for.
#[derive(Debug)]
struct OtherView<'a> {
    view: &'a StereoView,
    epipolar: Epipolar,
}

/// The template and the images in which its patches are looked for.
#[derive(Debug)]
pub(super) struct MatchViews<'a> {
    template: &'a StereoView,
    others: Vec<OtherView<'a>>,
    mask: Option<&'a Mask>,
}

impl<'a> MatchViews<'a> {
    pub(super) fn new(
        template: &'a StereoView,
        others: &[&'a StereoView],
        mask: Option<&'a Mask>,
    ) -> Result<Self, MatchError> {
        let other = |view: &&'a StereoView| {
            let distance = (view.camera.centre_world() - template.camera.centre_world()).norm();
            // nearer than a thousandth of a millimetre is one place
            if distance < 1e-6 {
                return Err(MatchError::NoBaseline {
                    template: template.camera.name.clone(),
                    other: view.camera.name.clone(),
                });
            }

            Ok(OtherView { view, epipolar: Epipolar::new(&template.camera, &view.camera) })
        };
        let others = others.iter().map(other).collect::<Result<_, _>>()?;
        Ok(Self { template, others, mask })
    }

    /// Whether a pixel of the template may show the subject.
    fn shows_subject(&self, x: usize, y: usize) -> bool {
        self.mask.is_none_or(|mask| mask.is_foreground(x, y))
    }

    /// All images, one bit each.
    fn all(&self) -> u32 {
        u32::MAX >> (32 - self.others.len())
    }

    /// How far the image of a pixel moves with inverse depth: the largest |∂u/∂w| of any image, px·m.
    fn reach(&self, pixel: (usize, usize), w: f64) -> f64 {
        let pixel = Point2::new(pixel.0 as f64, pixel.1 as f64);
        let others = self.others.iter();
        let images = others.filter_map(|o| o.epipolar.image(&o.epipolar.direction(&pixel), w));
        let reaches = images.map(|image| image.by_inverse_depth.norm());
        reaches.fold(0.0, f64::max)
    }

    /// Matches a patch in all images.
    pub(super) fn find_patch(
        &self,
        patch: &Patch,
        start: &DepthPlane,
        options: &MatchOptions,
    ) -> Option<Match> {
        fit(self, patch, start, self.all(), options).ok()
    }

    /// Where a place of the template is seen in each other image.
    pub(super) fn places_in_others(&self, place: &Point2<f64>, w: f64) -> Option<Vec<Point2<f64>>> {
        let others = self.others.iter();
        let images = others.map(|o| o.epipolar.image(&o.epipolar.direction(place), w));
        images.map(|image| Some(image?.pixel)).collect()
    }

    /// Matches the patch at a pixel in all images; where that fails, in all but one, as long as these are enough.
    fn find(
        &self,
        pixel: (usize, usize),
        start: &DepthPlane,
        radius: usize,
        options: &MatchOptions,
    ) -> Result<Match, Unmatched> {
        let patch = Patch::at(self, pixel, radius);
        let found = fit(self, &patch, start, self.all(), options);
        if found.is_ok() || self.others.len() <= options.least_images {
            return found;
        }

        let without = (0..self.others.len()).map(|i| self.all() & !(1 << i));
        let fewer = without.filter_map(|images| fit(self, &patch, start, images, options).ok());
        let surest = fewer.min_by(|a, b| a.sigma_px.total_cmp(&b.sigma_px));
        surest.map_or(found, Ok)
    }

    /// [`MatchViews::find`], with a larger patch where that fails.
    fn find_adaptively(
        &self,
        pixel: (usize, usize),
        start: &DepthPlane,
        options: &MatchOptions,
    ) -> Result<Match, Unmatched> {
        self.find(pixel, start, options.radius_px, options).or_else(|unmatched| {
            let larger = self.find(pixel, start, options.larger_radius_px, options);
            larger.map_err(|_| unmatched)
        })
    }
}

/// The points of the surface that the template and the other images show.
///
/// `mask` says which pixels of the template show the subject; patches use no others. `given` are further seeds: points
/// near the surface. The result is the same for any number of threads.
///
/// # Errors
/// [`MatchError`] for too few images, cameras in one place and options outside their range.
///
/// # Source
/// PFD99 § 2.1. **Differs**: seeds are found, not clicked; all images are matched at once instead of each by itself.
pub fn match_surface(
    template: &StereoView,
    others: &[&StereoView],
    mask: Option<&Mask>,
    given: &[Point3<f64>],
    options: &MatchOptions,
) -> Result<MatchedSurface, MatchError> {
    check(others.len(), options)?;
    let views = MatchViews::new(template, others, mask)?;
    // 1. seeds, and the Voronoi region of each
    let seeds = seeds::find(&views, given, options);
    // 2. through each region, horizontally and vertically
    let mut grid = regions::grow(&views, &seeds, options);
    // 3. holes, from all directions
    holes::close(&views, &mut grid, options);
    // 4. no point behind another, no stray regions
    holes::prune(&views, &mut grid, options);
    // 5. forward intersection
    Ok(surface::points(&views, &grid, seeds.len(), options))
}

/// Matches at every `spacing`-th pixel of every `spacing`-th row.
type Grid = Plane<Option<Match>>;

/// A place of the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    column: usize,
    row: usize,
}

impl Place {
    /// Its pixel in the template.
    fn pixel(self, options: &MatchOptions) -> (usize, usize) {
        let spacing = options.spacing_px;
        (self.column * spacing, self.row * spacing)
    }

    /// The place so many steps to the right and down; `None` left of the grid or above it.
    fn beside(self, right: isize, down: isize) -> Option<Self> {
        Some(Self {
            column: self.column.checked_add_signed(right)?,
            row: self.row.checked_add_signed(down)?,
        })
    }

    /// Its match, if it has one.
    fn found(self, grid: &Grid) -> Option<Match> {
        grid.get(self.column, self.row)?
    }
}

fn check(others: usize, options: &MatchOptions) -> Result<(), MatchError> {
    let needed = options.least_images.max(1);
    if !(needed..=32).contains(&others) {
        return Err(MatchError::Images { expected: needed, found: others });
    }

    let wrong = |name, found, expected| Err(MatchError::Option { name, found, expected });
    if !(1..=50).contains(&options.radius_px) {
        return wrong("radius_px", options.radius_px as f64, "1 to 50");
    }
    if !(options.radius_px..=100).contains(&options.larger_radius_px) {
        return wrong("larger_radius_px", options.larger_radius_px as f64, "radius_px to 100");
    }

    if options.spacing_px == 0 || options.seed_cell_px == 0 {
        return wrong("spacing_px or seed_cell_px", 0.0, "1 or more");
    }

    let (near, far) = options.depth.unwrap_or((1.0, 2.0));
    if !(near > 0.0 && far > near) {
        return wrong("the nearest depth", near, "more than 0 and less than the farthest");
    }
    Ok(())
}
