//! C3D: what every gait laboratory reads.
//!
//! Floating-point, Intel byte order, millimetres, Y up. The residual of a point is its standard deviation (the root mean
//! square of the three axes, steps of 0.1 mm up to 25.5), −1 where it is missing; the camera mask has a bit for each of
//! the first seven cameras that saw the person. Angles are points of three numbers, degrees (flexion, adduction,
//! rotation), listed in `POINT:ANGLES`.
//!
//! # Source
//! The C3D File Format, user guide, Motion Lab Systems 2021.

use nalgebra::Vector3;

use crate::camera::UpAxis;
use crate::gait::{Angle, AngleTracks, Event, EventKind, Side};
use crate::pipeline::FittedPoint;

/// What is written.
#[derive(Debug, Clone)]
pub struct C3dInput<'a> {
    /// Frames per second.
    pub rate_hz: f64,
    /// Number of the first frame, from 0; the file counts from 1.
    pub first_frame: usize,
    /// Points over time with their standard deviations.
    pub points: &'a [FittedPoint],
    /// For each frame a bit for each camera that saw the person.
    pub cameras: &'a [u8],
    /// Angles over time.
    pub angles: &'a AngleTracks,
    /// Foot strikes and foot offs.
    pub events: &'a [Event],
}

/// Why there is no file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum C3dError {
    /// The format counts frames in 16 bits.
    #[error(
        "C3D holds at most 65535 frames and 255 points and angles: this has {frames} and {points}"
    )]
    TooLarge {
        /// Number of the last frame.
        frames: usize,
        /// Points and angles.
        points: usize,
    },
}

/// Bytes of a block.
const BLOCK: usize = 512;
/// Millimetres of one step of a residual; negative: coordinates are floats.
const SCALE: f32 = -0.1;

/// The angles of one point: flexion, adduction, rotation.
const TRIPLES: [(&str, [Option<Angle>; 3]); 8] = [
    (
        "PelvisAngles",
        [Some(Angle::PelvisTilt), Some(Angle::PelvisObliquity), Some(Angle::PelvisRotation)],
    ),
    ("HipAngles", [Some(Angle::HipFlexion), Some(Angle::HipAdduction), Some(Angle::HipRotation)]),
    (
        "KneeAngles",
        [Some(Angle::KneeFlexion), Some(Angle::KneeAdduction), Some(Angle::KneeRotation)],
    ),
    ("AnkleAngles", [Some(Angle::AnkleDorsiflexion), None, None]),
    ("FootProgressAngles", [None, None, Some(Angle::FootProgression)]),
    (
        "ThoraxAngles",
        [Some(Angle::TrunkTilt), Some(Angle::TrunkObliquity), Some(Angle::TrunkRotation)],
    ),
    (
        "ShoulderAngles",
        [
            Some(Angle::ShoulderFlexion),
            Some(Angle::ShoulderAdduction),
            Some(Angle::ShoulderRotation),
        ],
    ),
    ("ElbowAngles", [Some(Angle::ElbowFlexion), None, None]),
];

/// The bytes of a C3D file.
///
/// # Errors
/// [`C3dError::TooLarge`].
pub fn c3d(input: &C3dInput<'_>) -> Result<Vec<u8>, C3dError> {
    let angles = angle_points(input.angles);
    let count = input.points.len() + angles.len();
    let frames = input.points.first().map_or(0, |p| p.track.len());
    let last = input.first_frame + frames;
    if last > usize::from(u16::MAX) || count > 255 {
        let (frames, points) = (last, count);
        return Err(C3dError::TooLarge { frames, points });
    }

    // the parameters state where the data begin, which follows from their own length
    let mut parameters = parameters(input, &angles, frames, 0);
    let data_block = 2 + parameters.len() / BLOCK;
    parameters = self::parameters(input, &angles, frames, data_block as u16);

    let mut bytes = header(input, count as u16, last as u16, data_block as u16);
    bytes.extend(parameters);
    for frame in 0..frames {
        data(input, &angles, frame, &mut bytes);
    }

    bytes.resize(bytes.len().div_ceil(BLOCK) * BLOCK, 0);
    Ok(bytes)
}

/// Name and degrees of each point of angles.
fn angle_points(angles: &AngleTracks) -> Vec<(String, Vec<[f64; 3]>)> {
    let frames = angles.values().map(Vec::len).max().unwrap_or(0);
    let mut points = Vec::new();
    for side in Side::BOTH {
        for (name, triple) in TRIPLES {
            let tracks = triple.map(|angle| angles.get(&(side, angle?)));
            if tracks.iter().all(Option::is_none) {
                continue;
            }
            let at = |i: usize| tracks.map(|t| t.map_or(0.0, |t| t[i].to_degrees()));
            let letter = side.name()[..1].to_uppercase();
            points.push((format!("{letter}{name}"), (0..frames).map(at).collect()));
        }
    }
    points
}

fn header(input: &C3dInput<'_>, count: u16, last: u16, data_block: u16) -> Vec<u8> {
    let mut bytes = vec![0; BLOCK];
    let mut put = |word: usize, value: &[u8]| {
        bytes[2 * (word - 1)..2 * (word - 1) + value.len()].copy_from_slice(value);
    };
    put(1, &[2, 0x50]);
    put(2, &count.to_le_bytes());
    put(4, &(input.first_frame as u16 + 1).to_le_bytes());
    put(5, &last.to_le_bytes());
    put(7, &SCALE.to_le_bytes());
    put(9, &data_block.to_le_bytes());
    put(11, &(input.rate_hz as f32).to_le_bytes());
    bytes
}

fn data(
    input: &C3dInput<'_>,
    angles: &[(String, Vec<[f64; 3]>)],
    frame: usize,
    bytes: &mut Vec<u8>,
) {
    let mut push = |place: Vector3<f64>, mask: f32| {
        let is_there = place.iter().all(|v| v.is_finite());
        let place = if is_there { place } else { Vector3::zeros() };
        let last = if is_there { mask } else { -1.0 };
        for value in [place.x as f32, place.y as f32, place.z as f32, last] {
            bytes.extend(value.to_le_bytes());
        }
    };

    // fourth number: cameras in the high byte, the residual in steps of SCALE in the low one
    let cameras = f32::from(input.cameras.get(frame).copied().unwrap_or(0) & 0x7f);
    for point in input.points {
        let sd = point.sd_m[frame].norm() / 3_f64.sqrt();
        let sd = if sd.is_finite() { sd } else { 0.0 };
        let steps = (1e3 * sd / f64::from(SCALE.abs())).round().clamp(0.0, 255.0);
        push(1e3 * UpAxis::Y.to_export(&point.track[frame]), 256.0 * cameras + steps as f32);
    }

    for (_, track) in angles {
        push(Vector3::from(track[frame]), 0.0);
    }
}

/// The parameter blocks.
fn parameters(
    input: &C3dInput<'_>,
    angles: &[(String, Vec<[f64; 3]>)],
    frames: usize,
    data_block: u16,
) -> Vec<u8> {
    let rate = input.rate_hz as f32;
    let labels: Vec<&str> = input.points.iter().map(|p| p.name.as_str()).collect();
    let angle_labels: Vec<&str> = angles.iter().map(|(name, _)| name.as_str()).collect();
    let all = [labels, angle_labels.clone()].concat();
    let mut section = Section::default();

    section.group("POINT");
    section.integer("USED", all.len() as u16);
    section.integer("FRAMES", frames as u16);
    section.integer("DATA_START", data_block);
    section.float("SCALE", &[SCALE], &[]);
    section.float("RATE", &[rate], &[]);
    section.texts("UNITS", &["mm"]);
    section.texts("LABELS", &all);
    section.texts("DESCRIPTIONS", &vec![""; all.len()]);
    section.texts("ANGLES", &angle_labels);
    section.texts("ANGLE_UNITS", &["deg"]);
    section.texts("X_SCREEN", &["+Z"]);
    section.texts("Y_SCREEN", &["+Y"]);

    section.group("ANALOG");
    section.integer("USED", 0);
    section.float("RATE", &[0.0], &[]);
    section.float("GEN_SCALE", &[1.0], &[]);
    section.float("SCALE", &[], &[0]);
    section.integers("OFFSET", &[]);
    section.texts("LABELS", &[]);
    section.texts("UNITS", &[]);

    section.group("TRIAL");
    let field = |frame: usize| [frame as u16, (frame >> 16) as u16];
    section.integers("ACTUAL_START_FIELD", &field(input.first_frame + 1));
    section.integers("ACTUAL_END_FIELD", &field(input.first_frame + frames));
    section.float("CAMERA_RATE", &[rate], &[]);

    section.group("FORCE_PLATFORM");
    section.integer("USED", 0);

    events(&mut section, input.events);
    section.blocks()
}

fn events(section: &mut Section, events: &[Event]) {
    let contexts: Vec<&str> = events
        .iter()
        .map(|e| match e.side {
            Side::Left => "Left",
            Side::Right => "Right",
        })
        .collect();
    let labels: Vec<&str> = events
        .iter()
        .map(|e| match e.kind {
            EventKind::Strike => "Foot Strike",
            EventKind::Off => "Foot Off",
        })
        .collect();
    // minutes and seconds, with frame 0 at time 0
    let times: Vec<f32> = events
        .iter()
        .flat_map(|e| {
            let minutes = (e.time_s / 60.0).floor();
            [minutes as f32, (e.time_s - 60.0 * minutes) as f32]
        })
        .collect();
    section.group("EVENT");
    section.integer("USED", events.len() as u16);
    section.texts("CONTEXTS", &contexts);
    section.texts("LABELS", &labels);
    section.texts("SUBJECTS", &vec!["person"; events.len()]);
    section.float("TIMES", &times, &[2, events.len() as u8]);
}

/// Groups and their parameters, one after another.
#[derive(Default)]
struct Section {
    bytes: Vec<u8>,
    groups: u8,
    /// Where the offset of the last entry stands.
    last: usize,
}

impl Section {
    fn group(&mut self, name: &str) {
        self.groups += 1;
        let id = (-(self.groups as i8)) as u8;
        self.entry(name, id, &[]);
    }

    fn entry(&mut self, name: &str, id: u8, content: &[u8]) {
        self.bytes.extend([name.len() as u8, id]);
        self.bytes.extend(name.bytes());
        self.last = self.bytes.len();
        // from here to the next entry: itself, the content, and an empty description
        self.bytes.extend((2 + content.len() as u16 + 1).to_le_bytes());
        self.bytes.extend(content);
        self.bytes.push(0);
    }

    fn parameter(&mut self, name: &str, kind: i8, shape: &[u8], values: impl Iterator<Item = u8>) {
        let mut content = vec![kind as u8, shape.len() as u8];
        content.extend(shape);
        content.extend(values);
        self.entry(name, self.groups, &content);
    }

    fn integer(&mut self, name: &str, value: u16) {
        self.parameter(name, 2, &[], value.to_le_bytes().into_iter());
    }

    fn integers(&mut self, name: &str, values: &[u16]) {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes());
        self.parameter(name, 2, &[values.len() as u8], bytes);
    }

    fn float(&mut self, name: &str, values: &[f32], shape: &[u8]) {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes());
        self.parameter(name, 4, shape, bytes);
    }

    fn texts(&mut self, name: &str, texts: &[&str]) {
        let width = texts.iter().map(|t| t.len()).max().unwrap_or(0).clamp(1, 127);
        let padded =
            texts.iter().flat_map(|t| t.bytes().chain(std::iter::repeat(b' ')).take(width));
        self.parameter(name, -1, &[width as u8, texts.len() as u8], padded);
    }

    /// Whole blocks, with the section's own header.
    fn blocks(mut self) -> Vec<u8> {
        let end = self.last;
        self.bytes[end..end + 2].copy_from_slice(&[0, 0]);
        let count = (4 + self.bytes.len()).div_ceil(BLOCK);
        let mut blocks = vec![1, 0x50, count as u8, 84];
        blocks.extend(self.bytes);
        blocks.resize(count * BLOCK, 0);
        blocks
    }
}
