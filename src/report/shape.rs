//! Lengths and girths of the person.

use maud::{Markup, html};

use super::label::part_name;
use super::page::{Page, absent};
use super::{ReportInput, Words};
use crate::io::result::{LengthPart, ResultFile};
use crate::skin::{Girth, girths};

pub(super) fn page<'a>(input: &ReportInput<'a>) -> Page<'a> {
    let words = input.words;
    Page {
        id: "shape",
        title: words.of("Shape"),
        body: match input.result {
            Some(result) => fitted_shape(result, input),
            None => html! {
                (absent(words.of("Points of another system: no body was fitted.")))
                @if let Some(leg) = input.gait.leg_length_m {
                    p { (words.fill("Leg length, hip to knee to ankle: {cm} cm.", &[("cm", &words.number(Some(100.0 * leg), 1))])) }
                }
            },
        },
        is_brief: input.result.is_none(),
    }
}

fn fitted_shape(result: &ResultFile, input: &ReportInput<'_>) -> Markup {
    let words = input.words;
    let portraits = [("front", words.of("from the front")), ("side", words.of("from the side"))];
    let covariance = result.shape.covariance.as_deref();
    let girths = input.body.map(|body| girths(&body.model, &body.shape, covariance));

    html! {
        div class="shape" {
            div class="portraits" {
                @for (view, name) in portraits {
                    figure {
                        img data-portrait=(view) alt={ (words.of("The fitted body,")) " " (name) };
                        figcaption { (name) }
                    }
                }
            }
            div {
                (length_table(&result.shape.lengths, words))
                @if let Some(girths) = &girths { (girth_table(girths, words)) }
            }
        }
        p class="note" {
            (words.of("± is the standard deviation that the fit gives the length"))
            @if result.shape.lengths.iter().all(|l| l.sd_m.is_none()) {
                (words.of("; it is absent because this fit was made without the joint optimum"))
            }
            ". " (words.of("Joint centres lie inside the body, where outlines do not show them: the lengths also rest on statistics of people."))
            " " (words.of("Girths: around the limb in the middle of the length and square to it."))
        }
    }
}

fn length_table(lengths: &[LengthPart], words: &Words) -> Markup {
    let row = |length: &LengthPart| (part_name(&length.name, words), length.length_m, length.sd_m);
    size_table(words.of("Length"), lengths.iter().map(row), words)
}

fn girth_table(girths: &[Girth], words: &Words) -> Markup {
    let row = |girth: &Girth| (part_name(&girth.name, words), girth.girth_m, girth.sd_m);
    size_table(words.of("Girth, mid-length"), girths.iter().map(row), words)
}

/// Name, metres and their standard deviation, row by row.
fn size_table(
    heading: &str,
    rows: impl Iterator<Item = (String, f64, Option<f64>)>,
    words: &Words,
) -> Markup {
    html! {
        div class="scroll" role="group" tabindex="0" aria-label=(words.of("Table")) {
            table class="numbers" {
                thead { tr { th scope="col" { (heading) } th scope="col" { "cm" } th scope="col" { "± cm" } } }
                tbody { @for (name, metres, sd_m) in rows { tr {
                    th scope="row" { (name) }
                    td class="mean" { (words.number(Some(100.0 * metres), 1)) }
                    td { (words.number(sd_m.map(|sd| 100.0 * sd), 1)) }
                } } }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::confidence::Confidence;
    use crate::report::Language;

    #[test]
    fn no_probability_that_reads_as_accuracy_stands_beside_a_length() {
        let confidence =
            Confidence { epsilon: 0.02, sigma: Some(0.001), keyframes: 7, p_within: Some(0.9999) };
        let thigh = LengthPart {
            name: "thigh".into(),
            from: "RHip".into(),
            to: "RKnee".into(),
            length_m: 0.41,
            sd_m: Some(0.012),
            confidence,
        };
        let table = length_table(&[thigh], &Words::new(Language::English)).into_string();
        assert!(table.contains("41.0") && table.contains("1.2"), "{table}");
        assert!(!table.contains("0.999") && !table.contains("ε"), "{table}");
    }
}
