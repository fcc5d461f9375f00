//! The border of a mask, finer than its pixels.

use nalgebra::Point2;

use super::{Plane, Runs};

/// Margin around the mask: the reach of the blur, and one pixel more so that every border closes.
const MARGIN: usize = 3;
/// The level of the border: half of 16 · 16, the value of blurred foreground.
const LEVEL: u16 = 128;
/// Most points of a resampled polyline.
const MOST_POINTS: f64 = 1e6;

/// The outer and inner borders of a mask as closed polylines; the last point is joined to the first.
///
/// The mask is blurred by the binomial (1 4 6 4 1)/16 in x and in y, variance σ² = 1 px², and the polylines are its
/// level ½ (marching squares; at a saddle the mean of the four corners decides). They run with the foreground on the
/// *left* as seen on the screen (x right, y down): walking to +x, the foreground is above.
///
/// A straight border stays where it is; one of radius R moves inwards by σ²/(2R), 0.0125 px for R = 40 px. Pieces
/// narrower than two pixels vanish. Beyond the image all is background, so a person cut by the image edge has a border
/// along it, rounded within two pixels of its ends.
pub fn trace(runs: &Runs) -> Vec<Vec<Point2<f64>>> {
    let Some(region) = runs.region() else {
        return Vec::new();
    };
    let blurred = blurred(&runs.painted(&region, MARGIN));
    let mut visited = Plane::filled(blurred.width(), blurred.height(), false);
    let (left, top) = (region.left as f64, region.top as f64);
    let offset = nalgebra::Vector2::new(left - MARGIN as f64, top - MARGIN as f64);

    // every border crosses the top of some cell downwards
    let mut contours = Vec::new();
    for y in 0..blurred.height() {
        let row = blurred.row(y);
        for x in 0..row.len().saturating_sub(1) {
            if row[x] < LEVEL && row[x + 1] >= LEVEL && visited.get(x, y) == Some(false) {
                let mut contour = follow(&blurred, &mut visited, x, y);
                contour.iter_mut().for_each(|point| *point += offset);
                contours.push(contour);
            }
        }
    }
    contours
}

/// Points of a closed polyline at equal arc length, each the mean of the arc it stands for; at least three.
///
/// Their number is chosen so that their distance comes closest to `spacing_px`. The mean flattens the steps of the
/// pixels and moves a border of radius R inwards by spacing²/(24 R). Empty if the polyline has no length or the spacing
/// is not positive.
pub fn resample(closed: &[Point2<f64>], spacing_px: f64) -> Vec<Point2<f64>> {
    let next = closed.iter().cycle().skip(1);
    let segments: Vec<_> = closed.iter().zip(next).collect();
    let length: f64 = segments.iter().map(|(a, b)| (*b - *a).norm()).sum();
    let count = (length / spacing_px).round().clamp(3.0, MOST_POINTS);
    if length <= 0.0 || spacing_px <= 0.0 || count.is_nan() {
        return Vec::new();
    }

    // `sum` is the integral over the current arc, of which the length `missing` is still to come
    let arc = length / count;
    let mut means = Vec::with_capacity(count as usize);
    let mut sum = nalgebra::Vector2::zeros();
    let mut missing = arc;
    for (a, b) in segments {
        let mut from = *a;
        let mut rest = (b - from).norm();
        while rest > missing {
            let to = from + (b - from) * (missing / rest);
            sum += nalgebra::center(&from, &to).coords * missing;
            means.push(Point2::from(sum / arc));
            rest -= missing;
            (from, sum, missing) = (to, nalgebra::Vector2::zeros(), arc);
        }
        sum += nalgebra::center(&from, b).coords * rest;
        missing -= rest;
    }

    // rounding decides whether the last arc was finished
    if means.len() < count as usize && missing < 0.5 * arc {
        means.push(Point2::from(sum / (arc - missing)));
    }
    means
}

/// The binomial blur of a plane of ones and zeros, times 16 · 16.
fn blurred(plane: &Plane<u8>) -> Plane<u16> {
    let mut across = Plane::filled(plane.width(), plane.height(), 0u8);
    for y in 0..plane.height() {
        let row = plane.row(y);
        if let Some(inner) = across.row_mut(y).get_mut(2..) {
            let windows = row.windows(5);
            for (out, w) in inner.iter_mut().zip(windows) {
                *out = w[0] + w[4] + 4 * (w[1] + w[3]) + 6 * w[2];
            }
        }
    }

    let width = plane.width();
    let mut blurred = Plane::filled(width, plane.height(), 0u16);
    for y in 2..plane.height().saturating_sub(2) {
        // slices of one known length: no bounds are checked in the loop
        let rows = [-2, -1, 0, 1, 2].map(|dy: isize| across.row(y.wrapping_add_signed(dy)));
        let [a, b, c, d, e] = rows.map(|row| &row[..width]);
        let out = &mut blurred.row_mut(y)[..width];
        for x in 0..width {
            let (outer, inner) = (u16::from(a[x] + e[x]), u16::from(b[x] + d[x]));
            out[x] = outer + 4 * inner + 6 * u16::from(c[x]);
        }
    }
    blurred
}

/// Edges of a cell of four neighbouring pixels.
#[derive(Clone, Copy)]
enum Edge {
    Top,
    Right,
    Bottom,
    Left,
}

/// The closed border that enters the cell (x, y) downwards through its top edge.
fn follow(
    blurred: &Plane<u16>,
    visited: &mut Plane<bool>,
    mut x: usize,
    mut y: usize,
) -> Vec<Point2<f64>> {
    let value = |x: usize, y: usize| blurred.get(x, y).unwrap_or(0);
    let mut contour = Vec::new();
    let mut entry = Edge::Top;

    loop {
        let corners = [value(x, y), value(x + 1, y), value(x + 1, y + 1), value(x, y + 1)];

        // only top edges are marked: a border has no other start
        if matches!(entry, Edge::Top) {
            match visited.row_mut(y).get_mut(x) {
                Some(seen) if !*seen => *seen = true,
                _ => return contour,
            }
        }
        contour.push(crossing(corners, entry, Point2::new(x as f64, y as f64)));

        entry = match exit(corners, entry) {
            Edge::Top => {
                y -= 1;
                Edge::Bottom
            }
            Edge::Right => {
                x += 1;
                Edge::Left
            }
            Edge::Bottom => {
                y += 1;
                Edge::Top
            }
            Edge::Left => {
                x -= 1;
                Edge::Right
            }
        };
    }
}

/// Where the level crosses an edge of the cell whose top left pixel is `corner`.
fn crossing(corners: [u16; 4], edge: Edge, corner: Point2<f64>) -> Point2<f64> {
    let [tl, tr, br, bl] = corners;
    let (x, y) = (corner.x, corner.y);
    let between =
        |a: u16, b: u16| (f64::from(LEVEL) - f64::from(a)) / (f64::from(b) - f64::from(a));
    match edge {
        Edge::Top => Point2::new(x + between(tl, tr), y),
        Edge::Right => Point2::new(x + 1.0, y + between(tr, br)),
        Edge::Bottom => Point2::new(x + between(bl, br), y + 1.0),
        Edge::Left => Point2::new(x, y + between(tl, bl)),
    }
}

/// The edge by which a border with the foreground on its left leaves the cell that it entered by `entry`.
fn exit(corners: [u16; 4], entry: Edge) -> Edge {
    let [tl, tr, br, bl] = corners.map(|corner| corner >= LEVEL);
    let is_open = [tl && !tr, tr && !br, br && !bl, bl && !tl];
    let edges = [Edge::Top, Edge::Right, Edge::Bottom, Edge::Left];
    let is_saddle = tl == br && tr == bl && tl != tr;

    if is_saddle {
        let is_joined = corners.iter().map(|c| u32::from(*c)).sum::<u32>() >= 4 * u32::from(LEVEL);
        let turn = if is_joined { 3 } else { 1 };
        return edges[(entry as usize + turn) % 4];
    }

    let open = is_open.iter().position(|is_open| *is_open);
    edges[open.unwrap_or(entry as usize)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Mask;

    fn disk(center: Point2<f64>, radius: f64) -> Runs {
        Runs::from_mask(&Mask::from_fn(120, 110, |x, y| {
            (Point2::new(x as f64, y as f64) - center).norm() < radius
        }))
    }

    /// Twice the area, positive when the inside is on the left as seen on the screen.
    fn doubled_area(closed: &[Point2<f64>]) -> f64 {
        let next = closed.iter().cycle().skip(1);
        closed.iter().zip(next).map(|(a, b)| b.x * a.y - a.x * b.y).sum()
    }

    #[test]
    fn the_border_of_a_disk_is_right_to_a_fraction_of_a_pixel() {
        let (mut deviations, mut means) = (Vec::new(), Vec::new());
        for k in 0..25 {
            let center = Point2::new(60.0 + f64::from(k % 5) * 0.2, 55.1 + f64::from(k / 5) * 0.2);
            let contours = trace(&disk(center, 40.0));
            assert_eq!(contours.len(), 1);
            let points = resample(&contours[0], 2.0);
            let radii: Vec<f64> = points.iter().map(|p| (p - center).norm()).collect();
            let mean = radii.iter().sum::<f64>() / radii.len() as f64;
            means.push(mean - 40.0);
            deviations.extend(radii.iter().map(|r| (r - mean).powi(2)));
        }
        let mean = means.iter().sum::<f64>() / means.len() as f64;
        let rms = (deviations.iter().sum::<f64>() / deviations.len() as f64).sqrt();
        assert!(mean.abs() < 0.03, "mean radius off by {mean} px");
        assert!(means.iter().all(|m| m.abs() < 0.1), "{means:?}");
        assert!(rms < 0.14, "rms {rms} px");
    }

    #[test]
    fn the_foreground_is_on_the_left_of_outer_and_inner_borders() {
        let ring = Runs::from_mask(&Mask::from_fn(100, 100, |x, y| {
            let r = (x as f64 - 50.0).hypot(y as f64 - 50.0);
            (20.0..40.0).contains(&r)
        }));
        let mut areas: Vec<f64> = trace(&ring).iter().map(|c| 0.5 * doubled_area(c)).collect();
        areas.sort_by(f64::total_cmp);
        let pi = std::f64::consts::PI;
        assert_eq!(areas.len(), 2);
        approx::assert_relative_eq!(areas[0], -pi * 400.0, max_relative = 0.02);
        approx::assert_relative_eq!(areas[1], pi * 1600.0, max_relative = 0.01);
    }

    #[test]
    fn a_straight_border_stays_where_it_is() {
        let block = Runs::from_mask(&Mask::from_fn(60, 60, |x, y| x > 19 && x < 50 && y > 9));
        let contours = trace(&block);
        let left: Vec<_> =
            contours[0].iter().filter(|p| p.x < 25.0 && p.y > 20.0 && p.y < 50.0).collect();
        assert!(left.len() > 20);
        assert!(left.iter().all(|p| (p.x - 19.5).abs() < 1e-9));
    }

    #[test]
    fn squares_that_touch_at_a_corner_are_one_piece_like_their_component() {
        let touching = Runs::from_mask(&Mask::from_fn(40, 40, |x, y| {
            (x < 20 && y < 20) || (x >= 20 && y >= 20)
        }));
        assert_eq!(trace(&touching).len(), 1);
    }

    #[test]
    fn resampled_points_are_equally_far_apart() {
        let circle: Vec<_> = (0..1000)
            .map(|i| f64::from(i) * std::f64::consts::TAU / 1000.0)
            .map(|a| Point2::new(30.0 * a.cos(), 30.0 * a.sin()))
            .collect();
        let points = resample(&circle, 4.0);
        assert_eq!(points.len(), 47);
        for (a, b) in points.iter().zip(points.iter().cycle().skip(1)) {
            approx::assert_relative_eq!(
                (b - a).norm(),
                60.0 * (std::f64::consts::PI / 47.0).sin(),
                max_relative = 1e-2
            );
        }
    }

    #[test]
    fn a_polyline_without_length_has_no_points() {
        let point = Point2::new(1.0, 2.0);
        assert!(resample(&[], 2.0).is_empty());
        assert!(resample(&[point], 2.0).is_empty());
        assert!(resample(&[point, Point2::new(9.0, 2.0)], 0.0).is_empty());
        assert!(resample(&[point, Point2::new(f64::NAN, 2.0)], 2.0).is_empty());
        assert_eq!(resample(&[point, Point2::new(2.0, 2.0)], 50.0).len(), 3);
    }

    #[test]
    fn every_pattern_of_pixels_is_traced_to_its_end() {
        let mut random = 1u64;
        for _ in 0..200 {
            let noise = Mask::from_fn(24, 24, |_, _| true);
            let bits: Vec<bool> = (0..noise.width() * noise.height())
                .map(|_| {
                    random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    random >> 63 == 1
                })
                .collect();
            let noise = Mask::from_fn(24, 24, |x, y| bits[24 * y + x]);
            for contour in trace(&Runs::from_mask(&noise)) {
                let steps = contour.iter().zip(contour.iter().cycle().skip(1));
                assert!(steps.map(|(a, b)| (b - a).norm()).all(|step| step < 1.5));
            }
        }
    }
}
