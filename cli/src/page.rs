//! How a page is written: its language, as HTML, and as a PDF beside it.

use std::path::PathBuf;

use clap::Args;
use maquette::io::folder::{OutFolder, pdf};
use maquette::report::Language;

use crate::choice::{Choice, one_of};
use crate::error::CliError;

/// What the pages of a report and of a comparison have in common.
#[derive(Debug, Args)]
pub(super) struct PageArguments {
    /// Also write a PDF of the page beside it, printed by an installed Chromium or Chrome; the variable CHROME names another one
    #[arg(long)]
    pdf: bool,
    #[command(flatten)]
    language: LanguageArgument,
}

/// The language of a page.
#[derive(Debug, Args)]
pub(super) struct LanguageArgument {
    /// Language of the page [default: en]
    #[arg(long, value_parser = one_of(LANGUAGES))]
    language: Option<Language>,
}

impl LanguageArgument {
    /// As asked for.
    pub(super) fn get(&self) -> Language {
        self.language.unwrap_or_default()
    }
}

const LANGUAGES: &[Choice<Language>] =
    &[("en", Language::English, "English"), ("de", Language::German, "German")];

/// Where a page is, and its PDF.
#[derive(Debug)]
pub(super) struct Written {
    pub(super) page: PathBuf,
    pub(super) pdf: Option<PathBuf>,
}

impl PageArguments {
    /// The language of the page.
    pub(super) fn language(&self) -> Language {
        self.language.get()
    }

    /// Writes a page, and prints it if that is asked for.
    pub(super) fn write(
        &self,
        out: &OutFolder,
        name: &str,
        text: &str,
    ) -> Result<Written, CliError> {
        out.write(name, text.as_bytes())?;
        let page = out.path().join(name);
        let pdf = self.pdf.then(|| pdf::print(&page)).transpose()?;
        Ok(Written { page, pdf })
    }
}
