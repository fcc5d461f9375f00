//! `maquette stereo`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::error::CliError;
use super::fit::FrameRange;
use super::progress::Progress;
use super::summary::counted;
use super::{complain, print};
use crate::camera::CameraId;
use crate::image::{Mask, Picture, Plane, luma};
use crate::io::frames::Footage;
use crate::io::out_folder::{Existing, check_out};
use crate::io::recording::Recording;
use crate::io::stereo::StereoFolder;
use crate::render::stereo::{cloud_from_the_side, in_colour, vector_field};
use crate::silhouette::FrameIndex;
use crate::stereo::correlation::CorrelationOptions;
use crate::stereo::matching::{MatchOptions, MatchedPoint, match_surface};
use crate::stereo::tracking::{FilterOptions, Shown, TrackOptions, Tracker, Trajectory, filter};
use crate::stereo::{CloudPoint, SideBySide, View, depth_map};

pub(super) const ABOUT: &str = "\
Measure points of the surface from cameras that stand side by side.

Writes OUT/points/<frame>.ply with a covariance for each point, OUT/disparity/<frame>.png (16 bits, 256 steps a pixel, \
0 unknown) and, with --tracks, OUT/trajectories.csv. Where the recording has masks, only the person is measured. \
The points go into a fit by `points = \"points/%06d.ply\"` in sequence.toml.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette stereo my-recording --out out/points
  maquette stereo my-recording --out out/points --frames 0:99 --tracks --pictures
  maquette stereo my-recording --out out/points --method correlation --cameras left,right --depth 2:5";

/// Frames through which a set of points is followed, before a new one begins.
const TRACKED_FRAMES: usize = 10;

/// Arguments of `maquette stereo`.
#[derive(Debug, Args)]
pub(super) struct StereoArguments {
    /// Folder of the recording, or its sequence.toml
    recording: PathBuf,
    /// Folder to write into
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// How points are found
    #[arg(long, value_enum, default_value_t = Method::Matching)]
    method: Method,
    /// Only the frames of these numbers, both included [default: all]
    #[arg(long, value_name = "FIRST:LAST")]
    frames: Option<FrameRange>,
    /// Cameras, the template first [default: the one in the middle and those beside it]
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    cameras: Vec<String>,
    /// Nearest and farthest depth, metres [default: from a shift of a third of an image to infinity]
    #[arg(long, value_name = "NEAR:FAR", value_parser = depth)]
    depth: Option<(f64, f64)>,
    /// Distance of neighbouring points in the template's image, px (matching)
    #[arg(long, value_name = "PX", default_value_t = MatchOptions::default().spacing_px)]
    spacing: usize,
    /// Cameras besides the template that must show a point (matching) [default: all]
    #[arg(long, value_name = "COUNT")]
    least_cameras: Option<usize>,
    /// Follow the points through ten frames at a time (matching)
    #[arg(long)]
    tracks: bool,
    /// Write pictures: disparities in colour, the cloud from the side, the motion of the surface
    #[arg(long)]
    pictures: bool,
    /// Frames per second, where the recording does not say
    #[arg(long, value_name = "HZ")]
    fps: Option<f64>,
    /// Write into a folder that is not empty
    #[arg(long)]
    overwrite: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Method {
    /// Disparity of each pair by correlation: fast, a point for every pixel
    Correlation,
    /// Least-squares matching in all images at once: more exact
    Matching,
}

fn depth(text: &str) -> Result<(f64, f64), String> {
    let parsed = text.split_once(':').and_then(|(near, far)| {
        let (near, far): (f64, f64) = (near.trim().parse().ok()?, far.trim().parse().ok()?);
        (near > 0.0 && far > near && far.is_finite()).then_some((near, far))
    });
    parsed.ok_or_else(|| "expected NEAR:FAR, two depths in metres, the nearer first".into())
}

/// Measures and writes.
pub(super) fn run(arguments: &StereoArguments) -> Result<(), CliError> {
    // 1. read and check everything
    let existing = if arguments.overwrite {
        Existing::Overwrite
    } else {
        Existing::Refuse
    };
    check_out(&arguments.out, existing)?;
    let footage = Footage::open(&arguments.recording, arguments.fps)?;
    let frames = asked_frames(&footage, arguments.frames)?;
    let mut work = Work {
        arguments,
        cameras: cameras(&footage, &arguments.cameras)?,
        masks: Recording::open(&arguments.recording, arguments.fps.or(Some(footage.fps))).ok(),
        out: StereoFolder::open(&arguments.out)?,
        footage: &footage,
        following: None,
        trajectories: Vec::new(),
        points: 0,
        skipped: Vec::new(),
    };
    if !arguments.quiet {
        footage
            .notes
            .iter()
            .for_each(|note| complain("note", &note.to_string()));
        if work.masks.is_none() {
            complain(
                "note",
                "no masks: everything that the cameras show is measured, not the person alone",
            );
        }
    }
    // 2. frame by frame
    let progress = if arguments.quiet {
        Progress::Hidden
    } else {
        Progress::Shown
    };
    let bar = progress.bar("stereo", frames.len());
    let mut sets = footage.frame_sets(frames[0].0..=frames[frames.len() - 1].0);
    for (frame, pictures) in sets.by_ref() {
        work.frame(frame, &pictures)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    // 3. what was found
    work.finish()?;
    if !arguments.quiet {
        sets.notes()
            .iter()
            .for_each(|note| complain("note", &note.to_string()));
        work.report(frames.len());
    }
    Ok(())
}

fn asked_frames(footage: &Footage, range: Option<FrameRange>) -> Result<Vec<FrameIndex>, CliError> {
    let all = footage.frames();
    let (Some(first), Some(last)) = (all.first(), all.last()) else {
        return Err(CliError::Arguments(format!(
            "{}: no frames",
            footage.folder.display()
        )));
    };
    let Some(range) = range else { return Ok(all) };
    let in_range: Vec<FrameIndex> = all
        .iter()
        .filter(|f| (range.first..=range.last).contains(&f.0))
        .copied()
        .collect();
    if in_range.is_empty() {
        let (first, last) = (first.0, last.0);
        return Err(CliError::NoFrames {
            range: format!("{}:{}", range.first, range.last),
            first,
            last,
        });
    }
    Ok(in_range)
}

/// The template's camera and the others.
fn cameras(footage: &Footage, asked: &[String]) -> Result<Vec<CameraId>, CliError> {
    if asked.is_empty() {
        let chosen = SideBySide::of(&footage.rig).map_err(|e| CliError::Stereo(e.to_string()))?;
        return Ok(std::iter::once(chosen.template)
            .chain(chosen.others)
            .collect());
    }
    let known = footage.rig.names().collect::<Vec<_>>().join(", ");
    let found = asked.iter().map(|name| {
        let found = footage.rig.by_name(name.trim()).map(|(id, _)| id);
        found.ok_or_else(|| {
            CliError::Stereo(format!(
                "--cameras {name}: no such camera: the recording has {known}"
            ))
        })
    });
    let found = found.collect::<Result<Vec<_>, _>>()?;
    let different = found
        .iter()
        .collect::<std::collections::BTreeSet<_>>()
        .len()
        == found.len();
    if found.len() < 2 || !different {
        return Err(CliError::Stereo(format!(
            "--cameras {}: expected two different cameras or more",
            asked.join(",")
        )));
    }
    Ok(found)
}

/// The points that are followed.
struct Following {
    tracker: Tracker,
    first: usize,
    last: usize,
    /// What the template's camera showed first.
    view: View,
}

/// A run.
struct Work<'a> {
    arguments: &'a StereoArguments,
    footage: &'a Footage,
    /// The template's camera first.
    cameras: Vec<CameraId>,
    masks: Option<Recording>,
    out: StereoFolder,
    following: Option<Following>,
    trajectories: Vec<Trajectory>,
    points: usize,
    /// Frames without a point, and why.
    skipped: Vec<(usize, String)>,
}

impl Work<'_> {
    fn frame(&mut self, frame: FrameIndex, pictures: &[Option<Picture>]) -> Result<(), CliError> {
        let shown = match self.shown(frame, pictures) {
            Ok(shown) => shown,
            Err(reason) => {
                self.skipped.push((frame.0, reason));
                return self.end_tracks();
            }
        };
        let found = match self.arguments.method {
            Method::Correlation => self.correlate(frame.0, &shown)?,
            Method::Matching => self.match_all(frame.0, shown)?,
        };
        if found == 0 {
            let reason = "nothing was matched: no texture, or the cameras do not see the same";
            self.skipped.push((frame.0, reason.into()));
        }
        self.points += found;
        Ok(())
    }

    /// The views and masks of the cameras used; why not, where a picture is missing.
    fn shown(&self, frame: FrameIndex, pictures: &[Option<Picture>]) -> Result<Shown, String> {
        let mut shown = Shown {
            views: Vec::new(),
            masks: Vec::new(),
        };
        for id in &self.cameras {
            let picture = pictures.get(id.0).and_then(Option::as_ref);
            let (Some(picture), Some(camera)) = (picture, self.footage.rig.camera(*id)) else {
                return Err("a camera has no picture".into());
            };
            shown
                .views
                .push(View::of(camera, &luma(picture)).map_err(|e| e.to_string())?);
            shown.masks.push(self.mask(&camera.name, frame)?);
        }
        Ok(shown)
    }

    fn mask(&self, camera: &str, frame: FrameIndex) -> Result<Option<Mask>, String> {
        let Some(recording) = &self.masks else {
            return Ok(None);
        };
        let Some((id, _)) = recording.rig.by_name(camera) else {
            return Ok(None);
        };
        recording.load_mask(id, frame).map_err(|e| e.to_string())
    }

    /// Every pair of the template and another camera.
    fn correlate(&mut self, frame: usize, shown: &Shown) -> Result<usize, CliError> {
        let mut points = Vec::new();
        for (i, other) in shown.views[1..].iter().enumerate() {
            let (template, mask) = (&shown.views[0], shown.masks[0].as_ref());
            let map = depth_map(
                template,
                other,
                mask,
                self.arguments.depth,
                &CorrelationOptions::default(),
            );
            let map = map.map_err(|e| CliError::Stereo(e.to_string()))?;
            let infinity =
                map.pair.left.camera.intrinsics.cx_px - map.pair.right.camera.intrinsics.cx_px;
            let disparities = map.disparities.map(|d| (d - infinity as f32).abs());
            let name = format!("{frame:06}_{}", i + 1);
            self.out.disparity(&name, &disparities)?;
            if self.arguments.pictures {
                self.out
                    .picture(&format!("disparity_{name}"), &in_colour(&disparities))?;
            }
            points.extend(map.points);
        }
        self.write_points(frame, &shown.views[0], &points)?;
        Ok(points.len())
    }

    /// The template in all other images.
    fn match_all(&mut self, frame: usize, shown: Shown) -> Result<usize, CliError> {
        let options = self.options();
        let (template, others) = (&shown.views[0], shown.views[1..].iter().collect::<Vec<_>>());
        let found = match_surface(template, &others, shown.masks[0].as_ref(), &[], &options);
        let found = found.map_err(|e| CliError::Stereo(e.to_string()))?;
        let disparities = disparities(template, others[0], &found.points);
        self.out.disparity(&format!("{frame:06}"), &disparities)?;
        if self.arguments.pictures {
            self.out
                .picture(&format!("disparity_{frame:06}"), &in_colour(&disparities))?;
        }
        let points: Vec<CloudPoint> = found.points.iter().map(|point| point.point).collect();
        self.write_points(frame, template, &points)?;
        if self.arguments.tracks {
            self.follow(frame, shown, &found.points)?;
        }
        Ok(points.len())
    }

    fn options(&self) -> MatchOptions {
        MatchOptions {
            spacing_px: self.arguments.spacing,
            least_images: self
                .arguments
                .least_cameras
                .unwrap_or(self.cameras.len() - 1),
            depth: self.arguments.depth,
            ..MatchOptions::default()
        }
    }

    fn write_points(
        &self,
        frame: usize,
        template: &View,
        points: &[CloudPoint],
    ) -> Result<(), CliError> {
        self.out.points(frame, points)?;
        if self.arguments.pictures {
            let cloud = cloud_from_the_side(&template.camera, points);
            self.out.picture(&format!("cloud_{frame:06}"), &cloud)?;
        }
        Ok(())
    }

    /// Follows the points into this frame; every tenth frame ends the tracks and begins new ones.
    fn follow(
        &mut self,
        frame: usize,
        shown: Shown,
        points: &[MatchedPoint],
    ) -> Result<(), CliError> {
        let fault = |e: crate::stereo::matching::MatchError| CliError::Stereo(e.to_string());
        if let Some(following) = self.following.as_mut().filter(|f| f.last + 1 == frame) {
            following.tracker.advance(shown.clone()).map_err(fault)?;
            following.last = frame;
        }
        let goes_on = |f: &Following| f.last == frame && f.first + TRACKED_FRAMES > frame;
        if !self.following.as_ref().is_some_and(goes_on) {
            self.end_tracks()?;
            let options = TrackOptions {
                spatial: self.options(),
                ..TrackOptions::default()
            };
            let view = shown.views[0].clone();
            let tracker = Tracker::start(frame, shown, points, options).map_err(fault)?;
            self.following = Some(Following {
                tracker,
                first: frame,
                last: frame,
                view,
            });
        }
        Ok(())
    }

    /// Filters the trajectories that were followed, and keeps them.
    fn end_tracks(&mut self) -> Result<(), CliError> {
        let Some(Following {
            tracker,
            first,
            view,
            ..
        }) = self.following.take()
        else {
            return Ok(());
        };
        let filtered = filter(&tracker.finish(self.footage.fps), &FilterOptions::default());
        if self.arguments.pictures {
            let points: Vec<_> = filtered
                .trajectories
                .iter()
                .filter_map(|t| t.at(first + 1).copied())
                .collect();
            self.out.picture(
                &format!("vectors_{first:06}"),
                &vector_field(&view.camera, &view.image, &points),
            )?;
        }
        self.trajectories.extend(filtered.trajectories);
        Ok(())
    }

    fn finish(&mut self) -> Result<(), CliError> {
        self.end_tracks()?;
        if self.arguments.tracks {
            self.out.trajectories(&self.trajectories)?;
        }
        Ok(())
    }

    fn report(&self, frames: usize) {
        if let Some((frame, reason)) = self.skipped.first() {
            let count = counted(self.skipped.len(), "frame");
            complain(
                "note",
                &format!("{count} without points, frame {frame} first: {reason}"),
            );
        }
        let out = self.arguments.out.display();
        let points = self.points / frames.max(1);
        print(&format!(
            "{out}: {}, {points} points each\n",
            counted(frames, "frame")
        ));
        if self.arguments.tracks {
            print(&format!(
                "{out}/trajectories.csv: {} trajectories\n",
                self.trajectories.len()
            ));
        }
    }
}

/// The shift of each point against one at infinity, as a pair side by side would show it: f·B/Z, px.
fn disparities(template: &View, other: &View, points: &[MatchedPoint]) -> Plane<f32> {
    let camera = &template.camera;
    let base =
        (camera.centre_world() - other.camera.centre_world()).norm() * camera.intrinsics.fx_px;
    let mut plane = Plane::filled(template.image.width(), template.image.height(), f32::NAN);
    for point in points {
        let depth = (camera.camera_from_world * point.point.position_world).z;
        let (x, y) = point.pixel;
        if let Some(disparity) = plane.row_mut(y).get_mut(x) {
            *disparity = (base / depth) as f32;
        }
    }
    plane
}
