//! Time and memory of the joint optimum, for sequences of any length (ZS06 call it intractable).
//!
//! A person walks one gait cycle before three cameras; 200, 2 000 and 20 000 frames are that cycle, forwards and
//! backwards by turns. What the cameras saw is shared between them, every frame's terms are its own. Timed are one
//! linearisation, one step and the marginal covariances, and, for the memory, a whole joint optimum of one step.
//! Then the whole joint optimum of seven cameras and 200 frames, from Algorithm 1's winner.
//!
//! Starts: the joint optima begin at Algorithm 1's winner, which is found from nothing.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use experiments::picture::{Panel, colour, svg};
use experiments::run::Run;
use experiments::table::Table;
use experiments::walker;
use maquette::body::BodyModel;
use maquette::inference::SequenceState;
use maquette::inference::camera_prior::CameraPrior;
use maquette::inference::contrasts::Contrasts;
use maquette::inference::joint::{JointOptions, joint_optimum, joint_optimum_from_terms};
use maquette::inference::motion_prior::MotionPrior;
use maquette::inference::noise::DataWeights;
use maquette::inference::search::{NoJournal, SearchOptions, search};
use maquette::inference::sequence_posterior::SequencePosterior;
use maquette::inference::{Detail, Evidence, Look, Sequence, SequenceTerms};
use maquette::io::model;
use maquette::likelihood::{LikelihoodOptions, Measure};
use maquette::silhouette::FrameObservations;
use maquette::solver::{Problem, QuadraticModel};
use maquette::synth::Synthetic;

/// Frames, and how often each is timed.
const LENGTHS: [(usize, usize); 3] = [(200, 10), (2_000, 3), (20_000, 1)];
const INTERVAL_S: f64 = 0.02;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("joint_scaling");
    let model = model::load("human-metaballs", Path::new(""))?;
    scaling(&mut run, &model)?;
    seven_cameras(&mut run, &model)?;
    Ok(run.finish()?)
}

/// One gait cycle, fitted.
struct Cycle<'a> {
    evidence: Evidence<'a>,
    frames: &'a [FrameObservations],
    fitted: SequenceState,
}

/// What one length took, milliseconds and kilobytes a frame.
#[derive(Default)]
struct Cost {
    frames: usize,
    /// Linearisation, step, marginals.
    stages_ms: [f64; 3],
    /// The three together, of all threads.
    processor_ms: f64,
    /// A joint optimum of one step and one round.
    whole_ms: f64,
    memory_kb: f64,
}

fn scaling(run: &mut Run, model: &BodyModel) -> Result<(), Box<dyn Error>> {
    let recording = walker::seen_by(3, None, run.seed())?;
    let frames = walker::observe(&recording);
    let cycle = Cycle {
        fitted: tracked(model, &recording, &frames).ok_or("nothing was found")?,
        evidence: evidence(model, &recording, Measure::Metaballs),
        frames: &frames,
    };
    let before_kb = memory_kb("VmRSS:");
    let mut costs = Vec::new();
    for (length, times) in LENGTHS {
        costs.push(cycle.cost(length, times, before_kb));
    }
    report(run, &costs)?;
    let curve = |value: fn(&Cost) -> f64| -> Vec<(f64, f64)> {
        let at = |c: &Cost| ((c.frames as f64).log10(), value(c));
        costs.iter().map(at).collect()
    };
    let highest = |value: fn(&Cost) -> f64| 1.3 * costs.iter().map(value).fold(0.0, f64::max);
    let panel = |title, label, value: fn(&Cost) -> f64| {
        Panel::new(title, "log₁₀ number of frames", label)
            .ranges((2.0, 4.6), (0.0, highest(value)))
            .curve("", colour::BLUE, &curve(value))
            .marks("", colour::BLUE, &curve(value))
    };
    let time = panel("linearisation, step and marginals", "processor time a frame (ms)", |c| {
        c.processor_ms
    });
    let memory = panel("the joint optimum", "memory a frame (kB)", |c| c.memory_kb);
    run.picture("costs", &svg(2, (420.0, 280.0), vec![time, memory]))?;
    Ok(())
}

fn evidence<'a>(model: &'a BodyModel, recording: &'a Synthetic, measure: Measure) -> Evidence<'a> {
    Evidence::new(model, &recording.rig, LikelihoodOptions::default(), measure)
}

/// Algorithm 1's winner, on ellipsoids.
fn tracked(
    model: &BodyModel,
    recording: &Synthetic,
    frames: &[FrameObservations],
) -> Option<SequenceState> {
    let sequence = Sequence { frames, fps: recording.fps };
    let coarse = evidence(model, recording, Measure::Ellipses);
    let found = search(&coarse, sequence, &SearchOptions::default(), &NoJournal)?;
    let winner = found.trials.get(found.winner)?;
    let motions = winner.frames.iter().flatten().map(|f| f.motion.clone());
    Some(SequenceState::new(winner.hypothesis.shape.clone(), motions.collect()))
}

impl Cycle<'_> {
    /// Which frame of the cycle stands at `i`: forwards, backwards, and so on.
    fn at(&self, i: usize) -> usize {
        let last = self.frames.len() - 1;
        let k = i % (2 * last);
        k.min(2 * last - k)
    }

    fn terms(&self, length: usize) -> SequenceTerms<'_> {
        let one = |i, detail| self.evidence.looks_of_all(&self.frames[self.at(i)], detail);
        SequenceTerms {
            thinned: (0..length).map(|i| one(i, Detail::Thinned)).collect(),
            all: (0..length).map(|i| one(i, Detail::Fine)).collect(),
            camera_prior: CameraPrior::trusting(),
        }
    }

    fn state(&self, length: usize) -> SequenceState {
        let motion = |i| self.fitted.motions[self.at(i)].clone();
        SequenceState::new(self.fitted.shape.clone(), (0..length).map(motion).collect())
    }

    fn cost(&self, length: usize, times: usize, before_kb: f64) -> Cost {
        let (terms, seconds) = (self.terms(length), vec![INTERVAL_S; length]);
        let options = JointOptions { iterations: 1, ..JointOptions::default() };
        let mut cost = Cost::default();
        for _ in 0..times {
            let share = 1.0 / times as f64;
            let before_s = processor_s();
            let stages = self.stages_ms(&terms.all, &seconds);
            cost.processor_ms += share * 1e3 * (processor_s() - before_s) / length as f64;
            for (mean, ms) in cost.stages_ms.iter_mut().zip(stages) {
                *mean += share * ms;
            }
            let state = self.state(length);
            let started = Instant::now();
            joint_optimum_from_terms(&self.evidence, &terms, &seconds, state, &options, &|| {});
            cost.whole_ms += share * 1e3 * started.elapsed().as_secs_f64() / length as f64;
        }
        Cost {
            frames: length,
            memory_kb: (memory_kb("VmHWM:") - before_kb) / length as f64,
            ..cost
        }
    }

    /// One linearisation, one step, the marginals: milliseconds a frame.
    fn stages_ms(&self, looks: &[Vec<Look<'_>>], seconds: &[f64]) -> [f64; 3] {
        let motion_prior =
            MotionPrior::new(self.evidence.model, JointOptions::default().motion_model);
        let looks: Vec<Vec<&Look<'_>>> = looks.iter().map(|frame| frame.iter().collect()).collect();
        let posterior = SequencePosterior {
            model: self.evidence.model,
            rig: self.evidence.rig,
            camera_prior: &CameraPrior::trusting(),
            shape_prior: &self.evidence.shape_prior,
            motion_prior: &motion_prior,
            seconds,
            looks: &looks,
            weights: DataWeights::all(1.0),
            contrasts: &Contrasts::none(looks.len()),
        };
        let state = self.state(looks.len());
        let mut chain = posterior.empty_model();
        let mut started = Instant::now();
        let mut lap_ms = || {
            let ms = 1e3 * started.elapsed().as_secs_f64() / looks.len() as f64;
            started = Instant::now();
            ms
        };
        posterior.linearize(&state, &mut chain);
        let linearisation = lap_ms();
        let step = chain.minimizer(1e-4);
        let step_ms = lap_ms();
        let complete = chain.marginals(|_, _| ());
        let marginals = lap_ms();
        match step {
            Some(_) if complete => [linearisation, step_ms, marginals],
            _ => [f64::NAN; 3],
        }
    }
}

/// A line of the process' status, kilobytes; NaN where the system has none.
fn memory_kb(line: &str) -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let value = status.lines().find_map(|l| l.strip_prefix(line));
    let number = value.and_then(|v| v.split_whitespace().next()?.parse().ok());
    number.unwrap_or(f64::NAN)
}

/// Time that the processors gave this process, seconds; NaN where the system does not tell.
fn processor_s() -> f64 {
    // user and system time are the 14th and 15th number, in hundredths; the name before them ends with ")"
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let numbers = stat.rsplit(')').next().unwrap_or_default();
    let mut times = numbers.split_whitespace().skip(11).map(str::parse::<f64>);
    match (times.next(), times.next()) {
        (Some(Ok(user)), Some(Ok(system))) => (user + system) / 100.0,
        _ => f64::NAN,
    }
}

fn report(run: &mut Run, costs: &[Cost]) -> Result<(), Box<dyn Error>> {
    let columns = [
        "frames",
        "linearisation, ms",
        "step, ms",
        "marginals, ms",
        "together, ms",
        "of the processors, ms",
        "joint optimum of one step and one round, ms",
        "memory, kB",
    ];
    let mut table = Table::new("costs", &columns);
    for c in costs {
        let [linearisation, step, marginals] = c.stages_ms;
        let once = linearisation + step + marginals;
        let figures = [linearisation, step, marginals, once, c.processor_ms, c.whole_ms];
        let figures = figures.map(|ms| format!("{ms:.3}"));
        let cells = std::iter::once(c.frames.to_string()).chain(figures);
        table.row(cells.chain([format!("{:.0}", c.memory_kb)]));
        run.number(format!("ms_a_frame_{}", c.frames), once);
        run.number(format!("processor_ms_a_frame_{}", c.frames), c.processor_ms);
        run.number(format!("kb_a_frame_{}", c.frames), c.memory_kb);
    }
    if let [first, .., last] = costs {
        run.number("processor_time_growth", last.processor_ms / first.processor_ms);
        run.number("memory_growth", last.memory_kb / first.memory_kb);
    }
    run.table("A frame of three cameras", &table)?;
    Ok(())
}

fn seven_cameras(run: &mut Run, model: &BodyModel) -> Result<(), Box<dyn Error>> {
    let recording = walker::recording(200, run.seed())?;
    let frames = walker::observe(&recording);
    let start = tracked(model, &recording, &frames).ok_or("nothing was found")?;
    let sequence = Sequence { frames: &frames, fps: recording.fps };
    let columns = ["likelihood", "seconds", "of the processors, s", "steps of the last round"];
    let mut table = Table::new("seven", &columns);
    for (name, measure) in [("ellipses", Measure::Ellipses), ("metaballs", Measure::Metaballs)] {
        let evidence = evidence(model, &recording, measure);
        let (started, before_s) = (Instant::now(), processor_s());
        let joint = joint_optimum(&evidence, sequence, start.clone(), &JointOptions::default());
        let seconds = started.elapsed().as_secs_f64();
        let processor_s = processor_s() - before_s;
        run.number(format!("seven_cameras_{name}_s"), seconds);
        run.number(format!("seven_cameras_{name}_processor_s"), processor_s);
        table.row([
            name.to_owned(),
            format!("{seconds:.1}"),
            format!("{processor_s:.1}"),
            joint.report.iterations.to_string(),
        ]);
    }
    run.table("Joint optimum of 7 cameras × 200 frames", &table)?;
    Ok(())
}
