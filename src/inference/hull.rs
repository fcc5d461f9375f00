//! Where the body of one frame is: from the visual hull, coarse voxels that every silhouette accepts, from points on its surface, or from
//! detections of its joints.

use nalgebra::{Matrix3, Point3, UnitVector3, Vector3};

use super::joints::{self, Joints};
use crate::camera::{Ray, Rig, closest_point};
use crate::math::stats::median;
use crate::silhouette::FrameObservations;
use crate::stereo::CloudPoint;

/// Where the body is, from carved voxels or from points.
#[derive(Debug, Clone, PartialEq)]
pub struct Hull {
    /// Mean of the occupied voxels, or of the points, metres.
    pub centroid_world: Point3<f64>,
    /// Height below which 0.5 % of them lie, metres.
    pub bottom: f64,
    /// Height below which 99.8 % of them lie.
    pub top: f64,
    /// How many voxels are occupied; 0 where the hull is of points.
    pub voxels: usize,
    /// The direction in which they extend farthest: their first principal axis.
    pub axis_world: UnitVector3<f64>,
    /// How far that is, but for 0.5 % at either end, metres.
    pub length: f64,
}

/// Half the edge of the cube that is carved, and the edge of a voxel, metres.
const REACH: f64 = 1.4;
const VOXEL: f64 = 0.04;
/// Half the depth of a person in a stride, metres.
const HALF_DEPTH_M: f64 = 0.4;
/// A hull is low if it is so many times as long as high. Of who stands with arms held aside it is not: the span of the arms is .95 to 1.11 of the
/// stature (99 % of ANSUR II).
const LOW: f64 = 1.2;

/// From so many cameras on, one may miss a place: a bitten mask must not cut a leg off.
pub const FORGIVING: usize = 5;

/// Fewer points do not tell where a body is.
pub const LEAST_POINTS: usize = 200;

/// Whether a frame tells where the body is: two cameras see it or its joints, or there are points enough.
pub fn locates_body(frame: &FrameObservations) -> bool {
    frame.views.len() >= 2
        || frame.points.len() >= LEAST_POINTS
        || joints::may_locate(&frame.detections)
}

/// If no two lines of sight meet at more than this angle, degrees, their hull has no depth.
const LEAST_ANGLE_DEG: f64 = 25.0;

/// The hull of a frame, from its silhouettes or else from its points; `None` where neither shows the body.
///
/// Where all cameras stand side by side the points come first: the hull of the silhouettes is open in depth.
pub fn hull(rig: &Rig, frame: &FrameObservations) -> Option<Hull> {
    let from_points = || Hull::from_points(&frame.points);
    if has_depth(&lines_of_sight(rig, frame)) {
        carve(rig, frame).or_else(from_points)
    } else {
        from_points().or_else(|| carve(rig, frame))
    }
}

/// Whether any two lines of sight meet at a wide angle.
pub fn has_depth(sights: &[Ray]) -> bool {
    let angle = |a: &Ray, b: &Ray| a.direction_world.angle(&b.direction_world).to_degrees();
    let mut pairs = sights.iter().enumerate();
    pairs.any(|(i, a)| sights[..i].iter().any(|b| angle(a, b) > LEAST_ANGLE_DEG))
}

/// The lines of sight to the silhouettes' centroids.
pub fn lines_of_sight(rig: &Rig, frame: &FrameObservations) -> Vec<Ray> {
    let views = frame.views.iter();
    views.map(|(camera, s)| rig.cameras[camera.0].ray(&s.centroid)).collect()
}

impl Hull {
    /// The extent of the points that lie within reach of their median, without strays; `None` with fewer than
    /// [`LEAST_POINTS`].
    pub fn from_points(points: &[CloudPoint]) -> Option<Self> {
        if points.len() < LEAST_POINTS {
            return None;
        }

        // the points about their median
        let along =
            |axis: usize| median(&mut points.iter().map(|p| p.position_world[axis]).collect());
        let middle = Point3::new(along(0)?, along(1)?, along(2)?);
        let places = points.iter().map(|p| p.position_world);
        let near: Vec<Vector3<f64>> =
            places.filter(|p| (p - middle).norm() <= REACH).map(|p| p.coords).collect();
        Self::of_places(&near, 0.005).map(|hull| Self { voxels: 0, ..hull })
    }

    /// The extent of places, whose heights go up to all but a share of them; `None` of none.
    fn of_places(places: &[Vector3<f64>], above: f64) -> Option<Self> {
        let centroid = places.iter().sum::<Vector3<f64>>() / places.len() as f64;
        let spread: Matrix3<f64> =
            places.iter().map(|place| place - centroid).map(|off| off * off.transpose()).sum();
        let principal = spread.symmetric_eigen();
        let axis = principal.eigenvectors.column(principal.eigenvalues.imax()).into_owned();

        let heights = sorted(places.iter().map(|place| place.z));
        let along = sorted(places.iter().map(|place| place.dot(&axis)));
        let quantile = |of: &[f64], q: f64| of.get(((of.len() as f64 - 1.0) * q) as usize).copied();
        Some(Self {
            centroid_world: centroid.into(),
            bottom: quantile(&heights, 0.005)?,
            top: quantile(&heights, 1.0 - above)?,
            voxels: places.len(),
            axis_world: UnitVector3::new_normalize(axis),
            length: quantile(&along, 0.995)? - quantile(&along, 0.005)?,
        })
    }

    /// Whether it extends along another direction than upwards, as of a body that lies or goes on all fours.
    pub fn is_low(&self) -> bool {
        self.length > LOW * (self.top - self.bottom)
    }
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

/// The point nearest to the rays through the silhouettes' centroids, or the middle of the joints: where to look for the body.
pub fn subject(rig: &Rig, frame: &FrameObservations) -> Option<Point3<f64>> {
    let of_joints = || Joints::new(rig, &frame.detections).map(|joints| joints.middle());
    closest_point(&lines_of_sight(rig, frame)).or_else(of_joints)
}

/// Carves the hull around the subject; `None` where no voxel survives.
///
/// A voxel is kept if [nearly all](nearly_all) silhouettes whose cameras look there hold it. The hull of cameras that stand side by side is open in depth;
/// there the parallax of the silhouettes' centroids says how far away the body is, and only what is near that place is kept.
pub fn carve(rig: &Rig, frame: &FrameObservations) -> Option<Hull> {
    let sights = lines_of_sight(rig, frame);
    let subject = closest_point(&sights)?;
    let open: Vector3<f64> = sights.iter().map(|sight| sight.direction_world.into_inner()).sum();
    let open = (!has_depth(&sights)).then(|| open.try_normalize(f64::MIN_POSITIVE)).flatten();
    let is_near =
        |offset: &Vector3<f64>| open.is_none_or(|open| offset.dot(&open).abs() < HALF_DEPTH_M);

    // voxel by voxel of the cube around the subject
    let n = (2.0 * REACH / VOXEL) as i32;
    let corner = subject - Vector3::repeat(REACH);
    let mut places = Vec::new();
    for (i, j, k) in (0..n * n * n).map(|v| (v / (n * n), v / n % n, v % n)) {
        let voxel = corner + Vector3::new(f64::from(i), f64::from(j), f64::from(k)) * VOXEL;
        if is_near(&(voxel - subject)) && occupied(rig, frame, &voxel) {
            places.push(voxel.coords);
        }
    }

    let hull = Hull::of_places(&places, 0.002)?;
    let half = 0.5 * VOXEL;
    Some(Hull {
        bottom: hull.bottom - half,
        top: hull.top + half,
        length: hull.length + VOXEL,
        ..hull
    })
}

fn occupied(rig: &Rig, frame: &FrameObservations, voxel: &Point3<f64>) -> bool {
    nearly_all(frame.views.iter().filter_map(|(camera, silhouette)| {
        let pixel = rig.cameras[camera.0].project_undistorted(voxel);
        let pixel = pixel.filter(|pixel| silhouette.sees(pixel))?;
        Some(silhouette.contains(&pixel))
    }))
}

/// Whether nearly all cameras that look at a place see something there: two or more, and all but one of [`FORGIVING`] or more.
pub fn nearly_all(seeing: impl Iterator<Item = bool>) -> bool {
    let (mut looking, mut missing) = (0, 0);
    for sees in seeing {
        looking += 1;
        missing += usize::from(!sees);
        if missing > 1 {
            return false;
        }
    }
    looking >= 2 && (missing == 0 || looking >= FORGIVING)
}
