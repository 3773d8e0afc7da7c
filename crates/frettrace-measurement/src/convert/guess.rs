//! A first description, proposed from what a file looks like.

use std::fmt::Write;
use std::path::Path;

use super::channels::file_name;
use super::sampling::{first_not_rising, uniform_rate};
use crate::error::Error;
use crate::formats::{Column, Table, read_table};
use crate::units::{ACCELERATION, Dimension, FORCE, LENGTH, TIME, VELOCITY, unit};

/// Proposes the description of a laboratory's file: a TOML text to look through and correct.
///
/// # Errors
/// As [`crate::read_table`].
pub fn guess(path: impl AsRef<Path>) -> Result<String, Error> {
    let path = path.as_ref();
    let table = read_table(path)?;
    let kinds: Vec<Guess> =
        table.columns.iter().enumerate().map(|(index, column)| of_column(index, column)).collect();
    let contact = kinds.contains(&Guess::Displacement);
    let mut text = head(&table, contact);
    channels(&mut text, &table, &kinds, contact);
    if contact {
        let _ = writeln!(
            text,
            "\n[[runs]]\nfile = {}\n# label, from = \"… s\", to = \"… s\", preload = \"… N\"",
            quoted(&file_name(path))
        );
    } else {
        text.push_str(RIG);
        let _ = writeln!(
            text,
            "[[runs]]\nfile = {}\nexcitation_frequency = \"… Hz\"\npreload = \"… N\"",
            quoted(&file_name(path))
        );
    }
    Ok(text)
}

/// A text as TOML writes it: names of files may hold quotation marks.
fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

const RIG: &str = r#"
[beam]
length = "… mm"
width = "… mm"
thickness = "… mm"
youngs_modulus = "… GPa"
density = "… kg/m^3"

[support]
position = "… mm"
slip = "rotation"            # or "transverse"
lever_arm = "… mm"
normal_stiffness = "… N/m"   # or "infinite"

[exciter]
position = "… mm"

"#;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Guess {
    Time,
    Force,
    NormalForce,
    Displacement,
    Velocity,
    Acceleration,
    Unknown,
}

fn head(table: &Table, contact: bool) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "# Proposed from a file of format {}: look at every line marked with … or ?.",
        table.format
    );
    for (index, column) in table.columns.iter().enumerate() {
        let (low, high) =
            column.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        let unit = column.unit.as_deref().map_or(String::new(), |unit| format!(" [{unit}]"));
        let name = column.name.as_str();
        let _ = writeln!(
            text,
            "#   column {} \"{name}\"{unit}: {} values from {low} to {high}",
            index + 1,
            column.values.len()
        );
    }
    let kind = if contact { "contact" } else { "measurement" };
    let _ = writeln!(text, "kind = \"{kind}\"\ntitle = \"…\"\nlaw = \"dahl\"");
    if contact {
        text.push_str("slip_unit = \"m\"\n");
    }
    if let Some(interval) = table.interval {
        let _ = writeln!(text, "sampling_rate = \"{} Hz\"   # the file's own", 1.0 / interval);
    }
    text
}

fn channels(text: &mut String, table: &Table, kinds: &[Guess], contact: bool) {
    text.push_str("\n[channels]\n");
    let entry = |index: usize, fallback: &str| {
        let unit = table.columns[index].unit.clone().filter(|text| unit(text).is_some());
        let doubt = if unit.is_some() { "" } else { "   # unit?" };
        (format!("column = {}, unit = \"{}\"", index + 1, unit.unwrap_or_else(|| fallback.into())), doubt)
    };
    let single = [
        (Guess::Time, "time", "s", true),
        (Guess::Force, "force", "N", true),
        (Guess::NormalForce, "normal_force", "N", contact),
        (Guess::Displacement, "slip_displacement", "mm", contact),
        (Guess::Velocity, "slip_velocity", "mm/s", contact),
        (Guess::Acceleration, "slip_acceleration", "m/s^2", contact),
    ];
    for (kind, name, fallback, _) in single.into_iter().filter(|(.., used)| *used) {
        match kinds.iter().position(|known| *known == kind) {
            Some(index) => {
                let (entry, doubt) = entry(index, fallback);
                let _ = writeln!(text, "{name} = {{ {entry} }}{doubt}");
            }
            None if kind == Guess::Force => {
                text.push_str("force = { column = …, unit = \"N\" }   # not recognised\n")
            }
            None => {}
        }
    }
    if let Some(index) = kinds.iter().position(|kind| *kind == Guess::Time)
        && uniform_rate(&table.columns[index].values).is_none()
    {
        text.push_str("# sampling is uneven: it is kept, or add at the top  resample = { rate = \"… Hz\", method = \"linear\" }\n");
    }
    for index in (0..kinds.len()).filter(|&index| !contact && kinds[index] == Guess::Acceleration) {
        let (entry, doubt) = entry(index, "m/s^2");
        let lines = entry.replace(", ", "\n");
        let _ = writeln!(text, "\n[[channels.acceleration]]\n{lines}{doubt}\nposition = \"… mm\"");
    }
}

/// What a column is, by its name, else its unit, else its numbers.
fn of_column(index: usize, column: &Column) -> Guess {
    let name = column.name.to_lowercase();
    let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
    let by_unit = column.unit.as_deref().and_then(unit).map(|unit| unit.dimension);
    if has(&["normal"]) {
        Guess::NormalForce
    } else if has(&["time", "x_value", "abscissa"]) || name == "t" || name == "tout" {
        Guess::Time
    } else if has(&["friction", "force", "forc", "load", "lbs", "pound"]) {
        Guess::Force
    } else if has(&["accel"]) {
        Guess::Acceleration
    } else if has(&["veloc", "speed"]) {
        Guess::Velocity
    } else if has(&["displ", "position", "stroke", "dist", "slip", "laser"]) {
        Guess::Displacement
    } else {
        by_unit.map_or_else(|| by_numbers(index, &column.values), by_dimension)
    }
}

fn by_dimension(dimension: Dimension) -> Guess {
    match dimension {
        TIME => Guess::Time,
        FORCE => Guess::Force,
        LENGTH => Guess::Displacement,
        VELOCITY => Guess::Velocity,
        ACCELERATION => Guess::Acceleration,
        _ => Guess::Unknown,
    }
}

fn by_numbers(index: usize, values: &[f64]) -> Guess {
    let rises = values.len() > 2 && first_not_rising(values).is_none();
    if index == 0 && rises { Guess::Time } else { Guess::Unknown }
}
