//! Why a point cloud could not be used.

use std::io;
use std::path::PathBuf;

use ply_rs_bw::parser::ParseError;

/// Why a point cloud could not be used, in one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CloudError {
    /// A file that cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A name that says nothing.
    #[error("{}: expected a point cloud: .ply, .xyz, .txt or .csv", path.display())]
    Kind {
        /// The file.
        path: PathBuf,
    },
    /// No PLY header.
    #[error("{}:{line}: the header is no PLY header: {}", path.display(), one_line(source))]
    Header {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// What the parser expected.
        source: ParseError,
    },
    /// A PLY without points.
    #[error("{}: expected an element \"vertex\", found {}", path.display(), listed(found))]
    NoVertices {
        /// The file.
        path: PathBuf,
        /// The elements that it has.
        found: Vec<String>,
    },
    /// More than the file can hold.
    #[error(
        "{}: the header promises {promised} of {element:?}, but the file has room for {room} at most", path.display()
    )]
    Promise {
        /// The file.
        path: PathBuf,
        /// The element.
        element: String,
        /// How many the header promises.
        promised: usize,
        /// How many fit into the rest of the file.
        room: usize,
    },
    /// A column that is needed.
    #[error("{}: expected {expected}, found {}", path.display(), listed(found))]
    Columns {
        /// The file.
        path: PathBuf,
        /// What is needed.
        expected: &'static str,
        /// The columns or properties that it has.
        found: Vec<String>,
    },
    /// A PLY element that cannot be read.
    #[error("{}: byte {byte}: {element:?} number {index} of {count}: {}", path.display(), one_line(source))]
    Element {
        /// The file.
        path: PathBuf,
        /// Where the element begins, from 0.
        byte: usize,
        /// The element.
        element: String,
        /// Which one, from 1.
        index: usize,
        /// How many there should be.
        count: usize,
        /// What the parser expected.
        source: ParseError,
    },
    /// A line that cannot be read.
    #[error("{}:{line}: expected {expected}, found {found:?}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: u64,
        /// What should stand there.
        expected: &'static str,
        /// What stands there.
        found: String,
    },
    /// A CSV record that cannot be read.
    #[error("{}: {source}", path.display())]
    Csv {
        /// The file.
        path: PathBuf,
        /// Why, with the line.
        source: csv::Error,
    },
}

fn listed(names: &[String]) -> String {
    match names {
        [] => "nothing".into(),
        names => names.join(", "),
    }
}

/// The parser's message without line breaks.
fn one_line(source: &ParseError) -> String {
    let text = source.to_string();
    let parts: Vec<&str> = text.lines().map(str::trim).collect();
    parts.join(", ")
}

/// The beginning of a text, short enough for a message.
pub(super) fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}
