//! Cameras side by side of which one was turned after the calibration, told from the rows of their pictures.

use std::collections::BTreeSet;
use std::fmt;

use super::UndistortedFrame;
use crate::camera::{CameraId, Rig};
use crate::pipeline::PictureSource;
use crate::silhouette::FrameIndex;
use crate::stereo::{MOST_ROWS, known_by_rows, neighbour};

/// Frames that are looked at.
const LOOKS: usize = 3;
/// Rows are apart where so many times as many pixels have a depth as where they are not.
const CLEARLY: f64 = 1.3;

/// A camera whose picture lies higher or lower than those beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct RowsApart {
    /// The camera that was turned, or the two of which one was.
    pub cameras: Vec<String>,
    /// By how many rows.
    pub rows: u32,
    /// How far it was turned up or down, degrees.
    pub turn_deg: f64,
}

impl fmt::Display for RowsApart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { cameras, rows, turn_deg } = self;
        let beyond = if *rows == MOST_ROWS as u32 { " or more" } else { "" };
        match cameras.as_slice() {
            [camera] => write!(
                f,
                "the pictures of camera {camera} lie {rows} px{beyond} higher or lower than the calibration says: it was turned by about {turn_deg:.1}°, calibrate it again"
            ),
            cameras => write!(
                f,
                "the pictures of cameras {} lie {rows} px{beyond} apart in height: one of them was turned by about {turn_deg:.1}° after the calibration, calibrate them again",
                cameras.join(" and ")
            ),
        }
    }
}

/// Two cameras side by side, and by how many rows the second picture lies lower.
type Pair = ([CameraId; 2], i32);

/// The cameras side by side whose pictures lie rows apart.
pub fn rows_apart(pictures: &dyn PictureSource, frames: &[FrameIndex]) -> Vec<RowsApart> {
    let rig = pictures.rig();
    let step = frames.len().div_ceil(LOOKS).max(1);
    let looks = frames.iter().step_by(step).filter_map(|frame| {
        let (_, seen) = pictures.pictures(frame.0..=frame.0).next()?;
        UndistortedFrame::new(rig, &seen).ok()
    });
    let looks: Vec<UndistortedFrame> = looks.collect();

    let pairs = side_by_side(rig).into_iter();
    let pairs: Vec<Pair> = pairs.filter_map(|pair| Some((pair, rows_of(pair, &looks)?))).collect();
    let turned = turned(&pairs).into_iter().map(|(cameras, rows)| {
        let cameras = cameras.iter().map(|id| &rig.cameras[id.0]);
        let focal_px = cameras.clone().map(|camera| camera.intrinsics.fy_px).fold(0.0, f64::max);
        RowsApart {
            cameras: cameras.map(|camera| camera.name.clone()).collect(),
            rows,
            turn_deg: f64::from(rows).atan2(focal_px).to_degrees(),
        }
    });
    turned.collect()
}

/// Each pair of neighbours once.
fn side_by_side(rig: &Rig) -> BTreeSet<[CameraId; 2]> {
    let cameras = (0..rig.cameras.len()).map(CameraId);
    let pairs = cameras.filter_map(|camera| Some([camera, neighbour(rig, camera)?]));
    pairs.map(|[a, b]| [a.min(b), a.max(b)]).collect()
}

/// By how many rows the second picture of a pair lies lower than the first; `None` where nothing tells.
fn rows_of(pair: [CameraId; 2], looks: &[UndistortedFrame]) -> Option<i32> {
    let mut known = vec![0_usize; (2 * MOST_ROWS + 1) as usize];
    for look in looks {
        let [Some(first), Some(second)] = pair.map(|id| look.views.get(id.0)?.as_ref()) else {
            continue;
        };
        let of_look = known_by_rows(&first.grey, &second.grey).ok()?;
        known.iter_mut().zip(of_look).for_each(|(sum, n)| *sum += n);
    }

    let level = *known.get(MOST_ROWS as usize)?;
    let (most, rows) = known.into_iter().zip(-MOST_ROWS..).max_by_key(|(n, _)| *n)?;
    let is_apart = most as f64 > CLEARLY * level as f64;
    (most > 0).then_some(if is_apart { rows } else { 0 })
}

/// Which cameras were turned, and by how many rows: the one that all pairs have in common whose rows are apart, if it is in no other; else one of
/// each pair.
fn turned(pairs: &[Pair]) -> Vec<(Vec<CameraId>, u32)> {
    let is_level = |id: &CameraId| pairs.iter().any(|(pair, rows)| *rows == 0 && pair.contains(id));
    let apart: Vec<&Pair> = pairs.iter().filter(|(_, rows)| *rows != 0).collect();
    let Some((first, rows)) = apart.first() else {
        return Vec::new();
    };

    let is_in_all = |id: &CameraId| apart.iter().all(|(pair, _)| pair.contains(id));
    let common: Vec<CameraId> =
        first.iter().filter(|id| is_in_all(id) && !is_level(id)).copied().collect();
    match common.as_slice() {
        [_] => vec![(common, rows.unsigned_abs())],
        _ => apart.iter().map(|(pair, rows)| (pair.to_vec(), rows.unsigned_abs())).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_three_cameras_the_one_that_was_turned_is_named_and_of_two_both() {
        let [left, centre, right] = [0, 1, 2].map(CameraId);
        assert_eq!(turned(&[([left, centre], 0), ([centre, right], 0)]), []);
        // the one in the middle, the one at an end, and two that stand alone
        let middle = turned(&[([left, centre], 6), ([centre, right], -6)]);
        assert_eq!(middle, [(vec![centre], 6)]);
        assert_eq!(turned(&[([left, centre], 0), ([centre, right], -3)]), [(vec![right], 3)]);
        assert_eq!(turned(&[([left, centre], 2)]), [(vec![left, centre], 2)]);
    }

    #[test]
    fn the_message_is_one_line_with_the_angle() {
        let apart = |cameras: &[&str]| RowsApart {
            cameras: cameras.iter().map(ToString::to_string).collect(),
            rows: 6,
            turn_deg: 0.537,
        };
        let line = apart(&["center"]).to_string();
        assert!(line.contains("camera center") && line.contains("0.5°"), "{line}");
        let line = apart(&["left", "right"]).to_string();
        assert!(line.contains("left and right") && !line.contains('\n'), "{line}");
    }
}
