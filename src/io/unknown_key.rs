//! Keys that a TOML file must not have, and what was probably meant.

use toml::de::DeTable;

/// A key that means nothing there.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct UnknownKey {
    /// Where it stands, from 1.
    pub(super) line: usize,
    /// The key.
    pub(super) key: String,
    /// The known key that looks most like it.
    pub(super) nearest: &'static str,
    /// All keys known there.
    pub(super) known: &'static [&'static str],
}

impl UnknownKey {
    /// The first key of `table`, a part of `text`, that is not among `known`; `None` if all are.
    pub(super) fn first_in(
        text: &str,
        table: &DeTable<'_>,
        known: &'static [&'static str],
    ) -> Option<Self> {
        let unknown = table.keys().filter(|key| !known.contains(&key.get_ref().as_ref()));
        let first = unknown.min_by_key(|key| key.span().start)?;
        let key = first.get_ref().to_string();
        Some(Self {
            line: line_of(text, first.span().start),
            nearest: nearest(&key, known).unwrap_or_default(),
            key,
            known,
        })
    }
}

/// The name that looks most like `name`; `None` if there is none to choose from.
pub(super) fn nearest<'a, T: AsRef<str> + ?Sized>(name: &str, known: &'a [&'a T]) -> Option<&'a T> {
    let likeness = |other: &&&T| strsim::jaro_winkler(&name.to_lowercase(), other.as_ref());
    known.iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b))).copied()
}

/// Line of a position in a text, from 1.
pub(super) fn line_of(text: &str, position: usize) -> usize {
    let before = text.as_bytes().iter().take(position);
    1 + before.filter(|byte| **byte == b'\n').count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_unknown_key_is_named_with_its_line_and_the_nearest_known_one() {
        let text = "fps = 3\n\nzebra = 1\nmsks = 2\n";
        let table = DeTable::parse(text).unwrap();
        let known: &[&str] = &["fps", "masks"];
        let unknown = UnknownKey::first_in(text, table.get_ref(), known).unwrap();
        assert_eq!((unknown.line, unknown.key.as_str()), (3, "zebra"));
        let text = "fps = 3\nmsks = 2\n";
        let table = DeTable::parse(text).unwrap();
        let unknown = UnknownKey::first_in(text, table.get_ref(), known).unwrap();
        assert_eq!((unknown.line, unknown.nearest, unknown.known), (2, "masks", known));
    }

    #[test]
    fn a_known_key_is_no_fault() {
        let table = DeTable::parse("fps = 3").unwrap();
        assert_eq!(UnknownKey::first_in("", table.get_ref(), &["fps"]), None);
    }
}
