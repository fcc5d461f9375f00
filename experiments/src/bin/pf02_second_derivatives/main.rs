//! PF02 App. A.2: lines of sight with complete derivatives against first-order ones.
//!
//! 20 arms before three cameras, ten starts each, up to 15 cm and 40° off. Silhouettes alone; model `arm`. With the
//! distance as residual the complete gradient has second derivatives of F; PF02's residual T − F has none, since ∇F·r
//! vanishes at the contact. Ways of one residual have one cost; its optimum is the least that any of them reached for
//! that arm. A start has arrived in its basin when its cost is within 5 % of that, and at it within 0.1 %.
//!
//! Where they do help: `contacts` searches the contact once and lets it move by second derivatives, or holds it.
//!
//! Starts: the pose that brings the model's joints nearest to the true ones, moved and turned by what is drawn. The paper
//! says of its starts only that they are "rough"; the question here is how far off they may be, so the truth must be known.

mod contacts;

use std::error::Error;
use std::process::ExitCode;

use experiments::limb::{
    ArmTruth, LimbFit, aligned, joints, limb_arm, limb_errors, pose, three_cameras, true_arm, views,
};
use experiments::picture::{Panel, colour, svg};
use experiments::run::Run;
use experiments::table::Table;
use kuva::plot::LegendPosition;
use maquette::body::{BodyModel, Posed, Shape, State};
use maquette::inference::prior::{PosePrior, ShapePrior};
use maquette::likelihood::{
    Derivatives, RayOptions, RayView, Residual, SilhouetteRays, SkinScale, Term,
};
use maquette::math::stats::median;
use maquette::solver::{Loss, Termination};
use nalgebra::{Rotation3, Unit, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

const ARMS: u64 = 20;
const STARTS: usize = 10;
/// By how much starts are off at most, metres and radians; and those of the comparison of contacts.
const FARTHEST: (f64, f64) = (0.15, 40.0 * std::f64::consts::PI / 180.0);
const NEARER: (f64, f64) = (0.03, 10.0 * std::f64::consts::PI / 180.0);
const MAX_ITERATIONS: usize = 100;
/// Share of the optimum's cost by which a cost may be larger: in the basin, and at the optimum.
const NEAR: [f64; 2] = [0.05, 0.001];

/// A residual with its derivatives.
struct Way {
    name: &'static str,
    title: &'static str,
    colour: &'static str,
    /// Which cost; ways of one number have the same.
    cost: usize,
    residual: Residual,
    /// One after another.
    derivatives: &'static [Derivatives],
    loss: Loss,
}

const WAYS: [Way; 7] = [
    Way {
        name: "metric_complete",
        title: "distance, complete",
        colour: colour::BLUE,
        cost: 0,
        residual: Residual::Metric,
        derivatives: &[Derivatives::Complete],
        loss: Loss::Cauchy(3.0),
    },
    Way {
        name: "metric_first_order",
        title: "distance, first order",
        colour: colour::BLUE,
        cost: 0,
        residual: Residual::Metric,
        derivatives: &[Derivatives::FirstOrder],
        loss: Loss::Cauchy(3.0),
    },
    Way {
        name: "metric_first_then_complete",
        title: "distance, first order, then complete",
        colour: colour::ORANGE,
        cost: 0,
        residual: Residual::Metric,
        derivatives: &[Derivatives::FirstOrder, Derivatives::Complete],
        loss: Loss::Cauchy(3.0),
    },
    Way {
        name: "metric_squared_complete",
        title: "distance squared, complete",
        colour: colour::GREEN,
        cost: 1,
        residual: Residual::Metric,
        derivatives: &[Derivatives::Complete],
        loss: Loss::Squared,
    },
    Way {
        name: "metric_squared_first_order",
        title: "distance squared, first order",
        colour: colour::GREEN,
        cost: 1,
        residual: Residual::Metric,
        derivatives: &[Derivatives::FirstOrder],
        loss: Loss::Squared,
    },
    Way {
        name: "field_complete",
        title: "T − F, complete",
        colour: colour::BLACK,
        cost: 2,
        residual: Residual::Field,
        derivatives: &[Derivatives::Complete],
        loss: Loss::Squared,
    },
    Way {
        name: "field_first_order",
        title: "T − F, first order",
        colour: colour::BLACK,
        cost: 2,
        residual: Residual::Field,
        derivatives: &[Derivatives::FirstOrder],
        loss: Loss::Squared,
    },
];

/// One arm, what is seen of it, and its starts.
struct Draw {
    truth: ArmTruth,
    views: Vec<RayView>,
    near: State,
    starts: Vec<State>,
    near_starts: Vec<State>,
}

/// One way's fits of one arm.
struct Fits {
    /// The least cost of all.
    optimum: f64,
    /// From each start the cost after each accepted step.
    costs: Vec<Vec<f64>>,
    joints_mm: Vec<f64>,
    stalled: usize,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("pf02_second_derivatives");
    run.setting("arms", ARMS);
    run.setting("starts of each", STARTS);
    run.setting("max iterations", MAX_ITERATIONS);
    let arm = limb_arm()?;
    let real = true_arm()?;
    let seed = run.seed() * ARMS;
    let draws: Vec<Draw> =
        (0..ARMS).into_par_iter().map(|i| Draw::new(&arm, &real, seed + i)).collect();
    let mut table = Table::new(
        "derivatives",
        &[
            "residual and derivatives",
            "in the basin, %",
            "at the optimum, %",
            "steps to the basin",
            "9th decile",
            "stalled, %",
            "joints, mm",
        ],
    );
    let mut all: Vec<Vec<Fits>> =
        WAYS.iter().map(|way| draws.par_iter().map(|draw| way.fit(&arm, draw)).collect()).collect();
    share_optima(&mut all);
    for (way, fits) in WAYS.iter().zip(&all) {
        report(&mut run, &mut table, way, fits);
    }
    run.table("200 starts", &table)?;
    let contacts = contacts::compare(&mut run, &arm, &draws);
    run.table("T − F with contacts that are renewed every third step", &contacts)?;
    run.picture("arrivals", &picture(&all))?;
    Ok(run.finish()?)
}

impl Draw {
    fn new(arm: &BodyModel, real: &BodyModel, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let truth = pose(real, &mut rng);
        let views = views(&truth, &three_cameras(), &mut rng);
        let shape = Shape(arm.statistics.mean.clone());
        let motion = aligned(arm, &shape, &joints(&truth.posed()));
        let near = State { motion, shape };
        let starts = (0..STARTS).map(|_| moved(&near, FARTHEST, &mut rng)).collect();
        let near_starts = (0..STARTS).map(|_| moved(&near, NEARER, &mut rng)).collect();
        Self { truth, views, near, starts, near_starts }
    }
}

/// A state moved and turned in a direction that is drawn.
fn moved(state: &State, (farthest, turned): (f64, f64), rng: &mut impl Rng) -> State {
    let mut direction = || {
        let drawn = Vector3::from_fn(|_, _| StandardNormal.sample(rng));
        Unit::new_normalize(drawn)
    };
    let (way, axis) = (direction(), direction());
    let mut state = state.clone();
    state.motion.position_world += way.scale(rng.random_range(0.0..farthest));
    let turn = rng.random_range(0.0..turned);
    state.motion.world_from_root *= Rotation3::from_axis_angle(&axis, turn);
    state
}

/// Gives ways of one cost the least of their optima, arm by arm.
fn share_optima(all: &mut [Vec<Fits>]) {
    for draw in 0..all.first().map_or(0, Vec::len) {
        for way in &WAYS {
            let same = WAYS.iter().zip(all.iter()).filter(|(w, _)| w.cost == way.cost);
            let least = same.map(|(_, fits)| fits[draw].optimum).fold(f64::INFINITY, f64::min);
            let same = WAYS.iter().zip(all.iter_mut()).filter(|(w, _)| w.cost == way.cost);
            same.for_each(|(_, fits)| fits[draw].optimum = least);
        }
    }
}

impl Way {
    fn fit(&self, arm: &BodyModel, draw: &Draw) -> Fits {
        let (prior, pose_prior) = (ShapePrior::new(arm), PosePrior::new(arm));
        let solve = |start: &State| {
            let (mut state, mut costs, mut ending) = (start.clone(), Vec::new(), None);
            for derivatives in self.derivatives {
                let terms = self.terms(arm, draw, *derivatives);
                let fit = LimbFit::new(arm, (&prior, &pose_prior), &terms);
                let solution = fit.solve(state, MAX_ITERATIONS);
                costs.extend(solution.report.costs);
                ending = Some(solution.report.termination);
                state = solution.state;
            }
            (state, costs, ending)
        };
        let near = solve(&draw.near).1;
        let solutions: Vec<_> = draw.starts.iter().map(solve).collect();
        let joints_mm = solutions.iter().map(|(state, _, _)| {
            let body = Posed::new(arm, &state.shape, &state.motion);
            limb_errors(&body, &draw.truth.posed()).joints_mm
        });
        let joints_mm = joints_mm.collect();
        let endings = solutions.iter().filter(|s| s.2 == Some(Termination::Stalled));
        let stalled = endings.count();
        let costs: Vec<Vec<f64>> = solutions.into_iter().map(|s| s.1).collect();
        let ends = costs.iter().chain([&near]).filter_map(|costs| costs.last());
        Fits { optimum: ends.copied().fold(f64::INFINITY, f64::min), costs, joints_mm, stalled }
    }

    fn terms(&self, arm: &BodyModel, draw: &Draw, derivatives: Derivatives) -> Vec<Box<dyn Term>> {
        let rays = RayOptions {
            residual: self.residual,
            derivatives,
            loss: self.loss,
            ..RayOptions::default()
        };
        let scale = SkinScale::new(arm);
        vec![Box::new(SilhouetteRays::new(draw.views.clone(), rays, scale))]
    }
}

impl Fits {
    /// Accepted steps until each start had come so near.
    fn arrived(&self, near: f64) -> impl Iterator<Item = Option<usize>> {
        let enough = self.optimum * (1.0 + near);
        let place = move |costs: &Vec<f64>| costs.iter().position(|cost| *cost <= enough);
        self.costs.iter().map(place)
    }
}

fn report(run: &mut Run, table: &mut Table, way: &Way, fits: &[Fits]) {
    let steps = |near: f64| -> Vec<f64> {
        let each = fits.iter().flat_map(|f| f.arrived(near)).flatten();
        let mut steps: Vec<f64> = each.map(|s| s as f64).collect();
        steps.sort_by(f64::total_cmp);
        steps
    };
    let [basin, exact] = NEAR.map(steps);
    let share = |count: usize| 100.0 * count as f64 / (ARMS as usize * STARTS) as f64;
    let mut off: Vec<f64> = fits.iter().flat_map(|f| f.joints_mm.iter().copied()).collect();
    let ninth = basin.get(basin.len() * 9 / 10).copied();
    let numbers = [
        ("in_basin_pct", share(basin.len())),
        ("at_optimum_pct", share(exact.len())),
        ("steps", median(&mut basin.clone()).unwrap_or(f64::NAN)),
        ("steps_ninth_decile", ninth.unwrap_or(f64::NAN)),
        ("stalled_pct", share(fits.iter().map(|f| f.stalled).sum())),
        ("joints_mm", median(&mut off).unwrap_or(f64::NAN)),
    ];
    for (name, value) in numbers {
        run.number(format!("{}_{name}", way.name), value);
    }
    let cells = numbers.iter().map(|(_, value)| format!("{value:.1}"));
    table.row(std::iter::once(way.title.to_owned()).chain(cells));
}

/// Share of the starts that had come so near after each number of steps.
fn arrivals(fits: &[Fits], near: f64) -> Vec<(f64, f64)> {
    let all: Vec<Option<usize>> = fits.iter().flat_map(|f| f.arrived(near)).collect();
    let by = |n: usize| all.iter().flatten().filter(|steps| **steps <= n).count();
    (0..=60).map(|n| (n as f64, 100.0 * by(n) as f64 / all.len() as f64)).collect()
}

fn picture(all: &[Vec<Fits>]) -> String {
    let panel = |title: &str, near: f64| {
        let empty = Panel::new(title, "accepted steps", "of 200 starts, %")
            .ranges((0.0, 60.0), (0.0, 100.0))
            .legend(LegendPosition::OutsideRightTop);
        WAYS.iter().zip(all).fold(empty, |panel, (way, fits)| {
            let curve = arrivals(fits, near);
            if way.derivatives == [Derivatives::FirstOrder] {
                panel.dashed(way.title, way.colour, &curve)
            } else {
                panel.curve(way.title, way.colour, &curve)
            }
        })
    };
    let panels = vec![
        panel("cost within 5 % of the optimum", NEAR[0]),
        panel("cost within 0.1 % of the optimum", NEAR[1]),
    ];
    svg(1, (680.0, 330.0), panels)
}
