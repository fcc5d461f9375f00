//! What a fit is compared by.

use maquette::body::Motion;
use maquette::io::points::trc::Trajectories;
use maquette::pipeline::Fit;

use crate::metrics::{
    INTERVALS, KNEES, LIMB_JOINTS, length_error_pct, mpjpe_mm, offset_mm, point, rms_deg,
    trajectories, within_pct,
};

/// How far a fit is from the truth, and how far in its own standard deviations.
#[derive(Debug, Clone)]
pub struct Figures {
    /// Mean distance of the joint centres, mm.
    pub raw_mm: f64,
    /// The same without a constant offset of each joint.
    pub offset_mm: f64,
    /// How far lengths are off, %.
    pub lengths_pct: f64,
    /// The same of the knees, °.
    pub knee_deg: f64,
    /// Errors of the joint centres along the axes of the world, in their standard deviations.
    pub z: Vec<f64>,
}

impl Figures {
    /// Of a recording at `fps` frames per second.
    pub fn new(truth: &Trajectories, fit: &Fit, fps: f64) -> Self {
        let fitted = fitted(fit, fps);
        let some = |figure: Option<f64>| figure.unwrap_or(f64::NAN);
        Self {
            raw_mm: some(mpjpe_mm(truth, &fitted)),
            offset_mm: some(offset_mm(truth, &fitted)),
            lengths_pct: some(length_error_pct(truth, &fitted)),
            knee_deg: some(rms_deg(&KNEES, truth, &fitted)),
            z: errors_in_sd(truth, &fitted, fit),
        }
    }
}

/// The joint centres of a fit.
pub fn fitted(fit: &Fit, fps: f64) -> Trajectories {
    let motions: Vec<Motion> = fit.frames.iter().map(|f| f.fit.motion.clone()).collect();
    trajectories(&fit.model, &fit.shape, &motions, fps)
}

fn errors_in_sd(truth: &Trajectories, fitted: &Trajectories, fit: &Fit) -> Vec<f64> {
    let index = |name: &str| fitted.names.iter().position(|n| n == name);
    let joints: Vec<(&str, usize)> =
        LIMB_JOINTS.iter().filter_map(|name| Some((*name, index(name)?))).collect();
    let of_frame = |frame: usize| {
        let uncertainty = fit.frames[frame].uncertainty.as_ref();
        uncertainty.into_iter().flat_map({
            let joints = &joints;
            move |uncertainty| {
                joints.iter().filter_map(move |(name, index)| {
                    let error = point(fitted, name, frame)? - point(truth, name, frame)?;
                    let sd = uncertainty.points[*index].diagonal().map(f64::sqrt);
                    Some(error.component_div(&sd))
                })
            }
        })
    };
    (0..fit.frames.len()).flat_map(of_frame).flat_map(|z| [z.x, z.y, z.z]).collect()
}

/// How many errors, in their standard deviations, lie in intervals of 50, 80 and 95 %, percent.
pub fn shares(z: &[f64]) -> [f64; 3] {
    INTERVALS.map(|(_, sds)| within_pct(z.iter().copied(), sds))
}

/// The same in words.
pub fn shares_text(z: &[f64]) -> String {
    shares(z).map(|share| format!("{share:.0}")).join(" · ")
}
