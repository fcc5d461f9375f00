//! A page as a PDF, printed by the browser of this machine: Chromium, Chrome or Edge.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use super::{UNFINISHED, parent_of};

/// Why a page was not printed. The page itself is there.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PdfError {
    /// There is no browser.
    #[error(
        "{}: no PDF of it: no Chromium or Chrome is installed (looked for {looked_for}): open the page in any browser and print it, or name a browser in the variable CHROME",
        page.display()
    )]
    NoBrowser {
        /// The page.
        page: PathBuf,
        /// Names that were tried.
        looked_for: String,
    },
    /// There is one, and it did not print.
    #[error("{}: no PDF of it: {browser} {reason}: open the page in any browser and print it", page.display())]
    Browser {
        /// The page.
        page: PathBuf,
        /// Its name.
        browser: String,
        /// What it did instead.
        reason: String,
    },
}

/// Names of browsers that print without a window, the commonest first.
const BROWSERS: [&str; 8] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    r"C:\Program Files\Google\Chrome\Application\chrome.exe",
    r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
];

/// Longest that a browser prints; a report takes a few seconds.
const LIMIT: Duration = Duration::from_secs(120);
/// How often a browser that prints is looked at.
const PAUSE: Duration = Duration::from_millis(20);

/// What draws the moving body without a graphics card.
const DRAWS: [&str; 3] =
    ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
/// What keeps a browser from asking anybody for anything, and from the person's own windows and profile.
const ALONE: [&str; 4] =
    ["--headless", "--no-first-run", "--disable-background-networking", "--disable-sync"];

/// Prints a page into the PDF beside it, `report.pdf` of `report.html`, and says where that is. It is printed when it has loaded,
/// which the report's page has when all of it is drawn. The browser is the one that the variable `CHROME` names, or else an
/// installed one.
///
/// # Errors
/// [`PdfError`] says what to do. There is no PDF then, not even one of an older page.
pub fn print(page: &Path) -> Result<PathBuf, PdfError> {
    let browsers = match env::var_os("CHROME").filter(|name| !name.is_empty()) {
        Some(name) => vec![name],
        None => BROWSERS.map(OsString::from).to_vec(),
    };
    Printer { browsers, limit: LIMIT }.print(page)
}

/// Browsers to be tried in turn, and how long one may take.
#[derive(Debug)]
struct Printer {
    browsers: Vec<OsString>,
    limit: Duration,
}

impl Printer {
    fn print(&self, page: &Path) -> Result<PathBuf, PdfError> {
        let pdf = page.with_extension("pdf");
        // an older page's
        let _ = fs::remove_file(&pdf);

        let mut failed = None;
        for browser in &self.browsers {
            match self.print_with(browser, page, &pdf) {
                Ok(()) => return Ok(pdf),
                Err(fault) if fault.kind() == io::ErrorKind::NotFound => {}
                Err(fault) => failed = failed.or(Some((browser, fault))),
            }
        }

        if let Some((browser, fault)) = failed {
            return Err(PdfError::Browser {
                page: page.into(),
                browser: browser.to_string_lossy().into_owned(),
                reason: fault.to_string(),
            });
        }
        let names = self.browsers.iter().map(|name| name.to_string_lossy());
        let looked_for = names.filter(|name| !name.contains([' ', '\\'])).collect::<Vec<_>>();
        Err(PdfError::NoBrowser { page: page.into(), looked_for: looked_for.join(", ") })
    }

    /// Prints by one browser; its fault is of the kind `NotFound` where it is not installed, and of no other reason.
    fn print_with(&self, browser: &OsString, page: &Path, pdf: &Path) -> io::Result<()> {
        let scratch = tempfile::Builder::new().prefix(UNFINISHED).tempdir_in(parent_of(pdf));
        let scratch = scratch.map_err(io::Error::other)?;
        let made = scratch.path().join("page.pdf");
        let start = |more: &[&str]| {
            Command::new(browser)
                .args(ALONE)
                .args(DRAWS)
                .args(["--no-pdf-header-footer"].iter().chain(more))
                .arg(option("--user-data-dir=", &scratch.path().join("profile")))
                .arg(option("--print-to-pdf=", &made))
                .arg(address(page))
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .map_err(|fault| match fault.kind() {
                    io::ErrorKind::NotFound => fault,
                    _ => io::Error::other(format!("cannot be run: {fault}")),
                })
        };

        // within its sandbox; where the machine has none, without: the page is our own
        let mut status = self.wait(start(&[])?)?;
        if !made.is_file() {
            status = self.wait(start(&["--no-sandbox"])?)?;
        }
        match made.is_file() {
            true => fs::rename(&made, pdf).map_err(io::Error::other),
            false => Err(io::Error::other(format!("wrote none ({status})"))),
        }
    }

    /// Waits until a browser has ended, and ends it after the longest time.
    fn wait(&self, mut browser: Child) -> io::Result<ExitStatus> {
        let begun = Instant::now();
        loop {
            if let Some(status) = browser.try_wait()? {
                return Ok(status);
            }
            if begun.elapsed() >= self.limit {
                let _ = browser.kill();
                let _ = browser.wait();
                let seconds = self.limit.as_secs();
                return Err(io::Error::other(format!("had not printed it after {seconds} s")));
            }
            thread::sleep(PAUSE);
        }
    }
}

fn option(name: &str, path: &Path) -> OsString {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
    let mut option = OsString::from(name);
    option.push(path);
    option
}

/// The address of a file; every byte that means something in an address is written as its number.
fn address(page: &Path) -> String {
    let path = std::path::absolute(page).unwrap_or_else(|_| page.into());
    let mut address = String::from(if cfg!(windows) { "file:///" } else { "file://" });
    for &byte in path.as_os_str().as_encoded_bytes() {
        match byte {
            b'\\' if cfg!(windows) => address.push('/'),
            b'-' | b'_' | b'.' | b'/' | b':' => address.push(byte.into()),
            _ if byte.is_ascii_alphanumeric() => address.push(byte.into()),
            _ => address += &format!("%{byte:02X}"),
        }
    }
    address
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    /// A folder with a page, and a browser that does what a script says. `$pdf` is the file that it is asked for.
    fn printed(script: &str, limit: Duration) -> (tempfile::TempDir, Result<PathBuf, String>) {
        let folder = tempfile::tempdir().expect("a folder");
        let page = folder.path().join("a page #1.html");
        fs::write(&page, "<p>page").expect("written");
        fs::write(page.with_extension("pdf"), "an older page").expect("written");
        let browser = folder.path().join("browser");
        let find = "for word; do case $word in --print-to-pdf=*) pdf=${word#*=};; esac; done";
        fs::write(&browser, format!("#!/bin/sh\n{find}\n{script}\n")).expect("written");
        fs::set_permissions(&browser, fs::Permissions::from_mode(0o755)).expect("written");
        let browsers = vec!["no-such-browser".into(), browser.into()];
        let done = Printer { browsers, limit }.print(&page).map_err(|fault| fault.to_string());
        (folder, done)
    }

    #[test]
    fn a_browser_prints_into_the_pdf_beside_the_page() {
        let (folder, done) = printed("for last; do :; done; echo $last > \"$pdf\"", LIMIT);
        let text = fs::read_to_string(done.unwrap()).unwrap();
        assert!(
            text.starts_with("file:///") && text.ends_with("/a%20page%20%231.html\n"),
            "{text}"
        );
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "page, PDF and browser");
    }

    #[test]
    fn a_machine_without_a_sandbox_prints_without_one() {
        let script = "case \"$*\" in *--no-sandbox*) echo printed > \"$pdf\";; *) exit 1;; esac";
        assert!(printed(script, LIMIT).1.is_ok());
    }

    #[test]
    fn a_browser_that_does_not_print_or_does_not_end_is_named_and_leaves_no_older_pdf() {
        for (script, limit, expected) in [
            ("echo much >&2; exit 3", LIMIT, "browser wrote none (exit status: 3)"),
            ("exec sleep 60", Duration::ZERO, "browser had not printed it after 0 s"),
        ] {
            let (folder, done) = printed(script, limit);
            let fault = done.unwrap_err();
            assert!(fault.contains(expected) && fault.contains("open the page"), "{fault}");
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "page and browser");
        }
    }

    #[test]
    fn where_there_is_no_browser_a_person_is_told_to_print_the_page() {
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("report.html");
        let browsers = vec!["no-such-browser".into()];
        let fault = Printer { browsers, limit: LIMIT }.print(&page).unwrap_err().to_string();
        assert!(fault.contains("looked for no-such-browser): open the page"), "{fault}");
    }
}
