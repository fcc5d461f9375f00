//! The rig from above: where each camera stands by its calibration, and where it was found to be.
//!
//! x points right and y up, as in the world; the height is left out. What was found is too small to be seen, so displacements are drawn
//! as many times as large as makes the largest a tenth of the rig's extent, and turns as many times as makes the largest 30°, both rounded
//! down to 1, 2 or 5 times a power of ten. Labels have the numbers as they are.

use maud::{Markup, html};
use nalgebra::{UnitQuaternion, Vector2, Vector3};

use super::Words;
use super::drawing::{number, points};
use super::figure::{BOTH, NORM};
use crate::io::result::{PlacePart, ResultFile};
use crate::pipeline::{CameraQuality, PoseFound};

/// Of the drawing, px.
const SIZE: [f64; 2] = [840.0, 460.0];
/// For labels beside and above it, px.
const MARGIN: [f64; 2] = [190.0, 56.0];
/// How far a camera looks, px, and half its angle of view.
const SIGHT_PX: f64 = 40.0;
const HALF_VIEW: f64 = 0.25;
/// The largest displacement as a share of the rig's extent, and the largest turn, degrees.
const DRAWN_SHARE: f64 = 0.1;
const DRAWN_TURN_DEG: f64 = 30.0;

/// The view, if it is known where the cameras stand and anything was found of them.
pub(super) fn rig_view(result: &ResultFile, words: &Words) -> Option<Markup> {
    let (cameras, places) = (&result.quality.cameras, &result.quality.places);
    let has_poses = cameras.iter().any(|camera| camera.found.pose.is_some());
    if !has_poses || places.len() != cameras.len() {
        return None;
    }

    let path: Vec<Vector2<f64>> = result.motion.frames.iter().map(|f| flat(f.position_m)).collect();
    let view = View::new(places, cameras, &path);
    let is_told = |camera: &CameraQuality| camera.found.pose.is_some_and(|pose| !pose.used);
    let used = match cameras.iter().any(is_told) {
        true => words.of("It is told here and not used: the fit takes the cameras as calibrated."),
        false => words.of("The fit takes the cameras where they were found."),
    };
    let (larger, turned) = (factor(view.larger, words), factor(view.turned_more, words));
    Some(html! {
        (view.drawing(places, cameras, &path, words))
        p class="note" {
            (words.fill("The rig from above, x to the right and y up. Dashed: as calibrated; drawn through: as found, displacements \
                {larger}, turns {turned}.", &[("larger", &larger), ("turned", &turned)])) " "
            (words.of("The thin line is the person's way. Labels: turn and displacement ± one standard deviation.")) " " (used)
        }
    })
}

/// `20 times as large`.
fn factor(times: f64, words: &Words) -> String {
    match times > 1.0 {
        true => words.fill("{n} times as large", &[("n", &format!("{times:.0}"))]),
        false => words.of("as large as they are").into(),
    }
}

fn flat(v: [f64; 3]) -> Vector2<f64> {
    Vector2::new(v[0], v[1])
}

/// Where things are drawn.
struct View {
    /// What is in the middle of the drawing, m.
    middle: Vector2<f64>,
    px_per_m: f64,
    /// How many times displacements and turns are enlarged.
    larger: f64,
    turned_more: f64,
}

impl View {
    fn new(places: &[PlacePart], cameras: &[CameraQuality], path: &[Vector2<f64>]) -> Self {
        let all = || places.iter().map(|place| flat(place.centre_m)).chain(path.iter().copied());
        let low = all().fold(Vector2::repeat(f64::INFINITY), |low, p| low.inf(&p));
        let high = all().fold(Vector2::repeat(f64::NEG_INFINITY), |high, p| high.sup(&p));
        let extent = (high - low).add_scalar(1e-3);
        let px = |axis: usize| (SIZE[axis] - 2.0 * MARGIN[axis]) / extent[axis];

        let poses = || cameras.iter().filter_map(|camera| camera.found.pose);
        let displaced = poses().map(|p| flat(p.displacement_m).norm()).fold(1e-9, f64::max);
        let turned = poses().map(|p| p.turn().0).fold(1e-9, f64::max);
        Self {
            middle: 0.5 * (low + high),
            px_per_m: px(0).min(px(1)),
            larger: round_down(DRAWN_SHARE * extent.amax() / displaced),
            turned_more: round_down(DRAWN_TURN_DEG / turned),
        }
    }

    fn px(&self, place: Vector2<f64>) -> Vector2<f64> {
        let from_middle = self.px_per_m * (place - self.middle);
        Vector2::new(0.5 * SIZE[0] + from_middle.x, 0.5 * SIZE[1] - from_middle.y)
    }

    fn drawing(
        &self,
        places: &[PlacePart],
        cameras: &[CameraQuality],
        path: &[Vector2<f64>],
        words: &Words,
    ) -> Markup {
        let [width, height] = SIZE;
        let (bar_px, bar_y) = (self.px_per_m, height - 12.0);
        html! {
            div class="chart" role="img" aria-label=(words.of("The cameras from above, as calibrated and as found")) {
                svg viewBox=(format!("0 0 {width} {height}")) xmlns="http://www.w3.org/2000/svg"
                    font-family="Helvetica, Arial, sans-serif" font-size="12" fill="none" {
                    polyline points=(points(path.iter().map(|p| self.px(*p)))) stroke=(NORM) stroke-width="1" {}
                    @for (camera, place) in cameras.iter().zip(places) { (self.camera(camera, place, words)) }
                    line x1="16" y1=(bar_y) x2=(number(16.0 + bar_px)) y2=(bar_y) stroke=(BOTH) stroke-width="2" {}
                    text x="16" y=(bar_y - 6.0) fill=(BOTH) { "1 m" }
                }
            }
        }
    }

    /// A camera as calibrated, as found, and its label.
    fn camera(&self, camera: &CameraQuality, place: &PlacePart, words: &Words) -> Markup {
        let pose = camera.found.pose;
        let looks = Vector3::from(place.looks);
        let calibrated = self.px(flat(place.centre_m));
        let found = pose.map(|pose| {
            let turn = Vector3::from(pose.turn_deg).map(f64::to_radians) * self.turned_more;
            let looks = UnitQuaternion::from_scaled_axis(turn) * looks;
            let moved = flat(place.centre_m) + self.larger * flat(pose.displacement_m);
            points(wedge(self.px(moved), &looks).into_iter())
        });

        // outwards, where nothing else is drawn
        let is_left = calibrated.x < 0.5 * SIZE[0];
        let beside = if is_left { -14.0 } else { 14.0 };
        let anchor = if is_left { "end" } else { "start" };
        let label =
            pose.map_or(words.of("as calibrated").into(), |pose| words.decimal(label(&pose)));
        html! {
            polygon points=(points(wedge(calibrated, &looks).into_iter())) stroke=(NORM) stroke-dasharray="4 3" {}
            @if let Some(found) = found {
                polygon points=(found) stroke=(BOTH) stroke-width="1.5" {}
            }
            text x=(number(calibrated.x + beside)) y=(number(calibrated.y - 4.0)) text-anchor=(anchor) fill=(BOTH) font-weight="bold" {
                (camera.camera)
            }
            text x=(number(calibrated.x + beside)) y=(number(calibrated.y + 10.0)) text-anchor=(anchor) fill=(BOTH) { (label) }
        }
    }
}

/// `1.02 ± 0.12°, 19 ± 7 mm`.
fn label(pose: &PoseFound) -> String {
    let sd =
        |sd: Option<f64>, digits: usize| sd.map_or(String::new(), |sd| format!(" ± {sd:.digits$}"));
    let ((turn, turn_sd), (way, way_sd)) = (pose.turn(), pose.displacement());
    let way_sd_mm = way_sd.map(|sd| 1e3 * sd);
    format!("{turn:.2}{}°, {:.0}{} mm", sd(turn_sd, 2), 1e3 * way, sd(way_sd_mm, 0))
}

/// What a camera at a place of the drawing sees; short where it looks up or down.
fn wedge(at: Vector2<f64>, looks: &Vector3<f64>) -> [Vector2<f64>; 3] {
    let ray = |turn: f64| {
        let (sin, cos) = turn.sin_cos();
        // y of the drawing runs down
        let way = Vector2::new(cos * looks.x - sin * looks.y, -(sin * looks.x + cos * looks.y));
        at + SIGHT_PX * way
    };
    [at, ray(HALF_VIEW), ray(-HALF_VIEW)]
}

/// 1, 2 or 5 times a power of ten, at least 1.
fn round_down(times: f64) -> f64 {
    let power = 10.0_f64.powf(times.max(1.0).log10().floor());
    let steps = [5.0, 2.0, 1.0].map(|step| step * power);
    steps.into_iter().find(|step| *step <= times * (1.0 + 1e-9)).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::CameraFound;
    use crate::report::Language;

    fn camera(name: &str, pose: Option<PoseFound>) -> CameraQuality {
        CameraQuality {
            camera: name.into(),
            frames: 1,
            mean_iou: 1.0,
            median_px: None,
            rms_px: None,
            detections: None,
            found: CameraFound { pose, clock: None },
        }
    }

    fn place(x: f64, y: f64) -> PlacePart {
        let away = Vector2::new(x, y).norm();
        PlacePart { centre_m: [x, y, 1.5], looks: [-x / away, -y / away, 0.0] }
    }

    const POSE: PoseFound = PoseFound {
        turn_deg: [0.0, 0.0, 1.0],
        turn_sd_deg: Some([0.1; 3]),
        displacement_m: [0.02, 0.0, 0.0],
        displacement_sd_m: Some([0.004; 3]),
        zoom: 1.0,
        zoom_sd: Some(0.001),
        used: true,
    };

    #[test]
    fn enlargements_are_round_and_no_less_than_one() {
        for (times, round) in [(0.3, 1.0), (1.0, 1.0), (4.9, 2.0), (7.0, 5.0), (499.0, 200.0)] {
            approx::assert_relative_eq!(round_down(times), round);
        }
    }

    #[test]
    fn a_camera_that_was_touched_is_drawn_beside_its_calibration() {
        let cameras = [camera("left", Some(POSE)), camera("right", None)];
        let places = [place(-4.0, 0.0), place(4.0, 2.0)];
        let view = View::new(&places, &cameras, &[]);
        // 8 m across: a tenth is 40 times 2 cm, rounded down
        approx::assert_relative_eq!(view.larger, 20.0);
        approx::assert_relative_eq!(view.turned_more, 20.0);

        let calibrated = view.px(Vector2::new(-4.0, 0.0));
        let moved = view.px(Vector2::new(-3.6, 0.0));
        let text =
            view.drawing(&places, &cameras, &[], &Words::new(Language::English)).into_string();
        for at in [calibrated, moved] {
            let first = format!("points=\"{:.1},{:.1} ", at.x, at.y);
            assert!(text.contains(&first), "{first} {text}");
        }
        assert!(text.contains("1.00 ± 0.10°, 20 ± 4 mm") && text.contains("as calibrated"));
        assert!(!text.contains("NaN"));
        // y of the world is up in the drawing, and a turn about z to the left
        assert!(view.px(Vector2::new(0.0, 1.0)).y < view.px(Vector2::zeros()).y);
        let turned = UnitQuaternion::from_scaled_axis(Vector3::z() * 0.3) * Vector3::x();
        assert!(
            wedge(Vector2::zeros(), &turned)[1].y < wedge(Vector2::zeros(), &Vector3::x())[1].y
        );
    }
}
