//! The page itself.

use super::{Kind, chart::Ink, escape, figures, numbers, words};
use crate::results::{
    BeforeAfter, ContactLoop, Control, Estimate, Explanation, Identification, ModeEstimate, Verdict,
};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// The report as one HTML page without any outside reference.
#[must_use]
pub fn html(title: &str, found: &Explanation) -> String {
    let mut page = String::new();
    let sections = [
        verdict(found),
        errors(found),
        pictures(found),
        numbers::section(found),
        energy(found),
        evidence(found),
        controls(found),
        parameters(found),
        notes(found),
    ];
    // Writing into a string cannot fail.
    let _ = write!(
        page,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n\
         <title>{0}</title>\n<style>\n{1}</style>\n</head>\n<body>\n<h1>{0}</h1>\n{2}</body>\n</html>\n",
        escape(title),
        include_str!("page.css"),
        sections.concat()
    );
    page
}

fn verdict(found: &Explanation) -> String {
    let class = match found.verdict {
        Verdict::NothingMissing => "nothing-missing",
        Verdict::Explained => "explained",
        Verdict::Unexplained => "unexplained",
    };
    let mut text = format!("<p class=\"verdict {class}\">{}</p>\n", escape(&words::verdict(found)));
    if found.verdict == Verdict::Unexplained {
        text += &numbers::sentence(found).map_or(String::new(), |said| format!("<p>{}</p>\n", escape(&said)));
    }
    for effect in &found.effects {
        let Some(experiment) = &effect.separating_experiment else { continue };
        let aim = if effect.indistinguishable_from.is_empty() {
            "What would put it to the test"
        } else {
            "What would tell the possibilities apart"
        };
        text += &format!("<p>{}: {aim}: {}</p>\n", escape(&effect.id), escape(experiment));
    }
    text
}

fn errors(found: &Explanation) -> String {
    let held_out = found.held_out.as_ref().map(|error| ("runs that nothing was fitted to", error));
    let rows: String = held_out
        .into_iter()
        .chain([("fitted runs", &found.error)])
        .map(|(name, error)| error_rows(name, error))
        .collect();
    format!("<h2>Error before and after</h2>\n<div class=\"scroll\"><table>\n{rows}</table></div>\n")
}

fn error_rows(name: &str, error: &BeforeAfter) -> String {
    let largest =
        [error.before, error.after, error.noise_floor].into_iter().fold(f64::MIN_POSITIVE, f64::max);
    let row = |what: &str, class: &str, value: f64| {
        format!(
            "<tr><td class=\"words\">{}, {what}</td><td>{}</td><td class=\"track\">{}</td></tr>\n",
            escape(name),
            words::percent(value),
            bar(class, value / largest)
        )
    };
    [
        row("before", "before", error.before),
        row("after", "after", error.after),
        row("noise alone", "floor", error.noise_floor),
    ]
    .concat()
}

fn bar(class: &str, share: f64) -> String {
    let width = 100.0 * if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
    format!("<span class=\"bar {class}\" style=\"width:{width:.1}%\"></span>")
}

fn pictures(found: &Explanation) -> String {
    let mut text = String::new();
    let mut section = "";
    // Errors, evidence and parameters stand in tables with bars.
    let told = [Kind::Loops, Kind::Signals, Kind::Spectra, Kind::Residuals, Kind::Modes];
    for figure in figures(found, Ink::Page).into_iter().filter(|figure| told.contains(&figure.kind)) {
        if figure.kind.heading() != section {
            text += if section.is_empty() { "" } else { "</div>\n" };
            section = figure.kind.heading();
            text += &format!("<h2>{section}</h2>\n<div class=\"figures\">\n");
        }
        text += &figure.svg;
    }
    text + if section.is_empty() { "" } else { "</div>\n" }
}

fn evidence(found: &Explanation) -> String {
    if found.candidates.is_empty() {
        return String::new();
    }
    let largest =
        found.candidates.iter().map(|candidate| candidate.evidence).fold(f64::MIN_POSITIVE, f64::max);
    let rows: String = found
        .candidates
        .iter()
        .map(|candidate| {
            format!(
                "<tr><td>{}</td><td class=\"words\">{}</td><td>{}</td><td>{:.0}</td><td class=\"track\">{}</td></tr>\n",
                escape(&candidate.id),
                words::meaning(&candidate.id),
                words::percent(candidate.error),
                candidate.evidence,
                bar("after", candidate.evidence / largest)
            )
        })
        .collect();
    format!(
        "<h2>Evidence of all candidates</h2>\n<p class=\"faint\">Fall of the Bayesian information criterion when the \
         candidate joins the declared model; a claim needs at least 10 over the model without it and over every \
         rival.</p>\n<div class=\"scroll\"><table>\n<tr><th>candidate</th><th></th><th>error with it</th>\
         <th>evidence</th><th></th></tr>\n{rows}</table></div>\n"
    )
}

/// The same search where the answer is known.
fn controls(found: &Explanation) -> String {
    let row = |control: &Control| {
        format!(
            "<tr><td class=\"words\">{}</td><td class=\"words\">{}</td></tr>\n",
            escape(&words::question(control)),
            escape(&words::answer(control))
        )
    };
    let rows: String = found.controls.iter().map(row).collect();
    if rows.is_empty() {
        return rows;
    }
    format!(
        "<h2>Controls</h2>\n<p class=\"faint\">The same search on data whose answer is known.</p>\n<div class=\"scroll\">\
         <table>\n<tr><th>asked</th><th>answered</th></tr>\n{rows}</table></div>\n"
    )
}

fn parameters(found: &Explanation) -> String {
    let mut text = String::from("<h2>Parameters with intervals</h2>\n");
    for effect in &found.effects {
        text += &estimates(&format!("Effect {}", effect.id), &[("value", &effect.parameters)]);
    }
    let both = [("declared model", &found.baseline), ("with the effects", &found.model)];
    let shown = if found.effects.is_empty() { &both[..1] } else { &both[..] };
    let laws: Vec<_> = shown.iter().map(|(name, model)| (*name, &model.parameters)).collect();
    let modes: Vec<_> = shown.iter().map(|(name, model)| (*name, modes(model))).collect();
    let modes: Vec<_> = modes.iter().map(|(name, modes)| (*name, modes)).collect();
    text += &estimates(&format!("Law {}", found.baseline.law), &laws);
    text + &estimates("Calibrated modes", &modes)
}

fn modes(model: &Identification) -> BTreeMap<String, Estimate> {
    let modes = model.structure.modes.iter().enumerate();
    let named = |(index, mode): (usize, &ModeEstimate)| {
        let number = index + 1;
        [
            (format!("mode {number:2} frequency"), mode.frequency.clone()),
            (format!("mode {number:2} damping ratio"), mode.damping_ratio.clone()),
        ]
    };
    modes.flat_map(named).collect()
}

/// One table: a row a parameter, a column a model.
fn estimates(title: &str, models: &[(&str, &BTreeMap<String, Estimate>)]) -> String {
    let names: BTreeSet<&String> = models.iter().flat_map(|(_, parameters)| parameters.keys()).collect();
    if names.is_empty() {
        return String::new();
    }
    let heads: String =
        models.iter().map(|(head, _)| format!("<th>{head}</th><th>95 % interval</th>")).collect();
    let rows: String = names.iter().map(|name| estimate_row(name, models)).collect();
    format!(
        "<h3>{}</h3>\n<div class=\"scroll\"><table>\n<tr><th>parameter</th>{heads}<th>unit</th></tr>\n{rows}</table></div>\n",
        escape(title)
    )
}

fn estimate_row(name: &str, models: &[(&str, &BTreeMap<String, Estimate>)]) -> String {
    let cells: String = models.iter().map(|(_, parameters)| estimate_cells(parameters.get(name))).collect();
    let unit = models.iter().find_map(|(_, parameters)| parameters.get(name)).map_or("", |found| &found.unit);
    format!("<tr><td>{}</td>{cells}<td>{}</td></tr>\n", escape(name), escape(unit))
}

fn estimate_cells(estimate: Option<&Estimate>) -> String {
    let Some(estimate) = estimate else { return "<td></td><td></td>".into() };
    let [low, high] = estimate.interval95.map(words::number);
    let interval = if estimate.identifiable {
        format!("{low} … {high}")
    } else {
        "not determined by these data".into()
    };
    format!("<td>{}</td><td>{interval}</td>", words::number(estimate.value))
}

/// What friction takes out of the beam, run by run.
fn energy(found: &Explanation) -> String {
    let cell = |energy: f64| format!("<td>{}</td>", words::number(1e3 * energy));
    let row = |run: &ContactLoop| {
        let [measured, before, after] =
            [&run.measured, &run.before, &run.after].map(|c| cell(c.energy_per_cycle_j));
        let role = if run.held_out { "held out" } else { "fitted" };
        format!(
            "<tr><td>{} {}</td><td>{role}</td>{measured}{before}{after}</tr>\n",
            escape(&run.run),
            escape(&run.label)
        )
    };
    let rows: String = found.exhibits.loops.iter().map(row).collect();
    if rows.is_empty() {
        return rows;
    }
    let force = if words::is_contact_record(found) { "measured" } else { "recovered" };
    format!(
        "<h2>Energy per cycle</h2>\n<p class=\"faint\">What friction takes out of the motion in one period [mJ]: wear \
         follows it.</p>\n<div class=\"scroll\"><table>\n<tr><th>run</th><th></th><th>{force}</th>\
         <th>declared model</th><th>with the effects</th></tr>\n{rows}</table></div>\n"
    )
}

/// What the measurement cannot show, whatever was found.
fn unseen(found: &Explanation) -> &'static str {
    if words::is_contact_record(found) {
        "The force is predicted from the motion alone; a constant part of it may be the load cell's or the contact's."
    } else {
        "Mean friction, preload and a constant offset cannot be seen by accelerometers; nothing is said about them."
    }
}

fn notes(found: &Explanation) -> String {
    let items: String = found.notes.iter().map(|note| format!("<li>{}</li>\n", escape(note))).collect();
    let held_out = found.held_out.as_ref().map_or(String::new(), |error| error.runs.join(", "));
    format!(
        "<h2>What this rests on</h2>\n<ul>\n{items}<li>Held-out runs, chosen before anything was fitted: {}</li>\n\
         <li>{}</li>\n</ul>\n<footer>frettrace {}, seed {}</footer>\n",
        escape(if held_out.is_empty() { "none" } else { &held_out }),
        unseen(found),
        escape(&found.provenance.version),
        found.provenance.seed
    )
}

#[cfg(test)]
mod tests;
