//! From a mask to a silhouette.

use std::sync::Arc;

use nalgebra::{Point2, Vector2};

use super::distance_map::MapExtent;
use super::{ContourPoint, DistanceMap, Silhouette, SilhouetteOptions};
use crate::camera::Camera;
use crate::image::{EvenSteps, Mask, Runs, Scanlines, clean, resample, trace};

/// Border points closer than this to the image edge are on it: the blur of the border reaches two pixels.
const EDGE_PX: f64 = 2.0;
/// A mask with foreground on more than this fraction of its outermost pixels shows no person.
const FULL_FRACTION: f64 = 0.9;
/// Points along each side of the image's own outline, which the lens bends.
const OUTLINE_STEPS: usize = 24;
/// Scan lines of the inside of a silhouette, unless they would be closer than a pixel.
const INSIDE_ROWS: f64 = 1000.0;

/// Why a mask shows no silhouette.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Rejected {
    /// No foreground.
    #[error("the mask is empty")]
    Empty,
    /// Foreground nearly all along the image edge.
    #[error(
        "the foreground covers {edge_percent:.0} % of the image edge: is foreground white and background black?"
    )]
    Full {
        /// Share of the outermost pixels that is foreground.
        edge_percent: f64,
    },
    /// Foreground too thin to have a border, or with no border inside the image.
    #[error("the foreground of {area_px} px has no border inside the image")]
    NoBorder {
        /// Number of foreground pixels.
        area_px: usize,
    },
    /// The mask is not of the size that the camera was calibrated for.
    #[error("the mask is {} × {} px, expected {} × {} px", found.0, found.1, expected.0, expected.1)]
    Size {
        /// Width and height of the calibration.
        expected: (usize, usize),
        /// Width and height of the mask.
        found: (usize, usize),
    },
}

/// The silhouette that a mask shows.
///
/// In the image as recorded, specks are removed and small holes filled ([`clean`]), borders traced ([`trace`]) and
/// resampled at equal arc length ([`resample`]). Only then are they undistorted, point by point; points that the lens model
/// does not cover are left out.
///
/// `options` must be valid.
///
/// # Errors
/// [`Rejected`] if the mask does not have the camera's size, or nothing in it can be a person's silhouette.
pub fn extract(
    mask: &Mask,
    camera: &Camera,
    options: &SilhouetteOptions,
) -> Result<Silhouette, Rejected> {
    let runs = usable_runs(mask, camera)?;
    let cleaned = clean(&runs, &options.clean);
    let region = cleaned.region().ok_or(Rejected::Empty)?;
    let size_px = (region.right - region.left).max(region.bottom - region.top) as f64;
    let spacing_px = options.spacing_px.max(size_px / options.points_per_size);

    let traced = trace(&cleaned);
    let borders = traced.iter();
    let borders = borders.map(|closed| Border::new(&resample(closed, spacing_px), camera));
    let borders: Vec<Border> = borders.collect();
    assembled(&borders, camera, options)
        .ok_or_else(|| Rejected::NoBorder { area_px: cleaned.area() })
}

/// A point of a silhouette's border, as an active contour leaves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BorderPoint {
    /// Where, undistorted px.
    pub pixel: Point2<f64>,
    /// How sure it is that the border is here, 0 to 1.
    pub reliability: f64,
}

/// The silhouette within closed curves, which run with the person on the left as seen on the screen.
///
/// `options` must be valid.
///
/// # Errors
/// [`Rejected::NoBorder`] if the curves enclose no area, or lie on the image edge all along.
pub fn from_curves(
    curves: &[Vec<BorderPoint>],
    camera: &Camera,
    options: &SilhouetteOptions,
) -> Result<Silhouette, Rejected> {
    let is_on_edge = |p: &BorderPoint| is_on_image_edge(&camera.distort(&p.pixel), camera);
    let borders = curves.iter().map(|curve| Border {
        pixels: curve.iter().map(|p| p.pixel).collect(),
        reliabilities: curve.iter().map(|p| p.reliability).collect(),
        is_on_image_edge: curve.iter().map(is_on_edge).collect(),
    });
    let borders: Vec<Border> = borders.collect();
    assembled(&borders, camera, options).ok_or(Rejected::NoBorder { area_px: 0 })
}

/// The silhouette of its borders; `None` if they enclose no area, or lie on the image edge all along.
fn assembled(
    borders: &[Border],
    camera: &Camera,
    options: &SilhouetteOptions,
) -> Option<Silhouette> {
    let polygons: Vec<_> = borders.iter().map(|border| border.pixels.clone()).collect();
    let (area_px, centroid) = area_and_centroid(&polygons)?;
    let bounds = bounds(polygons.iter().flatten())?;
    let contour = Contour::new(borders);
    if contour.points.is_empty() {
        return None;
    }

    let extent = MapExtent { bounds, margin: options.map_margin, cells: options.map_cells };
    Some(Silhouette {
        outside: Arc::new(DistanceMap::new(&polygons, image_outline(camera), &extent)),
        inside: inside(&polygons, bounds),
        contour: contour.points,
        area_px,
        centroid,
        bounds,
        cut_px: contour.cut_px,
        pieces: contour.pieces,
        others: Scanlines::default(),
    })
}

/// The runs of a mask that has the camera's size, some foreground, and background at its edge.
fn usable_runs(mask: &Mask, camera: &Camera) -> Result<Runs, Rejected> {
    let expected = (camera.width_px as usize, camera.height_px as usize);
    let found = (mask.width(), mask.height());
    if found != expected {
        return Err(Rejected::Size { expected, found });
    }

    let runs = Runs::from_mask(mask);
    if runs.area() == 0 {
        return Err(Rejected::Empty);
    }

    let edge_percent = 100.0 * edge_foreground(mask);
    if edge_percent > 100.0 * FULL_FRACTION {
        return Err(Rejected::Full { edge_percent });
    }
    Ok(runs)
}

/// Fraction of the outermost pixels that is foreground.
fn edge_foreground(mask: &Mask) -> f64 {
    let ends = |y: usize| {
        let row = mask.row(y);
        row.first().into_iter().chain(row.last())
    };
    let last = mask.height().saturating_sub(1);
    let pixels = (0..mask.height()).flat_map(ends);
    let pixels = pixels.chain(mask.row(0)).chain(mask.row(last));
    let (count, set) =
        pixels.fold((0u32, 0u32), |(count, set), pixel| (count + 1, set + u32::from(*pixel)));
    f64::from(set) / f64::from(count.max(1))
}

/// Whether a pixel of the recorded image is within [`EDGE_PX`] of its edge, or beyond.
fn is_on_image_edge(recorded: &Point2<f64>, camera: &Camera) -> bool {
    let inner = |x: f64, size: u32| (EDGE_PX - 0.5..=f64::from(size) - 0.5 - EDGE_PX).contains(&x);
    !(inner(recorded.x, camera.width_px) && inner(recorded.y, camera.height_px))
}

/// One closed border, undistorted.
struct Border {
    pixels: Vec<Point2<f64>>,
    reliabilities: Vec<f64>,
    is_on_image_edge: Vec<bool>,
}

impl Border {
    fn new(recorded: &[Point2<f64>], camera: &Camera) -> Self {
        let (pixels, is_on_image_edge): (Vec<_>, Vec<_>) = recorded
            .iter()
            .filter_map(|pixel| {
                let is_on_edge = is_on_image_edge(pixel, camera);
                Some((camera.undistort(pixel)?, is_on_edge))
            })
            .unzip();
        Self { reliabilities: vec![1.0; pixels.len()], pixels, is_on_image_edge }
    }

    /// The contour point at `i`; `None` on the image edge, or where the border turns back on itself.
    ///
    /// The tangent is that from neighbour to neighbour, those on the image edge left out.
    fn point(&self, i: usize) -> Option<ContourPoint> {
        let count = self.pixels.len();
        let neighbour = |j: usize| if self.is_on_image_edge[j] { i } else { j };
        let before = neighbour((i + count - 1) % count);
        let after = neighbour((i + 1) % count);
        let along = self.pixels[after] - self.pixels[before];
        // foreground on the left on the screen: with y down, outward is (−dy, dx)
        let normal = Vector2::new(-along.y, along.x).try_normalize(f64::EPSILON)?;
        (!self.is_on_image_edge[i]).then_some(ContourPoint {
            pixel: self.pixels[i],
            normal,
            length_px: self.length_at(i),
            reliability: self.reliabilities[i],
        })
    }

    /// Half of the way to each neighbour.
    fn length_at(&self, i: usize) -> f64 {
        let count = self.pixels.len();
        let to = |j: usize| (self.pixels[j % count] - self.pixels[i]).norm();
        0.5 * (to(i + count - 1) + to(i + 1))
    }
}

/// The points of all borders, as a [`Silhouette`] holds them.
#[derive(Default)]
struct Contour {
    points: Vec<ContourPoint>,
    pieces: Vec<usize>,
    cut_px: f64,
}

impl Contour {
    fn new(borders: &[Border]) -> Self {
        let mut contour = Self::default();
        for border in borders {
            contour.add(border);
        }
        contour.points.shrink_to_fit();
        contour
    }

    /// Adds a border, from where the image cuts it or from anywhere.
    fn add(&mut self, border: &Border) {
        let count = border.pixels.len();
        let start = border.is_on_image_edge.iter().position(|is_on| *is_on);
        let mut is_broken = true;
        for i in (0..count).map(|k| (k + start.unwrap_or(0)) % count) {
            let Some(point) = border.point(i) else {
                is_broken = true;
                self.cut_px += border.length_at(i);
                continue;
            };

            if is_broken {
                self.pieces.push(self.points.len());
                is_broken = false;
            }
            self.points.push(point);
        }
    }
}

/// Area without the holes, and its centroid (Green's theorem); `None` if the area is not positive.
fn area_and_centroid(polygons: &[Vec<Point2<f64>>]) -> Option<(f64, Point2<f64>)> {
    let mut doubled = 0.0;
    let mut moment = Vector2::zeros();
    for polygon in polygons {
        for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            let cross = b.x * a.y - a.x * b.y;
            doubled += cross;
            moment += (a.coords + b.coords) * cross;
        }
    }
    (doubled > 0.0).then(|| (0.5 * doubled, Point2::from(moment / (3.0 * doubled))))
}

fn bounds<'a>(
    mut points: impl Iterator<Item = &'a Point2<f64>>,
) -> Option<(Point2<f64>, Point2<f64>)> {
    let first = points.next()?;
    Some(points.fold((*first, *first), |(low, high), point| (low.inf(point), high.sup(point))))
}

/// The inside of border polygons, of which `bounds` are the corners of their box.
fn inside(polygons: &[Vec<Point2<f64>>], bounds: (Point2<f64>, Point2<f64>)) -> Scanlines {
    let (low, high) = bounds;
    let height = high.y - low.y;
    let step = (height / INSIDE_ROWS).max(1.0);
    let rows = EvenSteps {
        // half a step off the top: no row runs along a horizontal border
        first: low.y + 0.5 * step,
        step,
        count: (height / step).ceil() as usize,
    };
    Scanlines::new(polygons, rows)
}

/// The outline of the image itself, undistorted.
fn image_outline(camera: &Camera) -> Vec<Point2<f64>> {
    let right = f64::from(camera.width_px) - 0.5;
    let bottom = f64::from(camera.height_px) - 0.5;
    let corners = [
        Point2::new(-0.5, -0.5),
        Point2::new(right, -0.5),
        Point2::new(right, bottom),
        Point2::new(-0.5, bottom),
    ];
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    sides
        .flat_map(|(a, b)| {
            (0..OUTLINE_STEPS).map(move |k| a + (b - a) * (k as f64 / OUTLINE_STEPS as f64))
        })
        .filter_map(|pixel| camera.undistort(&pixel))
        .collect()
}
