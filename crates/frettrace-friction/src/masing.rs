//! Masing's rule with memory of the turning points, for laws that are given by their virgin curve.
//!
//! After a turning point `(u_r, f_r)` the branch is the virgin curve magnified twice:
//! `f = f_r ± 2 b(|u − u_r|/2)`. A branch that reaches the turning point before last closes its loop, and both are
//! forgotten (wiping out).

use crate::{Scalar, Stroke};

/// Turning points remembered at once; a motion that nests deeper forgets its smallest loop.
const DEPTH: usize = 6;
/// Length of the state: slip, force, number of turning points, and their slips and forces.
pub(crate) const LENGTH: usize = 3 + 2 * DEPTH;
/// Relative slack at which a loop counts as closed: rounding of the slips.
const CLOSED: f64 = 1.0 - 1e-12;

/// State of a law with Masing memory: slip since rest, force per newton of normal force, turning points.
pub type Memory<T> = [T; LENGTH];

/// The memory of a contact that never moved.
pub fn virgin<T: Scalar>() -> Memory<T> {
    [T::from(0.0); LENGTH]
}

/// Force per newton of normal force in the present state.
pub fn force<T: Scalar>(memory: &Memory<T>) -> T {
    memory[1]
}

/// Moves along one stroke; `backbone` is the virgin curve for slips ≥ 0.
pub fn advance<T: Scalar>(mut memory: Memory<T>, stroke: &Stroke<T>, backbone: impl Fn(T) -> T) -> Memory<T> {
    let mut count = memory[2].re() as usize;
    let origin = if count == 0 { 0.0 } else { turning(&memory, count).0.re() };
    if (memory[0].re() - origin) * stroke.direction < 0.0 {
        if count == DEPTH {
            count -= 2;
        }
        memory[3 + 2 * count] = memory[0];
        memory[4 + 2 * count] = memory[1];
        count += 1;
    }
    memory[0] += stroke.travel;
    count = wiped(&memory, count);
    memory[2] = T::from(count as f64);
    let (origin, base, scale) = match count {
        0 => (T::from(0.0), T::from(0.0), 1.0),
        _ => {
            let (slip, force) = turning(&memory, count);
            (slip, force, 2.0)
        }
    };
    let reach = memory[0] - origin;
    let sense = if reach.re() < 0.0 { -1.0 } else { 1.0 };
    memory[1] = base + backbone(reach * sense / scale) * (sense * scale);
    memory
}

/// Turning points that are left once the loops that have closed are forgotten.
fn wiped<T: Scalar>(memory: &Memory<T>, mut count: usize) -> usize {
    let slip = memory[0].re();
    while count > 0 {
        let last = turning(memory, count).0.re();
        let (span, closed) = if count == 1 {
            (2.0 * last.abs(), 0)
        } else {
            ((last - turning(memory, count - 1).0.re()).abs(), count - 2)
        };
        if (slip - last).abs() < span * CLOSED {
            break;
        }
        count = closed;
    }
    count
}

/// Slip and force of the turning point number `count`.
fn turning<T: Scalar>(memory: &Memory<T>, count: usize) -> (T, T) {
    (memory[1 + 2 * count], memory[2 + 2 * count])
}
