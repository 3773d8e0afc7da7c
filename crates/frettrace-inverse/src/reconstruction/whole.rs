//! Runs that are not periodic.

use super::{answered, asks, with_normal_reaction};
use crate::aperiodic::{self, Known};
use crate::calibration::Equations;
use crate::contact::{RunBalance, Setting};
use crate::dynamics::Load;
use crate::{Rig, RunData};

/// Balance over the whole spectrum, and the loads it was made with: with the normal reaction free where the residual asks for it.
pub(super) fn solve(
    rig: &Rig,
    setting: &Setting<'_>,
    run: &RunData<'_>,
    equations: &Equations<'_>,
) -> (RunBalance, Vec<Load>) {
    let lines = equations.lines;
    let balance = |loads: &[Load]| {
        let periodic = setting.balance(&Equations::new(lines, loads.to_vec()));
        let known = Known::solved(lines, &periodic.contact);
        aperiodic::solve(setting, run, (lines, &known), loads)
    };
    let bound = balance(&equations.loads);
    let more = with_normal_reaction(rig, &equations.loads).filter(|_| asks(bound.residual.reduced()));
    if let Some(more) = more {
        let free = balance(&more);
        if answered(bound.residual.reduced(), free.residual.reduced()) {
            return (free, more);
        }
    }
    (bound, equations.loads.clone())
}
