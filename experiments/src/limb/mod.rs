//! An arm before cameras: its truth, what they see of it, and how a fitted arm is measured against it (PF02, PFD99).

mod fit;
mod measure;
mod scene;

pub use fit::{Freedom, LimbFit, aligned, widened};
pub use measure::{Arm, LimbErrors, arm_errors, edges, joints, limb_errors};
pub use scene::{
    ArmTruth, ellipsoid_arm, front_pair, limb_arm, pose, surface_points, three_cameras, true_arm,
    views,
};
