//! Silhouettes before clutter in rooms, of persons and by rigs that are drawn from seeds (PF02 § 4).
//!
//! `pf02_clutter` has two persons who wander and wave. Here are six more, and of each something that those do not have: one
//! walks on the spot, one does so turned away, of one the feet are out of view and of one a side, behind one a cart goes to and
//! fro, and one turns and wanders. Distance, baseline and frame rate of the cameras are drawn too. A frame is in error where,
//! in any camera, the overlap with the true mask is less than 0.9 or the contour is more than 4 px off on average; it has a
//! verdict where the program refuses the whole, warns that the contours hardly lie on edges, or doubts the frame: depth backs too
//! little of one of its contours, or shows what stands behind a limb. `--quick`: the first two rooms, 16 frames each.
//!
//! Starts: from nothing.

use std::error::Error;
use std::f64::consts::PI;
use std::path::Path;
use std::process::ExitCode;

use experiments::contours::{Score, score_of_view};
use experiments::film::photographed;
use experiments::run::Run;
use experiments::table::Table;
use maquette::Recording;
use maquette::io::folder::silhouettes::SilhouetteExtras;
use maquette::math::stats::mean;
use maquette::pipeline::silhouettes::{SilhouettePipeline, UNSURE_RELIABILITY};
use maquette::pipeline::{FrameRange, NoProgress};
use maquette::silhouette::FrameIndex;
use maquette::synth::{Company, FilmRecipe, Staging};
use maquette::workflow::{DEFAULT_BODY, SilhouetteFiles};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Anything that ends the experiment.
type Fault = Box<dyn Error>;

/// Frames of a room, and of a quick one.
const FRAMES: [usize; 2] = [40, 16];
/// Rooms in all, and quickly.
const ROOMS: [u64; 2] = [6, 2];
/// Seeds begin here: nothing was tried on these.
const FIRST_SEED: u64 = 301;

/// What is particular to each room.
const PARTICULARS: [&str; 6] = [
    "walks on the spot",
    "walks on the spot, turned away",
    "on the spot, feet out of view",
    "on the spot, a side out of view",
    "on the spot, a cart behind",
    "wanders and waves, turned away",
];

fn main() -> Result<ExitCode, Fault> {
    let mut run = Run::start("pf02_rooms");
    let place = usize::from(run.is_quick());
    run.setting("frames", FRAMES[place]);
    run.setting("rooms", ROOMS[place]);
    let mut table = Table::new(
        "rooms",
        &["room", "frames", "in error", "of these without verdict", "contour off, px", "overlap"],
    );

    let (mut frames, mut errors, mut silent) = (0, 0, 0);
    for room in 0..ROOMS[place] {
        let recipe = recipe(run.seed() - 1 + FIRST_SEED + room, room as usize, FRAMES[place]);
        let found = traced(&recipe, &run.folder().join(format!("room_{}", room + 1)))?;
        table.row([
            PARTICULARS[room as usize].to_owned(),
            found.frames.to_string(),
            found.errors.len().to_string(),
            found.silent.len().to_string(),
            format!("{:.2}", found.distance_px),
            format!("{:.3}", found.overlap),
        ]);
        run.say(&format!(
            "room {}: frames in error {:?}, without verdict {:?}; {}",
            room + 1,
            found.errors,
            found.silent,
            found.failure.as_deref().unwrap_or("usable")
        ));
        frames += found.frames;
        errors += found.errors.len();
        silent += found.silent.len();
    }

    run.table("Rooms", &table)?;
    run.number("frames", frames as f64);
    run.number("errors", errors as f64);
    run.number("silent_errors", silent as f64);
    Ok(run.finish()?)
}

/// A room with cameras that are drawn from its seed.
fn recipe(seed: u64, room: usize, frames: usize) -> FilmRecipe {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let distance = rng.random_range(3.0..4.2);
    let baseline = rng.random_range(0.14..0.28);
    let turned = rng.random_range(-PI..PI);
    let side = if rng.random_range(0.0..1.0) < 0.5 { -1.0 } else { 1.0 };

    let spot = Staging { waving: 0.0, ..Staging::default() };
    let staging = match room {
        0 => spot,
        1 => Staging { turned, ..spot },
        // half the picture is 3/8 of the distance high: its lower edge lies between ankle and knee
        2 => Staging { aimed_off: [0.0, 0.375 * distance - 0.93 + 0.25], ..spot },
        // and half of the distance wide: its edge lies beside the middle of the trunk
        3 => Staging { aimed_off: [side * (0.5 * distance - 0.1), 0.0], ..spot },
        4 => Staging { company: Company::Cart, ..spot },
        _ => Staging { turned, ..Staging::default() },
    };
    FilmRecipe { seed, frames, distance, baseline, staging, ..FilmRecipe::default() }
}

/// How a room's silhouettes compare with the true ones.
struct Traced {
    frames: usize,
    /// Frames in error, and those of them of which nothing was said.
    errors: Vec<usize>,
    silent: Vec<usize>,
    distance_px: f64,
    overlap: f64,
    failure: Option<String>,
}

/// Photographs a room, and finds the silhouettes as a user would.
fn traced(recipe: &FilmRecipe, folder: &Path) -> Result<Traced, Fault> {
    let (recording, out) = (folder.join("recording"), folder.join("out"));
    let film = photographed(recipe, &recording)?;

    let files = SilhouetteFiles {
        folder: &out,
        body: DEFAULT_BODY,
        frames: FrameRange::default(),
        pipeline: SilhouettePipeline::Joint,
        start: None,
        extras: SilhouetteExtras::default(),
    };
    // a run that finds nothing to begin with is a verdict on every frame
    let written = Recording::open(&recording)?.write_silhouettes(&files, &NoProgress);
    let (rows, doubtful, failure) = match written {
        Ok(written) => (written.rows, written.doubtful, written.failure),
        Err(fault) => (Vec::new(), Vec::new(), Some(fault.to_string())),
    };

    let mut found = Traced {
        frames: film.synthetic.frames(),
        errors: Vec::new(),
        silent: Vec::new(),
        distance_px: 0.0,
        overlap: 0.0,
        failure,
    };
    let reliability = mean(rows.iter().map(|row| row.reliability));
    let is_doubted = reliability.is_some_and(|mean| mean < UNSURE_RELIABILITY);
    let mut scores: Vec<Score> = Vec::new();
    for frame in 0..found.frames {
        let truth = recording.join("truth");
        let names = film.synthetic.rig.names();
        let views = names.map(|name| score_of_view(&out, &truth, name, frame));
        let views: Vec<Score> = views.collect::<Result<_, _>>()?;
        let has_verdict = found.failure.is_some()
            || is_doubted
            || !rows.iter().any(|row| row.frame == frame)
            || doubtful.contains(&FrameIndex(frame));

        if views.iter().any(Score::is_error) {
            found.errors.push(frame);
            if !has_verdict {
                found.silent.push(frame);
            }
        }
        scores.extend(views);
    }
    let count = scores.len().max(1) as f64;
    found.distance_px = scores.iter().map(|score| score.distance_px).sum::<f64>() / count;
    found.overlap = scores.iter().map(|score| score.overlap).sum::<f64>() / count;
    Ok(found)
}
