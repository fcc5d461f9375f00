//! Cameras whose masks end at one upright line inside the picture: what lies beyond it was cut off, or never segmented.
//!
//! A person who walks or sways touches the outermost column of all their masks with a hand, once. A picture that was cut ends there
//! again and again, and over much of the person's height. Only left and right are looked at: floors make level edges of their own,
//! and a person who is cut off below is told by the height.

use super::cause::{Cause, name};
use crate::camera::{Camera, CameraId, Rig};
use crate::silhouette::{FrameObservations, Silhouette};

/// A border this near to the line lies on it, px of the recorded picture: the borders of a mask are known to half a pixel.
const ON_LINE_PX: f64 = 1.0;
/// A mask is cut if so much of its height lies on the line: more than a hand or a foot.
const CUT_SHARE: f64 = 1.0 / 3.0;
/// A camera's masks end at the line if so many of them are cut, …
const LEAST_FRAMES: usize = 3;
/// … and this share of all that it shows.
const LEAST_SHARE: f64 = 0.1;

/// The cameras whose masks end at an upright line, where they are half of those that show the person, or more.
pub(super) fn cropped(rig: &Rig, frames: &[FrameObservations]) -> Option<Cause> {
    let views = |id: CameraId| -> Vec<&Silhouette> {
        let all = frames.iter().flat_map(|frame| &frame.views);
        all.filter(|(camera, _)| *camera == id).map(|(_, view)| view).collect()
    };
    let shown = rig.iter().map(|(id, camera)| (id, camera, views(id)));
    let shown: Vec<_> = shown.filter(|(.., views)| !views.is_empty()).collect();

    let ends = |camera: &Camera, views: &[&Silhouette]| {
        ends_at_line(views, |x_px| -x_px, camera) || ends_at_line(views, |x_px| x_px, camera)
    };
    let found = shown.iter().filter(|(_, camera, views)| ends(camera, views));
    let cameras: Vec<String> = found.map(|(id, ..)| name(rig, *id)).collect();
    let are_many = !cameras.is_empty() && 2 * cameras.len() >= shown.len();
    are_many.then_some(Cause::Cropped { cameras })
}

/// Whether many silhouettes end at the column of a camera's picture that lies farthest outward of all that they reach.
fn ends_at_line(views: &[&Silhouette], outward: fn(f64) -> f64, camera: &Camera) -> bool {
    let columns = |view: &Silhouette| -> Vec<(f64, f64)> {
        let column = |pixel| outward(camera.distort(pixel).x);
        view.contour.iter().map(|point| (column(&point.pixel), point.length_px)).collect()
    };
    let columns: Vec<Vec<(f64, f64)>> = views.iter().map(|view| columns(view)).collect();
    let line = columns.iter().flatten().map(|(x_px, _)| *x_px).fold(f64::NEG_INFINITY, f64::max);

    let is_cut = |(view, columns): &(&&Silhouette, &Vec<(f64, f64)>)| {
        let on_line = columns.iter().filter(|(x_px, _)| line - x_px < ON_LINE_PX);
        let length_px: f64 = on_line.map(|(_, length_px)| length_px).sum();
        let height_px = view.bounds.1.y - view.bounds.0.y;
        length_px > CUT_SHARE * height_px
    };
    let cut = views.iter().zip(&columns).filter(is_cut).count();
    cut >= LEAST_FRAMES && cut as f64 >= LEAST_SHARE * views.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Mask;
    use crate::pipeline::diagnosis::figures::Figures;

    /// What is said of a person who sways by so much, m, of whose pictures only some columns are kept in some cameras.
    fn said(sway_m: f64, kept: impl Fn(usize, usize, usize) -> bool) -> Option<Cause> {
        let figures = Figures::new();
        let frame = |number: usize| {
            let masks = figures.masks(&figures.standing(sway_m * number as f64, 0.0));
            let cut = |(camera, mask): (usize, &Mask)| {
                let (width, height) = (mask.width(), mask.height());
                let is_shown = |x, y| mask.is_foreground(x, y) && kept(camera, x, width);
                Mask::from_fn(width, height, is_shown)
            };
            figures.frame(number, &masks.iter().enumerate().map(cut).collect::<Vec<_>>())
        };
        let frames: Vec<FrameObservations> = (0..6).map(frame).collect();
        cropped(&figures.rig, &frames)
    }

    #[test]
    fn masks_that_end_at_one_upright_line_are_told_and_those_of_a_whole_person_are_not() {
        let cameras = Figures::new().rig.cameras.len();
        let right = |_: usize, x: usize, width: usize| x >= width / 2;
        let left = |_: usize, x: usize, width: usize| x < width * 9 / 20;
        for sway_m in [0.0, 0.005, 0.05] {
            assert_eq!(said(sway_m, |_, _, _| true), None, "{sway_m}");
            for kept in [right, left] {
                let found = said(sway_m, kept);
                let Some(Cause::Cropped { cameras: named }) = &found else { panic!("{found:?}") };
                assert_eq!(named.len(), cameras, "{sway_m}");
            }
        }
    }

    #[test]
    fn half_of_the_cameras_must_be_so() {
        let cameras = Figures::new().rig.cameras.len();
        let of = |cut: usize| said(0.005, |camera, x, width| camera >= cut || x >= width / 2);
        assert_eq!(of(1), None);
        let found = of(cameras.div_ceil(2));
        assert!(
            matches!(&found, Some(Cause::Cropped { cameras }) if cameras.len() > 1),
            "{found:?}"
        );
    }
}
