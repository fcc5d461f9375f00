//! What the shipped bodies' files must say, and what they say.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;

use super::factors::{Estimate, KNOWN, SHARED};
use super::quantities::quantities;

/// A body model's file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Body {
    Ellipsoids,
    Metaballs,
}

impl Body {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Ellipsoids => "human-ellipsoids",
            Self::Metaballs => "human-metaballs",
        }
    }
}

/// From which quantities a coefficient has its loadings: Σ weight · loading.
struct Rule {
    body: Body,
    coefficient: &'static str,
    from: &'static [(&'static str, f64)],
    own: Own,
}

/// The SD that a coefficient does not share.
#[derive(Clone, Copy)]
enum Own {
    /// The quantity's own, times a number; of several quantities, their mean.
    Times(f64),
    /// The last quantity's own, times the size of its weight.
    Last,
    /// The quantity's own and, independent of it, this (E).
    Beside(f64),
}

/// Of a station whose breadth and depth are coefficients: the girth keeps its own SD if each has √2 of it.
const EACH: Own = Own::Times(std::f64::consts::SQRT_2);
const SAME: Own = Own::Times(1.0);
/// Lengths of three parts that make up the trunk: their own SDs, .03, .03 and .025 (E), are enlarged in common so that the sum
/// .105, .175, .264 m has the trunk's.
const LOWER_TRUNK: Own = Own::Times(0.030 / 0.0166);
const CHEST: Own = Own::Times(0.025 / 0.0166);
/// A hand at rest is bent by more or less (E).
const HAND: Own = Own::Beside(0.04);

macro_rules! rules {
    ($($body:ident $coefficient:literal: [$(($quantity:literal, $weight:literal)),+] $own:expr;)*) => {
        &[$(Rule { body: Body::$body, coefficient: $coefficient, from: &[$(($quantity, $weight)),+], own: $own }),*]
    };
}

/// Every coefficient that the survey determines. Between two stations: the mean of both.
const RULES: &[Rule] = rules! {
    Ellipsoids "pelvis_height": [("trunk", 1.0)] LOWER_TRUNK;
    Ellipsoids "abdomen_length": [("trunk", 1.0)] LOWER_TRUNK;
    Ellipsoids "thorax_length": [("trunk", 1.0)] CHEST;
    // .170 m above T12/L1 = .262 of thorax less .092
    Ellipsoids "shoulder_height": [("trunk", 1.541), ("shoulder below C7/T1", -0.541)] Own::Last;
    Ellipsoids "neck_length": [("neck", 1.0)] SAME;
    Ellipsoids "head_length": [("head", 1.0)] SAME;
    Ellipsoids "upper_arm_length": [("upper arm", 1.0)] SAME;
    Ellipsoids "forearm_length": [("forearm", 1.0)] SAME;
    Ellipsoids "hand_length": [("hand length", 1.0)] HAND;
    Ellipsoids "thigh_length": [("thigh", 1.0)] SAME;
    Ellipsoids "shank_length": [("shank", 1.0)] SAME;
    Ellipsoids "foot_length": [("foot length", 1.0)] SAME;
    Ellipsoids "foot_height": [("ankle height", 1.0)] SAME;
    Ellipsoids "shoulder_distance": [("biacromial breadth", 1.0)] SAME;
    Ellipsoids "pelvis_width": [("hip breadth", 1.0)] SAME;
    Ellipsoids "pelvis_depth": [("buttock depth", 1.0)] SAME;
    Ellipsoids "abdomen_width": [("waist breadth", 1.0)] SAME;
    Ellipsoids "abdomen_depth": [("waist depth", 1.0)] SAME;
    Ellipsoids "thorax_width": [("chest breadth", 1.0)] SAME;
    Ellipsoids "thorax_depth": [("chest depth", 1.0)] SAME;
    Ellipsoids "neck_width": [("neck girth", 1.0)] SAME;
    Ellipsoids "head_width": [("head breadth", 1.0)] SAME;
    Ellipsoids "upper_arm_width": [("biceps girth", 1.0)] SAME;
    Ellipsoids "forearm_width": [("forearm girth", 1.0)] SAME;
    Ellipsoids "hand_width": [("hand breadth", 1.0)] HAND;
    Ellipsoids "thigh_width": [("thigh girth", 0.5), ("lower thigh girth", 0.5)] SAME;
    Ellipsoids "shank_width": [("calf girth", 1.0)] SAME;
    Ellipsoids "foot_width": [("foot breadth", 1.0)] SAME;
    Metaballs "crest_width": [("hip breadth", 0.5), ("waist breadth", 0.5)] SAME;
    Metaballs "crest_depth": [("buttock depth", 0.5), ("waist depth", 0.5)] SAME;
    Metaballs "rib_width": [("waist breadth", 0.5), ("chest breadth", 0.5)] SAME;
    Metaballs "rib_depth": [("waist depth", 0.5), ("chest depth", 0.5)] SAME;
    Metaballs "head_depth": [("head length", 1.0)] SAME;
    Metaballs "wrist_width": [("wrist girth", 1.0)] SAME;
    Metaballs "thigh_upper_width": [("thigh girth", 1.0)] EACH;
    Metaballs "thigh_upper_depth": [("thigh girth", 1.0)] EACH;
    Metaballs "thigh_width": [("thigh girth", 0.5), ("lower thigh girth", 0.5)] EACH;
    Metaballs "thigh_depth": [("thigh girth", 0.5), ("lower thigh girth", 0.5)] EACH;
    Metaballs "thigh_lower_width": [("lower thigh girth", 1.0)] SAME;
    Metaballs "shank_width": [("calf girth", 1.0)] EACH;
    Metaballs "calf_depth": [("calf girth", 1.0)] EACH;
    Metaballs "shin_width": [("calf girth", 0.5), ("ankle girth", 0.5)] SAME;
    Metaballs "ankle_width": [("ankle girth", 1.0)] SAME;
    Metaballs "heel_width": [("heel breadth", 1.0)] SAME;
};

/// What a file says, or must say, of one coefficient; log units.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
pub(crate) struct Entry {
    pub(crate) sd: f64,
    #[serde(default)]
    pub(crate) loadings: BTreeMap<String, f64>,
}

/// A coefficient of a file, with what the survey makes of it.
#[derive(Debug)]
pub(crate) struct Expected {
    pub(crate) body: Body,
    pub(crate) coefficient: &'static str,
    pub(crate) entry: Entry,
}

/// A loading below this is none.
const LEAST: f64 = 0.003;

/// Every coefficient that the survey determines, rounded as the files have it; girth for civilians.
pub(crate) fn expected(estimate: &Estimate, widening: f64) -> Vec<Expected> {
    let names: Vec<&str> = quantities().iter().map(|q| q.name).collect();
    let row = |quantity: &str| names.iter().position(|n| *n == quantity).unwrap_or_default();
    let one = |rule: &Rule| {
        let loading = |factor: usize| {
            let weighted = rule.from.iter().map(|(q, w)| w * estimate.loadings[(row(q), factor)]);
            let civil = if KNOWN.get(factor) == Some(&"girth") { widening } else { 1.0 };
            rounded(civil * weighted.sum::<f64>())
        };
        let loadings = factors().enumerate().map(|(k, name)| (name.to_owned(), loading(k)));
        let loadings = loadings.filter(|(_, value)| value.abs() >= LEAST).collect();
        let own = |quantity: &str| estimate.own[row(quantity)];
        let mean = rule.from.iter().map(|(q, _)| own(q)).sum::<f64>() / rule.from.len() as f64;
        let sd = match (rule.own, rule.from.last()) {
            (Own::Times(times), _) => times * mean,
            (Own::Last, Some((quantity, weight))) => weight.abs() * own(quantity),
            (Own::Beside(other), _) => mean.hypot(other),
            (Own::Last, None) => f64::NAN,
        };
        let entry = Entry { sd: rounded(sd), loadings };
        Expected { body: rule.body, coefficient: rule.coefficient, entry }
    };
    RULES.iter().map(one).collect()
}

/// Names of all factors, in the order of the loadings.
pub(crate) fn factors() -> impl Iterator<Item = &'static str> {
    KNOWN.into_iter().chain(SHARED.map(|(name, _)| name))
}

fn rounded(value: f64) -> f64 {
    (1e3 * value).round() / 1e3
}

/// What the body's file says of its coefficients. Of factors that the survey does not know it says nothing here.
pub(crate) fn said(body: Body) -> Result<BTreeMap<String, Entry>, Box<dyn std::error::Error>> {
    #[derive(Deserialize)]
    struct File {
        coefficient: Vec<Named>,
    }
    #[derive(Deserialize)]
    struct Named {
        name: String,
        #[serde(flatten)]
        entry: Entry,
    }
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../data/models");
    let text = std::fs::read_to_string(folder.join(format!("{}.toml", body.name())))?;
    let file: File = toml::from_str(&text)?;
    let known: Vec<&str> = factors().collect();
    let entries = file.coefficient.into_iter().map(|Named { name, mut entry }| {
        entry.loadings.retain(|factor, _| known.contains(&factor.as_str()));
        (name, entry)
    });
    Ok(entries.collect())
}

/// The coefficients that a file has otherwise than the survey: one line each.
pub(crate) fn differing(expected: &[Expected]) -> Result<Vec<String>, Box<dyn std::error::Error>> {
    let (ellipsoids, metaballs) = (said(Body::Ellipsoids)?, said(Body::Metaballs)?);
    let line = |e: &Expected| {
        let file = if e.body == Body::Ellipsoids { &ellipsoids } else { &metaballs };
        let found = file.get(e.coefficient);
        let differs = found != Some(&e.entry);
        differs.then(|| {
            let found = found.map_or("nothing".to_owned(), Entry::to_string);
            format!("{} {}: expected {}, found {found}", e.body.name(), e.coefficient, e.entry)
        })
    };
    Ok(expected.iter().filter_map(line).collect())
}

impl std::fmt::Display for Entry {
    /// As a model's file has it.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let shared = factors().filter_map(|name| self.loadings.get_key_value(name));
        let shared: Vec<String> = shared.map(|(name, value)| format!("{name} = {value}")).collect();
        write!(f, "sd = {}, loadings = {{ {} }}", self.sd, shared.join(", "))
    }
}
