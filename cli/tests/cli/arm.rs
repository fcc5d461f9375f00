//! A small recording of the arm of ZS06, Fig. 3, and the program run on it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use image::{GrayImage, Luma};
use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::camera::{Camera, Rig};
use maquette::io::{calibration, model};
use maquette::math::quadric::project;
use maquette::synth::Ring;
use nalgebra::{DVector, Point3, Vector2};
use serde_json::Value;
use tempfile::TempDir;

pub(crate) const FRAMES: usize = 6;
pub(crate) const SIZE: (u32, u32) = (160, 120);

/// The true shape coefficient: the share of the upper part is 1/(1 + e⁻ˢ).
pub(crate) const SHAPE: f64 = 0.1;

pub(crate) fn model() -> BodyModel {
    model::load("arm-2d", Path::new("")).expect("a shipped model")
}

pub(crate) fn rig() -> Rig {
    let ring = Ring {
        cameras: 3,
        radius: 4.0,
        height: 0.8,
        target_world: Point3::new(0.9, 0.0, 0.2),
        focal_px: 150.0,
        width_px: SIZE.0,
        height_px: SIZE.1,
        ..Ring::default()
    };
    ring.regular()
}

fn motion(frame: usize) -> Motion {
    let mut motion = Motion::rest(&model());
    motion.angles[0] = 0.2 + 0.1 * frame as f64;
    motion
}

/// The joint centres of a frame, in the order of the model's points.
pub(crate) fn points(frame: usize) -> Vec<Point3<f64>> {
    let (model, shape) = (model(), Shape(DVector::from_vec(vec![SHAPE])));
    Posed::new(&model, &shape, &motion(frame)).points()
}

pub(crate) fn mask(camera: &Camera, frame: usize) -> GrayImage {
    let (model, shape) = (model(), Shape(DVector::from_vec(vec![SHAPE])));
    let ellipses: Vec<_> = Posed::new(&model, &shape, &motion(frame))
        .ellipsoids()
        .iter()
        .filter_map(|e| project(&camera.projection(), e))
        .map(|e| (e.centre, e.shape.cholesky().expect("an ellipse").inverse()))
        .collect();
    GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let pixel = Vector2::new(f64::from(x), f64::from(y));
        let inside = ellipses.iter().any(|(centre, inverse)| {
            let to = pixel - centre;
            to.dot(&(inverse * to)) <= 1.0
        });
        Luma([if inside { 255 } else { 0 }])
    })
}

/// A folder with `recording/` in it, and a place for results.
pub(crate) struct Arm {
    folder: TempDir,
}

impl Arm {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let arm = Self { folder };
        fs::create_dir_all(arm.recording()).expect("a folder");
        arm.write("calibration.toml", &calibration::write_toml(&rig()));
        for camera in &rig().cameras {
            for frame in 0..FRAMES {
                arm.write_mask(&camera.name, frame, &mask(camera, frame));
            }
        }
        arm
    }

    pub(crate) fn recording(&self) -> PathBuf {
        self.folder.path().join("recording")
    }

    pub(crate) fn out(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn mask_path(&self, camera: &str, frame: usize) -> PathBuf {
        let name = format!("masks/{camera}/{frame:06}.png");
        self.recording().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.recording().join(name), text).expect("written");
    }

    pub(crate) fn write_mask(&self, camera: &str, frame: usize, mask: &GrayImage) {
        let path = self.mask_path(camera, frame);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        mask.save(path).expect("a mask");
    }

    /// `maquette fit` on the recording with every second frame a keyframe, and more arguments.
    pub(crate) fn fit(&self, out: &str, more: &[&str]) -> Ran {
        let mut arguments = self.fit_arguments(out);
        arguments.extend(more.iter().map(ToString::to_string));
        run(&arguments)
    }

    pub(crate) fn fit_with_body(&self, out: &str, body: &str, more: &[&str]) -> Ran {
        let mut arguments = self.fit_arguments(out);
        let place = arguments.iter().position(|a| a == "arm-2d").expect("a body");
        arguments[place] = body.into();
        arguments.extend(more.iter().map(ToString::to_string));
        run(&arguments)
    }

    pub(crate) fn fit_arguments(&self, out: &str) -> Vec<String> {
        let (recording, out) = (self.recording(), self.out(out));
        let (recording, out) = (recording.display().to_string(), out.display().to_string());
        ["fit", &recording, "--out", &out, "--fps", "10"]
            .into_iter()
            .chain(["--body", "arm-2d", "--keyframe-every", "2"])
            .map(Into::into)
            .collect()
    }

    pub(crate) fn bytes(&self, out: &str, name: &str) -> Vec<u8> {
        let path = self.out(out).join(name);
        fs::read(&path).unwrap_or_else(|fault| panic!("{}: {fault}", path.display()))
    }

    pub(crate) fn result(&self, out: &str) -> Value {
        serde_json::from_slice(&self.bytes(out, "result.json")).expect("JSON")
    }
}

/// What the program said.
#[derive(Debug)]
pub(crate) struct Ran {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Ran {
    pub(crate) fn succeeded(self) -> Self {
        assert_eq!(self.code, Some(0), "{self:?}");
        self
    }

    /// One line on standard error with these parts, nothing on standard output, exit code 2.
    pub(crate) fn refused(self, parts: &[&str]) {
        assert_eq!(self.code, Some(2), "{parts:?} {self:?}");
        assert_eq!(self.out, "", "{parts:?}");
        assert_eq!(self.err.lines().count(), 1, "{self:?}");
        assert!(self.err.starts_with("error: "), "{self:?}");
        for part in parts {
            assert!(self.err.contains(part), "{part:?} not in {}", self.err);
        }
    }
}

pub(crate) fn program() -> &'static str {
    env!("CARGO_BIN_EXE_maquette")
}

pub(crate) fn run<S: AsRef<str>>(arguments: &[S]) -> Ran {
    let arguments = arguments.iter().map(AsRef::as_ref);
    ran(&Command::new(program()).args(arguments).output().expect("the program starts"))
}

pub(crate) fn ran(output: &Output) -> Ran {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("UTF-8");
    Ran { code: output.status.code(), out: text(&output.stdout), err: text(&output.stderr) }
}
