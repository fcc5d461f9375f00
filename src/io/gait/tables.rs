//! Tables for spreadsheets: comma-separated, one heading line, angles in degrees.

use crate::gait::{Band, Curve, GaitAnalysis, Movement, Norm};

/// Every curve, a row per side, angle and percent: mean, SD over strides, SD of the fit, norm, then the strides.
///
/// # Errors
/// None that an analysis can cause; the writer's, if it has any.
pub fn curves_csv(gait: &GaitAnalysis, norm: Option<&Norm>) -> std::io::Result<Vec<u8>> {
    let counts = gait.curves.iter().map(|c| c.strides.len());
    let strides = counts.max().unwrap_or(0);
    let heading =
        ["side", "angle", "percent", "mean_deg", "sd_deg", "fit_sd_deg", "norm_deg", "norm_sd_deg"];
    let stride_names = (1..=strides).map(|i| format!("stride_{i}_deg"));

    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(heading.map(str::to_owned).into_iter().chain(stride_names))?;
    for curve in &gait.curves {
        let band = norm.and_then(|norm| norm.band(curve.angle));
        for percent in 0..curve.mean.len() {
            writer.write_record(curve_row(curve, band, percent, strides))?;
        }
    }
    finished(writer)
}

/// One percent of a curve, with as many strides as the table has columns for.
fn curve_row(curve: &Curve, band: Option<&Band>, percent: usize, strides: usize) -> Vec<String> {
    let at = |values: &Option<Vec<f64>>| values.as_ref().and_then(|v| v.get(percent)).copied();
    // the norm has every second percent
    let band = band.filter(|_| percent.is_multiple_of(2));
    let norm_at = |values: &[f64]| values.get(percent / 2).copied();
    let numbers = [
        Some(curve.mean[percent]),
        at(&curve.sd),
        at(&curve.fit_sd),
        band.and_then(|band| norm_at(&band.mean)),
        band.and_then(|band| norm_at(&band.sd)),
    ];
    let stride = |i: usize| curve.strides.get(i).map(|s| s[percent]);

    let [side, angle] = [curve.side.name(), curve.angle.name()].map(str::to_owned);
    let mut row = vec![side, angle, percent.to_string()];
    row.extend(numbers.into_iter().map(degrees));
    row.extend((0..strides).map(stride).map(degrees));
    row
}

/// Every angle in every frame: a column per angle and side.
///
/// # Errors
/// As [`curves_csv`].
pub fn angles_csv(gait: &GaitAnalysis, movement: &Movement) -> std::io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let keys = gait.angles.keys();
    let names = keys.map(|(side, angle)| format!("{}_{}_deg", angle.name(), &side.name()[..1]));
    let heading = ["frame", "time_s"].map(str::to_owned);
    writer.write_record(heading.into_iter().chain(names))?;

    for i in 0..movement.frames {
        let frame = movement.first_frame + i;
        let time = format!("{:.6}", frame as f64 / movement.rate_hz);
        let angles = gait.angles.values().map(|track| degrees(track.get(i).copied()));
        writer.write_record([frame.to_string(), time].into_iter().chain(angles))?;
    }
    finished(writer)
}

/// Every stride and step of every parameter: a row each.
///
/// # Errors
/// As [`curves_csv`].
pub fn parameters_csv(gait: &GaitAnalysis) -> std::io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["parameter", "unit", "side", "number", "value", "uncertainty"])?;

    for ((parameter, side), statistic) in &gait.parameters {
        let uncertainty = statistic.uncertainty.map_or(String::new(), |u| format!("{u:.6}"));
        for (i, value) in statistic.values.iter().enumerate() {
            let cells = [
                parameter.name().to_owned(),
                parameter.unit().to_owned(),
                side.name().to_owned(),
                (i + 1).to_string(),
                format!("{value:.6}"),
                uncertainty.clone(),
            ];
            writer.write_record(cells)?;
        }
    }
    finished(writer)
}

fn degrees(angle: Option<f64>) -> String {
    let known = angle.filter(|a| a.is_finite());
    known.map_or(String::new(), |a| format!("{:.4}", a.to_degrees()))
}

pub(super) fn finished(writer: csv::Writer<Vec<u8>>) -> std::io::Result<Vec<u8>> {
    writer.into_inner().map_err(|e| e.into_error())
}
