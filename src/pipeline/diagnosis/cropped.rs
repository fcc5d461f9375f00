//! Cameras whose masks end at one upright line inside the picture: what lies beyond it was cut off, or never segmented.
//!
//! A person who walks or sways touches the outermost column of all their masks with a hand, once. A picture that was cut ends there
//! again and again, and over much of the person's height, now more of it and now less. Furniture has the same edge
//! always. Only left and right are looked at: floors make level edges of their own, and a person who is cut off below is told by the
//! height.

use super::cause::{Cause, name};
use crate::camera::{Camera, CameraId, Rig};
use crate::math::stats::median;
use crate::silhouette::{ContourPoint, FrameObservations, Silhouette};

/// A border this near to the line lies on it, px of the recorded picture: the borders of a mask are known to half a pixel.
const ON_LINE_PX: f64 = 1.0;
/// A mask is cut if so much of its height lies on the line: more than a hand or a foot.
const CUT_SHARE: f64 = 1.0 / 3.0;
/// A camera's masks end at the line if so many of them are cut, …
const LEAST_FRAMES: usize = 3;
/// … and this share of all that it shows.
const LEAST_SHARE: f64 = 0.1;
/// Of the cut masks the edge changes by this share of the person's height, from the tenth part with the shortest to the tenth with the
/// longest: legs part and close, arms swing.
const MOVES: f64 = 0.1;

/// The cameras whose masks end at an upright line, where they are half of those that show the person, or more.
pub(super) fn cropped(rig: &Rig, frames: &[FrameObservations]) -> Option<Cause> {
    let views = |id: CameraId| -> Vec<&Silhouette> {
        let all = frames.iter().flat_map(|frame| &frame.views);
        all.filter(|(camera, _)| *camera == id).map(|(_, view)| view).collect()
    };
    let shown = rig.iter().map(|(id, camera)| (id, camera, views(id)));
    let shown: Vec<_> = shown.filter(|(.., views)| !views.is_empty()).collect();

    let ends = |camera: &Camera, views: &[&Silhouette]| {
        let columns: Vec<_> = views.iter().map(|view| columns(view, camera)).collect();
        ends_at_line(views, &columns, -1.0) || ends_at_line(views, &columns, 1.0)
    };
    let found = shown.iter().filter(|(_, camera, views)| ends(camera, views));
    let cameras: Vec<String> = found.map(|(id, ..)| name(rig, *id)).collect();
    let are_many = !cameras.is_empty() && 2 * cameras.len() >= shown.len();
    are_many.then_some(Cause::Cropped { cameras })
}

/// Of each border point its column in the recorded picture, px, and the length that it stands for, px.
fn columns(view: &Silhouette, camera: &Camera) -> Vec<(f64, f64)> {
    let of_point = |point: &ContourPoint| (camera.distort(&point.pixel).x, point.length_px);
    view.contour.iter().map(of_point).collect()
}

/// Whether many silhouettes end at the column that lies farthest of all that they reach: to the right, or to the left for −1.
fn ends_at_line(views: &[&Silhouette], columns: &[Vec<(f64, f64)>], outward: f64) -> bool {
    let all = columns.iter().flatten().map(|(x_px, _)| outward * x_px);
    let line = all.fold(f64::NEG_INFINITY, f64::max);

    // how much of its height each silhouette that is cut has on the line
    let edge = |(view, columns): (&&Silhouette, &Vec<(f64, f64)>)| {
        let on_line = columns.iter().filter(|(x_px, _)| line - outward * x_px < ON_LINE_PX);
        let length_px: f64 = on_line.map(|(_, length_px)| length_px).sum();
        let height_px = view.bounds.1.y - view.bounds.0.y;
        (length_px > CUT_SHARE * height_px).then_some((length_px, height_px))
    };
    let cut: Vec<(f64, f64)> = views.iter().zip(columns).filter_map(edge).collect();
    let is_often =
        cut.len() >= LEAST_FRAMES && cut.len() as f64 >= LEAST_SHARE * views.len() as f64;
    is_often && moves(cut)
}

/// Whether the edges of a person change, of which the lengths and the person's heights are given.
fn moves(mut cut: Vec<(f64, f64)>) -> bool {
    cut.sort_by(|a, b| a.0.total_cmp(&b.0));
    let tenth = cut.len() / 10;
    let (shortest, longest) = (cut[tenth].0, cut[cut.len() - 1 - tenth].0);
    let height_px = median(&mut cut.iter().map(|(_, height_px)| *height_px).collect());
    height_px.is_some_and(|height_px| longest - shortest > MOVES * height_px)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Mask;
    use crate::pipeline::diagnosis::figures::Figures;

    /// What is said of a person who walks by `step_m` from frame to frame, whose masks hold what `is_shown` makes of each pixel: by camera,
    /// column over the picture's width, row over its height, and whether the person is there.
    fn said(step_m: f64, is_shown: impl Fn(usize, [f64; 2], bool) -> bool) -> Option<Cause> {
        let figures = Figures::new();
        let frame = |number: usize| {
            let along = step_m * (number as f64 - 2.5);
            let masks = figures.masks(&figures.standing(along, along));
            let changed = |(camera, mask): (usize, &Mask)| {
                let size = [mask.width(), mask.height()];
                let share = |x, y| [x as f64 / size[0] as f64, y as f64 / size[1] as f64];
                Mask::from_fn(size[0], size[1], |x, y| {
                    is_shown(camera, share(x, y), mask.is_foreground(x, y))
                })
            };
            figures.frame(number, &masks.iter().enumerate().map(changed).collect::<Vec<_>>())
        };
        let frames: Vec<FrameObservations> = (0..6).map(frame).collect();
        cropped(&figures.rig, &frames)
    }

    #[test]
    fn masks_that_end_at_one_upright_line_are_told_and_those_of_a_whole_person_are_not() {
        let cameras = Figures::new().rig.cameras.len();
        for step_m in [0.0, 0.005, 0.04] {
            assert_eq!(said(step_m, |_, _, is_person| is_person), None, "{step_m}");
        }
        let right = said(0.04, |_, [x, _], is_person| is_person && x >= 0.5);
        let left = said(0.04, |_, [x, _], is_person| is_person && x < 0.5);
        for found in [right, left] {
            let Some(Cause::Cropped { cameras: named }) = &found else { panic!("{found:?}") };
            assert!(2 * named.len() >= cameras, "{named:?}");
        }
        assert_eq!(
            said(0.04, |camera, [x, _], is_person| is_person && (camera > 0 || x >= 0.5)),
            None
        );
    }

    #[test]
    fn the_upright_edge_of_furniture_is_no_end_of_the_picture() {
        let wardrobe = |_: usize, [x, y]: [f64; 2], is_person: bool| {
            is_person || (0.05..0.2).contains(&x) && (0.2..0.9).contains(&y)
        };
        assert_eq!(said(0.04, wardrobe), None);
    }
}
