//! What is measured lies on the wall, and errs as it says.

use maquette::camera::{Distortion, Rig};
use maquette::image::Mask;
use maquette::stereo::correlation::CorrelationOptions;
use maquette::stereo::matching::{MatchOptions, match_surface};
use maquette::stereo::{SideBySide, Sighting, StereoView, depth_map, intersect, rectify};
use nalgebra::{Point2, Point3, Vector3};

use crate::scene::{SIZE, Wall, camera, finer, three};

fn views() -> [StereoView; 3] {
    three().map(|camera| Wall::STILL.view(&camera))
}

#[test]
fn lines_of_sight_meet_where_the_point_is_and_the_covariance_is_longest_in_depth() {
    let cameras = three();
    let truth = Point3::new(0.1, -0.2, 2.5);
    let sightings: Vec<Sighting<'_>> = cameras
        .iter()
        .map(|camera| Sighting {
            camera,
            pixel: camera.project_undistorted(&truth).unwrap(),
            sigma_px: 0.1,
        })
        .collect();
    let found = intersect(&sightings).unwrap();
    approx::assert_relative_eq!(found.position_world, truth, epsilon = 1e-9);
    assert!(found.residual_px < 1e-9);
    // σ_z = Z²/(f·B)·σ_d with the outer pair 30 cm apart, σ_d = √2·0.1 px; the middle one adds nothing to the base
    let sigma_z = found.covariance.m33.sqrt();
    approx::assert_relative_eq!(
        sigma_z,
        2.5f64.powi(2) / (150.0 * 0.3) * 0.1414,
        max_relative = 0.05
    );
    assert!(found.covariance.m11.sqrt() < 0.2 * sigma_z);
}

#[test]
fn points_behind_the_cameras_and_parallel_lines_of_sight_have_no_intersection() {
    let cameras = three();
    let towards = |camera, pixel| Sighting { camera, pixel, sigma_px: 0.1 };
    // lines that part before the cameras meet behind them
    let part = [
        towards(&cameras[0], Point2::new(10.0, 45.0)),
        towards(&cameras[2], Point2::new(110.0, 45.0)),
    ];
    assert_eq!(intersect(&part), None);
    let same = towards(&cameras[1], Point2::new(60.0, 45.0));
    assert_eq!(intersect(&[same, same]), None);
    assert_eq!(intersect(&[same]), None);
}

#[test]
fn a_rectified_point_is_in_the_same_row_of_both_images() {
    for (first, second) in [(0, 2), (2, 0), (1, 2)] {
        let views = views();
        let pair = rectify(&views[first], &views[second]).unwrap();
        assert_eq!(pair.left.image.height(), pair.right.image.height());
        for point in [Point3::new(0.2, 0.3, 2.2), Point3::new(-0.3, -0.1, 1.8)] {
            let [a, b] =
                [&pair.left, &pair.right].map(|v| v.camera.project_undistorted(&point).unwrap());
            approx::assert_relative_eq!(a.y, b.y, epsilon = 1e-9);
            let infinity = pair.left.camera.intrinsics.cx_px - pair.right.camera.intrinsics.cx_px;
            let depth = (pair.left.camera.camera_from_world * point).z;
            approx::assert_relative_eq!(
                a.x - b.x - infinity,
                150.0 * pair.baseline() / depth,
                epsilon = 1e-9
            );
        }
    }
}

#[test]
fn correlation_finds_the_wall_from_either_side() {
    let views = views();
    for (first, second) in [(0, 2), (2, 0)] {
        let options = CorrelationOptions::default();
        let map =
            depth_map(&views[first], &views[second], None, Some((1.5, 3.0)), &options).unwrap();
        assert!(map.points.len() > 3000, "{}", map.points.len());
        let mut off: Vec<f64> =
            map.points.iter().map(|p| Wall::STILL.off(&p.position_world).abs()).collect();
        off.sort_by(f64::total_cmp);
        assert!(off[off.len() / 2] < 0.03, "{}", off[off.len() / 2]);
    }
}

#[test]
fn matching_finds_the_wall_to_a_hundredth_of_a_pixel_and_its_errors_are_as_stated() {
    let [left, middle, right] = views();
    let options = MatchOptions { model_sigma_px: 0.01, ..MatchOptions::default() };
    let found = match_surface(&middle, &[&left, &right], None, &[], &options).unwrap();
    assert!(
        found.seeds > 10 && found.points.len() > 1200,
        "{} {}",
        found.seeds,
        found.points.len()
    );
    let mut off: Vec<f64> =
        found.points.iter().map(|p| Wall::STILL.off(&p.point.position_world).abs()).collect();
    let ratios = found
        .points
        .iter()
        .zip(&off)
        .map(|(p, off)| off / p.point.spread.along(&Vector3::z()).unwrap());
    let mut ratios: Vec<f64> = ratios.collect();
    off.sort_by(f64::total_cmp);
    ratios.sort_by(f64::total_cmp);
    // Z²/(f·B) is 27 cm for a pixel of the middle image
    assert!(off[off.len() / 2] < 0.0027, "{}", off[off.len() / 2]);
    assert!((0.1..1.5).contains(&ratios[ratios.len() / 2]), "{}", ratios[ratios.len() / 2]);
}

#[test]
fn cameras_of_different_sizes_find_the_wall_too() {
    let [left, middle, right] = three();
    let views = [finer(&left, 1.5), middle, finer(&right, 2.0)].map(|c| Wall::STILL.view(&c));
    let [left, middle, right] = &views;
    let median = |mut off: Vec<f64>| {
        off.sort_by(f64::total_cmp);
        off[off.len() / 2]
    };
    let found = match_surface(middle, &[left, right], None, &[], &MatchOptions::default()).unwrap();
    assert!(found.points.len() > 1200, "{}", found.points.len());
    let points = found.points.iter().map(|p| p.point.position_world);
    let off = median(points.map(|p| Wall::STILL.off(&p).abs()).collect());
    assert!(off < 0.003, "{off}");
    let range = Some((1.5, 3.0));
    let map = depth_map(left, right, None, range, &CorrelationOptions::default()).unwrap();
    assert!(map.points.len() > 3000, "{}", map.points.len());
    let points = map.points.iter().map(|p| p.position_world);
    let off = median(points.map(|p| Wall::STILL.off(&p).abs()).collect());
    assert!(off < 0.03, "{off}");
}

#[test]
fn a_lens_is_taken_out_before_matching() {
    let lens = Distortion::brown_conrady(&[-0.15, 0.05, 0.0, 0.0]).unwrap();
    let cameras = [("left", -0.15), ("middle", 0.0), ("right", 0.15)]
        .map(|(name, x)| camera(name, x, 0.0, lens));
    let [left, middle, right] = cameras.map(|camera| Wall::STILL.view(&camera));
    let found =
        match_surface(&middle, &[&left, &right], None, &[], &MatchOptions::default()).unwrap();
    assert!(found.points.len() > 1000);
    let mut off: Vec<f64> =
        found.points.iter().map(|p| Wall::STILL.off(&p.point.position_world).abs()).collect();
    off.sort_by(f64::total_cmp);
    assert!(off[off.len() / 2] < 0.006, "{}", off[off.len() / 2]);
}

#[test]
fn a_mask_a_given_seed_and_a_depth_change_what_is_matched() {
    let [left, middle, right] = views();
    let others = [&left, &right];
    let mask = Mask::from_fn(SIZE.0 as usize, SIZE.1 as usize, |x, _| x < 60);
    let options = MatchOptions::default();
    let half = match_surface(&middle, &others, Some(&mask), &[], &options).unwrap();
    assert!(!half.points.is_empty() && half.points.iter().all(|p| p.pixel.0 < 60));
    // no corner lies so near: only the given seed starts anything
    let near = MatchOptions { depth: Some((0.2, 0.3)), ..options };
    let nothing = match_surface(&middle, &others, None, &[], &near).unwrap();
    assert_eq!((nothing.seeds, nothing.points.len()), (0, 0));
    let given = [Point3::new(0.0, 0.0, 2.02)];
    let grown = match_surface(&middle, &others, None, &given, &near).unwrap();
    assert!(grown.seeds == 1 && grown.points.len() > 1000, "{}", grown.points.len());
}

#[test]
fn the_same_points_come_out_for_any_number_of_threads() {
    let [left, middle, right] = views();
    let by = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            match_surface(&middle, &[&left, &right], None, &[], &MatchOptions::default())
        })
        .unwrap()
    };
    assert_eq!(by(1), by(3));
}

#[test]
fn the_camera_in_the_middle_is_the_template() {
    let rig = Rig { cameras: three().to_vec() };
    let chosen = SideBySide::choose(&rig).unwrap();
    assert_eq!(chosen.template.0, 1);
    assert_eq!(chosen.others.len(), 2);
    let mut apart = three().to_vec();
    apart[0] = camera("left", -0.15, 1.5, Distortion::None);
    apart[2] = camera("right", 0.15, -1.5, Distortion::None);
    let message = SideBySide::choose(&Rig { cameras: apart }).unwrap_err().to_string();
    assert!(message.contains("3 cameras") && message.contains("25°"), "{message}");
}
