//! Runs all cases, writes `REPORT.md`, compares with `baseline.csv`; `--accept` stores what was found; `bands N` prints the table
//! of the reconstruction's bands over N rigs instead, `hypotheses` that of the modes, `splines` that of
//! splines and forms.
#![expect(clippy::print_stdout, reason = "the table is the answer")]

use std::{fs, path::Path, process::ExitCode};
use validation::{
    baseline,
    case::{Outcome, Row},
    cases, report,
};

fn main() -> anyhow::Result<ExitCode> {
    let mut words = std::env::args().skip(1);
    let table = match words.next().as_deref() {
        Some("bands") => {
            let rigs = words.next().map_or(Ok(200), |number| number.parse())?;
            Some(cases::verify_reconstruction_bands::table(rigs)?)
        }
        Some("hypotheses") => Some(cases::verify_mode_hypotheses::table()?),
        Some("splines") => Some(cases::compare_splines::table()?),
        _ => None,
    };
    if let Some(table) = table {
        print!("{table}");
        return Ok(ExitCode::SUCCESS);
    }
    let accept = std::env::args().any(|argument| argument == "--accept");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut results, mut skipped) = (Vec::new(), Vec::new());
    for case in cases::ALL {
        match (case.run)()? {
            Outcome::Ran(rows) => results.push((case.name, rows)),
            Outcome::Skipped(reason) => skipped.push((case.name, reason)),
        }
    }
    let text = report::markdown(&results, &skipped);
    print!("{text}");
    fs::write(folder.join("REPORT.md"), &text)?;
    if accept {
        fs::write(folder.join("baseline.csv"), baseline::write(&results))?;
    }
    let stored = baseline::read(&fs::read_to_string(folder.join("baseline.csv"))?);
    Ok(verdict(&results, &baseline::drifts(&stored, &results)))
}

fn verdict(results: &[(&str, Vec<Row>)], drifts: &[String]) -> ExitCode {
    for drift in drifts {
        println!("drift: {drift}");
    }
    let failed = results.iter().flat_map(|(_, rows)| rows).filter(|row| !row.passes()).count();
    let rows = results.iter().map(|(_, rows)| rows.len()).sum::<usize>();
    println!("\n{rows} quantities, {failed} failed, {} drifted", drifts.len());
    if failed == 0 && drifts.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
