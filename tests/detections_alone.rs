//! Detections of joints alone, without masks or pictures: a walker's body from OpenPose's files, and each way for the files to be bad.

use std::fs;
use std::path::Path;

use maquette::body::Side;
use maquette::camera::Camera;
use maquette::io::calibration::{self, CalibrationOptions, write_toml};
use maquette::io::model;
use maquette::io::recording::{ObservationFiles, RecordingError};
use maquette::pipeline::{NoProgress, Size};
use maquette::silhouette::{FrameIndex, Keypoint};
use maquette::synth::{Action, Movement, Recipe, Ring, Synthetic};
use maquette::workflow::LensRig;
use maquette::{FitOptions, Recording};
use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tempfile::TempDir;

/// COCO's points, in the order of a file.
const COCO: [&str; 17] = [
    "Nose",
    "LEye",
    "REye",
    "LEar",
    "REar",
    "LShoulder",
    "RShoulder",
    "LElbow",
    "RElbow",
    "LWrist",
    "RWrist",
    "LHip",
    "RHip",
    "LKnee",
    "RKnee",
    "LAnkle",
    "RAnkle",
];
const FRAMES: usize = 20;
const FPS: f64 = 25.0;
const NOISE_PX: f64 = 1.0;

fn walker() -> Synthetic {
    doing(Action::Walk)
}

fn doing(action: Action) -> Synthetic {
    let person = model::load("walker-metaballs", Path::new("")).expect("a shipped model");
    let ring = Ring { cameras: 4, ..Ring::default() };
    let recipe = Recipe { action, frames: Some(FRAMES), fps: FPS, ring, ..Recipe::default() };
    recipe.walker(&person).expect("a walker")
}

/// What a detector writes of the walker, moved so far, in a picture of a camera: x, y, confidence of each point.
fn person(
    walker: &Synthetic,
    (frame, camera): (usize, usize),
    off: Vector3<f64>,
    rng: &mut ChaCha8Rng,
) -> Vec<f64> {
    let points = walker.points(FrameIndex(frame)).expect("a frame");
    let mut seen = |name: &&str| {
        let at = walker.model.point(name).map(|index| points[index] + off);
        let pixel = at.and_then(|at| walker.rig.cameras[camera].project(&at));
        let mut noise = || NOISE_PX * rng.random_range(-1.0..1.0);
        pixel.map_or([0.0; 3], |at| [at.x + noise(), at.y + noise(), 0.9])
    };
    COCO.iter().flat_map(&mut seen).collect()
}

fn file(people: &[Vec<f64>]) -> String {
    let listed = people.iter().map(|person| format!("{{\"pose_keypoints_2d\": {person:?}}}"));
    format!("{{\"people\": [{}]}}", listed.collect::<Vec<_>>().join(", "))
}

/// The detections of a folder.
fn observed(folder: &Path) -> Result<ObservationFiles, RecordingError> {
    Recording::open(folder).expect("a folder").with_fps(FPS).observations()
}

/// A Pose2Sim project without videos: a calibration, and what each picture's file holds.
fn project(walker: &Synthetic, text: impl Fn(usize, usize) -> String) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let calibration = folder.path().join("calibration");
    fs::create_dir_all(&calibration).expect("a folder");
    fs::write(calibration.join("Calib_scene.toml"), write_toml(&walker.rig)).expect("a file");
    for (id, camera) in walker.rig.iter() {
        let pose = folder.path().join("pose").join(format!("{}_json", camera.name));
        fs::create_dir_all(&pose).expect("a folder");
        for frame in 0..FRAMES {
            let name = format!("{}_{frame:06}.json", camera.name);
            fs::write(pose.join(name), text(frame, id.0)).expect("a file");
        }
    }
    folder
}

/// The walker, and in every second frame somebody beside, in any order; one camera takes each leg for the other for a while.
fn text_of(walker: &Synthetic) -> impl Fn(usize, usize) -> String {
    |frame, camera| {
        let mut rng = ChaCha8Rng::seed_from_u64((100 * frame + camera) as u64);
        let mut own = person(walker, (frame, camera), Vector3::zeros(), &mut rng);
        if camera == 1 && (5..9).contains(&frame) {
            for right in (0..COCO.len()).filter(|k| ["RHip", "RKnee", "RAnkle"].contains(&COCO[*k]))
            {
                (0..3).for_each(|k| own.swap(3 * right + k, 3 * (right - 1) + k));
            }
        }
        let beside = person(walker, (frame, camera), Vector3::new(0.0, 1.2, 0.0), &mut rng);
        match frame % 4 {
            0 => file(&[beside, own]),
            2 => file(&[own, beside]),
            _ => file(&[own]),
        }
    }
}

fn fitted(folder: &Path) -> Result<maquette::FittedRecording, String> {
    let fit = Recording::open(folder).map_err(|fault| fault.to_string())?;
    fit.with_fps(FPS).fit(&FitOptions::default()).map_err(|fault| fault.to_string())
}

#[test]
fn who_lies_or_goes_on_all_fours_is_found_by_detections_alone() {
    for movement in [Movement::Lie, Movement::AllFours] {
        let person_lying = doing(Action::Move(movement));
        let folder = project(&person_lying, |frame, camera| {
            let mut rng = ChaCha8Rng::seed_from_u64((100 * frame + camera) as u64);
            file(&[person(&person_lying, (frame, camera), Vector3::zeros(), &mut rng)])
        });
        let fit = fitted(folder.path()).expect("a fit");
        assert!(fit.result.verdict.is_usable(), "{movement:?}: {:?}", fit.result.verdict);
        for frame in &fit.result.motion.frames {
            let truth = person_lying.points(FrameIndex(frame.frame)).expect("a frame");
            let off = |name: &&str| {
                let index = fit.result.motion.points.iter().position(|point| point == name);
                let place = Point3::from(frame.points_m[index.expect("a joint")]);
                (place - truth[person_lying.model.point(name).expect("a joint")]).norm()
            };
            let joints = ["RHip", "LHip", "RKnee", "LKnee", "RElbow", "LElbow", "RWrist", "LWrist"];
            let mean_m = joints.iter().map(off).sum::<f64>() / joints.len() as f64;
            assert!(mean_m < 0.05, "{movement:?}: {mean_m} m off in frame {}", frame.frame);
        }
    }
}

#[test]
fn a_project_without_videos_gives_the_walkers_joints_and_angles_with_standard_deviations() {
    let walker = walker();
    let folder = project(&walker, text_of(&walker));
    let fit = fitted(folder.path()).expect("a fit");
    assert!(fit.result.verdict.is_usable(), "{:?}", fit.result.verdict);
    assert!(fit.result.warnings.iter().any(|warning| warning.starts_with("no masks: ")));

    // what a detector means by a joint is not known, so 2 cm are no error
    let mut off = Vec::new();
    for frame in &fit.result.motion.frames {
        let truth = walker.points(FrameIndex(frame.frame)).expect("a frame");
        let truth = |name: &str| truth[walker.model.point(name).expect("a joint")];
        let place = |name: &str| {
            let index = fit.result.motion.points.iter().position(|point| point == name);
            Point3::from(frame.points_m[index.expect("a joint")])
        };
        let legs = |right: &str, left: &str| {
            (place("RAnkle") - truth(right)).norm() + (place("LAnkle") - truth(left)).norm()
        };
        assert!(legs("RAnkle", "LAnkle") < legs("LAnkle", "RAnkle"), "frame {}", frame.frame);
        assert!(frame.sd.is_some() && frame.views == 4);
        off.extend(COCO[5..].iter().map(|name| (place(name) - truth(name)).norm()));
    }
    let mean_m = off.iter().sum::<f64>() / off.len() as f64;
    assert!(mean_m < 0.025, "{mean_m}");

    let knee = fit.angle("knee_flexion", Side::Left).expect("a knee");
    let joint = walker.model.joint("knee_flexion_l").expect("a knee");
    let off = knee.radians.iter().zip(&walker.motions).map(|(a, m)| a - m.angles[joint.0]);
    let rms = (off.map(|off| off * off).sum::<f64>() / FRAMES as f64).sqrt().to_degrees();
    assert!(rms < 5.0 && knee.sd.is_some(), "{rms}");
}

#[test]
fn what_cannot_be_fitted_to_is_said_in_one_line() {
    let walker = walker();
    let own = |frame: usize, camera: usize| {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        person(&walker, (frame, camera), Vector3::zeros(), &mut rng)
    };
    let unsure = |frame: usize, camera: usize| {
        let mut person = own(frame, camera);
        person.chunks_mut(3).for_each(|point| point[2] = 0.0);
        file(&[person])
    };
    let without = |frame: usize, camera: usize| {
        let person = own(frame, camera);
        let places = person.chunks(3).flat_map(|point| [point[0], point[1]]).collect();
        file(&[places])
    };
    let larger = |frame: usize, camera: usize| {
        file(&[own(frame, camera).iter().map(|value| 3.0 * value).collect()])
    };
    let smaller = |frame: usize, camera: usize| file(&[half(&own(frame, camera))]);
    let cut = |frame: usize, camera: usize| {
        let text = file(&[own(frame, camera)]);
        text[..text.len() / (1 + usize::from(frame == 3))].to_owned()
    };
    let alone = |frame: usize, camera: usize| match camera {
        0 => file(&[own(frame, camera)]),
        _ => file(&[]),
    };
    let strange = |_: usize, _: usize| file(&[vec![10.0, 10.0, 0.9, 20.0, 20.0, 0.9]]);
    let apart = |frame: usize, camera: usize| {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let off = Vector3::new(0.0, 0.0, 0.9 * camera as f64 - 1.2);
        file(&[person(&walker, (frame, camera), off, &mut rng)])
    };
    for (text, part) in [
        (&(|_, _| file(&[])) as &dyn Fn(usize, usize) -> String, "show nobody"),
        (&unsure, "every confidence is 0"),
        (&without, "three numbers for each point"),
        (&larger, "another size"),
        (&smaller, "write detections_scale = 2 in sequence.toml"),
        (&cut, "000003.json"),
        (&alone, "no two cameras see one person"),
        (&apart, "no two cameras see one person"),
        (&strange, "people of 2 points"),
    ] {
        let fault = fitted(project(&walker, text).path()).expect_err(part);
        assert!(fault.contains(part) && !fault.contains('\n'), "{part}: {fault}");
    }
}

#[test]
fn frames_without_files_and_the_wrong_name_of_a_set_are_read_or_told() {
    let walker = walker();
    let folder = project(&walker, text_of(&walker));
    let pose = |camera: &str| folder.path().join(format!("pose/{camera}_json"));
    let names: Vec<&str> = walker.rig.names().collect();
    for frame in [4, 5, 11] {
        for name in &names {
            fs::remove_file(pose(name).join(format!("{name}_{frame:06}.json"))).expect("a file");
        }
    }
    fs::remove_file(pose(names[0]).join(format!("{}_000002.json", names[0]))).expect("a file");
    let files = observed(folder.path());
    let files = files.expect("detections");
    assert_eq!(files.frames.len(), FRAMES - 3);
    assert_eq!(files.load_people(2).expect("a frame").pictures.len(), 3);

    fs::write(folder.path().join("sequence.toml"), "keypoints = \"halpe26\"\n").expect("a file");
    let fault = observed(folder.path());
    let fault = fault.expect_err("17 points").to_string();
    assert!(fault.contains("people of 17 points, halpe26 has 26"), "{fault}");
}

#[test]
fn detections_of_pictures_of_half_the_size_are_read_with_their_scale() {
    let walker = walker();
    let own = |frame: usize, camera: usize| {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        person(&walker, (frame, camera), Vector3::zeros(), &mut rng)
    };
    let whole = project(&walker, |frame, camera| file(&[own(frame, camera)]));
    let halves = project(&walker, |frame, camera| file(&[half(&own(frame, camera))]));
    let manifest = halves.path().join("sequence.toml");
    fs::write(&manifest, "detections_scale = 2\n").expect("a file");

    let wanted = observed(whole.path()).expect("detections");
    let found = observed(halves.path()).expect("detections");
    for frame in 0..FRAMES {
        assert_eq!(found.load_people(frame).unwrap(), wanted.load_people(frame).unwrap());
    }

    fs::write(&manifest, "detections_scale = 0\n").expect("a file");
    let fault = Recording::open(halves.path()).expect_err("no picture has this size").to_string();
    assert!(fault.contains("detections_scale = 0: expected a number from 0.01"), "{fault}");
}

#[test]
fn poses_from_the_camera_to_the_world_are_told_and_read_as_the_manifest_says() {
    let walker = walker();
    let folder = project(&walker, text_of_one(&walker));
    let mut inverse = walker.rig.clone();
    for camera in &mut inverse.cameras {
        camera.camera_from_world = camera.camera_from_world.inverse();
    }
    let calibration = folder.path().join("calibration/Calib_scene.toml");
    fs::write(calibration, write_toml(&inverse)).expect("a file");
    let fault = fitted(folder.path()).expect_err("no poses");
    assert!(fault.ends_with("write poses = \"camera-to-world\" in sequence.toml"), "{fault}");

    fs::write(folder.path().join("sequence.toml"), "poses = \"camera-to-world\"\n")
        .expect("a file");
    let read = observed(folder.path()).expect("detections").rig;
    for (read, camera) in read.cameras.iter().zip(&walker.rig.cameras) {
        approx::assert_relative_eq!(
            read.camera_from_world,
            camera.camera_from_world,
            epsilon = 1e-12
        );
    }
}

/// A person in a picture of half the size.
fn half(person: &[f64]) -> Vec<f64> {
    let halved = person.iter().enumerate();
    halved.map(|(i, value)| if i % 3 == 2 { *value } else { value / 2.0 }).collect()
}

#[test]
fn a_table_of_each_camera_says_what_the_files_of_all_pictures_say() {
    let walker = walker();
    let folder = project(&walker, text_of(&walker));
    let wanted = observed(folder.path()).expect("detections");

    let tables = tempfile::tempdir().expect("a folder");
    let mut manifest = String::from("fps = 25\n");
    fs::write(tables.path().join("calibration.toml"), write_toml(&walker.rig)).expect("a file");
    for (id, camera) in walker.rig.iter() {
        let names =
            COCO.iter().flat_map(|name| ["x", "y", "score"].map(|end| format!("{name}.{end}")));
        let header = names.collect::<Vec<_>>().join(",");
        let mut text = format!("track,frame_idx,instance.score,{header}\n");
        for frame in 0..FRAMES {
            let people: serde_json::Value =
                serde_json::from_str(&text_of(&walker)(frame, id.0)).expect("JSON");
            for person in people["people"].as_array().expect("people") {
                let values = person["pose_keypoints_2d"].as_array().expect("points");
                let values: Vec<String> = values.iter().map(ToString::to_string).collect();
                text += &format!("t,{frame},1,{}\n", values.join(","));
            }
        }
        fs::write(tables.path().join(format!("{}.csv", camera.name)), text).expect("a file");
        let name = &camera.name;
        manifest += &format!("[[camera]]\nname = {name:?}\ndetections = \"{name}.csv\"\n");
    }
    fs::write(tables.path().join("sequence.toml"), manifest).expect("a file");

    let found = Recording::open(tables.path()).expect("a folder").observations();
    let found = found.expect("detections");
    assert_eq!(found.frames, wanted.frames);
    for frame in 0..FRAMES {
        assert_eq!(found.load_people(frame).unwrap(), wanted.load_people(frame).unwrap());
    }
    let inputs = found.checksums().expect("files");
    let own = inputs.iter().filter(|input| input.input.starts_with("detections of "));
    assert!(own.clone().count() == 4 && own.clone().all(|input| input.files == 1));
}

#[test]
fn cameras_of_which_the_lenses_alone_are_known_are_placed_by_the_walker_and_written() {
    let walker = walker();
    let folder = project(&walker, text_of_one(&walker));
    let lenses: String = write_toml(&walker.rig)
        .lines()
        .filter(|line| !line.starts_with("rotation") && !line.starts_with("translation"))
        .map(|line| format!("{line}\n"))
        .collect();
    fs::write(folder.path().join("calibration/Calib_scene.toml"), lenses).expect("a file");

    // without poses a fit says what makes them
    let fault = fitted(folder.path()).expect_err("no poses");
    assert!(fault.contains("calibrate --from lenses") && !fault.contains('\n'), "{fault}");

    let (a, b) = (&walker.rig.cameras[0], &walker.rig.cameras[1]);
    let apart = |a: &Camera, b: &Camera| (a.centre_world() - b.centre_world()).norm();
    let cameras = [a.name.clone(), b.name.clone()];
    let found = |size: Size| {
        LensRig::of(folder.path(), Some(FPS), size, &FitOptions::default(), &NoProgress)
            .map_err(|fault| fault.to_string())
    };
    let distance = Size::Distance { cameras: cameras.clone(), metres: apart(a, b) };
    let rig = found(distance).expect("a rig");
    assert_eq!(rig.unrefined, None);
    let out = folder.path().join("rig.toml");
    rig.write(&out).expect("a file");
    let text = fs::read_to_string(&out).expect("a file");
    assert!(text.contains("[metadata.placed."), "{text}");

    let read = calibration::read(&out, &CalibrationOptions::default()).expect("a calibration");
    for (i, camera) in walker.rig.cameras.iter().enumerate() {
        for (j, other) in walker.rig.cameras[..i].iter().enumerate() {
            let off_m = apart(&read.cameras[i], &read.cameras[j]) - apart(camera, other);
            let turned = read.cameras[i].camera_from_world.rotation
                * read.cameras[j].camera_from_world.rotation.inverse();
            let truly =
                camera.camera_from_world.rotation * other.camera_from_world.rotation.inverse();
            let off_deg = turned.angle_to(&truly).to_degrees();
            assert!(off_m.abs() < 0.06 && off_deg < 0.6, "{i} {j}: {off_m} m {off_deg}°");
        }
    }

    for (size, part) in [
        (Size::Height(17.5), "--height = 17.5 m: expected 0.4 to 2.6 m"),
        (Size::Distance { cameras: ["none".into(), cameras[0].clone()], metres: 1.0 }, "\"none\""),
        (
            Size::Distance { cameras: [cameras[0].clone(), cameras[0].clone()], metres: 1.0 },
            "twice",
        ),
    ] {
        let fault = found(size).expect_err(part);
        assert!(fault.contains(part) && !fault.contains('\n'), "{part}: {fault}");
    }
}

/// The walker alone.
fn text_of_one(walker: &Synthetic) -> impl Fn(usize, usize) -> String {
    |frame, camera| {
        let mut rng = ChaCha8Rng::seed_from_u64((100 * frame + camera) as u64);
        file(&[person(walker, (frame, camera), Vector3::zeros(), &mut rng)])
    }
}

/// MediaPipe's number of each of COCO's points from the shoulders on.
const MEDIAPIPE: [usize; 12] = [11, 12, 13, 14, 15, 16, 23, 24, 25, 26, 27, 28];

/// FreeMoCap's array of what the files of all pictures hold: cameras × frames × 33 × 2, as numpy.save writes it.
fn array(walker: &Synthetic) -> Vec<u8> {
    let text = format!(
        "{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, {FRAMES}, 33, 2), }}\n",
        walker.rig.cameras.len()
    );
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    for (id, _) in walker.rig.iter() {
        for frame in 0..FRAMES {
            let picture: serde_json::Value =
                serde_json::from_str(&text_of(walker)(frame, id.0)).expect("JSON");
            let values = picture["people"][0]["pose_keypoints_2d"].as_array().expect("points");
            let mut points = [[f64::NAN; 2]; 33];
            for (k, to) in MEDIAPIPE.into_iter().enumerate() {
                let number = |axis: usize| values[3 * (5 + k) + axis].as_f64().expect("a number");
                points[to] = [number(0), number(1)];
            }
            points.as_flattened().iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        }
    }
    bytes
}

#[test]
fn freemocaps_array_of_all_cameras_says_what_the_files_of_all_pictures_say() {
    let walker = walker();
    let folder = project(&walker, text_of(&walker));
    let wanted = observed(folder.path()).expect("detections");

    let bytes = array(&walker);
    let session = tempfile::tempdir().expect("a folder");
    let raw = session.path().join("output_data/raw_data");
    fs::create_dir_all(&raw).expect("a folder");
    let name = "mediapipe_2dData_numCams_numFrames_numTrackedPoints_pixelXY.npy";
    fs::write(raw.join(name), &bytes).expect("a file");
    fs::write(session.path().join("calibration.toml"), write_toml(&walker.rig)).expect("a file");

    let found = observed(session.path());
    let found = found.expect("detections");
    assert_eq!(found.frames, wanted.frames);
    for frame in 0..FRAMES {
        let pictures = |files: &ObservationFiles| {
            let people = files.load_people(frame).expect("a frame").pictures;
            let joint = |k: &Keypoint| {
                let at = COCO.iter().position(|name| *name == k.name)?;
                (at >= 5).then(|| (k.name, k.pixel.x.round() as i64, k.pixel.y.round() as i64))
            };
            let of_picture = |(id, people): &(_, Vec<Vec<Keypoint>>)| {
                let mut joints: Vec<_> = people[0].iter().filter_map(joint).collect();
                joints.sort_unstable();
                (*id, joints)
            };
            people.iter().map(of_picture).collect::<Vec<_>>()
        };
        assert_eq!(pictures(&found), pictures(&wanted));
    }
    let inputs = found.checksums().expect("files");
    assert!(inputs.iter().any(|input| input.input.starts_with("detections of ")), "{inputs:?}");

    fs::write(raw.join(name), &bytes[..bytes.len() - 8]).expect("a file");
    let fault = observed(session.path());
    let fault = fault.expect_err("a short array").to_string();
    assert!(fault.contains("bytes for its shape") && !fault.contains('\n'), "{fault}");
}
