//! XML with lines and cameras in its errors.

use super::{CalibrationError, Place, error::one_line, unchecked::Numbers};
use crate::io::input::shortened;
use roxmltree::{Document, Node};
use std::path::Path;

/// Parses a document; entities and DTDs are refused.
pub(super) fn document<'a>(path: &Path, text: &'a str) -> Result<Document<'a>, CalibrationError> {
    Document::parse(text).map_err(|error| CalibrationError::Syntax {
        place: Place::new(path, Some(error.pos().row as usize), None),
        expected: "XML",
        found: one_line(&error.to_string()),
    })
}

/// One element of a camera, with what an error about it must name.
#[derive(Clone, Copy)]
pub(super) struct Element<'a, 'i> {
    pub(super) path: &'a Path,
    pub(super) camera: &'a str,
    pub(super) node: Node<'a, 'i>,
}

impl<'a, 'i> Element<'a, 'i> {
    /// The child element of this name.
    pub(super) fn child(&self, name: &str) -> Result<Self, CalibrationError> {
        let child = self.node.children().find(|node| node.has_tag_name(name));
        Ok(Self { node: child.ok_or_else(|| self.missing(&format!("<{name}>")))?, ..*self })
    }

    pub(super) fn line(&self) -> usize {
        line_of(self.node)
    }

    /// The attribute's text.
    pub(super) fn text(&self, key: &str) -> Result<&'a str, CalibrationError> {
        self.node.attribute(key).ok_or_else(|| self.missing(key))
    }

    /// The attribute's numbers, separated by white space.
    pub(super) fn numbers(&self, key: &str) -> Result<Numbers, CalibrationError> {
        let tokens = self.text(key)?.split_whitespace();
        self.parse(key, tokens)
    }

    /// The attribute as one finite number.
    pub(super) fn number(&self, key: &str) -> Result<f64, CalibrationError> {
        let [number] = self.numbers(key)?.exactly::<1>("1", self.camera)?;
        Ok(number)
    }

    /// Several attributes of one finite number each, as one.
    pub(super) fn collect(&self, key: &str, keys: &[&str]) -> Result<Numbers, CalibrationError> {
        let values: Result<_, _> = keys.iter().map(|key| self.number(key)).collect();
        Ok(self.computed(key, values?))
    }

    /// Numbers computed from attributes of this element.
    pub(super) fn computed(&self, key: &str, values: Vec<f64>) -> Numbers {
        Numbers::new(self.path, self.line(), key, values)
    }

    /// Numbers from tokens found in the attribute `key`.
    pub(super) fn parse<'t>(
        &self,
        key: &str,
        tokens: impl Iterator<Item = &'t str>,
    ) -> Result<Numbers, CalibrationError> {
        let parse = |token: &str| {
            token.parse().map_err(|_| CalibrationError::NotANumber {
                place: self.place(),
                key: key.into(),
                found: shortened(token),
            })
        };
        let values: Result<_, _> = tokens.map(parse).collect();
        Ok(self.computed(key, values?))
    }

    pub(super) fn place(&self) -> Place {
        Place::new(self.path, Some(self.line()), Some(self.camera))
    }

    pub(super) fn missing(&self, key: &str) -> CalibrationError {
        CalibrationError::MissingKey { place: self.place(), key: key.into() }
    }
}

/// Line at which an element starts, from 1.
pub(super) fn line_of(node: Node<'_, '_>) -> usize {
    node.document().text_pos_at(node.range().start).row as usize
}
