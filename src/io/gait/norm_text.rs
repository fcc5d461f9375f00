//! A norm as the text that [`parse_norm`](super::parse_norm) reads.

use std::fmt::Write;

use crate::gait::{Norm, Zero};

/// Least standard deviation that is written, in the unit of its row: a norm without spread cannot be read.
const LEAST_SD: f64 = 0.001;

/// The text of a norm: curves in degrees, to three digits after the point.
pub fn norm_text(norm: &Norm) -> String {
    let quoted = |text: &str| toml::Value::String(text.into()).to_string();
    let mut text = format!("name = {}\nsource = {}\n", quoted(&norm.name), quoted(&norm.source));
    if let Some(Ok(word)) = norm.footwear.map(toml::Value::try_from) {
        let _ = writeln!(text, "footwear = {word}");
    }
    if norm.zero == Zero::Standing {
        text += "zero = \"standing\"\n";
    }
    if let Some([first, last]) = norm.ages {
        let _ = writeln!(text, "ages = [{first}, {last}]");
    }
    if !norm.remarks.is_empty() {
        let lines: Vec<String> = norm.remarks.iter().map(|line| quoted(line)).collect();
        let _ = writeln!(text, "remarks = [{}]", lines.join(", "));
    }

    for (angle, band) in &norm.curves {
        let _ = writeln!(text, "\n[curve.{}]", angle.name());
        let mean = band.mean.iter().map(|v| v.to_degrees());
        let sd = band.sd.iter().map(|v| v.to_degrees().max(LEAST_SD));
        let _ = writeln!(text, "mean_deg = [\n{}]\nsd_deg = [\n{}]", rows(mean), rows(sd));
    }
    for (parameter, (mean, sd)) in &norm.parameters {
        let (name, sd) = (parameter.name(), sd.max(LEAST_SD));
        let _ = writeln!(text, "\n[parameter.{name}]\nmean = {mean:.4}\nsd = {sd:.4}");
    }
    text
}

/// Seventeen numbers a line.
fn rows(values: impl Iterator<Item = f64>) -> String {
    let words: Vec<String> = values.map(|v| format!("{v:.3}")).collect();
    words.chunks(17).map(|row| format!("    {},\n", row.join(", "))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::gait::{parse_norm, shipped_norm};
    use std::path::Path;

    #[test]
    fn a_norm_that_is_written_is_read_as_it_was() {
        let mut norm = shipped_norm(Some(30)).unwrap();
        norm.source = "a \"quoted\" source".into();
        norm.parameters.insert(crate::gait::Parameter::Speed, (1.25, 0.15));
        norm.parameters_footwear = norm.footwear;
        norm.zero = Zero::Standing;
        let read = parse_norm(&norm_text(&norm), Path::new("own.toml")).unwrap();
        for (angle, band) in &norm.curves {
            for (ours, theirs) in
                [(&band.mean, &read.curves[angle].mean), (&band.sd, &read.curves[angle].sd)]
            {
                for (a, b) in ours.iter().zip(theirs) {
                    approx::assert_relative_eq!(a, b, epsilon = 1e-5);
                }
            }
        }
        assert_eq!(Norm { curves: norm.curves.clone(), ..read }, norm);
    }
}
