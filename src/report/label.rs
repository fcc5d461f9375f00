//! What clinicians call angles and parameters, and which way each axis points.

use super::Words;
use crate::gait::{Angle, Parameter, Side};

/// How an angle is labelled.
#[derive(Debug, Clone, Copy)]
pub(super) struct Label<'a> {
    /// Heading of its chart.
    pub(super) title: &'a str,
    /// Short words for a negative and a positive value.
    pub(super) signs: (&'a str, &'a str),
    /// Least range of its chart, degrees.
    pub(super) range: (f64, f64),
}

impl Label<'_> {
    /// `Ext ‹ ° › Flex`.
    pub(super) fn axis(self) -> String {
        format!("{} ‹ ° › {}", self.signs.0, self.signs.1)
    }
}

/// The label of an angle.
pub(super) fn angle_label(angle: Angle, words: &Words) -> Label<'_> {
    let flexion = (words.of("Ext"), words.of("Flex"));
    let adduction = (words.of("Abd"), words.of("Add"));
    let rotation = (words.of("Ext rot"), words.of("Int rot"));
    let tilt = (words.of("Post"), words.of("Ant"));
    let obliquity = (words.of("Down"), words.of("Up"));
    let varus = (words.of("Valg"), words.of("Var"));
    let dorsiflexion = (words.of("Plan"), words.of("Dors"));
    let (title, signs, range) = match angle {
        Angle::PelvisTilt => (words.of("Pelvic tilt"), tilt, (-10.0, 30.0)),
        Angle::PelvisObliquity => (words.of("Pelvic obliquity"), obliquity, (-20.0, 20.0)),
        Angle::PelvisRotation => (words.of("Pelvic rotation"), rotation, (-20.0, 20.0)),
        Angle::HipFlexion => (words.of("Hip flexion"), flexion, (-20.0, 60.0)),
        Angle::HipAdduction => (words.of("Hip adduction"), adduction, (-20.0, 20.0)),
        Angle::HipRotation => (words.of("Hip rotation"), rotation, (-30.0, 30.0)),
        Angle::KneeFlexion => (words.of("Knee flexion"), flexion, (-10.0, 80.0)),
        Angle::KneeAdduction => (words.of("Knee adduction"), varus, (-20.0, 20.0)),
        Angle::KneeRotation => (words.of("Knee rotation"), rotation, (-30.0, 30.0)),
        Angle::AnkleDorsiflexion => (words.of("Ankle dorsiflexion"), dorsiflexion, (-30.0, 30.0)),
        Angle::FootProgression => (words.of("Foot progression"), rotation, (-30.0, 30.0)),
        Angle::TrunkTilt => (words.of("Trunk tilt"), tilt, (-20.0, 20.0)),
        Angle::TrunkObliquity => (words.of("Trunk obliquity"), obliquity, (-20.0, 20.0)),
        Angle::TrunkRotation => (words.of("Trunk rotation"), rotation, (-20.0, 20.0)),
        Angle::ShoulderFlexion => (words.of("Shoulder flexion"), flexion, (-40.0, 40.0)),
        Angle::ShoulderAdduction => (words.of("Shoulder adduction"), adduction, (-30.0, 10.0)),
        Angle::ShoulderRotation => (words.of("Shoulder rotation"), rotation, (-30.0, 30.0)),
        Angle::ElbowFlexion => (words.of("Elbow flexion"), flexion, (0.0, 60.0)),
    };

    Label { title, signs, range }
}

/// The name of a parameter.
pub(super) fn parameter_name(parameter: Parameter, words: &Words) -> &str {
    match parameter {
        Parameter::Speed => words.of("Walking speed"),
        Parameter::Cadence => words.of("Cadence"),
        Parameter::StrideLength => words.of("Stride length"),
        Parameter::StrideTime => words.of("Stride time"),
        Parameter::StepLength => words.of("Step length"),
        Parameter::StepTime => words.of("Step time"),
        Parameter::StepWidth => words.of("Step width"),
        Parameter::StanceTime => words.of("Stance time"),
        Parameter::SwingTime => words.of("Swing time"),
        Parameter::Stance => words.of("Stance"),
        Parameter::Swing => words.of("Swing"),
        Parameter::SingleSupport => words.of("Single support"),
        Parameter::DoubleSupport => words.of("Double support, both"),
    }
}

/// A name of a model as words: `upper_arm` is `upper arm`.
pub(super) fn part_name(name: &str, words: &Words) -> String {
    words.known(&name.replace('_', " ")).to_owned()
}

/// The name of a side.
pub(super) fn side_name(side: Side, words: &Words) -> &str {
    words.known(side.name())
}
