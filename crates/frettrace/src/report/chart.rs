//! Charts as SVG text, in ink of the page they stand on.
//!
//! Charts are drawn with marker colours; [`Ink`] replaces them: by CSS variables in the report, so that one picture
//! serves light, dark and print, and by fixed colours in files that stand alone.

use plotters::prelude::*;

/// Marker colours of the four roles a mark can have.
const PAPER: RGBColor = RGBColor(1, 2, 3);
const TEXT: RGBColor = RGBColor(4, 5, 6);
const GRID: RGBColor = RGBColor(7, 8, 9);
const SERIES: [RGBColor; 3 + NUMBERED.len()] = {
    let mut markers = [RGBColor(0, 0, 0); 3 + NUMBERED.len()];
    let mut index = 0;
    while index < markers.len() {
        let first = 10 + 3 * index as u8;
        markers[index] = RGBColor(first, first + 1, first + 2);
        index += 1;
    }
    markers
};
/// Colours of numbered curves, as many as a ladder of levels has rungs or a beam sensors: in the order of the spectrum, so that
/// the order of levels shows; dark at both ends and light in the middle, so that those that colour-blindness brings together
/// differ in lightness.
const NUMBERED: [&str; 8] =
    ["#2a1a6e", "#1f6fd0", "#00a0a8", "#2a9d3a", "#a8a000", "#e08a00", "#d43a1f", "#8a0a3c"];

/// Where a chart will stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// In the report: colours are CSS variables of the page.
    Page,
    /// In a file of its own: dark on white.
    File,
}

impl Ink {
    /// Colours in the order paper, text, grid, roles.
    fn colours(self) -> [&'static str; 6] {
        match self {
            Self::Page => [
                "var(--paper)",
                "var(--text)",
                "var(--grid)",
                "var(--measured)",
                "var(--before)",
                "var(--after)",
            ],
            Self::File => ["#ffffff", "#1a1a1a", "#dddddd", "#1a1a1a", "#d55e00", "#0072b2"],
        }
    }
}

/// Role of a curve; its colour is the same in every chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// What was measured or recovered.
    Measured,
    /// The declared model.
    Before,
    /// The model with the effects in it.
    After,
    /// One of several curves of equal standing, by its number.
    Number(usize),
}

impl Role {
    fn index(self) -> usize {
        match self {
            Self::Measured => 0,
            Self::Before => 1,
            Self::After => 2,
            Self::Number(number) => 3 + number % NUMBERED.len(),
        }
    }
}

/// One curve.
#[derive(Clone, Debug)]
pub struct Curve<'a> {
    /// Name in the legend.
    pub name: &'a str,
    /// Role, which gives the colour.
    pub role: Role,
    /// Abscissae.
    pub x: &'a [f64],
    /// Ordinates; points that are not finite leave a gap.
    pub y: &'a [f64],
}

/// A chart of curves over common axes.
#[derive(Clone, Debug)]
pub struct Chart<'a> {
    /// Title.
    pub title: &'a str,
    /// Label of the abscissa, with its unit.
    pub x_label: &'a str,
    /// Label of the ordinate, with its unit.
    pub y_label: &'a str,
    /// Whether the ordinate is logarithmic; then only positive ordinates are drawn.
    pub logarithmic: bool,
    /// The curves, drawn in this order.
    pub curves: Vec<Curve<'a>>,
}

const SIZE: (u32, u32) = (560, 380);

impl Chart<'_> {
    /// The chart as one SVG element.
    #[must_use]
    pub fn svg(&self, ink: Ink) -> String {
        let mut text = String::new();
        {
            let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
            let drawn = self.draw(&root);
            debug_assert!(drawn.is_ok(), "drawing into a string cannot fail");
        }
        dress(&text, ink, self.title)
    }

    fn draw(&self, root: &Area<'_>) -> Result<(), Drawing> {
        let shown: Vec<Vec<(f64, f64)>> = self.curves.iter().map(|curve| self.points(curve)).collect();
        let x = range(shown.iter().flatten().map(|point| point.0));
        let y = range(shown.iter().flatten().map(|point| point.1));
        root.fill(&PAPER)?;
        let mut chart = ChartBuilder::on(root)
            .caption(self.title, ("sans-serif", 18).into_font().color(&TEXT))
            .margin(10)
            .x_label_area_size(42)
            .y_label_area_size(72)
            .build_cartesian_2d(x.clone(), y.clone())?;
        let place = emptiest(&shown, &x, &y);
        let [across, up] = [&x, &y].map(|range| range.end - range.start);
        let plain_x = |value: &f64| short(*value, across);
        let plain_y = |value: &f64| short(*value, up);
        let power = |exponent: &f64| format!("{:.1e}", 10_f64.powf(*exponent));
        chart
            .configure_mesh()
            .x_labels(6)
            .y_labels(6)
            .light_line_style(PAPER)
            .bold_line_style(GRID)
            .axis_style(TEXT)
            .label_style(("sans-serif", 13).into_font().color(&TEXT))
            .x_label_formatter(&plain_x)
            .y_label_formatter(if self.logarithmic { &power } else { &plain_y })
            .x_desc(self.x_label)
            .y_desc(self.y_label)
            .draw()?;
        for (curve, points) in self.curves.iter().zip(shown) {
            let colour = SERIES[curve.role.index()];
            let style = colour.stroke_width(if curve.role == Role::Measured { 3 } else { 2 });
            chart
                .draw_series(pieces(&points).map(|piece| PathElement::new(piece, style)))?
                .label(curve.name)
                .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], style));
        }
        chart
            .configure_series_labels()
            .position(place)
            .label_font(("sans-serif", 13).into_font().color(&TEXT))
            .background_style(PAPER)
            .border_style(GRID)
            .draw()?;
        Ok(())
    }

    /// Points to draw; a point that cannot be drawn becomes NaN and cuts the line.
    fn points(&self, curve: &Curve<'_>) -> Vec<(f64, f64)> {
        let height = |y: f64| if self.logarithmic { y.log10() } else { y };
        curve.x.iter().zip(curve.y).map(|(&x, &y)| (x, height(y))).collect()
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type Drawing = DrawingAreaErrorKind<std::io::Error>;

/// Runs of consecutive finite points.
fn pieces(points: &[(f64, f64)]) -> impl Iterator<Item = Vec<(f64, f64)>> + '_ {
    points
        .split(|(x, y)| !(x.is_finite() && y.is_finite()))
        .filter(|piece| !piece.is_empty())
        .map(<[_]>::to_vec)
}

/// Smallest range that holds all finite values, with a margin of 5 %; never empty.
fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low > high {
        return 0.0..1.0;
    }
    let margin = if high > low { 0.05 * (high - low) } else { low.abs().max(1.0) * 0.05 };
    low - margin..high + margin
}

/// The ninth of the plot with the fewest points in it: there the legend hides least.
fn emptiest(
    shown: &[Vec<(f64, f64)>],
    x: &std::ops::Range<f64>,
    y: &std::ops::Range<f64>,
) -> SeriesLabelPosition {
    use SeriesLabelPosition as At;
    let places = [
        [At::LowerRight, At::MiddleRight, At::UpperRight],
        [At::LowerLeft, At::MiddleLeft, At::UpperLeft],
        [At::LowerMiddle, At::MiddleMiddle, At::UpperMiddle],
    ];
    let third = |value: f64, range: &std::ops::Range<f64>| {
        (3.0 * (value - range.start) / (range.end - range.start)).clamp(0.0, 2.0) as usize
    };
    let mut counts = [[0_usize; 3]; 3];
    for (across, up) in shown.iter().flatten().filter(|(x, y)| x.is_finite() && y.is_finite()) {
        let column = [1, 2, 0][third(*across, x)];
        counts[column][third(*up, y)] += 1;
    }
    let all = places.into_iter().flatten().zip(counts.into_iter().flatten());
    all.min_by_key(|(_, count)| *count).map_or(At::UpperRight, |(place, _)| place)
}

/// A number with few digits, for an axis that spans `span`.
fn short(value: f64, span: f64) -> String {
    if value.abs() < 1e-9 * span {
        "0".into()
    } else if (1e-3..1e5).contains(&value.abs()) {
        format!("{:.4}", value).trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{value:.1e}")
    }
}

/// Replaces marker colours, makes the picture scale with the page, and names it for screen readers.
fn dress(svg: &str, ink: Ink, title: &str) -> String {
    let markers = [PAPER, TEXT, GRID].into_iter().chain(SERIES);
    let mut text = svg.to_owned();
    for (marker, colour) in markers.zip(ink.colours().into_iter().chain(NUMBERED)) {
        text = text.replace(&format!("#{:02X}{:02X}{:02X}", marker.0, marker.1, marker.2), colour);
    }
    let size = format!("width=\"{}\" height=\"{}\"", SIZE.0, SIZE.1);
    let label = format!("role=\"img\" aria-label=\"{}\"", super::escape(title));
    match ink {
        Ink::Page => text.replacen(&size, &label, 1),
        Ink::File => text.replacen(&size, &format!("{size} {label}"), 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart<'a>(x: &'a [f64], y: &'a [f64]) -> Chart<'a> {
        let curves = vec![Curve { name: "measured", role: Role::Measured, x, y }];
        Chart { title: "a <loop>", x_label: "slip [m]", y_label: "force [N]", logarithmic: false, curves }
    }

    /// No marker colour is left, and the page's picture takes its colours from the page.
    #[test]
    fn colours_belong_to_the_page() {
        let (x, y) = ([0.0, 1.0, 2.0], [0.0, 1.0, 0.5]);
        let page = chart(&x, &y).svg(Ink::Page);
        assert!(page.contains("var(--measured)") && page.contains("var(--paper)"), "{page}");
        assert!(!page.contains("#0") && page.contains("a &lt;loop&gt;"), "{page}");
        assert!(chart(&x, &y).svg(Ink::File).contains("#ffffff"));
    }

    /// A gap cuts the line in two; nothing that is not a number reaches the picture.
    #[test]
    fn a_gap_cuts_the_line() {
        let svg = chart(&[0.0, 1.0, 2.0, 3.0, 4.0], &[0.0, 1.0, f64::NAN, 1.0, 0.0]).svg(Ink::File);
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert_eq!(pieces(&[(0.0, 0.0), (1.0, f64::NAN), (2.0, 0.0)]).count(), 2);
    }

    /// Eight levels have eight colours, all of them in the picture.
    #[test]
    fn eight_levels_are_told_apart() {
        let (x, y) = ([0.0, 1.0], [[0.0, 1.0], [1.0, 2.0], [2.0, 3.0], [3.0, 4.0]]);
        let names: Vec<String> = (0..8).map(|level| format!("level {level}")).collect();
        let curves = names.iter().enumerate().map(|(level, name)| {
            let y = &y[level % y.len()];
            Curve { name, role: Role::Number(level), x: &x, y }
        });
        let chart = Chart { curves: curves.collect(), ..chart(&x, &y[0]) };
        let svg = chart.svg(Ink::File);
        assert!(NUMBERED.iter().all(|colour| svg.contains(colour)), "{svg}");
    }

    #[test]
    fn an_empty_chart_still_draws() {
        assert!(chart(&[], &[]).svg(Ink::File).contains("</svg>"));
    }
}
