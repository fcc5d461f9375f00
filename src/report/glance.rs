//! A walk at a glance: legs and trunk from the side, at some instants.

use maud::{Markup, html};
use nalgebra::{Vector2, Vector3};

use super::ReportInput;
use super::drawing::points;
use crate::gait::{Landmark, Paired, Side};

/// Instants that are drawn, evenly in time.
const INSTANTS: usize = 6;
/// Height of the picture.
const HEIGHT_PX: usize = 56;
/// Width of a line, and so the margin around all of them, cm.
const LINE_CM: f64 = 4.0;
/// A leg, from above.
const LEG: [Paired; 4] = [Paired::Hip, Paired::Knee, Paired::Ankle, Paired::Toe];

/// A line of the picture, cm from the side, up negative.
struct Line {
    colour: &'static str,
    points: Vec<Vector2<f64>>,
}

/// The picture of a trial; `None` where no leg is known.
pub(super) fn glance(input: &ReportInput<'_>) -> Option<Markup> {
    let lines: Vec<Line> = (0..INSTANTS).flat_map(|i| instant(input, i)).collect();
    let ends = |axis: usize| {
        let values = lines.iter().flat_map(|line| &line.points).map(|point| point[axis]);
        let (least, greatest) = values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), value| (a.min(value), b.max(value)));
        (greatest >= least).then_some((least - LINE_CM, greatest - least + 2.0 * LINE_CM))
    };
    let ((left, width), (top, height)) = (ends(0)?, ends(1)?);

    Some(html! {
        svg viewBox=(format!("{left:.0} {top:.0} {width:.0} {height:.0}")) height=(HEIGHT_PX) role="img"
            aria-label=(input.words.of("The walk from the side")) {
            g fill="none" stroke-width=(LINE_CM) stroke-linejoin="round" stroke-linecap="round" {
                @for line in &lines { polyline style={ "stroke:" (line.colour) } points=(points(line.points.iter().copied())) {} }
            }
        }
    })
}

/// The trunk, and the legs before it, the nearer right one last.
fn instant(input: &ReportInput<'_>, instant: usize) -> Vec<Line> {
    let (movement, course) = (input.movement, &input.gait.course);
    let frame = (2 * instant + 1) * movement.frames / (2 * INSTANTS);
    let Some(forwards) = course.heading.get(movement.frames / 2) else { return Vec::new() };
    // on a belt the person goes as far as the belt comes
    let carried_m = course.belt_m_s * frame as f64 / movement.rate_hz;
    let from_the_side =
        |place: &Vector3<f64>| 100.0 * Vector2::new(place.dot(forwards) + carried_m, -place.z);
    let places = |places: &[Landmark]| -> Vec<Vector2<f64>> {
        let tracks = places.iter().filter_map(|place| movement.track(*place)?.get(frame));
        tracks.filter(|place| place.x.is_finite()).map(from_the_side).collect()
    };

    let trunk = places(&[Landmark::MidHip, Landmark::Neck]);
    let leg = |side: Side| places(&LEG.map(|place| Landmark::Of(side, place)));
    [("var(--soft)", trunk), ("var(--left)", leg(Side::Left)), ("var(--right)", leg(Side::Right))]
        .into_iter()
        .filter(|(_, points)| points.len() > 1)
        .map(|(colour, points)| Line { colour, points })
        .collect()
}
