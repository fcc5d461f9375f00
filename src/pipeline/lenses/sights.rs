//! What each camera sees of each joint, in normalised image points: all that is known before any camera's place is.

use std::collections::BTreeMap;

use nalgebra::Point2;

use crate::camera::{CameraId, Rig};
use crate::likelihood::label_sigma_px;
use crate::silhouette::{Detection, FramePeople};

/// Of two people in a picture, the larger one is taken if the other is less than this share of their size; else neither.
const SMALLER: f64 = 0.5;

/// A joint in a picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sight {
    /// Normalised image point, undistorted.
    pub(super) at: Point2<f64>,
    /// Standard deviation of each coordinate.
    pub(super) sigma: f64,
}

/// Every sight of every joint.
#[derive(Debug, Clone)]
pub(super) struct Sights {
    /// The joints' names.
    pub(super) joints: Vec<&'static str>,
    /// How many frames.
    pub(super) frames: usize,
    /// By camera, then by [`Sights::joint`].
    pub(super) cameras: Vec<Vec<Option<Sight>>>,
    /// Pictures that show several people of about one size.
    pub(super) crowded: usize,
}

impl Sights {
    /// Of the person who is alone, or much larger than others, in each picture.
    pub(super) fn new(rig: &Rig, frames: &[FramePeople]) -> Self {
        let mut crowded = 0;
        let mut alone: Vec<(usize, CameraId, Detection)> = Vec::new();
        for (i, frame) in frames.iter().enumerate() {
            for (id, people) in &frame.pictures {
                match largest(people.iter().cloned().filter_map(Detection::new).collect()) {
                    Some(person) => alone.push((i, *id, person)),
                    None => crowded += usize::from(!people.is_empty()),
                }
            }
        }

        let of_all = alone.iter().flat_map(|(_, _, person)| &person.keypoints);
        let mut joints: Vec<&'static str> = of_all.map(|k| k.name).collect();
        joints.sort_unstable();
        joints.dedup();
        let index: BTreeMap<&str, usize> =
            joints.iter().enumerate().map(|(i, name)| (*name, i)).collect();

        let empty = vec![None; frames.len() * joints.len()];
        let mut cameras = vec![empty; rig.cameras.len()];
        for (i, id, person) in &alone {
            let Some(camera) = rig.camera(*id) else { continue };
            for seen in &person.keypoints {
                let sigma_px = label_sigma_px(seen.name, person.size_px, seen.confidence);
                let Some(joint) = index.get(seen.name) else { continue };
                cameras[id.0][i * joints.len() + joint] = Some(Sight {
                    at: camera.intrinsics.normalized(&seen.pixel).into(),
                    sigma: sigma_px / camera.intrinsics.focal_px(),
                });
            }
        }
        Self { frames: frames.len(), joints, cameras, crowded }
    }

    /// How many joints there are in all frames.
    pub(super) fn count(&self) -> usize {
        self.frames * self.joints.len()
    }

    /// Joints that both of two cameras see.
    pub(super) fn common(&self, a: usize, b: usize) -> Vec<usize> {
        let both =
            |joint: &usize| self.cameras[a][*joint].is_some() && self.cameras[b][*joint].is_some();
        (0..self.count()).filter(both).collect()
    }

    /// Those of some cameras alone.
    pub(super) fn only(&self, cameras: &[usize]) -> Self {
        let kept = cameras.iter().map(|camera| self.cameras[*camera].clone());
        Self { cameras: kept.collect(), joints: self.joints.clone(), ..*self }
    }

    /// Every standard deviation this many times as large.
    pub(super) fn scaled(&self, by: f64) -> Self {
        let mut scaled = self.clone();
        let all = scaled.cameras.iter_mut().flatten().flatten();
        all.for_each(|sight| sight.sigma *= by);
        scaled
    }

    /// At most so many of the frames, evenly.
    pub(super) fn thinned(&self, most: usize) -> Self {
        let stride = self.frames.div_ceil(most).max(1);
        let kept: Vec<usize> = (0..self.frames).step_by(stride).collect();
        let joints = self.joints.len();
        let of_camera = |all: &Vec<Option<Sight>>| {
            kept.iter().flat_map(|i| all[i * joints..(i + 1) * joints].iter().copied()).collect()
        };
        Self {
            joints: self.joints.clone(),
            frames: kept.len(),
            cameras: self.cameras.iter().map(of_camera).collect(),
            crowded: self.crowded,
        }
    }
}

/// The largest of some people, if the next is much smaller.
fn largest(mut people: Vec<Detection>) -> Option<Detection> {
    people.sort_by(|a, b| b.size_px.total_cmp(&a.size_px));
    let mut people = people.into_iter();
    let first = people.next()?;
    let is_alone = people.next().is_none_or(|next| next.size_px < SMALLER * first.size_px);
    is_alone.then_some(first)
}
