//! A part that is as thick as nobody's: it has grown into what hangs around it.
//!
//! A skirt that is wider than the legs at all heights looks like thicker legs: the body stays within the masks, and only its sizes tell.

use crate::body::{BodyModel, Motion, PartId, Posed, Shape};

/// A part twice as wide as the mean body's is nobody's.
const MOST_TIMES: f64 = 4.0;

/// A part with too much volume.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::pipeline) struct Swollen {
    /// Its name.
    pub(in crate::pipeline) part: String,
    /// Its volume over the mean body's.
    pub(in crate::pipeline) times: f64,
}

impl Swollen {
    /// The part that has grown most, if that is nobody's.
    pub(in crate::pipeline) fn of(model: &BodyModel, shape: &Shape) -> Option<Self> {
        let volumes = |shape: &Shape| volumes(model, shape);
        let (own, usual) = (volumes(shape), volumes(&Shape(model.statistics.mean.clone())));
        let times = own.iter().zip(&usual).filter(|(_, usual)| **usual > 0.0);
        let (part, times) = times
            .map(|(own, usual)| own / usual)
            .enumerate()
            .filter(|(_, times)| *times > MOST_TIMES)
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        let name = model.parts[part].name.trim_end_matches("_r").trim_end_matches("_l");
        Some(Self { part: name.replace('_', " "), times })
    }
}

/// The volume of the primitives of each part, up to a factor.
fn volumes(model: &BodyModel, shape: &Shape) -> Vec<f64> {
    let straight = Motion::straight(model);
    let body = Posed::new(model, shape, &straight);
    let primitives = match model.metaballs.as_slice() {
        [] => &model.ellipsoids,
        metaballs => metaballs,
    };
    let of_part = |part: PartId| {
        let own = primitives.iter().filter(|primitive| primitive.part == part);
        own.map(|primitive| body.primitive_radii(primitive).product()).sum()
    };
    (0..model.parts.len()).map(PartId).map(of_part).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn legs_that_are_three_times_as_thick_are_nobodys_and_those_of_a_heavy_man_are_his() {
        let model = crate::io::model::load("human-metaballs", Path::new("")).unwrap();
        let thick = |by: f64| {
            let mut shape = Shape(model.statistics.mean.clone());
            for (name, value) in model.coefficients.iter().zip(shape.0.iter_mut()) {
                let is_of_leg = ["thigh", "shank", "calf", "shin"].iter().any(|l| name.contains(l));
                let is_size = name.ends_with("_width") || name.ends_with("_depth");
                *value += if is_of_leg && is_size { by } else { 0.0 };
            }
            Swollen::of(&model, &shape)
        };
        assert_eq!(thick(0.4), None);
        let found = thick(1.1).unwrap();
        assert!(
            found.times > 5.0 && ["thigh", "shank"].contains(&found.part.as_str()),
            "{found:?}"
        );
    }
}
