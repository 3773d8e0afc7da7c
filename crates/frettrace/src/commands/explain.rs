//! `frettrace explain`.

use super::{Session, tables};
use clap::{Args, builder::PossibleValuesParser};
use frettrace::{
    explain::{ExplainOptions, explain},
    report::{html, words},
    results::Explanation,
    store,
};
use frettrace_measurement::Recording;
use std::path::PathBuf;

/// What the declared model lacks: the missing effect, and the error before and after on held-out runs
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  frettrace explain rig.h5 -o explain.json --report report.html\n  \
    frettrace explain rig.h5 --json | jq .verdict")]
pub struct Arguments {
    /// Measurement file or contact record
    file: PathBuf,
    /// Result file (JSON)
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Report for a person who decides: one HTML file that works offline
    #[arg(long)]
    report: Option<PathBuf>,
    /// Effects that are not looked for, by their ids
    #[arg(long, value_name = "ID", value_delimiter = ',', value_parser = PossibleValuesParser::new(frettrace_explain::effect_ids()))]
    without: Vec<String>,
    /// Controls: the same search on SURROGATES of the declared model, without the named effects in its list, and on the explaining
    /// model at full and half size, with noise drawn anew
    #[arg(long, value_name = "SURROGATES", num_args = 0..=1, default_missing_value = "4", default_value_t = 0, hide_default_value = true)]
    controls: usize,
    /// Seed of the noise that controls draw
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

pub fn run(arguments: &Arguments, session: &Session) -> anyhow::Result<()> {
    let recording = frettrace_measurement::read(&arguments.file)?;
    let Arguments { without, controls, seed, .. } = arguments;
    let options = ExplainOptions { seed: *seed, without: without.clone(), controls: *controls };
    let found = explain(&recording, &options, &session.progress)?;
    if let Some(path) = &arguments.output {
        store::write_text(path, &store::to_json(path, &found)?)?;
    }
    if let Some(path) = &arguments.report {
        store::write_text(path, &html(title(&recording), &found))?;
    }
    session.answer(&found, &text(&found))
}

fn title(recording: &Recording) -> &str {
    match recording {
        Recording::Measurement(measurement) => &measurement.title,
        Recording::Contact(record) => &record.title,
    }
}

/// The explanation as `explain` and `demo` print it.
pub fn text(found: &Explanation) -> String {
    let mut text = words::verdict(found) + "\n\n" + &tables::before_after("fitted runs", &found.error);
    if let Some(held_out) = &found.held_out {
        text += &tables::before_after("held-out runs", held_out);
    }
    for effect in &found.effects {
        text += &format!(
            "\n{} (probability {:.3})\n{}",
            effect.id,
            effect.probability,
            tables::estimates(&effect.parameters)
        );
        if let Some(experiment) = &effect.separating_experiment {
            let rivals = effect.indistinguishable_from.join(" and ");
            let aim = if rivals.is_empty() {
                "to be sure of it".to_owned()
            } else {
                format!("to tell it from {rivals}")
            };
            text += &format!("  {aim}: {experiment}\n");
        }
    }
    if !found.controls.is_empty() {
        text += "\ncontrols\n";
        for control in &found.controls {
            text += &format!("  {:<42} {}\n", words::question(control), words::answer(control));
        }
    }
    let law = if found.effects.is_empty() { &found.baseline } else { &found.model };
    text += &format!("\nlaw {}\n{}", law.law, tables::estimates(&law.parameters));
    text + "\n" + &tables::notes(&found.notes)
}
