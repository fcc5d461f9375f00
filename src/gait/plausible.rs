//! Steps that nobody takes: a wrong frame rate, and a person who was lost.

use super::cycles::Cycle;
use super::landmark::{Landmark, Side};
use super::movement::Movement;
use super::parameters::{Parameter, Parameters};
use crate::math::stats::mean;

/// Step length over cadence, m·min: healthy adults walk at 0.00638 ± 0.00066 from 0.55 to 1.67 m/s, patients with multiple sclerosis
/// at 0.00536 ± 0.00086 (Rota et al., Int J Rehabil Res 2011); who is asked to walk slower takes longer steps for it (Murakami &
/// Otaka, J Phys Ther Sci 2017). Half the frame rate doubles it.
const MOST_WALK_RATIO: f64 = 0.0105;
/// Steps a minute; 409 people in the street took 95 to 160 (Sato & Ishizu, J Hum Ergol 1990). Twice the frame rate doubles them.
const MOST_CADENCE: f64 = 170.0;

/// Speed of the hips through the room that nobody reaches who is followed, m/s: a sprinter's 12 need a longer room than cameras
/// see. Who is lost and found again elsewhere seems to move faster.
const MOST_HIPS_M_S: f64 = 8.0;

/// The strides that somebody can have taken, and why the others are refused.
pub(super) fn strides(movement: &Movement, strides: Vec<Cycle>) -> (Vec<Cycle>, Vec<String>) {
    let mut refused = Vec::new();
    let is_possible = |stride: &Cycle| {
        let fastest = fastest_hips(movement, stride);
        if fastest > MOST_HIPS_M_S {
            let number = |part: f64| movement.first_frame + stride.frame_at(part).round() as usize;
            refused.push(format!(
                "the {} stride from frame {} on is refused: the hips move at {fastest:.0} m/s in it, so the person was lost there",
                stride.side.name(),
                number(0.0),
            ));
        }
        fastest <= MOST_HIPS_M_S
    };
    (strides.into_iter().filter(is_possible).collect(), refused)
}

/// Greatest speed of the middle of the hips in a stride, from one frame in which it is known to the next.
fn fastest_hips(movement: &Movement, stride: &Cycle) -> f64 {
    let Some(hips) = movement.track(Landmark::MidHip) else {
        return 0.0;
    };
    let ends = [stride.frame_at(0.0), stride.frame_at(1.0), stride.off];
    let first = ends.iter().copied().fold(f64::INFINITY, f64::min).floor() as usize;
    let last = ends.iter().copied().fold(0.0, f64::max).ceil() as usize;
    let known: Vec<usize> =
        (first..=last.min(hips.len() - 1)).filter(|i| hips[*i].x.is_finite()).collect();
    let speed = |ends: &[usize]| {
        let seconds = (ends[1] - ends[0]) as f64 / movement.rate_hz;
        (hips[ends[1]] - hips[ends[0]]).norm() / seconds
    };
    known.windows(2).map(speed).fold(0.0, f64::max)
}

/// What to say where steps are such that the frame rate must be wrong.
pub(super) fn frame_rate_note(parameters: &Parameters) -> Option<String> {
    let both = |parameter: Parameter| {
        mean(Side::BOTH.iter().filter_map(|side| Some(parameters.get(&(parameter, *side))?.mean)))
    };
    let (cadence, step_m) = (both(Parameter::Cadence)?, both(Parameter::StepLength)?);
    let direction = match () {
        () if cadence > MOST_CADENCE => "high",
        () if step_m / cadence > MOST_WALK_RATIO => "low",
        () => return None,
    };
    Some(format!(
        "steps of {step_m:.2} m at {cadence:.0} a minute: hardly anybody walks so; is the frame rate right? It seems too {direction} (--fps)"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gait::Statistic;

    fn note(cadence: f64, step_m: f64) -> Option<String> {
        let of = |mean| Statistic { n: 1, mean, sd: None, uncertainty: None, values: vec![mean] };
        let parameters = [(Parameter::Cadence, cadence), (Parameter::StepLength, step_m)];
        let each = parameters.map(|(parameter, mean)| ((parameter, Side::Left), of(mean)));
        frame_rate_note(&Parameters::from(each))
    }

    #[test]
    fn the_same_walk_at_half_and_at_twice_the_frame_rate_is_told() {
        assert_eq!(note(104.0, 0.65), None);
        assert!(note(52.0, 0.65).unwrap().contains("too low"));
        assert!(note(208.0, 0.65).unwrap().contains("too high"));
    }

    #[test]
    fn slow_short_steps_of_a_patient_are_no_wrong_frame_rate() {
        assert_eq!(note(60.0, 0.30), None);
        assert_eq!(note(80.0, 0.60), None);
    }
}
