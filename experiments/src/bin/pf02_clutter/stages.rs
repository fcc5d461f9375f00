//! PF02 Fig. 5: each stage from a stereo pair to the filtered gradient.

use experiments::contours::{black_and_white, sheet};
use maquette::camera::CameraId;
use maquette::image::{Gradient, Picture, Plane};
use maquette::pipeline::silhouettes::{
    ContourOptions, Edges, FilteredEdges, UndistortedFrame, disparity_mask,
};
use maquette::render;
use maquette::silhouette::FrameIndex;
use maquette::stereo::neighbour;

use crate::Fault;
use crate::sequence::{CENTRE, Sequence};

/// Strength of an edge that is drawn black: this quantile of those that are there.
const BLACK: f64 = 0.97;

/// The stages of the centre camera in one frame: picture, disparities, gradient; the picture beside it, the mask, what passes.
///
/// The working volume of the mask is that around the true body, which the pipelines have from the frame before.
pub(crate) fn stages(sequence: &Sequence, frame: usize) -> Result<Picture, Fault> {
    let synthetic = &sequence.film.synthetic;
    let rig = &synthetic.rig;
    let shots = rig.iter().map(|(id, _)| {
        let studio = sequence.film.studio(id)?;
        studio.shot(FrameIndex(frame)).map(|shot| shot.picture)
    });
    let pictures: Vec<Option<Picture>> = shots.collect();
    let shown = UndistortedFrame::new(rig, &pictures)?;
    let depth = shown.depth(rig, CameraId(CENTRE), None);
    let (Some(view), Some(depth)) = (&shown.views[CENTRE], depth) else {
        return Err("no stereo".into());
    };
    let body = synthetic.posed(FrameIndex(frame)).ok_or("no such frame")?;
    let options = ContourOptions::default();
    let camera = &rig.cameras[CENTRE];
    let mask = disparity_mask(camera, &depth.points, &body, &options);
    let filtered = FilteredEdges::select(&Edges::find(view, &options), mask, &options);
    let gradient = Gradient::new(&view.colours, options.narrow_px).magnitude();
    let black = quantile(&gradient, BLACK);
    let photograph = |id: Option<CameraId>| {
        let picture = id.and_then(|id| pictures.get(id.0)?.clone());
        picture.ok_or("no picture")
    };
    let rows = [
        vec![
            photograph(Some(CameraId(CENTRE)))?,
            // the nearer the redder, whichever side the other camera stands on
            render::stereo::in_colour(&depth.disparities.map(f32::abs)).pixels().clone(),
            dark_on_white(&gradient, black),
        ],
        vec![
            photograph(neighbour(rig, CameraId(CENTRE)))?,
            black_and_white(&filtered.mask),
            dark_on_white(&filtered.magnitude(), black),
        ],
    ];
    let (width, height) = (camera.width_px as usize, camera.height_px as usize);
    Ok(sheet(&rows, [width / 10, 0, width * 8 / 10, height]))
}

fn dark_on_white(strength: &Plane<f32>, black: f32) -> Picture {
    strength.map(|s| [255 - (255.0 * (s / black).clamp(0.0, 1.0)) as u8; 3])
}

fn quantile(plane: &Plane<f32>, share: f64) -> f32 {
    let mut values: Vec<f32> = plane.values().to_vec();
    values.retain(|v| v.is_finite());
    values.sort_by(f32::total_cmp);
    let place = (share * values.len().saturating_sub(1) as f64) as usize;
    values.get(place).copied().unwrap_or(1.0).max(1e-6)
}
