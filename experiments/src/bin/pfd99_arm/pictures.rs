//! The fitted arms over the photographs, and how far they are off in the course of time.

use experiments::contours::{compared_with, sheet};
use experiments::limb::LimbErrors;
use experiments::picture::{Panel, colour, svg};
use kuva::plot::LegendPosition;
use maquette::body::Posed;
use maquette::camera::CameraId;
use maquette::image::Picture;
use maquette::render::{OutlinePoint, outline};
use maquette::silhouette::FrameIndex;
use nalgebra::Point2;

use crate::{ARMS, Compared, FRAMES, Fault};

/// The camera in the middle.
const CENTRE: CameraId = CameraId(1);
/// Frames that are drawn.
const SHOWN: [usize; 4] = [5, 18, 31, 44];
/// Distance of the outline's points, px.
const SPACING_PX: f64 = 1.5;
/// What is cut off the pictures on each side, as a part of their size: left, top; and what is shown of it.
const WINDOW: [f64; 4] = [0.2, 0.1, 0.6, 0.65];

/// Joints and elbow, frame by frame.
pub(crate) fn errors(of: &Compared) -> String {
    let panel = |title: &str, unit: &str, most: f64, value: &dyn Fn(&LimbErrors) -> f64| {
        let empty = Panel::new(title, "frame", unit)
            .ranges((0.0, FRAMES as f64), (0.0, most))
            .legend(LegendPosition::InsideTopRight);
        let arms = ARMS.iter().zip(&of.errors).zip([colour::BLUE, colour::ORANGE]);
        arms.fold(empty, |panel, (((name, _), errors), colour)| {
            let points = errors.iter().enumerate().map(|(i, e)| (i as f64, value(e)));
            panel.curve(name, colour, &points.collect::<Vec<(f64, f64)>>())
        })
    };
    let panels = vec![
        panel("shoulder, elbow and wrist", "mean error, mm", 60.0, &|e| e.joints_mm),
        panel("bend of the elbow", "error, °", 20.0, &|e| e.elbow_deg.abs()),
    ];
    svg(1, (640.0, 250.0), panels)
}

/// Photographs with the outline of the fitted body's surface (red) and the true one (light blue).
pub(crate) fn arms(of: &Compared) -> Result<Picture, Fault> {
    let studio = of.film.studio(CENTRE).ok_or("no such camera")?;
    let camera = &of.film.synthetic.rig.cameras[CENTRE.0];
    let shown = |frame: usize| -> Result<Picture, Fault> {
        let shot = studio.shot(FrameIndex(frame)).ok_or("no such frame")?;
        let body = Posed::new(&of.fit.model, &of.shape, &of.motions[frame]);
        let outline = outline(camera, &body, SPACING_PX).outer.into_iter();
        let curve = |points: Vec<OutlinePoint>| points.into_iter().map(|p| p.pixel).collect();
        let fitted: Vec<Vec<Point2<f64>>> = outline.map(curve).collect();
        Ok(compared_with(&shot.picture, &fitted, &shot.mask))
    };
    let row = SHOWN.into_iter().map(shown).collect::<Result<Vec<_>, _>>()?;
    let size = [camera.width_px, camera.height_px, camera.width_px, camera.height_px];
    let window = std::array::from_fn(|k| (WINDOW[k] * f64::from(size[k])) as usize);
    Ok(sheet(&[row], window))
}
