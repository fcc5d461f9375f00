//! Everything that changes over time, as one table: a row per frame, a column per number.
//!
//! Places and their standard deviations in metres along the file's axes (`RKnee_x_m`, `RKnee_sd_x_m`), angles in degrees
//! (`knee_flexion_r_deg`) and theirs (`knee_flexion_r_sd_deg`). What is not known is empty in CSV and null in Parquet.

use crate::camera::UpAxis;
use crate::gait::{GaitAnalysis, Movement};
use crate::pipeline::FittedPoint;

/// Columns over time.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameTable {
    /// Numbers of the frames.
    pub frames: Vec<i64>,
    /// Names and values, a value per frame; NaN where unknown. The first is the time, seconds from frame 0.
    pub columns: Vec<(String, Vec<f64>)>,
}

/// The table of a fit.
pub fn frame_table(movement: &Movement, points: &[FittedPoint], gait: &GaitAnalysis) -> FrameTable {
    let mut table = FrameTable::new(movement, "time_s");
    let columns = &mut table.columns;

    for point in points {
        for (track, what) in [(&point.track, ""), (&point.sd_m, "sd_")] {
            let turned: Vec<_> = track.iter().map(|v| UpAxis::Y.to_export(v)).collect();
            for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
                let name = format!("{}_{what}{letter}_m", point.name);
                columns.push((name, turned.iter().map(|p| p[axis]).collect()));
            }
        }
    }

    let degrees = |track: &[f64]| track.iter().map(|a| a.to_degrees()).collect();
    for (key, track) in &gait.angles {
        let (side, angle) = key;
        let name = format!("{}_{}", angle.name(), &side.name()[..1]);
        let segments = movement.segments.as_ref();
        let sd = segments.and_then(|s| s.angle_sd.get(key));
        columns.push((format!("{name}_deg"), degrees(track)));
        columns.extend(sd.map(|sd| (format!("{name}_sd_deg"), degrees(sd))));
    }

    table
}

impl FrameTable {
    /// The frames of a movement with their times.
    pub(super) fn new(movement: &Movement, time: &str) -> Self {
        let frames = movement.first_frame..movement.first_frame + movement.frames;
        let seconds = |frame: usize| frame as f64 / movement.rate_hz;
        Self {
            frames: frames.clone().map(|frame| frame as i64).collect(),
            columns: vec![(time.to_owned(), frames.map(seconds).collect())],
        }
    }

    /// As CSV, numbers with 6 decimals.
    ///
    /// # Errors
    /// The writer's, if it has any.
    pub fn csv(&self) -> std::io::Result<Vec<u8>> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let names = self.columns.iter().map(|(name, _)| name.as_str());
        writer.write_record(std::iter::once("frame").chain(names))?;
        for (i, frame) in self.frames.iter().enumerate() {
            let number = |(_, values): &(String, Vec<f64>)| {
                let known = values.get(i).filter(|v| v.is_finite());
                known.map_or(String::new(), |v| format!("{v:.6}"))
            };
            let cells = self.columns.iter().map(number);
            writer.write_record(std::iter::once(frame.to_string()).chain(cells))?;
        }
        writer.into_inner().map_err(|e| e.into_error())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Two frames, one of which does not know a place.
    pub(in crate::io::export) fn table() -> FrameTable {
        FrameTable {
            frames: vec![7, 8],
            columns: vec![
                ("time_s".into(), vec![0.14, 0.16]),
                ("RKnee_x_m".into(), vec![f64::NAN, 1.0 / 3.0]),
            ],
        }
    }

    #[test]
    fn a_cell_of_csv_is_empty_where_nothing_is_known() {
        let text = String::from_utf8(table().csv().unwrap()).unwrap();
        assert_eq!(text, "frame,time_s,RKnee_x_m\n7,0.140000,\n8,0.160000,0.333333\n");
    }
}
