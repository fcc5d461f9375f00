//! One run of an experiment.

#![allow(clippy::print_stdout, reason = "tables and numbers are what an experiment is run for")]

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use maquette::image::Picture;
use maquette::io::folder::jpeg;
use serde::Serialize;

use crate::expected::{ExpectedNumbers, out};
use crate::table::Table;

/// The seed for which the expected numbers hold.
pub const SEED: u64 = 1;

#[derive(Debug, Parser)]
struct Arguments {
    /// Write the pictures into docs/experiments too
    #[arg(long)]
    docs: bool,
    /// A shorter recording, with expected numbers of its own; only some experiments have one
    #[arg(long)]
    quick: bool,
    /// Only the rows whose name holds this text, with no numbers; only some experiments have rows
    #[arg(long)]
    only: Option<String>,
    /// Seed of everything that is drawn; expected numbers are checked for the default only
    #[arg(long, default_value_t = SEED)]
    seed: u64,
}

/// Where the data lie that are shared by projects; it need not be there.
pub fn shared_data() -> PathBuf {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    std::env::var_os("MAQUETTE_SHARED").map_or(beside, PathBuf::from).join("data")
}

/// Why an experiment could not be finished.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// A file of results cannot be written.
    #[error("cannot write {path}: {source}")]
    Write {
        /// File.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The expected numbers cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// File.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The expected numbers are not TOML or hold unknown keys.
    #[error("{path}: {source}")]
    Expected {
        /// File.
        path: PathBuf,
        /// Why.
        source: toml::de::Error,
    },
}

/// A run: its arguments, the numbers it measured, and where its files go.
#[derive(Debug)]
pub struct Run {
    name: &'static str,
    arguments: Arguments,
    started: Instant,
    settings: BTreeMap<String, serde_json::Value>,
    numbers: BTreeMap<String, f64>,
}

/// `record.json`.
#[derive(Debug, Serialize)]
struct Record<'a> {
    experiment: &'a str,
    version: &'a str,
    seed: u64,
    settings: &'a BTreeMap<String, serde_json::Value>,
    numbers: &'a BTreeMap<String, f64>,
    minutes: f64,
}

impl Run {
    /// Begins a run with the arguments of the command line.
    pub fn start(name: &'static str) -> Self {
        Self {
            name,
            arguments: Arguments::parse(),
            started: Instant::now(),
            settings: BTreeMap::new(),
            numbers: BTreeMap::new(),
        }
    }

    /// Seed of everything that is drawn.
    pub fn seed(&self) -> u64 {
        self.arguments.seed
    }

    /// A shorter recording was asked for.
    pub fn is_quick(&self) -> bool {
        self.arguments.quick
    }

    /// Whether a row of this name was asked for.
    pub fn wants(&self, row: &str) -> bool {
        self.arguments.only.as_deref().is_none_or(|only| row.contains(only))
    }

    /// Whether only some rows were asked for: what they give is printed, and nothing is kept or checked.
    pub fn is_partial(&self) -> bool {
        self.arguments.only.is_some()
    }

    /// The name of its files.
    fn file_name(&self) -> String {
        let quick = if self.is_quick() { "_quick" } else { "" };
        format!("{}{quick}", self.name)
    }

    /// Keeps a setting for the record.
    pub fn setting(&mut self, name: &str, value: impl Serialize) {
        let value = serde_json::to_value(value).unwrap_or(serde_json::Value::Null);
        self.settings.insert(name.to_owned(), value);
    }

    /// Keeps a measured number for the record and the check.
    pub fn number(&mut self, name: impl Into<String>, value: f64) {
        self.numbers.insert(name.into(), value);
    }

    /// Prints a table and writes it as CSV.
    ///
    /// # Errors
    /// [`RunError::Write`].
    pub fn table(&self, title: &str, table: &Table) -> Result<(), RunError> {
        println!("\n{title}\n\n{table}");
        write(&self.folder().join(format!("{}.csv", table.name)), table.csv())
    }

    /// Prints a line.
    pub fn say(&self, line: &str) {
        println!("{line}");
    }

    /// Writes a picture, with `--docs` into the documentation too.
    ///
    /// # Errors
    /// [`RunError::Write`].
    pub fn picture(&self, name: &str, svg: &str) -> Result<(), RunError> {
        write(&self.folder().join(format!("{name}.svg")), svg)?;
        if self.arguments.docs {
            let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/experiments");
            write(&docs.join(format!("{}_{name}.svg", self.name)), svg)?;
        }
        Ok(())
    }

    /// Writes a photograph as JPEG, as good as fits into 300 kB, with `--docs` into the documentation too.
    ///
    /// # Errors
    /// [`RunError::Write`].
    pub fn photograph(&self, name: &str, picture: &Picture) -> Result<(), RunError> {
        let path = self.folder().join(format!("{name}.jpg"));
        let mut bytes = Vec::new();
        for quality in [90, 80, 70, 60, 50, 40] {
            bytes = jpeg::encode(picture, quality)
                .map_err(|source| RunError::Write { path: path.clone(), source })?;
            if bytes.len() <= MOST_BYTES {
                break;
            }
        }
        write(&path, &bytes)?;
        if self.arguments.docs {
            let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/experiments");
            write(&docs.join(format!("{}_{name}.jpg", self.name)), &bytes)?;
        }
        Ok(())
    }

    /// Writes the record and compares the numbers with the expected ones.
    ///
    /// The exit code is 1 if one is out of its tolerance; each has its line.
    ///
    /// # Errors
    /// [`RunError`] if the record cannot be written or the expected numbers cannot be read.
    pub fn finish(self) -> Result<ExitCode, RunError> {
        let minutes = self.started.elapsed().as_secs_f64() / 60.0;
        let record = Record {
            experiment: self.name,
            version: env!("CARGO_PKG_VERSION"),
            seed: self.seed(),
            settings: &self.settings,
            numbers: &self.numbers,
            minutes,
        };
        let text = serde_json::to_string_pretty(&record).unwrap_or_default();
        write(&self.folder().join("record.json"), &text)?;
        let expected = read_expected(&self.file_name())?;
        let mut table = Table::new("numbers", &["number", "here", "expected", "paper"]);
        for (name, value) in &self.numbers {
            let known = expected.get(name).copied().unwrap_or_default();
            let interval = match (known.value, known.tolerance, known.least, known.most) {
                (Some(value), Some(tolerance), _, _) => format!("{value} ± {tolerance}"),
                (_, _, Some(least), None) => format!("≥ {least}"),
                (_, _, None, Some(most)) => format!("≤ {most}"),
                (_, _, Some(least), Some(most)) => format!("{least} to {most}"),
                _ => "–".to_owned(),
            };
            let paper = known.paper.map_or_else(String::new, |p| p.to_string());
            table.row([name.clone(), format!("{value:.4}"), interval, paper]);
        }
        self.table(&format!("Numbers of this run ({minutes:.1} min)"), &table)?;
        if self.seed() != SEED {
            println!("not checked: the expected numbers are those of seed {SEED}");
            return Ok(ExitCode::SUCCESS);
        }
        let out = out(&expected, &self.numbers);
        out.iter().for_each(|line| println!("{line}"));
        Ok(if out.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }

    /// Where its files go.
    pub fn folder(&self) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("out").join(self.file_name())
    }
}

fn read_expected(name: &str) -> Result<ExpectedNumbers, RunError> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("expected/{name}.toml"));
    let text = fs::read_to_string(&path)
        .map_err(|source| RunError::Read { path: path.clone(), source })?;
    toml::from_str(&text).map_err(|source| RunError::Expected { path, source })
}

/// Size of a photograph in the documentation.
const MOST_BYTES: usize = 300_000;

fn write(path: &Path, text: impl AsRef<[u8]>) -> Result<(), RunError> {
    let folder = path.parent().unwrap_or(path);
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(path, text))
        .map_err(|source| RunError::Write { path: path.to_owned(), source })
}
