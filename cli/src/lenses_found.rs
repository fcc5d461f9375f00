//! What `maquette calibrate --from lenses` says.

use std::path::PathBuf;

use maquette::pipeline::{PlaceSd, Size};
use maquette::workflow::LensRig;
use serde_json::{Value, json};

use super::said::in_a_line;
use super::table::Table;

/// Where each camera stands, and how well that is known.
pub(super) fn lenses_text(found: &LensRig, written: &[PathBuf], seconds: f64) -> String {
    let mut table = Table::new(&["camera", "stands at x y z, m", "turned", "placed"]);
    for (camera, sd) in found.rig.cameras.iter().zip(&found.sds) {
        let at = camera.camera_from_world.inverse().translation.vector;
        table.row(vec![
            camera.name.clone(),
            format!("{:.3} {:.3} {:.3}", at.x, at.y, at.z),
            format!("± {:.2}°", sd.turn_deg),
            format!("± {:.1} mm", 1e3 * sd.place_m),
        ]);
    }
    let refined = match &found.unrefined {
        None => "refined by the person's body".into(),
        Some(why) => format!("not refined by the person's body: {why}"),
    };
    let crowded = match found.placed.crowded {
        0 => String::new(),
        count => format!("  ! {count} pictures show several people and were left out\n"),
    };
    format!(
        "{}  by {} sights of joints, {:.1} times as far off as published labels; {refined}\n  {}\n{crowded}{} in {seconds:.1} s\n",
        table.text(),
        found.placed.sights,
        found.placed.spread,
        size(found),
        in_a_line(written),
    )
}

/// What tells how large the world is.
fn size(found: &LensRig) -> String {
    match (&found.size, found.scale.sd) {
        (Size::Height(metres), _) => format!("as large as a person of {metres:.2} m says"),
        (Size::Distance { cameras: [a, b], metres }, _) => {
            format!("as large as {metres} m between {a} and {b} say")
        }
        (Size::Usual, sd) => format!(
            "! as large as people's bones are on the mean{}: give --height or --distance",
            sd.map_or(String::new(), |sd| format!(", ± {:.0} %", 100.0 * sd))
        ),
    }
}

/// The same as JSON.
pub(super) fn lenses_json(found: &LensRig, written: &[PathBuf], seconds: f64) -> Value {
    let camera = |(name, sd): (&str, &PlaceSd)| json!({ "camera": name, "turn_sd_deg": sd.turn_deg, "place_sd_m": sd.place_m });
    let cameras = |sds: &[PlaceSd]| found.rig.names().zip(sds).map(camera).collect::<Vec<_>>();
    json!({
        "files": written.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
        "seconds": seconds,
        "lenses": {
            "frames": found.frames,
            "sights": found.placed.sights,
            "spread": found.placed.spread,
            "crowded_pictures": found.placed.crowded,
            "scale": found.scale.factor,
            "scale_sd": found.scale.sd,
            "unrefined": found.unrefined,
            "placed": cameras(&found.placed.sds),
            "refined": cameras(&found.sds),
        },
        "recordings": [],
        "cameras": [],
        "notes": [],
    })
}
