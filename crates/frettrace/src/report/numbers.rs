//! The residual's own shape in numbers: what it follows, and where it is largest.

use super::{escape, words::number};
use crate::results::{Explanation, ResidualShape};
use std::fmt::Write;

/// Least and largest of a residual along a quantity, and where it is largest.
struct Extent {
    least: f64,
    largest: f64,
    place: f64,
}

fn extent(shape: &ResidualShape, values: &[f64]) -> Option<Extent> {
    let known = || shape.centre.iter().zip(values).filter(|(_, value)| value.is_finite());
    let (place, largest) = known().max_by(|a, b| a.1.total_cmp(b.1))?;
    let least = known().map(|(_, value)| *value).fold(f64::INFINITY, f64::min);
    Some(Extent { least, largest: *largest, place: *place })
}

/// What the residual left over follows most, in one sentence; none where there is no shape.
pub(super) fn sentence(found: &Explanation) -> Option<String> {
    let named = !found.effects.is_empty();
    let of = |shape: &'_ ResidualShape| extent(shape, if named { &shape.after } else { &shape.before });
    let contrast = |e: &Extent| e.largest / e.least.max(f64::MIN_POSITIVE);
    let all = found.exhibits.residual.iter().filter_map(|shape| Some((shape, of(shape)?)));
    let (shape, most) = all.max_by(|a, b| contrast(&a.1).total_cmp(&contrast(&b.1)))?;
    Some(format!(
        "What is left changes most with {}: {} to {} standard deviations of the noise, largest at {} ({}).",
        shape.against,
        number(most.least),
        number(most.largest),
        number(most.place),
        shape.unit
    ))
}

/// A table of all shapes, and every number of them below it.
pub(super) fn section(found: &Explanation) -> String {
    let shapes = &found.exhibits.residual;
    if shapes.is_empty() {
        return String::new();
    }
    let named = !found.effects.is_empty();
    let head = |model: &str| format!("<th>{model}: least</th><th>largest</th><th>at</th>");
    let heads = head("declared model") + &if named { head("with the effects") } else { String::new() };
    let rows: String = shapes.iter().map(|shape| row(shape, named)).collect();
    let bins: String = shapes.iter().map(|shape| bins(shape, named)).collect();
    format!(
        "<h3>In numbers</h3>\n<p class=\"faint\">Quadratic means in standard deviations of the noise: 1 is noise alone. What does \
         not follow a quantity is nearly the same everywhere along it.</p>\n<div class=\"scroll\"><table>\n<tr><th>against</th>\
         {heads}<th>unit</th></tr>\n{rows}</table></div>\n<details><summary>All bins</summary>\n{bins}</details>\n"
    )
}

fn row(shape: &ResidualShape, named: bool) -> String {
    let sides = [&shape.before, &shape.after];
    let cells = sides[..if named { 2 } else { 1 }].iter().map(|values| match extent(shape, values) {
        Some(e) => {
            format!("<td>{}</td><td>{}</td><td>{}</td>", number(e.least), number(e.largest), number(e.place))
        }
        None => "<td></td><td></td><td></td>".into(),
    });
    let cells: String = cells.collect();
    format!("<tr><td>{}</td>{cells}<td>{}</td></tr>\n", escape(&shape.against), escape(&shape.unit))
}

fn bins(shape: &ResidualShape, named: bool) -> String {
    let mut rows = String::new();
    for (k, centre) in shape.centre.iter().enumerate() {
        let at = |values: &[f64]| values.get(k).copied().map_or("?".to_owned(), number);
        let last = if named { format!("<td>{}</td>", at(&shape.after)) } else { String::new() };
        // Writing into a string cannot fail.
        let _ = writeln!(rows, "<tr><td>{}</td><td>{}</td>{last}</tr>", number(*centre), at(&shape.before));
    }
    let after = if named { "<th>with the effects</th>" } else { "" };
    format!(
        "<div class=\"scroll\"><table>\n<tr><th>{} [{}]</th><th>declared model</th>{after}</tr>\n{rows}</table></div>\n",
        escape(&shape.against),
        escape(&shape.unit)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{Exhibits, Verdict};

    fn found() -> Explanation {
        let shape = |against: &str, before: Vec<f64>| ResidualShape {
            against: against.into(),
            unit: "m".into(),
            centre: vec![0.25, 0.5, 0.75],
            after: vec![1.0; 3],
            before,
        };
        let residual = vec![shape("slip", vec![2.0, 3.0, 8.0]), shape("phase", vec![4.0, f64::NAN, 5.0])];
        Explanation {
            verdict: Verdict::Unexplained,
            exhibits: Exhibits { residual, ..Exhibits::default() },
            ..Explanation::default()
        }
    }

    /// The quantity with the largest contrast is named, with its least and largest value and the place of the latter.
    #[test]
    fn what_the_residual_follows_is_said() {
        let said = sentence(&found()).unwrap();
        assert_eq!(
            said,
            "What is left changes most with slip: 2.000 to 8.000 standard deviations of the noise, largest at 0.7500 (m)."
        );
        assert!(sentence(&Explanation::default()).is_none());
    }

    /// Every bin of every shape is there in numbers; one model has one column.
    #[test]
    fn every_bin_is_a_number() {
        let text = section(&found());
        assert_eq!(text.matches("<tr>").count(), 1 + 2 + 2 * 4);
        assert!(
            text.contains("<td>0.5000</td><td>?</td></tr>") && !text.contains("with the effects"),
            "{text}"
        );
        assert!(section(&Explanation::default()).is_empty());
    }
}
