//! `gait.json`, field by field; docs/gait.md explains them. Angles are in degrees.

use serde::Serialize;

use super::read::GaitInput;
use crate::gait::{
    Agreement, Angle, Curve, Event, Extremes, GaitAnalysis, Indices, Norm, Parameter, Side,
    Statistic, Surface, Used, indices,
};

/// A gait analysis. Version 1.
#[derive(Debug, Serialize)]
pub struct GaitFile {
    /// `maquette-gait`.
    pub format: &'static str,
    /// 1.
    pub version: u32,
    /// `points`, or the name of the fitted body.
    pub source: String,
    /// Frames per second.
    pub fps: f64,
    /// Number of frames.
    pub frames: usize,
    /// Cutoff of the low pass on all places; 0: none.
    pub cutoff_hz: f64,
    /// Floor or belt.
    pub surface: Surface,
    /// Speed of the belt; 0 on the floor.
    pub belt_m_s: f64,
    /// Speed of the pelvis in the room; negative: backwards.
    pub speed_in_room_m_s: f64,
    /// Hip to knee to ankle.
    pub leg_length_m: Option<f64>,
    /// What each place was taken from.
    pub used: Vec<Used>,
    /// Foot strikes and foot offs, by time.
    pub events: Vec<Event>,
    /// How far the two methods agree.
    pub agreement: Vec<Agreement>,
    /// Spatiotemporal parameters.
    pub parameters: Vec<ParameterPart>,
    /// Angles over the cycle.
    pub curves: Vec<CurvePart>,
    /// Scores against the norm, degrees.
    pub indices: Option<Indices>,
    /// The norm.
    pub norm: Option<NormPart>,
    /// Angles that cannot be known, and why.
    pub unknown: Vec<UnknownPart>,
    /// What a person should know.
    pub notes: Vec<String>,
}

/// One parameter.
#[derive(Debug, Serialize)]
pub struct ParameterPart {
    /// Which.
    pub name: Parameter,
    /// Unit of all its numbers.
    pub unit: &'static str,
    /// Of the left side.
    pub left: Option<Statistic>,
    /// Of the right side.
    pub right: Option<Statistic>,
    /// Right over left.
    pub symmetry_percent: Option<f64>,
    /// Mean of left and right over its scale (Hof 1996): without unit.
    pub normalised: Option<f64>,
}

/// One angle over the cycle.
#[derive(Debug, Serialize)]
pub struct CurvePart {
    /// Which.
    pub angle: Angle,
    /// Whose cycle.
    pub side: Side,
    /// What a positive value means.
    pub positive: &'static str,
    /// Foot off, % of the cycle.
    pub foot_off_percent: f64,
    /// Whether the swing was recorded before the stance: the curve then breaks at foot off.
    pub is_joined: bool,
    /// Mean over strides, 0 to 100 %.
    pub mean_deg: Vec<f64>,
    /// Standard deviation over strides.
    pub sd_deg: Option<Vec<f64>>,
    /// Standard deviation of the angle, from the fit.
    pub fit_sd_deg: Option<Vec<f64>>,
    /// Stride by stride.
    pub strides_deg: Vec<Vec<f64>>,
    /// At foot strike.
    pub initial_contact_deg: f64,
    /// In stance, degrees.
    pub stance: Extremes,
    /// In swing, degrees.
    pub swing: Extremes,
    /// Greatest minus least.
    pub range_deg: f64,
}

/// The norm.
#[derive(Debug, Serialize)]
pub struct NormPart {
    /// Its name.
    pub name: String,
    /// Where its numbers are from.
    pub source: String,
    /// Where those of steps and strides are from, if from elsewhere.
    pub parameters_source: Option<String>,
}

/// An angle that cannot be known.
#[derive(Debug, Serialize)]
pub struct UnknownPart {
    /// Which.
    pub angle: Angle,
    /// Why.
    pub reason: &'static str,
}

/// The file of an analysis.
pub fn gait_file(input: &GaitInput, gait: &GaitAnalysis, norm: Option<&Norm>) -> GaitFile {
    let unknown = |(angle, reason): &(Angle, &'static str)| UnknownPart { angle: *angle, reason };
    let indices = norm.and_then(|norm| Some(in_degrees(indices(&gait.curves, norm)?)));
    let norm = norm.map(|norm| NormPart {
        name: norm.name.clone(),
        source: norm.source.clone(),
        parameters_source: norm.parameters_source.clone(),
    });

    GaitFile {
        format: "maquette-gait",
        version: 1,
        source: input.source.clone(),
        fps: input.movement.rate_hz,
        frames: input.movement.frames,
        cutoff_hz: gait.cutoff_hz,
        surface: gait.course.surface,
        belt_m_s: gait.course.belt_m_s,
        speed_in_room_m_s: gait.course.speed_m_s,
        leg_length_m: gait.leg_length_m,
        used: input.movement.used.clone(),
        events: gait.events.clone(),
        agreement: gait.agreement.clone(),
        parameters: parameters(gait),
        curves: gait.curves.iter().map(curve).collect(),
        indices,
        norm,
        unknown: gait.unknown.iter().map(unknown).collect(),
        notes: gait.notes.clone(),
    }
}

fn parameters(gait: &GaitAnalysis) -> Vec<ParameterPart> {
    let part = |name: Parameter| {
        let statistic = |side| gait.parameters.get(&(name, side)).cloned();
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

fn in_degrees(mut indices: Indices) -> Indices {
    for variable in &mut indices.variables {
        variable.score = variable.score.to_degrees();
    }
    for score in [&mut indices.left, &mut indices.right, &mut indices.both] {
        *score = score.map(f64::to_degrees);
    }
    indices
}
