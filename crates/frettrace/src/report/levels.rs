//! Figures of the three hypotheses about the motion, against level, for each frequency, preload and lubrication.

use super::chart::{Chart, Curve, Ink, Role};
use super::kind::{Figure, Kind};
use super::words::number;
use crate::hypotheses::Level;

/// Runs that differ in their level only, the lowest first.
struct Group<'a> {
    name: String,
    levels: Vec<&'a Level>,
}

/// Error of the hypotheses against level, one figure for each frequency, preload and lubrication; and over all of them the first
/// real mode's likeness to the linear mode, and its generalised acceleration.
#[must_use]
pub fn figures(levels: &[Level], ink: Ink) -> Vec<Figure> {
    let groups = groups(levels);
    let errors = groups.iter().enumerate().map(|(index, group)| errors(index, group, ink));
    let across = [
        across("likeness", "Likeness of the first real mode to the linear one", &groups, ink, |level| {
            1.0 - level.assurance
        }),
        across("coordinate", "First generalised acceleration [m/s²]", &groups, ink, |level| {
            level.coordinate
        }),
    ];
    errors.chain(across).collect()
}

fn groups(levels: &[Level]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for level in levels {
        let film = level.lubricated.map_or("", |yes| if yes { ", lubricated" } else { ", dry" });
        // Refined frequencies differ by rounding: a tenth of a hertz tells settings apart.
        let preload = number(level.preload);
        let preload = if preload.contains('.') { preload.trim_end_matches('0') } else { &preload };
        let name = format!("{:.1} Hz, {} N{film}", level.frequency_hz, preload.trim_end_matches('.'));
        match groups.iter_mut().find(|group| group.name == name) {
            Some(group) => group.levels.push(level),
            None => groups.push(Group { name, levels: vec![level] }),
        }
    }
    groups.iter_mut().for_each(|group| group.levels.sort_by(|a, b| a.level.total_cmp(&b.level)));
    groups
}

fn values(group: &Group<'_>, of: impl Fn(&Level) -> f64) -> Vec<f64> {
    group.levels.iter().map(|level| of(level)).collect()
}

const LEVEL: &str = "level, log10 of the accelerations' rms [m/s²]";

fn errors(index: usize, group: &Group<'_>, ink: Ink) -> Figure {
    let x = values(group, |level| level.level.log10());
    let named: [(&str, Role, Vec<f64>); 4] = [
        ("fixed modes", Role::Number(0), values(group, |level| level.fixed)),
        ("real modes of the level", Role::Number(1), values(group, |level| level.real)),
        ("harmonic balance", Role::Number(2), values(group, |level| level.harmonic)),
        ("noise", Role::Measured, values(group, |level| level.noise_floor)),
    ];
    let curves = named.iter().map(|(name, role, y)| Curve::line(name, *role, &x, y)).collect();
    let chart = Chart {
        title: &format!("Accelerometers not described: {}", group.name),
        x_label: LEVEL,
        y_label: "relative error",
        logarithmic: true,
        curves,
    };
    Figure::new(format!("hypotheses-{}", index + 1), Kind::Modes, chart.picture(ink))
}

fn across(name: &str, title: &str, groups: &[Group<'_>], ink: Ink, of: fn(&Level) -> f64) -> Figure {
    let drawn: Vec<(&str, Vec<f64>, Vec<f64>)> = groups
        .iter()
        .map(|group| (group.name.as_str(), values(group, |level| level.level.log10()), values(group, of)))
        .collect();
    let curves = drawn
        .iter()
        .enumerate()
        .map(|(index, (name, x, y))| Curve::line(name, Role::Number(index), x, y))
        .collect();
    let y_label = if name == "likeness" { "1 − modal assurance criterion" } else { "m/s²" };
    let chart = Chart { title, x_label: LEVEL, y_label, logarithmic: true, curves };
    Figure::new(name.to_owned(), Kind::Modes, chart.picture(ink))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(preload: f64, level: f64) -> Level {
        Level {
            run: "0001".into(),
            level,
            frequency_hz: 50.0,
            preload,
            lubricated: Some(preload > 50.0),
            modes: 2,
            fixed: 0.05,
            real: 0.03,
            harmonic: 0.01,
            noise_floor: 0.009,
            shape: vec![1.0],
            assurance: 0.999,
            resembles: 0,
            coordinate: level,
        }
    }

    /// Two preloads, told to four digits, make two figures of errors and two common ones, each with the curves of its groups.
    #[test]
    fn settings_have_figures_of_their_own() {
        let levels = [level(40.0, 2.0), level(40.0, 1.0), level(80.0004, 1.0)];
        let drawn = figures(&levels, Ink::File);
        assert_eq!(drawn.len(), 4);
        assert!(drawn[0].svg.contains("50.0 Hz, 40 N, dry") && drawn[1].svg.contains("80 N, lubricated"));
        assert!(drawn[2].svg.contains("50.0 Hz, 80 N, lubricated"));
        assert!(groups(&levels)[0].levels[0].level < groups(&levels)[0].levels[1].level);
    }
}
