//! What detections of joints add: to the masks of three recordings with their truth, alone, and where a search starts from a single frame; and how
//! well they predict what a left-out camera sees of a real person.

mod balance;
mod sets;

use std::error::Error;
use std::process::ExitCode;

use experiments::run::{Run, shared_data};

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("detections");
    let folder = shared_data();
    let needed = sets::WITH_TRUTH.iter().chain(&sets::STARTED).chain(&["balance"]);
    if let Some(missing) = needed.map(|name| folder.join(name)).find(|path| !path.is_dir()) {
        run.say(&format!("skipped: no recording in {}", missing.display()));
        return Ok(ExitCode::SUCCESS);
    }
    sets::gains(&mut run, &folder)?;
    sets::starts(&mut run, &folder)?;
    balance::run(&mut run, &folder.join("balance"))?;
    Ok(run.finish()?)
}
