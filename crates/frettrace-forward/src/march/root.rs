//! One implicit load: the root of a rising function of the load.

/// What the search knows beforehand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guess {
    /// First trial.
    pub(super) value: f64,
    /// Slope of the function there, at least about 1.
    pub(super) slope: f64,
    /// Residual that counts as zero.
    pub(super) tolerance: f64,
}

/// Trials before the middle of the bracket is taken for the root.
const LIMIT: usize = 120;
/// Trials after which the residual must have shrunk …
const PATIENCE: usize = 3;
/// … to this share, or the bracket is halved.
const PROGRESS: f64 = 0.25;

/// Root of `function`, whose sign tells the side, and the slope last seen.
///
/// Secant steps inside a bracket; halving where they leave it, or where they do not get on. A jump through zero (a law that takes a force
/// back at once) ends at the jump.
pub(super) fn rising_root(guess: Guess, mut function: impl FnMut(f64) -> f64) -> (f64, f64) {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut x, mut slope) = (guess.value, guess.slope);
    let mut last: Option<(f64, f64)> = None;
    let mut reach = guess.tolerance.max(f64::MIN_POSITIVE);
    let mut earlier = f64::INFINITY;
    for trial in 0..LIMIT {
        let value = function(x);
        if value.abs() <= guess.tolerance {
            break;
        }
        if value < 0.0 {
            low = low.max(x)
        } else {
            high = high.min(x)
        }
        if let Some((x0, v0)) = last {
            let secant = (value - v0) / (x - x0);
            if secant.is_finite() && secant > 0.0 {
                slope = secant;
            }
        }
        last = Some((x, value));
        let mut next = x - value / slope;
        let bracketed = low.is_finite() && high.is_finite();
        let due = trial % PATIENCE == PATIENCE - 1;
        let idle = due && value.abs() > PROGRESS * earlier;
        if due {
            earlier = value.abs();
        }
        if bracketed && (next <= low || next >= high || idle) {
            next = 0.5 * (low + high);
        } else if !bracketed && trial >= PATIENCE {
            // The secant creeps: stride out.
            reach = 2.0 * reach.max((next - x).abs());
            next = if value < 0.0 { x + reach } else { x - reach };
        }
        if next <= low || next >= high || next == x {
            break;
        }
        x = next;
    }
    (x, slope)
}
