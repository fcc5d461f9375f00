//! Bad input: one line each, and what is good is kept.

use maquette::camera::Distortion;
use maquette::image::Plane;
use maquette::stereo::matching::{MatchOptions, match_surface};
use maquette::stereo::{StereoView, rectify};

use crate::scene::{SIZE, Wall, camera, three};

fn flat(name: &str, x: f64) -> StereoView {
    let camera = camera(name, x, 0.0, Distortion::None);
    StereoView::undistorted(&camera, &Plane::filled(SIZE.0 as usize, SIZE.1 as usize, 100))
        .expect("the camera's size")
}

#[test]
fn without_texture_there_is_no_point_and_it_is_said_how_many() {
    let views = [flat("left", -0.1), flat("middle", 0.0), flat("right", 0.1)];
    let found =
        match_surface(&views[1], &[&views[0], &views[2]], None, &[], &MatchOptions::default())
            .unwrap();
    assert_eq!((found.points.len(), found.seeds), (0, 0));
    assert_eq!(found.unmatched, 60 * 45);
    assert_eq!(found.without_texture, found.unmatched);
}

#[test]
fn identical_images_of_cameras_apart_show_points_at_infinity_which_are_none() {
    let [left, middle, right] = three();
    let image = Wall::STILL.seen_by(&middle);
    let [left, middle, right] = [left, middle, right].map(|c| {
        StereoView::undistorted(&camera(&c.name, c.centre_world().x, 0.0, Distortion::None), &image)
            .unwrap()
    });
    let found =
        match_surface(&middle, &[&left, &right], None, &[], &MatchOptions::default()).unwrap();
    let near = found.points.iter().filter(|p| p.point.position_world.z < 100.0).count();
    assert_eq!(near, 0, "of {}", found.points.len());
}

#[test]
fn cameras_in_one_place_and_cameras_that_look_at_each_other_are_refused() {
    let view = |name, x, turn| Wall::STILL.view(&camera(name, x, turn, Distortion::None));
    let (a, b) = (view("a", 0.0, 0.0), view("b", 0.0, 0.0));
    let message = rectify(&a, &b).unwrap_err().to_string();
    assert!(message.contains("cameras a and b are 0.000 mm apart"), "{message}");
    let options = MatchOptions { least_images: 1, ..MatchOptions::default() };
    let message = match_surface(&a, &[&b], None, &[], &options).unwrap_err().to_string();
    assert!(message.contains("a and b are in one place"), "{message}");
    let turned =
        StereoView { camera: camera("c", 0.5, 1.6, Distortion::None), image: a.image.clone() };
    let message = rectify(&a, &turned).unwrap_err().to_string();
    assert!(message.contains("do not look side by side (92°"), "{message}");
}

#[test]
fn an_image_of_another_size_than_its_camera_s_is_refused() {
    let camera = &three()[0];
    let message =
        StereoView::undistorted(camera, &Plane::filled(10, 9, 0)).unwrap_err().to_string();
    assert_eq!(message, "camera left: expected an image of 120x90 px, found 10x9");
}

#[test]
fn too_few_images_and_numbers_that_make_no_sense_are_refused_in_one_line() {
    let [left, middle, right] = three().map(|camera| Wall::STILL.view(&camera));
    let others = [&left, &right];
    let refused = |options: &MatchOptions, others: &[&StereoView]| {
        match_surface(&middle, others, None, &[], options).unwrap_err().to_string()
    };
    let default = MatchOptions::default();
    assert!(refused(&default, &others[..1]).contains("1 images beside the template: expected 2"));
    assert!(
        refused(&MatchOptions { least_images: 0, ..default.clone() }, &[]).contains("expected 1")
    );
    let wrong = [
        MatchOptions { radius_px: 0, ..default.clone() },
        MatchOptions { larger_radius_px: 1, ..default.clone() },
        MatchOptions { spacing_px: 0, ..default.clone() },
        MatchOptions { depth: Some((2.0, 1.0)), ..default.clone() },
        MatchOptions { depth: Some((f64::NAN, 1.0)), ..default.clone() },
    ];
    for options in wrong {
        let message = refused(&options, &others);
        assert!(message.contains("expected") && !message.contains('\n'), "{message}");
    }
}

#[test]
fn images_smaller_than_a_patch_give_no_points() {
    let small = |name: &str, x: f64| {
        let camera = maquette::camera::Camera {
            width_px: 3,
            height_px: 2,
            ..camera(name, x, 0.0, Distortion::None)
        };
        StereoView::undistorted(&camera, &Plane::filled(3, 2, 9)).unwrap()
    };
    let views = [small("left", -0.1), small("middle", 0.0), small("right", 0.1)];
    let found =
        match_surface(&views[1], &[&views[0], &views[2]], None, &[], &MatchOptions::default())
            .unwrap();
    assert_eq!(found.points.len(), 0);
}
