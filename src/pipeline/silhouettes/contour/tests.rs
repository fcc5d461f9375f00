use std::f64::consts::TAU;

use super::*;
use crate::camera::{Distortion, Intrinsics};
use crate::image::{Gradient, Plane};
use crate::math::Rigid3;
use crate::pipeline::silhouettes::filter::Edges;

const SIZE: (usize, usize) = (160, 140);
const MIDDLE: (f64, f64) = (80.0, 70.0);
/// At 2 m before a camera of f = 200 px a metre is 100 px long.
const DEPTH_M: f64 = 2.0;

fn camera() -> Camera {
    Camera {
        name: "front".into(),
        width_px: SIZE.0 as u32,
        height_px: SIZE.1 as u32,
        intrinsics: Intrinsics {
            fx_px: 200.0,
            fy_px: 200.0,
            cx_px: MIDDLE.0,
            cy_px: MIDDLE.1,
            skew_px: 0.0,
        },
        distortion: Distortion::None,
        camera_from_world: Rigid3::identity(),
    }
}

/// A bright disk on a dark ground.
fn disk((x0, y0): (f64, f64), radius_px: f64) -> Plane<f32> {
    let value = |i: usize| {
        let (x, y) = ((i % SIZE.0) as f64, (i / SIZE.0) as f64);
        let inside = radius_px + 0.5 - (x - x0).hypot(y - y0);
        (180.0 * inside.clamp(0.0, 1.0)) as f32
    };
    Plane::from_values(SIZE.0, SIZE.1, (0..SIZE.0 * SIZE.1).map(value).collect()).unwrap()
}

fn filtered(picture: Plane<f32>, options: &ContourOptions) -> FilteredEdges {
    let pictures = [picture];
    let edges = Edges {
        wide: Gradient::new(&pictures, options.wide_px),
        narrow: Gradient::new(&pictures, options.narrow_px),
    };
    FilteredEdges::select(&edges, Mask::from_fn(SIZE.0, SIZE.1, |_, _| true), options)
}

/// A circle with its inside on the left.
fn circle((x0, y0): (f64, f64), radius_px: f64) -> Vec<Point2<f64>> {
    let at = |i: i32| -TAU * f64::from(i) / 120.0;
    let point = |i| Point2::new(x0 + radius_px * at(i).cos(), y0 + radius_px * at(i).sin());
    (0..120).map(point).collect()
}

fn expected(pixels: Vec<Point2<f64>>) -> ModelOutline {
    let point = |pixel| OutlinePoint { pixel, part: PartId(0), depth_m: DEPTH_M };
    ModelOutline { outer: vec![pixels.into_iter().map(point).collect()], inner: Vec::new() }
}

fn found(outline: &ModelOutline, picture: Plane<f32>, options: &ContourOptions) -> ViewContours {
    let colours = [picture.clone(), picture.clone(), picture.clone()];
    let edges = filtered(picture, options);
    ViewContours::settle(&camera(), outline, &edges, &colours, options)
}

fn is_the_outline_and_not_relied_on(found: &ViewContours, outline: &ModelOutline) -> bool {
    let points: Vec<_> = found.outer.iter().flatten().collect();
    let places = points.iter().map(|p| p.pixel);
    places.eq(outline.outer.iter().flatten().map(|p| p.pixel))
        && points.iter().all(|p| p.reliability <= 0.0)
}

#[test]
fn a_contour_without_fault_is_found_and_relied_on() {
    let outline = expected(circle(MIDDLE, 42.0));
    let found = found(&outline, disk(MIDDLE, 40.0), &ContourOptions::default());
    assert_eq!(found.faults, []);
    let off = |p: &FoundPoint| (p.pixel - Point2::new(MIDDLE.0, MIDDLE.1)).norm() - 40.0;
    let farthest = found.outer[0].iter().map(|p| off(p).abs());
    let farthest = farthest.fold(0.0, f64::max);
    assert!(farthest < 0.6, "{farthest}");
    assert!(found.mean_reliability() > 0.3);
    let area = found.silhouette.as_ref().unwrap().area_px;
    assert!((area / (0.5 * TAU * 1600.0) - 1.0).abs() < 0.03, "{area}");
    assert!(found.mask(&camera()).is_foreground(80, 70));
}

#[test]
fn a_body_out_of_view_is_a_fault_without_a_silhouette() {
    let found = found(&ModelOutline::default(), disk(MIDDLE, 40.0), &ContourOptions::default());
    assert_eq!(found.faults, [ContourFault::NoOutline]);
    assert!(found.outer.is_empty() && found.silhouette.is_none());
    assert!(!found.mask(&camera()).is_foreground(80, 70));
}

#[test]
fn in_a_flat_picture_the_outline_stands_and_nothing_counts() {
    let outline = expected(circle(MIDDLE, 42.0));
    let flat = Plane::filled(SIZE.0, SIZE.1, 90.0);
    let found = found(&outline, flat, &ContourOptions::default());
    assert_eq!(found.faults, [ContourFault::Flat]);
    assert!(is_the_outline_and_not_relied_on(&found, &outline));
    let silhouette = found.silhouette.unwrap();
    let counted: f64 = silhouette.contour.iter().map(|p| p.counted_px()).sum();
    assert!(counted <= 0.0 && silhouette.area_px > 5000.0);
}

#[test]
fn an_outline_cut_by_the_image_is_told_and_does_not_count_there() {
    let middle = (20.0, 70.0);
    let cut = circle(middle, 41.0).into_iter();
    let outline = expected(cut.map(|p| Point2::new(p.x.max(-0.5), p.y)).collect());
    let found = found(&outline, disk(middle, 40.0), &ContourOptions::default());
    let is_cut =
        |f: &ContourFault| matches!(f, ContourFault::PartlyOutside { percent } if *percent > 20.0);
    assert!(found.faults.len() == 1 && is_cut(&found.faults[0]), "{:?}", found.faults);
    for point in found.outer.iter().flatten() {
        let is_held = point.expected.x < 2.0;
        assert!(!is_held || point.reliability <= 0.0, "{point:?}");
        assert!(point.expected.x < 10.0 || point.reliability > 0.2, "{point:?}");
    }
}

#[test]
fn a_contour_that_a_speck_draws_together_is_a_fault_and_the_outline_stands() {
    let options = ContourOptions { prior_m: 0.2, search_m: 0.2, ..ContourOptions::default() };
    let outline = expected(circle(MIDDLE, 9.0));
    let found = found(&outline, disk(MIDDLE, 1.5), &options);
    assert_eq!(found.faults, [ContourFault::Collapsed]);
    assert!(is_the_outline_and_not_relied_on(&found, &outline));
}

#[test]
fn a_contour_that_crosses_itself_is_a_fault_and_the_outline_stands() {
    let turned_over = |p: Point2<f64>| {
        let is_folded = p.x > 100.0;
        Point2::new(p.x, if is_folded { 140.0 - p.y } else { p.y })
    };
    let crossed = circle(MIDDLE, 40.0).into_iter().map(turned_over);
    let outline = expected(crossed.collect());
    let found = found(&outline, disk(MIDDLE, 40.0), &ContourOptions::default());
    assert_eq!(found.faults, [ContourFault::SelfCrossing]);
    assert!(is_the_outline_and_not_relied_on(&found, &outline));
}
