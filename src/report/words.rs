//! What a page says, in the language of its reader.
//!
//! A text stands in English where it is said: `words.of("Steps and strides")`. That is the page in English. Another language is a
//! file of `language/`, which has for each of these texts the one that is said in its place. `tests/language.rs` reads `src/report`
//! and `web/src` and fails where a file lacks a text, has one that nobody says, or changes a `{placeholder}`.

use std::collections::BTreeMap;
use std::fmt::Display;

use maud::{Markup, html};
use serde::Deserialize;

const GERMAN: &str = include_str!("language/de.toml");

/// The language of a page.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Language {
    /// English.
    #[default]
    English,
    /// German.
    German,
}

impl Language {
    /// Its two letters in ISO 639-1.
    pub fn code(self) -> &'static str {
        match self {
            Self::English => "en",
            Self::German => "de",
        }
    }
}

/// A file of `language/`: the English text, and what is said in its place.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Translation {
    /// Texts of the pages.
    page: BTreeMap<String, String>,
    /// Texts of the page's program.
    program: BTreeMap<String, String>,
    /// Names, units and sentences of the analysis. What is missing here stays English.
    elsewhere: BTreeMap<String, String>,
}

/// The words of a page in one language.
#[derive(Debug)]
pub struct Words {
    language: Language,
    translation: Translation,
}

impl Words {
    /// The words of a language.
    pub fn new(language: Language) -> Self {
        let translation = match language {
            Language::English => Translation::default(),
            Language::German => read(GERMAN),
        };
        Self { language, translation }
    }

    /// Two letters for the page's `lang`.
    pub(super) fn code(&self) -> &'static str {
        self.language.code()
    }

    /// A text of the page.
    pub(super) fn of<'a>(&'a self, english: &'a str) -> &'a str {
        self.translation.page.get(english).map_or(english, String::as_str)
    }

    /// A text of the page, with values in the place of `{name}`.
    pub(super) fn fill(&self, english: &str, values: &[(&str, &dyn Display)]) -> String {
        let mut text = self.of(english).to_owned();
        for (name, value) in values {
            text = text.replace(&format!("{{{name}}}"), &value.to_string());
        }
        text
    }

    /// A name, a unit or a sentence that was made elsewhere; it stays English if this language does not know it.
    pub(super) fn known<'a>(&'a self, english: &'a str) -> &'a str {
        self.translation.elsewhere.get(english).map_or(english, String::as_str)
    }

    /// The same, marked as English if it stays English.
    pub(super) fn line(&self, english: &str) -> Markup {
        let stays =
            self.language != Language::English && !self.translation.elsewhere.contains_key(english);
        html! { @if stays { span lang="en" { (english) } } @else { (self.known(english)) } }
    }

    /// What the page's program says.
    pub(super) fn program(&self) -> &BTreeMap<String, String> {
        &self.translation.program
    }

    /// A number with digits after the decimal sign; a dash if it is absent or not finite.
    pub(super) fn number(&self, value: Option<f64>, digits: usize) -> String {
        match value.filter(|v| v.is_finite()) {
            // zero has no sign
            Some(value) if value.abs() < 0.5 * 0.1_f64.powi(digits as i32) => {
                self.decimal(format!("{:.digits$}", 0.0))
            }
            Some(value) => self.decimal(format!("{value:.digits$}").replace('-', "−")),
            None => "–".into(),
        }
    }

    /// A written number, with the decimal sign of this language.
    pub(super) fn decimal(&self, number: impl Display) -> String {
        let number = number.to_string();
        if self.is_decimal_comma() { number.replace('.', ",") } else { number }
    }

    /// Whether its decimal sign is a comma.
    pub(super) fn is_decimal_comma(&self) -> bool {
        self.language == Language::German
    }

    /// A probability; none is written as 1.
    pub(super) fn probability(&self, value: Option<f64>) -> String {
        match value {
            Some(value) if value > 0.999 => format!("> {}", self.decimal(0.999)),
            _ => self.number(value, 3),
        }
    }
}

fn read(file: &str) -> Translation {
    toml::from_str(file).expect("a test reads every file of a language")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_a_language_is_read() {
        assert!(Words::new(Language::German).translation.page.len() > 100);
    }

    #[test]
    fn what_is_not_there_is_a_dash() {
        let words = Words::new(Language::English);
        assert_eq!(words.number(None, 1), "–");
        assert_eq!(words.number(Some(f64::NAN), 1), "–");
        assert_eq!(words.number(Some(-1.26), 1), "−1.3");
        assert_eq!(words.number(Some(-0.04), 1), "0.0");
    }

    #[test]
    fn german_numbers_have_a_comma_and_english_sentences_of_the_analysis_are_marked() {
        let words = Words::new(Language::German);
        assert_eq!((words.code(), words.number(Some(-1.26), 1)), ("de", "−1,3".into()));
        assert_eq!(words.probability(Some(1.0)), "> 0,999");
        assert_eq!(words.known("left"), "links");
        assert_eq!(words.line("a line").into_string(), "<span lang=\"en\">a line</span>");
        assert_eq!(Words::new(Language::English).line("a line").into_string(), "a line");
    }
}
