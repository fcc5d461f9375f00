//! The order in which people count: `cam2` before `cam10`.

use std::cmp::Ordering;

/// Compares names piece by piece, runs of digits as numbers; equal numbers of different length by their text.
pub(in crate::io) fn natural(a: &str, b: &str) -> Ordering {
    let (mut left, mut right) = (a, b);
    while !left.is_empty() && !right.is_empty() {
        let (x, rest_left) = piece(left);
        let (y, rest_right) = piece(right);
        let order = compare_pieces(x, y);
        if order.is_ne() {
            return order;
        }
        (left, right) = (rest_left, rest_right);
    }
    left.len().cmp(&right.len()).then_with(|| a.cmp(b))
}

/// Numbers by value, of any length; everything else as text.
fn compare_pieces(x: &str, y: &str) -> Ordering {
    let is_number = |s: &str| s.starts_with(|c: char| c.is_ascii_digit());
    if is_number(x) && is_number(y) {
        let (x, y) = (x.trim_start_matches('0'), y.trim_start_matches('0'));
        x.len().cmp(&y.len()).then_with(|| x.cmp(y))
    } else {
        x.cmp(y)
    }
}

/// The leading run of digits, or of non-digits, and the rest.
fn piece(text: &str) -> (&str, &str) {
    let digits = text.starts_with(|c: char| c.is_ascii_digit());
    let end = text.find(|c: char| c.is_ascii_digit() != digits).unwrap_or(text.len());
    text.split_at(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_count() {
        let mut names = ["cam10", "cam2", "cam_1", "cam02", "10", "9", "cam", "cam2b"];
        names.sort_by(|a, b| natural(a, b));
        let expected = ["9", "10", "cam", "cam02", "cam2", "cam2b", "cam10", "cam_1"];
        assert_eq!(names, expected);
    }

    #[test]
    fn numbers_longer_than_any_integer_are_compared() {
        let long = "1".repeat(40);
        assert_eq!(natural(&long, "2"), Ordering::Greater);
        assert_eq!(natural(&long, &long), Ordering::Equal);
    }
}
