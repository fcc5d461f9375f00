//! The mask of a mesh.

use nalgebra::{Point2, Vector3};

use super::Raster;
use crate::camera::Camera;
use crate::image::Mask;

/// Samples across a pixel, and down it.
const SAMPLES: usize = 3;

/// The pixels of a camera's picture, distorted as it is, whose middle a mesh covers.
pub fn covered(camera: &Camera, vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Mask {
    let mut raster = Raster::new(camera, SAMPLES);
    raster.draw(vertices, triangles, 0);

    // fragments are those of an undistorted picture
    let fragments = raster.fragments();
    let sample = |px: f64| ((px + 0.5) * SAMPLES as f64 - 0.5).round();
    let is_covered = |x: usize, y: usize| {
        let Some(at) = camera.undistort(&Point2::new(x as f64, y as f64)) else { return false };
        let at = at.map(sample);
        let is_within = at.x >= 0.0
            && at.y >= 0.0
            && at.x < fragments.width() as f64
            && at.y < fragments.height() as f64;
        is_within && fragments.row(at.y as usize)[at.x as usize].depth.is_finite()
    };
    Mask::from_fn(camera.width_px as usize, camera.height_px as usize, is_covered)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::body::metaball::Field;
    use crate::body::{Motion, Posed, Shape};
    use crate::camera::Distortion;
    use crate::skin::{SkinOptions, skin};
    use crate::synth::Ring;

    #[test]
    fn a_skin_covers_what_its_metaballs_cover_also_before_a_camera_that_distorts() {
        let model = crate::io::model::load("walker-metaballs", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let mut motion = Motion::rest(&model);
        motion.position_world.z = 1.0;
        let body = Posed::new(&model, &shape, &motion);
        let mesh = skin(&body, &SkinOptions::with_around(48)).unwrap();
        for coefficients in [[0.0; 4], [-0.2, 0.1, 0.002, -0.002]] {
            let distortion = Distortion::brown_conrady(&coefficients).unwrap();
            let rig = Ring { cameras: 2, distortion, ..Ring::default() }.regular();
            for camera in &rig.cameras {
                let of_mesh = covered(camera, &mesh.vertices, &mesh.triangles);
                let of_field = crate::render::silhouette(camera, &Field::from_body(&body));
                let (mut both, mut either) = (0, 0);
                for y in 0..of_mesh.height() {
                    for x in 0..of_mesh.width() {
                        let (a, b) = (of_mesh.is_foreground(x, y), of_field.is_foreground(x, y));
                        both += usize::from(a && b);
                        either += usize::from(a || b);
                    }
                }
                assert!(both as f64 > 0.97 * either as f64, "{both} of {either}");
            }
        }
    }
}
