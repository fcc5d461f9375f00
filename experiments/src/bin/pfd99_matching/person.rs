//! The rendered man before three cameras 20 cm apart.

use std::path::Path;
use std::time::Instant;

use experiments::run::Run;
use maquette::camera::CameraId;
use maquette::image::{Mask, luma};
use maquette::io::frames::Footage;
use maquette::io::recording::Recording;
use maquette::silhouette::FrameIndex;
use maquette::stereo::View;
use maquette::stereo::matching::{MatchOptions, match_surface};

use crate::Fault;
use crate::mesh::Mesh;

/// Left, centre and right of a frame, and the centre's mask.
pub struct Triplet {
    pub views: Vec<View>,
    pub mask: Mask,
}

pub fn triplets(folder: &Path, last: usize) -> Result<Vec<Triplet>, Fault> {
    let footage = Footage::open(folder, None)?;
    let recording = Recording::open(folder, None)?;
    let mut all = Vec::new();
    for (frame, pictures) in footage.frame_sets(0..=last) {
        let views = footage.rig.cameras.iter().zip(pictures);
        let views = views
            .map(|(camera, picture)| Ok(View::of(camera, &luma(&picture.ok_or("no picture")?))?));
        let mask = recording
            .load_mask(CameraId(1), FrameIndex(frame.0))?
            .ok_or("no mask")?;
        all.push(Triplet {
            views: views.collect::<Result<_, Fault>>()?,
            mask,
        });
    }
    Ok(all)
}

pub fn measure(run: &mut Run, folder: &Path) -> Result<(), Fault> {
    let options = MatchOptions {
        spacing_px: 1,
        least_images: 1,
        ..MatchOptions::default()
    };
    let (mut off, mut ratios, mut least) = (Vec::new(), Vec::new(), usize::MAX);
    for (i, triplet) in triplets(folder, 39)?.iter().enumerate().step_by(13) {
        let mesh = Mesh::read(&folder.join(format!("surface/{i:06}.ply")))?;
        let start = Instant::now();
        let [left, centre, right] = &triplet.views[..] else {
            return Err("three cameras expected".into());
        };
        let found = match_surface(centre, &[left, right], Some(&triplet.mask), &[], &options)?;
        let seconds = start.elapsed().as_secs_f64();
        let mut here = Vec::new();
        for point in &found.points {
            let distance = mesh
                .nearest(&point.point.position_world)
                .map_or(0.06, |found| found.0);
            let ray = point.point.position_world - centre.camera.centre_world();
            here.push(1000.0 * distance);
            ratios.push(distance / point.point.spread.along(&ray.normalize()).unwrap_or(1.0));
        }
        least = least.min(here.len());
        let (middle, most) = quantiles(&mut here);
        run.say(&format!(
            "frame {i}: {} points of {} pixels ({} without texture), {} seeds, median {middle:.2} mm, 95 % {most:.1} mm, {seconds:.1} s",
            found.points.len(), found.points.len() + found.unmatched, found.without_texture, found.seeds
        ));
        off.append(&mut here);
    }
    let (middle, most) = quantiles(&mut off);
    run.number("person_median_mm", middle);
    run.number("person_95_percent_mm", most);
    run.number("person_least_points", least as f64);
    let (ratio, ratio_95) = quantiles(&mut ratios);
    run.number("person_distance_over_sigma_median", ratio);
    run.number("person_distance_over_sigma_95_percent", ratio_95);
    run.say(&format!(
        "all: median {middle:.2} mm, 95 % {most:.1} mm; over sigma {ratio:.2} and {ratio_95:.1}"
    ));
    Ok(())
}

/// Median and 95 %.
pub fn quantiles(values: &mut [f64]) -> (f64, f64) {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        values
            .get((share * values.len() as f64) as usize)
            .copied()
            .unwrap_or(f64::NAN)
    };
    (at(0.5), at(0.95))
}
