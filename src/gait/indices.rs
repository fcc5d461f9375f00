//! How far curves lie from those of healthy people: Gait Variable Scores, Movement Analysis Profile, Gait Profile Score.
//!
//! GVS of one variable = root mean square over the cycle (51 points) of the curve less the norm's mean. The Movement
//! Analysis Profile is the GVS of all nine variables of both sides. GPS of one side = root mean square of its nine GVS;
//! the GPS of both sides takes the pelvis from the left, and hip, knee, ankle and foot of both, fifteen in all.
//!
//! A constant offset of a curve, from another idea of where joints lie and what neutral is, goes into the score in full. With d the
//! difference at the points, d̄ its mean over the cycle, and GVS₀ the root mean square of d − d̄,
//!
//! GVS² = d̄² + GVS₀².
//!
//! GVS₀ is the score *without offset*, and GPS₀ the root mean square of nine of them. It does not see a person who really holds a joint
//! differently all the time.
//!
//! # Source
//! GVS and GPS: Baker et al., Gait Posture 30 (2009) 265–269. GVS₀ is ours; that offset and form of curves are told apart is as in
//! Iosa et al., BioMed Res. Int. 2014, 214156.

use std::collections::BTreeMap;

use super::angle::Angle;
use super::beyond::{Beyond, Footwear};
use super::curves::{Curve, POINTS};
use super::landmark::Side;
use super::neutral::Zero;
use super::parameters::Parameter;

/// Points at which a score compares: every 2 % of the cycle.
pub const SCORE_POINTS: usize = 51;

/// The nine variables of the score.
pub const VARIABLES: [Angle; 9] = [
    Angle::PelvisTilt,
    Angle::PelvisObliquity,
    Angle::PelvisRotation,
    Angle::HipFlexion,
    Angle::HipAdduction,
    Angle::HipRotation,
    Angle::KneeFlexion,
    Angle::AnkleDorsiflexion,
    Angle::FootProgression,
];

/// Mean and standard deviation of healthy people.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// Mean.
    pub mean: Vec<f64>,
    /// Standard deviation between people.
    pub sd: Vec<f64>,
}

/// What healthy people do.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Norm {
    /// Name.
    pub name: String,
    /// Where the numbers are from, and of whom.
    pub source: String,
    /// First and last year of life of the people of the curves, if they are known.
    pub ages: Option<[u32; 2]>,
    /// What to know before a person is compared with the curves, each in one line.
    pub remarks: Vec<String>,
    /// Angles over the cycle at [`SCORE_POINTS`] points, radians.
    pub curves: BTreeMap<Angle, Band>,
    /// Mean and standard deviation of parameters, in their units.
    pub parameters: BTreeMap<Parameter, (f64, f64)>,
    /// Where the parameters are from, and of whom; `None`: as the curves.
    pub parameters_source: Option<String>,
    /// What the people of the curves wore, if it is known.
    pub footwear: Option<Footwear>,
    /// What the people of the parameters wore, if it is known.
    pub parameters_footwear: Option<Footwear>,
    /// What its angles are counted from.
    pub zero: Zero,
    /// What those of the walk are counted from that is compared with it.
    pub walk_zero: Zero,
}

/// What to know where both are not the same.
const OTHER_ZERO: &str = "the walk and the norm count angles from another zero, a standing pose and anatomical axes: only the form of curves is compared, by scores without offset";

impl Norm {
    /// What to know before a person in this footwear is compared with the curves, each in one line.
    pub fn cautions(&self, person: Option<Footwear>) -> Vec<String> {
        let of_footwear = Footwear::caution(self.footwear, person);
        let of_footwear = of_footwear.filter(|_| !self.curves.is_empty());
        of_footwear
            .map(|caution| caution.to_string())
            .into_iter()
            .chain(self.remarks.iter().cloned())
            .collect()
    }

    /// Where a parameter lies beyond those of healthy people; `None` within, and where the norm has none.
    pub fn beyond(&self, parameter: Parameter, value: f64) -> Option<Beyond> {
        let (mean, sd) = self.parameters.get(&parameter)?;
        Beyond::new(value, *mean, *sd)
    }

    /// The same for a walk whose angles are counted from this.
    pub fn for_zero(mut self, zero: Zero) -> Self {
        self.walk_zero = zero;
        self.remarks.retain(|remark| remark != OTHER_ZERO);
        if self.zero != zero {
            self.remarks.push(OTHER_ZERO.into());
        }
        self
    }

    /// What healthy people's curves of an angle are; `None` where only their form compares.
    pub fn band(&self, angle: Angle) -> Option<&Band> {
        let has_one_zero = self.zero == self.walk_zero || !angle.has_standing_zero();
        self.curves.get(&angle).filter(|_| has_one_zero)
    }

    /// Where an angle lies beyond those of healthy people at the same place of the cycle, in percent; radians.
    pub fn beyond_at(&self, angle: Angle, percent: usize, value: f64) -> Option<Beyond> {
        let band = self.band(angle)?;
        let at = (percent * (SCORE_POINTS - 1) + 50) / 100;
        Beyond::new(value, *band.mean.get(at)?, *band.sd.get(at)?)
    }
}

/// How far curves lie from those of healthy people, root mean square, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// GVS or GPS; `None` where the norm counts the angle, or one of the nine, from another zero.
    pub whole: Option<f64>,
    /// GVS₀ or GPS₀.
    pub without_offset: f64,
}

/// The scores of a walk.
#[derive(Debug, Clone, PartialEq)]
pub struct Indices {
    /// The Movement Analysis Profile: the GVS of each variable that is known.
    pub variables: BTreeMap<(Side, Angle), Score>,
    /// GPS of the left side; only where all nine variables are known.
    pub left: Option<Score>,
    /// GPS of the right side.
    pub right: Option<Score>,
    /// GPS of both.
    pub both: Option<Score>,
}

impl Score {
    /// Of differences at the points of a cycle.
    fn of_differences(differences: &[f64]) -> Self {
        let count = differences.len() as f64;
        let offset = differences.iter().sum::<f64>() / count;
        let root_mean = |of: &dyn Fn(&f64) -> f64| {
            (differences.iter().map(|d| of(d).powi(2)).sum::<f64>() / count).sqrt()
        };
        Self { whole: Some(root_mean(&|d| *d)), without_offset: root_mean(&|d| d - offset) }
    }

    /// The root mean square of several scores.
    fn together(scores: &[Self]) -> Self {
        let root_mean = |squares: f64| (squares / scores.len() as f64).sqrt();
        let whole: Option<f64> = scores.iter().map(|score| Some(score.whole?.powi(2))).sum();
        let rest = scores.iter().map(|score| score.without_offset.powi(2)).sum();
        Self { whole: whole.map(root_mean), without_offset: root_mean(rest) }
    }
}

/// The scores of curves against a norm; `None` if they have no variable in common.
pub fn indices(curves: &[Curve], norm: &Norm) -> Option<Indices> {
    let score = |curve: &Curve| {
        let band = norm.curves.get(&curve.angle)?;
        let step = (POINTS - 1) / (SCORE_POINTS - 1);
        let differences = (0..SCORE_POINTS).map(|i| curve.mean[i * step] - band.mean[i]);
        let mut score = Score::of_differences(&differences.collect::<Vec<_>>());
        score.whole = score.whole.filter(|_| norm.band(curve.angle).is_some());
        Some(((curve.side, curve.angle), score))
    };
    let scored = curves.iter().filter(|c| VARIABLES.contains(&c.angle));
    let variables: BTreeMap<_, Score> = scored.filter_map(score).collect();

    let of = |side: Side, angles: &[Angle]| -> Option<Vec<Score>> {
        angles.iter().map(|angle| variables.get(&(side, *angle)).copied()).collect()
    };
    let left = of(Side::Left, &VARIABLES);
    let right_leg = of(Side::Right, &VARIABLES[3..]);
    let both = left.clone().zip(right_leg).map(|(left, leg)| [left, leg].concat());

    let profile = |scores: Option<Vec<Score>>| scores.map(|scores| Score::together(&scores));
    let indices = Indices {
        left: profile(left),
        right: profile(of(Side::Right, &VARIABLES)),
        both: profile(both),
        variables,
    };
    (!indices.variables.is_empty()).then_some(indices)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walk(offset: f64) -> (Vec<Curve>, Norm) {
        let curve = |(angle, side): (Angle, Side)| Curve {
            angle,
            side,
            strides: Vec::new(),
            mean: vec![offset; POINTS],
            sd: None,
            fit_sd: None,
            foot_off: 0.6,
            is_joined: false,
        };
        let both = Side::BOTH.into_iter().flat_map(|s| VARIABLES.map(|a| (a, s)));
        let band = || Band { mean: vec![0.0; SCORE_POINTS], sd: vec![1.0; SCORE_POINTS] };
        let norm = Norm {
            curves: VARIABLES.into_iter().map(|a| (a, band())).collect(),
            ..Norm::default()
        };
        (both.map(curve).collect(), norm)
    }

    #[test]
    fn a_walk_that_is_everywhere_as_far_off_scores_that_distance() {
        let (curves, norm) = walk(0.1);
        let found = indices(&curves, &norm).unwrap();
        assert_eq!(found.variables.len(), 18);
        for gps in [found.left, found.right, found.both] {
            approx::assert_relative_eq!(gps.unwrap().whole.unwrap(), 0.1, epsilon = 1e-12);
            approx::assert_relative_eq!(gps.unwrap().without_offset, 0.0, epsilon = 1e-12);
        }
    }

    #[test]
    fn offset_and_what_is_left_make_up_the_score() {
        let (mut curves, norm) = walk(0.1);
        for curve in &mut curves {
            for (i, angle) in curve.mean.iter_mut().enumerate() {
                *angle += 0.05 * (std::f64::consts::TAU * i as f64 / 100.0).sin();
            }
        }
        let found = indices(&curves, &norm).unwrap().both.unwrap();
        // a sine of amplitude a over whole periods has the root mean square a/√2, but for the one point that is there twice
        approx::assert_relative_eq!(found.without_offset, 0.05 / 2_f64.sqrt(), max_relative = 0.02);
        approx::assert_relative_eq!(
            found.whole.unwrap(),
            found.without_offset.hypot(0.1),
            epsilon = 1e-12
        );
    }

    #[test]
    fn of_angles_from_another_zero_only_the_form_is_scored() {
        let (curves, norm) = walk(0.1);
        let found = indices(&curves, &norm.clone().for_zero(Zero::Standing)).unwrap();
        let both = found.both.unwrap();
        assert_eq!(both.whole, None);
        approx::assert_relative_eq!(both.without_offset, 0.0, epsilon = 1e-12);
        // against the direction of walking there is no standing pose
        let score = |angle| found.variables[&(Side::Left, angle)].whole;
        assert!(score(Angle::FootProgression).is_some() && score(Angle::KneeFlexion).is_none());
        assert_eq!(norm.clone().for_zero(Zero::Standing).for_zero(Zero::Anatomical), norm);
    }

    #[test]
    fn a_side_without_one_of_the_nine_has_no_profile_score() {
        let (mut curves, norm) = walk(0.1);
        curves.retain(|c| c.angle != Angle::HipRotation || c.side == Side::Left);
        let found = indices(&curves, &norm).unwrap();
        assert!(found.left.is_some() && found.right.is_none() && found.both.is_none());
    }
}
