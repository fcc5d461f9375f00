//! The girth of a limb, in the middle of its length.
//!
//! At rest, rays go out from the middle m of a length, square to it. Each ray ends where it leaves the flesh of one part:
//! the part that m lies deepest in. Of metaballs that is the part with the largest sum at m, and F = ½ at its end; of
//! ellipsoids the part whose ellipsoid has the least (m − c)ᵀ S⁻¹ (m − c). The girth is the perimeter of the ends.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use crate::body::metaball::{Field, THRESHOLD};
use crate::body::{BodyModel, Motion, Posed, Shape};
use crate::math::quadric::Ellipsoid;

const RAYS: usize = 72;
/// Where the search along a ray ends, m, and its steps.
const FARTHEST_M: f64 = 0.5;
const STEPS: usize = 100;
/// Halvings of the last step: to a few nanometres.
const HALVINGS: usize = 20;

/// A girth of the body at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Girth {
    /// Name of the length in whose middle it is.
    pub name: String,
    /// Metres.
    pub girth_m: f64,
    /// Its standard deviation, metres, where the covariance of the coefficients is known.
    pub sd_m: Option<f64>,
}

/// The girth of every limb, in the middle of each length that runs along it.
///
/// `covariance` is that of the shape coefficients, row by row. The standard deviation is √(∇gᵀ C ∇g) with C the
/// covariance and ∇g from central differences over one standard deviation of each coefficient.
pub fn girths(model: &BodyModel, shape: &Shape, covariance: Option<&[Vec<f64>]>) -> Vec<Girth> {
    let lengths = model.lengths.iter().enumerate();
    let girths = lengths.filter_map(|(i, (name, _, _))| {
        Some(Girth {
            name: name.clone(),
            girth_m: girth(model, shape, i)?,
            sd_m: covariance.and_then(|c| standard_deviation(model, shape, c, i)),
        })
    });
    girths.collect()
}

fn standard_deviation(
    model: &BodyModel,
    shape: &Shape,
    covariance: &[Vec<f64>],
    length: usize,
) -> Option<f64> {
    let girth_at = |k: usize, offset: f64| {
        let mut moved = shape.clone();
        *moved.0.get_mut(k)? += offset;
        girth(model, &moved, length)
    };

    let slope = |k: usize| {
        let sd = covariance[k].get(k)?.sqrt();
        match sd > 0.0 {
            true => Some((girth_at(k, sd)? - girth_at(k, -sd)?) / (2.0 * sd)),
            // a coefficient that is known has no part in it
            false => Some(0.0),
        }
    };
    let slopes: Vec<f64> = (0..covariance.len()).map(slope).collect::<Option<_>>()?;

    // ∇gᵀ C ∇g, row by row
    let rows = covariance.iter().zip(&slopes).map(|(row, slope)| {
        let sum: f64 = row.iter().zip(&slopes).map(|(c, other)| c * other).sum();
        slope * sum
    });
    let variance: f64 = rows.sum();
    (variance >= 0.0).then(|| variance.sqrt())
}

/// The perimeter around one length; `None` if it runs from side to side, or its middle lies outside the flesh.
fn girth(model: &BodyModel, shape: &Shape, length: usize) -> Option<f64> {
    let rest = Motion::rest(model);
    let body = Posed::new(model, shape, &rest);
    let points = body.points();
    let (_, from, to) = model.lengths.get(length)?;
    let along = (points[*to] - points[*from]).try_normalize(1e-9)?;

    // a limb has a side, and hangs; the widths of hips and shoulders do not
    let is_limb = has_side(model, *from) && has_side(model, *to) && along.z.abs() >= 0.5;
    if !is_limb {
        return None;
    }

    let middle = nalgebra::center(&points[*from], &points[*to]).coords;
    let flesh = PartFlesh::around(&body, &middle)?;
    let across = along.cross(&Vector3::x()).try_normalize(1e-9)?;
    let ahead = along.cross(&across);

    let ends = (0..RAYS).map(|k| {
        let (sin, cos) = (TAU * k as f64 / RAYS as f64).sin_cos();
        flesh.end(&middle, &(across * cos + ahead * sin))
    });
    let ends: Vec<Vector3<f64>> = ends.collect::<Option<_>>()?;
    let next = ends.iter().cycle().skip(1);
    Some(ends.iter().zip(next).map(|(a, b)| (b - a).norm()).sum())
}

/// Whether the name of a point begins with the letter of a side and a capital, as `RKnee` does.
fn has_side(model: &BodyModel, point: usize) -> bool {
    let mut letters = model.points[point].name.chars();
    letters.next().is_some_and(|c| "RL".contains(c))
        && letters.next().is_some_and(char::is_uppercase)
}

/// The flesh of one part.
enum PartFlesh {
    Metaballs(Field),
    Ellipsoids(Vec<Ellipsoid>),
}

impl PartFlesh {
    /// That of the part that a place lies deepest in; `None` if it lies in none.
    fn around(body: &Posed<'_>, place: &Vector3<f64>) -> Option<Self> {
        let flesh = match body.model.metaballs.is_empty() {
            false => Self::Metaballs(deepest_metaballs(body, place)?),
            true => Self::Ellipsoids(deepest_ellipsoids(body, place)?),
        };
        flesh.holds(place).then_some(flesh)
    }

    fn holds(&self, place: &Vector3<f64>) -> bool {
        match self {
            Self::Metaballs(field) => field.value(place) > THRESHOLD,
            Self::Ellipsoids(all) => all.iter().any(|e| depth(e, place) < 1.0),
        }
    }

    /// Where a ray from within first leaves it.
    fn end(&self, from: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Vector3<f64>> {
        let step = FARTHEST_M / STEPS as f64;
        let at = |t: f64| from + direction * t;
        let outside = (1..=STEPS).find(|k| !self.holds(&at(step * *k as f64)))?;

        let (mut low, mut high) = (step * (outside - 1) as f64, step * outside as f64);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match self.holds(&at(middle)) {
                true => low = middle,
                false => high = middle,
            }
        }
        Some(at(0.5 * (low + high)))
    }
}

/// The metaballs of the part with the largest sum at a place.
fn deepest_metaballs(body: &Posed<'_>, place: &Vector3<f64>) -> Option<Field> {
    let fields = (0..body.model.parts.len()).map(|part| {
        let own = body.model.metaballs.iter().filter(|m| m.part.0 == part);
        Field::new(own.map(|m| body.primitive(m)))
    });
    fields.max_by(|a, b| a.value(place).total_cmp(&b.value(place)))
}

/// The ellipsoids of the part that carries the one that a place lies deepest in.
fn deepest_ellipsoids(body: &Posed<'_>, place: &Vector3<f64>) -> Option<Vec<Ellipsoid>> {
    let primitives = body.model.ellipsoids.iter();
    let all: Vec<_> = primitives.zip(body.ellipsoids()).collect();
    let depths = all.iter().map(|(p, e)| (p.part, depth(e, place)));
    let (part, _) = depths.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let own = all.into_iter().filter(|(p, _)| p.part == part);
    Some(own.map(|(_, e)| e).collect())
}

/// (x − c)ᵀ S⁻¹ (x − c): 0 in the centre, 1 on the surface.
fn depth(ellipsoid: &Ellipsoid, place: &Vector3<f64>) -> f64 {
    let offset = place - ellipsoid.centre;
    let inverse = ellipsoid.shape.cholesky().map(|c| c.inverse());
    inverse.map_or(f64::INFINITY, |inverse| offset.dot(&(inverse * offset)))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn mean_girths(name: &str) -> Vec<Girth> {
        let model = crate::io::model::load(name, Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let n = model.coefficients.len();
        let row = |i: usize| (0..n).map(|k| if i == k { 4e-4 } else { 0.0 }).collect();
        let covariance: Vec<Vec<f64>> = (0..n).map(row).collect();
        girths(&model, &shape, Some(&covariance))
    }

    #[test]
    fn coefficients_that_err_against_each_other_leave_the_girth_surer_than_those_that_err_alike() {
        let model = crate::io::model::load("human-metaballs", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let named = |name: &str| model.coefficients.iter().position(|c| c == name).unwrap();
        let (across, ahead) = (named("thigh_width"), named("thigh_depth"));
        let sd = |together: f64| {
            let n = model.coefficients.len();
            let mut covariance = vec![vec![0.0; n]; n];
            (covariance[across][across], covariance[ahead][ahead]) = (4e-4, 4e-4);
            (covariance[across][ahead], covariance[ahead][across]) = (together, together);
            let girths = girths(&model, &shape, Some(&covariance));
            girths.iter().find(|g| g.name == "thigh").unwrap().sd_m.unwrap()
        };
        assert!(sd(-3e-4) < sd(0.0) && sd(0.0) < sd(3e-4));
    }

    #[test]
    fn the_mean_bodys_girths_are_a_persons_on_either_body() {
        // generous, of adults (metres)
        let people = [
            ("thigh", 0.38, 0.70),
            ("shank", 0.24, 0.45),
            ("upper_arm", 0.20, 0.42),
            ("forearm", 0.16, 0.32),
        ];
        for body in ["human-ellipsoids", "human-metaballs"] {
            let girths = mean_girths(body);
            for (name, least, most) in people {
                let girth = girths.iter().find(|g| g.name == name).unwrap();
                assert!((least..most).contains(&girth.girth_m), "{body}: {girth:?}");
                assert!(girth.sd_m.unwrap() > 0.0, "{body}: {girth:?}");
            }
            assert_eq!(girths.len(), people.len());
        }
    }

    #[test]
    fn an_arm_that_hangs_into_a_broad_chest_is_no_thicker() {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let upper_arm = |thorax: f64| {
            let mut shape = Shape(model.statistics.mean.clone());
            for name in ["thorax_width", "thorax_depth"] {
                let broad = model.coefficients.iter().position(|c| c == name).unwrap();
                shape.0[broad] *= thorax;
            }
            let girths = girths(&model, &shape, None);
            girths.iter().find(|g| g.name == "upper_arm").unwrap().girth_m
        };
        approx::assert_relative_eq!(upper_arm(1.6), upper_arm(1.0), epsilon = 1e-9);
    }

    #[test]
    fn a_ray_ends_where_it_leaves_the_ellipsoid() {
        let flesh = PartFlesh::Ellipsoids(vec![Ellipsoid {
            centre: Vector3::zeros(),
            shape: nalgebra::Matrix3::from_diagonal_element(0.01),
        }]);
        let end = flesh.end(&Vector3::zeros(), &Vector3::y()).unwrap();
        approx::assert_relative_eq!(end.y, 0.1, epsilon = 1e-6);
    }
}
