//! Universal file format, dataset 58 (functions at nodes), as text and binary (58b).
//!
//! Layout: Structural Dynamics Research Corporation's description of dataset 58, as kept by the University of
//! Cincinnati (<https://www.ceas3.uc.edu/sdrluff/>): 11 records of 80 characters, then the ordinates.

use super::{Column, Format, Source, Table};
use crate::error::{Error, Problem};

/// Universal file format, dataset 58.
pub(super) struct Uff58;

/// Records before the ordinates.
const RECORDS: usize = 11;

impl Format for Uff58 {
    fn recognises(&self, source: &Source<'_>) -> bool {
        let head = String::from_utf8_lossy(&source.bytes[..source.bytes.len().min(400)]).into_owned();
        let mut lines = head.lines().skip_while(|line| line.trim().is_empty());
        lines.next().is_some_and(|line| line.trim() == "-1")
    }

    fn read(&self, source: &Source<'_>) -> Result<Table, Error> {
        let mut columns: Vec<Column> = Vec::new();
        let mut interval = None;
        for block in blocks(source.bytes) {
            let place = format!("dataset 58 number {}", columns.len() + 1);
            let malformed =
                |reason: &str| source.invalid(place.as_str(), Problem::Malformed { reason: reason.into() });
            let block =
                Block::parse(block).ok_or_else(|| malformed("a header line is missing or unreadable"))?;
            let values = block.ordinates().ok_or_else(|| malformed("a value is not a number"))?;
            if values.len() < block.count {
                let problem = Problem::CutShort { found: values.len(), expected: block.count };
                return Err(source.invalid(place, problem));
            }
            let uneven = block.abscissae();
            if let Some(values) = uneven.filter(|_| columns.is_empty()) {
                columns.push(Column { name: "abscissa".into(), unit: Some("s".into()), values });
            }
            interval = interval.or(block.interval());
            columns.push(Column { name: block.name(columns.len() + 1), unit: block.unit.clone(), values });
        }
        Ok(Table { format: "UFF dataset 58", columns, interval })
    }
}

/// One dataset 58.
struct Block {
    /// Identification lines.
    identification: Vec<String>,
    /// Ordinate data type: 2 and 4 real, 5 and 6 complex; 2 and 5 of single precision.
    kind: u32,
    count: usize,
    even: bool,
    increment: f64,
    node: String,
    unit: Option<String>,
    data: Data,
}

enum Data {
    Text(String),
    Binary { bytes: Vec<u8>, big_endian: bool },
}

/// The bodies between pairs of `-1` lines that begin with `58`.
fn blocks(bytes: &[u8]) -> Vec<&[u8]> {
    let mut found = Vec::new();
    let mut rest = bytes;
    while let Some(start) = find_mark(rest) {
        let body = &rest[start..];
        let first = body.split(|&byte| byte == b'\n').next().unwrap_or_default();
        let skip =
            binary_length(first, body).map_or(0, |length| header_length(body) + length).min(body.len());
        let end = find_mark(&body[skip..]).map_or(body.len(), |at| skip + at);
        if String::from_utf8_lossy(first).trim_start().starts_with("58") {
            found.push(&body[..end]);
        }
        rest = &body[end..];
    }
    found
}

/// The byte after the next line that holds `-1` alone.
fn find_mark(bytes: &[u8]) -> Option<usize> {
    let mut start = 0;
    for line in bytes.split_inclusive(|&byte| byte == b'\n') {
        let end = start + line.len();
        if line.trim_ascii() == b"-1" {
            return Some(end);
        }
        start = end;
    }
    None
}

/// Bytes of ordinates behind a `58b` line. The line announces them, but writers get complex and uneven data wrong:
/// the count in record 7 decides.
fn binary_length(first: &[u8], body: &[u8]) -> Option<usize> {
    if !first.trim_ascii_start().starts_with(b"58b") {
        return None;
    }
    let header = String::from_utf8_lossy(&body[..header_length(body)]).into_owned();
    let mut form = header.lines().nth(7)?.split_whitespace();
    let (kind, count): (u32, usize) = (form.next()?.parse().ok()?, form.next()?.parse().ok()?);
    let size = if matches!(kind, 4 | 6) { 8 } else { 4 };
    count.checked_mul(size * stride(kind, form.next()? == "1"))
}

/// Numbers a sample: an abscissa where the spacing is uneven, one or two ordinates.
fn stride(kind: u32, even: bool) -> usize {
    usize::from(!even) + if kind >= 5 { 2 } else { 1 }
}

/// Bytes of the `58b` line and the 11 records below it.
fn header_length(body: &[u8]) -> usize {
    body.split_inclusive(|&byte| byte == b'\n').take(RECORDS + 1).map(<[u8]>::len).sum()
}

impl Block {
    fn parse(body: &[u8]) -> Option<Self> {
        let header = String::from_utf8_lossy(&body[..header_length(body)]).into_owned();
        let lines: Vec<&str> = header.lines().collect();
        let form: Vec<&str> = lines.get(7)?.split_whitespace().collect();
        let axis = |index: usize| lines.get(index).and_then(|line| axis_unit(line));
        let data = &body[header_length(body)..];
        let data = match binary_length(lines.first()?.as_bytes(), body) {
            Some(length) => {
                let big_endian =
                    lines.first()?.trim_start().strip_prefix("58b")?.split_whitespace().next()? == "2";
                Data::Binary { bytes: data[..length.min(data.len())].to_vec(), big_endian }
            }
            None => Data::Text(String::from_utf8_lossy(data).into_owned()),
        };
        Some(Self {
            identification: lines.get(1..6)?.iter().map(|line| line.trim().to_string()).collect(),
            kind: form.first()?.parse().ok()?,
            count: form.get(1)?.parse().ok()?,
            even: *form.get(2)? == "1",
            increment: fortran(form.get(4)?)?,
            node: node(lines.get(6)?),
            unit: axis(9),
            data,
        })
    }

    fn interval(&self) -> Option<f64> {
        (self.even && self.increment > 0.0).then_some(self.increment)
    }

    fn name(&self, number: usize) -> String {
        let label = self.identification.iter().find(|line| !line.is_empty() && *line != "NONE");
        match label {
            Some(label) if !self.node.trim().is_empty() => format!("{label} {}", self.node),
            Some(label) => label.clone(),
            None => number.to_string(),
        }
    }

    /// The (real parts of the) ordinates.
    fn ordinates(&self) -> Option<Vec<f64>> {
        let skip = usize::from(!self.even);
        let values = self.numbers()?;
        Some(values.into_iter().skip(skip).step_by(stride(self.kind, self.even)).take(self.count).collect())
    }

    /// The abscissae where they are not evenly spaced.
    fn abscissae(&self) -> Option<Vec<f64>> {
        let values = if self.even { None } else { self.numbers() };
        Some(values?.into_iter().step_by(stride(self.kind, self.even)).take(self.count).collect())
    }

    fn numbers(&self) -> Option<Vec<f64>> {
        let double = matches!(self.kind, 4 | 6);
        match &self.data {
            Data::Text(text) => {
                let parted = part(text);
                parted.split_whitespace().take_while(|field| *field != "-1").map(fortran).collect()
            }
            Data::Binary { bytes, big_endian } if double => {
                let read = if *big_endian { f64::from_be_bytes } else { f64::from_le_bytes };
                Some(bytes.as_chunks::<8>().0.iter().map(|&chunk| read(chunk)).collect())
            }
            Data::Binary { bytes, big_endian } => {
                let read = if *big_endian { f32::from_be_bytes } else { f32::from_le_bytes };
                Some(bytes.as_chunks::<4>().0.iter().map(|&chunk| f64::from(read(chunk))).collect())
            }
        }
    }
}

/// Parts fields that touch: a sign behind a digit begins the next number.
fn part(text: &str) -> String {
    let mut parted = String::with_capacity(text.len() + text.len() / 8);
    let mut before = ' ';
    for letter in text.chars() {
        if matches!(letter, '-' | '+') && (before.is_ascii_digit() || before == '.') {
            parted.push(' ');
        }
        parted.push(letter);
        before = letter;
    }
    parted
}

/// A number as Fortran writes it: `1.5D-03` too.
fn fortran(field: &str) -> Option<f64> {
    field.replace(['D', 'd'], "E").parse().ok()
}

/// Node and direction of the response, `12:3`: columns 42 to 51 and 52 to 55 of record 6.
fn node(line: &str) -> String {
    let field = |start: usize, end: usize| {
        line.get(start..end.min(line.len())).unwrap_or_default().trim().to_string()
    };
    let (node, direction) = (field(41, 51), field(51, 55));
    if node.is_empty() { node } else { format!("{node}:{direction}") }
}

/// The unit label of an axis record: columns 48 to 67.
fn axis_unit(line: &str) -> Option<String> {
    let unit = line.get(47..67.min(line.len()))?.trim();
    (!unit.is_empty() && unit != "NONE").then(|| unit.to_string())
}
