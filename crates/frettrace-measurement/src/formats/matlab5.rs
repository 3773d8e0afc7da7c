//! MATLAB files up to version 7.2 (`-v6`, `-v7`, "level 5"): numeric arrays and the fields of structures.
//!
//! Layout: "MAT-File Format" (The MathWorks), chapter 1: a header of 128 bytes, then elements of a tag (type, bytes) and
//! data; a matrix is an element of elements. The crate `matfile` 0.5 was tried: it leaves out an array cut short without
//! a word and prints to the standard output, where the program's JSON goes.

use std::io::Read;

use super::{Column, Format, Source, Table};
use crate::error::{Error, Problem};

/// MATLAB version 5.
pub(super) struct Matlab5;

const HEADER: usize = 128;
/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Class of a structure; classes 6 to 15 are the number types.
const STRUCTURE: u8 = 2;
const NUMERIC: std::ops::RangeInclusive<u8> = 6..=15;
/// A compressed array is at most this much longer than its stored bytes (zlib: 1032).
const MOST_EXPANSION: u64 = 1100;
/// Structures in structures beyond this are a damaged file.
const MAX_DEPTH: usize = 8;

impl Format for Matlab5 {
    fn recognises(&self, source: &Source<'_>) -> bool {
        let mark = source.bytes.get(124..HEADER);
        mark.is_some_and(|mark| mark == [0, 1, b'I', b'M'] || mark == [1, 0, b'M', b'I'])
    }

    fn read(&self, source: &Source<'_>) -> Result<Table, Error> {
        let order = Order { little: source.bytes[126] == b'I' };
        let mut columns = Vec::new();
        let mut rest = &source.bytes[HEADER..];
        while !rest.is_empty() {
            let element =
                element(order, &mut rest).and_then(|element| top_level(order, element, &mut columns));
            let reason = "an array is cut short or damaged".to_string();
            element.ok_or_else(|| source.invalid("whole file", Problem::Malformed { reason }))?;
        }
        Ok(Table { format: "MATLAB version 5", columns, interval: None })
    }
}

/// Byte order of the file.
#[derive(Clone, Copy)]
struct Order {
    little: bool,
}

impl Order {
    /// An unsigned number of up to eight bytes.
    fn unsigned(self, bytes: &[u8]) -> u64 {
        let join = |value: u64, &byte: &u8| (value << 8) | u64::from(byte);
        if self.little { bytes.iter().rev().fold(0, join) } else { bytes.iter().fold(0, join) }
    }

    fn word(self, bytes: &[u8]) -> Option<u32> {
        u32::try_from(self.unsigned(bytes.get(..4)?)).ok()
    }
}

/// An element: its type and data.
struct Element<'a> {
    kind: u32,
    data: &'a [u8],
}

/// Takes the next element; `None` where it is cut short.
fn element<'a>(order: Order, rest: &mut &'a [u8]) -> Option<Element<'a>> {
    let tag = order.word(rest)?;
    // A small element has its length in the upper half of the type and its data in the tag.
    if tag >> 16 != 0 {
        let (kind, length) = (tag & 0xffff, (tag >> 16) as usize);
        let data = rest.get(4..4 + length).filter(|_| length <= 4)?;
        *rest = rest.get(8..)?;
        return Some(Element { kind, data });
    }
    let length = order.word(rest.get(4..)?)? as usize;
    let data = rest.get(8..8 + length)?;
    // Elements are padded to 8 bytes, compressed ones and the last of a file are not.
    let padded = if tag == COMPRESSED { length } else { length.next_multiple_of(8) };
    *rest = rest.get(8 + padded..).unwrap_or_default();
    Some(Element { kind: tag, data })
}

fn top_level(order: Order, found: Element<'_>, columns: &mut Vec<Column>) -> Option<()> {
    if found.kind != COMPRESSED {
        return matrix(order, &found, None, columns);
    }
    let mut bytes = Vec::new();
    let most = (found.data.len() as u64).saturating_mul(MOST_EXPANSION);
    flate2::read::ZlibDecoder::new(found.data).take(most).read_to_end(&mut bytes).ok()?;
    matrix(order, &element(order, &mut bytes.as_slice())?, None, columns)
}

/// The columns of a matrix. `path` is the structure it is a field of, with the field's name.
fn matrix(order: Order, found: &Element<'_>, path: Option<&str>, columns: &mut Vec<Column>) -> Option<()> {
    if found.kind != MATRIX || found.data.is_empty() {
        return Some(());
    }
    let mut rest = found.data;
    let flags = element(order, &mut rest)?;
    let class = (order.word(flags.data)? & 0xff) as u8;
    let dimensions = element(order, &mut rest)?;
    let size: Vec<usize> =
        dimensions.data.chunks_exact(4).map(|bytes| order.unsigned(bytes) as usize).collect();
    let name = String::from_utf8_lossy(element(order, &mut rest)?.data).into_owned();
    let name = path.map_or(name, ToString::to_string);
    if NUMERIC.contains(&class) {
        let values = numbers(order, &element(order, &mut rest)?)?;
        // Fewer or more values than the size says: damaged. A scalar or empty array is no channel.
        let announced = size.iter().try_fold(1usize, |all, &n| all.checked_mul(n))?;
        (announced == values.len()).then(|| columns.extend(self::columns(&name, &size, &values)))
    } else if class == STRUCTURE && name.matches('.').count() < MAX_DEPTH {
        structure(order, rest, &name, columns)
    } else {
        Some(())
    }
}

/// The fields of a structure, `structure.field`.
fn structure(order: Order, mut rest: &[u8], name: &str, columns: &mut Vec<Column>) -> Option<()> {
    let width = order.word(element(order, &mut rest)?.data)? as usize;
    let names = element(order, &mut rest)?;
    let fields = names.data.chunks_exact(width.max(1)).map(|field| {
        let end = field.iter().position(|&byte| byte == 0).unwrap_or(field.len());
        String::from_utf8_lossy(&field[..end]).into_owned()
    });
    for field in fields {
        if rest.is_empty() {
            break;
        }
        matrix(order, &element(order, &mut rest)?, Some(&format!("{name}.{field}")), columns)?;
    }
    Some(())
}

/// Numbers of an element in any of the number types: MATLAB stores whole numbers in the shortest that holds them.
fn numbers(order: Order, found: &Element<'_>) -> Option<Vec<f64>> {
    let (width, decode): (usize, fn(u64) -> f64) = match found.kind {
        1 => (1, |bits| f64::from(bits as u8 as i8)),
        2 => (1, |bits| bits as f64),
        3 => (2, |bits| f64::from(bits as u16 as i16)),
        4 => (2, |bits| bits as f64),
        5 => (4, |bits| f64::from(bits as u32 as i32)),
        6 => (4, |bits| bits as f64),
        7 => (4, |bits| f64::from(f32::from_bits(bits as u32))),
        9 => (8, f64::from_bits),
        12 => (8, |bits| bits as i64 as f64),
        13 => (8, |bits| bits as f64),
        _ => return None,
    };
    Some(found.data.chunks_exact(width).map(|bytes| decode(order.unsigned(bytes))).collect())
}

/// A variable as columns: a vector is one, a matrix one a column, named `x(:,2)`; scalars and empties are left out.
pub(super) fn columns(name: &str, size: &[usize], values: &[f64]) -> Vec<Column> {
    let column = |name: String, values: &[f64]| Column { name, unit: None, values: values.to_vec() };
    let rows = size.first().copied().unwrap_or(0);
    let announced = size.iter().try_fold(1usize, |all, &n| all.checked_mul(n));
    if values.len() < 2 || announced != Some(values.len()) {
        return Vec::new();
    }
    if rows == values.len() || rows == 1 {
        return vec![column(name.to_string(), values)];
    }
    let numbered = values.chunks_exact(rows).enumerate();
    numbered.map(|(index, chunk)| column(format!("{name}(:,{})", index + 1), chunk)).collect()
}
