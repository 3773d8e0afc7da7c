//! Samples of every laboratory format: two channels, told alike by all, and spoilt files with the message beside them.
#![allow(clippy::unwrap_used, reason = "a test")]

use std::path::PathBuf;

use frettrace_measurement::read_table;

const SAMPLES: usize = 20;

fn samples(prefix: &str) -> Vec<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/formats");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let wanted = |path: &PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        name.starts_with(prefix) && !name.ends_with(".message")
    };
    files.filter(wanted).collect()
}

/// The channels as `make_samples.py` makes them: force, then slip.
fn expected() -> [Vec<f64>; 2] {
    let force = (0..SAMPLES).map(|k| ((k * 7) % 16) as f64 / 4.0 - 2.0);
    let slip = (0..SAMPLES).map(|k| ((k * 5) % 32) as f64 / 8.0 - 2.0);
    [force.collect(), slip.collect()]
}

#[test]
fn every_format_tells_the_same() {
    let files = samples("good_");
    assert_eq!(files.len(), 20);
    for path in files {
        let table = read_table(&path).unwrap();
        let name = path.display();
        let columns = &table.columns;
        assert!(columns.len() >= 2, "{name}: {} columns", columns.len());
        let by_name = path.extension().is_some_and(|extension| extension == "mat");
        let (force, slip) = if by_name {
            let column =
                |name: &str| table.column(name).or_else(|| table.column(&format!("rig.{name}"))).unwrap();
            (column("data(:,1)"), column("data(:,2)"))
        } else {
            (&columns[columns.len() - 2], &columns[columns.len() - 1])
        };
        for (column, expected) in [force, slip].into_iter().zip(expected()) {
            // The numbers have at most four digits: every sample holds them exactly.
            assert_eq!(column.values, expected, "{name}: {}", column.name);
        }
        let time = table.column("t").or_else(|| table.column("rig.t")).unwrap_or(&columns[0]);
        // Six digits of times up to 0.095 s.
        let right = |(k, at): (usize, &f64)| (at - k as f64 / 200.0).abs() < 1e-6;
        let timed = table.interval == Some(1.0 / 200.0) || time.values.iter().enumerate().all(right);
        assert!(timed, "{name}: times {:?}", &time.values[..3]);
    }
}

#[test]
fn units_are_read_where_the_file_states_them() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/formats");
    let units = |name: &str| {
        let table = read_table(folder.join(name)).unwrap();
        table.columns.iter().map(|column| column.unit.clone().unwrap_or_default()).collect::<Vec<_>>()
    };
    assert_eq!(units("good_comma.csv"), ["s", "N", "mm"]);
    assert_eq!(units("good_windows.csv"), ["s", "N", "mm"]);
    assert_eq!(units("good_units_below.txt"), ["s", "N", "mm"]);
    assert_eq!(units("good_latin1.csv"), ["s", "N", "µm"]);
    assert_eq!(units("good_labview.lvm"), ["s", "N", "mm"]);
    assert_eq!(units("good_text.uff"), ["N", "mm"]);
    assert_eq!(units("good_no_heading.tsv"), ["", "", ""]);
}

#[test]
fn every_spoilt_file_is_told_what_is_wrong() {
    let files = samples("bad_");
    assert_eq!(files.len(), 15);
    let mut wrong = Vec::new();
    for path in files {
        let message = std::fs::read_to_string(format!("{}.message", path.display())).unwrap();
        let expected = format!("{}: {}", path.display(), message.trim_end());
        match read_table(&path) {
            Ok(_) => wrong.push(format!("{} is read without complaint", path.display())),
            Err(error) if error.to_string() == expected => {}
            Err(error) => wrong.push(format!("expected {expected}\nfound    {error}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
