//! Figures of what was identified: evidence and errors, parameters with intervals, calibrated modes.

use super::chart::{Ink, Role, Row, Rows};
use super::kind::{Figure, Kind};
use super::words::{number, percent};
use crate::results::{BeforeAfter, Estimate, Explanation, Identification, Verdict};

/// Evidence, errors, parameters and modes of an explanation.
pub(super) fn explained(found: &Explanation, ink: Ink) -> Vec<Figure> {
    let named = !found.effects.is_empty() || found.verdict == Verdict::Explained;
    let (law, role) = if named { (&found.model, Role::After) } else { (&found.baseline, Role::Before) };
    let mut figures = vec![errors(found, ink)];
    figures.extend((!found.candidates.is_empty()).then(|| evidence(found, ink)));
    figures.extend(parameters(law, role, ink));
    figures.extend(modes(law, role, ink));
    figures
}

/// Figures of an identification: parameters with intervals, errors of its steps, calibrated modes.
#[must_use]
pub fn identification(found: &Identification, ink: Ink) -> Vec<Figure> {
    let mut figures: Vec<Figure> = parameters(found, Role::After, ink).into_iter().collect();
    figures.extend(steps(found, ink));
    figures.extend(modes(found, Role::After, ink));
    figures
}

fn evidence(found: &Explanation, ink: Ink) -> Figure {
    let chosen = |id: &str| found.effects.iter().any(|effect| effect.id == id);
    let rows = found.candidates.iter().map(|candidate| {
        let role = if chosen(&candidate.id) { Role::After } else { Role::Floor };
        let note = format!("{:.0}, error {}", candidate.evidence, percent(candidate.error));
        Row::bar(candidate.id.clone(), role, candidate.evidence, note)
    });
    let chart = Rows {
        title: "Evidence of all candidates over the declared model",
        x_label: "fall of the Bayesian information criterion [1]",
        rows: rows.collect(),
    };
    Figure::new("evidence", Kind::Evidence, chart.picture(ink))
}

fn errors(found: &Explanation, ink: Ink) -> Figure {
    let rows = |name: &str, error: &BeforeAfter| {
        let row = |what: &str, role, value: f64| {
            Row::bar(format!("{name}, {what}"), role, 100.0 * value, percent(value))
        };
        [
            row("before", Role::Before, error.before),
            row("after", Role::After, error.after),
            row("noise alone", Role::Floor, error.noise_floor),
        ]
    };
    let held_out = found.held_out.iter().flat_map(|error| rows("held-out runs", error));
    let chart = Rows {
        title: "Error before and after",
        x_label: "relative error [%]",
        rows: held_out.chain(rows("fitted runs", &found.error)).collect(),
    };
    Figure::new("errors", Kind::Evidence, chart.picture(ink))
}

/// An estimate as a row; an interval that is open has no mark, and says so.
fn interval(name: String, role: Role, estimate: &Estimate, scale: f64) -> Row {
    let closed = estimate.identifiable && estimate.interval95.iter().all(|end| end.is_finite());
    let unit = if estimate.unit == "1" { "" } else { &estimate.unit };
    let note = if closed {
        format!("{} {unit}", number(estimate.value)).trim_end().to_owned()
    } else {
        "not determined by these data".into()
    };
    let known = |value: f64| if closed { value } else { f64::NAN };
    Row {
        name,
        role,
        span: estimate.interval95.map(|end| known(scale * end)),
        value: Some(known(scale * estimate.value)),
        note,
    }
}

/// The chart as a figure; one without rows is none.
fn figure(name: &str, kind: Kind, chart: &Rows, ink: Ink) -> Option<Figure> {
    (!chart.rows.is_empty()).then(|| Figure::new(name, kind, chart.picture(ink)))
}

/// 95 % intervals of all parameters, over their values: widths of different units beside each other.
fn parameters(found: &Identification, role: Role, ink: Ink) -> Option<Figure> {
    let about = |(name, estimate): (&String, &Estimate)| {
        let row = interval(name.clone(), role, estimate, 100.0 / estimate.value.abs());
        let middle = row.value.unwrap_or(f64::NAN);
        Row { span: row.span.map(|end| end - middle), value: row.value.map(|value| value - middle), ..row }
    };
    let rows: Vec<Row> = found.parameters.iter().map(about).collect();
    let chart = Rows {
        title: &format!("Law {}: 95 % intervals", found.law),
        x_label: "difference from the value [% of it]",
        rows,
    };
    figure("parameters", Kind::Parameters, &chart, ink)
}

fn steps(found: &Identification, ink: Ink) -> Option<Figure> {
    let rows = found
        .steps
        .iter()
        .map(|step| Row::bar(step.name.clone(), Role::After, 100.0 * step.error, percent(step.error)));
    let chart = Rows {
        title: "Error of each step of the identification",
        x_label: "relative error [%]",
        rows: rows.collect(),
    };
    figure("steps", Kind::Evidence, &chart, ink)
}

/// Damping ratios of the calibrated modes with their intervals.
fn modes(found: &Identification, role: Role, ink: Ink) -> Option<Figure> {
    let rows = found.structure.modes.iter().enumerate().map(|(index, mode)| {
        let name = format!("mode {}, {} Hz", index + 1, number(mode.frequency.value));
        let row = interval(name, role, &mode.damping_ratio, 100.0);
        let note = if row.value.is_some_and(f64::is_finite) {
            percent(mode.damping_ratio.value)
        } else {
            row.note.clone()
        };
        Row { note, ..row }
    });
    let chart = Rows {
        title: "Calibrated modes: damping with 95 % intervals",
        x_label: "damping ratio [%]",
        rows: rows.collect(),
    };
    figure("modes", Kind::Modes, &chart, ink)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{Candidate, Effect, ModeEstimate, Step, Structure};
    use std::collections::BTreeMap;

    fn estimate(value: f64, identifiable: bool) -> Estimate {
        let interval95 = [0.9 * value, 1.1 * value];
        Estimate { value, std: 0.05 * value, interval95, unit: "1/m".into(), identifiable }
    }

    fn law() -> Identification {
        let mode = ModeEstimate { frequency: estimate(95.1, true), damping_ratio: estimate(0.004, true) };
        Identification {
            law: "dahl".into(),
            parameters: BTreeMap::from([
                ("sigma0".into(), estimate(2e5, true)),
                ("mu_k".into(), estimate(0.3, false)),
            ]),
            structure: Structure { modes: vec![mode] },
            steps: vec![Step { name: "joint".into(), parameters: vec!["sigma0".into()], error: 0.0123 }],
            ..Identification::default()
        }
    }

    /// Every parameter has a row; what the data do not determine has no mark but says so.
    #[test]
    fn intervals_of_an_identification() {
        let drawn = identification(&law(), Ink::File);
        let names: Vec<&str> = drawn.iter().map(|figure| figure.name.as_str()).collect();
        assert_eq!(names, ["parameters", "steps", "modes"]);
        let svg = &drawn[0].svg;
        assert!(svg.contains("2.000e5 1/m") && svg.contains("not determined by these data"), "{svg}");
        assert_eq!(svg.matches("<circle").count(), 1, "one value is known");
        assert!(drawn[1].svg.contains("1.23 %") && drawn[2].svg.contains("mode 1, 95.10 Hz"));
    }

    /// The candidate that was named stands out of those that were tried.
    #[test]
    fn the_named_candidate_stands_out() {
        let tried = |id: &str, evidence: f64| Candidate { id: id.into(), error: 0.01, evidence };
        let found = Explanation {
            effects: vec![Effect { id: "friction.lag".into(), ..Effect::default() }],
            candidates: vec![tried("friction.lag", 120.0), tried("friction.film", 30.0)],
            model: law(),
            ..Explanation::default()
        };
        let drawn = explained(&found, Ink::File);
        let evidence = drawn.iter().find(|figure| figure.name == "evidence").unwrap();
        assert!(evidence.svg.contains("120, error 1.00 %"));
        for colour in ["#0072B2", "#767676"] {
            assert_eq!(evidence.svg.matches(&format!("fill=\"{colour}\"")).count(), 1, "{colour}");
        }
    }
}
