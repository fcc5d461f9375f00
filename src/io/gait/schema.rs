//! `gait.json`, field by field; docs/gait.md explains them. Angles are in degrees.

use serde::Serialize;

use super::read::GaitInput;
use crate::gait::{
    Agreement, Angle, Curve, Event, EventSource, Extremes, GaitAnalysis, Indices, NeutralPose,
    Norm, Parameter, Score, Side, Statistic, Surface, Used, indices,
};

/// A gait analysis. Version 1.
#[derive(Debug, Serialize)]
struct GaitFile<'a> {
    /// `maquette-gait`.
    format: &'static str,
    /// 1.
    version: u32,
    /// `points`, or the name of the fitted body.
    source: &'a str,
    /// Frames per second.
    fps: f64,
    /// Number of frames.
    frames: usize,
    /// Cutoff of the low pass on all places; 0: none.
    cutoff_hz: f64,
    /// Floor or belt.
    surface: Surface,
    /// Speed of the belt; 0 on the floor.
    belt_m_s: f64,
    /// Speed of the pelvis in the room; negative: backwards.
    speed_in_room_m_s: f64,
    /// Hip to knee to ankle.
    leg_length_m: Option<f64>,
    /// What each place was taken from.
    used: &'a [Used],
    /// Foot strikes and foot offs, by time.
    events: &'a [Event],
    /// Who says when they are: `detected`, or a `person` who has corrected them.
    event_source: EventSource,
    /// How far the two methods agree.
    agreement: &'a [Agreement],
    /// Spatiotemporal parameters.
    parameters: Vec<ParameterPart<'a>>,
    /// Angles over the cycle.
    curves: Vec<CurvePart>,
    /// Scores against the norm, degrees.
    indices: Option<IndicesPart>,
    /// The norm.
    norm: Option<NormPart<'a>>,
    /// The standing pose that angles are counted from; `None`: anatomical axes.
    neutral: Option<NeutralPart<'a>>,
    /// Angles that cannot be known, and why.
    unknown: Vec<UnknownPart>,
    /// What a person should know.
    notes: &'a [String],
}

/// One parameter.
#[derive(Debug, Serialize)]
struct ParameterPart<'a> {
    /// Which.
    name: Parameter,
    /// Unit of all its numbers.
    unit: &'static str,
    /// Of the left side.
    left: Option<&'a Statistic>,
    /// Of the right side.
    right: Option<&'a Statistic>,
    /// Right over left.
    symmetry_percent: Option<f64>,
    /// Mean of left and right over its scale (Hof 1996): without unit.
    normalised: Option<f64>,
}

/// One angle over the cycle.
#[derive(Debug, Serialize)]
struct CurvePart {
    /// Which.
    angle: Angle,
    /// Whose cycle.
    side: Side,
    /// What a positive value means.
    positive: &'static str,
    /// Foot off, % of the cycle.
    foot_off_percent: f64,
    /// Whether the swing was recorded before the stance: the curve then breaks at foot off.
    is_joined: bool,
    /// Mean over strides, 0 to 100 %.
    mean_deg: Vec<f64>,
    /// Standard deviation over strides.
    sd_deg: Option<Vec<f64>>,
    /// Standard deviation of the angle, from the fit.
    fit_sd_deg: Option<Vec<f64>>,
    /// Stride by stride.
    strides_deg: Vec<Vec<f64>>,
    /// At foot strike.
    initial_contact_deg: f64,
    /// In stance, degrees.
    stance: Extremes,
    /// In swing, degrees.
    swing: Extremes,
    /// Greatest minus least.
    range_deg: f64,
}

/// The norm.
#[derive(Debug, Serialize)]
struct NormPart<'a> {
    /// Its name.
    name: &'a str,
    /// Where its numbers are from.
    source: &'a str,
    /// Where those of steps and strides are from, if from elsewhere.
    parameters_source: Option<&'a str>,
    /// What to know before comparing with its curves.
    remarks: &'a [String],
}

/// An angle that cannot be known.
#[derive(Debug, Serialize)]
struct UnknownPart {
    /// Which.
    angle: Angle,
    /// Why.
    reason: &'static str,
}

/// A standing pose.
#[derive(Debug, Serialize)]
struct NeutralPart<'a> {
    /// The trial that shows it.
    source: &'a str,
    /// Its angles.
    angles: Vec<NeutralAngle>,
}

/// An angle of a standing pose.
#[derive(Debug, Serialize)]
struct NeutralAngle {
    /// Which.
    angle: Angle,
    /// Whose.
    side: Side,
    /// What was taken from it.
    deg: f64,
}

/// Scores against a norm, degrees.
#[derive(Debug, Serialize)]
struct IndicesPart {
    /// GVS of each variable.
    variables: Vec<VariablePart>,
    /// GPS of the left side; only where all nine variables are known.
    left: Option<f64>,
    /// GPS of the right side.
    right: Option<f64>,
    /// GPS of both.
    both: Option<f64>,
    /// The same without the offsets of the curves.
    without_offset: ProfilePart,
}

/// GPS₀, degrees.
#[derive(Debug, Serialize)]
struct ProfilePart {
    /// Of the left side.
    left: Option<f64>,
    /// Of the right side.
    right: Option<f64>,
    /// Of both.
    both: Option<f64>,
}

/// The score of one variable.
#[derive(Debug, Serialize)]
struct VariablePart {
    /// The variable.
    angle: Angle,
    /// Whose.
    side: Side,
    /// GVS, degrees; absent where the norm counts the angle from another zero.
    score: Option<f64>,
    /// GVS₀, degrees.
    without_offset: f64,
}

/// What `gait.json` holds.
pub fn gait_file<'a>(
    input: &'a GaitInput,
    gait: &'a GaitAnalysis,
    norm: Option<&'a Norm>,
) -> impl Serialize + use<'a> {
    let unknown = |(angle, reason): &(Angle, &'static str)| UnknownPart { angle: *angle, reason };

    GaitFile {
        format: "maquette-gait",
        version: 1,
        source: &input.source,
        fps: input.movement.rate_hz,
        frames: input.movement.frames,
        cutoff_hz: gait.cutoff_hz,
        surface: gait.course.surface,
        belt_m_s: gait.course.belt_m_s,
        speed_in_room_m_s: gait.course.speed_m_s,
        leg_length_m: gait.leg_length_m,
        used: &input.movement.used,
        events: &gait.events,
        event_source: gait.event_source,
        agreement: &gait.agreement,
        parameters: parameters(gait),
        curves: gait.curves.iter().map(curve).collect(),
        indices: norm.and_then(|norm| Some(scores(&indices(&gait.curves, norm)?))),
        norm: norm.map(|norm| NormPart {
            name: &norm.name,
            source: &norm.source,
            parameters_source: norm.parameters_source.as_deref(),
            remarks: &norm.remarks,
        }),
        neutral: gait.neutral.as_ref().map(neutral),
        unknown: gait.unknown.iter().map(unknown).collect(),
        notes: &gait.notes,
    }
}

fn neutral(pose: &NeutralPose) -> NeutralPart<'_> {
    let angles = pose.angles.iter();
    let angles = angles.map(|(&(side, angle), radians)| NeutralAngle {
        angle,
        side,
        deg: radians.to_degrees(),
    });
    NeutralPart { source: &pose.source, angles: angles.collect() }
}

fn parameters(gait: &GaitAnalysis) -> Vec<ParameterPart<'_>> {
    let part = |name: Parameter| {
        let statistic = |side| gait.parameters.get(&(name, side));
        let (left, right) = (statistic(Side::Left), statistic(Side::Right));
        let is_known = left.is_some() || right.is_some();
        is_known.then(|| ParameterPart {
            name,
            unit: name.unit(),
            symmetry_percent: gait.symmetry_percent(name),
            normalised: gait.normalised(name),
            left,
            right,
        })
    };
    Parameter::ALL.into_iter().filter_map(part).collect()
}

fn curve(curve: &Curve) -> CurvePart {
    let degrees = |values: &Vec<f64>| values.iter().map(|v| v.to_degrees()).collect();
    let key = curve.key_points();
    CurvePart {
        angle: curve.angle,
        side: curve.side,
        positive: curve.angle.positive(),
        foot_off_percent: 100.0 * curve.foot_off,
        is_joined: curve.is_joined,
        mean_deg: degrees(&curve.mean),
        sd_deg: curve.sd.as_ref().map(degrees),
        fit_sd_deg: curve.fit_sd.as_ref().map(degrees),
        strides_deg: curve.strides.iter().map(degrees).collect(),
        initial_contact_deg: key.initial_contact.to_degrees(),
        stance: extremes(key.stance),
        swing: extremes(key.swing),
        range_deg: key.range.to_degrees(),
    }
}

fn extremes(extremes: Extremes) -> Extremes {
    Extremes {
        least: extremes.least.to_degrees(),
        greatest: extremes.greatest.to_degrees(),
        ..extremes
    }
}

fn scores(indices: &Indices) -> IndicesPart {
    let variables = indices.variables.iter();
    let part = |(&(side, angle), score): (&(Side, Angle), &Score)| VariablePart {
        angle,
        side,
        score: score.whole.map(f64::to_degrees),
        without_offset: score.without_offset.to_degrees(),
    };
    let whole = |score: Option<Score>| Some(score?.whole?.to_degrees());
    let rest = |score: Option<Score>| Some(score?.without_offset.to_degrees());

    IndicesPart {
        variables: variables.map(part).collect(),
        left: whole(indices.left),
        right: whole(indices.right),
        both: whole(indices.both),
        without_offset: ProfilePart {
            left: rest(indices.left),
            right: rest(indices.right),
            both: rest(indices.both),
        },
    }
}
