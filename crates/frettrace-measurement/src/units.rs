//! Units: spellings of the contract's own, and conversion of the laboratory's to SI.

/// Whether two spellings mean the same unit: `m/s²`, `m s^-2` and `m/s^2` do, `g` and `m/s^2` do not.
pub(crate) fn same_units(found: &str, expected: &str) -> bool {
    let plain = plain_spelling(found);
    let none = matches!(plain.as_str(), "" | "-" | "dimensionless" | "none");
    plain == plain_spelling(expected) || (expected == "1" && none)
}

fn plain_spelling(units: &str) -> String {
    let mut text: String = units.trim().replace('²', "^2").replace('³', "^3").replace("**", "^");
    text.retain(|letter| !matches!(letter, ' ' | '[' | ']' | '(' | ')' | '·' | '*'));
    match text.as_str() {
        "ms^-2" | "m/s2" | "m/s/s" => "m/s^2".into(),
        "ms^-1" => "m/s".into(),
        "newton" | "Newton" => "N".into(),
        "hertz" | "hz" => "Hz".into(),
        "metre" | "meter" => "m".into(),
        _ => text,
    }
}

/// Exponents of length, mass, time and voltage. Angles have none.
pub(crate) type Dimension = [i32; 4];

pub(crate) const LENGTH: Dimension = [1, 0, 0, 0];
pub(crate) const TIME: Dimension = [0, 0, 1, 0];
pub(crate) const FREQUENCY: Dimension = [0, 0, -1, 0];
pub(crate) const MASS: Dimension = [0, 1, 0, 0];
pub(crate) const FORCE: Dimension = [1, 1, -2, 0];
pub(crate) const VELOCITY: Dimension = [1, 0, -1, 0];
pub(crate) const ACCELERATION: Dimension = [1, 0, -2, 0];
pub(crate) const PRESSURE: Dimension = [-1, 1, -2, 0];
pub(crate) const DENSITY: Dimension = [-3, 1, 0, 0];
pub(crate) const STIFFNESS: Dimension = [0, 1, -2, 0];
pub(crate) const AREA: Dimension = [2, 0, 0, 0];
pub(crate) const SECOND_MOMENT: Dimension = [4, 0, 0, 0];
pub(crate) const NUMBER: Dimension = [0, 0, 0, 0];
const VOLTAGE: Dimension = [0, 0, 0, 1];

/// A unit: so many SI units of a dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit {
    /// How many SI units it is.
    pub(crate) factor: f64,
    /// Its dimension.
    pub(crate) dimension: Dimension,
}

/// Standard gravity (m/s²), exact by definition (3rd CGPM, 1901).
const GRAVITY: f64 = 9.80665;
/// Inch \[m\] and pound \[kg\], exact by the international yard and pound agreement of 1959.
const INCH: f64 = 0.0254;
const POUND: f64 = 0.453_592_37;

/// Units with names of their own. `g` is standard gravity and `lb` the force: these are measurements of forces
/// and accelerations; masses are `gram` and `lbm`.
const NAMED: [(&[&str], f64, Dimension); 31] = [
    (&["m", "metre", "meter", "metres", "meters"], 1.0, LENGTH),
    (&["in", "inch", "inches", "\""], INCH, LENGTH),
    (&["ft", "foot", "feet"], 12.0 * INCH, LENGTH),
    (&["mil", "thou"], INCH / 1000.0, LENGTH),
    (&["micron", "microns"], 1e-6, LENGTH),
    (&["kg"], 1.0, MASS),
    (&["gram", "grams"], 1e-3, MASS),
    (&["lbm"], POUND, MASS),
    (&["s", "sec", "second", "seconds"], 1.0, TIME),
    (&["min", "minute", "minutes"], 60.0, TIME),
    (&["h", "hour", "hours"], 3600.0, TIME),
    (&["Hz", "hz", "hertz"], 1.0, FREQUENCY),
    (&["N", "newton", "newtons", "Newton", "Newtons"], 1.0, FORCE),
    (&["lb", "lbs", "lbf", "pound", "pounds", "Pounds", "Pound"], POUND * GRAVITY, FORCE),
    (&["kip", "kips", "klbf"], 1000.0 * POUND * GRAVITY, FORCE),
    (&["ozf"], POUND * GRAVITY / 16.0, FORCE),
    (&["kgf", "kp"], GRAVITY, FORCE),
    (&["dyn"], 1e-5, FORCE),
    (&["Pa", "pascal"], 1.0, PRESSURE),
    (&["bar"], 1e5, PRESSURE),
    (&["psi"], POUND * GRAVITY / (INCH * INCH), PRESSURE),
    (&["ksi"], 1000.0 * POUND * GRAVITY / (INCH * INCH), PRESSURE),
    (&["g", "gn", "g_n", "G"], GRAVITY, ACCELERATION),
    (&["Gal"], 0.01, ACCELERATION),
    (&["rad", "radian", "radians"], 1.0, NUMBER),
    (&["deg", "degree", "degrees", "°"], std::f64::consts::PI / 180.0, NUMBER),
    (&["rev", "turn"], 2.0 * std::f64::consts::PI, NUMBER),
    (&["rpm"], 2.0 * std::f64::consts::PI / 60.0, FREQUENCY),
    (&["V", "volt", "volts", "Volt", "Volts"], 1.0, VOLTAGE),
    (&["%"], 0.01, NUMBER),
    (&["1", "", "-"], 1.0, NUMBER),
];

const PREFIXES: [(&str, f64); 8] =
    [("n", 1e-9), ("u", 1e-6), ("µ", 1e-6), ("μ", 1e-6), ("m", 1e-3), ("c", 1e-2), ("k", 1e3), ("M", 1e6)];
const GIGA: (&str, f64) = ("G", 1e9);
/// Units that take a prefix.
const PREFIXED: [&str; 9] = ["m", "s", "N", "Pa", "V", "g", "Hz", "bar", "rad"];

/// Reads a unit such as `mm`, `kip`, `in/s`, `m/s^2`, `mV/g`, `N s/m`; `None` where it is not known.
pub(crate) fn unit(text: &str) -> Option<Unit> {
    let text = text.trim().replace('²', "^2").replace('³', "^3").replace("**", "^").replace(['·', '*'], " ");
    let mut total = Unit { factor: 1.0, dimension: NUMBER };
    for (index, part) in text.split('/').enumerate() {
        let sign = if index == 0 { 1 } else { -1 };
        for piece in part.split_whitespace() {
            let (symbol, power) = power_of(piece)?;
            let base = base_unit(symbol)?;
            total.factor *= base.factor.powi(sign * power);
            for (all, one) in total.dimension.iter_mut().zip(base.dimension) {
                *all += sign * power * one;
            }
        }
    }
    Some(total)
}

/// `s^2`, `s2` and `s^-2` as a symbol and its power.
fn power_of(piece: &str) -> Option<(&str, i32)> {
    if let Some((symbol, power)) = piece.split_once('^') {
        return Some((symbol, power.parse().ok().filter(|power: &i32| power.abs() <= 9)?));
    }
    match piece.strip_suffix(['2', '3', '4']) {
        Some(symbol) if !symbol.is_empty() => Some((symbol, piece[symbol.len()..].parse().ok()?)),
        _ => Some((piece, 1)),
    }
}

fn base_unit(symbol: &str) -> Option<Unit> {
    let named = |symbol: &str| {
        let entry = NAMED.iter().find(|(names, ..)| names.contains(&symbol));
        entry.map(|&(_, factor, dimension)| Unit { factor, dimension })
    };
    named(symbol).or_else(|| {
        PREFIXES.iter().chain([&GIGA]).find_map(|(prefix, scale)| {
            let rest = symbol.strip_prefix(prefix).filter(|rest| PREFIXED.contains(rest))?;
            named(rest).map(|unit| Unit { factor: scale * unit.factor, ..unit })
        })
    })
}

/// Reads a quantity such as `501 mm` or `100 mV/g`: its SI value and dimension.
pub(crate) fn quantity(text: &str) -> Option<(f64, Dimension)> {
    let text = text.trim();
    let end = text.find(|letter: char| letter.is_whitespace()).unwrap_or(text.len());
    let value: f64 = text[..end].parse().ok()?;
    let unit = unit(&text[end..])?;
    Some((value * unit.factor, unit.dimension))
}

/// The SI unit of a dimension, for messages.
pub(crate) fn si_name(dimension: Dimension) -> &'static str {
    let names = [
        (LENGTH, "a length (m, mm, in)"),
        (TIME, "a time (s, ms)"),
        (FREQUENCY, "a frequency (Hz)"),
        (MASS, "a mass (kg)"),
        (FORCE, "a force (N, kN, lbf, kip)"),
        (VELOCITY, "a velocity (m/s, mm/s, in/s)"),
        (ACCELERATION, "an acceleration (m/s^2, g)"),
        (PRESSURE, "a pressure (Pa, bar, psi)"),
        (DENSITY, "a density (kg/m^3)"),
        (STIFFNESS, "a stiffness (N/m)"),
        (AREA, "an area (m^2)"),
        (SECOND_MOMENT, "a second moment of area (m^4)"),
        (NUMBER, "a number or an angle (1, rad, deg)"),
    ];
    names.iter().find(|(known, _)| *known == dimension).map_or("another quantity", |(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(text: &str, factor: f64, dimension: Dimension) {
        let found = unit(text).unwrap();
        // Factors are products of a few doubles: 1e-12 is thousands of roundings.
        assert!((found.factor / factor - 1.0).abs() < 1e-12, "{text}: {found:?}");
        assert_eq!(found.dimension, dimension, "{text}");
    }

    #[test]
    fn laboratory_units() {
        close("kip", 4448.2216152605, FORCE); // NIST SP 811, table of conversion factors
        close("lbf", 4.4482216152605, FORCE);
        close("psi", 6894.757293168361, PRESSURE);
        close("in/s", 0.0254, VELOCITY);
        close("in/s^2", 0.0254, ACCELERATION);
        close("mm/s²", 1e-3, ACCELERATION);
        close("mg", 9.80665e-3, ACCELERATION);
        close("µN", 1e-6, FORCE);
        close("uN", 1e-6, FORCE);
        close("GPa", 1e9, PRESSURE);
        close("N/mm", 1000.0, STIFFNESS);
        close("kg/m3", 1.0, DENSITY);
        close("mm^4", 1e-12, SECOND_MOMENT);
        close("deg/s", std::f64::consts::PI / 180.0, FREQUENCY);
        close("m s^-2", 1.0, ACCELERATION);
        assert_eq!(unit("furlong"), None);
        assert_eq!(unit("m^x"), None);
    }

    #[test]
    fn quantities_and_sensitivities() {
        assert_eq!(quantity("501 mm"), Some((0.501, LENGTH)));
        assert_eq!(quantity("0.5"), Some((0.5, NUMBER)));
        assert_eq!(quantity("half a metre"), None);
        // 100 mV/g, the common accelerometer: 0.1 V for 9.80665 m/s².
        let (value, dimension) = quantity("100 mV/g").unwrap();
        assert!((value - 0.1 / 9.80665).abs() < 1e-15);
        assert_eq!(dimension, [-1, 0, 2, 1]);
    }

    #[test]
    fn spellings_of_the_contract() {
        assert!(same_units("m/s²", "m/s^2") && same_units("m s^-2", "m/s^2") && same_units("", "1"));
        assert!(!same_units("g", "m/s^2") && !same_units("", "m") && !same_units("mm", "m"));
    }
}
