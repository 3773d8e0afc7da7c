//! Texts of a picture against each other and against its edges: axis titles, numbers, names, notes.

use super::sheet::{FINE, LETTER, width};
use super::*;

/// A text and its box: left, top, right, bottom, in pixels.
type Placed = (String, [f64; 4]);

/// Height of a line of letters over the size of the type, from the top of what rises to the foot of what hangs.
const TALL: f64 = 0.95;
/// What two boxes may share: rounding of places to quarters of a pixel.
const ROUNDING: f64 = 0.5;

fn attribute<'a>(tag: &'a str, name: &str) -> &'a str {
    tag.split(&format!(" {name}=\"")).nth(1).map_or("", |rest| rest.split('"').next().unwrap_or(""))
}

fn number(text: &str) -> f64 {
    text.parse::<f64>().unwrap_or(f64::NAN) / f64::from(FINE)
}

/// Boxes of all texts; those on the ordinate are turned by a right angle to the left.
fn placed(svg: &str) -> Vec<Placed> {
    svg.split("<text")
        .skip(1)
        .map(|rest| {
            let (tag, rest) = rest.split_once('>').unwrap();
            let text = rest.split("</text>").next().unwrap().trim().replace("&lt;", "<").replace("&gt;", ">");
            let size = number(attribute(tag, "font-size"));
            let wide = f64::from(width(&text, LETTER)) * size / f64::from(LETTER);
            let left = match attribute(tag, "text-anchor") {
                "middle" => -0.5 * wide,
                "end" => -wide,
                _ => 0.0,
            };
            // Where the letters hang from their place, are centred on it, or stand on it.
            let top = match attribute(tag, "dy") {
                "0.76em" => 0.0,
                "0.5ex" => -0.5 * TALL * size,
                _ => -TALL * size,
            };
            let turned = attribute(tag, "transform").contains("rotate(270");
            let (x, y) = (number(attribute(tag, "x")), number(attribute(tag, "y")));
            let (right, bottom) = (left + wide, top + TALL * size);
            let found = if turned {
                [x + top, y - right, x + bottom, y - left]
            } else {
                [x + left, y + top, x + right, y + bottom]
            };
            (text, found)
        })
        .collect()
}

/// What touches, and what is cut off.
fn faults(svg: &str) -> Vec<String> {
    let size: Vec<f64> = attribute(svg, "viewBox").split(' ').map(number).collect();
    let all = placed(svg);
    let mut faults = Vec::new();
    for (k, (text, a)) in all.iter().enumerate() {
        if a[0] < -ROUNDING || a[1] < -ROUNDING || a[2] > size[2] + ROUNDING || a[3] > size[3] + ROUNDING {
            faults.push(format!("{text} is cut off: {a:?}"));
        }
        for (other, b) in &all[..k] {
            let shared = [0, 1].map(|side| a[side + 2].min(b[side + 2]) - a[side].max(b[side]));
            if shared.iter().all(|shared| *shared > ROUNDING) {
                faults.push(format!("{text} touches {other}"));
            }
        }
    }
    faults
}

/// Ranges whose numbers are long, short, close to each other, negative or of several sizes.
const RANGES: [(f64, f64); 8] = [
    (2.3e-7, 1.1e-4),
    (3.16e-6, 3.3e-6),
    (0.25, 72.0),
    (0.012_21, 0.012_29),
    (1e-12, 3e3),
    (123_456.0, 123_457.0),
    (9.4, 9.6),
    (1.0, 1.0),
];

/// No number on an axis touches its title, its neighbour or the edge, with any range, title or unit.
#[test]
fn numbers_and_titles_stay_apart() {
    for x_range in RANGES {
        for y_range in RANGES {
            for logarithmic in [false, true] {
                let (x, y) = ([-x_range.0, x_range.1], [y_range.0, y_range.1]);
                let chart = Chart {
                    title: "Acceleration a force, sensor 4",
                    x_label: "excitation frequency [Hz]",
                    y_label: "rms acceleration / force [m/(s² N)]",
                    logarithmic,
                    curves: vec![
                        Curve::line("0.6 N", Role::Number(0), &x, &y),
                        Curve::dashed("noise floor (between the lines)", Role::Floor, &x, &y),
                        Curve::dots("unstable", Role::Before, &x, &y),
                    ],
                };
                let found = faults(&chart.picture(Ink::File).svg);
                assert!(found.is_empty(), "{x_range:?} {y_range:?} {logarithmic}: {found:?}");
            }
        }
    }
}

/// The same for bars with names and notes, and for maps over numbers and names.
#[test]
fn names_and_notes_stay_apart() {
    for (low, high) in RANGES {
        let row = |name: &str, value: f64| {
            Row::bar(name.into(), Role::After, value, "−1234567, error 12.3 %".into())
        };
        let rows = vec![row("friction.presliding-damping", high), row("contact.tangential-stiffness", low)];
        let rows =
            Rows { title: "Evidence", x_label: "fall of the Bayesian information criterion [1]", rows };
        let found = faults(&rows.picture(Ink::File).svg);
        assert!(found.is_empty(), "{low} {high}: {found:?}");
        let values = vec![vec![2.0, low, high]; 8];
        let numbers = |label: &str| Axis::Numbers { label: label.into(), range: low..high + 1e-9 };
        let names: Vec<String> = (0..8).map(|k| format!("{:.4}", 123.4 * f64::from(k))).collect();
        let named = |label: &str| Axis::Names { label: label.into(), names: names.clone() };
        for (x, y) in [
            (numbers("slip [m]"), numbers("slip velocity [m/s]")),
            (named("sensor [index]"), named("level [m/s² RMS of all sensors]")),
        ] {
            let scale = "residual [std of the noise]";
            let map = Map { title: "Residual", x, y, values: &values, top: 1.0 + high, scale };
            let found = faults(&map.picture(Ink::File).svg);
            assert!(found.is_empty(), "{low} {high}: {found:?}");
        }
    }
}

/// The check sees what it is made for: two texts on one place, and one beyond the edge.
#[test]
fn faults_are_seen() {
    let text = |x: i32, anchor: &str| {
        format!(
            "<text x=\"{x}\" y=\"100\" dy=\"0.5ex\" text-anchor=\"{anchor}\" font-size=\"48\">\n12345\n</text>"
        )
    };
    let svg = format!(
        "<svg viewBox=\"0 0 800 200\">{}{}{}</svg>",
        text(100, "start"),
        text(250, "end"),
        text(790, "middle")
    );
    let found = faults(&svg);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].contains("touches") && found[1].contains("cut off"));
}
