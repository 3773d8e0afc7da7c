//! JSON arrays: named lists of numbers, or one list of rows, at any depth.

use serde_json::Value;

use super::{Column, Format, Source, Table};
use crate::error::{Error, Problem};

/// JSON.
pub(super) struct Json;

impl Format for Json {
    fn recognises(&self, source: &Source<'_>) -> bool {
        source
            .bytes
            .iter()
            .find(|byte| !byte.is_ascii_whitespace())
            .is_some_and(|byte| matches!(byte, b'{' | b'['))
    }

    fn read(&self, source: &Source<'_>) -> Result<Table, Error> {
        let value: Value = serde_json::from_slice(source.bytes).map_err(|error| {
            let place = format!("line {}, column {}", error.line(), error.column());
            source.invalid(place, Problem::Malformed { reason: "not JSON from here on".into() })
        })?;
        let mut columns = Vec::new();
        collect(source, "", &value, &mut columns)?;
        let interval = ["dt", "delta_t", "interval_s"].iter().find_map(|key| value.get(key)?.as_f64());
        Ok(Table { format: "JSON", columns, interval })
    }
}

/// Every list of numbers below a value, by its path.
fn collect(source: &Source<'_>, path: &str, value: &Value, columns: &mut Vec<Column>) -> Result<(), Error> {
    match value {
        Value::Object(members) => {
            for (key, member) in members {
                let inner = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                collect(source, &inner, member, columns)?;
            }
        }
        Value::Array(items) if items.first().is_some_and(Value::is_array) => {
            rows(source, path, items, columns)?
        }
        Value::Array(items) if items.first().is_some_and(Value::is_number) => {
            let numbers = items.iter().enumerate().map(|(row, item)| number(source, path, row, item));
            let values = numbers.collect::<Result<_, _>>()?;
            let name = if path.is_empty() { "1".to_string() } else { path.to_string() };
            columns.push(Column { name, unit: None, values });
        }
        _ => {}
    }
    Ok(())
}

/// A list of rows: a column a place in the row, named `path(1)`, or `1` where there is no path.
fn rows(source: &Source<'_>, path: &str, items: &[Value], columns: &mut Vec<Column>) -> Result<(), Error> {
    let width = items[0].as_array().map_or(0, Vec::len);
    let mut table = vec![Vec::with_capacity(items.len()); width];
    for (row, item) in items.iter().enumerate() {
        let fields = item.as_array().map(Vec::as_slice).unwrap_or_default();
        if fields.len() != width {
            let problem = Problem::Ragged { found: fields.len(), expected: width };
            return Err(source.invalid(format!("{path}[{row}]"), problem));
        }
        for (column, field) in table.iter_mut().zip(fields) {
            column.push(number(source, path, row, field)?);
        }
    }
    for (index, values) in table.into_iter().enumerate() {
        let name = if path.is_empty() { (index + 1).to_string() } else { format!("{path}[{}]", index + 1) };
        columns.push(Column { name, unit: None, values });
    }
    Ok(())
}

fn number(source: &Source<'_>, path: &str, row: usize, item: &Value) -> Result<f64, Error> {
    let bad = || source.invalid(format!("{path}[{row}]"), Problem::BadNumber { found: item.to_string() });
    item.as_f64().ok_or_else(bad)
}
