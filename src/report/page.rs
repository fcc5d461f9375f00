//! The document around the pages, and the pieces that all pages share.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::figure::style_of_sides;
use super::{Subject, Words};
use crate::gait::{BEYOND_SD, Beyond, Footwear, FootwearCaution};
use crate::pipeline::Verdict;

const SCRIPT: &str = include_str!("bundle/report.js");
const STYLE: &str = include_str!("bundle/report.css");

/// One page: its name in links, its heading and what it shows.
#[derive(Debug)]
pub(super) struct Page<'a> {
    pub(super) id: &'static str,
    pub(super) title: &'a str,
    pub(super) body: Markup,
    /// A few lines only: on paper they follow the page before.
    pub(super) is_brief: bool,
}

/// What is printed across every page of a fit that cannot be used.
pub(super) fn banner(verdict: &Verdict, words: &Words) -> Option<Markup> {
    let headline = verdict.why_unusable()?;
    Some(html! { p class="verdict" role="alert" { (words.line(&headline)) } })
}

/// The whole file. `scene` is JSON for the page's program, without which nothing moves; the banner stands on every page.
pub(super) fn document(
    subject: &Subject,
    banner: Option<&Markup>,
    pages: &[Page<'_>],
    scene: Option<&str>,
    words: &Words,
) -> String {
    let title = subject.name.as_ref().unwrap_or(&subject.recording);
    let markup = html! {
        (DOCTYPE)
        html lang=(words.code()) {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (words.of("Motion report")) " · " (title) }
                (style()) style { (PreEscaped(foot(subject))) }
            }
            body {
                a class="skip" href="#identity" { (words.of("Skip to the report")) }
                header class="bar" {
                    strong { "Maquette" }
                    nav aria-label=(words.of("Pages")) {
                        @for page in pages { a href={ "#" (page.id) } { (page.title) } }
                    }
                    @if scene.is_some() { label { input type="checkbox" id="colour-blind"; " " (words.of("colour-blind safe")) } }
                }
                main {
                    @for (i, page) in pages.iter().enumerate() {
                        section id=(page.id) class=[page.is_brief.then_some("brief")] aria-labelledby={ (page.id) "-title" } {
                            @if i == 0 { h1 { (words.of("Motion report")) } }
                            h2 id={ (page.id) "-title" } { (page.title) }
                            @if let Some(banner) = banner { (banner) }
                            (page.body)
                        }
                    }
                }
                @if let Some(scene) = scene { (program(scene)) }
            }
        }
    };
    markup.into_string()
}

/// How a page looks.
pub(super) fn style() -> Markup {
    html! { style { (PreEscaped(STYLE)) (PreEscaped(style_of_sides())) } }
}

/// The page's program, and `scene`, which is JSON.
pub(super) fn program(scene: &str) -> Markup {
    // within a script element no text may look like its end
    let scene = scene.replace('<', "\\u003c");
    html! {
        script type="application/json" id="scene" { (PreEscaped(scene)) }
        script type="module" { (PreEscaped(SCRIPT)) }
    }
}

/// Who, when, and the number of the page at the foot of each sheet of paper.
fn foot(subject: &Subject) -> String {
    let stated = [&subject.name, &subject.date, &subject.condition];
    let stated = stated.into_iter().flatten().chain([&subject.recording]);
    let whose = stated.map(String::as_str).collect::<Vec<_>>().join(" · ");
    // every character by its number, so that none can end the string or the style sheet
    let whose: String = whose.chars().map(|c| format!("\\{:06x}", u32::from(c))).collect();
    format!(
        "@page {{ @bottom-left {{ content: \"{whose}\" }} @bottom-right {{ content: counter(page) \" / \" counter(pages) }} }}"
    )
}

/// The mark of a number beyond the norm, which is also read aloud.
pub(super) fn mark(beyond: Option<Beyond>, words: &Words) -> Markup {
    html! {
        @if let Some(beyond) = beyond {
            span class="beyond" { span aria-hidden="true" { (beyond.mark()) } span class="spoken" { (words.known(beyond.words())) } }
        }
    }
}

/// What to know before a person is compared with a norm; nothing where both walked alike.
pub(super) fn footwear_note(
    norm: Option<Footwear>,
    person: Option<Footwear>,
    words: &Words,
) -> Markup {
    let of = |footwear: Footwear| words.known(footwear.words());
    let caution = Footwear::caution(norm, person).map(|caution| match caution {
        FootwearCaution::Differs { norm, person } => words.fill(
            "the people of the norm walked {norm}, this person {person}: footwear changes steps and ankles",
            &[("norm", &of(norm)), ("person", &of(person))],
        ),
        FootwearCaution::NotStated { norm } => words.fill(
            "the people of the norm walked {norm}; what this person wore is not stated (--footwear)",
            &[("norm", &of(norm))],
        ),
        FootwearCaution::NormUnknown => words.of("what the people of the norm wore is not known").into(),
    });
    html! {
        @if let Some(caution) = caution {
            p class="absent" { (words.of("Before comparing with the norm:")) " " (caution) "." }
        }
    }
}

/// What the marks mean.
pub(super) fn mark_legend(words: &Words) -> Markup {
    html! {
        span aria-hidden="true" { (Beyond::Above.mark()) " " (Beyond::Below.mark()) }
        " " (words.fill("marked: beyond the norm's mean by more than {n} SD between people.", &[("n", &BEYOND_SD)])) " "
    }
}

/// A reason why something is absent.
pub(super) fn absent(reason: &str) -> Markup {
    html! { p class="absent" { (reason) } }
}

/// The key of the two sides, for every page with curves.
pub(super) fn key(norm: Option<&str>, words: &Words) -> Markup {
    html! {
        p class="key" {
            span class="left" { (words.known("left")) } span class="right" { (words.known("right")) }
            @if let Some(norm) = norm { span class="norm" { (words.fill("norm: {norm}, mean ± 1 SD between people", &[("norm", &norm)])) } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::{Cause, Reason};
    use crate::report::Language;

    fn english() -> Words {
        Words::new(Language::English)
    }

    #[test]
    fn no_text_of_the_data_can_end_its_script() {
        let page = document(
            &Subject::default(),
            None,
            &[],
            Some(r#"{"name":"</script><b>"}"#),
            &english(),
        );
        assert!(page.contains(r#"{"name":"\u003c/script>\u003cb>"}"#));
    }

    #[test]
    fn the_verdict_on_a_fit_that_cannot_be_used_stands_on_every_page() {
        let page = |id| Page { id, title: id, body: html! {}, is_brief: false };
        let reason = Reason::Overlap { found: 0.31, least: 0.65 };
        let unusable = Verdict { unusable: vec![reason], causes: vec![Cause::AllMirrored] };
        let pages = [page("one"), page("two")];
        let text = document(
            &Subject::default(),
            banner(&unusable, &english()).as_ref(),
            &pages,
            Some("{}"),
            &english(),
        );
        assert_eq!(
            text.matches("not usable: the body overlaps the silhouettes by 0.31").count(),
            2
        );
        assert!(text.contains("all pictures are mirrored"));

        let late = Cause::Late { camera: "a".into(), frames: 2 };
        let usable = Verdict { unusable: Vec::new(), causes: vec![late] };
        assert!(banner(&usable, &english()).is_none());
    }

    #[test]
    fn a_name_with_markup_stays_text() {
        let subject = Subject { name: Some("<img src=x>".into()), ..Subject::default() };
        assert!(document(&subject, None, &[], None, &english()).contains("&lt;img src=x&gt;"));
        assert!(!foot(&subject).contains(['<', 'x']));
    }

    #[test]
    fn the_page_asks_nobody_for_anything() {
        for text in [STYLE, SCRIPT] {
            assert!(!text.contains("@import") && !text.contains("sourceMappingURL"));
            assert!(!text.contains("</script"));
        }
    }
}
