//! Rows of a campaign and other tables as Parquet files. The columns of the rows are the number of the flight, its
//! outcome, its drawn numbers and its figures. The metadata contain the identity of the campaign and the unit of each
//! column.

use crate::error::Error;
use crate::flight::{Outcome, Row, TIME};
use crate::plan::{Identity, Plan};
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::column::reader::get_typed_column_reader;
use parquet::data_type::{ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, RowGroupReader, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use serde_json::{Map, Value};
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

/// Metadata key of the campaign's identity.
const IDENTITY: &str = "squid.campaign";
/// Metadata key of the units.
const UNITS: &str = "squid.units";

/// Number of columns before the drawn numbers.
const FIRST: usize = 2;

/// Values of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Integers.
    Whole(Vec<i64>),
    /// Text.
    Words(Vec<&'static str>),
    /// Real numbers.
    Numbers(Vec<f64>),
}

/// Column of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name.
    pub name: String,
    /// Unit; empty for integers and text.
    pub unit: String,
    /// Values.
    pub values: Values,
}

/// Returns the bytes of a file of rows.
///
/// # Errors
/// [`Error::Parquet`].
pub fn bytes(plan: &Plan<'_>, rows: &[Row]) -> Result<Vec<u8>, Error> {
    let flights = rows.iter().map(|row| row.flight as i64).collect();
    let outcomes = rows.iter().map(|row| row.outcome.word()).collect();
    let first = [("flight", Values::Whole(flights)), ("outcome", Values::Words(outcomes))];
    let first = first.map(|(name, values)| Column { name: name.into(), unit: String::new(), values });
    let names = plan.drawn().into_iter().chain(plan.figures());
    let numbers = names.enumerate().map(|(index, (name, unit))| {
        let number = |row: &Row| row.drawn.iter().chain(&row.figures).nth(index).copied().unwrap_or(f64::NAN);
        Column { name, unit: unit.into(), values: Values::Numbers(rows.iter().map(number).collect()) }
    });
    file(plan, &first.into_iter().chain(numbers).collect::<Vec<_>>())
}

/// Returns the bytes of a file of columns.
///
/// # Errors
/// [`Error::Parquet`].
pub fn file(plan: &Plan<'_>, columns: &[Column]) -> Result<Vec<u8>, Error> {
    let field = |Column { name, values, .. }: &Column| {
        let (kind, logical) = match values {
            Values::Whole(_) => (Physical::INT64, None),
            Values::Words(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            Values::Numbers(_) => (Physical::DOUBLE, None),
        };
        let required = Type::primitive_type_builder(name, kind).with_repetition(Repetition::REQUIRED);
        required.with_logical_type(logical).build().map(Arc::new)
    };
    let fields = columns.iter().map(field).collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("flights").with_fields(fields).build()?;
    let numbers = columns.iter().filter(|column| matches!(column.values, Values::Numbers(_)));
    let units: Map<String, Value> = numbers.map(|one| (one.name.clone(), one.unit.clone().into())).collect();
    let identity =
        serde_json::to_string(&plan.identity).map_err(|why| ParquetError::General(why.to_string()))?;
    let metadata = vec![
        KeyValue::new(IDENTITY.to_owned(), identity),
        KeyValue::new(UNITS.to_owned(), Value::Object(units).to_string()),
    ];
    let properties = WriterProperties::builder().set_key_value_metadata(Some(metadata)).build();
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for column in columns {
        match &column.values {
            Values::Whole(values) => add::<Int64Type>(&mut group, values)?,
            Values::Words(texts) => {
                add::<ByteArrayType>(
                    &mut group,
                    &texts.iter().map(|text| (*text).into()).collect::<Vec<_>>(),
                )?;
            }
            Values::Numbers(values) => add::<DoubleType>(&mut group, values)?,
        }
    }
    group.close()?;
    Ok(writer.into_inner()?)
}

fn add<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, Vec<u8>>,
    values: &[T::T],
) -> Result<(), ParquetError> {
    if let Some(mut column) = group.next_column()? {
        column.typed::<T>().write_batch(values, None, None)?;
        column.close()?;
    }
    Ok(())
}

/// Reads the rows of a file, and the identity of their campaign.
///
/// # Errors
/// [`Error::Results`].
pub fn read(path: &Path) -> Result<(Identity, Vec<Row>), Error> {
    let invalid = |reason: String| Error::Results { path: path.display().to_string(), reason };
    let file = squid_base::files::open(path)?;
    rows(&SerializedFileReader::new(file).map_err(|why| invalid(why.to_string()))?).map_err(invalid)
}

/// Reads the values of a column.
fn column<T: DataType>(
    group: &dyn RowGroupReader,
    index: usize,
    count: usize,
) -> Result<Vec<T::T>, ParquetError> {
    let mut values = Vec::new();
    get_typed_column_reader::<T>(group.get_column_reader(index)?).read_records(
        count,
        None,
        None,
        &mut values,
    )?;
    Ok(values)
}

fn rows(reader: &SerializedFileReader<File>) -> Result<(Identity, Vec<Row>), String> {
    let message = |why: ParquetError| why.to_string();
    let metadata = reader.metadata().file_metadata();
    let pairs = metadata.key_value_metadata().map_or(&[][..], Vec::as_slice);
    let text = pairs.iter().find(|pair| pair.key == IDENTITY).and_then(|pair| pair.value.as_ref());
    let text = text.ok_or_else(|| format!("its metadata do not contain '{IDENTITY}'"))?;
    let identity = serde_json::from_str(text).map_err(|why| format!("'{IDENTITY}': {why}"))?;
    let columns = metadata.schema_descr().num_columns();
    let is_first = |column: &usize| metadata.schema_descr().column(*column).name() == TIME.0;
    let drawn = (FIRST..columns).position(|column| is_first(&column));
    let drawn = drawn.ok_or_else(|| format!("it has no column '{}'", TIME.0))?;
    let mut all = Vec::new();
    for index in 0..reader.num_row_groups() {
        let group = reader.get_row_group(index).map_err(message)?;
        let count = usize::try_from(group.metadata().num_rows()).map_err(|why| why.to_string())?;
        let flights = column::<Int64Type>(&*group, 0, count).map_err(message)?;
        let outcomes = column::<ByteArrayType>(&*group, 1, count).map_err(message)?;
        let numbers = (FIRST..columns).map(|index| column::<DoubleType>(&*group, index, count));
        let numbers = numbers.collect::<Result<Vec<_>, _>>().map_err(message)?;
        for (k, (flight, word)) in flights.iter().zip(&outcomes).enumerate() {
            let word = word.as_utf8().map_err(message)?;
            let outcome = Outcome::ALL.into_iter().find(|outcome| outcome.word() == word);
            let values: Vec<f64> = numbers.iter().map(|values| values[k]).collect();
            all.push(Row {
                flight: u64::try_from(*flight).map_err(|why| why.to_string())?,
                outcome: outcome.ok_or_else(|| format!("the outcome '{word}' is unknown"))?,
                drawn: values[..drawn].to_vec(),
                figures: values[drawn..].to_vec(),
            });
        }
    }
    Ok((identity, all))
}
