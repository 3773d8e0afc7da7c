//! Colours: of a file, or markers that become those of the page.

use plotters::style::RGBColor;

/// Roles with a colour of their own.
const NAMED: usize = 4;
/// Paper, text, grid and the roles, while a picture for a page is drawn.
const MARKERS: [RGBColor; 3 + NAMED] = {
    let mut markers = [RGBColor(0, 0, 0); 3 + NAMED];
    let mut index = 0;
    while index < markers.len() {
        let first = 1 + 3 * index as u8;
        markers[index] = RGBColor(first, first + 1, first + 2);
        index += 1;
    }
    markers
};
/// What they become.
const VARIABLES: [&str; 3 + NAMED] = [
    "var(--paper)",
    "var(--text)",
    "var(--grid)",
    "var(--measured)",
    "var(--before)",
    "var(--after)",
    "var(--faint)",
];
/// The same in a file: dark on white.
const FIXED: [RGBColor; 3 + NAMED] = [
    RGBColor(0xff, 0xff, 0xff),
    RGBColor(0x1a, 0x1a, 0x1a),
    RGBColor(0xdd, 0xdd, 0xdd),
    RGBColor(0x1a, 0x1a, 0x1a),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0x76, 0x76, 0x76),
];
/// Colours of numbered curves, as many as a ladder of levels has rungs or a beam sensors: in the order of the spectrum, so that
/// the order of levels shows; dark at both ends and light in the middle, so that those that colour-blindness brings together
/// differ in lightness.
pub(super) const NUMBERED: [RGBColor; 8] = [
    RGBColor(0x2a, 0x1a, 0x6e),
    RGBColor(0x1f, 0x6f, 0xd0),
    RGBColor(0x00, 0xa0, 0xa8),
    RGBColor(0x2a, 0x9d, 0x3a),
    RGBColor(0xa8, 0xa0, 0x00),
    RGBColor(0xe0, 0x8a, 0x00),
    RGBColor(0xd4, 0x3a, 0x1f),
    RGBColor(0x8a, 0x0a, 0x3c),
];

/// Where a chart will stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// In the report: colours are CSS variables of the page.
    Page,
    /// In a file of its own: dark on white.
    File,
    /// In a file of its own, and as PNG besides.
    FileAndPng,
}

impl Ink {
    pub(super) fn palette(self) -> Palette {
        Palette(if self == Self::Page { MARKERS } else { FIXED })
    }

    /// Markers replaced by the variables of the page.
    pub(super) fn dye(self, svg: String) -> String {
        if self != Self::Page {
            return svg;
        }
        let named = MARKERS.iter().zip(VARIABLES);
        named.fold(svg, |svg, (m, variable)| {
            svg.replace(&format!("#{:02X}{:02X}{:02X}", m.0, m.1, m.2), variable)
        })
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
    /// What a perfect model would leave: the noise.
    Floor,
    /// One of several curves of equal standing, by its number.
    Number(usize),
}

/// The colours a picture is drawn in.
#[derive(Clone, Copy)]
pub(super) struct Palette([RGBColor; 3 + NAMED]);

impl Palette {
    pub(super) fn paper(&self) -> RGBColor {
        self.0[0]
    }

    pub(super) fn text(&self) -> RGBColor {
        self.0[1]
    }

    pub(super) fn grid(&self) -> RGBColor {
        self.0[2]
    }

    pub(super) fn role(&self, role: Role) -> RGBColor {
        match role {
            Role::Measured => self.0[3],
            Role::Before => self.0[4],
            Role::After => self.0[5],
            Role::Floor => self.0[6],
            Role::Number(number) => NUMBERED[number % NUMBERED.len()],
        }
    }
}
