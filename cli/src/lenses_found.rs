//! What `maquette calibrate --from lenses` says.

use std::path::PathBuf;

use maquette::pipeline::Size;
use maquette::workflow::{FoundByLenses, RefinedRig};
use serde_json::{Value, json};

use super::calibrate::{length, names};
use super::table::Table;

/// Where each camera stands, and how well that is known.
pub(super) fn lenses_text(
    rig: &RefinedRig,
    found: &FoundByLenses,
    written: &[PathBuf],
    seconds: f64,
) -> String {
    let mut table = Table::new(&["camera", "stands at, m", "turned", "placed"]);
    for (i, camera) in rig.rig.cameras.iter().enumerate() {
        let at = camera.camera_from_world.inverse().translation.vector;
        let (turn_deg, place_m) = sds(rig, found, i);
        table.row(vec![
            camera.name.clone(),
            format!("{:.3} {:.3} {:.3}", at.x, at.y, at.z),
            format!("± {turn_deg:.2}°"),
            format!("± {:.1} mm", 1e3 * place_m),
        ]);
    }
    let refined = match &found.unrefined {
        None => "refined by the person's body".into(),
        Some(why) => format!("not refined by the person's body: {why}"),
    };
    format!(
        "{}  by {} sights of joints, {:.1} times as far off as published labels; {refined}\n  {}\n{} in {seconds:.1} s\n",
        table.text(),
        found.placed.sights,
        found.placed.spread,
        size(found),
        names(written),
    )
}

/// What tells how large the world is.
fn size(found: &FoundByLenses) -> String {
    match (&found.size, found.scale.sd) {
        (Size::Height(metres), _) => format!("as large as a person of {metres:.2} m says"),
        (Size::Distance { cameras: [a, b], metres }, _) => {
            format!("as large as {metres} m between {a} and {b} say")
        }
        (_, Some(sd)) => format!(
            "! as large as people's bones are on the mean, ± {:.0} %: give --height or --distance",
            100.0 * sd
        ),
        (_, None) => "! as large as people's bones are on the mean: give --height or --distance".into(),
    }
}

/// Standard deviations of a camera's turn (degrees) and place (m), against the rig.
fn sds(rig: &RefinedRig, found: &FoundByLenses, camera: usize) -> (f64, f64) {
    let refined = rig.cameras.get(camera).and_then(|camera| camera.found.as_ref().ok());
    let placed = found.placed.sds[camera];
    refined.map_or((placed.turn_deg, placed.place_m * found.scale.factor), |refined| {
        (length(refined.turn_sd_deg), length(refined.displacement_sd_m))
    })
}

/// The same as JSON.
pub(super) fn lenses_json(found: &FoundByLenses) -> Value {
    let cameras = found.placed.rig.names().zip(&found.placed.sds);
    let camera = |(name, sd): (&str, &maquette::pipeline::PlaceSd)| {
        json!({ "camera": name, "turn_sd_deg": sd.turn_deg, "place_sd_m": sd.place_m })
    };
    json!({
        "sights": found.placed.sights,
        "spread": found.placed.spread,
        "crowded_pictures": found.placed.crowded,
        "scale": found.scale.factor,
        "scale_sd": found.scale.sd,
        "unrefined": found.unrefined,
        "placed": cameras.map(camera).collect::<Vec<_>>(),
    })
}
