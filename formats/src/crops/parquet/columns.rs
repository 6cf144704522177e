//! The columns of a crop: what each holds, and its names in Parquet and at Hugging Face.

use super::super::row::Row;
use parquet::basic::{ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::{ParquetError, Result};
use parquet::file::writer::{SerializedColumnWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};
use serde_json::{Value, json};
use std::fs::File;
use std::sync::Arc;
use vantage_dataset::store::pose_fields;

/// How a column's value is had from a row.
///
/// Every column is declared optional, as the readers' own writers do; only `Optional` ones hold nulls.
pub(super) enum Kind {
    /// A PNG, and the ending of its name.
    Image(fn(&Row) -> &[u8], &'static str),
    Text(fn(&Row) -> String),
    Integer(fn(&Row) -> u64),
    Number(fn(&Row) -> Option<f64>),
    /// A list of `tx, ty, tz, qx, qy, qz, qw`.
    Pose(fn(&Row) -> [f64; 7]),
}

/// One column of the table.
pub(super) struct Column {
    pub(super) name: &'static str,
    /// For people.
    pub(super) meaning: &'static str,
    pub(super) kind: Kind,
}

pub(super) const COLUMNS: [Column; 27] = [
    column("key", "episode, step and track", Kind::Text(|row| row.key.clone())),
    column("masked", "the crop with all but the object black", Kind::Image(|row| &row.masked, "masked.png")),
    column("boxed", "the crop with its surroundings", Kind::Image(|row| &row.boxed, "boxed.png")),
    column("episode", "seed of the episode", Kind::Integer(|row| row.sample.episode)),
    column("step", "step of the episode", Kind::Integer(|row| row.sample.step as u64)),
    column("timestamp", "seconds since the episode's start", Kind::Number(|row| Some(row.sample.timestamp))),
    column("track", "index of the object in its episode", Kind::Integer(|row| row.sample.track as u64)),
    column("instance", "the object: equal ids look equal", Kind::Text(|row| row.sample.instance.to_string())),
    column("family", "its family", Kind::Text(|row| row.sample.family.clone())),
    column(
        "min_x",
        "left edge of the box as detected, pixels: the visible mask's, unless the scene's detector jitters",
        Kind::Number(|row| Some(row.sample.bounding_box.min.x)),
    ),
    column("min_y", "top edge", Kind::Number(|row| Some(row.sample.bounding_box.min.y))),
    column("max_x", "right edge, exclusive", Kind::Number(|row| Some(row.sample.bounding_box.max.x))),
    column("max_y", "bottom edge, exclusive", Kind::Number(|row| Some(row.sample.bounding_box.max.y))),
    column(
        "visible_fraction",
        "visible share of the silhouette",
        Kind::Number(|row| Some(row.sample.visible_fraction)),
    ),
    column(
        "image_width",
        "of the image that the box is in, pixels",
        Kind::Integer(|row| row.sample.camera.width.into()),
    ),
    column("image_height", "likewise", Kind::Integer(|row| row.sample.camera.height.into())),
    column("fx", "focal length along x, pixels", Kind::Number(|row| Some(row.sample.camera.fx))),
    column("fy", "focal length along y, pixels", Kind::Number(|row| Some(row.sample.camera.fy))),
    column(
        "cx",
        "principal point, x, pixels; pixel centres at +0.5",
        Kind::Number(|row| Some(row.sample.camera.cx)),
    ),
    column("cy", "principal point, y, pixels", Kind::Number(|row| Some(row.sample.camera.cy))),
    column(
        "world_from_camera",
        "`tx, ty, tz, qx, qy, qz, qw`, metres; the camera looks along +z, x right, y down",
        Kind::Pose(|row| pose_fields(&row.sample.world_from_camera)),
    ),
    column(
        "object_from_camera",
        "the camera in the object's frame",
        Kind::Pose(|row| pose_fields(&row.sample.object_from_camera)),
    ),
    column(
        "direction_x",
        "unit vector from object to camera, object frame; none where the viewpoint is undefined",
        Kind::Number(|row| row.sample.viewpoint.map(|v| v.direction.x)),
    ),
    column("direction_y", "likewise", Kind::Number(|row| row.sample.viewpoint.map(|v| v.direction.y))),
    column("direction_z", "likewise", Kind::Number(|row| row.sample.viewpoint.map(|v| v.direction.z))),
    column(
        "roll",
        "about the viewing ray, radians",
        Kind::Number(|row| row.sample.viewpoint.map(|v| v.roll)),
    ),
    column(
        "log_distance",
        "logarithm of distance over object size",
        Kind::Number(|row| row.sample.viewpoint.map(|v| v.log_distance)),
    ),
];

const fn column(name: &'static str, meaning: &'static str, kind: Kind) -> Column {
    Column { name, meaning, kind }
}

impl Kind {
    /// The column's type in Parquet.
    pub(super) fn parquet_type(&self, name: &str) -> Result<TypePtr> {
        let text = |name| leaf(name, Physical::BYTE_ARRAY, Some(LogicalType::String));
        match self {
            Self::Image(..) => {
                group(name, vec![leaf("bytes", Physical::BYTE_ARRAY, None)?, text("path")?], None)
            }
            Self::Text(_) => text(name),
            Self::Integer(_) => leaf(name, Physical::INT64, Some(LogicalType::integer(64, false))),
            Self::Number(_) => leaf(name, Physical::DOUBLE, None),
            Self::Pose(_) => {
                let element = leaf("element", Physical::DOUBLE, None)?;
                let list = Type::group_type_builder("list")
                    .with_repetition(Repetition::REPEATED)
                    .with_fields(vec![element])
                    .build()?;
                group(name, vec![Arc::new(list)], Some(ConvertedType::LIST))
            }
        }
    }

    /// The column's type in the metadata of Hugging Face's `datasets`.
    pub(super) fn feature(&self) -> Value {
        let value = |dtype| json!({"dtype": dtype, "_type": "Value"});
        match self {
            Self::Image(..) => json!({"_type": "Image"}),
            Self::Text(_) => value("string"),
            Self::Integer(_) => value("uint64"),
            Self::Number(_) => value("float64"),
            Self::Pose(_) => json!({"feature": value("float64"), "_type": "Sequence"}),
        }
    }

    /// The column's type in the head of a card.
    pub(super) fn yaml(&self) -> &'static str {
        match self {
            Self::Image(..) => "dtype: image",
            Self::Text(_) => "dtype: string",
            Self::Integer(_) => "dtype: uint64",
            Self::Number(_) => "dtype: float64",
            Self::Pose(_) => "sequence: float64",
        }
    }

    /// Writes the values of a row group.
    pub(super) fn write(&self, group: &mut SerializedRowGroupWriter<'_, File>, rows: &[Row]) -> Result<()> {
        match self {
            Self::Image(get, ending) => {
                let bytes = rows.iter().map(|row| ByteArray::from(get(row).to_vec())).collect::<Vec<_>>();
                put::<ByteArrayType>(group, &bytes, &vec![2; rows.len()], None)?;
                let paths = rows.iter().map(|row| text(format!("{}.{ending}", row.key))).collect::<Vec<_>>();
                put::<ByteArrayType>(group, &paths, &vec![2; rows.len()], None)
            }
            Self::Text(get) => {
                let values: Vec<_> = rows.iter().map(|row| text(get(row))).collect();
                put::<ByteArrayType>(group, &values, &vec![1; rows.len()], None)
            }
            Self::Integer(get) => {
                let values: Vec<_> = rows.iter().map(|row| get(row) as i64).collect();
                put::<Int64Type>(group, &values, &vec![1; rows.len()], None)
            }
            Self::Number(get) => {
                let present: Vec<_> = rows.iter().map(|row| i16::from(get(row).is_some())).collect();
                let values: Vec<_> = rows.iter().filter_map(get).collect();
                put::<DoubleType>(group, &values, &present, None)
            }
            Self::Pose(get) => {
                let values: Vec<_> = rows.iter().flat_map(get).collect();
                let starts: Vec<_> = (0..values.len()).map(|i| i16::from(i % 7 != 0)).collect();
                put::<DoubleType>(group, &values, &vec![3; values.len()], Some(&starts))
            }
        }
    }
}

fn text(text: String) -> ByteArray {
    ByteArray::from(text.into_bytes())
}

fn leaf(name: &str, physical: Physical, logical: Option<LogicalType>) -> Result<TypePtr> {
    let builder = Type::primitive_type_builder(name, physical);
    Ok(Arc::new(builder.with_repetition(Repetition::OPTIONAL).with_logical_type(logical).build()?))
}

fn group(name: &str, fields: Vec<TypePtr>, converted: Option<ConvertedType>) -> Result<TypePtr> {
    let builder = Type::group_type_builder(name).with_repetition(Repetition::OPTIONAL).with_fields(fields);
    let logical = converted.map(|_| LogicalType::List);
    let builder = builder.with_converted_type(converted.unwrap_or(ConvertedType::NONE));
    Ok(Arc::new(builder.with_logical_type(logical).build()?))
}

fn put<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, File>,
    values: &[T::T],
    definitions: &[i16],
    repetitions: Option<&[i16]>,
) -> Result<()> {
    let missing = || ParquetError::General("fewer columns in the schema than in the table".to_owned());
    let mut column: SerializedColumnWriter<'_> = group.next_column()?.ok_or_else(missing)?;
    column.typed::<T>().write_batch(values, Some(definitions), repetitions)?;
    column.close()
}
