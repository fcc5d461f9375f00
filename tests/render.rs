//! Rendered masks against dense marching along the rays.

use std::path::Path;

use maquette::body::metaball::{Field, THRESHOLD};
use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::camera::{Camera, Distortion};
use maquette::image::Mask;
use maquette::io::model;
use maquette::render::silhouette;
use maquette::synth::Ring;
use nalgebra::{Point2, Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn walker() -> BodyModel {
    model::load("walker-metaballs", Path::new("")).expect("shipped models are right")
}

fn standing_field() -> Field {
    let model = walker();
    let mut motion = Motion::rest(&model);
    motion.position_world = Vector3::new(0.0, 0.0, 0.985);
    Field::from_body(&Posed::new(&model, &Shape(model.statistics.mean.clone()), &motion))
}

fn camera(distortion: Distortion) -> Camera {
    let ring = Ring {
        cameras: 1,
        width_px: 320,
        height_px: 240,
        focal_px: 350.0,
        distortion,
        ..Ring::default()
    };
    ring.irregular(&mut ChaCha8Rng::seed_from_u64(4)).cameras.remove(0)
}

/// The greatest F on the ray of a pixel, in steps of 2 mm.
fn marched_maximum(field: &Field, camera: &Camera, x: usize, y: usize) -> f64 {
    let pixel = camera.undistort(&Point2::new(x as f64, y as f64));
    let ray = camera.ray(&pixel.expect("the lens model holds in the image"));
    let value = |i: u32| field.value(&ray.point_at(3.8 + 2e-3 * f64::from(i)).coords);
    (0..800).map(value).fold(0.0, f64::max)
}

fn border(mask: &Mask) -> Vec<(usize, usize)> {
    let at = |x: usize, y: usize| mask.is_foreground(x, y);
    let all = (1..mask.height() - 1).flat_map(|y| (1..mask.width() - 1).map(move |x| (x, y)));
    all.filter(|&(x, y)| at(x - 1, y) != at(x + 1, y) || at(x, y - 1) != at(x, y + 1)).collect()
}

#[test]
fn the_mask_is_where_dense_marching_meets_the_skin() {
    let lens = Distortion::brown_conrady(&[-0.25, 0.1, 0.001, -0.002]).expect("four coefficients");
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for distortion in [Distortion::None, lens] {
        let (field, camera) = (standing_field(), camera(distortion));
        let mask = silhouette(&camera, &field);
        let border = border(&mask);
        assert!(border.len() > 500);
        for _ in 0..150 {
            let (x, y) = border[rng.random_range(0..border.len())];
            let marched = marched_maximum(&field, &camera, x, y);
            // within 0.001 of the threshold, rays miss or meet the skin by less than 0.1 mm
            if (marched - THRESHOLD).abs() > 1e-3 {
                assert_eq!(mask.is_foreground(x, y), marched > THRESHOLD, "{x} {y} {marched}");
            }
        }
    }
}

#[test]
fn a_distorted_mask_shows_every_point_where_the_camera_projects_it() {
    let lens = Distortion::brown_conrady(&[-0.25, 0.1, 0.001, -0.002]).expect("four coefficients");
    let (field, camera) = (standing_field(), camera(lens));
    let mask = silhouette(&camera, &field);
    for metaball in field.metaballs.iter().filter(|m| field.value(&m.ellipsoid.centre) > 0.8) {
        let centre = Point3::from(metaball.ellipsoid.centre);
        let pixel = camera.project(&centre).expect("in front of the camera");
        assert!(mask.is_foreground(pixel.x.round() as usize, pixel.y.round() as usize));
    }
}

#[test]
fn a_body_behind_the_camera_is_not_seen_and_one_around_it_fills_the_image() {
    let mut camera = camera(Distortion::None);
    let field = standing_field();
    let seen = |camera: &Camera| {
        let mask = silhouette(camera, &field);
        (0..240).map(|y| mask.row(y).iter().filter(|&&v| v == 1).count()).sum::<usize>()
    };
    assert!(seen(&camera) > 1000);
    camera.camera_from_world.translation.z -= 10.0;
    assert_eq!(seen(&camera), 0);
    let chest = camera.camera_from_world.rotation * Vector3::new(0.0, 0.0, 1.3);
    camera.camera_from_world.translation.vector = -chest;
    assert_eq!(seen(&camera), 320 * 240);
}
