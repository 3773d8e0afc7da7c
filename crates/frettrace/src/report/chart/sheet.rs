//! The sheet that every chart is drawn on: title, room, text, numbers on axes.

use super::ink::{Ink, Palette};
use super::png;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;
use std::sync::Once;

/// Width of every chart in pixels: half a desktop's column and a little more than a phone's, so that letters stay legible on both.
pub(super) const WIDTH: i32 = 480;
/// Units of the drawing in a pixel: plotters places points on whole units, and stairs of a pixel would be seen.
pub(super) const FINE: i32 = 4;
/// Size of letters on axes, in pixels.
pub(super) const LETTER: i32 = 12;
/// Room for a line of text, in pixels.
pub(super) const LINE: i32 = 17;
const TITLE: i32 = 14;
/// Room around a chart, in pixels.
pub(super) const MARGIN: i32 = 8;

pub(super) type Drawing<DB> = DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>;

/// A picture in the forms asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// One SVG element.
    pub svg: String,
    /// A PNG file.
    pub png: Option<Vec<u8>>,
}

/// What is drawn under a title.
pub(super) trait Drawn {
    /// The title.
    fn title(&self) -> &str;
    /// Height below the title, in pixels.
    fn height(&self) -> i32;
    /// Draws it.
    fn draw<DB: DrawingBackend>(&self, sheet: &Sheet<DB>) -> Result<(), Drawing<DB>>;
}

/// Part of a picture, and the colours it is drawn in.
pub(super) struct Sheet<DB: DrawingBackend> {
    pub area: DrawingArea<DB, Shift>,
    pub palette: Palette,
}

impl<DB: DrawingBackend> Sheet<DB> {
    /// Type of a size in pixels at an anchor; the backend divides its sizes by 1.24.
    pub(super) fn letters(&self, pixels: i32, across: HPos, up: VPos) -> TextStyle<'static> {
        let style = ("sans-serif", 1.24 * f64::from(pixels * FINE)).into_font().color(&self.palette.text());
        style.pos(Pos::new(across, up))
    }

    /// Letters on axes, as the mesh wants them.
    pub(super) fn labels(&self) -> TextStyle<'static> {
        self.letters(LETTER, HPos::Left, VPos::Top)
    }

    /// Lines of axes and grid.
    pub(super) fn line(&self, colour: RGBColor) -> ShapeStyle {
        colour.stroke_width(FINE as u32)
    }

    /// The upper `height` pixels, and the rest.
    pub(super) fn split(&self, height: i32) -> (Self, Self) {
        let (above, below) = self.area.split_vertically(height * FINE);
        (Self { area: above, palette: self.palette }, Self { area: below, palette: self.palette })
    }

    /// Paper and title; the rest of the sheet is left.
    fn titled(&self, lines: &[String]) -> Result<Self, Drawing<DB>> {
        self.area.fill(&self.palette.paper())?;
        let style = self.letters(TITLE, HPos::Center, VPos::Top);
        for (number, line) in lines.iter().enumerate() {
            let place = (WIDTH / 2 * FINE, (MARGIN + (LINE + 2) * number as i32) * FINE);
            self.area.draw_text(line, &style, place)?;
        }
        Ok(self.split(head(lines)).1)
    }
}

/// Room for the title, in pixels.
fn head(lines: &[String]) -> i32 {
    MARGIN + (LINE + 2) * lines.len() as i32
}

/// A chart of [`WIDTH`] pixels under its title; as SVG an element that says its title to who cannot see it.
pub(super) fn picture(of: &impl Drawn, ink: Ink) -> Picture {
    font();
    let lines = wrapped(of.title(), WIDTH - 2 * MARGIN, TITLE);
    let height = head(&lines) + of.height();
    let size = ((WIDTH * FINE) as u32, (height * FINE) as u32);
    let mut text = String::new();
    paint(SVGBackend::with_string(&mut text, size), of, &lines, ink);
    let drawn = format!("width=\"{}\" height=\"{}\"", size.0, size.1);
    let label = format!("role=\"img\" aria-label=\"{}\"", super::super::escape(of.title()));
    let shown = match ink {
        Ink::Page => label,
        Ink::File | Ink::FileAndPng => format!("width=\"{WIDTH}\" height=\"{height}\" {label}"),
    };
    // Cells of a map touch: without this the paper shines through between them.
    let svg =
        ink.dye(text).replace("<rect ", "<rect shape-rendering=\"crispEdges\" ").replacen(&drawn, &shown, 1);
    let png = (ink == Ink::FileAndPng).then(|| {
        let mut dots = vec![0; 3 * (size.0 * size.1) as usize];
        paint(BitMapBackend::with_buffer(&mut dots, size), of, &lines, ink);
        png::encoded(&dots, size)
    });
    Picture { svg, png }
}

fn paint<DB: DrawingBackend>(backend: DB, of: &impl Drawn, lines: &[String], ink: Ink) {
    let root = Sheet { area: backend.into_drawing_area(), palette: ink.palette() };
    let drawn = root.titled(lines).and_then(|below| of.draw(&below));
    debug_assert!(drawn.is_ok(), "drawing into memory cannot fail");
}

/// Letters of Latin, Greek and Cyrillic with the signs of a formula; what the font lacks shows as an empty box in a PNG.
fn font() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let known = register_font("sans-serif", FontStyle::Normal, include_bytes!("../font/DejaVuSans.ttf"));
        debug_assert!(known.is_ok(), "the font is part of the program");
    });
}

/// Width of a text in pixels, in the font that PNG are drawn with: it is a wide one, a browser's own takes no more.
pub(super) fn width(text: &str, letter: i32) -> i32 {
    font();
    let measured = ("sans-serif", 1.24 * f64::from(letter * FINE)).into_font().box_size(text);
    // Only a font that is not there cannot be measured: then a letter is as wide as high.
    measured.map_or(text.chars().count() as i32 * letter, |(wide, _)| (wide as i32 + FINE - 1) / FINE)
}

/// A text in lines of at most `room` pixels, broken at blanks; a word that is longer alone is cut.
fn wrapped(text: &str, room: i32, letter: i32) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let fitting = (2..=word.chars().count()).rev().map(|most| shortened(word, most));
        let word =
            fitting.into_iter().find(|word| width(word, letter) <= room).unwrap_or_else(|| word.to_owned());
        let Some(line) = lines.last_mut() else { break };
        let longer = if line.is_empty() { word.clone() } else { format!("{line} {word}") };
        if line.is_empty() || width(&longer, letter) <= room {
            *line = longer;
        } else {
            lines.push(word);
        }
    }
    lines
}

/// At most `most` letters; what is cut off leaves an ellipsis.
pub(super) fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(1)).chain(['…']).collect()
}

/// Smallest range that holds all finite values, with a margin of 5 %; never empty.
pub(super) fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low > high {
        return 0.0..1.0;
    }
    let margin = if high > low { 0.05 * (high - low) } else { low.abs().max(1.0) * 0.05 };
    low - margin..high + margin
}

/// A number with as many digits as its neighbours on an axis that spans `span` need to differ: down to a hundredth of the span's own decade;
/// five digits where no span is given.
pub(super) fn short(value: f64, span: f64) -> String {
    let size = value.abs();
    let span = if span > 0.0 { span } else { 1e-2 * size };
    let last = span.log10().floor() - 2.0;
    if size < 1e-9 * span {
        "0".into()
    } else if (1e-3..1e5).contains(&size) {
        let digits = (-last).clamp(0.0, 12.0) as usize;
        trimmed(&format!("{value:.digits$}"))
    } else {
        let exponent = size.log10().floor();
        let digits = (exponent - last).clamp(0.0, 12.0) as usize;
        scientific(value / 10_f64.powf(exponent), exponent, digits)
    }
}

/// Without zeros at its end, and with a real minus sign.
fn trimmed(number: &str) -> String {
    let number =
        if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number };
    number.replace('-', "−")
}

/// A power of ten on a logarithmic axis, given by its exponent.
pub(super) fn power(exponent: f64) -> String {
    let whole = exponent.floor();
    scientific(10_f64.powf(exponent - whole), whole, 2)
}

/// `2.5·10⁻³`, with so many digits behind the point; without the factor where it is one.
fn scientific(factor: f64, exponent: f64, digits: usize) -> String {
    let carried = format!("{factor:.digits$}").trim_start_matches('-').starts_with("10");
    let (factor, exponent) = if carried { (factor / 10.0, exponent + 1.0) } else { (factor, exponent) };
    let raised: String = format!("{exponent:.0}").chars().map(superscript).collect();
    match trimmed(&format!("{factor:.digits$}")).as_str() {
        "1" => format!("10{raised}"),
        "−1" => format!("−10{raised}"),
        factor => format!("{factor}·10{raised}"),
    }
}

fn superscript(letter: char) -> char {
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    letter.to_digit(10).and_then(|digit| digits.get(digit as usize).copied()).unwrap_or('⁻')
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers on axes are short and have real minus signs and exponents.
    #[test]
    fn numbers_are_short() {
        assert_eq!(short(-0.25, 1.0), "−0.25");
        assert_eq!(short(2.5e-6, 1e-5), "2.5·10⁻⁶");
        assert_eq!(short(1e-17, 1.0), "0");
        assert_eq!(short(-1e6, 1e6), "−10⁶");
        // Neighbours a fifth of the span apart differ; 0.01225 ± 0.00002.
        assert_eq!([short(0.01224, 4e-5), short(0.01225, 4e-5)], ["0.01224", "0.01225"]);
        assert_eq!([short(1.2345e-6, 2e-9), short(100_000.5, 1.0)], ["1.2345·10⁻⁶", "1.000005·10⁵"]);
        assert_eq!([short(20.0, 0.0), short(-40.0, 90.0)], ["20", "−40"]);
        assert_eq!(power(-2.0), "10⁻²");
        // 10^0.5 = 3.162
        assert_eq!(power(0.5), "3.16·10⁰");
    }

    /// A long title takes several lines, a word without end is cut, and no line is wider than its room.
    #[test]
    fn titles_are_wrapped() {
        let text = format!("Friction, run 0003, {} (held out)", "x".repeat(200));
        let lines = wrapped(&text, 464, TITLE);
        assert!(lines.len() == 3 && lines[1].ends_with('…'), "{lines:?}");
        assert!(lines.iter().all(|line| width(line, TITLE) <= 464), "{lines:?}");
    }
}
