//! Charts as SVG text and as PNG, in ink of the page they stand on.
//!
//! Colours are CSS variables in the report, so that one picture serves light, dark and print, and fixed in files that stand alone.

mod axis;
mod ink;
mod map;
#[cfg(test)]
mod overlap;
mod png;
mod rows;
mod sheet;
#[cfg(test)]
mod tests;

pub use ink::{Ink, Role};
pub use map::{Axis, Map};
pub use rows::{Row, Rows};
pub use sheet::Picture;

use axis::{Marks, TICK};
use ink::Palette;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use sheet::{Drawing, Drawn, FINE, LETTER, LINE, MARGIN, Sheet, WIDTH, picture, range, width};

/// How the points of a curve are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mark {
    Line,
    Dashes,
    Dots,
}

/// One curve.
#[derive(Clone, Debug)]
pub struct Curve<'a> {
    name: &'a str,
    role: Role,
    mark: Mark,
    x: &'a [f64],
    y: &'a [f64],
}

impl<'a> Curve<'a> {
    /// A line through points; points that are not finite leave a gap. A curve without a name is not in the legend.
    #[must_use]
    pub fn line(name: &'a str, role: Role, x: &'a [f64], y: &'a [f64]) -> Self {
        Self { name, role, mark: Mark::Line, x, y }
    }

    /// The same, dashed.
    #[must_use]
    pub fn dashed(name: &'a str, role: Role, x: &'a [f64], y: &'a [f64]) -> Self {
        Self { mark: Mark::Dashes, ..Self::line(name, role, x, y) }
    }

    /// The points themselves.
    #[must_use]
    pub fn dots(name: &'a str, role: Role, x: &'a [f64], y: &'a [f64]) -> Self {
        Self { mark: Mark::Dots, ..Self::line(name, role, x, y) }
    }

    fn style(&self, palette: Palette) -> ShapeStyle {
        let width = if self.role == Role::Measured && self.mark == Mark::Line { 10 } else { 7 };
        let style = palette.role(self.role).stroke_width(width);
        if self.mark == Mark::Dots { style.filled() } else { style }
    }
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

/// Height of the axes and what stands beside them, in pixels.
const BODY: i32 = 290;
/// Length of the stroke before a name in the legend, in pixels.
const STROKE: i32 = 18;
/// Most letters of a name in the legend.
const LONGEST: usize = 40;

/// A name in the legend: its place in pixels, from the legend's corner.
struct Entry {
    name: String,
    curve: usize,
    place: (i32, i32),
}

impl Drawn for Chart<'_> {
    fn title(&self) -> &str {
        self.title
    }

    fn height(&self) -> i32 {
        self.legend().1 + BODY
    }

    fn draw<DB: DrawingBackend>(&self, sheet: &Sheet<DB>) -> Result<(), Drawing<DB>> {
        let (entries, height) = self.legend();
        let (above, below) = sheet.split(height);
        entries.iter().try_for_each(|entry| self.name(&above, entry))?;
        self.axes(&below)
    }
}

impl Chart<'_> {
    /// The chart in the forms asked for.
    #[must_use]
    pub fn picture(&self, ink: Ink) -> Picture {
        picture(self, ink)
    }

    /// Names in rows above the axes, where they hide nothing, and the height they take; one curve alone needs no name.
    fn legend(&self) -> (Vec<Entry>, i32) {
        let named: Vec<usize> = (0..self.curves.len()).filter(|k| !self.curves[*k].name.is_empty()).collect();
        if named.len() < 2 {
            return (Vec::new(), 0);
        }
        let (mut x, mut row) = (2 * MARGIN, 0);
        let mut entries = Vec::new();
        for curve in named {
            let name = sheet::shortened(self.curves[curve].name, LONGEST);
            let wide = STROKE + 5 + width(&name, LETTER);
            if x > 2 * MARGIN && x + wide > WIDTH - MARGIN {
                (x, row) = (2 * MARGIN, row + 1);
            }
            entries.push(Entry { name, curve, place: (x, row * LINE) });
            x += wide + 14;
        }
        (entries, (row + 1) * LINE)
    }

    fn name<DB: DrawingBackend>(&self, sheet: &Sheet<DB>, entry: &Entry) -> Result<(), Drawing<DB>> {
        let (x, y) = (entry.place.0 * FINE, entry.place.1 * FINE);
        let middle = y + LINE * FINE / 2;
        let curve = &self.curves[entry.curve];
        let (area, style) = (&sheet.area, curve.style(sheet.palette));
        let ends = [(x, middle), (x + STROKE * FINE, middle)];
        match curve.mark {
            Mark::Line => area.draw(&PathElement::new(ends, style))?,
            Mark::Dashes => {
                area.draw(&DashedPathElement::new(ends, DASH, GAP, style))?;
            }
            Mark::Dots => area.draw(&Circle::new((x + STROKE * FINE / 2, middle), DOT, style))?,
        }
        let style = sheet.letters(LETTER, HPos::Left, VPos::Center);
        area.draw_text(&entry.name, &style, (x + (STROKE + 5) * FINE, middle))
    }

    fn axes<DB: DrawingBackend>(&self, sheet: &Sheet<DB>) -> Result<(), Drawing<DB>> {
        let palette = sheet.palette;
        let shown: Vec<Vec<(f64, f64)>> = self.curves.iter().map(|curve| self.points(curve)).collect();
        let x = range(shown.iter().flatten().map(|point| point.0));
        let y = range(shown.iter().flatten().map(|point| point.1));
        let y = if self.logarithmic { Marks::decades(y) } else { Marks::even(y) };
        let beside = y.beside();
        let x = Marks::across(x, WIDTH - 2 * MARGIN - beside);
        let mut chart = ChartBuilder::on(&sheet.area)
            .margin(MARGIN * FINE)
            .margin_right(x.right(WIDTH - MARGIN - beside) * FINE)
            .x_label_area_size(40 * FINE)
            .y_label_area_size(beside * FINE)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .bold_line_style(sheet.line(palette.grid()))
            .axis_style(sheet.line(palette.text()))
            .label_style(sheet.labels())
            .set_all_tick_mark_size(TICK)
            .x_desc(self.x_label)
            .y_desc(self.y_label)
            .draw()?;
        for (curve, points) in self.curves.iter().zip(&shown) {
            let style = curve.style(palette);
            match curve.mark {
                Mark::Line => {
                    chart.draw_series(pieces(points).map(|piece| PathElement::new(piece, style)))?
                }
                Mark::Dashes => chart.draw_series(
                    pieces(points).map(|piece| DashedPathElement::new(piece, DASH, GAP, style)),
                )?,
                Mark::Dots => {
                    chart.draw_series(pieces(points).flatten().map(|point| Circle::new(point, DOT, style)))?
                }
            };
        }
        Ok(())
    }

    /// Points to draw; a point that cannot be drawn becomes NaN and cuts the line.
    fn points(&self, curve: &Curve<'_>) -> Vec<(f64, f64)> {
        let height = |y: f64| if self.logarithmic { y.log10() } else { y };
        curve.x.iter().zip(curve.y).map(|(&x, &y)| (x, height(y))).collect()
    }
}

const DASH: i32 = 6 * FINE;
const GAP: i32 = 4 * FINE;
const DOT: i32 = 3 * FINE;

/// Runs of consecutive finite points.
fn pieces(points: &[(f64, f64)]) -> impl Iterator<Item = Vec<(f64, f64)>> + '_ {
    points
        .split(|(x, y)| !(x.is_finite() && y.is_finite()))
        .filter(|piece| !piece.is_empty())
        .map(<[_]>::to_vec)
}
