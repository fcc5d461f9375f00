//! The table of a fit as Parquet; with the feature `parquet`.

use std::sync::Arc;

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::{DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::FrameTable;

impl FrameTable {
    /// As Parquet: `frame` as INT64, all others as DOUBLE, in one row group.
    ///
    /// # Errors
    /// The writer's, if it has any.
    pub fn parquet(&self) -> std::io::Result<Vec<u8>> {
        self.encode().map_err(std::io::Error::other)
    }

    fn encode(&self) -> Result<Vec<u8>, ParquetError> {
        let field = |name: &str, physical, repetition| {
            let field = Type::primitive_type_builder(name, physical).with_repetition(repetition);
            field.build().map(Arc::new)
        };
        let frame = field("frame", Physical::INT64, Repetition::REQUIRED);
        let doubles = self.columns.iter();
        let doubles = doubles.map(|(name, _)| field(name, Physical::DOUBLE, Repetition::OPTIONAL));
        let fields = std::iter::once(frame).chain(doubles).collect::<Result<_, _>>()?;
        let schema = Type::group_type_builder("motion").with_fields(fields).build()?;
        let properties = WriterProperties::builder()
            .set_created_by(concat!("maquette ", env!("CARGO_PKG_VERSION")).into());
        let mut bytes = Vec::new();
        let mut file =
            SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties.build()))?;
        let mut rows = file.next_row_group()?;
        if let Some(mut column) = rows.next_column()? {
            column.typed::<Int64Type>().write_batch(&self.frames, None, None)?;
            column.close()?;
        }
        for (_, values) in &self.columns {
            let Some(mut column) = rows.next_column()? else {
                break;
            };
            // a null has no value and the definition level 0
            let known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
            let levels: Vec<i16> = values.iter().map(|v| i16::from(v.is_finite())).collect();
            column.typed::<DoubleType>().write_batch(&known, Some(&levels), None)?;
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

    use crate::io::export::table::tests::table;

    #[test]
    fn parquet_gives_back_every_bit_and_null_for_what_is_unknown() {
        let bytes = table().parquet().unwrap();
        let mut file = tempfile::tempfile().unwrap();
        std::io::Write::write_all(&mut file, &bytes).unwrap();
        let file = SerializedFileReader::new(file).unwrap();
        let rows: Vec<_> = file.into_iter().map(Result::unwrap).collect();
        assert_eq!((rows[0].get_long(0).unwrap(), rows[1].get_long(0).unwrap()), (7, 8));
        assert!(rows[0].get_double(2).is_err(), "null");
        assert_eq!(rows[1].get_double(2).unwrap().to_bits(), (1.0_f64 / 3.0).to_bits());
    }
}
