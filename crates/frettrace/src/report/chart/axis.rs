//! Axes whose marks are known before they are drawn, so that room can be kept for their numbers.
//!
//! A number on an axis may touch neither its neighbour, nor the axis' title, nor the edge of the sheet. With the widths `w` of the numbers, the
//! distance `d` of two marks, the share `s` of the axis before its last mark and the length `A` that axis and right margin `r` have
//! together, all in pixels:
//!
//! - the ordinate keeps two strokes, the widest number, a gap and the title's line beside it;
//! - the abscissa takes as many marks as leave `d ≥ w + gap`;
//! - its last number ends where the sheet does: `w/2 ≤ (1 − s)(A − r) + r`, thus `r ≥ (w/2 − (1 − s)A)/s`.

use super::sheet::{FINE, LETTER, LINE, MARGIN, power, short, width};
use plotters::coord::ranged1d::{BoldPoints, KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use std::ops::Range;

/// Length of the stroke at a mark, in units of the drawing.
pub(super) const TICK: i32 = 4 * FINE;
/// Least distance of two texts, in pixels.
const GAP: i32 = 5;
/// Most marks of an axis.
const MOST: usize = 6;
/// Fewest decades whose powers of ten are marks enough.
const DECADES: f64 = 2.0;
/// Marks within a decade where there are fewer.
const WITHIN: [f64; 3] = [1.0, 2.0, 5.0];

/// What stands at the marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Numbers {
    /// The places themselves.
    Plain,
    /// Powers of ten whose exponents the places are, written as such.
    Powers,
    /// The same, written out.
    Written,
}

/// An axis with its marks.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Marks {
    range: Range<f64>,
    places: Vec<f64>,
    numbers: Numbers,
}

impl Marks {
    /// No marks: what stands beside the axis is placed by hand.
    pub(super) fn none(range: Range<f64>) -> Self {
        Self { range, places: Vec::new(), numbers: Numbers::Plain }
    }

    /// At most six marks at round numbers.
    pub(super) fn even(range: Range<f64>) -> Self {
        Self { places: round(&range, MOST), range, numbers: Numbers::Plain }
    }

    /// As many marks at round numbers as leave their numbers apart on an axis of so many pixels.
    pub(super) fn across(range: Range<f64>, axis: i32) -> Self {
        let fewer =
            (1..MOST).rev().map(|most| Self { places: round(&range, most), ..Self::even(range.clone()) });
        let apart = |marks: &Self| {
            let step = marks.places.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
            step / marks.span() * f64::from(axis) >= f64::from(marks.widest() + GAP)
        };
        std::iter::once(Self::even(range.clone())).chain(fewer).find(apart).unwrap_or(Self::none(range))
    }

    /// Marks over exponents of ten: at whole ones, at most seven; within few decades at 1, 2 and 5; in less at round numbers.
    pub(super) fn decades(range: Range<f64>) -> Self {
        let span = range.end - range.start;
        if span >= DECADES {
            let every = (span / MOST as f64).ceil();
            let first = (range.start / every).ceil();
            let places = (0..=MOST).map(|k| (first + k as f64) * every).filter(|place| *place <= range.end);
            return Self { places: places.collect(), range, numbers: Numbers::Powers };
        }
        let decades = (0..=DECADES as i32).map(|k| range.start.floor() + f64::from(k));
        let digits = decades.flat_map(|decade| WITHIN.map(|digit| decade + digit.log10()));
        let mut places: Vec<f64> = digits.filter(|place| range.contains(place)).collect();
        if places.len() < 2 {
            let values = 10_f64.powf(range.start)..10_f64.powf(range.end);
            places = round(&values, MOST).into_iter().map(f64::log10).collect();
        }
        Self { range, places, numbers: Numbers::Written }
    }

    fn span(&self) -> f64 {
        self.range.end - self.range.start
    }

    /// The number at a mark.
    pub(super) fn label(&self, place: f64) -> String {
        match self.numbers {
            Numbers::Plain => short(place, self.span()),
            Numbers::Powers => power(place),
            Numbers::Written => short(10_f64.powf(place), 0.0),
        }
    }

    /// Width of the widest number, in pixels.
    fn widest(&self) -> i32 {
        self.places.iter().map(|place| width(&self.label(*place), LETTER)).max().unwrap_or(0)
    }

    /// Room that an ordinate takes with its title, in pixels.
    pub(super) fn beside(&self) -> i32 {
        beside(self.widest())
    }

    /// Margin at the right of an abscissa, where the axis and this margin have so many pixels.
    pub(super) fn right(&self, length: i32) -> i32 {
        let Some(last) = self.places.last() else { return MARGIN };
        let before = (last - self.range.start) / self.span();
        let over = f64::from(width(&self.label(*last), LETTER)) / 2.0 - (1.0 - before) * f64::from(length);
        if over > 0.0 { MARGIN.max((over / before).ceil() as i32) } else { MARGIN }
    }
}

/// Room that texts beside an ordinate take with its title, in pixels.
pub(super) fn beside(widest: i32) -> i32 {
    2 * TICK / FINE + widest + GAP + LINE
}

/// At most `most` round numbers of a range.
fn round(range: &Range<f64>, most: usize) -> Vec<f64> {
    RangedCoordf64::from(range.clone()).key_points(BoldPoints(most))
}

impl ValueFormatter<f64> for Marks {
    fn format_ext(&self, place: &f64) -> String {
        self.label(*place)
    }
}

impl Ranged for Marks {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        RangedCoordf64::from(self.range.clone()).map(value, limit)
    }

    /// The marks; lines between them, which plotters asks for as light ones, there are none.
    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.places.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Marks of a logarithmic axis are powers of ten, or 1, 2 and 5 of them, or round numbers: never half a decade.
    #[test]
    fn decades_have_round_marks() {
        let labels = |range: Range<f64>| {
            let marks = Marks::decades(range);
            marks.places.iter().map(|place| marks.label(*place)).collect::<Vec<_>>()
        };
        assert_eq!(labels(-6.7..-3.9), ["10⁻⁶", "10⁻⁵", "10⁻⁴"]);
        // 14 decades, six steps at most: every third power.
        assert_eq!(labels(-12.0..2.0), ["10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "10⁰"]);
        // 10^0.2 = 1.58 to 10^1.5 = 31.6; 10^-5.6 = 2.5e-6 to 10^-5.2 = 6.3e-6.
        assert_eq!(labels(0.2..1.5), ["2", "5", "10", "20"]);
        assert_eq!(labels(-5.6..-5.2).first().map(String::as_str), Some("3·10⁻⁶"));
    }

    /// Long numbers are fewer, and the last one stays on the sheet.
    #[test]
    fn numbers_stay_apart() {
        let marks = Marks::across(-2.51e-6..2.51e-6, 300);
        // "−2·10⁻⁶" takes about 50 of 300 pixels: steps of 2e-6, 120 pixels, fit and those of 1e-6, 60 pixels, do as well.
        let step = 300.0 * (marks.places[1] - marks.places[0]) / marks.span();
        assert!(marks.places.len() > 2 && step >= f64::from(marks.widest() + GAP), "{marks:?}");
        // A mark at the very end hangs over by half of its number.
        let ends = Marks { places: vec![0.0, 10.0], ..Marks::even(0.0..10.0) };
        assert_eq!(ends.right(300), MARGIN.max((f64::from(width("10", LETTER)) / 2.0).ceil() as i32));
        let long = Marks { places: vec![0.0, 12345.0], ..Marks::even(0.0..12345.0) };
        assert!(long.right(300) > MARGIN);
    }
}
