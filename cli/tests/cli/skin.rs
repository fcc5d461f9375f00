//! Skins of a fit and of a model.

use std::fs;

use crate::arm::{Arm, FRAMES, run};

/// The arm of the recording, with metaballs beside its ellipsoids.
pub(crate) fn soft_arm(arm: &Arm) -> String {
    let mut text = String::from(include_str!("../../../data/models/arm-2d.toml"));
    text = text.replace("name = \"arm-2d\"", "name = \"soft-arm\"");
    for (part, scale) in [("upper", "share:a"), ("lower", "rest:a")] {
        let mut balls = String::new();
        for centre in ["0.25", "0.5", "0.75"] {
            balls += &format!(
                "[[part.metaball]]\ncentre = [{centre}, 0.0, 0.0]\ncentre_scale = [\"{scale}\", \"\", \"\"]\n"
            );
            balls += "radii = [0.3, 0.15, 0.15]\n";
        }
        let head = format!("radii_scale = [\"{scale}\", \"\", \"\"]\n");
        assert!(text.contains(&head), "{part}");
        text = text.replace(&head, &format!("{head}{balls}"));
    }
    arm.write("soft-arm.toml", &text);
    arm.recording().join("soft-arm.toml").display().to_string()
}

#[test]
fn the_skin_of_each_fitted_frame_is_written_and_pictured() {
    let arm = Arm::new();
    let body = soft_arm(&arm);
    arm.fit_with_body("out", &body, &[]).succeeded();
    let out = arm.out("out").display().to_string();
    let said = run(&["skin", &out, "--body", &body, "--around", "24"]).succeeded();
    assert!(said.out.contains("6 skins of soft-arm"), "{}", said.out);
    for frame in 0..FRAMES {
        let mesh = arm.bytes("out", &format!("skin/frame_{frame:06}.ply"));
        assert!(mesh.starts_with(b"ply\nformat binary_little_endian 1.0\n"));
    }
    let first = arm.bytes("out", "skin/frame_000001.ply");
    assert_ne!(first, arm.bytes("out", "skin/frame_000004.ply"), "the arm moves");
    let one = ["skin", &out, "--body", &body, "--frame", "2", "--picture", "--format", "obj"];
    run(&one).succeeded();
    assert!(arm.bytes("out", "skin/frame_000002.obj").starts_with(b"# metres, Z up\n"));
    let picture = image::load_from_memory(&arm.bytes("out", "skin/frame_000002.png"));
    let picture = picture.expect("a picture").to_rgb8();
    let is_skin = |pixel: &&image::Rgb<u8>| pixel.0 != [255; 3];
    let share = picture.pixels().filter(is_skin).count() as f64 / 480_000.0;
    assert!((0.01..0.5).contains(&share), "{share} of the picture");
    let said = run(&["skin", &out, "--body", &body, "--rest", "--quiet", "--json"]).succeeded();
    crate::schema::check("skin", &said.out);
    assert!(arm.out("out").join("skin/rest.ply").exists());
}

#[test]
fn a_skin_that_cannot_be_is_refused_and_a_new_fit_takes_the_old_ones_away() {
    let arm = Arm::new();
    let body = soft_arm(&arm);
    arm.fit_with_body("out", &body, &[]).succeeded();
    let out = arm.out("out").display().to_string();
    run(&["skin", &out, "--body", &body, "--rest", "--quiet"]).succeeded();
    let refused = |more: &[&str], parts: &[&str]| {
        let mut arguments = vec!["skin", &out, "--body", &body];
        arguments.extend(more);
        run(&arguments).refused(parts);
    };
    refused(&["--frame", "6"], &["--frames 6:6", "the result has 0 to 5"]);
    refused(&["--frames", "8:9"], &["--frames 8:9", "the result has 0 to 5"]);
    refused(&["--around", "15"], &["even number from 16 to 1024, found 15"]);
    refused(&["--frame", "1", "--rest"], &["cannot be used with"]);
    run(&["skin", &out, "--body", "walker-metaballs"]).refused(&[
        "this result was fitted with body model soft-arm (67 shape coefficients)",
        "walker-metaballs",
    ]);
    run(&["skin", &out]).refused(&["no body model \"soft-arm\""]);
    let mut again = arm.fit_arguments("out");
    again.push("--overwrite".into());
    run(&again).succeeded();
    assert!(!arm.out("out").join("skin").exists());
    run(&["skin", &out]).refused(&["body model arm-2d has no metaballs"]);
}

#[test]
fn a_folder_without_a_result_is_refused() {
    let arm = Arm::new();
    let nothing = arm.out("nothing").display().to_string();
    run(&["skin", &nothing]).refused(&["result.json", "a finished `maquette fit`"]);
    fs::create_dir_all(&nothing).expect("a folder");
    fs::write(arm.out("nothing").join("result.json"), "{\n\"format\": 1}").expect("written");
    run(&["skin", &nothing]).refused(&["result.json:2: not a result"]);
}

#[test]
fn a_model_shows_its_mean_body() {
    let arm = Arm::new();
    let file = |name: &str| arm.out(name).display().to_string();
    let (mesh, picture) = (file("body.obj"), file("body.png"));
    let show = ["models", "walker-metaballs", "--skin", &mesh, "--picture", &picture];
    let said = run(&show).succeeded();
    assert!(said.out.contains("vertices"), "{}", said.out);
    let text = fs::read_to_string(&mesh).expect("a mesh");
    assert!(text.lines().filter(|l| l.starts_with("v ")).count() > 3000);
    assert!(image::open(&picture).is_ok());
    let solid = ["models", "human-ellipsoids", "--skin", &mesh];
    run(&solid).refused(&["human-ellipsoids has no metaballs", "[[part.metaball]]"]);
    let odd = ["models", "walker-metaballs", "--skin", "body.stl"];
    run(&odd).refused(&["ends in .ply or .obj"]);
    run(&["models", "walker-metaballs"]).refused(&["--skin"]);
}
