//! OpenCV's `FileStorage`: named values, in YAML or XML.
//!
//! Only what `cv::FileStorage` writes for calibrations is understood: matrices, lists of plain values and single
//! values. Anything else is passed over.

use super::{
    CalibrationError, Place,
    unchecked::Numbers,
    xml::{document, line_of},
};
use crate::io::input::shortened;
use std::path::{Path, PathBuf};

/// The values of one file, in its order.
#[derive(Debug)]
pub(super) struct Storage {
    pub(super) path: PathBuf,
    pub(super) entries: Vec<Entry>,
}

/// One named value.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) key: String,
    line: usize,
    /// rows · cols, where stated.
    expected: Option<usize>,
    /// The values as text, row by row.
    tokens: Vec<String>,
}

impl Storage {
    /// The value of the first of these keys that is there.
    pub(super) fn find(&self, keys: &[String]) -> Option<&Entry> {
        let named = |key: &String| self.entries.iter().find(|entry| entry.key == *key);
        keys.iter().find_map(named)
    }

    /// An entry's numbers, as many as its rows and columns say.
    pub(super) fn numbers(&self, entry: &Entry, camera: &str) -> Result<Numbers, CalibrationError> {
        let place = Place::new(&self.path, Some(entry.line), Some(camera));
        let parse = |token: &String| {
            number(token).ok_or_else(|| CalibrationError::NotANumber {
                place: place.clone(),
                key: entry.key.clone(),
                found: shortened(token),
            })
        };

        let values: Result<Vec<f64>, _> = entry.tokens.iter().map(parse).collect();
        let values = values?;
        if entry.expected.is_some_and(|n| n != values.len()) {
            return Err(CalibrationError::Count {
                place,
                key: entry.key.clone(),
                expected: "rows × cols",
                found: values.len(),
            });
        }

        Ok(Numbers::new(&self.path, entry.line, &entry.key, values))
    }
}

impl Entry {
    /// The values as plain text.
    pub(super) fn texts(&self) -> impl Iterator<Item = &str> {
        self.tokens.iter().map(String::as_str)
    }
}

/// A number as OpenCV writes it: `1.`, `.5`, `.Nan`, `-.Inf`.
fn number(token: &str) -> Option<f64> {
    match token.to_ascii_lowercase().as_str() {
        ".nan" => Some(f64::NAN),
        ".inf" | "+.inf" => Some(f64::INFINITY),
        "-.inf" => Some(f64::NEG_INFINITY),
        plain => plain.parse().ok(),
    }
}

/// Reads `<opencv_storage>`.
pub(super) fn parse_xml(path: &Path, text: &str) -> Result<Storage, CalibrationError> {
    let document = document(path, text)?;
    let elements = document.root_element().children().filter(|n| n.is_element());
    let entries = elements.map(|node| {
        let text_of = |name: &str| {
            let child = node.children().find(|child| child.has_tag_name(name));
            child.and_then(|child| child.text())
        };
        let size = |name: &str| text_of(name).and_then(|text| text.trim().parse::<usize>().ok());
        // a list of texts has one element <_> each
        let own: String = node
            .descendants()
            .filter(|n| n.is_text())
            .filter_map(|n| n.text())
            .collect::<Vec<_>>()
            .join(" ");
        let data = text_of("data").map_or(own, str::to_owned);
        Entry {
            key: node.tag_name().name().into(),
            line: line_of(node),
            expected: size("rows").zip(size("cols")).and_then(|(r, c)| r.checked_mul(c)),
            tokens: tokens(&data),
        }
    });
    Ok(Storage { path: path.into(), entries: entries.collect() })
}

/// Reads the YAML that OpenCV and EasyMocap write.
pub(super) fn parse_yaml(path: &Path, text: &str) -> Result<Storage, CalibrationError> {
    let mut blocks: Vec<Block> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim_end();
        let is_marker = line.starts_with('%') || line == "---" || line == "...";
        if is_marker || line.trim_start().starts_with('#') || line.is_empty() {
            continue;
        }

        // an indented line or list item continues the entry above, as does every line within brackets
        let open = blocks.last().is_some_and(Block::is_open);
        if open || line.starts_with([' ', '\t', '-']) {
            let block = blocks.last_mut().ok_or_else(|| not_a_key(path, index, line))?;
            block.push(line);
        } else {
            let (key, rest) = line.split_once(':').ok_or_else(|| not_a_key(path, index, line))?;
            blocks.push(Block::new(unquoted(key.trim()), index + 1, rest));
        }
    }

    if let Some(block) = blocks.iter().find(|block| block.is_open()) {
        return Err(CalibrationError::Syntax {
            place: Place::new(path, Some(block.line), None),
            expected: "]",
            found: "the end of the file".into(),
        });
    }

    Ok(Storage { path: path.into(), entries: blocks.iter().map(Block::entry).collect() })
}

fn not_a_key(path: &Path, index: usize, line: &str) -> CalibrationError {
    CalibrationError::Syntax {
        place: Place::new(path, Some(index + 1), None),
        expected: "key: value",
        found: format!("{:?}", shortened(line)),
    }
}

/// A key and the text up to the next one.
struct Block {
    key: String,
    line: usize,
    lines: Vec<String>,
    /// Brackets so far.
    opened: usize,
    closed: usize,
}

impl Block {
    fn new(key: &str, line: usize, rest: &str) -> Self {
        let mut block = Self { key: key.into(), line, lines: Vec::new(), opened: 0, closed: 0 };
        block.push(rest);
        block
    }

    fn push(&mut self, line: &str) {
        self.opened += line.matches('[').count();
        self.closed += line.matches(']').count();
        self.lines.push(line.trim_start().into());
    }

    /// Whether a bracket is still open.
    fn is_open(&self) -> bool {
        self.opened > self.closed
    }

    fn entry(&self) -> Entry {
        let after = |name: &str| {
            let at = self.lines.iter().position(|line| line.starts_with(name))?;
            Some(self.lines[at..].join("\n")[name.len()..].to_owned())
        };
        let size = |name: &str| after(name)?.lines().next()?.trim().parse::<usize>().ok();
        let data = after("data:").unwrap_or_else(|| self.lines.join("\n"));
        Entry {
            key: self.key.clone(),
            line: self.line,
            expected: size("rows:").zip(size("cols:")).and_then(|(r, c)| r.checked_mul(c)),
            tokens: tokens(first_value(&data)),
        }
    }
}

/// The text of the first value: a list in brackets, a list of dashes, or the rest of the line.
fn first_value(text: &str) -> &str {
    let first_line = text.lines().next().unwrap_or("").trim();

    // block style: a list whose items begin lines
    if first_line.is_empty() && text.trim_start().starts_with('-') {
        let lines = text.split_inclusive('\n');
        let end: usize = lines
            .take_while(|line| line.trim().is_empty() || line.starts_with('-'))
            .map(str::len)
            .sum();
        return &text[..end];
    }

    if !text.trim_start().starts_with('[') {
        return first_line;
    }

    // flow style: up to the bracket that closes the list
    let mut depth = 0_usize;
    for (index, c) in text.char_indices() {
        match c {
            '[' => depth += 1,
            ']' if depth <= 1 => return &text[..index],
            ']' => depth -= 1,
            _ => {}
        }
    }
    text
}

/// Plain values between white space, commas, brackets and list dashes.
fn tokens(text: &str) -> Vec<String> {
    text.split(|c: char| c.is_whitespace() || matches!(c, ',' | '[' | ']'))
        .filter(|token| !token.is_empty() && *token != "-")
        .map(|token| unquoted(token).to_owned())
        .collect()
}

fn unquoted(token: &str) -> &str {
    let pairs = ['"', '\''];
    pairs.iter().find_map(|&q| token.strip_prefix(q)?.strip_suffix(q)).unwrap_or(token)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn yaml(text: &str) -> Storage {
        parse_yaml(Path::new("a.yml"), text).unwrap()
    }

    fn values(storage: &Storage, key: &str) -> Vec<f64> {
        let entry = storage.find(&[key.into()]).unwrap();
        storage.numbers(entry, "cam").unwrap().values
    }

    #[test]
    fn yaml_of_opencv_and_easymocap_is_read() {
        let text = "%YAML:1.0\r\n---\r\nnames:\r\n   - \"1\"\r\n   - \"2\"\r\nK: !!opencv-matrix\r\n   rows: 2\r\n   cols: 2\r\n   dt: d\r\n   data: [ 1., 2.5e+00, -3.,\r\n       .Nan ]\r\nH_1: 1080\r\n# a remark\r\nflat: [1, 2]\r\nrows: [ [1, 2], [3, 4] ]\r\nD:\r\n  cols: 1\r\n  data:\r\n  - 7.0\r\n  - 8.0\r\n  rows: 2\r\n";
        let storage = yaml(text);
        let names: Vec<&str> = storage.find(&["names".into()]).unwrap().texts().collect();
        assert_eq!(names, ["1", "2"]);
        let k = values(&storage, "K");
        assert_eq!(k[..3], [1.0, 2.5, -3.0]);
        assert!(k[3].is_nan());
        assert_eq!(values(&storage, "H_1"), [1080.0]);
        assert_eq!(values(&storage, "flat"), [1.0, 2.0]);
        assert_eq!(values(&storage, "rows"), [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(values(&storage, "D"), [7.0, 8.0]);
    }

    #[test]
    fn names_may_start_in_the_first_column() {
        let storage = yaml("names:\n- \"a\"\n- \"b\"\n");
        assert_eq!(storage.entries[0].texts().collect::<Vec<_>>(), ["a", "b"]);
    }

    #[test]
    fn an_open_bracket_is_found_where_it_was_opened() {
        let error = parse_yaml(Path::new("a.yml"), "x: 1\nK: [1, 2\ny: 3\n").unwrap_err();
        assert_eq!(error.to_string(), "a.yml:2: expected ], found the end of the file");
    }

    #[test]
    fn rows_and_columns_must_agree_with_the_data() {
        let storage = yaml("K: !!opencv-matrix\n  rows: 3\n  cols: 3\n  data: [1, 2]\n");
        let error = storage.numbers(&storage.entries[0], "cam").unwrap_err();
        let expected = "a.yml:1: camera cam: K: expected rows × cols numbers, found 2";
        assert_eq!(error.to_string(), expected);
    }

    #[test]
    fn xml_gives_the_same_entries() {
        let text = "<?xml version=\"1.0\"?>\n<opencv_storage>\n<K type_id=\"opencv-matrix\"><rows>1</rows><cols>2</cols><dt>d</dt>\n<data>\n 1. 2.</data></K>\n<names>\n  \"1\" \"2\"</names>\n<list><_>a</_><_>b</_></list></opencv_storage>";
        let storage = parse_xml(Path::new("a.xml"), text).unwrap();
        assert_eq!(values(&storage, "K"), [1.0, 2.0]);
        let texts = |i: usize| storage.entries[i].texts().collect::<Vec<_>>();
        assert_eq!(texts(1), ["1", "2"]);
        assert_eq!(texts(2), ["a", "b"]);
    }
}
