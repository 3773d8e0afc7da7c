//! Maps: one number over two quantities, as colour.

use super::axis::{Marks, TICK, beside};
use super::ink::Ink;
use super::sheet::{
    Drawing, Drawn, FINE, LETTER, LINE, MARGIN, Picture, Sheet, WIDTH, picture, power, shortened, width,
};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use std::ops::Range;

/// Height of the cells of a map over numbers, and of a named row, in pixels.
const NUMBERS: i32 = 230;
const STEP: i32 = 24;
/// Width of the scale beside the map, in pixels.
const SCALE: i32 = 62;
/// Steps of the scale.
const STEPS: usize = 48;
/// Most letters of a row's name, and of a column's.
const LONGEST: usize = 18;
const COLUMN: usize = 6;
/// Least distance of the names of columns, in pixels.
const GAP: i32 = 4;

/// What a map is drawn over.
#[derive(Clone, Debug, PartialEq)]
pub enum Axis {
    /// Cells of equal width over a range.
    Numbers {
        /// Label, with its unit.
        label: String,
        /// From the first cell's begin to the last one's end.
        range: Range<f64>,
    },
    /// One cell a name.
    Names {
        /// Label, with its unit.
        label: String,
        /// The names.
        names: Vec<String>,
    },
}

impl Axis {
    fn label(&self) -> &str {
        match self {
            Self::Numbers { label, .. } | Self::Names { label, .. } => label,
        }
    }

    fn range(&self) -> Range<f64> {
        match self {
            Self::Numbers { range, .. } => range.clone(),
            Self::Names { names, .. } => 0.0..names.len().max(1) as f64,
        }
    }

    fn names(&self) -> &[String] {
        match self {
            Self::Numbers { .. } => &[],
            Self::Names { names, .. } => names,
        }
    }
}

/// A map of a number from 1 upwards, on a logarithmic scale of colour; all below 1 is drawn as 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Map<'a> {
    /// Title.
    pub title: &'a str,
    /// Abscissa.
    pub x: Axis,
    /// Ordinate.
    pub y: Axis,
    /// One row an ordinate, from below; what is not finite stays empty.
    pub values: &'a [Vec<f64>],
    /// The largest number of the scale.
    pub top: f64,
    /// What the scale shows.
    pub scale: &'a str,
}

impl Drawn for Map<'_> {
    fn title(&self) -> &str {
        self.title
    }

    fn height(&self) -> i32 {
        let rows = self.y.names().len() as i32;
        let cells = if rows == 0 { NUMBERS } else { (STEP * rows).max(4 * STEP) };
        cells + 2 * MARGIN + 42 + LINE
    }

    fn draw<DB: DrawingBackend>(&self, sheet: &Sheet<DB>) -> Result<(), Drawing<DB>> {
        let (above, below) = sheet.split(LINE);
        let right = sheet.letters(LETTER, HPos::Right, VPos::Top);
        above.area.draw_text(self.scale, &right, ((WIDTH - MARGIN) * FINE, 0))?;
        let (cells, scale) = below.area.split_horizontally((WIDTH - SCALE) * FINE);
        self.cells(&Sheet { area: cells, palette: sheet.palette })?;
        self.steps(&Sheet { area: scale, palette: sheet.palette })
    }
}

impl Map<'_> {
    /// The map in the forms asked for.
    #[must_use]
    pub fn picture(&self, ink: Ink) -> Picture {
        picture(self, ink)
    }

    fn cells<DB: DrawingBackend>(&self, sheet: &Sheet<DB>) -> Result<(), Drawing<DB>> {
        let area = &sheet.area;
        let (x, y) = (self.x.range(), self.y.range());
        let [across, up] = [&x, &y].map(|range| range.end - range.start);
        let names: Vec<String> = self.y.names().iter().map(|name| shortened(name, LONGEST)).collect();
        let named = names.iter().map(|name| width(name, LETTER)).max();
        let ordinate = if named.is_some() { Marks::none(y.clone()) } else { Marks::even(y.clone()) };
        let room = named.map_or_else(|| ordinate.beside(), beside);
        let length = WIDTH - SCALE - MARGIN - room;
        let numbered = self.x.names().is_empty();
        let abscissa =
            if numbered { Marks::across(x.clone(), length - MARGIN) } else { Marks::none(x.clone()) };
        let mut chart = ChartBuilder::on(area)
            .margin(MARGIN * FINE)
            .margin_right(abscissa.right(length) * FINE)
            .x_label_area_size(40 * FINE)
            .y_label_area_size(room * FINE)
            .build_cartesian_2d(abscissa, ordinate)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .axis_style(sheet.line(sheet.palette.text()))
            .label_style(sheet.labels())
            .set_all_tick_mark_size(TICK)
            .x_desc(self.x.label())
            .y_desc(self.y.label())
            .draw()?;
        let step_y = up / self.values.len().max(1) as f64;
        for (row, values) in self.values.iter().enumerate() {
            let low = y.start + step_y * row as f64;
            let step = across / values.len().max(1) as f64;
            let cells = values.iter().enumerate().filter(|(_, value)| value.is_finite());
            chart.draw_series(cells.map(|(column, value)| {
                let left = x.start + step * column as f64;
                let corners = [(left, low), (left + step, low + step_y)];
                Rectangle::new(corners, colour(self.share(*value)).filled())
            }))?;
        }
        let base = area.get_base_pixel();
        let plot = chart.plotting_area();
        let (left, bottom) =
            (plot.get_x_axis_pixel_range().start - base.0, plot.get_y_axis_pixel_range().end - base.1);
        let beside = sheet.letters(LETTER, HPos::Right, VPos::Center);
        for (row, name) in names.iter().enumerate() {
            let (_, y) = plot.map_coordinate(&(x.start, row as f64 + 0.5));
            area.draw_text(name, &beside, (left - 5 * FINE, y - base.1))?;
        }
        let under = sheet.letters(LETTER, HPos::Center, VPos::Top);
        let names: Vec<String> = self.x.names().iter().map(|name| shortened(name, COLUMN)).collect();
        let widest = names.iter().map(|name| width(name, LETTER)).max().unwrap_or(0);
        // As many columns apart as their names need.
        let every = names.len() as i32 * (widest + GAP) / (length - MARGIN) + 1;
        for (column, name) in names.iter().enumerate().step_by(every as usize) {
            let (x, _) = plot.map_coordinate(&(column as f64 + 0.5, y.start));
            area.draw_text(name, &under, (x - base.0, bottom + 5 * FINE))?;
        }
        Ok(())
    }

    /// Place of a number on the scale, 0 to 1.
    pub(super) fn share(&self, value: f64) -> f64 {
        (value.max(1.0).ln() / self.top.max(1.0 + 1e-9).ln()).clamp(0.0, 1.0)
    }

    fn steps<DB: DrawingBackend>(&self, sheet: &Sheet<DB>) -> Result<(), Drawing<DB>> {
        let area = &sheet.area;
        let decades = self.top.max(1.0 + 1e-9).log10();
        let mut chart = ChartBuilder::on(area)
            .margin_top(MARGIN * FINE)
            .margin_bottom((MARGIN + 40) * FINE)
            .margin_right(4 * FINE)
            .right_y_label_area_size(40 * FINE)
            .build_cartesian_2d(Marks::none(0.0..1.0), Marks::decades(0.0..decades))?;
        chart
            .configure_mesh()
            .disable_mesh()
            .axis_style(sheet.palette.paper())
            .label_style(sheet.labels())
            .y_label_formatter(&|exponent| label(*exponent))
            .draw()?;
        chart.draw_series((0..STEPS).map(|step| {
            let [low, high] = [step, step + 1].map(|k| decades * k as f64 / STEPS as f64);
            Rectangle::new([(0.0, low), (1.0, high)], colour((step as f64 + 0.5) / STEPS as f64).filled())
        }))?;
        Ok(())
    }
}

/// A number of the scale, given by its exponent: two digits as far as they are read at a glance.
fn label(exponent: f64) -> String {
    let value = 10_f64.powf(exponent);
    if value < 9.95 {
        format!("{value:.1}")
    } else if value < 9999.5 {
        format!("{value:.0}")
    } else {
        power(exponent)
    }
}

/// Viridis: dark where there is little, light where there is much, also to who sees no colours.
fn colour(share: f64) -> RGBColor {
    ViridisRGB.get_color_normalized(share, 0.0, 1.0)
}
