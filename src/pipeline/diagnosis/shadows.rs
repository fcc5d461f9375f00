//! Shadows on the floor: a picture of the empty room does not tell them from the person.
//!
//! Cameras on all sides see a place of the floor through the person only where the person stands; they all see a shadow. Let S(z) be the
//! places at height z where most of the cameras that look see something (of fewer than four all). Lines of sight that meet on the floor
//! part above and below it, so S is large at the floor where there is a shadow, and about as large at the floor as at the shins where
//! there is none. The floor is sought where
//!
//! f = argmax |S(z)| near argmax |S(z)| − |S(z + h)|,  h = [`SHIN_M`],
//!
//! summed over frames. A frame holds a shadow if S(f) is more than two feet cover and more than [`MORE`] times S(f + h), and somebody
//! stands there. If most frames do, it is taken out of all.
//!
//! A pixel *may show a shadow* where its line of sight meets the floor in F: that is S(f) with the border of masks, for cameras that were
//! touched or are late see a shadow elsewhere. A place above the floor is the person's if nearly all cameras that look see something
//! there, and half of them by pixels that cannot show a shadow. A pixel that may show a shadow, or lies next to such, shows the person
//! if its line of sight meets such a place. Whether the person is seen at the others is unknown, as where somebody else stands before
//! them. A border point counts where the pixel within shows the person, unless its own line of sight meets S(f): whatever it passes
//! before, that may be the border of a shadow.

use std::borrow::Cow;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

use nalgebra::{Point2, Point3};
use rayon::prelude::*;

use super::cause::Cause;
use super::level::Level;
use super::parts::{AGREEING, BORDER_M, View};
use super::shown_by_two;
use crate::camera::{Camera, Ray, Rig, closest_point};
use crate::inference::hull::{FORGIVING, lines_of_sight, nearly_all};
use crate::silhouette::{ContourPoint, FrameObservations};

/// Frames that are looked at first.
const SAMPLED_FRAMES: usize = 12;
/// The edge of a place, metres.
const CELL_M: f64 = 0.04;
/// How far around the middle of the person places are looked at, and how far a shadow may fall.
const REACH_M: f64 = 1.2;
const SHADOW_M: f64 = 3.0;
/// Places of the person lie at most so high above the floor.
const PERSON_M: f64 = 2.2;
/// The floor is sought so far below the middle of the person, in such steps, and so far from the first maximum at most.
const BELOW_M: Range<f64> = 0.5..1.4;
const HEIGHT_STEP_M: f64 = 0.02;
const NEAR_M: f64 = 0.1;
/// Shins are that high above the floor, and so is somebody who does not lie.
const SHIN_M: f64 = 0.3;
const STANDING_M: f64 = 1.0;
/// Two feet of 36 × 16 cm: those of the largest men, and a ragged mask's border.
const FEET_M2: f64 = 2.0 * 0.36 * 0.16;
/// What the floor shows is so many times what the shins do: a long skirt is as wide at both.
const MORE: f64 = 1.5;

/// A recording without the shadows that its masks hold.
#[derive(Debug, Clone)]
pub(super) struct WithoutShadows<'a> {
    pub(super) frames: Cow<'a, [FrameObservations]>,
    pub(super) cause: Option<Cause>,
}

impl<'a> WithoutShadows<'a> {
    pub(super) fn new(rig: &Rig, frames: Cow<'a, [FrameObservations]>) -> Self {
        let sampled = shown_by_two(&frames, SAMPLED_FRAMES).into_iter();
        let around: Vec<Around<'_>> = sampled.filter_map(|i| Around::of(rig, &frames[i])).collect();
        let Some(floor_m) = floor_m(&around) else { return Self { frames, cause: None } };
        let shaded = around.par_iter().filter(|around| around.has_shadow(floor_m)).count();
        if 2 * shaded <= around.len() {
            return Self { frames, cause: None };
        }

        let cleared: Vec<FrameObservations> =
            frames.par_iter().map(|frame| cleared(rig, frame, floor_m)).collect();
        let share = 1.0 - area_px(&cleared) / area_px(&frames);
        Self { frames: Cow::Owned(cleared), cause: Some(Cause::Shadows { share }) }
    }
}

/// How high the floor is, if there are shadows on it; `None` without frames.
fn floor_m(frames: &[Around<'_>]) -> Option<f64> {
    if frames.is_empty() {
        return None;
    }
    let middle = frames.iter().map(|around| around.subject.z).sum::<f64>() / frames.len() as f64;
    let steps = |length_m: f64| (length_m / HEIGHT_STEP_M).round() as usize;
    let (heights, shins, near) = (steps(BELOW_M.end - BELOW_M.start), steps(SHIN_M), steps(NEAR_M));
    let height_m = |step: usize| middle - BELOW_M.end + HEIGHT_STEP_M * step as f64;
    let seen_m2 = |step| frames.iter().map(|around| around.seen_m2(height_m(step))).sum();
    let seen: Vec<f64> = (0..heights + shins).into_par_iter().map(seen_m2).collect();

    let largest = |steps: Range<usize>, area: &dyn Fn(usize) -> f64| {
        steps.max_by(|a, b| area(*a).total_cmp(&area(*b)))
    };
    let about = largest(0..heights, &|step| seen[step] - seen[step + shins])?;
    let around = about.saturating_sub(near)..(about + near + 1).min(heights);
    largest(around, &|step| seen[step]).map(height_m)
}

/// A frame without what may show a shadow.
fn cleared(rig: &Rig, frame: &FrameObservations, floor_m: f64) -> FrameObservations {
    let Some(around) = Around::of(rig, frame) else { return frame.clone() };
    let shaded = Shaded::new(&around, floor_m);
    frame.with_views(|id, shown| {
        let camera = &rig.cameras[id.0];
        let shows_person = |pixel: &Point2<f64>| shaded.shows_person(&camera.ray(pixel));
        // a mask ends at its border
        let within_px = within_px(camera, &around.subject);
        let is_border = |point: &ContourPoint| {
            let within = point.pixel - point.normal * within_px;
            let is_sure = !shaded.shows_shadow(&camera.ray(&point.pixel));
            f64::from(u8::from(is_sure && shows_person(&within)))
        };
        shown.share(is_border, shows_person)
    })
}

/// Half a cell, in the picture.
fn within_px(camera: &Camera, subject: &Point3<f64>) -> f64 {
    let depth_m = (camera.camera_from_world * subject).z;
    0.5 * CELL_M * camera.intrinsics.focal_px() / depth_m
}

fn area_px(frames: &[FrameObservations]) -> f64 {
    frames.iter().flat_map(|frame| &frame.views).map(|(_, shown)| shown.area_px).sum()
}

/// What cameras on all sides of a person show.
struct Around<'a> {
    views: Vec<View<'a>>,
    /// The middle of the person.
    subject: Point3<f64>,
}

impl<'a> Around<'a> {
    /// `None` if the cameras do not look at one place, or are not on all sides of it.
    fn of(rig: &'a Rig, frame: &'a FrameObservations) -> Option<Self> {
        let subject = closest_point(&lines_of_sight(rig, frame))?;
        let views: Vec<View<'a>> = View::of(rig, frame).collect();
        are_on_all_sides(&views, &subject).then_some(Self { views, subject })
    }

    /// Whether most cameras that look see something at a place, of fewer than four all.
    fn most(&self, sees: impl Fn(&View<'a>) -> Option<bool>) -> bool {
        let (mut seeing, mut denying) = (0, 0);
        for sees in self.views.iter().filter_map(sees) {
            if sees {
                seeing += 1
            } else {
                denying += 1
            }
            if 2 * denying >= self.views.len() {
                return false;
            }
        }
        let all = seeing >= 2 && denying == 0;
        all || seeing >= AGREEING && seeing > denying
    }

    /// Where most cameras see something, at a height.
    fn level(
        &self,
        height_m: f64,
        reach_m: f64,
        sees: impl Fn(&View<'a>, &Point3<f64>) -> Option<bool>,
    ) -> Level {
        Level::new(&self.subject.xy(), reach_m, CELL_M, |place| {
            let place = Point3::new(place.x, place.y, height_m);
            self.most(|view| sees(view, &place))
        })
    }

    /// |S(z)|.
    fn seen_m2(&self, height_m: f64) -> f64 {
        self.level(height_m, REACH_M, View::holds).area_m2()
    }

    fn has_shadow(&self, floor_m: f64) -> bool {
        let floor_m2 = self.seen_m2(floor_m);
        floor_m2 > FEET_M2
            && floor_m2 > MORE * self.seen_m2(floor_m + SHIN_M)
            && self.seen_m2(floor_m + STANDING_M) > 0.0
    }
}

/// Whether no two neighbours around a place are half a turn apart, even without one of many.
fn are_on_all_sides(views: &[View<'_>], subject: &Point3<f64>) -> bool {
    let bearing = |view: &View<'_>| {
        let towards = view.camera.centre_world() - subject;
        towards.y.atan2(towards.x)
    };
    let mut bearings: Vec<f64> = views.iter().map(bearing).collect();
    bearings.sort_by(f64::total_cmp);
    let (count, next) = (bearings.len(), if bearings.len() >= FORGIVING { 2 } else { 1 });
    let gap = |i: usize| {
        let turns = ((i + next) / count) as f64;
        bearings[(i + next) % count] + turns * TAU - bearings[i]
    };
    count >= AGREEING && (0..count).all(|i| gap(i) < PI)
}

/// Where a frame shows shadows, and where the person.
struct Shaded {
    floor_m: f64,
    /// S(f), with a cell around.
    shadow: Level,
    /// F, and that with what lies next to it.
    floor: Level,
    near: Level,
    /// Places of the person, level by level from the floor up.
    person: Vec<Level>,
}

impl Shaded {
    fn new(around: &Around<'_>, floor_m: f64) -> Self {
        let shadow = around.level(floor_m, SHADOW_M, View::holds).widened(CELL_M);
        let floor = around.level(floor_m, SHADOW_M, View::sees);
        let near = floor.widened(BORDER_M);
        let mut shaded = Self { floor_m, shadow, floor, near, person: Vec::new() };
        let person = |level: usize| {
            let height_m = floor_m + (level as f64 + 0.5) * CELL_M;
            Level::new(&around.subject.xy(), REACH_M, CELL_M, |place| {
                shaded.is_person(&around.views, &Point3::new(place.x, place.y, height_m))
            })
        };
        shaded.person = (0..(PERSON_M / CELL_M) as usize).map(person).collect();
        shaded
    }

    /// Whether a place is the person's.
    fn is_person(&self, views: &[View<'_>], place: &Point3<f64>) -> bool {
        if !nearly_all(views.iter().filter_map(|view| view.holds(place))) {
            return false;
        }
        let may_be_shadow = |view: &View<'_>| {
            view.pixel(place).is_some_and(|p| self.meets(&self.floor, &view.camera.ray(&p)))
        };
        let looking = || views.iter().filter_map(|view| Some((view, view.holds(place)?)));
        let sure = looking().filter(|(view, holds)| *holds && !may_be_shadow(view)).count();
        looking().count() >= AGREEING && 2 * sure >= looking().count()
    }

    /// Whether a line of sight meets the floor in a level.
    fn meets(&self, level: &Level, ray: &Ray) -> bool {
        let is_in = |along: f64| level.contains(&ray.point_at(along).xy());
        ray.to_height(self.floor_m).is_some_and(is_in)
    }

    /// Whether a line of sight meets a shadow, whatever it passes before.
    fn shows_shadow(&self, ray: &Ray) -> bool {
        self.meets(&self.shadow, ray)
    }

    /// Whether a line of sight shows the person, and no shadow.
    fn shows_person(&self, ray: &Ray) -> bool {
        let to_floor = ray.to_height(self.floor_m).filter(|_| self.meets(&self.near, ray));
        let Some(to_floor) = to_floor else { return true };
        let step = 0.5 * CELL_M;
        let steps = (to_floor.min(2.0 * SHADOW_M) / step) as usize;
        (0..steps).any(|k| {
            let place = ray.point_at(to_floor - step * k as f64);
            let level = ((place.z - self.floor_m) / CELL_M) as usize;
            self.person.get(level).is_some_and(|level| level.contains(&place.xy()))
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use nalgebra::{Rotation3, Vector3};

    use super::*;
    use crate::camera::CameraId;
    use crate::image::Mask;
    use crate::pipeline::diagnosis::figures::{Figures, joined};

    /// The masks of a disk on the floor.
    fn disk(rig: &Rig, middle: Point2<f64>, radius_m: f64) -> Vec<Mask> {
        let mask = |camera: &Camera| {
            Mask::from_fn(camera.width_px as usize, camera.height_px as usize, |x, y| {
                let Some(pixel) = camera.undistort(&Point2::new(x as f64, y as f64)) else {
                    return false;
                };
                let ray = camera.ray(&pixel);
                ray.to_height(0.0).is_some_and(|along| {
                    nalgebra::distance(&ray.point_at(along).xy(), &middle) < radius_m
                })
            })
        };
        rig.cameras.iter().map(mask).collect()
    }

    /// A person who stands, with this beside them in all masks.
    fn beside(figures: &Figures, beside: &[Mask]) -> [FrameObservations; 1] {
        let person = figures.masks(&figures.standing(0.0, 0.0));
        [figures.frame(0, &joined(&person, beside))]
    }

    #[test]
    fn a_shadow_is_left_out_and_named_and_the_person_stays() {
        let figures = Figures::new();
        let alone = figures.frame(0, &figures.masks(&figures.standing(0.0, 0.0)));
        let shadow = disk(&figures.rig, Point2::new(0.5, 0.2), 0.4);
        let shown = beside(&figures, &shadow);
        let without = WithoutShadows::new(&figures.rig, Cow::Borrowed(&shown));
        let Some(Cause::Shadows { share }) = without.cause else { panic!("{:?}", without.cause) };
        assert!((0.1..0.5).contains(&share), "{share}");

        let mut beside = 0;
        for (k, (id, cleared)) in without.frames[0].views.iter().enumerate() {
            let camera = &figures.rig.cameras[id.0];
            let at = |place: Point3<f64>| camera.project_undistorted(&place).unwrap();
            let (in_shadow, person) = (at(Point3::new(0.7, 0.3, 0.0)), &alone.views[k].1);
            assert!(shown[0].views[k].1.contains(&in_shadow));
            if !person.contains(&in_shadow) {
                assert!(!cleared.contains(&in_shadow) && !cleared.sees(&in_shadow), "{k}");
                beside += 1;
            }
            assert!(cleared.contains(&at(Point3::new(0.0, 0.0, 1.1))));
            let ratio = cleared.area_px / person.area_px;
            assert!((0.85..1.02).contains(&ratio), "{k}: {ratio}");
        }
        assert!(2 * beside > figures.rig.cameras.len(), "{beside}");
    }

    #[test]
    fn somebody_who_stands_or_lies_without_a_shadow_stays_as_they_are() {
        let figures = Figures::new();
        let standing = figures.standing(0.3, 0.0);
        let mut lying = standing.clone();
        lying.world_from_root = Rotation3::new(Vector3::y() * FRAC_PI_2);
        lying.position_world = Vector3::new(0.0, 0.0, 0.12);
        for motion in [standing, lying] {
            let shown = [figures.frame(0, &figures.masks(&motion))];
            let without = WithoutShadows::new(&figures.rig, Cow::Borrowed(&shown));
            assert!(without.cause.is_none() && matches!(without.frames, Cow::Borrowed(_)));
        }
    }

    #[test]
    fn cameras_on_one_side_do_not_tell_a_shadow() {
        let figures = Figures::new();
        let shadow = disk(&figures.rig, Point2::new(0.5, 0.2), 0.4);
        let mut shown = beside(&figures, &shadow);
        shown[0].views.retain(|(CameraId(camera), _)| *camera < figures.rig.cameras.len() / 2);
        let without = WithoutShadows::new(&figures.rig, Cow::Borrowed(&shown));
        assert!(without.cause.is_none());
    }
}
