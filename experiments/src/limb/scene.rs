//! The true arm, its cameras, and what they see.

use maquette::body::metaball::Field;
use maquette::body::{BodyModel, Motion, Posed, Root, Shape};
use maquette::camera::{Camera, Rig};
use maquette::io::model::{self, ModelFileError};
use maquette::likelihood::{RayView, SurfacePoint};
use maquette::math::Rigid3;
use maquette::render;
use maquette::silhouette::{SilhouetteOptions, extract};
use maquette::synth::{Ring, SegmentationErrors, StereoPair};
use nalgebra::{DVector, Point3, Rotation3, Vector3};
use rand::{Rng, RngExt};
use std::path::Path;

/// Where the arms hang, metres.
const MIDDLE: [f64; 3] = [0.0, 0.0, 1.2];
/// Distance of the cameras, metres.
const DISTANCE: f64 = 2.5;
/// Spacing of the lines of sight along a silhouette, metres.
const SPACING: f64 = 0.02;

/// An arm in one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmTruth {
    /// The arm.
    pub model: BodyModel,
    /// Its motion.
    pub motion: Motion,
    /// No coefficients.
    pub shape: Shape,
}

impl ArmTruth {
    /// The arm as it is.
    pub fn posed(&self) -> Posed<'_> {
        Posed::new(&self.model, &self.shape, &self.motion)
    }
}

/// The arm of the truth.
///
/// # Errors
/// [`ModelFileError`]; the text in the program has none.
pub fn true_arm() -> Result<BodyModel, ModelFileError> {
    model::parse(include_str!("true-arm.toml"), Path::new("true-arm.toml"))
}

/// The shipped `arm`, three metaballs a limb, free to move.
///
/// # Errors
/// As [`true_arm`].
pub fn limb_arm() -> Result<BodyModel, ModelFileError> {
    model::load("arm", Path::new("")).map(free)
}

/// The shipped `arm-ellipsoids`, one ellipsoid a limb, free to move.
///
/// # Errors
/// As [`true_arm`].
pub fn ellipsoid_arm() -> Result<BodyModel, ModelFileError> {
    model::load("arm-ellipsoids", Path::new("")).map(free)
}

/// A model whose shoulder is not held: where it is and how it is turned is found, too.
fn free(mut model: BodyModel) -> BodyModel {
    model.root = Root::Free { speed: 1.0, turn: 200.0_f64.to_radians() };
    model
}

/// The arm in a pose that is drawn: up to 40° from hanging, bent by 20 to 100°.
pub fn pose(model: &BodyModel, rng: &mut impl Rng) -> ArmTruth {
    let mut draw = |reach: f64| rng.random_range(-reach..=reach);
    let turn = Rotation3::from_scaled_axis(Vector3::new(draw(0.7), draw(0.7), draw(1.5)));
    let offset = Vector3::new(draw(0.05), draw(0.05), draw(0.05));
    let mut motion = Motion::rest(model);
    motion.angles[0] = rng.random_range(0.35..1.75);
    motion.world_from_root = turn;
    motion.position_world = Vector3::from(MIDDLE) + Vector3::z() * 0.2 + offset;
    ArmTruth { model: model.clone(), motion, shape: Shape(DVector::zeros(0)) }
}

fn ring(cameras: usize) -> Ring {
    Ring {
        cameras,
        radius: DISTANCE,
        height: MIDDLE[2] + 0.2,
        target_world: Point3::from(Vector3::from(MIDDLE)),
        focal_px: 900.0,
        irregularity: 0.0,
        ..Ring::default()
    }
}

/// A camera 2.5 m in front of the arm and its twin, `baseline` metres to the right.
pub fn front_pair(baseline: f64) -> Rig {
    let mut cameras = ring(4).regular().cameras;
    cameras.truncate(1);
    cameras.extend(cameras.first().map(|camera| twin(camera, baseline)));
    Rig { cameras }
}

fn twin(camera: &Camera, baseline: f64) -> Camera {
    let aside = Rigid3::translation(-baseline, 0.0, 0.0);
    Camera {
        name: format!("{}_right", camera.name),
        camera_from_world: aside * camera.camera_from_world,
        ..camera.clone()
    }
}

/// Three cameras around the arm.
pub fn three_cameras() -> Rig {
    ring(3).regular()
}

/// Points that a camera and its twin see.
pub fn surface_points(
    truth: &ArmTruth,
    camera: &Camera,
    pair: &StereoPair,
    rng: &mut impl Rng,
) -> Vec<SurfacePoint> {
    let cloud = pair.points(camera, &truth.posed(), rng);
    cloud.iter().map(SurfacePoint::from).collect()
}

/// The lines of sight along the arm's silhouettes, segmented with mild errors.
pub fn views(truth: &ArmTruth, rig: &Rig, rng: &mut impl Rng) -> Vec<RayView> {
    let field = Field::from_body(&truth.posed());
    let errors =
        SegmentationErrors { bites: 0.0, holes: 0.0, specks: 0.0, ..SegmentationErrors::MILD };
    let each = rig.cameras.iter().filter_map(|camera| {
        let mask = errors.apply(&render::silhouette(camera, &field), rng);
        let silhouette = extract(&mask, camera, &SilhouetteOptions::default()).ok()?;
        Some(RayView::new(camera, &silhouette, DISTANCE, SPACING))
    });
    each.collect()
}
