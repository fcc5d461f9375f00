//! The angles of gait analysis: their names, and what a positive value means.

use serde::{Serialize, Serializer};

/// An angle of gait analysis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[expect(missing_docs, reason = "Angle::positive says what each is")]
pub enum Angle {
    PelvisTilt,
    PelvisObliquity,
    PelvisRotation,
    HipFlexion,
    HipAdduction,
    HipRotation,
    KneeFlexion,
    KneeAdduction,
    KneeRotation,
    AnkleDorsiflexion,
    FootProgression,
    TrunkTilt,
    TrunkObliquity,
    TrunkRotation,
    ShoulderFlexion,
    ShoulderAdduction,
    ShoulderRotation,
    ElbowFlexion,
}

impl Angle {
    /// All of them, from the pelvis down and then up.
    pub const ALL: [Self; 18] = [
        Self::PelvisTilt,
        Self::PelvisObliquity,
        Self::PelvisRotation,
        Self::HipFlexion,
        Self::HipAdduction,
        Self::HipRotation,
        Self::KneeFlexion,
        Self::KneeAdduction,
        Self::KneeRotation,
        Self::AnkleDorsiflexion,
        Self::FootProgression,
        Self::TrunkTilt,
        Self::TrunkObliquity,
        Self::TrunkRotation,
        Self::ShoulderFlexion,
        Self::ShoulderAdduction,
        Self::ShoulderRotation,
        Self::ElbowFlexion,
    ];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::PelvisTilt => "pelvis_tilt",
            Self::PelvisObliquity => "pelvis_obliquity",
            Self::PelvisRotation => "pelvis_rotation",

            Self::HipFlexion => "hip_flexion",
            Self::HipAdduction => "hip_adduction",
            Self::HipRotation => "hip_rotation",
            Self::KneeFlexion => "knee_flexion",
            Self::KneeAdduction => "knee_adduction",
            Self::KneeRotation => "knee_rotation",
            Self::AnkleDorsiflexion => "ankle_dorsiflexion",
            Self::FootProgression => "foot_progression",

            Self::TrunkTilt => "trunk_tilt",
            Self::TrunkObliquity => "trunk_obliquity",
            Self::TrunkRotation => "trunk_rotation",

            Self::ShoulderFlexion => "shoulder_flexion",
            Self::ShoulderAdduction => "shoulder_adduction",
            Self::ShoulderRotation => "shoulder_rotation",
            Self::ElbowFlexion => "elbow_flexion",
        }
    }

    /// What a positive value means.
    pub fn positive(self) -> &'static str {
        match self {
            Self::PelvisTilt | Self::TrunkTilt => {
                "forwards (OpenSim's pelvis_tilt has the other sign)"
            }
            Self::PelvisObliquity | Self::TrunkObliquity => "own side up",
            Self::PelvisRotation | Self::TrunkRotation => "own side forwards",
            Self::AnkleDorsiflexion => "dorsiflexion",
            Self::FootProgression => "toes inwards",
            Self::HipRotation | Self::KneeRotation | Self::ShoulderRotation => "internal",
            Self::HipAdduction | Self::ShoulderAdduction => "adduction",
            Self::KneeAdduction => "adduction (varus)",
            Self::HipFlexion | Self::KneeFlexion | Self::ShoulderFlexion | Self::ElbowFlexion => {
                "flexion"
            }
        }
    }

    /// The joint angle of a shipped body model, without its side, that has the same standard deviation.
    pub fn model_joint(self) -> Option<&'static str> {
        match self {
            Self::HipFlexion => Some("hip_flexion"),
            Self::HipAdduction => Some("hip_abduction"),
            Self::HipRotation => Some("hip_rotation"),
            Self::KneeFlexion => Some("knee_flexion"),
            Self::AnkleDorsiflexion => Some("ankle_dorsiflexion"),
            Self::ShoulderFlexion => Some("shoulder_flexion"),
            Self::ShoulderAdduction => Some("shoulder_abduction"),
            Self::ShoulderRotation => Some("shoulder_rotation"),
            Self::ElbowFlexion => Some("elbow_flexion"),
            _ => None,
        }
    }
}

impl Serialize for Angle {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}
