//! Dense points by least-squares matching in several images at once (PFD99 § 2.1).
//!
//! One image is the template. [`match_surface`] finds seeds (corners, correlated along the epipolar lines, alike in all
//! images), cuts the template into their Voronoi regions, goes from each seed horizontally and then vertically through
//! its region, each match starting from the plane of the one before, closes holes from all directions, and gives every
//! matched pixel as a point with its covariance.
//!
//! | file             | holds                                                               |
//! |------------------|---------------------------------------------------------------------|
//! | `epipolar.rs`    | where a pixel of the template is seen in another image, by its depth |
//! | `multi_image.rs` | least-squares matching of one patch in all images                    |
//! | `seeds.rs`       | seeds                                                               |
//! | `regions.rs`     | Voronoi regions, and the way through one                             |
//! | `holes.rs`       | closing holes, and what is left away                                 |
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
pub(super) use multi_image::{Match, Patch, Plane3, pixels_around};
use multi_image::{Unmatched, fit};

/// How surfaces are matched.
#[derive(Debug, Clone, PartialEq)]
pub struct MatchOptions {
    /// A patch has (2·radius + 1)² pixels. 5: 11 × 11; 6 is PFD99's 13 × 13, too large for a curved limb far away.
    pub radius_px: usize,
    /// The larger patch where that one fails. 8: 17 × 17.
    pub larger_radius_px: usize,
    /// Distance of neighbouring points in the template. 2.
    pub spacing_px: usize,
    /// Images besides the template in which a point must be found. 2: triplets (PFD99).
    pub least_images: usize,
    /// Least correlation coefficient of the template's patch with that of any image. Noise lowers it without harm: the
    /// standard deviation is the stricter judge. 0.6.
    pub least_correlation: f64,
    /// Largest standard deviation of a match by its normal matrix, and of a point with what its neighbours say, px. 0.2.
    pub most_sigma_px: f64,
    /// Error of a match that neither the normal matrix nor its neighbours see (calibration, brightness), px. 0.05.
    pub model_sigma_px: f64,
    /// Nearest and farthest depth of seeds, metres; where not given, from a shift of a third of an image to infinity.
    pub depth: Option<(f64, f64)>,
    /// Seeds are looked for in squares of so many pixels, one in each. 16.
    pub seed_cell_px: usize,
    /// Connected points fewer than this are left away. 20.
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
    /// Too few images.
    #[error("{found} images beside the template: expected {expected} to 32")]
    Images {
        /// Needed.
        expected: usize,
        /// Given.
        found: usize,
    },
    /// One place.
    #[error(
        "cameras {template} and {other} are in one place: expected a distance between them, to measure depth by"
    )]
    NoBaseline {
        /// The template's camera.
        template: String,
        /// The other one.
        other: String,
    },
    /// A number that makes no sense.
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
    /// The images used, a bit each, in the order given.
    pub images: u32,
    /// The plane of the patch, for neighbours and other frames.
    pub(super) plane: Plane3,
}

/// What was matched, and what was not.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MatchedSurface {
    /// The points, row by row of the template.
    pub points: Vec<MatchedPoint>,
    /// Seeds that were found.
    pub seeds: usize,
    /// Pixels that were asked for and have no point.
    pub unmatched: usize,
    /// Of these, pixels around which the template has no texture.
    pub without_texture: usize,
}

/// An image in which patches of the template are looked for.
#[derive(Debug)]
struct Other<'a> {
    view: &'a StereoView,
    epipolar: Epipolar,
}

/// All that stays the same for every patch.
#[derive(Debug)]
pub(super) struct Stage<'a> {
    template: &'a StereoView,
    others: Vec<Other<'a>>,
    mask: Option<&'a Mask>,
}

impl<'a> Stage<'a> {
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
            Ok(Other {
                view,
                epipolar: Epipolar::new(&template.camera, &view.camera),
            })
        };
        let others = others.iter().map(other).collect::<Result<_, _>>()?;
        Ok(Self {
            template,
            others,
            mask,
        })
    }

    /// Whether a pixel of the template may show the subject.
    fn shows_subject(&self, x: usize, y: usize) -> bool {
        self.mask.is_none_or(|mask| mask.is_foreground(x, y))
    }

    /// The largest |∂u/∂w| of any image, px·m.
    fn reach(&self, (x, y): (usize, usize), w: f64) -> f64 {
        let pixel = Point2::new(x as f64, y as f64);
        let seen = self
            .others
            .iter()
            .filter_map(|o| o.epipolar.seen(&o.epipolar.direction(&pixel), w));
        seen.map(|seen| seen.by_inverse_depth.norm())
            .fold(0.0, f64::max)
    }

    /// Matches a patch in all images.
    pub(super) fn find_patch(
        &self,
        patch: &Patch,
        start: &Plane3,
        options: &MatchOptions,
    ) -> Option<Match> {
        let all = u32::MAX >> (32 - self.others.len());
        fit(self, patch, start, all, options).ok()
    }

    /// Where a place of the template is seen in each other image.
    pub(super) fn images_of(&self, place: &Point2<f64>, w: f64) -> Option<Vec<Point2<f64>>> {
        let seen = self
            .others
            .iter()
            .map(|o| o.epipolar.seen(&o.epipolar.direction(place), w));
        seen.map(|seen| Some(seen?.pixel)).collect()
    }

    /// Matches the patch at a pixel in all images, else in all but one, as long as these are enough.
    fn find(
        &self,
        pixel: (usize, usize),
        start: &Plane3,
        radius: usize,
        options: &MatchOptions,
    ) -> Result<Match, Unmatched> {
        let patch = Patch::at(self, pixel, radius);
        let all = u32::MAX >> (32 - self.others.len());
        let found = fit(self, &patch, start, all, options);
        if found.is_ok() || self.others.len() <= options.least_images {
            return found;
        }
        let without = (0..self.others.len()).map(|i| all & !(1 << i));
        let fewer = without.filter_map(|images| fit(self, &patch, start, images, options).ok());
        let surest = fewer.min_by(|a, b| a.sigma_px.total_cmp(&b.sigma_px));
        surest.map_or(found, Ok)
    }

    /// [`Stage::find`], and where that fails with a larger patch.
    fn find_adaptively(
        &self,
        pixel: (usize, usize),
        start: &Plane3,
        options: &MatchOptions,
    ) -> Result<Match, Unmatched> {
        self.find(pixel, start, options.radius_px, options)
            .or_else(|unmatched| {
                let larger = self.find(pixel, start, options.larger_radius_px, options);
                larger.map_err(|_| unmatched)
            })
    }
}

/// The points of the surface that the template and the other images show.
///
/// `mask` says which pixels of the template show the subject; patches use no others. `given` are seeds beside those
/// that are found: points of the surface, roughly. The result is the same for any number of threads.
///
/// # Errors
/// [`MatchError`] for too few images, cameras in one place and options that make no sense.
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
    let stage = Stage::new(template, others, mask)?;
    // 1. seeds, and the Voronoi region of each
    let seeds = seeds::find(&stage, given, options);
    // 2. through each region, horizontally and vertically
    let mut grid = regions::grow(&stage, &seeds, options);
    // 3. holes, from all directions
    holes::close(&stage, &mut grid, options);
    // 4. what hides behind another point, and stray regions
    holes::prune(&stage, &mut grid, options);
    // 5. forward intersection
    Ok(surface::points(&stage, &grid, seeds.len(), options))
}

/// Matches at every `spacing`-th pixel of every `spacing`-th row.
type Grid = Plane<Option<Match>>;

fn check(others: usize, options: &MatchOptions) -> Result<(), MatchError> {
    let needed = options.least_images.max(1);
    if !(needed..=32).contains(&others) {
        return Err(MatchError::Images {
            expected: needed,
            found: others,
        });
    }
    let wrong = |name, found, expected| {
        Err(MatchError::Option {
            name,
            found,
            expected,
        })
    };
    let (near, far) = options.depth.unwrap_or((1.0, 2.0));
    if !(1..=50).contains(&options.radius_px) {
        return wrong("radius_px", options.radius_px as f64, "1 to 50");
    }
    if !(options.radius_px..=100).contains(&options.larger_radius_px) {
        return wrong(
            "larger_radius_px",
            options.larger_radius_px as f64,
            "radius_px to 100",
        );
    }
    if options.spacing_px == 0 || options.seed_cell_px == 0 {
        return wrong("spacing_px or seed_cell_px", 0.0, "1 or more");
    }
    if !(near > 0.0 && far > near) {
        return wrong(
            "the nearest depth",
            near,
            "more than 0 and less than the farthest",
        );
    }
    Ok(())
}
