//! Silhouettes that lack a part of the person, or hold something else: a table stands before one camera, a wardrobe is in its mask.
//!
//! The line of sight x(t) of a pixel in a silhouette meets the person where most cameras see something. A camera sees a place if it
//! lies at most [`BORDER_M`] outside of its silhouette, so that small turns, delays and ragged masks do not count. Where
//! [`AGREEING`] cameras and half of those that look see the place, a camera that looks there and does not see it *lacks* the pixel.
//! Where fewer than half see any place of the line, the pixel stands *alone*; of two against two nobody knows. It is *off* where
//! fewer than [`NEARLY_ALL`] do. Of camera b
//!
//! ```text
//! lacks(b) = median over the other cameras a of the share of a's pixels that b lacks
//! alone(b) = share of b's pixels that stand alone, off(b) = share of those that are off
//! ```
//!
//! A camera that looks elsewhere, or shows another moment, lacks and is off in like measure. A mask without the legs lacks and is not off;
//! one with a wardrobe stands alone and lacks nothing. Such views are left out, as long as [`AGREEING`] others remain.

use std::borrow::Cow;

use nalgebra::{Point2, Point3};
use rayon::prelude::*;

use super::cameras::CameraFaults;
use super::cause::{Cause, camera_causes, name};
use super::coherence::{NEARLY_ALL, REACH_M};
use crate::camera::{Camera, CameraId, Ray, Rig, closest_point};
use crate::inference::hull::lines_of_sight;
use crate::math::stats::median;
use crate::silhouette::{FrameObservations, Silhouette};

/// Pixels of each silhouette that are looked at, about.
const PIXELS: f64 = 64.0;
/// So many cameras are believed against one.
pub(in crate::pipeline) const AGREEING: usize = 3;
/// What lies no farther outside of a silhouette is its border: cameras that were touched show it so far off, metres.
pub(super) const BORDER_M: f64 = 0.1;
/// More than an arm and less than a leg, of a person's area: those are 5 and 20 % of the mass (de Leva 1996).
const LEAST_SHARE: f64 = 0.15;
/// What a camera lacks is so many times what is off, or what stands alone so many times what lacks.
const MORE: f64 = 2.0;
/// A camera is named if it is so in more than this share of the frames that it shows, and left out of all of them beyond the other.
const NAMED: f64 = 0.1;
const ALWAYS: f64 = 0.25;
/// The steps in which a line of sight is followed, metres: what is nearer to a silhouette than two of them is its border.
const STEP_M: f64 = 0.05;

/// A recording without the views that lack a part of the person or hold something else.
#[derive(Debug, Clone)]
pub(super) struct Parted<'a> {
    pub(super) frames: Cow<'a, [FrameObservations]>,
    /// The cameras whose views were left out.
    pub(super) causes: Vec<Cause>,
}

/// What is wrong with a view.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Wrong {
    /// This share of the person is not in it.
    Lacks(f64),
    /// This share of it is nothing that the others see.
    Holds(f64),
}

impl<'a> Parted<'a> {
    pub(super) fn new(rig: &Rig, frames: Cow<'a, [FrameObservations]>) -> Self {
        let wrong: Vec<Vec<(CameraId, Wrong)>> =
            frames.par_iter().map(|frame| wrong_views(rig, frame)).collect();

        // how often each camera is so
        let found = |id: CameraId| wrong.iter().flatten().filter(move |(c, _)| *c == id).count();
        let shown = |id: CameraId| {
            frames.iter().filter(|f| f.views.iter().any(|(camera, _)| *camera == id)).count()
        };
        let share = |(id, _)| found(id) as f64 / shown(id).max(1) as f64;
        let shares: Vec<f64> = rig.iter().map(share).collect();
        if shares.iter().all(|share| *share <= NAMED) || has_wrong_pictures(rig, &frames) {
            return Self { frames, causes: Vec::new() };
        }

        let kept = frames.iter().zip(&wrong).map(|(frame, wrong)| {
            let is_wrong = |id: CameraId| wrong.iter().any(|(camera, _)| *camera == id);
            let is_kept = |id: CameraId| match shares[id.0] {
                share if share <= NAMED => true,
                share => share <= ALWAYS && !is_wrong(id),
            };
            let mut kept = frame.clone();
            kept.views.retain(|(id, _)| is_kept(*id));
            if kept.views.len() < AGREEING { frame.clone() } else { kept }
        });
        let named = wrong.iter().flatten().copied().filter(|(id, _)| shares[id.0] > NAMED);
        let causes = causes(rig, &named.collect::<Vec<_>>());
        Self { frames: Cow::Owned(kept.collect()), causes }
    }
}

/// Whether cameras are exchanged or mirrored: what these lack is shown elsewhere.
fn has_wrong_pictures(rig: &Rig, frames: &[FrameObservations]) -> bool {
    let causes = camera_causes(rig, &CameraFaults::of(rig, frames));
    causes.iter().any(|cause| cause.wrong_pictures(rig) > 0)
}

/// The cameras that lack a part, and those that hold something else.
fn causes(rig: &Rig, found: &[(CameraId, Wrong)]) -> Vec<Cause> {
    let cameras = |share_of: fn(Wrong) -> Option<f64>| {
        let of_camera = |(id, _): (CameraId, &Camera)| {
            let shares = found.iter().filter(|(camera, _)| *camera == id);
            let share = median(&mut shares.filter_map(|(_, wrong)| share_of(*wrong)).collect())?;
            Some((name(rig, id), share))
        };
        rig.iter().filter_map(of_camera).collect::<Vec<(String, f64)>>()
    };
    let lacks = cameras(|wrong| if let Wrong::Lacks(share) = wrong { Some(share) } else { None });
    let holds = cameras(|wrong| if let Wrong::Holds(share) = wrong { Some(share) } else { None });

    let most = |of: &[(String, f64)]| of.iter().map(|(_, share)| *share).fold(0.0, f64::max);
    let names = |of: &[(String, f64)]| of.iter().map(|(camera, _)| camera.clone()).collect();
    let hidden = (!lacks.is_empty())
        .then(|| Cause::PartsHidden { cameras: names(&lacks), share: most(&lacks) });
    let alone = (!holds.is_empty())
        .then(|| Cause::PartsAlone { cameras: names(&holds), share: most(&holds) });
    hidden.into_iter().chain(alone).collect()
}

/// What of a frame's views cannot be used; none where too few would be left.
fn wrong_views(rig: &Rig, frame: &FrameObservations) -> Vec<(CameraId, Wrong)> {
    let Some(views) = Views::of(rig, frame) else { return Vec::new() };
    let shares = shares(&views).into_iter().zip(&frame.views);
    let wrong = shares.filter_map(|(Shares { lacks, alone, off }, (id, _))| {
        if lacks > LEAST_SHARE && lacks > MORE * off {
            Some((*id, Wrong::Lacks(lacks)))
        } else if alone > LEAST_SHARE && alone > MORE * lacks {
            Some((*id, Wrong::Holds(alone)))
        } else {
            None
        }
    });
    let wrong: Vec<(CameraId, Wrong)> = wrong.collect();
    if frame.views.len() - wrong.len() >= AGREEING { wrong } else { Vec::new() }
}

/// What the cameras show of one frame.
#[derive(Debug, Clone)]
pub(super) struct Views<'a> {
    views: Vec<View<'a>>,
    /// The middle of the person.
    subject: Point3<f64>,
}

impl<'a> Views<'a> {
    /// `None` if the cameras do not look at one place, or if they are too few to believe most of them.
    pub(super) fn of(rig: &'a Rig, frame: &'a FrameObservations) -> Option<Self> {
        let views: Vec<View<'a>> = View::of(rig, frame).collect();
        let subject = closest_point(&lines_of_sight(rig, frame));
        subject.filter(|_| views.len() > AGREEING).map(|subject| Self { views, subject })
    }

    /// What the cameras see along the line of sight of a pixel of one of them; `None` if that shows nothing.
    pub(super) fn sight(&self, camera: CameraId, pixel: &Point2<f64>) -> Option<Sight> {
        let own = self.views.iter().position(|view| view.id == camera)?;
        Some(self.sight_of(own, pixel))
    }

    fn sight_of(&self, own: usize, pixel: &Point2<f64>) -> Sight {
        Sight::along(&self.views[own].camera.ray(pixel), &self.subject, &self.views, own)
    }
}

/// A silhouette and its camera.
#[derive(Debug, Clone, Copy)]
pub(super) struct View<'a> {
    id: CameraId,
    pub(super) camera: &'a Camera,
    shown: &'a Silhouette,
}

impl<'a> View<'a> {
    /// What each camera shows.
    pub(super) fn of(rig: &'a Rig, frame: &'a FrameObservations) -> impl Iterator<Item = Self> {
        let views = frame.views.iter();
        views.map(|(id, shown)| Self { id: *id, camera: &rig.cameras[id.0], shown })
    }

    /// Where it shows a place; `None` where the camera does not look.
    pub(super) fn pixel(&self, place: &Point3<f64>) -> Option<Point2<f64>> {
        self.camera.project_undistorted(place).filter(|pixel| self.shown.sees(pixel))
    }

    /// Whether a place lies in its silhouette; `None` where the camera does not look.
    pub(super) fn holds(&self, place: &Point3<f64>) -> Option<bool> {
        Some(self.shown.contains(&self.pixel(place)?))
    }

    /// Whether something is seen at a place, with the border; `None` where the camera does not look.
    pub(super) fn sees(&self, place: &Point3<f64>) -> Option<bool> {
        let pixel = self.pixel(place)?;
        let depth_m = (self.camera.camera_from_world * place).z;
        let (outside_px, _) = self.shown.outside.sample(&pixel);
        Some(outside_px * depth_m < BORDER_M * self.camera.intrinsics.focal_px())
    }

    /// Pixels of the silhouette, evenly.
    fn pixels(&self) -> impl Iterator<Item = Point2<f64>> {
        let (low, high) = self.shown.bounds;
        let step = (self.shown.area_px / PIXELS).sqrt().max(1.0);
        let columns = ((high.x - low.x) / step).ceil() as usize;
        let rows = ((high.y - low.y) / step).ceil() as usize;
        let cell = move |i: usize| {
            let (column, row) = (i % columns, i / columns);
            Point2::new(low.x + (column as f64 + 0.5) * step, low.y + (row as f64 + 0.5) * step)
        };
        (0..rows * columns).map(cell).filter(|pixel| self.shown.contains(pixel))
    }
}

/// Of the person what a view lacks; of its pixels those that stand alone, and that are off.
#[derive(Debug, Clone, Copy, Default)]
struct Shares {
    lacks: f64,
    alone: f64,
    off: f64,
}

/// The shares of each view.
fn shares(seen_by: &Views<'_>) -> Vec<Shares> {
    let views = &seen_by.views;
    let seen = |own: usize| {
        let sights: Vec<Sight> =
            views[own].pixels().map(|pixel| seen_by.sight_of(own, &pixel)).collect();
        let share = |is_so: &dyn Fn(&Sight) -> bool| {
            sights.iter().filter(|s| is_so(s)).count() as f64 / sights.len().max(1) as f64
        };
        let lacked: Vec<f64> = (0..views.len()).map(|b| share(&|s| s.lacked[b])).collect();
        (lacked, Shares { lacks: 0.0, alone: share(&|s| s.is_alone), off: share(&|s| s.is_off) })
    };
    let seen: Vec<(Vec<f64>, Shares)> = (0..views.len()).map(seen).collect();

    let of_view = |b: usize| {
        let others = seen.iter().enumerate().filter(|(a, _)| *a != b);
        let lacks = median(&mut others.map(|(_, (lacked, _))| lacked[b]).collect());
        Shares { lacks: lacks.unwrap_or(0.0), ..seen[b].1 }
    };
    (0..views.len()).map(of_view).collect()
}

/// What the cameras see along the line of sight of a pixel.
#[derive(Debug, Clone)]
pub(super) struct Sight {
    is_alone: bool,
    pub(super) is_off: bool,
    /// View by view, whether it lacks what the others see.
    lacked: Vec<bool>,
}

impl Sight {
    fn along(ray: &Ray, subject: &Point3<f64>, views: &[View<'_>], own: usize) -> Self {
        let middle = (subject - ray.origin_world).dot(&ray.direction_world);
        let nobody = vec![false; views.len()];
        let (mut most, mut looking) = (0, 0);
        let mut lacked = nobody.clone();
        for t in outward(middle) {
            let place = ray.point_at(t);
            let of_view = |(b, view): (usize, &View<'_>)| {
                if b == own { Some(true) } else { view.sees(&place) }
            };
            let seen: Vec<Option<bool>> = views.iter().enumerate().map(of_view).collect();
            let looks = seen.iter().flatten().count();
            let sees = seen.iter().flatten().filter(|sees| **sees).count();
            looking = looking.max(looks);
            if sees >= AGREEING && sees == looks {
                return Self { is_alone: false, is_off: false, lacked: nobody };
            }

            // of places that equally many see, a view lacks what it sees at none
            let lacks = seen.iter().map(|sees| *sees == Some(false));
            if sees > most {
                (most, lacked) = (sees, lacks.collect());
            } else if sees == most {
                lacked.iter_mut().zip(lacks).for_each(|(lacked, lacks)| *lacked &= lacks);
            }
        }
        let is_believed = most >= AGREEING && 2 * most >= looking;
        let is_judged = looking >= AGREEING;
        Self {
            is_alone: is_judged && 2 * most < looking,
            is_off: is_judged && (most as f64) < NEARLY_ALL * looking as f64,
            lacked: if is_believed { lacked } else { nobody },
        }
    }
}

/// The places along a line of sight that are looked at, from the subject on.
fn outward(middle: f64) -> impl Iterator<Item = f64> {
    let steps = (REACH_M / STEP_M) as usize;
    let both = move |step: usize| {
        let away = step as f64 * STEP_M;
        [middle + away, middle - away]
    };
    (0..=steps).flat_map(both).filter(|t| *t > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Mask;
    use crate::pipeline::diagnosis::figures::Figures;

    /// What is said of a person whose masks are spoiled, and how many views are left of each frame.
    fn said(spoil: impl Fn(usize, &Mask) -> Mask, rig: impl Fn(&mut Rig)) -> (Vec<Cause>, usize) {
        let figures = Figures::new();
        let masks = figures.masks(&figures.standing(0.1, -0.1));
        let masks: Vec<Mask> = masks.iter().enumerate().map(|(c, m)| spoil(c, m)).collect();
        let frames = [figures.frame(0, &masks), figures.frame(1, &masks)];
        let mut calibrated = figures.rig.clone();
        rig(&mut calibrated);
        let parted = Parted::new(&calibrated, Cow::Borrowed(&frames));
        (parted.causes, parted.frames[1].views.len())
    }

    fn as_calibrated(_: &mut Rig) {}

    /// A mask without what lies below half of the person's height.
    fn half(mask: &Mask) -> Mask {
        let shown: Vec<usize> = (0..mask.height()).filter(|y| mask.row(*y).contains(&1)).collect();
        let middle = (shown[0] + shown[shown.len() - 1]) / 2;
        Mask::from_fn(mask.width(), mask.height(), |x, y| y < middle && mask.is_foreground(x, y))
    }

    #[test]
    fn masks_without_legs_are_left_out_and_named_while_three_are_whole() {
        let cameras = Figures::new().rig.cameras.len();
        let (causes, left) = said(|_, mask| mask.clone(), as_calibrated);
        assert_eq!((causes, left), (Vec::new(), cameras));

        for cut in [vec![1], vec![0, 3], (3..cameras).collect()] {
            let spoil =
                |c: usize, mask: &Mask| if cut.contains(&c) { half(mask) } else { mask.clone() };
            let (causes, left) = said(spoil, as_calibrated);
            assert_eq!(left, cameras - cut.len(), "{cut:?}: {causes:?}");
            let [Cause::PartsHidden { cameras, share }] = &causes[..] else { panic!("{causes:?}") };
            assert_eq!(cameras.len(), cut.len());
            assert!((0.2..0.6).contains(share), "{share}");
        }
    }

    #[test]
    fn what_only_one_mask_holds_is_left_out_with_it() {
        let wardrobe = |c: usize, mask: &Mask| {
            let (w, h) = (mask.width(), mask.height());
            let is_wardrobe = |x: usize, y: usize| (w / 8..w / 4).contains(&x) && y > h / 3;
            Mask::from_fn(w, h, |x, y| mask.is_foreground(x, y) || c == 2 && is_wardrobe(x, y))
        };
        let (causes, left) = said(wardrobe, as_calibrated);
        assert!(matches!(&causes[..], [Cause::PartsAlone { .. }]), "{causes:?}");
        assert_eq!(left, Figures::new().rig.cameras.len() - 1);
    }

    #[test]
    fn cameras_that_are_exchanged_keep_their_views() {
        let cameras = Figures::new().rig.cameras.len();
        let exchanged = |rig: &mut Rig| rig.cameras.swap(0, 3);
        assert_eq!(said(|_, mask| mask.clone(), exchanged), (Vec::new(), cameras));
    }

    #[test]
    fn a_camera_that_stands_elsewhere_or_zooms_is_not_taken_for_one_that_lacks_a_part() {
        let cameras = Figures::new().rig.cameras.len();
        let moved = |rig: &mut Rig| rig.cameras[1].camera_from_world.translation.vector.x += 0.4;
        let zoomed = |rig: &mut Rig| rig.cameras[1].intrinsics.fx_px *= 1.1;
        assert_eq!(said(|_, mask| mask.clone(), moved), (Vec::new(), cameras));
        assert_eq!(said(|_, mask| mask.clone(), zoomed), (Vec::new(), cameras));
    }
}
