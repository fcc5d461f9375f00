//! How far a fitted motion is from the truth, from joint centres alone.
//!
//! The figures of `mpjpe_mm`, `offset_mm`, `length_error_pct` and the angles are those that comparisons of
//! markerless systems report: raw, and with what two skeletons mean by the same joint taken away.

use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::io::points::trc::Trajectories;
use maquette::math::stats::mean;
use nalgebra::{Matrix3, Point3, Vector3};

/// The joints that are compared: those of arms and legs.
pub const LIMB_JOINTS: [&str; 12] = [
    "RHip",
    "RKnee",
    "RAnkle",
    "RShoulder",
    "RElbow",
    "RWrist",
    "LHip",
    "LKnee",
    "LAnkle",
    "LShoulder",
    "LElbow",
    "LWrist",
];

/// Percent of a standard normal, and within ± how many standard deviations they lie.
pub const INTERVALS: [(f64, f64); 3] = [(50.0, 0.674_490), (80.0, 1.281_552), (95.0, 1.959_964)];

/// Segments whose lengths are compared.
const SEGMENTS: [(&str, &str); 8] = [
    ("RHip", "RKnee"),
    ("RKnee", "RAnkle"),
    ("RShoulder", "RElbow"),
    ("RElbow", "RWrist"),
    ("LHip", "LKnee"),
    ("LKnee", "LAnkle"),
    ("LShoulder", "LElbow"),
    ("LElbow", "LWrist"),
];

/// The points of a body in motion.
pub fn trajectories(
    model: &BodyModel,
    shape: &Shape,
    motions: &[Motion],
    rate_hz: f64,
) -> Trajectories {
    let points = |motion| Posed::new(model, shape, motion).points().into_iter().map(Some).collect();
    Trajectories {
        rate_hz,
        first_frame: 0,
        names: model.points.iter().map(|p| p.name.clone()).collect(),
        frames: motions.iter().map(points).collect(),
    }
}

/// One frame of trajectories; `None` where there is no such frame.
pub fn only(of: &Trajectories, frame: usize) -> Option<Trajectories> {
    Some(Trajectories { frames: vec![of.frames.get(frame)?.clone()], ..of.clone() })
}

/// The trajectory of one point; `None` in frames without it, or for a name that is not there.
pub fn point(of: &Trajectories, name: &str, frame: usize) -> Option<Point3<f64>> {
    let index = of.names.iter().position(|n| n == name)?;
    *of.frames.get(frame)?.get(index)?
}

/// Mean distance of the limb joints in one frame, mm; `None` if none is in both.
pub fn frame_error_mm(truth: &Trajectories, fit: &Trajectories, frame: usize) -> Option<f64> {
    mean(
        LIMB_JOINTS
            .iter()
            .filter_map(|name| Some(1e3 * difference(truth, fit, name, frame)?.norm())),
    )
}

/// Mean distance of the limb joints over all frames, mm.
pub fn mpjpe_mm(truth: &Trajectories, fit: &Trajectories) -> Option<f64> {
    mean((0..truth.frames.len()).filter_map(|frame| frame_error_mm(truth, fit, frame)))
}

/// Root mean square of the limb joints' errors in standard deviations, √(mean of ⅓ eᵀΣ⁻¹e): 1 where the stated covariances are
/// right, 2 where errors are twice as large as stated.
///
/// `covariances` are those of the fit's points, square metres, frame by frame; `None` where they are withheld.
pub fn rms_z(
    truth: &Trajectories,
    fit: &Trajectories,
    covariances: &[Option<&[Matrix3<f64>]>],
) -> Option<f64> {
    let square = |frame: usize, name: &str| {
        let index = fit.names.iter().position(|n| n == name)?;
        let precision = covariances.get(frame)?.as_ref()?.get(index)?.cholesky()?.inverse();
        let error = difference(truth, fit, name, frame)?;
        Some(error.dot(&(precision * error)) / 3.0)
    };
    let frames = 0..truth.frames.len();
    let squares = frames.flat_map(|f| LIMB_JOINTS.iter().filter_map(move |n| square(f, n)));
    Some(mean(squares)?.sqrt())
}

/// Root mean square; NaN of no values.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    mean(values.into_iter().map(|value| value * value)).map_or(f64::NAN, f64::sqrt)
}

/// Share of errors, in standard deviations, that are not more than so many, %.
pub fn within_pct(errors: impl Iterator<Item = f64>, sds: f64) -> f64 {
    let (mut inside, mut all) = (0usize, 0usize);
    for error in errors {
        all += 1;
        inside += usize::from(error.abs() <= sds);
    }
    100.0 * inside as f64 / all.max(1) as f64
}

/// Distance of every limb joint in every frame, mm, after the joint's mean offset is taken away.
///
/// The offset is expressed in the frame of the limb that the joint opens, where a skeleton's own idea of
/// a joint centre is constant. Frame by frame, in the order of [`LIMB_JOINTS`].
pub fn offset_errors_mm(truth: &Trajectories, fit: &Trajectories) -> Vec<Vec<f64>> {
    let frames = truth.frames.len();
    let of_joint = |name: &&str| {
        let local = |frame| {
            Some(limb_axes(truth, name, frame)?.transpose() * difference(truth, fit, name, frame)?)
        };
        let local: Vec<Option<Vector3<f64>>> = (0..frames).map(local).collect();
        let known = local.iter().flatten().count().max(1) as f64;
        let offset = local.iter().flatten().sum::<Vector3<f64>>() / known;
        local
            .iter()
            .map(|d| d.map_or(f64::NAN, |d| 1e3 * (d - offset).norm()))
            .collect::<Vec<f64>>()
    };
    let joints: Vec<Vec<f64>> = LIMB_JOINTS.iter().map(of_joint).collect();
    (0..frames).map(|frame| joints.iter().map(|j| j[frame]).collect()).collect()
}

/// Mean of [`offset_errors_mm`].
pub fn offset_mm(truth: &Trajectories, fit: &Trajectories) -> Option<f64> {
    mean(offset_errors_mm(truth, fit).into_iter().flatten().filter(|e| e.is_finite()))
}

/// Mean |fit/truth − 1| of thighs, shanks, upper arms and forearms, percent.
pub fn length_error_pct(truth: &Trajectories, fit: &Trajectories) -> Option<f64> {
    mean(SEGMENTS.iter().filter_map(|(from, to)| {
        let ratio = mean_distance(fit, from, to)? / mean_distance(truth, from, to)?;
        Some(100.0 * (ratio - 1.0).abs())
    }))
}

/// Mean distance of two points over the frames, metres.
pub fn mean_distance(of: &Trajectories, from: &str, to: &str) -> Option<f64> {
    let distance = |frame| Some((point(of, from, frame)? - point(of, to, frame)?).norm());
    mean((0..of.frames.len()).filter_map(distance))
}

/// A flexion angle: how far three joints are from lying on a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Flexion(pub &'static str, pub &'static str, pub &'static str);

/// Flexion of the right and the left knee.
pub const KNEES: [Flexion; 2] =
    [Flexion("RHip", "RKnee", "RAnkle"), Flexion("LHip", "LKnee", "LAnkle")];
/// Of the hips, against the trunk's side.
pub const HIPS: [Flexion; 2] =
    [Flexion("RShoulder", "RHip", "RKnee"), Flexion("LShoulder", "LHip", "LKnee")];

impl Flexion {
    /// The angle in one frame, degrees: 0 when straight.
    pub fn deg(self, of: &Trajectories, frame: usize) -> Option<f64> {
        let [a, b, c] = [self.0, self.1, self.2].map(|name| point(of, name, frame));
        let (u, v) = (b? - a?, c? - b?);
        Some(u.angle(&v).to_degrees())
    }

    /// RMS difference over the frames, degrees.
    pub fn rms_deg(self, truth: &Trajectories, fit: &Trajectories) -> Option<f64> {
        let difference = |frame| Some((self.deg(fit, frame)? - self.deg(truth, frame)?).powi(2));
        mean((0..truth.frames.len()).filter_map(difference)).map(f64::sqrt)
    }
}

/// Mean RMS difference of several angles, degrees.
pub fn rms_deg(angles: &[Flexion], truth: &Trajectories, fit: &Trajectories) -> Option<f64> {
    mean(angles.iter().filter_map(|angle| angle.rms_deg(truth, fit)))
}

fn difference(
    truth: &Trajectories,
    fit: &Trajectories,
    name: &str,
    frame: usize,
) -> Option<Vector3<f64>> {
    Some(point(fit, name, frame)? - point(truth, name, frame)?)
}

/// Axes of the limb that a joint opens, as columns: z along the limb, y across the body's side.
fn limb_axes(of: &Trajectories, joint: &str, frame: usize) -> Option<Matrix3<f64>> {
    let (side, joint) = joint.split_at(1);
    let leg = ["Hip", "Knee", "Ankle"];
    let chain = if leg.contains(&joint) { leg } else { ["Shoulder", "Elbow", "Wrist"] };
    let [a, b, c] = chain.map(|name| point(of, &format!("{side}{name}"), frame));
    let along = if joint == chain[2] { c? - b? } else { b? - a? };
    let lateral =
        point(of, &format!("L{}", chain[0]), frame)? - point(of, &format!("R{}", chain[0]), frame)?;
    let z = along.try_normalize(1e-9)?;
    let y = z.cross(&lateral).try_normalize(1e-9)?;
    Some(Matrix3::from_columns(&[y.cross(&z), y, z]))
}

#[cfg(test)]
mod tests {
    use maquette::io::model;
    use nalgebra::DVector;

    use super::*;

    /// A person who bends knees and elbows, and walks along x.
    fn person(scale: f64) -> Trajectories {
        let model = model::load("human-ellipsoids", std::path::Path::new("")).unwrap();
        let mut shape = Shape(DVector::zeros(model.coefficients.len()));
        let thigh = model.coefficients.iter().position(|c| c == "thigh_length").unwrap();
        shape.0[thigh] = scale.ln();
        let motion = |i: usize| {
            let mut motion = Motion::rest(&model);
            motion.angles.add_scalar_mut(0.02 * i as f64);
            motion.position_world.x = 0.1 * i as f64;
            motion
        };
        trajectories(&model, &shape, &(0..10).map(motion).collect::<Vec<_>>(), 50.0)
    }

    #[test]
    fn the_truth_is_no_distance_from_itself() {
        let truth = person(1.0);
        assert_eq!(mpjpe_mm(&truth, &truth), Some(0.0));
        assert_eq!(offset_mm(&truth, &truth), Some(0.0));
        assert_eq!(length_error_pct(&truth, &truth), Some(0.0));
        assert_eq!(rms_deg(&KNEES, &truth, &truth), Some(0.0));
    }

    #[test]
    fn a_shift_is_an_error_that_the_offset_figure_forgives_only_in_part_as_limbs_turn() {
        let truth = person(1.0);
        let mut fit = truth.clone();
        for place in fit.frames.iter_mut().flatten().flatten() {
            place.y += 0.02;
        }
        approx_eq(mpjpe_mm(&truth, &fit), 20.0, 1e-9);
        assert!(offset_mm(&truth, &fit).unwrap() < 3.0);
    }

    #[test]
    fn ten_percent_of_two_segments_of_eight_is_two_and_a_half() {
        approx_eq(length_error_pct(&person(1.0), &person(1.1)), 2.5, 1e-9);
    }

    #[test]
    fn a_missing_point_is_left_out() {
        let truth = person(1.0);
        let mut fit = truth.clone();
        fit.frames[3].iter_mut().for_each(|place| *place = None);
        assert_eq!(frame_error_mm(&truth, &fit, 3), None);
        assert_eq!(mpjpe_mm(&truth, &fit), Some(0.0));
    }

    fn approx_eq(found: Option<f64>, expected: f64, tolerance: f64) {
        assert!((found.unwrap() - expected).abs() < tolerance, "{found:?}");
    }
}
