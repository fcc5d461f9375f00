//! Who is in detections, where no silhouette tells.
//!
//! # One frame
//! Two pictures show the same person if their joints lie on lines of sight that meet. For person a of one camera and b of another, X_k the
//! point nearest to both lines of sight to joint k,
//!
//! d(a, b) = median_k ½(‖u_ak − π_a(X_k)‖/s_a + ‖u_bk − π_b(X_k)‖/s_b),
//!
//! s the person's size in each picture. So d has no unit of length, and a calibration in a wrong unit groups people as well. A joint may be
//! that of the other side: a detector exchanges them now and then. The sizes must agree too, s_a z_a/f_a ≈ s_b z_b/f_b, z the depth. A
//! group grows from a pair by those whose mean d to all of it is least, as long as that is below the limit, and of all such groups the one counts
//! first of whose n members n·(0.3 − mean d) is greatest. d < 0.3, some 20 cm at the person: two
//! people stand farther apart, and a camera that was turned by a degree, or is some frames late, still joins.
//!
//! # All frames
//! Groups of consecutive frames that lie nearest to each other are one person, if nobody had to run faster than 5 m/s for it. Who has half as
//! many pictures as the one who has most is somebody. Pictures that no group has, as where one camera alone sees the person, are added afterwards if they lie nearer than
//! 0.5 to the joints of the frames about them.
//!
//! # How large the person is
//! The box around the joints grows and shrinks with the pose and with what is hidden. A person's size in the world does not: it is the median
//! of s z/f over all pictures, and each picture's s follows from it.
//!
//! # Source
//! Grouping across cameras by what lines of sight miss each other by: Dong et al. 2019, *Fast and robust multi-person 3D pose estimation
//! from multiple views*. The limits: E.

mod groups;
mod scale;
mod tracks;

pub use scale::other_scale;
pub(super) use tracks::tracks;

use std::cmp::Reverse;
use std::collections::BTreeMap;

use nalgebra::Point3;
use rayon::prelude::*;

use self::groups::Group;
use super::people::{Presence, measured};
use crate::camera::{CameraId, Rig};
use crate::inference::joints::{Joints, twin};
use crate::math::stats::median;
use crate::silhouette::{Detection, FrameIndex, FrameObservations, FramePeople};

/// Persons whose joints lie farther from the expected ones than this, over their size, are others.
const FAR: f64 = 0.5;
/// Joints are expected where they were so many seconds before or after at most.
const MEMORY_S: f64 = 0.5;

/// One of the people in a recording.
#[derive(Debug, Clone)]
pub struct Person {
    /// What is seen of them, in every frame.
    pub detections: Vec<(FrameIndex, Vec<(CameraId, Detection)>)>,
    /// What else the detections show.
    pub beside: Beside,
}

/// What detections show besides a person.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Beside {
    /// How many other people are followed for half as long or longer.
    pub others: usize,
    /// Cameras with people none of whom is the one that the others see.
    pub cameras: Vec<String>,
    /// Pictures with people.
    pub pictures: usize,
}

/// The people who are seen by two cameras or more for half as long as the one seen longest, at most `most` of them; the one who is measured
/// comes [first](super::people()). Without any detection there is one of whom nothing is seen.
pub fn detected_people(rig: &Rig, frames: &[FramePeople], fps: f64, most: usize) -> Vec<Person> {
    // 1. the people of each frame, and over time
    let seen: Vec<Vec<Seen>> = frames.par_iter().map(Seen::of_frame).collect();
    let groups: Vec<_> = seen.par_iter().map(|people| groups::groups(rig, people)).collect();
    let times_s: Vec<f64> = frames.iter().map(|frame| frame.frame.0 as f64 / fps).collect();
    let middles = groups.iter().map(|frame| frame.iter().map(|g| g.joints.middle()).collect());
    let mut tracks = tracks(&middles.collect::<Vec<_>>(), &times_s);

    // 2. those who are in most pictures
    let support = |track: &BTreeMap<usize, usize>| -> usize {
        track.iter().map(|(frame, group)| groups[*frame][*group].members.len()).sum()
    };
    tracks.sort_by_key(|track| Reverse(support(track)));
    let longest = tracks.first().map_or(0, support);
    tracks.retain(|track| 2 * support(track) >= longest);
    let others = tracks.len().saturating_sub(1);
    tracks.truncate(most.max(1));
    if tracks.is_empty() {
        tracks.push(BTreeMap::new());
    }
    let presences: Vec<Presence> = tracks.iter().map(|track| presence(&groups, track)).collect();
    let measured = measured(&presences);
    tracks[..=measured].rotate_right(1);

    // 3. what is seen of each
    let recorded = Recorded { rig, frames, seen: &seen, groups: &groups, times_s: &times_s };
    tracks.iter().map(|track| recorded.person(track, others)).collect()
}

/// How long a person is seen, how far they walk, and how tall they are.
fn presence(groups: &[Vec<Group>], track: &BTreeMap<usize, usize>) -> Presence {
    let joints: Vec<&Joints> = track.iter().map(|(i, group)| &groups[*i][*group].joints).collect();
    let ends = joints.first().zip(joints.last());
    let height = |joints: &&Joints| {
        let heights = || joints.places.iter().map(|(_, place)| place.z);
        Some(heights().reduce(f64::max)? - heights().reduce(f64::min)?)
    };
    Presence {
        frames: track.len(),
        path_m: ends.map_or(0.0, |(a, b)| (b.middle() - a.middle()).xy().norm()),
        height_m: median(&mut joints.iter().filter_map(height).collect()).unwrap_or(0.0),
    }
}

/// All that detections show.
struct Recorded<'a> {
    rig: &'a Rig,
    frames: &'a [FramePeople],
    seen: &'a [Vec<Seen>],
    groups: &'a [Vec<Group>],
    times_s: &'a [f64],
}

impl Recorded<'_> {
    /// Everything that is seen of the person of a track.
    fn person(&self, track: &BTreeMap<usize, usize>, others: usize) -> Person {
        let Self { rig, frames, seen, groups, times_s } = *self;
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); frames.len()];
        let mut known: BTreeMap<usize, &Joints> = BTreeMap::new();
        for (frame, group) in track {
            members[*frame] = groups[*frame][*group].members.clone();
            known.insert(*frame, &groups[*frame][*group].joints);
        }

        // pictures of them that no group has
        for (i, people) in seen.iter().enumerate() {
            let of_others =
                groups[i].iter().enumerate().filter(|(group, _)| track.get(&i) != Some(group));
            let taken: Vec<usize> = of_others.flat_map(|(_, g)| g.members.clone()).collect();
            add_lone(rig, people, &expected(&known, times_s, i), &taken, &mut members[i]);
        }

        let detections = detections(rig, frames, seen, &members, &known);
        let beside = Beside {
            others,
            cameras: never_seen_by(rig, frames, &detections),
            pictures: frames.iter().map(|frame| frame.pictures.len()).sum(),
        };
        Person { detections, beside }
    }
}

impl Person {
    /// What is seen of the person, frame by frame.
    pub fn into_observations(self) -> Vec<FrameObservations> {
        let of_frame = |(frame, detections)| FrameObservations {
            detections,
            ..FrameObservations::nothing(frame)
        };
        self.detections.into_iter().map(of_frame).collect()
    }
}

/// One person in one picture.
struct Seen {
    camera: CameraId,
    detection: Detection,
}

impl Seen {
    fn of_frame(frame: &FramePeople) -> Vec<Self> {
        let of_picture = |(camera, people): &(CameraId, Vec<_>)| {
            let camera = *camera;
            let seen = move |person: &Vec<_>| {
                Detection::new(person.clone()).map(|detection| Self { camera, detection })
            };
            people.iter().filter_map(seen).collect::<Vec<Self>>()
        };
        frame.pictures.iter().flat_map(of_picture).collect()
    }

    /// How far the person's joints lie from expected ones, over their size: the median over the joints that both have.
    fn miss(&self, rig: &Rig, joints: &[(&'static str, Point3<f64>)]) -> Option<f64> {
        let camera = rig.camera(self.camera)?;
        let off = |name: &str, at: &Point3<f64>| {
            let seen = self.detection.keypoint(name)?;
            let at = camera.project_undistorted(at);
            let off = at.map_or(f64::INFINITY, |at| (seen.pixel - at).norm());
            Some(off / self.detection.size_px)
        };
        let least = |(name, at): &(&'static str, Point3<f64>)| {
            let both = [off(name, at), off(&twin(name), at)];
            both.into_iter().flatten().reduce(f64::min)
        };
        median(&mut joints.iter().filter_map(least).collect())
    }
}

/// The person's joints in a frame: those found there, or about where they are in the nearest frames before and after.
fn expected(
    known: &BTreeMap<usize, &Joints>,
    times_s: &[f64],
    frame: usize,
) -> Vec<(&'static str, Point3<f64>)> {
    let before = known.range(..=frame).next_back();
    let after = known.range(frame..).next();
    let is_near =
        |(other, _): &(&usize, &&Joints)| (times_s[**other] - times_s[frame]).abs() <= MEMORY_S;
    match (before.filter(is_near), after.filter(is_near)) {
        (Some((i, a)), Some((j, b))) if i < j => {
            let part = (times_s[frame] - times_s[*i]) / (times_s[*j] - times_s[*i]);
            let between = |(name, at): &(&'static str, Point3<f64>)| {
                Some((*name, at + (b.place(name)? - at) * part))
            };
            a.places.iter().filter_map(between).collect()
        }
        (Some((_, one)), _) | (None, Some((_, one))) => one.places.clone(),
        (None, None) => Vec::new(),
    }
}

/// Adds of each camera that the group has not the person who is nearest to the expected joints.
fn add_lone(
    rig: &Rig,
    people: &[Seen],
    joints: &[(&'static str, Point3<f64>)],
    taken: &[usize],
    members: &mut Vec<usize>,
) {
    let mut nearest: BTreeMap<CameraId, (f64, usize)> = BTreeMap::new();
    for (i, seen) in people.iter().enumerate() {
        let is_had = members.iter().any(|member| people[*member].camera == seen.camera);
        if is_had || taken.contains(&i) {
            continue;
        }
        if let Some(miss) = seen.miss(rig, joints).filter(|miss| *miss < FAR) {
            let best = nearest.entry(seen.camera).or_insert((miss, i));
            *best = if miss < best.0 { (miss, i) } else { *best };
        }
    }
    members.extend(nearest.values().map(|(_, i)| *i));
    members.sort_unstable();
}

/// What is seen of the person in each frame, as large as they are in the world.
fn detections(
    rig: &Rig,
    frames: &[FramePeople],
    seen: &[Vec<Seen>],
    members: &[Vec<usize>],
    known: &BTreeMap<usize, &Joints>,
) -> Vec<(FrameIndex, Vec<(CameraId, Detection)>)> {
    // px per m of each camera at the person
    let scale = |frame: usize, camera: CameraId| {
        let camera = rig.camera(camera)?;
        let depth_m = (camera.camera_from_world * known.get(&frame)?.middle()).z;
        (depth_m > 0.0).then(|| camera.intrinsics.focal_px() / depth_m)
    };
    let all = (0..frames.len()).flat_map(|i| members[i].iter().map(move |m| (i, &seen[i][*m])));
    let size = |(i, seen): (usize, &Seen)| Some(seen.detection.size_px / scale(i, seen.camera)?);
    let size_m = median(&mut all.filter_map(size).collect());

    let of_frame = |i: usize| {
        let detection = |member: &usize| {
            let Seen { camera, detection } = &seen[i][*member];
            let size_px = scale(i, *camera).zip(size_m).map(|(scale, size_m)| scale * size_m);
            let size_px = size_px.unwrap_or(detection.size_px);
            (*camera, Detection { size_px, ..detection.clone() })
        };
        (frames[i].frame, members[i].iter().map(detection).collect())
    };
    (0..frames.len()).map(of_frame).collect()
}

/// The cameras that show people and never the person.
fn never_seen_by(
    rig: &Rig,
    frames: &[FramePeople],
    detections: &[(FrameIndex, Vec<(CameraId, Detection)>)],
) -> Vec<String> {
    let shows = |id: CameraId| frames.iter().any(|f| f.pictures.iter().any(|(c, _)| *c == id));
    let sees = |id: CameraId| detections.iter().any(|(_, seen)| seen.iter().any(|(c, _)| *c == id));
    let never = rig.iter().filter(|(id, _)| shows(*id) && !sees(*id));
    never.map(|(_, camera)| camera.name.clone()).collect()
}

#[cfg(test)]
mod tests;
