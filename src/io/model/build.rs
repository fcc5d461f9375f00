//! From the file to the model: sides doubled, names resolved.

use std::path::Path;

use nalgebra::{DMatrix, DVector, Rotation3, UnitVector3, Vector3};

use super::ModelFileError;
use super::order::parents_first;
use super::side::{Side, Sides};
use super::spec::{AxisSpec, JointSpec, LengthSpec, ModelSpec, PartSpec, PointSpec, PoseSpec};
use crate::body::{
    BodyModel, Joint, JointId, ModelError, NamedPoint, Part, PartId, Pose, Root, ScaledVector,
    ShapeStatistics, Shift,
};

pub(super) fn build(spec: &ModelSpec, path: &Path) -> Result<BodyModel, ModelFileError> {
    let mut builder = Builder { path, scales: Vec::new(), carried: Vec::new(), model: empty(spec) };
    builder.model.statistics = builder.coefficients(spec)?;
    let parts = parents_first(spec, path)?;
    for (part, side) in &parts {
        builder.part(part, *side)?;
    }
    // frames of flesh are numbered after all joints
    for (id, (part, side)) in parts.iter().enumerate() {
        builder.flesh(part, PartId(id), *side)?;
    }
    for point in &spec.points {
        builder.point(point)?;
    }
    for pose in &spec.poses {
        let pose = builder.pose(pose)?;
        builder.model.poses.push(pose);
    }
    for length in &spec.lengths {
        let length = builder.length(length)?;
        builder.model.lengths.push(length);
    }
    builder.unique()?;
    let checked = builder.model.validate();
    checked.map_err(|fault| builder.fault(fault))?;
    Ok(builder.model)
}

fn empty(spec: &ModelSpec) -> BodyModel {
    let root = match spec.root.fixed {
        true => Root::Fixed,
        false => Root::Free { speed: spec.root.speed, turn: spec.root.turn_deg.to_radians() },
    };

    BodyModel {
        name: spec.name.clone(),
        coefficients: Vec::new(),
        statistics: ShapeStatistics { mean: DVector::zeros(0), covariance: DMatrix::zeros(0, 0) },
        root,
        joints: Vec::new(),
        followers: Vec::new(),
        offsets: None,
        parts: Vec::new(),
        ellipsoids: Vec::new(),
        metaballs: Vec::new(),
        points: Vec::new(),
        keypoints: Vec::new(),
        poses: Vec::new(),
        lengths: Vec::new(),
    }
}

pub(super) struct Builder<'a> {
    path: &'a Path,
    /// The scale of each part, in the order of the model's parts.
    scales: Vec<[String; 3]>,
    /// How far each part's flesh, and all that the part carries, shifts in its frame because of where its joint lies in the flesh.
    pub(super) carried: Vec<Vec<Shift>>,
    pub(super) model: BodyModel,
}

impl Builder<'_> {
    pub(super) fn fault(&self, fault: ModelError) -> ModelFileError {
        ModelFileError::Model { path: self.path.to_owned(), fault }
    }

    pub(super) fn missing(&self, place: &str, kind: &'static str, name: &str) -> ModelFileError {
        ModelFileError::Missing {
            path: self.path.to_owned(),
            place: place.to_owned(),
            kind,
            name: name.to_owned(),
        }
    }

    /// p(s): covariance ΛΛᵀ + diag(sd²) from the loadings Λ on the named factors.
    fn coefficients(&mut self, spec: &ModelSpec) -> Result<ShapeStatistics, ModelFileError> {
        let mut rows = Vec::new();
        for coefficient in &spec.coefficients {
            let mut loadings = vec![0.0; spec.factors.len()];
            for (factor, value) in &coefficient.loadings {
                let place = format!("coefficient {}", coefficient.name);
                let index = spec.factors.iter().position(|f| f == factor);
                loadings[index.ok_or_else(|| self.missing(&place, "factor", factor))?] = *value;
            }

            for side in coefficient.sides.each() {
                self.model.coefficients.push(side.suffix(&coefficient.name));
                rows.push((coefficient, loadings.clone()));
            }
        }

        // Σ = ΛΛᵀ + diag(σ²), from the factors' loadings Λ
        let n = rows.len();
        let mean = DVector::from_iterator(n, rows.iter().map(|(c, _)| c.mean));
        let covariance = DMatrix::from_fn(n, n, |i, j| {
            let shared: f64 = rows[i].1.iter().zip(&rows[j].1).map(|(a, b)| a * b).sum();
            shared + if i == j { rows[i].0.sd.powi(2) } else { 0.0 }
        });
        Ok(ShapeStatistics { mean, covariance })
    }

    fn part(&mut self, spec: &PartSpec, side: Side) -> Result<(), ModelFileError> {
        self.has_effect(spec)?;
        let name = side.suffix(&spec.name);
        let place = format!("part {name}");
        let parent = match &spec.parent {
            None => None,
            Some(parent) => Some(self.part_named(parent, side, &place)?),
        };

        let mut joint = parent.and_then(|p: PartId| self.model.parts[p.0].joint);
        let at_scale = spec.at_scale.as_ref().or(parent.map(|p| &self.scales[p.0]));
        let mut translation = self.scaled(side.place(spec.at), at_scale, side, &place)?;
        let below = parent.map_or(Vec::new(), |p| self.carried[p.0].clone());
        translation.shifts.extend(below.iter().copied());

        // only the first joint lies where the part begins: the others turn in the same place
        let mut turn = side.turn(spec.turn_deg);
        let first = self.model.joints.len();
        for joint_spec in &spec.joints {
            let made = self.joint(joint_spec, side, joint, translation, turn)?;
            self.model.joints.push(made);
            joint = Some(JointId(self.model.joints.len() - 1));
            translation = ScaledVector::fixed(Vector3::zeros());
            turn = Rotation3::identity();
        }

        let pivot = self.pivot(spec, side, &place)?;
        let carried = match spec.joints.is_empty() {
            true => below,
            false => self.displace(first, &pivot),
        };

        self.carried.push(carried);
        self.model.parts.push(Part { name, joint, pivot, sd_m: spec.sd.into(), folds: spec.folds });
        self.scales.push(spec.scale.clone());
        Ok(())
    }

    /// Checks that a part which states its joint's place has a joint.
    fn has_effect(&self, spec: &PartSpec) -> Result<(), ModelFileError> {
        let is_any = |numbers: [f64; 3]| numbers.iter().any(|v| *v != 0.0);
        let given = [
            ("at", is_any(spec.at)),
            ("at_scale", spec.at_scale.is_some()),
            ("turn_deg", is_any(spec.turn_deg)),
            ("pivot", spec.pivot.is_some()),
            ("sd", is_any(spec.sd)),
            ("folds", spec.folds),
        ];
        match given.into_iter().find(|(_, is_given)| *is_given) {
            Some((key, _)) if spec.joints.is_empty() => Err(ModelFileError::NoJoint {
                path: self.path.to_owned(),
                part: spec.name.clone(),
                key,
            }),
            _ => Ok(()),
        }
    }

    /// A part by its name in the file, on this side or in the middle.
    pub(super) fn part_named(
        &self,
        name: &str,
        side: Side,
        place: &str,
    ) -> Result<PartId, ModelFileError> {
        let find =
            |wanted: &str| self.model.parts.iter().position(|p| p.name == wanted).map(PartId);
        find(&side.suffix(name))
            .or_else(|| find(name))
            .ok_or_else(|| self.missing(place, "part", name))
    }

    fn joint(
        &self,
        spec: &JointSpec,
        side: Side,
        parent: Option<JointId>,
        mut translation: ScaledVector,
        mut turn: Rotation3<f64>,
    ) -> Result<Joint, ModelFileError> {
        let axis = self.axis(spec, side)?;

        // Denavit–Hartenberg: turn by α about x, move by (a, 0, d), turn by θ about z
        if let Some(dh) = &spec.dh {
            let alpha = Rotation3::from_axis_angle(&Vector3::x_axis(), dh.alpha_deg.to_radians());
            translation.value += turn * (alpha * Vector3::new(dh.a, 0.0, dh.d));
            turn *=
                alpha * Rotation3::from_axis_angle(&Vector3::z_axis(), dh.theta_deg.to_radians());
        }

        let radians = |d: f64| d.to_radians();
        Ok(Joint {
            name: side.suffix(&spec.name),
            parent,
            parent_from_joint: turn,
            translation,
            axis,
            limits: (radians(spec.limits_deg[0]), radians(spec.limits_deg[1])),
            rest: radians(spec.rest_deg),
            spread: radians(spec.spread_deg),
            speed: radians(spec.speed_deg),
        })
    }

    /// Checks that exactly one of two keys is given.
    fn one_of(&self, place: &str, keys: [(&'static str, bool); 2]) -> Result<(), ModelFileError> {
        match keys.iter().filter(|(_, is_given)| *is_given).count() {
            1 => Ok(()),
            found => Err(ModelFileError::OneOf {
                path: self.path.to_owned(),
                place: place.to_owned(),
                keys: keys.map(|(key, _)| key),
                found,
            }),
        }
    }

    fn axis(&self, spec: &JointSpec, side: Side) -> Result<UnitVector3<f64>, ModelFileError> {
        let place = format!("joint {}", spec.name);
        let keys = [("axis", spec.axis.is_some()), ("dh", spec.dh.is_some())];
        self.one_of(&place, keys)?;

        let vector = match &spec.axis {
            None => return Ok(Vector3::z_axis()),
            Some(AxisSpec::Vector(v)) => Some(Vector3::from(*v)),
            Some(AxisSpec::Letter(letter)) => match letter.trim_start_matches(['+', '-']) {
                "x" => Some(Vector3::x()),
                "y" => Some(Vector3::y()),
                "z" => Some(Vector3::z()),
                _ => None,
            }
            .map(|v| if letter.starts_with('-') { -v } else { v }),
        };

        vector.and_then(|v| UnitVector3::try_new(side.axis(v), 1e-9)).ok_or_else(|| {
            ModelFileError::Axis {
                path: self.path.to_owned(),
                joint: spec.name.clone(),
                found: format!("{:?}", spec.axis),
            }
        })
    }

    fn point(&mut self, spec: &PointSpec) -> Result<(), ModelFileError> {
        let place = format!("point {}", spec.name);
        let keys = [("part", spec.part.is_some()), ("midpoint", !spec.midpoint.is_empty())];
        self.one_of(&place, keys)?;
        if let Some(part) = &spec.part {
            let sided = Sides::from(!self.model.parts.iter().any(|p| p.name == *part));
            for &side in sided.each() {
                let prefix = ["", "R", "L"][side as usize];
                let owner = self.part_named(part, side, &place)?;
                let at_scale = spec.at_scale.as_ref().or(Some(&self.scales[owner.0]));
                let mut at = self.scaled(side.place(spec.at), at_scale, side, &place)?;
                // a joint's centre is where the joint is, all else is in the flesh
                let is_centre = at.value == Vector3::zeros();
                if !is_centre {
                    at.shifts.extend(&self.carried[owner.0]);
                }
                let of_part = is_centre.then(|| self.model.parts[owner.0].sd_m);
                self.model.points.push(NamedPoint {
                    name: format!("{prefix}{}", spec.name),
                    places: vec![(owner, at)],
                    sd_m: spec.sd.map(Vector3::from).or(of_part).unwrap_or_default(),
                    meant: None,
                });
            }
            return Ok(());
        }
        let mut places = Vec::new();
        for end in &spec.midpoint {
            let index = self.model.point(end).ok_or_else(|| self.missing(&place, "point", end))?;
            places.extend(self.model.points[index].places.clone());
        }
        self.model.points.push(NamedPoint {
            name: spec.name.clone(),
            places,
            sd_m: spec.sd.unwrap_or_default().into(),
            meant: None,
        });
        Ok(())
    }

    fn pose(&self, spec: &PoseSpec) -> Result<Pose, ModelFileError> {
        let angle = |(name, degrees): (&String, &f64)| match self.model.joint(name) {
            Some(joint) => Ok((joint, degrees.to_radians())),
            None => Err(self.missing(&format!("pose {}", spec.name), "joint", name)),
        };
        Ok(Pose {
            name: spec.name.clone(),
            limbs: spec.limbs,
            angles: spec.angles_deg.iter().map(angle).collect::<Result<_, _>>()?,
        })
    }

    /// Its name, and the points at its ends.
    fn length(&self, spec: &LengthSpec) -> Result<(String, usize, usize), ModelFileError> {
        let place = format!("length {}", spec.name);
        let find = |name: &str| {
            let index = self.model.point(name);
            index.ok_or_else(|| self.missing(&place, "point", name))
        };
        Ok((spec.name.clone(), find(&spec.from)?, find(&spec.to)?))
    }

    fn unique(&self) -> Result<(), ModelFileError> {
        let model = &self.model;
        let lists: [(&'static str, Vec<&String>); 4] = [
            ("coefficient", model.coefficients.iter().collect()),
            ("part", model.parts.iter().map(|p| &p.name).collect()),
            ("joint", model.joints.iter().map(|j| &j.name).collect()),
            ("point", model.points.iter().map(|p| &p.name).collect()),
        ];

        for (kind, mut names) in lists {
            names.sort();
            if let Some(pair) = names.windows(2).find(|w| w[0] == w[1]) {
                return Err(ModelFileError::Duplicate {
                    path: self.path.to_owned(),
                    kind,
                    name: pair[0].clone(),
                });
            }
        }
        Ok(())
    }
}
