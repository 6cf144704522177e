//! Crops as Parquet, for Hugging Face's `datasets`: the images as PNG in a struct of `bytes` and `path`.

mod card;
mod columns;

use super::row::Row;
pub(super) use card::card;
use columns::{COLUMNS, Kind};
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnPath, Type};
use serde_json::{Map, json};
use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

/// A Parquet file under way.
pub(super) struct ParquetShard(SerializedFileWriter<File>);

impl std::fmt::Debug for ParquetShard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("ParquetShard")
    }
}

impl ParquetShard {
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        let file = File::create(path)?;
        let create = || {
            let fields = COLUMNS.iter().map(|column| column.kind.parquet_type(column.name));
            let fields = fields.collect::<Result<_, ParquetError>>()?;
            let schema = Type::group_type_builder("schema").with_fields(fields).build()?;
            SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties()))
        };
        create().map(Self).map_err(io_error)
    }

    /// Adds a row group.
    pub(super) fn add(&mut self, rows: &[Row]) -> io::Result<()> {
        if rows.is_empty() {
            return Ok(());
        }
        let mut add = || {
            let mut group = self.0.next_row_group()?;
            COLUMNS.iter().try_for_each(|column| column.kind.write(&mut group, rows))?;
            group.close()
        };
        add().map(drop).map_err(io_error)
    }

    pub(super) fn close(self) -> io::Result<()> {
        self.0.close().map(drop).map_err(io_error)
    }
}

/// PNG does not shrink further, and a dictionary of it would only cost.
fn properties() -> WriterProperties {
    let features: Map<_, _> =
        COLUMNS.iter().map(|column| (column.name.to_owned(), column.kind.feature())).collect();
    let features =
        KeyValue::new("huggingface".to_owned(), json!({"info": {"features": features}}).to_string());
    let builder = WriterProperties::builder()
        .set_compression(Compression::UNCOMPRESSED)
        .set_key_value_metadata(Some(vec![features]));
    let images = COLUMNS.iter().filter(|column| matches!(column.kind, Kind::Image(..)));
    let builder = images.fold(builder, |builder, column| {
        let bytes = ColumnPath::from(vec![column.name.to_owned(), "bytes".to_owned()]);
        builder
            .set_column_dictionary_enabled(bytes.clone(), false)
            .set_column_statistics_enabled(bytes, EnabledStatistics::None)
    });
    builder.build()
}

fn io_error(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(error) => match error.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(other) => io::Error::other(other),
        },
        other => io::Error::other(other),
    }
}
