//! Everything that changes over time, as one table: a row per frame, a column per number.
//!
//! Places and their standard deviations in metres along the file's axes (`RKnee_x_m`, `RKnee_sd_x_m`), angles in degrees
//! (`knee_flexion_r_deg`) and theirs (`knee_flexion_r_sd_deg`). What is not known is empty in CSV and null in Parquet.

use std::sync::Arc;

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::{DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::camera::UpAxis;
use crate::gait::{GaitAnalysis, Movement};
use crate::io::gait::FittedPoint;

/// Columns over time.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameTable {
    /// Numbers of the frames.
    pub frames: Vec<i64>,
    /// Names and values, a value per frame; NaN where unknown. The first is `time_s`, from frame 0.
    pub columns: Vec<(String, Vec<f64>)>,
}

/// The table of a fit.
pub fn frame_table(movement: &Movement, points: &[FittedPoint], gait: &GaitAnalysis) -> FrameTable {
    let numbers = movement.first_frame..movement.first_frame + movement.frames;
    let time = |frame: usize| frame as f64 / movement.rate_hz;
    let mut columns = vec![("time_s".to_owned(), numbers.clone().map(time).collect())];
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
    FrameTable {
        frames: numbers.map(|frame| frame as i64).collect(),
        columns,
    }
}

impl FrameTable {
    /// As CSV, numbers with 6 decimals.
    ///
    /// # Errors
    /// The writer's, if it has any.
    pub fn csv(&self) -> Result<Vec<u8>, csv::Error> {
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
        writer.into_inner().map_err(|e| e.into_error().into())
    }

    /// As Parquet: `frame` as INT64, all others as DOUBLE, in one row group.
    ///
    /// # Errors
    /// The writer's, if it has any.
    pub fn parquet(&self) -> Result<Vec<u8>, ParquetError> {
        let field = |name: &str, physical, repetition| {
            let field = Type::primitive_type_builder(name, physical).with_repetition(repetition);
            field.build().map(Arc::new)
        };
        let frame = field("frame", Physical::INT64, Repetition::REQUIRED);
        let doubles = self.columns.iter();
        let doubles = doubles.map(|(name, _)| field(name, Physical::DOUBLE, Repetition::OPTIONAL));
        let fields = std::iter::once(frame)
            .chain(doubles)
            .collect::<Result<_, _>>()?;
        let schema = Type::group_type_builder("motion")
            .with_fields(fields)
            .build()?;
        let properties = WriterProperties::builder()
            .set_created_by(concat!("maquette ", env!("CARGO_PKG_VERSION")).into());
        let mut bytes = Vec::new();
        let mut file =
            SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties.build()))?;
        let mut rows = file.next_row_group()?;
        if let Some(mut column) = rows.next_column()? {
            column
                .typed::<Int64Type>()
                .write_batch(&self.frames, None, None)?;
            column.close()?;
        }
        for (_, values) in &self.columns {
            let Some(mut column) = rows.next_column()? else {
                break;
            };
            // a null has no value and the definition level 0
            let known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
            let levels: Vec<i16> = values.iter().map(|v| i16::from(v.is_finite())).collect();
            column
                .typed::<DoubleType>()
                .write_batch(&known, Some(&levels), None)?;
            column.close()?;
        }
        rows.close()?;
        file.close()?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use parquet::file::serialized_reader::SerializedFileReader;
    use parquet::record::RowAccessor;

    use super::*;

    fn table() -> FrameTable {
        FrameTable {
            frames: vec![7, 8],
            columns: vec![
                ("time_s".into(), vec![0.14, 0.16]),
                ("RKnee_x_m".into(), vec![f64::NAN, 1.0 / 3.0]),
            ],
        }
    }

    #[test]
    fn parquet_gives_back_every_bit_and_null_for_what_is_unknown() {
        let bytes = table().parquet().unwrap();
        let mut file = tempfile::tempfile().unwrap();
        std::io::Write::write_all(&mut file, &bytes).unwrap();
        let file = SerializedFileReader::new(file).unwrap();
        let rows: Vec<_> = file.into_iter().map(Result::unwrap).collect();
        assert_eq!(
            (rows[0].get_long(0).unwrap(), rows[1].get_long(0).unwrap()),
            (7, 8)
        );
        assert!(rows[0].get_double(2).is_err(), "null");
        assert_eq!(
            rows[1].get_double(2).unwrap().to_bits(),
            (1.0_f64 / 3.0).to_bits()
        );
    }

    #[test]
    fn a_cell_of_csv_is_empty_where_nothing_is_known() {
        let text = String::from_utf8(table().csv().unwrap()).unwrap();
        assert_eq!(
            text,
            "frame,time_s,RKnee_x_m\n7,0.140000,\n8,0.160000,0.333333\n"
        );
    }
}
