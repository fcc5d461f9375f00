//! How a page is written: as HTML, and as a PDF beside it.

use std::path::PathBuf;

use clap::Args;
use maquette::io::folder::{OutFolder, pdf};

use crate::error::CliError;

/// What the pages of a report and of a comparison have in common.
#[derive(Debug, Args)]
pub(super) struct PageArguments {
    /// Also write a PDF of the page beside it, printed by an installed Chromium or Chrome; the variable CHROME names another one
    #[arg(long)]
    pdf: bool,
}

/// Where a page is, and its PDF.
#[derive(Debug)]
pub(super) struct Written {
    pub(super) page: PathBuf,
    pub(super) pdf: Option<PathBuf>,
}

impl PageArguments {
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
