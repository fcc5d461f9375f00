//! How much of a silhouette the body covers.

use nalgebra::{Point2, Vector2};

use crate::body::metaball::Field;
use crate::body::{PartId, Posed, Primitive};
use crate::camera::{Camera, Distortion, Intrinsics};
use crate::likelihood::Measure;
use crate::math::quadric::{Ellipse, project};
use crate::render;
use crate::silhouette::{Overlap, OverlapGrid, Silhouette};

/// Primitives of the model as ellipses in a camera, in undistorted pixels; those around or behind it are left out.
pub(super) fn projected<'p>(
    camera: &Camera,
    body: &Posed<'_>,
    primitives: impl IntoIterator<Item = &'p Primitive>,
) -> Vec<Ellipse> {
    let projection = camera.projection();
    let each = primitives.into_iter().map(|p| body.primitive(p));
    each.filter_map(|e| project(&projection, &e)).collect()
}

/// What lies farther outside a silhouette is astray, metres: the half width of a forearm, so that bones lie outside.
const ASTRAY_M: f64 = 0.04;

/// Overlap of a silhouette and the body as it was measured: the skin of its metaballs, or the union of its ellipses.
pub(super) fn overlap(
    camera: &Camera,
    silhouette: &Silhouette,
    body: &Posed<'_>,
    measure: Measure,
) -> Overlap {
    let depth_m = (camera.camera_from_world * body.origin_of_part(PartId(0))).z;
    let far_px = ASTRAY_M * camera.intrinsics.focal_px() / depth_m.max(f64::MIN_POSITIVE);
    if measure.has_metaballs() && !body.model.metaballs.is_empty() {
        skin_overlap(camera, silhouette, body, far_px)
    } else {
        ellipses_overlap(camera, silhouette, body, far_px)
    }
}

/// The body's ellipsoids as a camera sees them, without those around or behind it.
pub(super) fn coverings(camera: &Camera, body: &Posed<'_>) -> Vec<Covering> {
    projected(camera, body, &body.model.ellipsoids).iter().map(Covering::new).collect()
}

fn ellipses_overlap(
    camera: &Camera,
    silhouette: &Silhouette,
    body: &Posed<'_>,
    far_px: f64,
) -> Overlap {
    let ellipses = coverings(camera, body);
    let grid = silhouette.overlap_grid(bounds(silhouette, &ellipses));
    let is_model = |_, _, pixel: &Point2<f64>| ellipses.iter().any(|e| e.contains(pixel));
    silhouette.overlap(&grid, far_px, is_model)
}

/// The skin is rendered by a camera without distortion, of which each pixel is a cell of the grid.
fn skin_overlap(
    camera: &Camera,
    silhouette: &Silhouette,
    body: &Posed<'_>,
    far_px: f64,
) -> Overlap {
    let balls: Vec<Covering> =
        projected(camera, body, &body.model.metaballs).iter().map(Covering::new).collect();
    let grid = silhouette.overlap_grid(bounds(silhouette, &balls));
    let mask = render::silhouette(&window(camera, &grid), &Field::from_body(body));
    let is_model = |column, row, _: &Point2<f64>| mask.is_foreground(column, row);
    silhouette.overlap(&grid, far_px, is_model)
}

/// The camera that sees the cells of a grid, one pixel for each.
fn window(camera: &Camera, grid: &OverlapGrid) -> Camera {
    let OverlapGrid { low, step, columns, rows } = *grid;
    let k = &camera.intrinsics;
    Camera {
        width_px: columns as u32,
        height_px: rows as u32,
        // the centre of pixel 0 lies half a step inside the grid
        intrinsics: Intrinsics {
            fx_px: k.fx_px / step,
            fy_px: k.fy_px / step,
            cx_px: (k.cx_px - low.x) / step - 0.5,
            cy_px: (k.cy_px - low.y) / step - 0.5,
            skew_px: k.skew_px / step,
        },
        distortion: Distortion::None,
        ..camera.clone()
    }
}

fn bounds(silhouette: &Silhouette, ellipses: &[Covering]) -> (Point2<f64>, Point2<f64>) {
    let nothing = (silhouette.bounds.0, silhouette.bounds.0);
    let boxes = ellipses.iter().map(|e| (e.low, e.high));
    boxes.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1))).unwrap_or(nothing)
}

/// An ellipse, its box, and Σ⁻¹.
#[derive(Debug)]
pub(super) struct Covering {
    low: Point2<f64>,
    high: Point2<f64>,
    centre: Vector2<f64>,
    inverse: [f64; 3],
}

impl Covering {
    pub(super) fn new(ellipse: &Ellipse) -> Self {
        let s = &ellipse.shape;
        let determinant = s[(0, 0)] * s[(1, 1)] - s[(0, 1)] * s[(0, 1)];
        let half = Vector2::new(s[(0, 0)].sqrt(), s[(1, 1)].sqrt());
        Self {
            low: Point2::from(ellipse.centre - half),
            high: Point2::from(ellipse.centre + half),
            centre: ellipse.centre,
            inverse: [s[(1, 1)], -s[(0, 1)], s[(0, 0)]].map(|v| v / determinant),
        }
    }

    pub(super) fn contains(&self, pixel: &Point2<f64>) -> bool {
        let y = pixel.coords - self.centre;
        let [xx, xy, yy] = self.inverse;
        xx * y.x * y.x + 2.0 * xy * y.x * y.y + yy * y.y * y.y <= 1.0
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Vector3;

    use super::*;
    use crate::body::{BodyModel, Motion, Shape};
    use crate::image::Mask;
    use crate::silhouette::{SilhouetteOptions, extract};
    use crate::synth::Ring;

    fn walker() -> BodyModel {
        crate::io::model::load("human-metaballs", Path::new("")).unwrap()
    }

    /// A camera to which a person is 500 px tall, and a body that stands before it.
    fn scene(model: &BodyModel) -> (Camera, Shape, Motion) {
        let ring = Ring { focal_px: 1040.0, width_px: 1280, height_px: 960, ..Ring::default() };
        let camera = ring.regular().cameras.remove(0);
        let mut motion = Motion::rest(model);
        motion.position_world = Vector3::new(0.1, -0.1, 0.95);
        (camera, Shape(model.statistics.mean.clone()), motion)
    }

    fn overlap_of(
        measure: Measure,
        rendered: impl Fn(&Camera, &Posed<'_>) -> Mask,
    ) -> [Overlap; 2] {
        let model = walker();
        let (camera, shape, mut motion) = scene(&model);
        let body = Posed::new(&model, &shape, &motion);
        let mask = rendered(&camera, &body);
        let seen = extract(&mask, &camera, &SilhouetteOptions::default()).unwrap();
        let own = overlap(&camera, &seen, &body, measure);
        // to the side of the line of sight
        let aside = camera.camera_from_world.rotation.inverse() * Vector3::x();
        motion.position_world += aside * 1.2;
        let apart = overlap(&camera, &seen, &Posed::new(&model, &shape, &motion), measure);
        [own, apart]
    }

    #[test]
    fn a_skin_covers_its_own_silhouette_and_none_beside_it() {
        let of_skin =
            |camera: &Camera, body: &Posed<'_>| render::silhouette(camera, &Field::from_body(body));
        let [own, apart] = overlap_of(Measure::Metaballs, of_skin);
        assert!(own.iou() > 0.98 && own.iou() <= 1.0, "{own:?}");
        assert!(apart.iou() < 1e-9, "{apart:?}");
        assert!(own.astray_share() < 1e-9, "{own:?}");
        assert!(apart.astray_share() > 0.9 && apart.astray_share() <= 1.0, "{apart:?}");
    }

    #[test]
    fn ellipses_cover_their_own_silhouette_and_none_beside_it() {
        let of_ellipses = |camera: &Camera, body: &Posed<'_>| {
            let all: Vec<Covering> =
                projected(camera, body, &body.model.ellipsoids).iter().map(Covering::new).collect();
            let (width, height) = (camera.width_px as usize, camera.height_px as usize);
            Mask::from_fn(width, height, |x, y| {
                let pixel = Point2::new(x as f64, y as f64);
                all.iter().any(|e| e.contains(&pixel))
            })
        };
        let [own, apart] = overlap_of(Measure::Ellipses, of_ellipses);
        assert!(own.iou() > 0.98 && own.iou() <= 1.0, "{own:?}");
        assert!(apart.iou() < 1e-9, "{apart:?}");
        assert!(own.astray_share() < 1e-9, "{own:?}");
        assert!(apart.astray_share() > 0.9 && apart.astray_share() <= 1.0, "{apart:?}");
    }
}
