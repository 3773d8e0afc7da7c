//! LabVIEW measurement files (`.lvm`): tab-separated text behind two headers.

use super::delimited::read_body;
use super::{Column, Format, Source, Table};
use crate::error::{Error, Problem};

/// LabVIEW measurement file.
pub(super) struct Lvm;

const END_OF_HEADER: &str = "***End_of_Header***";

impl Format for Lvm {
    fn recognises(&self, source: &Source<'_>) -> bool {
        source.bytes.starts_with(b"LabVIEW Measurement")
    }

    fn read(&self, source: &Source<'_>) -> Result<Table, Error> {
        let text = source.text();
        let malformed = |reason: &str| source.invalid("header", Problem::Malformed { reason: reason.into() });
        let lines: Vec<&str> = text.lines().collect();
        let last = lines.iter().rposition(|line| line.starts_with(END_OF_HEADER));
        let last = last.ok_or_else(|| malformed("there is no end of the header"))?;
        let decimal = field(&lines[..=last], "Decimal_Separator").first().copied().unwrap_or(".");
        let labels = lines.get(last + 1).ok_or_else(|| malformed("there are no channel names"))?;
        let separator =
            if field(&lines[..=last], "Separator").first() == Some(&"Comma") { ',' } else { '\t' };
        let labels: Vec<&str> =
            labels.split(separator).map(str::trim).filter(|label| *label != "Comment").collect();
        let body = blank_above(&lines, last + 2, separator, labels.len());
        let body = if decimal == "," { body.replace(',', ".") } else { body };
        let mut columns = read_body(source, &body)?;
        name(&mut columns, &labels, &field(&lines[..=last], "Y_Unit_Label"));
        let interval = field(&lines[..=last], "Delta_X").first().and_then(|text| text.parse().ok());
        Ok(Table { format: "LabVIEW measurement file", columns, interval })
    }
}

/// The values of a header line, by its key.
fn field<'a>(header: &[&'a str], key: &str) -> Vec<&'a str> {
    let line =
        header.iter().find_map(|line| line.strip_prefix(key).filter(|rest| rest.starts_with(['\t', ','])));
    let values = line.map(|rest| rest.trim_matches(['\t', ',']).split(['\t', ',']).map(str::trim));
    values.map(Iterator::collect).unwrap_or_default()
}

/// The lines below the headings, with the heading lines left blank so that line numbers stay those of the file, and
/// without the column of comments.
fn blank_above(lines: &[&str], first: usize, separator: char, width: usize) -> String {
    let mut body = "\n".repeat(first);
    for line in &lines[first.min(lines.len())..] {
        let end = line.match_indices(separator).nth(width.saturating_sub(1)).map_or(line.len(), |(at, _)| at);
        body.push_str(&line[..end]);
        body.push('\n');
    }
    body
}

/// Names and units: the first column is the abscissa, the units stand for the others.
fn name(columns: &mut [Column], labels: &[&str], units: &[&str]) {
    for (index, column) in columns.iter_mut().enumerate() {
        if let Some(label) = labels.get(index).filter(|label| !label.is_empty()) {
            column.name = label.to_string();
        }
        column.unit = match index {
            0 => Some("s".into()),
            _ => units.get(index - 1).filter(|unit| !unit.is_empty()).map(ToString::to_string),
        };
    }
}
