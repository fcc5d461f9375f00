//! Axes of the parts from the lines between joint centres and markers, and the angles that such lines cannot show.

use nalgebra::{Matrix3, Vector3};

use super::angle::Angle;
use super::complete::pelvis_frame;
use super::landmark::{Landmark, Paired, Side};
use super::movement::{Movement, Track};
use super::segments::{Axes, Limb, Segment, Segments, unknown};

/// How far the line from ankle to toe slopes down in a foot that stands flat: atan(0.055/0.180), as in `complete.rs`.
const FOOT_SLOPE: f64 = 0.2966;

impl Segments {
    /// The parts that places of the body show.
    pub(super) fn from_landmarks(movement: &Movement) -> Self {
        let mut segments = Self::default();
        segments.pelvis(movement);
        segments.trunk(movement);
        for side in Side::BOTH {
            segments.leg(movement, side);
            segments.arm(movement, side);
        }
        segments.list_unknown(movement);
        segments
    }

    fn pelvis(&mut self, movement: &Movement) {
        let axes = match movement.spines() {
            Some(spines) => {
                let frame = |[l, r, b]: &[Vector3<f64>; 3]| pelvis_frame(l, r, b);
                let frames = spines.iter().map(frame);
                frames.map(|frame| frame.unwrap_or(unknown())).collect()
            }

            None => {
                let hips = Side::BOTH.map(|side| movement.paired_track(side, Paired::Hip));
                let [Some(left), Some(right)] = hips else {
                    return;
                };
                let frame = |(l, r): (&Vector3<f64>, &Vector3<f64>)| axes_from_level_z(&(r - l));
                left.iter().zip(right).map(frame).collect()
            }
        };
        self.axes.insert(Segment::Pelvis, axes);
    }

    fn trunk(&mut self, movement: &Movement) {
        let shoulders = Side::BOTH.map(|side| movement.paired_track(side, Paired::Shoulder));
        let [Some(left), Some(right)] = shoulders else {
            return;
        };
        let Some(low) = movement.track(Landmark::MidHip) else {
            return;
        };
        let high: Track = match movement.track(Landmark::Neck) {
            Some(neck) => neck.clone(),
            None => left.iter().zip(right).map(|(l, r)| (l + r) * 0.5).collect(),
        };
        let axes =
            (0..movement.frames).map(|i| axes_from_y_z(&(high[i] - low[i]), &(right[i] - left[i])));
        self.axes.insert(Segment::Trunk, axes.collect());
    }

    fn leg(&mut self, movement: &Movement, side: Side) {
        let place = |place| movement.paired_track(side, place);
        let (Some(hip), Some(knee), Some(ankle), Some(toe), Some(pelvis)) = (
            place(Paired::Hip),
            place(Paired::Knee),
            place(Paired::Ankle),
            place(Paired::Toe),
            self.axes.get(&Segment::Pelvis),
        ) else {
            return;
        };

        let medial = place(Paired::KneeMedial);
        let medial_ankle = place(Paired::AnkleMedial);
        let heel = movement.has_heel_marker(side).then(|| place(Paired::Heel)).flatten();

        let mut axes: [Axes; 3] = Default::default();
        for i in 0..movement.frames {
            // the flexion axis: from the epicondyles where both are marked, else the pelvis' own right
            let right = match medial {
                Some(inner) => (knee[i] - inner[i]) * side.sign(),
                None => pelvis[i].column(2).into_owned(),
            };
            let thigh = axes_from_y_z(&(hip[i] - knee[i]), &right);
            let right = match medial_ankle {
                Some(inner) => (ankle[i] - inner[i]) * side.sign(),
                None => thigh.column(2).into_owned(),
            };
            let shank = axes_from_y_z(&(knee[i] - ankle[i]), &right);
            let right = shank.column(2).into_owned();
            let foot = match heel {
                Some(heel) => axes_from_x_z(&(toe[i] - heel[i]), &right),
                None => raised(&axes_from_x_z(&(toe[i] - ankle[i]), &right)),
            };
            for (all, one) in axes.iter_mut().zip([thigh, shank, foot]) {
                all.push(one);
            }
        }

        for (limb, axes) in [Limb::Thigh, Limb::Shank, Limb::Foot].into_iter().zip(axes) {
            self.axes.insert(Segment::Of(side, limb), axes);
        }
    }

    fn arm(&mut self, movement: &Movement, side: Side) {
        let place = |place| movement.paired_track(side, place);
        let (Some(shoulder), Some(elbow), Some(wrist), Some(trunk)) = (
            place(Paired::Shoulder),
            place(Paired::Elbow),
            place(Paired::Wrist),
            self.axes.get(&Segment::Trunk),
        ) else {
            return;
        };

        let mut axes: [Axes; 2] = Default::default();
        for i in 0..movement.frames {
            // an elbow bends about the normal of its plane; nearly straight it is taken to bend as the trunk does
            let (upper, lower) = (shoulder[i] - elbow[i], elbow[i] - wrist[i]);
            let normal = upper.cross(&lower);
            let bend = normal.norm() / (upper.norm() * lower.norm());
            let right = match bend > 0.17 {
                true => normal,
                false => trunk[i].column(2).into_owned(),
            };
            axes[0].push(axes_from_y_z(&upper, &right));
            axes[1].push(axes_from_y_z(&lower, &right));
        }

        for (limb, axes) in [Limb::UpperArm, Limb::Forearm].into_iter().zip(axes) {
            self.axes.insert(Segment::Of(side, limb), axes);
        }
    }

    /// Lists the angles that the places cannot show.
    fn list_unknown(&mut self, movement: &Movement) {
        if movement.spines().is_none() {
            let reason =
                "the hips alone do not show how the pelvis is tilted; it is taken to be upright";
            self.unknown.insert(Angle::PelvisTilt, reason);
        }

        let has =
            |place| Side::BOTH.iter().all(|side| movement.paired_track(*side, place).is_some());
        if !has(Paired::KneeMedial) {
            let reason =
                "the turn of a leg about itself needs a lateral and a medial marker on the knee";
            self.unknown.insert(Angle::HipRotation, reason);
        }
        if !has(Paired::KneeMedial) || !has(Paired::AnkleMedial) {
            let reason = "the axes of the shank need lateral and medial markers on knee and ankle";
            self.unknown.insert(Angle::KneeAdduction, reason);
            self.unknown.insert(Angle::KneeRotation, reason);
        }

        let reason = "the turn of an arm about itself is not shown by joint centres";
        self.unknown.insert(Angle::ShoulderRotation, reason);
    }
}

/// Axes with Y as given and Z as near as it can be.
fn axes_from_y_z(y: &Vector3<f64>, z: &Vector3<f64>) -> Matrix3<f64> {
    let axes = || {
        let y = y.try_normalize(1e-9)?;
        let z = (z - y * z.dot(&y)).try_normalize(1e-9)?;
        Some(Matrix3::from_columns(&[y.cross(&z), y, z]))
    };
    axes().unwrap_or(unknown())
}

/// Axes with Z as given and Y as upright as it can be.
fn axes_from_level_z(z: &Vector3<f64>) -> Matrix3<f64> {
    let axes = || {
        let z = z.try_normalize(1e-9)?;
        let x = Vector3::z().cross(&z).try_normalize(1e-9)?;
        Some(Matrix3::from_columns(&[x, z.cross(&x), z]))
    };
    axes().unwrap_or(unknown())
}

/// Axes with X as given and Z as near as it can be.
fn axes_from_x_z(x: &Vector3<f64>, z: &Vector3<f64>) -> Matrix3<f64> {
    let axes = || {
        let x = x.try_normalize(1e-9)?;
        let z = (z - x * z.dot(&x)).try_normalize(1e-9)?;
        Some(Matrix3::from_columns(&[x, z.cross(&x), z]))
    };
    axes().unwrap_or(unknown())
}

/// Axes whose X was the line from ankle to toe, turned up until it lies along the sole.
fn raised(axes: &Matrix3<f64>) -> Matrix3<f64> {
    axes * nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), FOOT_SLOPE).matrix()
}
