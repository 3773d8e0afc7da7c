//! What is left: the residual against one quantity, and over two.

use super::chart::{Axis, Chart, Curve, Ink, Map, Role};
use super::kind::{Figure, Kind};
use crate::results::{Exhibits, ResidualMap, ResidualShape};

/// Curves and maps of the residual; with effects named, before and after.
pub(super) fn figures(exhibits: &Exhibits, named: bool, ink: Ink) -> Vec<Figure> {
    let shapes = exhibits.residual.iter().map(|shape| curve(shape, named, ink));
    let maps = exhibits.maps.iter().flat_map(|map| {
        let sides = [("declared model", "before", &map.before), ("with the effects", "after", &map.after)];
        maps(map, &sides[..if named { 2 } else { 1 }], ink)
    });
    shapes.chain(maps).collect()
}

fn curve(shape: &ResidualShape, named: bool, ink: Ink) -> Figure {
    let floor = vec![1.0; shape.centre.len()];
    let mut curves = vec![
        Curve::dashed("noise alone", Role::Floor, &shape.centre, &floor),
        Curve::line("declared model", Role::Before, &shape.centre, &shape.before),
    ];
    if named {
        curves.push(Curve::line("with the effects", Role::After, &shape.centre, &shape.after));
    }
    let chart = Chart {
        title: &format!("Residual against {}", shape.against),
        x_label: &format!("{} [{}]", shape.against, shape.unit),
        y_label: "residual [std of the noise]",
        logarithmic: false,
        curves,
    };
    let name = format!("shape-{}", shape.against.replace(' ', "-"));
    Figure::new(name, Kind::Residuals, chart.picture(ink))
}

/// One side of a map: the model it is about, the word for it in a file's name, and the numbers.
pub(super) type Side<'a> = (&'a str, &'a str, &'a Vec<Vec<f64>>);

/// The sides of a map on one scale of colours, so that they can be compared.
pub(super) fn maps(map: &ResidualMap, sides: &[Side<'_>], ink: Ink) -> Vec<Figure> {
    let all = sides.iter().flat_map(|(_, _, values)| values.iter().flatten());
    let top = all.copied().filter(|value| value.is_finite()).fold(2.0, f64::max);
    let draw = |&(model, side, values): &Side<'_>| {
        let picture = Map {
            title: &format!("Residual over {} and {}, {model}", map.across, map.up),
            x: axis(&map.across, &map.across_unit, &map.x),
            y: axis(&map.up, &map.up_unit, &map.y),
            values,
            top,
            scale: "residual [std of the noise]",
        };
        let name = format!("map-{}-{}-{side}", map.across, map.up).replace(' ', "-");
        Figure::new(name, Kind::Residuals, picture.picture(ink))
    };
    sides.iter().map(draw).collect()
}

/// Levels, sensors and runs are names; all else is a range of equal cells.
fn axis(quantity: &str, unit: &str, centres: &[f64]) -> Axis {
    let label = format!("{quantity} [{unit}]");
    match (quantity, centres) {
        ("level" | "sensor" | "run", _) | (_, []) => {
            let name = |value: &f64| {
                if quantity == "level" { super::words::number(*value) } else { format!("{value:.0}") }
            };
            Axis::Names { label, names: centres.iter().map(name).collect() }
        }
        (_, [first, .., last]) => {
            let half = 0.5 * (last - first) / (centres.len() - 1) as f64;
            Axis::Numbers { label, range: first - half..last + half }
        }
        (_, [only]) => Axis::Numbers { label, range: only - 0.5..only + 0.5 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each map is drawn before and after where effects are named, else once, under a name of its own.
    #[test]
    fn maps_show_both_models() {
        let map = ResidualMap {
            across: "phase".into(),
            across_unit: "periods".into(),
            x: vec![0.125, 0.375, 0.625, 0.875],
            up: "level".into(),
            up_unit: "m/s²".into(),
            y: vec![1.0, 20.0],
            before: vec![vec![1.0; 4], vec![50.0; 4]],
            after: vec![vec![1.0; 4], vec![1.0; 4]],
        };
        let exhibits = Exhibits { maps: vec![map], ..Exhibits::default() };
        let names = |named| -> Vec<String> {
            figures(&exhibits, named, Ink::File).into_iter().map(|figure| figure.name).collect()
        };
        assert_eq!(names(true), ["map-phase-level-before", "map-phase-level-after"]);
        assert_eq!(names(false), ["map-phase-level-before"]);
        let svg = &figures(&exhibits, true, Ink::File)[1].svg;
        // The scale is that of both: the scale's labels reach tens although nothing is left.
        assert!(svg.contains("20.00") && svg.contains("periods") && svg.contains(">\n10\n<"), "{svg}");
    }

    /// Cells reach half a step beyond the outer centres.
    #[test]
    fn cells_end_where_the_next_would_begin() {
        let found = axis("slip", "m", &[-0.75, -0.25, 0.25, 0.75]);
        assert_eq!(found, Axis::Numbers { label: "slip [m]".into(), range: -1.0..1.0 });
    }
}
