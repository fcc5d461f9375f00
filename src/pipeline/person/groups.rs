//! The people of one frame: those of several pictures whose joints lie on lines of sight that meet.

use super::Seen;
use crate::camera::{Camera, Ray, Rig, closest_point};
use crate::inference::joints::{Joints, twin};
use crate::math::stats::{mean, median};
use crate::silhouette::Keypoint;

/// People of two pictures whose joints' lines of sight miss each other by more than this share of their size are not one.
const MISS: f64 = 0.3;
/// One person's sizes, as two cameras see them, differ by less than this factor.
const SIZES: f64 = 2.0;
/// Fewer joints in common do not tell.
const LEAST_COMMON: usize = 4;

/// One person as several cameras see them.
pub(super) struct Group {
    /// Positions among the people of all pictures of the frame, ascending.
    pub(super) members: Vec<usize>,
    pub(super) joints: Joints,
    /// The mean d of its pairs.
    pub(super) miss: f64,
}

/// The people of a frame, those whom most pictures agree about first.
pub(super) fn groups(rig: &Rig, people: &[Seen]) -> Vec<Group> {
    let misses = misses(rig, people);
    let mut taken = vec![false; people.len()];
    let mut groups = Vec::new();
    loop {
        let mut grown = grown(&misses, people, &taken);
        if grown.is_empty() {
            return groups;
        }
        grown.sort_by(|a, b| trust(b).total_cmp(&trust(a)));
        for (miss, mut members) in grown {
            if members.iter().any(|member| taken[*member]) {
                continue;
            }
            members.iter().for_each(|member| taken[*member] = true);
            members.sort_unstable();
            let seen = |member: &usize| (people[*member].camera, people[*member].detection.clone());
            let detections: Vec<_> = members.iter().map(seen).collect();
            let joints = Joints::new(rig, &detections);
            groups.extend(joints.map(|joints| Group { members, joints, miss }));
        }
    }
}

/// How far a group with this mean d can be trusted: Σ over its members of how much less than the limit they miss each other. A pair may agree
/// by chance, as two cameras that face each other do about two people on one line; who is seen by more cameras is not.
fn trust((miss, members): &(f64, Vec<usize>)) -> f64 {
    members.len() as f64 * (MISS - miss)
}

/// From each pair of people who are free, the group that it grows to, and its mean d.
fn grown(misses: &[Vec<Option<f64>>], people: &[Seen], taken: &[bool]) -> Vec<(f64, Vec<usize>)> {
    let free = || (0..people.len()).filter(|i| !taken[*i]);
    let pairs = free().flat_map(|i| free().take_while(move |j| *j < i).map(move |j| (i, j)));
    let grow = |(i, j): (usize, usize)| {
        misses[i][j].filter(|miss| *miss < MISS)?;
        let mut members = vec![j, i];
        while let Some(next) = joining(misses, people, taken, &members) {
            members.push(next);
        }
        let pairs = members.iter().flat_map(|a| members.iter().map(move |b| (*a, *b)));
        let all = pairs.filter(|(a, b)| b < a).map(|(a, b)| misses[a][b]);
        Some((mean(all.flatten())?, members))
    };
    pairs.filter_map(grow).collect()
}

/// The person of another camera who misses a group least, on the mean over its members.
fn joining(
    misses: &[Vec<Option<f64>>],
    people: &[Seen],
    taken: &[bool],
    members: &[usize],
) -> Option<usize> {
    let is_of_another =
        |i: &usize| members.iter().all(|member| people[*member].camera != people[*i].camera);
    let mean = |i: usize| {
        let all = members.iter().map(|member| misses[i.max(*member)][i.min(*member)]);
        let sum = all.sum::<Option<f64>>()?;
        Some((sum / members.len() as f64, i)).filter(|(miss, _)| *miss < MISS)
    };
    let free = (0..people.len()).filter(|i| !taken[*i]).filter(is_of_another);
    free.filter_map(mean).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
}

/// d of each person and those before, where it is known.
fn misses(rig: &Rig, people: &[Seen]) -> Vec<Vec<Option<f64>>> {
    let miss = |i: usize, j: usize| {
        let (a, b) = (&people[i], &people[j]);
        (a.camera != b.camera).then(|| Pair::new(rig, a, b)?.miss())?
    };
    (0..people.len()).map(|i| (0..i).map(|j| miss(i, j)).collect()).collect()
}

/// Two people of two cameras.
struct Pair<'a> {
    cameras: [&'a Camera; 2],
    people: [&'a Seen; 2],
}

impl<'a> Pair<'a> {
    fn new(rig: &'a Rig, a: &'a Seen, b: &'a Seen) -> Option<Self> {
        Some(Self { cameras: [rig.camera(a.camera)?, rig.camera(b.camera)?], people: [a, b] })
    }

    /// d; `None` where too little is seen by both, or the sizes differ.
    fn miss(&self) -> Option<f64> {
        let [own, others] = self.people.map(|seen| &seen.detection.keypoints);
        let mut depths: Vec<[f64; 2]> = Vec::new();
        let mut all = Vec::new();
        for keypoint in own {
            let twin = twin(keypoint.name);
            let alike = others.iter().filter(|k| k.name == keypoint.name || k.name == twin);
            let least = alike.filter_map(|other| self.meeting(keypoint, other));
            if let Some((miss, depth)) = least.min_by(|a, b| a.0.total_cmp(&b.0)) {
                all.push(miss);
                depths.push(depth);
            }
        }
        let sizes_m = [0, 1].map(|k| {
            let depth = median(&mut depths.iter().map(|d| d[k]).collect())?;
            let focal_px = self.cameras[k].intrinsics.focal_px();
            Some(self.people[k].detection.size_px * depth / focal_px)
        });
        let ratio = sizes_m[0]? / sizes_m[1]?;
        let is_one = all.len() >= LEAST_COMMON && ratio.max(1.0 / ratio) < SIZES;
        is_one.then(|| median(&mut all)).flatten()
    }

    /// How far the lines of sight to two keypoints miss each other, over the sizes, and at which depths; `None` behind a camera.
    fn meeting(&self, a: &Keypoint, b: &Keypoint) -> Option<(f64, [f64; 2])> {
        let pixels = [a.pixel, b.pixel];
        let rays: [Ray; 2] = [0, 1].map(|k| self.cameras[k].ray(&pixels[k]));
        let point = closest_point(&rays)?;
        let off = |k: usize| {
            let at = self.cameras[k].project_undistorted(&point)?;
            Some((pixels[k] - at).norm() / self.people[k].detection.size_px)
        };
        let depths = [0, 1].map(|k| (self.cameras[k].camera_from_world * point).z);
        Some((0.5 * (off(0)? + off(1)?), depths))
    }
}
