//! What cameras side by side see differently at one place of the body: their parallax.
//!
//! Cameras side by side touch the same places. What errs there errs for all of them alike: the surface lies further out than the
//! model's, cloth hangs away. The mean of their residuals has that error. Their differences have not, and it is the differences that say
//! how far away a limb is. With r̄_c the weighted mean of the residuals of view c at a place, W_c the sum of their weights, and r̄ the
//! mean over all views there, the *contrasts* d_c = r̄_c − r̄ cost
//!
//! E = ½ Σ_places Σ_c W_c d_c²,   ∂d_c/∂θ = Σ wⱼ/W_c ∂rⱼ/∂θ − Σ wⱼ/W ∂rⱼ/∂θ,
//!
//! sums over the lines j of the view and of the place. Which lines touch a place, and their weights w = w ρ′/σ², are those of the
//! state at which the term was made; so E is a sum of squares. How much it counts beside the lines themselves is estimated:
//! [`contrasts`](crate::inference::contrasts).
//!
//! Cameras that look from farther apart touch a limb where it faces elsewhere. They meet other places of its surface, and their
//! differences say how round it is, not how far away.

use std::collections::BTreeMap;

use nalgebra::{DVector, Vector2, Vector3};

use super::Source;
use super::placed_residual::{PLACE_M, Place, place};
use super::silhouette_ray::SilhouetteRays;
use super::skin_term::{self, SkinTerm, TouchPlace};
use crate::body::metaball::{Field, FieldSlopes};
use crate::body::{PartId, Posed};
use crate::solver::NormalEquations;

/// Lines of sight at a smaller angle than this are of cameras side by side: the places at which they touch a trunk, of radius 15 cm,
/// are no farther apart than one is wide.
const BESIDE_RAD: f64 = PLACE_M / 0.15;

/// The contrasts of one frame.
#[derive(Debug, Clone)]
pub struct Parallax {
    /// The lines that touch a place which another camera sees too.
    rays: SilhouetteRays,
    /// By view and line.
    lines: Vec<Vec<Line>>,
    looks: Vec<Look>,
    places: usize,
}

/// A line of sight among the looks.
#[derive(Debug, Clone, Copy)]
struct Line {
    look: usize,
    /// w ρ′/σ², 1/m².
    weight: f64,
}

/// One view's look at one place.
#[derive(Debug, Clone, Copy)]
struct Look {
    place: usize,
    part: PartId,
    view: usize,
    quarter: Quarter,
}

/// The way in which a border faces in its picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "they are what they say")]
pub enum Quarter {
    Left,
    Right,
    Up,
    Down,
}

impl Quarter {
    fn new(outward_px: &Vector2<f64>) -> Self {
        match (outward_px.x.abs() > outward_px.y.abs(), outward_px.x > 0.0, outward_px.y > 0.0) {
            (true, false, _) => Self::Left,
            (true, true, _) => Self::Right,
            (false, _, false) => Self::Up,
            (false, _, true) => Self::Down,
        }
    }
}

/// By how much one view differs from all that see a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contrast {
    /// The part.
    pub part: PartId,
    /// The view: its position among the frame's.
    pub view: usize,
    /// Which way its border faces there.
    pub quarter: Quarter,
    /// W_c, 1/m².
    pub weight: f64,
    /// d_c, metres.
    pub value_m: f64,
    /// 1 − W_c/W: its share of the place's independent contrasts, one less than there are views.
    pub freedom: f64,
}

/// Σw and Σwr.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    weight: f64,
    residual: f64,
}

impl Sum {
    fn add(&mut self, other: Self) {
        self.weight += other.weight;
        self.residual += other.residual;
    }

    fn mean(self) -> f64 {
        self.residual / self.weight
    }
}

/// A line that touches a place, as it is found.
struct Found {
    view: usize,
    index: usize,
    weight: f64,
    quarter: Quarter,
    direction: Vector3<f64>,
}

impl Parallax {
    /// Of the lines of sight of one frame at the places that they touch now; `None` if no two cameras are side by side.
    pub(super) fn new(rays: &SilhouetteRays, body: &Posed<'_>) -> Option<Self> {
        // cameras around a person need no search for the places
        if !rays.has_views_within(BESIDE_RAD) {
            return None;
        }
        let rays = &rays.without_shared(body);

        let mut looks: Vec<Look> = Vec::new();
        let mut places = 0;
        let mut kept: BTreeMap<(usize, usize), Line> = BTreeMap::new();

        for ((part, _), found) in touched(rays, body) {
            for mut beside in side_by_side(found) {
                beside.sort_by_key(|line| line.view);
                let views = || beside.chunk_by(|a, b| a.view == b.view);
                if views().count() < 2 {
                    continue;
                }
                for lines in views() {
                    let line = |l: &Found| {
                        ((l.view, l.index), Line { look: looks.len(), weight: l.weight })
                    };
                    kept.extend(lines.iter().map(line));
                    let (view, quarter) = (lines[0].view, lines[0].quarter);
                    looks.push(Look { place: places, part, view, quarter });
                }
                places += 1;
            }
        }

        let views = rays.views();
        let of_view = |view: usize| kept.range((view, 0)..(view + 1, 0));
        let indices = |view: usize| of_view(view).map(|((_, index), _)| *index).collect();
        let indices: Vec<Vec<usize>> = (0..views).map(indices).collect();
        let lines = (0..views).map(|view| of_view(view).map(|(_, line)| *line).collect()).collect();
        (places > 0).then(|| Self { rays: rays.only(&indices), lines, looks, places })
    }

    /// Every contrast at a state.
    pub fn contrasts(&self, body: &Posed<'_>) -> Vec<Contrast> {
        let field = Field::from_body(body);
        let scale = self.rays.scale(body, &field);
        let mut sums = vec![Sum::default(); self.looks.len()];
        self.rays.touches(body, &field, &scale, |touch, _| {
            if let Some(Line { look, weight }) = self.line(touch.source, touch.index) {
                let residual = weight * touch.residual.distance_m;
                sums[look].add(Sum { weight, residual });
            }
        });
        self.contrasts_of(&sums).into_iter().map(|(_, contrast)| contrast).collect()
    }

    /// E.
    pub fn cost(&self, body: &Posed<'_>) -> f64 {
        self.contrasts(body).iter().map(|c| 0.5 * c.weight * c.value_m * c.value_m).sum()
    }

    /// c·E, whose equations are added.
    pub fn linearize(&self, body: &Posed<'_>, c: f64, equations: &mut NormalEquations) -> f64 {
        let mut cost = 0.0;
        for (contrast, row) in self.rows(body, equations.gradient.len()) {
            let weight = c * contrast.weight;
            cost += 0.5 * weight * contrast.value_m * contrast.value_m;
            add_row(&row, contrast.value_m, weight, equations);
        }
        cost
    }

    /// Every contrast with its derivatives with respect to the state's first n components.
    pub fn rows(&self, body: &Posed<'_>, n: usize) -> Vec<(Contrast, DVector<f64>)> {
        let field = Field::from_body(body);
        let slopes = FieldSlopes::new(body, &field);

        // Σw, Σwr and Σw ∂r/∂θ of each look, and the last of each place
        let mut sums = vec![Sum::default(); self.looks.len()];
        let mut rows = vec![DVector::zeros(n); self.looks.len()];
        skin_term::rows(&self.rays, body, &field, &slopes, |touch, row| {
            let Some(Line { look, weight }) = self.line(touch.source, touch.index) else { return };
            sums[look].add(Sum { weight, residual: weight * touch.residual.distance_m });
            let of_limb = slopes.components(row.limb).iter().zip(row.values).map(|(k, v)| (*k, *v));
            let of_offsets = row.offsets.iter().flat_map(|offset| offset.slopes);
            for (component, slope) in of_limb.chain(of_offsets).filter(|(k, _)| *k < n) {
                rows[look][component] += weight * slope;
            }
        });
        let mut of_places = vec![DVector::zeros(n); self.places];
        for (look, row) in self.looks.iter().zip(&rows) {
            of_places[look.place] += row;
        }

        let weights = self.of_places(&sums);
        let row = |(look, contrast): (usize, Contrast)| {
            let place = self.looks[look].place;
            let row = &rows[look] / sums[look].weight - &of_places[place] / weights[place].weight;
            (contrast, row)
        };
        self.contrasts_of(&sums).into_iter().map(row).collect()
    }

    fn line(&self, source: Source, index: usize) -> Option<Line> {
        match source {
            Source::View(view) => Some(self.lines[view][index]),
            Source::Cloud | Source::Keypoint { .. } => None,
        }
    }

    /// The sums of each place, from those of the looks.
    fn of_places(&self, looks: &[Sum]) -> Vec<Sum> {
        let mut places = vec![Sum::default(); self.places];
        for (look, sum) in self.looks.iter().zip(looks) {
            places[look.place].add(*sum);
        }
        places
    }

    /// The contrasts, each with its look; of looks whose lines all miss the body there is none.
    fn contrasts_of(&self, looks: &[Sum]) -> Vec<(usize, Contrast)> {
        let places = self.of_places(looks);
        let contrast = |(index, (look, sum)): (usize, (&Look, &Sum))| {
            let Look { place, part, view, quarter } = *look;
            let all = places[place];
            let value_m = sum.mean() - all.mean();
            let freedom = 1.0 - sum.weight / all.weight;
            let contrast = Contrast { part, view, quarter, weight: sum.weight, value_m, freedom };
            (sum.weight > 0.0).then_some((index, contrast))
        };
        self.looks.iter().zip(looks).enumerate().filter_map(contrast).collect()
    }
}

/// Every line of sight that touches the body, by its place.
fn touched(rays: &SilhouetteRays, body: &Posed<'_>) -> BTreeMap<Place, Vec<Found>> {
    let field = Field::from_body(body);
    let mut places: BTreeMap<Place, Vec<Found>> = BTreeMap::new();
    rays.touches(body, &field, &rays.scale(body, &field), |touch, sample| {
        let (Source::View(view), TouchPlace::Summit(direction)) = (touch.source, touch.place)
        else {
            return;
        };
        let metaball = sample.heaviest().unwrap_or_default();
        let point = sample.point_world.into();
        let Some((part, point)) = skin_term::place(body, &field, metaball, &point) else { return };
        places.entry(place(part, &point)).or_default().push(Found {
            view,
            index: touch.index,
            weight: touch.loss(rays.loss()).1,
            quarter: Quarter::new(&touch.outward_px),
            direction: *direction,
        });
    });
    places
}

/// The lines at one place, those apart that come from elsewhere.
fn side_by_side(lines: Vec<Found>) -> Vec<Vec<Found>> {
    let mut groups: Vec<Vec<Found>> = Vec::new();
    for line in lines {
        let beside =
            |group: &&mut Vec<Found>| group[0].direction.angle(&line.direction) < BESIDE_RAD;
        match groups.iter_mut().find(beside) {
            Some(group) => group.push(line),
            None => groups.push(vec![line]),
        }
    }
    groups
}

/// Adds a residual r of weight w, whose row is mostly zeros.
fn add_row(row: &DVector<f64>, r: f64, w: f64, equations: &mut NormalEquations) {
    let filled = row.iter().enumerate().filter(|(_, slope)| slope.abs() > 0.0);
    let filled: Vec<(usize, f64)> = filled.map(|(k, slope)| (k, *slope)).collect();
    for (first, &(column, slope)) in filled.iter().enumerate() {
        equations.gradient[column] += w * slope * r;
        for (k, other) in &filled[first..] {
            equations.hessian[(*k, column)] += w * slope * other;
        }
    }
}
