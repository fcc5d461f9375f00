//! Passes through the room: what a person does between entering and leaving. No stride reaches from one to the next.

use std::borrow::Cow;
use std::ops::Range;

use nalgebra::Vector3;

use super::GaitError;
use super::landmark::Landmark;
use super::movement::Movement;
use super::segments::unknown;

/// A person who is not seen for longer than this may have turned meanwhile, seconds.
const APART_S: f64 = 0.2;

/// One pass of a movement.
pub(super) struct OnePass<'a> {
    /// The movement, with nothing known outside of the pass.
    pub(super) movement: Cow<'a, Movement>,
    /// The frames of the pass, from the first one of the movement.
    pub(super) frames: Range<usize>,
    /// What to say if there are others.
    pub(super) note: Option<String>,
}

/// The movement in one pass, the longest if none is asked for.
pub(super) fn one_pass(movement: &Movement, pass: Option<usize>) -> Result<OnePass<'_>, GaitError> {
    let passes = passes(movement);
    let longest = || (0..passes.len()).max_by_key(|i| (passes[*i].len(), std::cmp::Reverse(*i)));
    let chosen = match pass {
        Some(pass) if !(1..=passes.len()).contains(&pass) => {
            return Err(GaitError::NoPass { pass, passes: passes.len() });
        }
        Some(pass) => Some(pass - 1),
        None => longest(),
    };
    let Some(chosen) = chosen.filter(|_| passes.len() > 1) else {
        let frames = 0..movement.frames;
        return Ok(OnePass { movement: Cow::Borrowed(movement), frames, note: None });
    };

    let number = |frame: usize| movement.first_frame + frame;
    let shown = |(i, pass): (usize, &Range<usize>)| {
        format!("{}: frames {}–{}", i + 1, number(pass.start), number(pass.end - 1))
    };
    let shown: Vec<String> = passes.iter().enumerate().map(shown).collect();
    let note = format!(
        "the person leaves and comes back ({}): all numbers are of pass {}; --pass chooses another",
        shown.join(", "),
        chosen + 1
    );
    let frames = passes[chosen].clone();
    Ok(OnePass { movement: Cow::Owned(within(movement, &frames)), frames, note: Some(note) })
}

/// The frames in which the hips are known, without a long gap.
fn passes(movement: &Movement) -> Vec<Range<usize>> {
    let Some(hips) = movement.track(Landmark::MidHip) else {
        return Vec::new();
    };
    let longest_gap = (APART_S * movement.rate_hz) as usize;
    let mut passes: Vec<Range<usize>> = Vec::new();
    for i in (0..hips.len()).filter(|i| hips[*i].x.is_finite()) {
        match passes.last_mut() {
            Some(pass) if i - pass.end <= longest_gap => pass.end = i + 1,
            _ => passes.push(i..i + 1),
        }
    }
    passes
}

/// The movement with nothing known outside of some frames.
fn within(movement: &Movement, frames: &Range<usize>) -> Movement {
    let mut within = movement.clone();
    let outside = |i: &usize| !frames.contains(i);
    for track in within.tracks.values_mut() {
        (0..track.len()).filter(outside).for_each(|i| track[i] = Vector3::repeat(f64::NAN));
    }
    for axes in within.segments.iter_mut().flat_map(|s| s.axes.values_mut()) {
        (0..axes.len()).filter(outside).for_each(|i| axes[i] = unknown());
    }
    within
}
