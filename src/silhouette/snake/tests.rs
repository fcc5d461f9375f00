use std::f64::consts::TAU;

use super::*;
use crate::image::Plane;

/// A bright ellipse of half axes 50 and 35 about (80, 70), its border one pixel wide.
fn picture() -> Plane<f32> {
    let value = |x: f64, y: f64| {
        let (u, v) = ((x - 80.0) / 50.0, (y - 70.0) / 35.0);
        let rho = u.hypot(v);
        let outside = (rho - 1.0) / (u / 50.0).hypot(v / 35.0).max(1e-9) * rho;
        (180.0 * (0.5 - outside).clamp(0.0, 1.0)) as f32
    };
    let values = (0..160 * 140).map(|i| value(f64::from(i % 160), f64::from(i / 160)));
    Plane::from_values(160, 140, values.collect()).unwrap()
}

/// A point of the ellipse grown by some pixels; anticlockwise on the screen, the inside on the left.
fn ellipse(grown_px: f64, count: usize) -> Vec<Point2<f64>> {
    let at = |i: usize| -TAU * i as f64 / count as f64;
    (0..count)
        .map(|i| {
            Point2::new(
                80.0 + (50.0 + grown_px) * at(i).cos(),
                70.0 + (35.0 + grown_px) * at(i).sin(),
            )
        })
        .collect()
}

fn off(points: &[Point2<f64>]) -> f64 {
    let truth = ellipse(0.0, 20_000);
    let least = |p: &Point2<f64>| truth.iter().map(|t| (t - p).norm()).fold(f64::MAX, f64::min);
    points.iter().map(least).sum::<f64>() / points.len() as f64
}

fn gradient() -> Gradient {
    Gradient::new(&[picture()], 1.0)
}

#[test]
fn a_closed_contour_comes_to_rest_on_the_border_to_a_tenth_of_a_pixel() {
    let gradient = gradient();
    for grown_px in [-2.0, 2.0] {
        let mut snake =
            Snake::new(&ellipse(grown_px, 200), Ends::Closed, SnakeOptions::default()).unwrap();
        assert!(snake.settle(&gradient));
        let points = snake.points(&gradient);
        let places: Vec<_> = points.iter().map(|p| p.pixel).collect();
        assert!(off(&places) < 0.1, "{}", off(&places));
        assert!(points.iter().all(|p| p.reliability > 0.3 && p.reliability <= 1.0));
    }
}

#[test]
fn an_edge_far_from_where_it_is_expected_is_followed_the_less_the_farther_it_is() {
    let gradient = gradient();
    let off_px = |grown_px: f64| {
        let curve = ellipse(grown_px, 200);
        let mut snake = Snake::new(&curve, Ends::Closed, SnakeOptions::default()).unwrap();
        snake.settle(&gradient);
        let points = snake.points(&gradient);
        off(&points.iter().map(|p| p.pixel).collect::<Vec<_>>())
    };
    let (near, far) = (off_px(4.0), off_px(7.5));
    assert!(near < 0.6 && far > 2.0 * near, "{near} {far}");
}

#[test]
fn an_open_contour_settles_on_its_piece_of_the_border() {
    let gradient = gradient();
    let piece: Vec<_> = ellipse(2.0, 200)[20..70].to_vec();
    let mut snake = Snake::new(&piece, Ends::Open, SnakeOptions::default()).unwrap();
    snake.settle(&gradient);
    let places: Vec<_> = snake.points(&gradient).iter().map(|p| p.pixel).collect();
    assert!(off(&places) < 0.15, "{}", off(&places));
    assert!((places[0] - piece[0]).norm() < 6.0);
}

#[test]
fn in_a_gap_of_the_border_the_expected_place_is_held_and_not_relied_on() {
    let whole = gradient();
    let right = crate::image::Mask::from_fn(160, 140, |x, y| !(x > 100 && (50..90).contains(&y)));
    let gapped = whole.within(&right);
    let at_gap = |rest| {
        let options = SnakeOptions { rest, ..SnakeOptions::default() };
        let mut snake = Snake::new(&ellipse(3.0, 200), Ends::Closed, options).unwrap();
        snake.settle(&gapped);
        let points = snake.points(&gapped);
        let tip = points.into_iter().max_by(|a, b| a.pixel.x.total_cmp(&b.pixel.x));
        tip.unwrap()
    };
    let tip = at_gap(Rest::Expected);
    assert!((tip.pixel.x - 133.0).abs() < 0.5, "{tip:?}");
    assert!(tip.reliability < 0.01);
    assert!(at_gap(Rest::Straight).pixel.x < tip.pixel.x - 0.5);
}

#[test]
fn without_an_edge_nothing_moves_and_nothing_is_relied_on() {
    let flat = Gradient::new(&[Plane::filled(160, 140, 90.0)], 1.0);
    let mut snake = Snake::new(&ellipse(0.0, 200), Ends::Closed, SnakeOptions::default()).unwrap();
    assert!(snake.settle(&flat));
    for point in snake.points(&flat) {
        assert!((point.pixel - point.expected).norm() < 1e-9);
        // the sums of a constant are not 0 to the last bit
        assert!(point.reliability < 1e-6);
    }
}

#[test]
fn at_the_border_of_the_picture_a_contour_is_held() {
    let gradient = gradient();
    let curve: Vec<_> =
        ellipse(3.0, 200).iter().map(|p| Point2::new(p.x.min(100.0), p.y)).collect();
    let narrow = Plane::from_values(
        102,
        140,
        (0..140).flat_map(|y| picture().row(y)[..102].to_vec()).collect(),
    );
    let narrow = Gradient::new(&[narrow.unwrap()], 1.0);
    let mut snake = Snake::new(&curve, Ends::Closed, SnakeOptions::default()).unwrap();
    snake.settle(&narrow);
    let at_border = snake.points(&narrow).into_iter().filter(|p| p.expected.x > 99.5);
    assert!(at_border.clone().count() > 10);
    assert!(at_border.clone().all(|p| p.reliability <= 0.0 && (p.pixel - p.expected).norm() < 1.0));
    assert_eq!(gradient.width(), 160);
}

#[test]
fn of_a_contour_that_crosses_itself_the_loops_remain() {
    let mut eight: Vec<_> = ellipse(0.0, 200);
    // one end turned over: a fold that runs the other way around
    for p in eight.iter_mut().filter(|p| p.x > 110.0) {
        p.y = 140.0 - p.y;
    }
    let snake = Snake::new(&eight, Ends::Closed, SnakeOptions::default()).unwrap();
    let loops = snake.loops();
    assert_eq!(loops.len(), 1);
    assert!(loops[0].len() < snake.points(&gradient()).len());
}

#[test]
fn a_point_is_no_contour() {
    assert!(Snake::new(&[], Ends::Closed, SnakeOptions::default()).is_none());
    assert!(
        Snake::new(&[Point2::new(3.0, 4.0); 20], Ends::Closed, SnakeOptions::default()).is_none()
    );
    assert!(
        Snake::new(&[Point2::new(f64::NAN, 4.0); 20], Ends::Open, SnakeOptions::default())
            .is_none()
    );
}

#[test]
fn every_option_can_be_noticed() {
    let gradient = gradient();
    let settled = |options: SnakeOptions| {
        let mut snake = Snake::new(&ellipse(4.0, 200), Ends::Closed, options).unwrap();
        snake.settle(&gradient);
        snake.points(&gradient).iter().map(|p| p.pixel).collect::<Vec<_>>()
    };
    let usual = SnakeOptions { rest_px: 1e-3, ..SnakeOptions::default() };
    let base = settled(usual);
    for options in [
        SnakeOptions { tension: 400.0, ..usual },
        SnakeOptions { stiffness: 1e6, ..usual },
        SnakeOptions { time_step: 0.01, ..usual },
        SnakeOptions { spacing_px: 3.0, ..usual },
        SnakeOptions { search_px: 2.0, ..usual },
        SnakeOptions { prior_px: 1.0, ..usual },
        SnakeOptions { hold: 0.9, ..usual },
        SnakeOptions { edge: 500.0, ..usual },
        SnakeOptions { rest_px: 2.0, ..usual },
        SnakeOptions { most_steps: 1, ..usual },
        SnakeOptions { rest: Rest::Straight, ..usual },
    ] {
        assert_ne!(settled(options), base, "{options:?}");
    }
}
