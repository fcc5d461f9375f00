//! Points, disparities and trajectories of a wall before three cameras.

use std::fs;
use std::path::PathBuf;

use maquette::camera::Rig;
use maquette::io::calibration::write_toml;
use maquette::io::points;
use maquette::io::recording::Recording;
use maquette::silhouette::SilhouetteOptions;
use nalgebra::Vector3;
use tempfile::TempDir;

use crate::arm::{Ran, run};
use crate::scene::{SIZE, Wall, three};

/// Correlation between two depths, which is fast.
const QUICK: [&str; 4] = ["--method", "correlation", "--depth", "1.5:3"];

/// A recording of the wall, which moves a centimetre a frame.
struct Recorded(TempDir);

impl Recorded {
    fn new(frames: usize) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let cameras = three();
        let rig = Rig { cameras: cameras.to_vec() };
        fs::write(folder.path().join("calibration.toml"), write_toml(&rig)).expect("a folder");
        for camera in &cameras {
            let images = folder.path().join("images").join(&camera.name);
            fs::create_dir_all(&images).expect("a folder");
            for frame in 0..frames {
                let wall = Wall { shift: Vector3::new(0.01 * frame as f64, 0.0, 0.0) };
                let image = wall.seen_by(camera);
                let path = images.join(format!("{frame:06}.png"));
                image::save_buffer(path, image.values(), SIZE.0, SIZE.1, image::ColorType::L8)
                    .expect("a picture");
            }
        }
        Self(folder)
    }

    /// A file or folder of the recording.
    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.at(name), text).expect("written");
    }

    fn table(&self, out: &str) -> String {
        fs::read_to_string(self.at(out).join("stereo.csv")).expect("a table")
    }

    /// `maquette stereo` into a folder of the recording.
    fn stereo(&self, out: &str, arguments: &[&str]) -> Ran {
        let [recording, out] = ["", out].map(|name| self.at(name).display().to_string());
        run(&[&["stereo", &recording, "--fps", "25", "--out", &out], arguments].concat())
    }
}

#[test]
fn points_disparities_trajectories_and_pictures_of_a_recording_are_written() {
    let recorded = Recorded::new(4);
    let out = recorded.at("out");
    let said = recorded.stereo("out", &["--tracks", "--pictures", "--frames", "0:2"]).succeeded();
    assert!(said.out.contains("3 frames"), "{}", said.out);
    assert!(said.err.contains("no masks"), "{}", said.err);
    let points = points::read(&out.join("points/000001.ply")).expect("a cloud").points;
    assert!(points.len() > 1000);
    let wall = Wall { shift: Vector3::new(0.01, 0.0, 0.0) };
    let mut off: Vec<f64> = points.iter().map(|p| wall.off(&p.position_world).abs()).collect();
    off.sort_by(f64::total_cmp);
    assert!(off[off.len() / 2] < 0.01, "{}", off[off.len() / 2]);
    let rows = fs::read_to_string(out.join("trajectories.csv")).expect("trajectories");
    assert!(rows.starts_with("trajectory,frame,x,y,z,vx") && rows.lines().count() > 100);
    for name in ["disparity/000002.png", "pictures/cloud_000000.png", "pictures/vectors_000000.png"]
    {
        assert!(out.join(name).is_file(), "{name}");
    }
    assert!(!out.join("points/000003.ply").exists());
    recorded.stereo("out", &[]).refused(&["not empty"]);
}

#[test]
fn correlation_writes_the_disparity_of_each_pair_and_a_missing_picture_costs_its_frame_alone() {
    let recorded = Recorded::new(2);
    fs::remove_file(recorded.at("images/left/000001.png")).expect("a picture");
    let said = recorded.stereo("out", &QUICK).succeeded();
    assert!(said.err.contains("1 frame without points, frame 1 first"), "{}", said.err);
    for name in ["points/000000.ply", "disparity/000000_1.png", "disparity/000000_2.png"] {
        assert!(recorded.at("out").join(name).is_file(), "{name}");
    }
}

#[test]
fn arguments_that_make_no_sense_are_refused_in_one_line() {
    let recorded = Recorded::new(1);
    let cases = [
        (vec!["--cameras", "left,nobody"], "no such camera: the recording has left, middle, right"),
        (vec!["--cameras", "left,left"], "expected two different cameras"),
        (vec!["--depth", "3:1"], "expected NEAR:FAR"),
        (vec!["--frames", "7:9"], "no frame of the recording lies in this range"),
        (vec!["--spacing", "0"], "--spacing"),
    ];
    for (arguments, expected) in cases {
        recorded.stereo("out", &arguments).refused(&[expected]);
    }
}

#[test]
fn that_contours_were_chosen_is_said_with_what_they_cost() {
    let recorded = Recorded::new(1);
    let [recording, out] = ["", "fit"].map(|name| recorded.at(name).display().to_string());
    // there is nobody to be fitted
    let said = run(&["fit", &recording, "--fps", "25", "--out", &out, "--quiet"]);
    assert_eq!(said.code, Some(2), "{said:?}");
    for part in ["note: no masks, cameras side by side", "takes many times as long as masks"] {
        assert!(said.err.contains(part), "{said:?}");
    }
}

#[test]
fn what_an_older_run_left_is_removed_and_what_is_not_its_own_stays() {
    let recorded = Recorded::new(2);
    let out = recorded.at("out");
    let said = recorded.stereo("out", &[&QUICK[..], &["--json"]].concat()).succeeded();
    crate::schema::check("stereo", &said.out);
    assert!(out.join("points/000001.ply").is_file());
    recorded.write("out/notes.txt", "mine");
    let again = [&QUICK[..], &["--overwrite", "--frames", "0:0"]].concat();
    recorded.stereo("out", &again).succeeded();
    assert!(out.join("points/000000.ply").is_file() && out.join("notes.txt").is_file());
    assert!(!out.join("points/000001.ply").exists());
    let table = recorded.table("out");
    assert_eq!(table.lines().count(), 2, "{table}");
}

#[test]
fn a_frame_of_which_the_template_has_no_mask_is_not_measured_and_a_folder_of_no_camera_is_told() {
    let recorded = Recorded::new(2);
    let mask = |camera: &str, frame: usize| {
        let masks = recorded.at("masks").join(camera);
        fs::create_dir_all(&masks).expect("a folder");
        image::GrayImage::from_pixel(SIZE.0, SIZE.1, image::Luma([255]))
            .save(masks.join(format!("{frame:06}.png")))
            .expect("a mask");
    };
    for camera in ["left", "right", "middel"] {
        mask(camera, 0);
        mask(camera, 1);
    }
    let said = recorded.stereo("bare", &QUICK).succeeded().err;
    assert!(said.contains("middel"), "{said}");
    assert!(said.contains("camera middle: no masks: everything that it shows"), "{said}");
    fs::remove_dir_all(recorded.at("masks/middel")).expect("removed");
    mask("middle", 0);
    let said = recorded.stereo("masked", &QUICK).succeeded().err;
    let table = recorded.table("masked");
    assert!(
        said.contains("1 frame without points, frame 1 first: camera middle has no mask of it"),
        "{said}"
    );
    assert!(table.lines().nth(1).is_some_and(|line| !line.starts_with("0,0,")), "{table}");
}

#[test]
fn masks_that_cannot_be_used_are_told_and_not_taken_for_none() {
    let recorded = Recorded::new(1);
    let camera = |name: &str| {
        format!("[[camera]]\nname = \"{name}\"\nimages = \"images/{name}\"\nmasks = \"nowhere\"\n")
    };
    let manifest: String = ["left", "middle", "right"].map(camera).concat();
    recorded.write("sequence.toml", &manifest);
    recorded.stereo("out", &[]).refused(&["camera left: no mask at"]);
}

#[test]
fn points_come_back_where_they_were_whichever_axis_of_the_files_is_up() {
    let recorded = Recorded::new(1);
    let manifest = "fps = 25\nup = \"-z\"\npoints = \"out/points/%06d.ply\"\n";
    recorded.write("sequence.toml", manifest);
    recorded.stereo("out", &QUICK).succeeded();
    // the file is in the world of the calibration, in which the wall stands
    let points = points::read(&recorded.at("out/points/000000.ply")).expect("a cloud").points;
    let wall = Wall { shift: Vector3::zeros() };
    let mut off: Vec<f64> = points.iter().map(|p| wall.off(&p.position_world).abs()).collect();
    off.sort_by(f64::total_cmp);
    assert!(off[off.len() / 2] < 0.03, "{}", off[off.len() / 2]);
    // and the recording reads it in the world of its cameras
    let recording = Recording::open(recorded.at(""))
        .and_then(|found| found.observations())
        .expect("a recording");
    let read = recording.load_frame(0, &SilhouetteOptions::default()).expect("a frame").points;
    let seen = recording.rig.cameras.iter().filter(|camera| {
        read.iter().all(|p| (camera.camera_from_world * p.position_world).z > 0.0)
    });
    assert_eq!(seen.count(), 3);
}
