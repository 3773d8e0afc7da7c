//! Spellings of the contract's units.

/// Whether two spellings mean the same unit: `m/s²`, `m s^-2` and `m/s^2` do, `g` and `m/s^2` do not.
pub(crate) fn same_units(found: &str, expected: &str) -> bool {
    let plain = plain_spelling(found);
    plain == plain_spelling(expected)
        || (expected == "1" && matches!(plain.as_str(), "" | "-" | "dimensionless" | "none"))
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
