//! Charts of named rows: bars from zero, and intervals about a value.

use super::axis::{Marks, TICK};
use super::ink::{Ink, Palette, Role};
use super::sheet::{
    Drawing, Drawn, FINE, LETTER, LINE, MARGIN, Picture, Sheet, WIDTH, picture, range, shortened, width,
};
use plotters::coord::CoordTranslate;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Most letters of a row's name and of the note behind it.
const LONGEST: usize = 34;
/// Height of a row, in pixels.
const STEP: i32 = LINE + 3;
/// Share of the axis that notes may take.
const MOST: f64 = 0.6;

/// One row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name before it.
    pub name: String,
    /// Role, which gives the colour.
    pub role: Role,
    /// Where the mark begins and ends; nothing is drawn where they are not finite.
    pub span: [f64; 2],
    /// The value inside an interval, drawn as a dot; bars have none.
    pub value: Option<f64>,
    /// What stands behind the mark.
    pub note: String,
}

impl Row {
    /// A bar from zero.
    #[must_use]
    pub fn bar(name: String, role: Role, value: f64, note: String) -> Self {
        Self { name, role, span: [0.0, value], value: None, note }
    }

    fn end(&self) -> f64 {
        self.span.into_iter().filter(|end| end.is_finite()).fold(0.0, f64::max)
    }
}

/// A chart of named rows, the first one on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows<'a> {
    /// Title.
    pub title: &'a str,
    /// Label of the abscissa, with its unit.
    pub x_label: &'a str,
    /// The rows.
    pub rows: Vec<Row>,
}

impl Rows<'_> {
    /// The chart in the forms asked for.
    #[must_use]
    pub fn picture(&self, ink: Ink) -> Picture {
        picture(self, ink)
    }
}

impl Drawn for Rows<'_> {
    fn title(&self) -> &str {
        self.title
    }

    fn height(&self) -> i32 {
        2 * MARGIN + 44 + STEP * self.rows.len().max(1) as i32
    }

    fn draw<DB: DrawingBackend>(&self, sheet: &Sheet<DB>) -> Result<(), Drawing<DB>> {
        let (area, palette) = (&sheet.area, sheet.palette);
        let names: Vec<String> = self.rows.iter().map(|row| shortened(&row.name, LONGEST)).collect();
        let room = names.iter().map(|name| width(name, LETTER)).max().unwrap_or(0) + 2 * MARGIN;
        let ends = self.rows.iter().flat_map(|row| row.span.into_iter().chain([0.0]));
        let mut x = range(ends);
        let notes = self.rows.iter().map(|row| width(&shortened(&row.note, LONGEST), LETTER));
        let axis = f64::from(WIDTH - 2 * MARGIN - room);
        let free = f64::from(notes.max().unwrap_or(0) + MARGIN).min(MOST * axis);
        x.end = x.start + (x.end - x.start) * axis / (axis - free);
        let x = Marks::across(x, WIDTH - 2 * MARGIN - room);
        let mut chart = ChartBuilder::on(area)
            .margin(MARGIN * FINE)
            .margin_right(x.right(WIDTH - MARGIN - room) * FINE)
            .x_label_area_size(40 * FINE)
            .y_label_area_size(room * FINE)
            .build_cartesian_2d(x, Marks::none(0.0..self.rows.len().max(1) as f64))?;
        chart
            .configure_mesh()
            .bold_line_style(sheet.line(palette.grid()))
            .axis_style(sheet.line(palette.text()))
            .label_style(sheet.labels())
            .set_all_tick_mark_size(TICK)
            .x_desc(self.x_label)
            .draw()?;
        for (number, (row, name)) in self.rows.iter().zip(&names).enumerate() {
            let middle = (self.rows.len() - number) as f64 - 0.5;
            draw_mark(chart.plotting_area(), palette, (row, middle))?;
            let at = |x: f64| chart.plotting_area().map_coordinate(&(x, middle));
            let left = chart.plotting_area().get_x_axis_pixel_range().start - 6 * FINE;
            let base = area.get_base_pixel();
            let (x, y) = at(row.end());
            let before = sheet.letters(LETTER, HPos::Right, VPos::Center);
            let behind = sheet.letters(LETTER, HPos::Left, VPos::Center);
            area.draw_text(name, &before, (left - base.0, y - base.1))?;
            area.draw_text(&shortened(&row.note, LONGEST), &behind, (x + 5 * FINE - base.0, y - base.1))?;
        }
        Ok(())
    }
}

/// The bar, or the interval with its value; nothing where they are not known.
fn draw_mark<DB, C>(
    area: &DrawingArea<DB, C>,
    palette: Palette,
    (row, middle): (&Row, f64),
) -> Result<(), Drawing<DB>>
where
    DB: DrawingBackend,
    C: CoordTranslate<From = (f64, f64)>,
{
    let [from, to] = row.span;
    let colour = palette.role(row.role);
    if !(from.is_finite() && to.is_finite()) {
        return Ok(());
    }
    let Some(value) = row.value else {
        let corners = [(from, middle - 0.32), (to, middle + 0.32)];
        return area.draw(&Rectangle::new(corners, colour.filled()));
    };
    area.draw(&PathElement::new([(from, middle), (to, middle)], colour.stroke_width(10)))?;
    area.draw(&Circle::new((value, middle), 4 * FINE, colour.filled()))
}
