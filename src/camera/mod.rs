//! Calibrated cameras: where a point of the world is seen, and where in the world a pixel looks.
//!
//! A [`Camera`] is a pose (`camera_from_world`), [`Intrinsics`] K and a lens [`Distortion`]. The camera frame is
//! right-handed with x right, y down, z forward, as in OpenCV; pixel (0, 0) is the centre of the top-left pixel.
//! Two kinds of pixel coordinates occur: **distorted** ones, as in the recorded image, and **undistorted** ones,
//! where the camera is exactly K·\[R|t\]. Contours, likelihoods and rays work in undistorted ones;
//! [`Camera::undistort`] and [`Camera::distort`] go from one to the other.
//!
//! A [`Rig`] is all cameras of a recording in one world; [`Rig::common_view`] says whether they look at one volume.
//! [`UpAxis`] converts between that world, with Z up, and those of files; [`PoseForm`] says what a file's R and t mean.
//! [`essential_matrices`] says how two cameras stand to each other whose lenses alone are known.
//! [`InfiniteHomography`] goes from the pixels of a camera to those of another at the same place.
//! [`check_projection`] is the law that every camera model here obeys.

mod check;
mod common_view;
mod distortion;
mod essential;
mod homography;
mod intrinsics;
mod pinhole;
mod pose_form;
mod ray;
mod rig;
mod up_axis;

pub use check::{ProjectionFault, check_projection};
pub use common_view::{Blindness, CommonView};
pub use distortion::Distortion;
pub use essential::{essential_matrices, poses_of_essential};
pub use homography::InfiniteHomography;
pub use intrinsics::Intrinsics;
pub use pinhole::Camera;
pub use pose_form::PoseForm;
pub use ray::{Ray, closest_point};
pub use rig::{CameraId, Rig};
pub use up_axis::UpAxis;
