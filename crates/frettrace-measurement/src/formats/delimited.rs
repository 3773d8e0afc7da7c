//! Numbers in columns: CSV, TSV, semicolons or blanks, with or without headings, decimal point or comma.

use super::{Column, Format, Source, Table, name_and_unit};
use crate::error::{Error, Problem};

/// Delimited text.
pub(super) struct Delimited;

/// Lines looked at to find the delimiter and the first numbers.
const PREVIEW: usize = 200;

impl Format for Delimited {
    fn recognises(&self, source: &Source<'_>) -> bool {
        let head = &source.bytes[..source.bytes.len().min(4096)];
        !head.is_empty() && !head.contains(&0)
    }

    fn read(&self, source: &Source<'_>) -> Result<Table, Error> {
        let columns = read_body(source, &source.text())?;
        Ok(Table { format: "delimited text", columns, interval: None })
    }
}

/// The columns of a text, its headings included: also for formats that are delimited text behind a header.
pub(super) fn read_body(source: &Source<'_>, text: &str) -> Result<Vec<Column>, Error> {
    let layout = layout(text).ok_or_else(|| source.invalid("whole file", Problem::NoNumbers))?;
    let values = numbers(source, text, &layout)?;
    let columns = layout.headings.into_iter().zip(values);
    Ok(columns.map(|((name, unit), values)| Column { name, unit, values }).collect())
}

/// How the numbers stand in the text.
struct Layout {
    delimiter: Delimiter,
    decimal_comma: bool,
    /// The first line of numbers, from 0.
    first: usize,
    headings: Vec<(String, Option<String>)>,
}

#[derive(Clone, Copy, PartialEq)]
enum Delimiter {
    Byte(u8),
    Blanks,
}

impl Layout {
    fn byte(&self) -> u8 {
        match self.delimiter {
            Delimiter::Byte(byte) => byte,
            Delimiter::Blanks => b' ',
        }
    }

    /// A line with one delimiter between its fields.
    fn plain(&self, line: &str) -> String {
        match self.delimiter {
            Delimiter::Byte(_) => line.to_string(),
            Delimiter::Blanks => line.split_whitespace().collect::<Vec<_>>().join(" "),
        }
    }
}

fn split(line: &str, delimiter: Delimiter) -> Vec<&str> {
    match delimiter {
        Delimiter::Byte(byte) => line.trim_end_matches('\r').split(char::from(byte)).collect(),
        Delimiter::Blanks => line.split_whitespace().collect(),
    }
}

fn number(field: &str, decimal_comma: bool) -> Option<f64> {
    let field = field.trim().trim_matches('"').trim();
    if decimal_comma { field.replace(',', ".").parse().ok() } else { field.parse().ok() }
}

/// The layout under which the most lines of the beginning are rows of numbers.
fn layout(text: &str) -> Option<Layout> {
    let lines: Vec<&str> = text.lines().take(PREVIEW).collect();
    let tries = [
        (Delimiter::Byte(b'\t'), false),
        (Delimiter::Byte(b';'), false),
        (Delimiter::Byte(b','), false),
        (Delimiter::Byte(b'\t'), true),
        (Delimiter::Byte(b';'), true),
        (Delimiter::Blanks, false),
        (Delimiter::Blanks, true),
    ];
    // The most frequent width and how often it occurs: of two readings of the same lines the one with more columns
    // found the delimiter.
    let score = |&(delimiter, comma): &(Delimiter, bool)| {
        let widths: Vec<usize> = lines.iter().filter_map(|line| row_width(line, delimiter, comma)).collect();
        let count = |width: usize| widths.iter().filter(|&&other| other == width).count();
        widths.iter().map(|&width| (count(width), width)).max()
    };
    // Of equals `max_by_key` takes the last, so the list is turned: the first named wins.
    let best = tries.iter().rev().max_by_key(|attempt| score(attempt))?;
    let (_, width) = score(best)?;
    let (delimiter, decimal_comma) = *best;
    let first = lines.iter().position(|line| row_width(line, delimiter, decimal_comma) == Some(width))?;
    let headings = headings(&lines[..first], delimiter, width);
    Some(Layout { delimiter, decimal_comma, first, headings })
}

/// Number of fields of a line that holds numbers only.
fn row_width(line: &str, delimiter: Delimiter, decimal_comma: bool) -> Option<usize> {
    let fields = trimmed(split(line, delimiter));
    let numeric = !fields.is_empty() && fields.iter().all(|field| number(field, decimal_comma).is_some());
    numeric.then_some(fields.len())
}

/// Fields without the empty ones at the end of the line.
fn trimmed(mut fields: Vec<&str>) -> Vec<&str> {
    while fields.last().is_some_and(|field| field.trim().is_empty()) {
        fields.pop();
    }
    fields
}

/// Names and units: the last lines of the head that have as many fields as the numbers.
fn headings(head: &[&str], delimiter: Delimiter, width: usize) -> Vec<(String, Option<String>)> {
    let fits = |line: &&&str| {
        let fields = trimmed(split(line, delimiter));
        fields.len() == width && fields.iter().all(|field| !field.trim().is_empty())
    };
    let mut rows = head.iter().filter(fits).map(|line| split(line, delimiter));
    let (names, units) = (rows.next(), rows.next());
    let heading = |column: usize| {
        let Some(label) = names.as_ref().map(|names| names[column]) else {
            return ((column + 1).to_string(), None);
        };
        let (name, unit) = name_and_unit(label);
        let below = units.as_ref().map(|units| units[column].trim().to_string());
        (name, unit.or(below))
    };
    (0..width).map(heading).collect()
}

/// The numbers by column; a ragged or unreadable row is an error with its line.
fn numbers(source: &Source<'_>, text: &str, layout: &Layout) -> Result<Vec<Vec<f64>>, Error> {
    let body: String = text.lines().skip(layout.first).map(|line| layout.plain(line) + "\n").collect();
    let mut reader = csv::ReaderBuilder::new();
    let reader = reader.delimiter(layout.byte()).has_headers(false).flexible(true);
    let width = layout.headings.len();
    let mut columns = vec![Vec::new(); width];
    for record in reader.from_reader(body.as_bytes()).records() {
        let record = record.map_err(|error| {
            source.invalid("whole file", Problem::Malformed { reason: error.to_string() })
        })?;
        let line = record.position().map_or(0, csv::Position::line) + layout.first as u64;
        let place = || format!("line {line}");
        let fields = trimmed(record.iter().collect());
        if fields.is_empty() {
            continue;
        }
        if fields.len() != width {
            return Err(source.invalid(place(), Problem::Ragged { found: fields.len(), expected: width }));
        }
        for (column, field) in columns.iter_mut().zip(&fields) {
            let value = number(field, layout.decimal_comma);
            let bad = || source.invalid(place(), Problem::BadNumber { found: field.trim().to_string() });
            column.push(value.ok_or_else(bad)?);
        }
    }
    Ok(columns)
}
