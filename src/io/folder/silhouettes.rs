//! What `maquette silhouettes` writes: masks, contours as JSON and SVG, overlays, stages, `quality.csv`.

use std::fmt::Write;
use std::io;
use std::path::Path;

use nalgebra::Point2;
use serde::Serialize;

use super::png::{self, Effort};
use super::segmented::{self, QUALITY};
use super::table;
use super::{OutError, OutFolder, file_name, make_folder, write_atomically};
use crate::body::BodyModel;
use crate::camera::{Camera, Rig};
use crate::image::{Mask, Picture};
use crate::pipeline::silhouettes::{FoundPoint, FrameSilhouettes, ViewContours, ViewSighting};
use crate::render::{Canvas, Pen};
use crate::silhouette::FrameIndex;

/// What is written beside masks and contours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct SilhouetteExtras {
    /// `overlays/<camera>/%06d.png`: the contours over the picture.
    pub overlays: bool,
    /// `stages/<camera>/%06d_mask.png` and `_gradient.png`: where edges count, and which passed.
    pub stages: bool,
}

/// One line of `quality.csv`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContourRow {
    /// Number of the frame.
    pub frame: usize,
    /// Name of the camera.
    pub camera: String,
    /// Pixels of the mask.
    pub area_px: usize,
    /// Mean reliability of the contour, 0 to 1.
    pub reliability: f64,
    /// Mean distance of the contour from where it was expected, px.
    pub moved_px: f64,
    /// How far depth backs the contour, 0 to 1; empty where no depth is seen.
    pub backing: Option<f64>,
    /// What was wrong; empty if nothing was.
    pub faults: String,
}

/// What was found in one view.
#[derive(Clone, Copy)]
struct FoundView<'a> {
    frame: FrameIndex,
    camera: &'a Camera,
    picture: &'a Picture,
    seen: &'a ViewSighting,
}

/// The folder of a run.
#[derive(Debug)]
pub struct SilhouetteFolder<'a> {
    out: &'a OutFolder,
    extras: SilhouetteExtras,
    rows: Vec<ContourRow>,
}

impl<'a> SilhouetteFolder<'a> {
    /// Begins a run in a folder, without what an older one left there.
    ///
    /// # Errors
    /// [`OutError`].
    pub fn open(out: &'a OutFolder, extras: SilhouetteExtras) -> Result<Self, OutError> {
        segmented::begin(out)?;
        Ok(Self { out, extras, rows: Vec::new() })
    }

    /// Writes what was found in every view of a frame.
    ///
    /// # Errors
    /// [`OutError`] for the first file that cannot be written.
    pub fn write(
        &mut self,
        found: &FrameSilhouettes<'_>,
        rig: &Rig,
        model: &BodyModel,
    ) -> Result<(), OutError> {
        let views = found.sighting.views.iter().zip(found.pictures);

        for (camera, (seen, picture)) in rig.cameras.iter().zip(views) {
            if let (Some(seen), Some(picture)) = (seen, picture) {
                let view = FoundView { frame: found.frame, camera, picture, seen };
                self.write_view(&view, model)?;
            }
        }
        Ok(())
    }

    fn write_view(&mut self, view: &FoundView<'_>, model: &BodyModel) -> Result<(), OutError> {
        let FoundView { frame, camera, picture, seen } = *view;
        let contours = &seen.contours;
        let mask = contours.mask(camera);
        let path = |kind: &str, ending: &str| {
            let name = format!("{:06}{ending}", frame.0);
            self.out.path().join(kind).join(file_name(&camera.name)).join(name)
        };

        let png = png::encode_mask(&mask, Effort::Quick);
        write(&path("masks", ".png"), png)?;
        let json = serde_json::to_vec(&ContourFile::new(frame, camera, contours, model));
        let json = json.map_err(std::io::Error::other);
        write(&path("contours", ".json"), json)?;
        write(&path("contours", ".svg"), Ok(svg(camera, contours).into_bytes()))?;

        if self.extras.overlays {
            let canvas = overlay(picture, camera, contours);
            let png = png::encode_picture(canvas.pixels(), Effort::Quick);
            write(&path("overlays", ".png"), png)?;
        }

        if self.extras.stages {
            let passed = png::encode_mask(&seen.filtered.mask, Effort::Quick);
            write(&path("stages", "_mask.png"), passed)?;
            let scale = 160.0 / seen.filtered.strong.max(1.0);
            let grey = seen.filtered.magnitude().map(|g| [(scale * g).min(255.0) as u8; 3]);
            let grey = png::encode_picture(&grey, Effort::Quick);
            write(&path("stages", "_gradient.png"), grey)?;
        }

        self.rows.push(row(frame, camera, seen, &mask));
        Ok(())
    }

    /// Writes `quality.csv`: where it stands all is complete.
    ///
    /// # Errors
    /// [`OutError`].
    pub fn finish(self) -> Result<Vec<ContourRow>, OutError> {
        table::finish(self.out, QUALITY, &self.rows)?;
        Ok(self.rows)
    }
}

fn row(frame: FrameIndex, camera: &Camera, seen: &ViewSighting, mask: &Mask) -> ContourRow {
    let contours = &seen.contours;
    let points = || contours.outer.iter().flatten();
    let moved: f64 = points().map(|p| (p.pixel - p.expected).norm()).sum();
    let rounded = |v: f64| (v * 1e3).round() / 1e3;
    let faults: Vec<String> = contours.faults.iter().map(ToString::to_string).collect();
    ContourRow {
        frame: frame.0,
        camera: camera.name.clone(),
        area_px: (0..mask.height()).flat_map(|y| mask.row(y)).filter(|v| **v == 1).count(),
        reliability: rounded(contours.mean_reliability()),
        moved_px: rounded(moved / points().count().max(1) as f64),
        backing: seen.backing.map(rounded),
        faults: faults.join("; "),
    }
}

/// `contours/<camera>/%06d.json`.
#[derive(Serialize)]
struct ContourFile<'a> {
    frame: usize,
    camera: &'a str,
    /// Width and height, px.
    size_px: [u32; 2],
    /// Closed curves, undistorted pixels.
    outer: Vec<CurveFile<'a>>,
    /// Open curves.
    inner: Vec<CurveFile<'a>>,
    faults: Vec<String>,
}

/// One curve: as many places as reliabilities and parts.
#[derive(Serialize)]
struct CurveFile<'a> {
    points_px: Vec<[f64; 2]>,
    reliability: Vec<f64>,
    part: Vec<&'a str>,
}

impl<'a> ContourFile<'a> {
    fn new(
        frame: FrameIndex,
        camera: &'a Camera,
        contours: &ViewContours,
        model: &'a BodyModel,
    ) -> Self {
        let curve = |points: &Vec<FoundPoint>| CurveFile {
            points_px: points.iter().map(|p| [p.pixel.x, p.pixel.y].map(hundredths)).collect(),
            reliability: points.iter().map(|p| hundredths(p.reliability)).collect(),
            part: points.iter().map(|p| model.parts[p.part.0].name.as_str()).collect(),
        };

        Self {
            frame: frame.0,
            camera: &camera.name,
            size_px: [camera.width_px, camera.height_px],
            outer: contours.outer.iter().map(curve).collect(),
            inner: contours.inner.iter().map(curve).collect(),
            faults: contours.faults.iter().map(ToString::to_string).collect(),
        }
    }
}

fn hundredths(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

/// The contours as paths: the outer ones filled, inner ones as lines; undistorted pixels.
fn svg(camera: &Camera, contours: &ViewContours) -> String {
    let path = |points: &Vec<FoundPoint>, end: &str| {
        let mut d = String::new();
        for (i, point) in points.iter().enumerate() {
            let command = if i == 0 { 'M' } else { 'L' };
            // writing to a text cannot fail
            let _ = write!(d, "{command}{:.2} {:.2}", point.pixel.x, point.pixel.y);
        }
        d + end
    };
    let outer: String = contours.outer.iter().map(|c| path(c, "Z")).collect();
    let inner: String = contours.inner.iter().map(|c| path(c, "")).collect();
    format!(
        concat!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-0.5 -0.5 {} {}\">\n",
            "<path fill=\"#ddd\" stroke=\"#000\" fill-rule=\"evenodd\" d=\"{}\"/>\n",
            "<path fill=\"none\" stroke=\"#06c\" d=\"{}\"/>\n</svg>\n"
        ),
        camera.width_px, camera.height_px, outer, inner
    )
}

/// The expected outline blue, the contours yellow where they are sure and red where they are not, inner ones cyan.
fn overlay(picture: &Picture, camera: &Camera, contours: &ViewContours) -> Canvas {
    let mut canvas = Canvas::from_pixels(picture.clone());
    let pen = |color| Pen { color, opacity: 0.9, width_px: 1.2 };
    let recorded = |a: &Point2<f64>, b: &Point2<f64>| [camera.distort(a), camera.distort(b)];

    let (mut expected, mut sure, mut unsure) = (Vec::new(), Vec::new(), Vec::new());
    for curve in &contours.outer {
        for (a, b) in curve.iter().zip(curve.iter().cycle().skip(1)) {
            expected.push(recorded(&a.expected, &b.expected));
            let found = if a.reliability > 0.25 { &mut sure } else { &mut unsure };
            found.push(recorded(&a.pixel, &b.pixel));
        }
    }

    let pairs = contours.inner.iter().flat_map(|curve| curve.windows(2));
    let inner: Vec<_> = pairs.map(|w| recorded(&w[0].pixel, &w[1].pixel)).collect();

    canvas.draw(&expected, pen([70, 70, 255]));
    canvas.draw(&inner, pen([0, 230, 230]));
    canvas.draw(&unsure, pen([255, 40, 0]));
    canvas.draw(&sure, pen([255, 230, 0]));
    canvas
}

/// Writes a file, and the folder that it is in.
fn write(path: &Path, bytes: io::Result<Vec<u8>>) -> Result<(), OutError> {
    let bytes = bytes.map_err(|source| OutError::write(path, source))?;
    if let Some(folder) = path.parent() {
        make_folder(folder)?;
    }
    write_atomically(path, &bytes)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// A folder with these files, opened for a run; those that are left.
    fn left(files: &[&str]) -> Vec<String> {
        let folder = tempfile::tempdir().unwrap();
        for name in files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "older").unwrap();
        }
        let out = OutFolder::open(folder.path()).unwrap();
        SilhouetteFolder::open(&out, SilhouetteExtras::default()).unwrap();
        let is_left = |name: &&&str| folder.path().join(name).exists();
        let left = files.iter().filter(is_left);
        left.map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn what_an_older_run_left_is_removed_and_what_is_not_its_own_stays() {
        let made = [
            "masks/left/000007.png",
            "contours/left/000007.svg",
            "overlays/left/000007.png",
            "stages/left/000007_mask.png",
            "quality.csv",
        ];
        assert_eq!(left(&[&made[..], &["notes.txt"]].concat()), ["notes.txt"]);
        // without the table they may be the user's
        assert_eq!(left(&made[..4]), made[..4]);
        // a fit replaces its own overlays
        let fitted = ["overlays/left/000007.png", "result.json"];
        assert_eq!(left(&[&fitted[..], &["quality.csv"]].concat()), fitted);
    }
}
