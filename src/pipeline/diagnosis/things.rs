//! Things that stand still in masks while the person walks: a chair that was moved after the picture of the empty room, a screen, a lamp.
//!
//! The picture of a camera is looked at in cells. One that is foreground in nearly every frame is *still*. Of somebody who walks it
//! shows a thing if one of these holds:
//!
//! - In some frames it lies apart from the person: from the largest piece of what is foreground and not still, where that is nearly as tall
//!   as the foreground around it.
//! - In most frames its line of sight is [off](super::parts): at no place of it do nearly all cameras see anything. The trunk of somebody
//!   who comes towards the camera is still too, and the others see it.
//!
//! Somebody who stays in one place is still themselves. So nothing is looked for unless these pieces move by [`WALK_M`] in the room.
//!
//! Whether the person is seen at a thing is unknown, as where somebody else stands before them. So a camera keeps what it shows beside
//! the thing, and is not left out with it. Things that are in line by chance look like somebody: what is left when others are gone is looked
//! at again.

use std::borrow::Cow;

use nalgebra::{Point2, Point3};
use rayon::prelude::*;

use super::cause::{Cause, name};
use super::parts::Views;
use super::room::{Cells, in_nearly_all, shown};
use super::{evenly, shown_by_two};
use crate::camera::{Camera, CameraId, Ray, Rig, closest_point};
use crate::image::{Component, Connectivity, Mask, Region, Runs, widened};
use crate::math::stats::median;
use crate::silhouette::{FrameObservations, Silhouette};

/// Frames that are looked at, and of those the ones in which lines of sight are followed.
const SAMPLED_FRAMES: usize = 24;
const FOLLOWED_FRAMES: usize = 8;
/// Fewer frames do not show what stands still.
const LEAST_FRAMES: usize = 8;
/// The middle of somebody who walks moves by more, metres; of one who stands up or squats, by a thigh's length at most.
const WALK_M: f64 = 0.75;
/// Of the area of a silhouette what a thing has at least: a hand has a hundredth.
const LEAST_SHARE: f64 = 0.02;
/// In so many frames at least a thing lies apart from the person.
const LEAST_APART: usize = 3;
/// Of the height of the foreground around them what a person has at least who is not mostly still.
const WHOLE: f64 = 0.75;
/// Of its area likewise: of a trunk that stays where it is, only a rim moves.
const HALF: f64 = 0.5;
/// Of a person's height what they may reach beside what of them is not still.
const REACH: f64 = 0.1;
/// So often what is left is looked at again.
const ROUNDS: usize = 3;

/// A recording without the things that stand still in its masks.
#[derive(Debug, Clone)]
pub(super) struct WithoutThings<'a> {
    pub(super) frames: Cow<'a, [FrameObservations]>,
    pub(super) cause: Option<Cause>,
}

impl<'a> WithoutThings<'a> {
    pub(super) fn new(rig: &Rig, frames: Cow<'a, [FrameObservations]>) -> Self {
        let mut without = Self { frames, cause: None };
        let mut shares = vec![0.0; rig.cameras.len()];
        for _ in 0..ROUNDS {
            let things = things(rig, &without.frames);
            if things.is_empty() {
                break;
            }
            things.iter().for_each(|(id, thing)| shares[id.0] += thing.share);
            let beside = without.frames.par_iter().map(|frame| beside(frame, &things)).collect();
            without.frames = Cow::Owned(beside);
        }

        let holding = rig.iter().filter(|(id, _)| shares[id.0] > 0.0);
        let cameras: Vec<String> = holding.map(|(id, _)| name(rig, id)).collect();
        let share = shares.into_iter().fold(0.0, f64::max);
        without.cause = (!cameras.is_empty()).then_some(Cause::Things { cameras, share });
        without
    }
}

/// The things in the pictures of those cameras that show some.
fn things(rig: &Rig, frames: &[FrameObservations]) -> Vec<(CameraId, Thing)> {
    let sampled: Vec<&FrameObservations> =
        shown_by_two(frames, SAMPLED_FRAMES).into_iter().map(|i| &frames[i]).collect();
    let cameras: Vec<(CameraId, &Camera)> = rig.iter().collect();
    let pictures =
        cameras.into_par_iter().filter_map(|(id, camera)| Picture::new(id, camera, &sampled));
    let pictures: Vec<Picture<'_>> = pictures.collect();
    let may_hold = |picture: &Picture<'_>| picture.share(&picture.still) >= LEAST_SHARE;
    if !pictures.iter().any(may_hold) {
        return Vec::new();
    }

    let people: Vec<People> = pictures.par_iter().map(Picture::people).collect();
    if !walks(&pictures, &people, sampled.len()) {
        return Vec::new();
    }
    let followed = evenly(sampled.len(), FOLLOWED_FRAMES);
    let followed: Vec<Views<'_>> = followed.filter_map(|i| Views::of(rig, sampled[i])).collect();
    let holding = pictures.par_iter().zip(&people).filter(|(picture, _)| may_hold(picture));
    let thing = |(picture, people): (&Picture<'_>, &People)| {
        Some((picture.id, picture.thing(people, &followed)?))
    };
    holding.filter_map(thing).collect()
}

/// Whether the person goes through the room.
fn walks(pictures: &[Picture<'_>], people: &[People], frames: usize) -> bool {
    let place = |frame: usize| {
        let rays = pictures.iter().zip(people);
        let rays = rays.filter_map(|(picture, people)| Some(picture.towards(&people[frame]?)));
        closest_point(&rays.collect::<Vec<Ray>>())
    };
    let places: Vec<Point3<f64>> = (0..frames).filter_map(place).collect();
    places.iter().any(|to| places.iter().any(|from| nalgebra::distance(from, to) > WALK_M))
}

/// Frame by frame where the person is who moves; `None` where there is nobody, or not a whole person.
type People = Vec<Option<Region>>;

/// The picture of a camera in some frames, in cells.
#[derive(Debug)]
struct Picture<'a> {
    id: CameraId,
    camera: &'a Camera,
    cells: Cells,
    /// What each frame shows.
    frames: Vec<Option<Mask>>,
    /// What is foreground in nearly all of them.
    still: Mask,
    /// The median silhouette's.
    area: f64,
}

impl<'a> Picture<'a> {
    /// `None` if too few frames have one.
    fn new(id: CameraId, camera: &'a Camera, sampled: &[&FrameObservations]) -> Option<Self> {
        let cells = Cells::of(camera);
        let in_cells = |silhouette: &Silhouette| {
            let is_inside = |x, y| silhouette.contains(&cells.middle(x, y));
            Mask::from_fn(cells.columns, cells.rows, is_inside)
        };
        let frames: Vec<Option<Mask>> =
            sampled.iter().map(|frame| shown(frame, id).map(in_cells)).collect();
        let seen: Vec<&Mask> = frames.iter().flatten().collect();
        if seen.len() < LEAST_FRAMES {
            return None;
        }

        let still = Mask::from_fn(cells.columns, cells.rows, |x, y| {
            let shown = seen.iter().filter(|mask| mask.is_foreground(x, y)).count();
            in_nearly_all(shown, seen.len())
        });
        let area = median(&mut seen.iter().map(|mask| area(mask)).collect())?;
        Some(Self { id, camera, cells, frames, still, area })
    }

    /// Of the area of the median silhouette.
    fn share(&self, cells: &Mask) -> f64 {
        area(cells) / self.area
    }

    fn people(&self) -> People {
        self.frames.iter().map(|mask| moving(mask.as_ref()?, &self.still)).collect()
    }

    /// The line of sight to the middle of a person.
    fn towards(&self, person: &Region) -> Ray {
        let middle = [person.left + person.right, person.top + person.bottom];
        let [x, y] = middle.map(|twice| 0.5 * twice as f64 * self.cells.step_px);
        self.camera.ray(&Point2::new(x, y))
    }

    /// What of it shows things; `None` if that is nothing.
    fn thing(&self, people: &People, followed: &[Views<'_>]) -> Option<Thing> {
        let is_off = |x: usize, y: usize| {
            let pixel = self.cells.middle(x, y);
            let sights = followed.iter().filter_map(|views| views.sight(self.id, &pixel));
            let off: Vec<bool> = sights.map(|sight| sight.is_off).collect();
            2 * off.iter().filter(|is_off| **is_off).count() > off.len()
        };
        let is_apart = |x: usize, y: usize| {
            let people = people.iter().flatten();
            people.filter(|person| is_apart(person, x, y)).count() >= LEAST_APART
        };
        let things = Mask::from_fn(self.cells.columns, self.cells.rows, |x, y| {
            self.still.is_foreground(x, y) && (is_apart(x, y) || is_off(x, y))
        });
        let share = self.share(&things);
        let step_px = self.cells.step_px;
        (share >= LEAST_SHARE).then(|| Thing { cells: widened(&things, 1), step_px, share })
    }
}

/// What of a camera's picture shows things.
#[derive(Debug, Clone)]
struct Thing {
    /// Its cells, and those beside them: its border is ragged.
    cells: Mask,
    step_px: f64,
    /// Its area over that of the median silhouette.
    share: f64,
}

impl Thing {
    /// What a camera shows beside it; `None` if that is nothing.
    fn beside(&self, shown: &Silhouette) -> Option<Silhouette> {
        let is_beside = |pixel: &Point2<f64>| {
            let [x, y] = [pixel.x, pixel.y].map(|along| (along / self.step_px) as usize);
            !self.cells.is_foreground(x, y)
        };
        shown.share(|point| f64::from(u8::from(is_beside(&point.pixel))), is_beside)
    }
}

/// What a frame shows beside things.
fn beside(frame: &FrameObservations, things: &[(CameraId, Thing)]) -> FrameObservations {
    frame.with_views(|id, shown| match things.iter().find(|(camera, _)| *camera == id) {
        Some((_, thing)) => thing.beside(shown),
        None => Some(shown.clone()),
    })
}

fn area(cells: &Mask) -> f64 {
    Runs::from_mask(cells).area() as f64
}

/// Where the largest piece is of what is foreground and not still; `None` unless it is nearly as tall as the piece of foreground around it, and
/// half of it.
fn moving(seen: &Mask, still: &Mask) -> Option<Region> {
    let pieces =
        |mask: &Mask| -> Vec<Component> { Runs::from_mask(mask).components(Connectivity::Eight).0 };
    let rest = Mask::from_fn(seen.width(), seen.height(), |x, y| {
        seen.is_foreground(x, y) && !still.is_foreground(x, y)
    });
    let person = pieces(&rest).into_iter().max_by_key(|piece| piece.area)?;
    let around = pieces(seen).into_iter().filter(|piece| holds(&piece.region, &person.region));
    let around = around.min_by_key(|piece| piece.area)?;

    let height = |piece: &Component| (piece.region.bottom - piece.region.top) as f64;
    let is_whole = height(&person) >= WHOLE * height(&around)
        && person.area as f64 >= HALF * around.area as f64;
    is_whole.then_some(person.region)
}

fn holds(outer: &Region, inner: &Region) -> bool {
    outer.left <= inner.left
        && outer.right >= inner.right
        && outer.top <= inner.top
        && outer.bottom >= inner.bottom
}

/// Whether a cell lies beside a person, farther than they may reach.
fn is_apart(person: &Region, x: usize, y: usize) -> bool {
    let reach = (REACH * (person.bottom - person.top) as f64).ceil() as usize;
    let is_beside = |at: usize, low: usize, high: usize| at + reach < low || at >= high + reach;
    is_beside(x, person.left, person.right) || is_beside(y, person.top, person.bottom)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::diagnosis::figures::Figures;

    /// A person who goes `step_m` each frame, with a chair in the masks of the first cameras.
    fn frames(figures: &Figures, step_m: f64, chairs: usize) -> Vec<FrameObservations> {
        let frame = |number: usize| {
            let masks = figures.masks(&figures.standing(step_m * (number as f64 - 4.0), 0.0));
            let with_chair = |(camera, mask): (usize, &Mask)| {
                Mask::from_fn(mask.width(), mask.height(), |x, y| {
                    let is_chair = (40..80).contains(&x) && y > 120;
                    mask.is_foreground(x, y) || camera < chairs && is_chair
                })
            };
            figures.frame(number, &masks.iter().enumerate().map(with_chair).collect::<Vec<_>>())
        };
        (0..9).map(frame).collect()
    }

    #[test]
    fn a_chair_is_left_out_and_named_and_its_cameras_stay() {
        let figures = Figures::new();
        let alone = frames(&figures, 0.2, 0);
        for chairs in [1, 2, figures.rig.cameras.len()] {
            let shown = frames(&figures, 0.2, chairs);
            let without = WithoutThings::new(&figures.rig, Cow::Borrowed(&shown));
            let Some(Cause::Things { cameras, share }) = &without.cause else {
                panic!("{chairs} chairs: {:?}", without.cause)
            };
            assert_eq!(cameras.len(), chairs);
            assert!((0.1..2.0).contains(share), "{share}");

            for (frame, person) in without.frames.iter().zip(&alone) {
                assert_eq!(frame.views.len(), person.views.len());
                for ((_, left), (_, person)) in frame.views.iter().zip(&person.views) {
                    let ratio = left.area_px / person.area_px;
                    assert!((0.6..1.1).contains(&ratio), "{ratio}");
                }
                let (chair, (_, first)) = (Point2::new(60.0, 180.0), &frame.views[0]);
                assert!(!first.contains(&chair) && !first.sees(&chair));
            }
        }
    }

    #[test]
    fn a_person_alone_stays_as_they_are_and_so_does_all_beside_one_who_does_not_walk() {
        let figures = Figures::new();
        for (step_m, chairs) in [(0.2, 0), (0.0, 0), (0.01, 2)] {
            let shown = frames(&figures, step_m, chairs);
            let without = WithoutThings::new(&figures.rig, Cow::Borrowed(&shown));
            assert!(without.cause.is_none() && matches!(without.frames, Cow::Borrowed(_)));
        }
    }

    #[test]
    fn a_few_frames_do_not_show_what_stands_still() {
        let figures = Figures::new();
        let shown = frames(&figures, 0.2, 1);
        let few = Cow::Borrowed(&shown[..LEAST_FRAMES - 1]);
        assert!(WithoutThings::new(&figures.rig, few).cause.is_none());
    }
}
