//! The verdict in one line, where something was found that the fit does not use.

use super::{Cause, Verdict};

impl Verdict {
    /// The verdict in one line, as [`Verdict::headline`]; of cameras that were found to be elsewhere and are taken as calibrated it says so.
    pub fn words(&self) -> Option<String> {
        let is_told = |cause: &Cause| matches!(cause, Cause::Touched { pose, .. } if !pose.used);
        if !self.is_usable() || !self.causes.iter().any(is_told) {
            return self.headline();
        }

        let words = |cause: &Cause| match is_told(cause) {
            true => cause.to_string().replace(USED, "(told, and not used: --cameras check)"),
            false => cause.to_string(),
        };
        Some(self.causes.iter().map(words).collect::<Vec<_>>().join("; "))
    }
}

/// What is said of cameras that the fit moves.
const USED: &str = "(taken into account)";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::PoseFound;

    #[test]
    fn what_is_told_and_not_used_is_said_to_be_so() {
        let touched = |used: bool| Cause::Touched {
            camera: "cam_02".into(),
            pose: Box::new(PoseFound {
                turn_deg: [1.0, 0.0, 0.0],
                turn_sd_deg: Some([0.1; 3]),
                displacement_m: [0.02, 0.0, 0.0],
                displacement_sd_m: Some([0.005; 3]),
                used,
            }),
        };
        let late = Cause::Clock { camera: "cam_03".into(), late_frames: 2.0, sd_frames: 0.1 };
        let words = |causes: Vec<Cause>| Verdict { unusable: Vec::new(), causes }.words().unwrap();
        let told = words(vec![touched(false), late]);
        assert!(told.contains("displaced by 20 ± 5 mm (told, and not used"), "{told}");
        assert!(
            told.ends_with("cam_03 is late by 2.0 ± 0.1 frames (taken into account)"),
            "{told}"
        );
        assert!(words(vec![touched(true)]).ends_with(USED));
    }
}
