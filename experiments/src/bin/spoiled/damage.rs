//! Ways to spoil a recording, each with what a verdict must say that names the cause.

use std::ops::Range;

use experiments::recorded::Recorded;
use maquette::camera::Camera;
use maquette::image::{Mask, opened};
use maquette::math::Rigid3;
use maquette::math::stats::median;
use maquette::silhouette::FrameIndex;
use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::jumps::{late_from, touched_while};
use crate::shadows::{around_feet, cast, darkened};
use crate::worn::{bag, carried, skirt};

/// A way to spoil a recording.
pub(crate) struct Damage {
    pub(crate) name: &'static str,
    /// What a verdict must say that names the cause; ` & ` between what it must say besides.
    pub(crate) cause: &'static str,
    /// What a note says of it, where that is all that can be said.
    pub(crate) note: Option<&'static str>,
    pub(crate) spoil: Box<dyn Fn(&Recorded) -> Recorded>,
}

fn damage(
    name: &'static str,
    cause: &'static str,
    spoil: impl Fn(&Recorded) -> Recorded + 'static,
) -> Damage {
    Damage { name, cause, note: None, spoil: Box::new(spoil) }
}

impl Damage {
    fn noted(self, note: &'static str) -> Self {
        Self { note: Some(note), ..self }
    }
}

/// What a note says of the scale where nobody stated the person's height.
const UNCHECKED: &str = "pictures alone do not show whether the calibration's unit of length";
/// What a note says of limbs.
const HIDDEN: &str = "lies before or behind the body";

/// Everything that is done to a recording.
pub(crate) fn damages() -> Vec<Damage> {
    let mut all = vec![damage("nothing", "", Clone::clone)];
    all.extend(cameras());
    all.extend(lenses());
    all.extend(masks());
    all.extend(world());
    all
}

/// What is wrong with a recording already; `cause` names it.
pub(crate) fn as_recorded(cause: &'static str) -> Damage {
    damage("as recorded", cause, Clone::clone)
}

/// The cameras where they were.
pub(crate) fn recalibrated() -> Damage {
    damage("nothing", "", |r| Recorded { rig: r.true_rig.clone(), ..r.clone() })
}

fn cameras() -> Vec<Damage> {
    let turned = |degrees: f64| {
        move |c: &mut Camera| {
            let turn = Rigid3::rotation(Vector3::y() * degrees.to_radians());
            c.camera_from_world = turn * c.camera_from_world;
        }
    };
    vec![
        damage("every second camera", "", |r| r.with_cameras(&every(r, 2))),
        damage("three cameras", "", |r| {
            r.with_cameras(&[0, r.rig.cameras.len() / 3, 2 * r.rig.cameras.len() / 3])
        }),
        damage("two cameras side by side", "", |r| r.with_cameras(&[0, 1])).noted(HIDDEN),
        damage("two cameras", "", |r| r.with_cameras(&[0, r.rig.cameras.len() / 2])).noted(HIDDEN),
        damage("one camera", "two cameras", |r| r.with_cameras(&[0])),
        damage("cameras 1 and 2 exchanged", "exchanged", |r| exchanged(r, 0, 1)),
        damage("cameras 1 and 4 exchanged", "exchanged", |r| exchanged(r, 0, 3)),
        damage("all mirrored", "all pictures are mirrored", |r| {
            r.with_masks(|_, _, m| Some(mirrored(m)))
        }),
        damage("camera 2 mirrored", "is mirrored", |r| {
            r.with_masks(|_, c, m| Some(if c == 1 { mirrored(m) } else { m.clone() }))
        }),
        damage("all upside down", "all pictures are upside down", |r| {
            r.with_masks(|_, _, m| Some(upside_down(m)))
        }),
        damage("camera 2 upside down", "is upside down", |r| {
            r.with_masks(|_, c, m| Some(if c == 1 { upside_down(m) } else { m.clone() }))
        }),
        damage("camera 2 moved by 10 cm", "was touched", |r| moved(r, 1, |c| shift(c, 0.1))),
        damage("camera 2 moved by 30 cm", "was touched", |r| moved(r, 1, |c| shift(c, 0.3))),
        damage("camera 2 turned by 1°", "was touched", move |r| moved(r, 1, turned(1.0))),
        damage("camera 2 turned by 3°", "was touched", move |r| moved(r, 1, turned(3.0))),
        damage("camera 2 late by 1 frame", "late by 1.0", |r| late(r, 1, 1)),
        damage("camera 2 late by 3 frames", "late by 3.0", |r| late(r, 1, 3)),
        damage("camera 2 late by 10 frames", "late by 10.0", |r| late(r, 1, 10)),
        damage("camera 2 loses 3 frames", "has lost 3 frames", |r| {
            late_from(r, 1, -3, r.masks.len() / 2)
        }),
        damage("camera 2 shows each picture twice", "once more in", |r| {
            let masks = r.masks.clone();
            r.with_masks(
                move |f, c, m| {
                    if c == 1 { masks[f - f % 2][c].clone() } else { Some(m.clone()) }
                },
            )
        }),
        damage("camera 2 is turned by 1° while it records", "touched while it recorded", |r| {
            touched_while(r, 1, Vector3::y() * 1f64.to_radians())
        }),
        damage("cameras 2 and 4 late by 4 and −5 frames", "early by 5.0", |r| {
            late(&late(r, 1, 4), 3, -5)
        }),
    ]
}

fn lenses() -> Vec<Damage> {
    vec![
        damage("camera 2's focal length 10 % off", "focal length of", |r| {
            moved(r, 1, |c| zoom(c, 1.1))
        }),
        damage("focal lengths 5 % off", "focal lengths of all", |r| {
            all_cameras(r, |c| zoom(c, 1.05))
        })
        .noted(UNCHECKED),
        damage("focal lengths 20 % off", "focal lengths of all", |r| {
            all_cameras(r, |c| zoom(c, 1.2))
        })
        .noted(UNCHECKED),
        damage("focal lengths 20 % off, height given", "focal lengths", |r| {
            with_height(&all_cameras(r, |c| zoom(c, 1.2)))
        }),
    ]
}

fn masks() -> Vec<Damage> {
    vec![
        damage("20 % of the masks lost", "", |r| lost(r, 0.2)),
        damage("40 % of the masks lost", "", |r| lost(r, 0.4)),
        damage("legs cut off", "less than a standing person", |r| {
            r.with_masks(|_, _, m| {
                let (top, bottom) = rows(m)?;
                let cut = top + (bottom - top) * 11 / 20;
                Some(kept(m, |_, y| y < cut))
            })
        }),
        damage("legs behind a table", "less than a standing person", table),
        damage("lower half lost in every second camera", "lack a part of the person", |r| {
            r.with_masks(|_, c, m| if c % 2 == 1 { half(m) } else { Some(m.clone()) })
        }),
        damage("a wardrobe in two cameras", "that the other cameras do not see", |r| {
            let last = r.rig.cameras.len() - 1;
            r.with_masks(move |_, c, m| {
                Some(if c == 1 || c == last { joined(m, &wardrobe(m)) } else { m.clone() })
            })
        }),
        damage("a chair in camera 2", "left out", |r| {
            r.with_masks(|_, c, m| Some(if c == 1 { joined(m, &chair(m)) } else { m.clone() }))
        }),
        damage("a lamp's shadow", "shadows on the floor", |r| darkened(r, cast)),
        damage("the dark around the feet", "shadows on the floor", |r| darkened(r, around_feet)),
        damage("a skirt", "moves with the person", |r| carried(r, skirt)),
        damage("a bag in the right hand", "moves with the person", |r| carried(r, bag)),
        damage("stale picture of the room", "never moves", |r| {
            let first = r.masks[0].clone();
            r.with_masks(move |_, c, m| Some(joined(m, first[c].as_ref()?)))
        }),
        damage("furniture in the masks", "never moves", |r| {
            r.with_masks(|_, c, m| Some(joined(m, &furniture(m, c))))
        }),
        damage("a second person", "second person", |r| {
            let n = r.masks.len();
            let masks = r.masks.clone();
            r.with_masks(move |f, c, m| Some(joined(m, masks[n - 1 - f][c].as_ref()?)))
        }),
        damage("thin parts gone", "thin parts", |r| {
            r.with_masks(|_, _, m| {
                let (top, bottom) = rows(m)?;
                Some(opened(m, ((bottom - top) / 30).min(255) as u8))
            })
        }),
        damage("the person leaves for a third", "", |r| {
            let n = r.masks.len();
            r.with_masks(move |f, _, m| (f < n / 3 || f >= 2 * n / 3).then(|| m.clone()))
        }),
        damage("the person comes back elsewhere", "", comes_back),
        damage("left half of each picture lost", "cut off", |r| {
            r.with_masks(|_, _, m| Some(kept(m, |x, _| x >= m.width() / 2)))
        }),
    ]
}

fn world() -> Vec<Damage> {
    let turn = |axis: Vector3<f64>, degrees: f64| Rigid3::rotation(axis * degrees.to_radians());
    vec![
        damage("up is another axis", "`up`", move |r| turned_world(r, turn(Vector3::x(), 90.0))),
        damage("up is a third axis", "`up`", move |r| turned_world(r, turn(Vector3::y(), 90.0))),
        damage("up is down", "`up`", move |r| turned_world(r, turn(Vector3::x(), 180.0))),
        damage("world 10 % too large", "too large for a person", |r| scaled(r, 1.1))
            .noted(UNCHECKED),
        damage("world 10 % too small", "too small for a person", |r| scaled(r, 0.9))
            .noted(UNCHECKED),
        damage("world 10 % too large, height given", "too large for a person", |r| {
            with_height(&scaled(r, 1.1))
        }),
        damage("world 10 % too small, height given", "too small for a person", |r| {
            with_height(&scaled(r, 0.9))
        }),
        damage("world 30 % too large", "too large for a person", |r| scaled(r, 1.3)),
        damage("unit ten times too large", "unit", |r| scaled(r, 10.0)),
        damage("frame rate half", "frame rate", |r| Recorded { fps: 0.5 * r.fps, ..r.clone() }),
        damage("frame rate double", "frame rate", |r| Recorded { fps: 2.0 * r.fps, ..r.clone() }),
        damage("frame rate ten times", "frame rate", |r| Recorded {
            fps: 10.0 * r.fps,
            ..r.clone()
        }),
    ]
}

fn every(r: &Recorded, step: usize) -> Vec<usize> {
    (0..r.rig.cameras.len()).step_by(step).collect()
}

fn exchanged(r: &Recorded, a: usize, b: usize) -> Recorded {
    let mut spoiled = r.clone();
    spoiled.masks.iter_mut().for_each(|masks| masks.swap(a, b));
    spoiled
}

fn late(r: &Recorded, camera: usize, frames: isize) -> Recorded {
    late_from(r, camera, frames, 0)
}

fn moved(r: &Recorded, camera: usize, change: impl Fn(&mut Camera)) -> Recorded {
    let mut spoiled = r.clone();
    change(&mut spoiled.rig.cameras[camera]);
    spoiled
}

fn all_cameras(r: &Recorded, change: impl Fn(&mut Camera)) -> Recorded {
    let mut spoiled = r.clone();
    spoiled.rig.cameras.iter_mut().for_each(change);
    spoiled
}

/// To the side, as the camera sees it.
fn shift(camera: &mut Camera, metres: f64) {
    camera.camera_from_world.translation.vector.x += metres;
}

fn zoom(camera: &mut Camera, factor: f64) {
    camera.intrinsics.fx_px *= factor;
    camera.intrinsics.fy_px *= factor;
}

fn turned_world(r: &Recorded, turned_from_world: Rigid3) -> Recorded {
    let world_from_turned = turned_from_world.inverse();
    let mut spoiled = all_cameras(r, |c| c.camera_from_world *= world_from_turned);
    let places = spoiled.truth.frames.iter_mut().flatten().flatten();
    places.for_each(|place| *place = turned_from_world * *place);
    spoiled
}

/// Only the cameras: the truth keeps its size.
fn scaled(r: &Recorded, factor: f64) -> Recorded {
    all_cameras(r, |c| c.camera_from_world.translation.vector *= factor)
}

fn with_height(r: &Recorded) -> Recorded {
    Recorded { given_m: r.stature_m, ..r.clone() }
}

fn lost(r: &Recorded, share: f64) -> Recorded {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut spoiled = r.clone();
    for mask in spoiled.masks.iter_mut().flatten() {
        if rng.random_bool(share) {
            *mask = None;
        }
    }
    spoiled
}

/// The recording, as long again without anybody, and the recording once more: the person stands where the first began.
fn comes_back(r: &Recorded) -> Recorded {
    let n = r.masks.len();
    let mut spoiled = r.clone();
    for i in n..3 * n {
        spoiled.numbers.push(FrameIndex(r.numbers[0].0 + i));
        let shown = (i >= 2 * n).then(|| i - 2 * n);
        spoiled
            .masks
            .push(shown.map_or_else(|| vec![None; r.rig.cameras.len()], |i| r.masks[i].clone()));
        let places = shown.and_then(|i| r.truth.frames.get(i).cloned());
        spoiled.truth.frames.push(places.unwrap_or_else(|| vec![None; r.truth.names.len()]));
    }
    spoiled
}

/// What lies below half of the person's usual height is hidden in every camera, as by furniture all around.
fn table(r: &Recorded) -> Recorded {
    let heights = r.truth.frames.iter().flatten().flatten().map(|p| p.z);
    let top = heights.fold(0.0, f64::max);
    let middle = |axis: usize| {
        median(&mut r.truth.frames.iter().flatten().flatten().map(|p| p[axis]).collect())
    };
    let Some((x, y)) = middle(0).zip(middle(1)) else {
        return r.clone();
    };
    let edge = Point3::new(x, y, 0.45 * top);
    r.with_masks(|_, c, m| {
        let row = r.rig.cameras[c].project(&edge)?.y;
        Some(kept(m, |_, y| (y as f64) < row))
    })
}

/// The first and the last row with foreground.
fn rows(mask: &Mask) -> Option<(usize, usize)> {
    let shown = |y: &usize| mask.row(*y).contains(&1);
    let first = (0..mask.height()).find(shown)?;
    Some((first, (0..mask.height()).rfind(shown)?))
}

fn kept(mask: &Mask, is_kept: impl Fn(usize, usize) -> bool) -> Mask {
    let is_foreground = |x, y| mask.is_foreground(x, y) && is_kept(x, y);
    Mask::from_fn(mask.width(), mask.height(), is_foreground)
}

fn mirrored(mask: &Mask) -> Mask {
    let last = mask.width() - 1;
    Mask::from_fn(mask.width(), mask.height(), |x, y| mask.is_foreground(last - x, y))
}

fn upside_down(mask: &Mask) -> Mask {
    let (right, bottom) = (mask.width() - 1, mask.height() - 1);
    let shown = |x, y| mask.is_foreground(right - x, bottom - y);
    Mask::from_fn(mask.width(), mask.height(), shown)
}

fn joined(a: &Mask, b: &Mask) -> Mask {
    Mask::from_fn(a.width(), a.height(), |x, y| a.is_foreground(x, y) || b.is_foreground(x, y))
}

/// What is above the middle of the person.
fn half(mask: &Mask) -> Option<Mask> {
    let (top, bottom) = rows(mask)?;
    Some(kept(mask, |_, y| y < (top + bottom) / 2))
}

/// A box of a tenth of the picture's width.
fn wardrobe(mask: &Mask) -> Mask {
    let (w, h) = (mask.width(), mask.height());
    block(mask, w * 5 / 8..w * 29 / 40, h / 4..h * 4 / 5)
}

/// A box that stands where people do: a sixth of the picture's width, and a quarter of its height.
fn chair(mask: &Mask) -> Mask {
    let (w, h) = (mask.width(), mask.height());
    block(mask, w * 17 / 40..w * 23 / 40, h * 19 / 30..h * 9 / 10)
}

/// A box in a picture as large as a mask.
fn block(mask: &Mask, columns: Range<usize>, rows: Range<usize>) -> Mask {
    let is_block = |x, y| columns.contains(&x) && rows.contains(&y);
    Mask::from_fn(mask.width(), mask.height(), is_block)
}

/// Two boxes, elsewhere in each camera.
fn furniture(mask: &Mask, camera: usize) -> Mask {
    let mut rng = ChaCha8Rng::seed_from_u64(camera as u64);
    let (w, h) = (mask.width(), mask.height());
    let boxes: Vec<[usize; 4]> = (0..2)
        .map(|_| {
            let (x, y) = (rng.random_range(0..w * 3 / 4), rng.random_range(h / 3..h * 3 / 4));
            [x, x + w / 6, y, y + h / 4]
        })
        .collect();
    Mask::from_fn(w, h, |x, y| {
        boxes.iter().any(|[a, b, c, d]| (a..b).contains(&&x) && (c..d).contains(&&y))
    })
}
