//! What clinicians call angles and parameters, and which way each axis points.

use crate::gait::{Angle, Parameter};

/// How an angle is labelled.
#[derive(Debug, Clone, Copy)]
pub(super) struct Label {
    /// Heading of its chart.
    pub(super) title: &'static str,
    /// Short words for a negative and a positive value.
    pub(super) signs: (&'static str, &'static str),
    /// Least range of its chart, degrees.
    pub(super) range: (f64, f64),
}

impl Label {
    /// `Ext ‹ ° › Flex`.
    pub(super) fn axis(self) -> String {
        format!("{} ‹ ° › {}", self.signs.0, self.signs.1)
    }
}

/// The label of an angle.
pub(super) fn angle_label(angle: Angle) -> Label {
    let (title, signs, range) = match angle {
        Angle::PelvisTilt => ("Pelvic tilt", ("Post", "Ant"), (-10.0, 30.0)),
        Angle::PelvisObliquity => ("Pelvic obliquity", ("Down", "Up"), (-20.0, 20.0)),
        Angle::PelvisRotation => ("Pelvic rotation", ("Ext", "Int"), (-20.0, 20.0)),
        Angle::HipFlexion => ("Hip flexion", ("Ext", "Flex"), (-20.0, 60.0)),
        Angle::HipAdduction => ("Hip adduction", ("Abd", "Add"), (-20.0, 20.0)),
        Angle::HipRotation => ("Hip rotation", ("Ext", "Int"), (-30.0, 30.0)),
        Angle::KneeFlexion => ("Knee flexion", ("Ext", "Flex"), (-10.0, 80.0)),
        Angle::KneeAdduction => ("Knee adduction", ("Valg", "Var"), (-20.0, 20.0)),
        Angle::KneeRotation => ("Knee rotation", ("Ext", "Int"), (-30.0, 30.0)),
        Angle::AnkleDorsiflexion => ("Ankle dorsiflexion", ("Plan", "Dors"), (-30.0, 30.0)),
        Angle::FootProgression => ("Foot progression", ("Ext", "Int"), (-30.0, 30.0)),
        Angle::TrunkTilt => ("Trunk tilt", ("Post", "Ant"), (-20.0, 20.0)),
        Angle::TrunkObliquity => ("Trunk obliquity", ("Down", "Up"), (-20.0, 20.0)),
        Angle::TrunkRotation => ("Trunk rotation", ("Ext", "Int"), (-20.0, 20.0)),
        Angle::ShoulderFlexion => ("Shoulder flexion", ("Ext", "Flex"), (-40.0, 40.0)),
        Angle::ShoulderAdduction => ("Shoulder adduction", ("Abd", "Add"), (-30.0, 10.0)),
        Angle::ShoulderRotation => ("Shoulder rotation", ("Ext", "Int"), (-30.0, 30.0)),
        Angle::ElbowFlexion => ("Elbow flexion", ("Ext", "Flex"), (0.0, 60.0)),
    };

    Label { title, signs, range }
}

/// The name of a parameter.
pub(super) fn parameter_name(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::Speed => "Walking speed",
        Parameter::Cadence => "Cadence",
        Parameter::StrideLength => "Stride length",
        Parameter::StrideTime => "Stride time",
        Parameter::StepLength => "Step length",
        Parameter::StepTime => "Step time",
        Parameter::StepWidth => "Step width",
        Parameter::StanceTime => "Stance time",
        Parameter::SwingTime => "Swing time",
        Parameter::Stance => "Stance",
        Parameter::Swing => "Swing",
        Parameter::SingleSupport => "Single support",
        Parameter::DoubleSupport => "Double support, both",
    }
}

/// A name of a model or of a file as words: `upper_arm_r` is `upper arm r`.
pub(super) fn words(name: &str) -> String {
    name.replace('_', " ")
}
