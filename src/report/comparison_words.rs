//! What the page of a comparison says of two sessions, and of two sides.

use std::fmt::Display;

use super::Words;
use crate::gait::trials::Sides;

pub(super) fn changes(sides: Sides, words: &Words) -> &str {
    match sides {
        Sides::Same => words.of("Changes"),
        Sides::Opposite => words.of("Right side less left side"),
    }
}

pub(super) fn change(sides: Sides, words: &Words) -> &str {
    match sides {
        Sides::Same => words.of("Change"),
        Sides::Opposite => words.of("Difference"),
    }
}

pub(super) fn beyond(sides: Sides, words: &Words) -> &str {
    match sides {
        Sides::Same => words.of("Changes that exceed the minimal detectable change"),
        Sides::Opposite => words.of("Differences between the sides that exceed chance"),
    }
}

/// How many numbers differ, of so many, and how many would by chance.
pub(super) fn by_chance(sides: Sides, (n, all): (usize, usize), words: &Words) -> String {
    let numbers: [(&str, &dyn Display); 2] = [("n", &n), ("all", &all)];
    match sides {
        Sides::Same => words.fill(
            "{n} of {all} numbers. Of a person who has not changed, one in twenty exceeds it.",
            &numbers,
        ),
        Sides::Opposite => words.fill(
            "{n} of {all} numbers. Of a person who walks evenly, one in twenty exceeds chance.",
            &numbers,
        ),
    }
}

pub(super) fn made_of_sides(words: &Words) -> &str {
    words.of(
        "SD: between the trials. Difference: right less left, with its 95 % interval, from the differences within each trial and the \
         fit's own SD of each side.",
    )
}

pub(super) fn detectable(sides: Sides, words: &Words) -> &str {
    match sides {
        Sides::Same => words.of(
            "MDC: minimal detectable change, 1.96·√2·SEM of two sessions alike (Weir 2005), which a person who has not changed \
             exceeds once in twenty times; ● marks a change beyond it. Scores are against the norm.",
        ),
        Sides::Opposite => words.of(
            "MDC: 1.96·SEM of the differences, which a person who walks evenly exceeds once in twenty times; ● marks a difference \
             beyond it. Scores are against the norm.",
        ),
    }
}

/// A figure in words.
pub(super) fn description(sides: Sides, values: &[(&str, &dyn Display)], words: &Words) -> String {
    match sides {
        Sides::Same => {
            words.fill("{angle}, {side}, degrees: mean curves of {before} and {after}.", values)
        }
        Sides::Opposite => words
            .fill("{angle}, degrees: mean curves of the {before} and the {after} side.", values),
    }
}
