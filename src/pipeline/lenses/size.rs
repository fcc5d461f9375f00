//! How large the world is: by the person's height, by the distance of two cameras, or by what people are like.

use super::stature_m;
use crate::body::{BodyModel, Shape};
use crate::camera::Rig;
use crate::pipeline::diagnosis::likeliest_scale;

/// What is known of the size of the world.
#[derive(Debug, Clone, PartialEq)]
pub enum Size {
    /// The person's height without shoes, metres.
    Height(f64),
    /// The distance of two cameras' centres.
    Distance {
        /// Their names.
        cameras: [String; 2],
        /// The distance.
        metres: f64,
    },
    /// Nothing but what people are like.
    Usual,
}

/// By what a world is to be multiplied, and how well that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// The factor.
    pub factor: f64,
    /// Its standard deviation over itself; `None` where a length is given, or nothing is known.
    pub sd: Option<f64>,
}

/// A distance that cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SizeError {
    /// No camera of that name.
    #[error("--distance: no camera {camera:?}: there are {known}")]
    UnknownCamera {
        /// The name.
        camera: String,
        /// The names there are.
        known: String,
    },
    /// A length that none is.
    #[error("{name} = {metres} m: expected {least} to {most} m")]
    Length {
        /// Of what.
        name: &'static str,
        /// It.
        metres: f64,
        /// Its limits.
        least: f64,
        /// Its limits.
        most: f64,
    },
    /// Twice the same camera.
    #[error("--distance: expected two cameras, found {camera:?} twice")]
    Twice {
        /// The name.
        camera: String,
    },
}

/// Nobody is shorter or taller, metres; as for a fit.
const HEIGHTS_M: [f64; 2] = [0.4, 2.6];
/// No two cameras of a room are nearer or farther, metres.
const DISTANCES_M: [f64; 2] = [0.01, 1000.0];

impl Size {
    /// Whether it can be used with these cameras.
    ///
    /// # Errors
    /// [`SizeError`].
    pub fn check(&self, rig: &Rig) -> Result<(), SizeError> {
        let within =
            |name, metres: f64, [least, most]: [f64; 2]| match (least..=most).contains(&metres) {
                true => Ok(()),
                false => Err(SizeError::Length { name, metres, least, most }),
            };
        match self {
            Self::Usual => Ok(()),
            Self::Height(metres) => within("--height", *metres, HEIGHTS_M),
            Self::Distance { cameras, metres } => {
                within("--distance", *metres, DISTANCES_M)?;
                let unknown = cameras.iter().find(|name| rig.by_name(name).is_none());
                let known = || rig.names().collect::<Vec<_>>().join(", ");
                match unknown {
                    Some(name) => {
                        Err(SizeError::UnknownCamera { camera: name.clone(), known: known() })
                    }
                    None if cameras[0] == cameras[1] => {
                        Err(SizeError::Twice { camera: cameras[0].clone() })
                    }
                    None => Ok(()),
                }
            }
        }
    }

    /// The person's height, if that is what is known.
    pub fn height_m(&self) -> Option<f64> {
        if let Self::Height(metres) = self { Some(*metres) } else { None }
    }

    /// What makes a world of the right size of one in which a body of this shape was fitted between these cameras. Without a body it is as large
    /// as detections make it.
    pub fn scale(&self, model: &BodyModel, shape: Option<&Shape>, rig: &Rig) -> Scale {
        match self {
            Self::Height(metres) => {
                let found_m = shape.map_or(*metres, |shape| stature_m(model, shape));
                Scale { factor: metres / found_m, sd: None }
            }
            Self::Distance { cameras, metres } => {
                let centre = |name: &String| Some(rig.by_name(name)?.1.centre_world());
                let [a, b] = [0, 1].map(|k| centre(&cameras[k]));
                let found = a.zip(b).map_or(*metres, |(a, b)| (a - b).norm());
                Scale { factor: metres / found, sd: None }
            }
            Self::Usual => {
                let mean = Shape(model.statistics.mean.clone());
                let found = likeliest_scale(model, shape.unwrap_or(&mean));
                let (log, sd) = found.map_or((0.0, None), |(log, sd)| (log, Some(sd)));
                Scale { factor: (-log).exp(), sd }
            }
        }
    }
}
