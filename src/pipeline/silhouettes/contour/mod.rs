//! The contours of one view: from the model's outline to the filtered edges, and on to where the person's colours end.

use nalgebra::Point2;

use super::filter::FilteredEdges;
use super::{ContourFault, ContourOptions, colours};
use crate::body::PartId;
use crate::camera::Camera;
use crate::image::{EvenSteps, Mask, Plane, Scanlines};
use crate::render::{ModelOutline, OutlinePoint};
use crate::silhouette::snake::{Ends, Snake, SnakeOptions, SnakePoint, area_on_the_left};
use crate::silhouette::{BorderPoint, Silhouette, SilhouetteOptions, from_curves};

/// A point of a contour. Undistorted pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundPoint {
    /// Where the border is.
    pub pixel: Point2<f64>,
    /// Where the model had it.
    pub expected: Point2<f64>,
    /// How sure it is, 0 to 1.
    pub reliability: f64,
    /// The part whose border it is, by the model.
    pub part: PartId,
}

/// The contours of one view.
#[derive(Debug, Clone)]
pub struct ViewContours {
    /// Closed, with the person on the left as seen on the screen; also around holes.
    pub outer: Vec<Vec<FoundPoint>>,
    /// Open: a limb before another.
    pub inner: Vec<Vec<FoundPoint>>,
    /// What was wrong; the model's own outline stands there, with reliability 0.
    pub faults: Vec<ContourFault>,
    /// For the likelihood; `None` if there is no contour.
    pub silhouette: Option<Silhouette>,
}

/// A contour that shrank to less than this share of its expected area is no contour.
const COLLAPSED: f64 = 0.2;
/// A contour that keeps less than this share of its points, and loses the others in folds, crossed itself.
const UNCROSSED: f64 = 0.9;
/// Depth changes by less than this from a point to the next along one contour, m.
const JUMP_M: f64 = 0.08;
/// A silhouette of which less than this share of the border is seen is cut by the image.
const CUT: f64 = 0.02;

impl ViewContours {
    /// Lets active contours move from the expected outline to the filtered edges, and on to where the person's colours end.
    ///
    /// `camera` is the recording's, with its lens; `colours` are red, green and blue without it.
    pub fn settle(
        camera: &Camera,
        outline: &ModelOutline,
        edges: &FilteredEdges,
        colours: &[Plane<f32>],
        options: &ContourOptions,
    ) -> Self {
        // what is amiss before anything moves
        let mut faults = Vec::new();
        let count = outline.outer.iter().map(Vec::len).sum::<usize>();
        if count == 0 {
            faults.push(ContourFault::NoOutline);
        }
        if edges.strong <= 0.0 && count > 0 {
            faults.push(ContourFault::Flat);
        }
        let is_cut = |p: &&OutlinePoint| !well_inside(camera, &p.pixel);
        let cut = outline.outer.iter().flatten().filter(is_cut).count();
        if cut as f64 > CUT * count as f64 {
            let percent = 100.0 * cut as f64 / count as f64;
            faults.push(ContourFault::PartlyOutside { percent });
        }

        // on to the edges
        let px_per_m = px_per_m(camera, outline);
        let mut outer = Vec::new();
        for curve in &outline.outer {
            match settled(curve, Ends::Closed, edges, px_per_m, options) {
                Ok(found) => outer.extend(found),
                Err(fault) => {
                    faults.extend(fault);
                    outer.push(as_expected(curve));
                }
            }
        }
        let inner = outline.inner.iter().map(|curve| {
            let found = settled(curve, Ends::Open, edges, px_per_m, options);
            found.unwrap_or_else(|_| vec![as_expected(curve)])
        });
        let inner = inner.flatten().collect();

        // and from there to where the colours end
        let outer = where_colours_end(&outer, colours);
        let silhouette = silhouette(&outer, camera);
        Self { outer, inner, faults, silhouette }
    }

    /// Mean reliability of the outer contours; 0 without any.
    pub fn mean_reliability(&self) -> f64 {
        let all = self.outer.iter().flatten().map(|p| p.reliability);
        let count = self.outer.iter().map(Vec::len).sum::<usize>();
        all.sum::<f64>() / count.max(1) as f64
    }

    /// What lies within the outer contours, undistorted px.
    pub(super) fn inside(&self) -> Option<Scanlines> {
        inside(&self.outer)
    }

    /// Takes it that nobody is there: no point counts any more.
    pub(super) fn distrust(&mut self, fault: ContourFault) {
        let curves = self.outer.iter_mut().chain(&mut self.inner);
        curves.flatten().for_each(|point| point.reliability = 0.0);
        let silhouette = self.silhouette.iter_mut();
        silhouette.flat_map(|s| &mut s.contour).for_each(|point| point.reliability = 0.0);
        self.faults.push(fault);
    }

    /// Takes it that some parts of the body are elsewhere: their border does not count.
    pub(super) fn distrust_parts(
        &mut self,
        parts: &[PartId],
        fault: ContourFault,
        camera: &Camera,
    ) {
        let points = self.outer.iter_mut().chain(&mut self.inner).flatten();
        points.filter(|p| parts.contains(&p.part)).for_each(|point| point.reliability = 0.0);
        self.silhouette = silhouette(&self.outer, camera);
        self.faults.push(fault);
    }

    /// The pixels of the recorded image within the outer contours.
    pub fn mask(&self, camera: &Camera) -> Mask {
        let (width, height) = (camera.width_px as usize, camera.height_px as usize);
        let inside = inside(&self.outer);
        Mask::from_fn(width, height, |x, y| {
            let pixel = camera.undistort(&Point2::new(x as f64, y as f64));
            pixel.zip(inside.as_ref()).is_some_and(|(p, inside)| inside.contains(&p))
        })
    }
}

/// What lies within outer contours, undistorted px; `None` without any, or of a size that no image has.
fn inside(outer: &[Vec<FoundPoint>]) -> Option<Scanlines> {
    let pixels = |curve: &Vec<FoundPoint>| curve.iter().map(|p| p.pixel).collect();
    let polygons: Vec<Vec<Point2<f64>>> = outer.iter().map(pixels).collect();
    let rows = polygons.iter().flatten().map(|p| p.y);
    let (top, bottom) = rows.fold((f64::MAX, f64::MIN), |(l, h), y| (l.min(y), h.max(y)));
    if polygons.is_empty() || (bottom - top).is_nan() || bottom - top > 1e5 {
        return None;
    }
    let top = top.floor() - 1.0;
    let rows = EvenSteps { first: top, step: 1.0, count: (bottom - top).ceil() as usize + 2 };
    Some(Scanlines::new(&polygons, rows))
}

/// The contours, moved to where the person's colours end beside them; where nothing was found they stay.
fn where_colours_end(outer: &[Vec<FoundPoint>], colours: &[Plane<f32>]) -> Vec<Vec<FoundPoint>> {
    let Some(person) = inside(outer) else {
        return outer.to_vec();
    };
    let moved = |(point, parting): (&FoundPoint, Point2<f64>)| match point.reliability > 0.0 {
        true => FoundPoint { pixel: parting, ..*point },
        false => *point,
    };

    let curves = outer.iter().map(|curve| {
        let pixels: Vec<Point2<f64>> = curve.iter().map(|p| p.pixel).collect();
        let parting = colours::parting(&pixels, colours, |p| person.contains(p));
        curve.iter().zip(parting).map(moved).collect()
    });
    curves.collect()
}

fn silhouette(outer: &[Vec<FoundPoint>], camera: &Camera) -> Option<Silhouette> {
    let border = |p: &FoundPoint| BorderPoint { pixel: p.pixel, reliability: p.reliability };
    let curves: Vec<Vec<BorderPoint>> =
        outer.iter().map(|curve| curve.iter().map(border).collect()).collect();
    from_curves(&curves, camera, &SilhouetteOptions::default()).ok()
}

/// Pixels per metre at the outline's middle depth; 0 without an outline.
pub(super) fn px_per_m(camera: &Camera, outline: &ModelOutline) -> f64 {
    let points = || outline.outer.iter().flatten();
    let count = points().count();
    let mean = points().map(|p| p.depth_m).sum::<f64>() / count.max(1) as f64;
    let focal_px = camera.intrinsics.focal_px();
    if mean > 0.0 { focal_px / mean } else { 0.0 }
}

fn well_inside(camera: &Camera, undistorted: &Point2<f64>) -> bool {
    let p = camera.distort(undistorted);
    let inside = |x: f64, size: u32| x > 2.0 && x < f64::from(size) - 3.0;
    inside(p.x, camera.width_px) && inside(p.y, camera.height_px)
}

fn as_expected(curve: &[OutlinePoint]) -> Vec<FoundPoint> {
    let point = |p: &OutlinePoint| FoundPoint {
        pixel: p.pixel,
        expected: p.pixel,
        reliability: 0.0,
        part: p.part,
    };
    curve.iter().map(point).collect()
}

/// An active contour at rest, first on the wide scale's edges and then on the narrow one's; several if it split.
///
/// The fault if there is no contour; `None` for a curve too short to be one, and in a flat picture.
fn settled(
    curve: &[OutlinePoint],
    ends: Ends,
    edges: &FilteredEdges,
    px_per_m: f64,
    options: &ContourOptions,
) -> Result<Vec<Vec<FoundPoint>>, Option<ContourFault>> {
    if edges.strong <= 0.0 {
        return Err(None);
    }

    let pixels: Vec<Point2<f64>> = curve.iter().map(|p| p.pixel).collect();
    let wide = options.snake(px_per_m, edges.strong);
    let mut snake = Snake::new(&pixels, ends, wide).ok_or(None)?;
    snake.settle(&edges.wide);

    let narrow = SnakeOptions { search_px: (0.4 * wide.search_px).max(2.0), ..wide };
    let mut snake = snake.with(narrow).ok_or(None)?;
    snake.settle(&edges.narrow);

    let points = snake.points(&edges.narrow);
    let found: Vec<FoundPoint> = points.iter().map(|p| attributed(p, curve)).collect();
    let piece = |l: Vec<usize>| -> Vec<FoundPoint> { l.into_iter().map(|i| found[i]).collect() };
    let loops: Vec<Vec<FoundPoint>> = snake.loops().into_iter().map(piece).collect();
    match ends {
        Ends::Open => Ok(loops),
        Ends::Closed => whole(loops, &found),
    }
}

/// A point of a contour, with the body part that the model expects there.
fn attributed(point: &SnakePoint, curve: &[OutlinePoint]) -> FoundPoint {
    let (nearest, is_sure) = nearest(curve, &point.expected);
    FoundPoint {
        pixel: point.pixel,
        expected: point.expected,
        reliability: if is_sure { point.reliability } else { 0.0 },
        part: nearest.part,
    }
}

/// The loops of a closed contour, if enough of it is left.
fn whole(
    loops: Vec<Vec<FoundPoint>>,
    contour: &[FoundPoint],
) -> Result<Vec<Vec<FoundPoint>>, Option<ContourFault>> {
    let area = |points: &[FoundPoint], place: fn(&FoundPoint) -> Point2<f64>| {
        area_on_the_left(&points.iter().map(place).collect::<Vec<_>>())
    };
    let found: f64 = loops.iter().map(|l| area(l, |p| p.pixel)).sum();
    let share = found / area(contour, |p| p.expected);
    if share.is_nan() || share < COLLAPSED {
        return Err(Some(ContourFault::Collapsed));
    }
    let kept: usize = loops.iter().map(Vec::len).sum();
    if loops.len() > 1 || (kept as f64) < UNCROSSED * contour.len() as f64 {
        return Err(Some(ContourFault::SelfCrossing));
    }
    Ok(loops)
}

/// The outline's point nearest to where a contour was expected, and whether one surface continues there: where it ends
/// behind another, the border is a corner of both.
fn nearest<'c>(curve: &'c [OutlinePoint], expected: &Point2<f64>) -> (&'c OutlinePoint, bool) {
    let off = |p: &OutlinePoint| (p.pixel - expected).norm_squared();
    let indices = 0..curve.len();
    let best = indices.min_by(|a, b| off(&curve[*a]).total_cmp(&off(&curve[*b])));
    let best = best.unwrap_or_default();
    let n = curve.len();
    let depths = [curve[(best + n - 1) % n].depth_m, curve[(best + 1) % n].depth_m];
    (&curve[best], (depths[0] - depths[1]).abs() < JUMP_M)
}

#[cfg(test)]
mod tests;
