//! Runs all cases, writes `REPORT.md`, compares with `baseline.csv`; or prints one of the large tables.
#![expect(clippy::print_stdout, reason = "the table is the answer")]

use clap::{Args, Parser, Subcommand};
use frettrace_measurement::write_measurement;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{fs, time::Duration};
use validation::sweep::apart::{MADE, printed};
use validation::sweep::coverage::{self, Covered, cover};
use validation::sweep::judged::{Judged, judge};
use validation::sweep::{self, made::make, mended::mended, plan, tables};
use validation::{
    baseline,
    case::{Outcome, Row},
    cases::{self, verify_reconstruction_bands::Motion},
    report,
};

/// How far to trust frettrace: all cases, REPORT.md and the comparison with the stored results
#[derive(Parser, Debug)]
#[command(args_conflicts_with_subcommands = true)]
struct Arguments {
    /// Store what is found as the new baseline
    #[arg(long)]
    accept: bool,
    #[command(subcommand)]
    table: Option<Table>,
}

#[derive(Subcommand, Debug)]
enum Table {
    /// The bands of the reconstruction over rigs
    Bands {
        /// Number of rigs
        #[arg(default_value_t = 200)]
        rigs: u64,
        /// Seed of the first
        #[arg(long, default_value_t = 0)]
        first: u64,
        /// Records without a period
        #[arg(long)]
        wandering: bool,
    },
    /// The hypotheses of the modes
    Hypotheses,
    /// Splines and forms of the reconstruction
    Splines,
    /// Simulated rigs with a known effect through `explain`: confusion, false alarms, detection limit
    Sweep {
        #[command(flatten)]
        extent: Extent,
        #[command(flatten)]
        kept: Kept,
    },
    /// One set of the sweep's plan through `explain`: a line when it is made, then its line of JSON
    Judge {
        /// Name in the plan
        name: String,
        #[command(flatten)]
        drawn: Drawn,
        #[command(flatten)]
        kept: Kept,
    },
    /// One set of the sweep's plan as a measurement file with its truth, to look at
    Set {
        /// Name in the plan, as the lines of a sweep have it
        name: String,
        /// The file
        #[arg(short, long)]
        output: PathBuf,
        /// As the sensors of a laboratory's calibration would have recorded it, which `coverage` asks `identify` about
        #[arg(long)]
        calibrated: bool,
        #[command(flatten)]
        drawn: Drawn,
    },
    /// Simulated clean rigs through `reconstruct` and `identify`: how often the bands hold the truth
    Coverage(Extent),
    /// One clean set of the plan through `reconstruct` and `identify`: a line when it is made, then its line of JSON
    Cover {
        /// Name in the plan
        name: String,
        #[command(flatten)]
        drawn: Drawn,
    },
}

/// Which sets, and where they go.
#[derive(Args, Debug)]
struct Extent {
    /// File with a line of JSON for every finished set; what is in it already is not run again
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    drawn: Drawn,
    /// Only the first sets of the plan, which is in drawn order
    #[arg(long, default_value_t = usize::MAX)]
    first: usize,
    /// Seconds after which a question counts as not answered
    #[arg(long, default_value_t = 600)]
    limit: u64,
    /// Seconds after which a set counts as one that cannot be made
    #[arg(long, default_value_t = 600)]
    making: u64,
}

impl Extent {
    fn sets(&self, wanted: impl Fn(&plan::Planned) -> bool) -> anyhow::Result<Vec<plan::Planned>> {
        Ok(self.drawn.plan()?.into_iter().filter(wanted).take(self.first).collect())
    }

    /// What another process of this program answers on a set, within the limits.
    fn apart<T: DeserializeOwned>(
        &self,
        question: &str,
        set: &plan::Planned,
        kept: &Kept,
    ) -> anyhow::Result<T> {
        let mut program = Command::new(std::env::current_exe()?);
        let [seed, clean] = [self.drawn.seed, self.drawn.clean as u64].map(|number| number.to_string());
        program.args([question, &set.name, "--seed", &seed, "--clean", &clean]);
        program.args(self.drawn.pairs.then_some("--pairs"));
        program.args(self.drawn.thirds.then_some("--thirds"));
        program.args(self.drawn.wide.then_some("--wide"));
        program.args(self.drawn.mended.then_some("--mended"));
        program.args(kept.sets.iter().flat_map(|folder| [Path::new("--sets"), folder]));
        Ok(serde_json::from_str(&printed(program, [self.making, self.limit].map(Duration::from_secs))?)?)
    }
}

/// Where made sets are kept.
#[derive(Args, Debug, Default)]
struct Kept {
    /// Folder that keeps the sets once they are made, and from which they are taken; empty it when the simulator changes
    #[arg(long)]
    sets: Option<PathBuf>,
}

/// What a plan is drawn from.
#[derive(Args, Debug)]
struct Drawn {
    /// Everything is drawn from this
    #[arg(long, default_value_t = sweep::SEED)]
    seed: u64,
    /// Clean sets of the plan
    #[arg(long, default_value_t = sweep::CLEAN)]
    clean: usize,
    /// The sets with two effects instead
    #[arg(long)]
    pairs: bool,
    /// The sets whose effects have third formulas instead
    #[arg(long, conflicts_with = "pairs")]
    thirds: bool,
    /// Sets on rigs of any kind instead: tubes, pins, short records, any law
    #[arg(long, conflicts_with_all = ["pairs", "thirds"])]
    wide: bool,
    /// The sets that were answered wrong once instead, of whatever seed
    #[arg(long, conflicts_with_all = ["pairs", "thirds", "wide"])]
    mended: bool,
}

impl Drawn {
    fn plan(&self) -> anyhow::Result<Vec<plan::Planned>> {
        Ok(match self {
            Self { pairs: true, .. } => plan::pairs(self.seed),
            Self { thirds: true, .. } => plan::thirds(self.seed),
            Self { wide: true, .. } => plan::wide(self.seed),
            Self { mended: true, .. } => mended()?,
            _ => plan::plan(self.seed, self.clean),
        })
    }

    fn set(&self, name: &str) -> anyhow::Result<plan::Planned> {
        let found = self.plan()?.into_iter().find(|set| set.name == name);
        found.ok_or_else(|| anyhow::anyhow!("no set \"{name}\" in the plan of seed {}", self.seed))
    }
}

fn main() -> anyhow::Result<ExitCode> {
    let arguments = Arguments::parse();
    let Some(table) = arguments.table else { return run_cases(arguments.accept) };
    print!("{}", run_table(&table)?);
    Ok(ExitCode::SUCCESS)
}

fn run_table(table: &Table) -> anyhow::Result<String> {
    match table {
        Table::Bands { rigs, first, wandering } => {
            let motion = if *wandering { Motion::Wandering } else { Motion::Periodic };
            cases::verify_reconstruction_bands::table(*first..first + rigs, motion)
        }
        Table::Hypotheses => cases::verify_mode_hypotheses::table(),
        Table::Splines => cases::compare_splines::table(),
        Table::Sweep { extent, kept } => {
            let judged = |set: &plan::Planned| {
                extent.apart("judge", set, kept).unwrap_or_else(|error| Judged::failed(set, &error))
            };
            let done = sweep::resume(&extent.output, &extent.sets(|_| true)?, |set| &set.name, judged)?;
            Ok(tables::markdown(&format!("Sweep of explain, seed {}", extent.drawn.seed), &done))
        }
        Table::Judge { name, drawn, kept } => {
            let judged = judge(&drawn.set(name)?, kept.sets.as_deref(), || println!("{MADE}"));
            Ok(serde_json::to_string(&judged)? + "\n")
        }
        Table::Set { name, output, calibrated, drawn } => {
            let planned = drawn.set(name)?;
            let mut made = make(&planned)?.simulation;
            if *calibrated {
                made.measurement = coverage::calibrated(made.measurement, planned.seed);
            }
            write_measurement(output, &made.measurement, Some(&made.truth))?;
            Ok(format!("{planned:#?}\n"))
        }
        Table::Coverage(extent) => {
            let covered = |set: &plan::Planned| {
                extent
                    .apart("cover", set, &Kept::default())
                    .unwrap_or_else(|error| Covered::failed(set, &error))
            };
            let clean = extent.sets(|set| set.formulas.is_empty())?;
            let done = sweep::resume(&extent.output, &clean, |set| &set.name, covered)?;
            Ok(coverage::markdown(&done))
        }
        Table::Cover { name, drawn } => {
            Ok(serde_json::to_string(&cover(&drawn.set(name)?, || println!("{MADE}")))? + "\n")
        }
    }
}

fn run_cases(accept: bool) -> anyhow::Result<ExitCode> {
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
