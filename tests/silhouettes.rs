//! Silhouettes of shapes that are known: disks, seen with and without a lens.

use maquette::camera::{Camera, Distortion, Intrinsics};
use maquette::image::Mask;
use maquette::math::Rigid3;
use maquette::silhouette::{Rejected, Silhouette, SilhouetteOptions, extract};
use nalgebra::{Point2, Vector2};

const PI: f64 = std::f64::consts::PI;

fn camera(distortion: Distortion) -> Camera {
    Camera {
        name: "left".into(),
        width_px: 320,
        height_px: 240,
        intrinsics: Intrinsics {
            fx_px: 250.0,
            fy_px: 251.0,
            cx_px: 161.0,
            cy_px: 118.0,
            skew_px: 0.0,
        },
        distortion,
        camera_from_world: Rigid3::identity(),
    }
}

fn barrel() -> Camera {
    camera(Distortion::brown_conrady(&[-0.2, 0.05, 0.001, -0.001]).expect("four coefficients"))
}

/// The recorded mask of what satisfies `is_inside` in undistorted pixels.
fn mask(camera: &Camera, is_inside: impl Fn(&Point2<f64>) -> bool) -> Mask {
    Mask::from_fn(320, 240, |x, y| {
        let pixel = Point2::new(x as f64, y as f64);
        camera.undistort(&pixel).is_some_and(|pixel| is_inside(&pixel))
    })
}

fn disk(center: Point2<f64>, radius: f64) -> impl Fn(&Point2<f64>) -> bool {
    move |pixel| (pixel - center).norm() < radius
}

fn seen(camera: &Camera, is_inside: impl Fn(&Point2<f64>) -> bool) -> Silhouette {
    extract(&mask(camera, is_inside), camera, &SilhouetteOptions::default()).expect("a silhouette")
}

fn length(silhouette: &Silhouette) -> f64 {
    silhouette.contour.iter().map(|point| point.length_px).sum()
}

#[test]
fn a_disk_has_its_area_border_and_normals_with_and_without_a_lens() {
    let center = Point2::new(90.2, 80.7);
    for camera in [camera(Distortion::None), barrel()] {
        let silhouette = seen(&camera, disk(center, 40.0));
        approx::assert_relative_eq!(silhouette.area_px, PI * 1600.0, max_relative = 0.01);
        approx::assert_relative_eq!(silhouette.centroid, center, epsilon = 0.1);
        approx::assert_relative_eq!(length(&silhouette), PI * 80.0, max_relative = 0.02);
        approx::assert_relative_eq!(
            silhouette.bounds.0,
            center - Vector2::repeat(40.0),
            epsilon = 0.6
        );
        for point in &silhouette.contour {
            let outward = point.pixel - center;
            assert!((outward.norm() - 40.0).abs() < 0.7, "{point:?}");
            assert!(point.normal.dot(&outward) / outward.norm() > 0.9, "{point:?}");
            approx::assert_relative_eq!(point.normal.norm(), 1.0, epsilon = 1e-12);
        }
    }
}

#[test]
fn the_inside_is_that_of_the_disk() {
    let center = Point2::new(90.2, 80.7);
    let silhouette = seen(&barrel(), disk(center, 40.0));
    for i in 0..4000 {
        let pixel = Point2::new(f64::from(i % 80) * 2.0, f64::from(i / 80) * 3.2);
        let r = (pixel - center).norm();
        if (r - 40.0).abs() > 1.0 {
            assert_eq!(silhouette.contains(&pixel), r < 40.0, "{pixel}");
        }
    }
}

#[test]
fn the_border_of_a_hole_points_into_the_hole() {
    let center = Point2::new(150.2, 120.3);
    let ring = |pixel: &Point2<f64>| (20.0..50.0).contains(&(pixel - center).norm());
    let silhouette = seen(&camera(Distortion::None), ring);
    approx::assert_relative_eq!(length(&silhouette), PI * 140.0, max_relative = 0.02);
    for point in &silhouette.contour {
        let outward = point.pixel - center;
        let is_outer = outward.norm() > 35.0;
        assert_eq!(point.normal.dot(&outward) > 0.0, is_outer, "{point:?}");
    }
    assert!(!silhouette.contains(&center));
    let (distance, gradient) = silhouette.outside.sample(&(center + Vector2::new(10.0, 0.0)));
    approx::assert_relative_eq!(distance, 10.0, epsilon = 0.3);
    approx::assert_relative_eq!(gradient, Vector2::new(-1.0, 0.0), epsilon = 0.35);
}

#[test]
fn the_map_holds_the_distance_to_the_disk_in_the_grid_and_beyond() {
    let center = Point2::new(140.2, 118.7);
    for camera in [camera(Distortion::None), barrel()] {
        let silhouette = seen(&camera, disk(center, 30.0));
        for k in 0..600 {
            let (angle, r) = (f64::from(k) * 0.7, f64::from(k % 30) * 3.5);
            let pixel = center + Vector2::new(angle.cos(), angle.sin()) * r;
            let (distance, gradient) = silhouette.outside.sample(&pixel);
            let expected = if silhouette.sees(&pixel) { (r - 30.0).max(0.0) } else { 0.0 };
            // beyond the grid an upper bound by the triangle inequality
            let slack = if r < 42.0 { 0.7 } else { 0.7 + 0.12 * expected };
            assert!(
                (-0.7..slack).contains(&(distance - expected)),
                "{pixel} {distance} {expected}"
            );
            if distance > 1.0 && r < 42.0 {
                assert!((gradient.norm() - 1.0).abs() < 0.05, "{pixel} {gradient}");
            }
        }
    }
}

#[test]
fn the_gradient_of_the_map_is_that_of_its_value() {
    let silhouette = seen(&barrel(), disk(Point2::new(140.2, 118.7), 30.0));
    let h = 1e-5;
    let mut checked = 0;
    for k in 0..3000 {
        let pixel = Point2::new(f64::from(k % 60) * 5.013, f64::from(k / 60) * 4.507);
        let value = |dx: f64, dy: f64| silhouette.outside.sample(&(pixel + Vector2::new(dx, dy))).0;
        let slope = Vector2::new(value(h, 0.0) - value(-h, 0.0), value(0.0, h) - value(0.0, -h))
            / (2.0 * h);
        let gradient = silhouette.outside.sample(&pixel).1;
        approx::assert_relative_eq!(gradient, slope, epsilon = 1e-5);
        checked += usize::from(gradient.norm() > 0.0);
    }
    assert!(checked > 2000, "{checked}");
}

#[test]
fn the_image_edge_is_no_silhouette_and_nothing_is_known_beyond() {
    let center = Point2::new(300.0, 120.0);
    let silhouette = seen(&camera(Distortion::None), disk(center, 50.0));
    // the right edge at 319.5 cuts the disk at a distance of 19.5 from its centre
    let half_angle = (19.5f64 / 50.0).acos();
    let arc = (2.0 * PI - 2.0 * half_angle) * 50.0;
    approx::assert_relative_eq!(length(&silhouette), arc, max_relative = 0.03);
    approx::assert_relative_eq!(silhouette.cut_px, 100.0 * half_angle.sin(), max_relative = 0.1);
    for point in &silhouette.contour {
        assert!(((point.pixel - center).norm() - 50.0).abs() < 1.0, "{point:?}");
        assert!(point.normal.dot(&(point.pixel - center)) > 40.0, "{point:?}");
    }
    let beyond = Point2::new(330.0, 200.0);
    assert!(!silhouette.sees(&beyond));
    assert_eq!(silhouette.outside.sample(&beyond), (0.0, Vector2::zeros()));
    let jumps = silhouette.contour.windows(2).filter(|w| (w[1].pixel - w[0].pixel).norm() > 5.0);
    assert_eq!(jumps.count(), 0, "the open piece starts behind the edge and ends before it");
}

#[test]
fn a_pixel_that_is_no_number_is_nowhere() {
    let silhouette = seen(&camera(Distortion::None), disk(Point2::new(150.0, 120.0), 50.0));
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        for pixel in [Point2::new(x, 100.0), Point2::new(100.0, x), Point2::new(x, x)] {
            let (distance, _) = silhouette.outside.sample(&pixel);
            assert_eq!(distance.is_nan(), x.is_nan(), "{pixel}");
            assert!(x.is_nan() || distance.abs() <= 0.0, "{pixel}");
            assert!(!silhouette.contains(&pixel) && !silhouette.sees(&pixel), "{pixel}");
            silhouette.overlap(
                &silhouette.overlap_grid((pixel, pixel)),
                f64::INFINITY,
                |_, _, _| true,
            );
        }
    }
}

#[test]
fn thinning_keeps_the_length_and_the_points() {
    let center = Point2::new(150.2, 120.3);
    let ring = |pixel: &Point2<f64>| (20.0..50.0).contains(&(pixel - center).norm());
    let silhouette = seen(&camera(Distortion::None), ring);
    let thinned = silhouette.thinned(10.0);
    let sum: f64 = thinned.iter().map(|point| point.length_px).sum();
    approx::assert_relative_eq!(sum, length(&silhouette), epsilon = 1e-9);
    assert_eq!(thinned.len(), 31 + 13);
    for point in &thinned {
        assert!(silhouette.contour.iter().any(|p| p.pixel == point.pixel));
        assert!((5.0..15.0).contains(&point.length_px), "{point:?}");
    }
    assert_eq!(silhouette.thinned(0.1), silhouette.contour);
    assert_eq!(silhouette.thinned(1e9).len(), 2);
}

/// A model that lies farther outside is astray.
const FAR_PX: f64 = 20.0;

/// The area that two disks have in common whose centres lie d apart.
fn lens(r: f64, big: f64, d: f64) -> f64 {
    let part = |a: f64, b: f64| a * a * ((d * d + a * a - b * b) / (2.0 * d * a)).acos();
    let kite = (r + big - d) * (d + r - big) * (d - r + big) * (d + r + big);
    part(r, big) + part(big, r) - 0.5 * kite.sqrt()
}

#[test]
fn the_overlap_of_two_disks_is_that_of_geometry() {
    let silhouette = seen(&camera(Distortion::None), disk(Point2::new(120.3, 119.6), 50.0));
    let full = PI * 2500.0;
    let astray = full - lens(50.0, 50.0 + FAR_PX, 50.0);
    for (shift, intersection, astray) in
        [(0.0, full, 0.0), (50.0, lens(50.0, 50.0, 50.0), astray), (150.0, 0.0, full)]
    {
        let model = Point2::new(120.3 + shift, 119.6);
        let reach = Vector2::repeat(50.0);
        let grid = silhouette.overlap_grid((model - reach, model + reach));
        let is_model = disk(model, 50.0);
        let overlap = silhouette.overlap(&grid, FAR_PX, |_, _, pixel| is_model(pixel));
        let union = PI * 5000.0 - intersection;
        approx::assert_relative_eq!(overlap.intersection, intersection, epsilon = 80.0);
        approx::assert_relative_eq!(overlap.union, union, epsilon = 120.0);
        approx::assert_relative_eq!(overlap.iou(), intersection / union, epsilon = 0.015);
        approx::assert_relative_eq!(overlap.model, full, epsilon = 80.0);
        approx::assert_relative_eq!(overlap.astray, astray, epsilon = 80.0);
        approx::assert_relative_eq!(overlap.astray_share(), astray / full, epsilon = 0.01);
    }
}

#[test]
fn a_model_that_leaves_the_image_is_not_held_against_it() {
    let center = Point2::new(300.0, 120.0);
    let silhouette = seen(&camera(Distortion::None), disk(center, 50.0));
    let reach = Vector2::repeat(50.0);
    let grid = silhouette.overlap_grid((center - reach, center + reach));
    let is_model = disk(center, 50.0);
    let overlap = silhouette.overlap(&grid, FAR_PX, |_, _, pixel| is_model(pixel));
    assert!(overlap.iou() > 0.97, "{overlap:?}");
}

#[test]
fn a_mask_without_a_person_is_rejected_with_the_reason() {
    let camera = camera(Distortion::None);
    let reject = |mask: &Mask| extract(mask, &camera, &SilhouetteOptions::default()).err();
    assert_eq!(reject(&mask(&camera, |_| false)), Some(Rejected::Empty));
    assert_eq!(reject(&mask(&camera, |_| true)), Some(Rejected::Full { edge_percent: 100.0 }));
    let inverted = mask(&camera, |pixel| (pixel - Point2::new(150.0, 120.0)).norm() > 50.0);
    assert_eq!(reject(&inverted), Some(Rejected::Full { edge_percent: 100.0 }));
    let thin = mask(&camera, |pixel| (pixel.x - 100.0).abs() < 0.5);
    assert_eq!(reject(&thin), Some(Rejected::NoBorder { area_px: 240 }));
    let small = Mask::from_fn(32, 24, |x, _| x > 10);
    let expected = Rejected::Size { expected: (320, 240), found: (32, 24) };
    assert_eq!(reject(&small), Some(expected));
}

#[test]
fn every_option_changes_the_silhouette() {
    let camera = camera(Distortion::None);
    let mask = mask(&camera, disk(Point2::new(150.0, 120.0), 80.0));
    let defaults = SilhouetteOptions::default();
    let with =
        |options: SilhouetteOptions| extract(&mask, &camera, &options).expect("a silhouette");
    let usual = with(defaults);
    let wider = with(SilhouetteOptions { spacing_px: 3.0, ..defaults });
    assert!(wider.contour.len() * 3 < usual.contour.len() * 2);
    let fewer = with(SilhouetteOptions { points_per_size: 40.0, ..defaults });
    assert!(fewer.contour.len() * 2 < usual.contour.len());
    let coarse = with(SilhouetteOptions { map_cells: 20, ..defaults });
    assert!(coarse.heap_bytes() * 2 < usual.heap_bytes());
    let tight = with(SilhouetteOptions { map_margin: 0.01, ..defaults });
    let corner = Point2::new(40.0, 60.0);
    assert!(tight.outside.sample(&corner).0 > usual.outside.sample(&corner).0 + 1.0);
}
