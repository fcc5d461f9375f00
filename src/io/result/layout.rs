//! JSON that a person can read: one line for each frame, hypothesis, camera.

use std::io::{self, Write};

use serde_json::ser::{CompactFormatter, Formatter};

/// Levels that are spread over several lines; deeper ones share a line.
const SPREAD_LEVELS: usize = 3;

/// Spreads the outer levels over lines and keeps the inner ones on one.
#[derive(Debug, Default)]
pub(super) struct Layout {
    level: usize,
    is_filled: bool,
}

impl Layout {
    fn open<W: Write + ?Sized>(&mut self, writer: &mut W, bracket: &[u8]) -> io::Result<()> {
        self.level += 1;
        self.is_filled = false;
        writer.write_all(bracket)
    }

    fn close<W: Write + ?Sized>(&mut self, writer: &mut W, bracket: &[u8]) -> io::Result<()> {
        let is_spread = self.is_filled && self.level <= SPREAD_LEVELS;
        self.level -= 1;
        if is_spread {
            self.new_line(writer)?;
        }
        self.is_filled = true;
        writer.write_all(bracket)
    }

    /// Begins an item; `comma` is what separates it from the one before, empty if it is the first.
    fn item<W: Write + ?Sized>(&mut self, writer: &mut W, comma: &[u8]) -> io::Result<()> {
        writer.write_all(comma)?;
        match (self.level <= SPREAD_LEVELS, comma.is_empty()) {
            (true, _) => self.new_line(writer),
            (false, true) => Ok(()),
            (false, false) => writer.write_all(b" "),
        }
    }

    fn new_line<W: Write + ?Sized>(&self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b"\n")?;
        (0..self.level).try_for_each(|_| writer.write_all(b"  "))
    }
}

/// What separates an item from the one before, by whether it is the first.
const SEPARATOR: [&[u8]; 2] = [b",", b""];

impl Formatter for Layout {
    fn begin_array<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.open(writer, b"[")
    }

    fn end_array<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.close(writer, b"]")
    }

    fn begin_array_value<W: Write + ?Sized>(&mut self, w: &mut W, first: bool) -> io::Result<()> {
        self.item(w, SEPARATOR[usize::from(first)])
    }

    fn end_array_value<W: Write + ?Sized>(&mut self, _: &mut W) -> io::Result<()> {
        self.is_filled = true;
        Ok(())
    }

    fn begin_object<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.open(writer, b"{")
    }

    fn end_object<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.close(writer, b"}")
    }

    fn begin_object_key<W: Write + ?Sized>(&mut self, w: &mut W, first: bool) -> io::Result<()> {
        self.item(w, SEPARATOR[usize::from(first)])
    }

    fn begin_object_value<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        CompactFormatter.begin_object_value(writer)?;
        writer.write_all(b" ")
    }

    fn end_object_value<W: Write + ?Sized>(&mut self, _: &mut W) -> io::Result<()> {
        self.is_filled = true;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use serde::Serialize;
    use serde_json::{Serializer, json};

    use super::*;

    #[test]
    fn outer_levels_are_spread_and_inner_ones_stand_on_one_line() {
        let value = json!({"a": {"b": [{"c": [1, 2], "d": []}, {}]}, "e": []});
        let mut bytes = Vec::new();
        let mut serializer = Serializer::with_formatter(&mut bytes, Layout::default());
        value.serialize(&mut serializer).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let expected = "{\n  \"a\": {\n    \"b\": [\n      {\"c\": [1, 2], \"d\": []},\n      {}\n    ]\n  },\n  \"e\": []\n}";
        assert_eq!(text, expected);
    }
}
