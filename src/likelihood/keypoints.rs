//! Detected 2-D keypoints against the points of the body.
//!
//! Keypoint k of a picture lies at u; the body has it at X_k, the keypoint that its detector means
//! ([`BodyModel::with_keypoints`](crate::body::BodyModel::with_keypoints)). With e = u − π(X_k),
//!
//! E_k = ½ ρ(‖e‖²/σ²),  σ = a_k s/(√2 c).
//!
//! s is the person's size in the picture, c the detector's confidence, and a_k the standard deviation of published labels of this joint
//! over s, in the plane; along one axis it is a_k/√2. A detector that errs less or more than those who label is found out by
//! the joint optimum ([`Noise`](crate::inference::noise::Noise)). Where the body has no coefficients for what the detector means, their
//! standard deviation is added to σ.
//!
//! Now and then a detector takes one leg for the other, or one arm. The legs of a picture are labelled as they are or
//! the other way round, with ε = 1 %:
//!
//! E_legs = −ln((1 − ε) exp(−Σ E_k) + ε exp(−Σ E_k′)),
//!
//! k′ the keypoint of the other side. Its gradient is the mean of the gradients of both sums, with the probabilities of the two labellings.
//!
//! # Source
//! a: COCO's keypoint evaluation (5000 images labelled twice; Lin et al. 2014, cocodataset.org), COCO-WholeBody for feet (Jin et al. 2020).
//! Neck and head are not among them: as for shoulders (E). ε: E.

use nalgebra::{Matrix2x3, Point2, Vector2, Vector3};

use super::{PlacedResidual, Source, Term};
use crate::body::{BodyModel, KEYPOINT_SD_M, NamedPoint, PartId, PointSlopes, Posed, Side};
use crate::camera::Camera;
use crate::silhouette::Detection;
use crate::solver::{Loss, NormalEquations};

/// Settings of the keypoint likelihood.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct KeypointOptions {
    /// Robust loss, in standard deviations.
    pub loss: Loss,
    /// ε: how often the sides of legs or arms are exchanged in a picture.
    pub exchanged: f64,
}

impl Default for KeypointOptions {
    fn default() -> Self {
        Self { loss: Loss::Cauchy(3.0), exchanged: 0.01 }
    }
}

/// a of a keypoint, by its name without the side.
fn spread(name: &str) -> f64 {
    match name {
        "Hip" => 0.107,
        "Knee" => 0.087,
        "Ankle" => 0.089,
        "BigToe" => 0.068,
        "Elbow" => 0.072,
        "Wrist" => 0.062,
        _ => 0.079,
    }
}

/// σ = a_k s/(√2 c) of the keypoint of this name, px, of a person of size s whom the detector sees with the confidence c.
pub fn label_sigma_px(name: &str, size_px: f64, confidence: f64) -> f64 {
    let name = if Side::mirrored(name).is_some() { &name[1..] } else { name };
    spread(name) * size_px / (2.0_f64.sqrt() * confidence)
}

/// Where the point of a keypoint is in a body.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Target {
    /// Of [`BodyModel::keypoints`].
    Keypoint(usize),
    /// Of [`BodyModel::points`].
    Point(usize),
}

impl Target {
    fn of(model: &BodyModel, name: &str) -> Option<Self> {
        let keypoint = model.keypoints.iter().position(|k| k.name == name).map(Self::Keypoint);
        keypoint.or_else(|| model.point(name).map(Self::Point))
    }

    fn index(self) -> usize {
        match self {
            Self::Keypoint(index) | Self::Point(index) => index,
        }
    }

    fn point(self, model: &BodyModel) -> &NamedPoint {
        match self {
            Self::Keypoint(index) => &model.keypoints[index],
            Self::Point(index) => &model.points[index],
        }
    }
}

/// A keypoint that the body has.
#[derive(Debug, Clone, Copy)]
struct Seen {
    pixel: Point2<f64>,
    sigma_px: f64,
    target: Target,
    /// That of the other side; its own where it has none.
    twin: Target,
}

/// What one camera's detector saw of the person.
#[derive(Debug, Clone)]
pub struct KeypointView {
    camera: Camera,
    /// Keypoints of neither side, of the legs, and of the arms.
    groups: [Vec<Seen>; 3],
}

impl KeypointView {
    /// Of a camera that is about `depth_m` from the person. Keypoints that the body has not are left out.
    pub fn new(model: &BodyModel, camera: &Camera, detection: &Detection, depth_m: f64) -> Self {
        let mut groups = [Vec::new(), Vec::new(), Vec::new()];
        for keypoint in &detection.keypoints {
            let Some(target) = Target::of(model, keypoint.name) else { continue };
            let twin = Side::mirrored(keypoint.name).and_then(|name| Target::of(model, &name));
            let name = if twin.is_some() { &keypoint.name[1..] } else { keypoint.name };
            let of_labels = label_sigma_px(keypoint.name, detection.size_px, keypoint.confidence);
            let of_place = match target {
                Target::Keypoint(_) => 0.0,
                Target::Point(_) => KEYPOINT_SD_M * camera.intrinsics.focal_px() / depth_m,
            };
            let group = match (twin, name) {
                (None, _) => 0,
                (Some(_), "Hip" | "Knee" | "Ankle" | "BigToe") => 1,
                (Some(_), _) => 2,
            };
            groups[group].push(Seen {
                pixel: keypoint.pixel,
                sigma_px: of_labels.hypot(of_place),
                target,
                twin: twin.unwrap_or(target),
            });
        }
        Self { camera: camera.clone(), groups }
    }
}

/// −log p(keypoints | m, s) of one frame.
#[derive(Debug, Clone)]
pub struct Keypoints {
    views: Vec<KeypointView>,
    options: KeypointOptions,
}

/// Which side a keypoint is taken to be of.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Labels {
    AsGiven,
    Exchanged,
}

impl Seen {
    fn target(&self, labels: Labels) -> Target {
        if labels == Labels::AsGiven { self.target } else { self.twin }
    }

    /// e/σ; `None` behind the camera, where nothing is known.
    fn residual(&self, body: &Posed<'_>, camera: &Camera, labels: Labels) -> Option<Vector2<f64>> {
        let at = body.named_point(self.target(labels).point(body.model));
        Some((self.pixel - camera.project_undistorted(&at)?) / self.sigma_px)
    }
}

/// A residual behind the camera costs as one of so many standard deviations.
const LOST: f64 = 30.0;

impl Keypoints {
    /// The term of one frame.
    pub fn new(views: Vec<KeypointView>, options: KeypointOptions) -> Self {
        Self { views, options }
    }

    /// Σ E_k of a group.
    fn sum(&self, body: &Posed<'_>, camera: &Camera, group: &[Seen], labels: Labels) -> f64 {
        let cost = |seen: &Seen| {
            let r = seen.residual(body, camera, labels).map_or(LOST, |r| r.norm());
            0.5 * self.options.loss.evaluate(r).0
        };
        group.iter().map(cost).sum()
    }

    /// The cost of a group, and the probability that its sides are exchanged.
    fn group_cost(&self, body: &Posed<'_>, camera: &Camera, group: &[Seen]) -> (f64, f64) {
        let as_given = self.sum(body, camera, group, Labels::AsGiven);
        if group.iter().all(|seen| seen.twin == seen.target) {
            return (as_given, 0.0);
        }

        let exchanged = self.sum(body, camera, group, Labels::Exchanged);
        let (a, b) = (
            (1.0 - self.options.exchanged).ln() - as_given,
            self.options.exchanged.ln() - exchanged,
        );
        let most = a.max(b);
        let log_sum = most + ((a - most).exp() + (b - most).exp()).ln();
        (-log_sum, (b - log_sum).exp())
    }

    /// Adds the rows of one keypoint, `share` times.
    fn add_rows(
        &self,
        body: &Posed<'_>,
        camera: &Camera,
        (seen, labels, share): (&Seen, Labels, f64),
        equations: &mut NormalEquations,
        slopes: &mut PointSlopes,
    ) {
        let point = seen.target(labels).point(body.model);
        let projected = camera.project_undistorted_with_jacobian(&body.named_point(point));
        let Some((at, by_point)) = projected else { return };
        let r = (seen.pixel - at) / seen.sigma_px;
        let weight = share * self.options.loss.evaluate(r.norm()).1;

        body.named_point_slopes(point, slopes);
        let n = equations.gradient.len();
        let by_point: Matrix2x3<f64> = by_point / -seen.sigma_px;
        let free = slopes.partition_point(|(component, _)| *component < n);
        let columns: Vec<(usize, Vector2<f64>)> = slopes[..free]
            .iter()
            .map(|(component, slope)| (*component, by_point * slope))
            .collect();
        for (i, (row, a)) in columns.iter().enumerate() {
            equations.gradient[*row] += weight * a.dot(&r);
            for (column, b) in &columns[..=i] {
                equations.hessian[(*row, *column)] += weight * a.dot(b);
            }
        }
    }
}

impl Term for Keypoints {
    fn name(&self) -> &'static str {
        "keypoints"
    }

    fn observations(&self) -> f64 {
        let count = |view: &KeypointView| view.groups.iter().map(Vec::len).sum::<usize>();
        2.0 * self.views.iter().map(count).sum::<usize>() as f64
    }

    fn cost(&self, body: &Posed<'_>) -> f64 {
        let of_view = |view: &KeypointView| {
            let groups = view.groups.iter();
            groups.map(|group| self.group_cost(body, &view.camera, group).0).sum::<f64>()
        };
        self.views.iter().map(of_view).sum()
    }

    fn linearize(&self, body: &Posed<'_>, equations: &mut NormalEquations) -> f64 {
        let mut slopes = PointSlopes::new();
        let mut sum = 0.0;
        for view in &self.views {
            for group in &view.groups {
                let (cost, exchanged) = self.group_cost(body, &view.camera, group);
                sum += cost;
                for (labels, share) in
                    [(Labels::AsGiven, 1.0 - exchanged), (Labels::Exchanged, exchanged)]
                {
                    if share <= 0.0 {
                        continue;
                    }
                    for seen in group {
                        self.add_rows(
                            body,
                            &view.camera,
                            (seen, labels, share),
                            equations,
                            &mut slopes,
                        );
                    }
                }
            }
        }
        sum
    }

    /// Two residuals of each keypoint, as it is labelled: along the picture's rows and columns.
    fn placed_residuals(&self, body: &Posed<'_>) -> Vec<PlacedResidual> {
        let of_view = |(camera, view): (usize, &KeypointView)| {
            let residuals = view.groups.iter().flatten().filter_map(move |seen| {
                let r = seen.residual(body, &view.camera, Labels::AsGiven)?;
                let trust = self.options.loss.evaluate(r.norm()).1;
                let (part, place_part) = part_of(body, seen.target);
                Some([0, 1].map(|axis| PlacedResidual {
                    source: Source::Keypoint { camera, keypoint: seen.target.index() },
                    value: r[axis],
                    trust,
                    sigma: seen.sigma_px,
                    weight: 1.0,
                    outward_px: Vector2::ith(axis, 1.0),
                    part,
                    place_part,
                }))
            });
            residuals.flatten().collect::<Vec<_>>()
        };
        self.views.iter().enumerate().flat_map(of_view).collect()
    }
}

/// The (first) part of a point, and where on it the point is.
fn part_of(body: &Posed<'_>, target: Target) -> (PartId, Vector3<f64>) {
    let point = target.point(body.model);
    let part = point.places[0].0;
    (part, body.in_part(part, &body.named_point(point)))
}
