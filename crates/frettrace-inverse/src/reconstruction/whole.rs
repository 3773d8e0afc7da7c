//! Runs that are not periodic, and what periodic runs hold beside their lines.

use super::{answered, asks, with_normal_reaction};
use crate::analysis::bands;
use crate::aperiodic::{Estimated, Known, Left, slopes};
use crate::calibration::{CalibratedStructure, Equations, Step, calibrate_by};
use crate::contact::{RunBalance, Setting};
use crate::dynamics::{Dynamics, Load};
use crate::{Rig, RunData};
use frettrace_fourier::spectrum;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Balance over the whole spectrum, and the loads it was made with: with the normal reaction free where the residual asks for it.
pub(super) fn solve(
    rig: &Rig,
    setting: &Setting<'_>,
    run: &RunData<'_>,
    equations: &Equations<'_>,
) -> (RunBalance, Vec<Load>) {
    let lines = equations.lines;
    let balance = |loads: &[Load]| {
        let periodic = setting.balance(&equations.with_loads(loads.to_vec()));
        let known = Known::solved(lines, &periodic.contact);
        let left = known.taken_off(run, &lines.noise_std);
        Estimated::new(setting, &left, (&known, equations.share()), loads).balance()
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

/// A structure that is known calibrated further on runs that are not periodic; `None` where they determine none.
pub(super) fn calibrated(
    rig: &Rig,
    known: &CalibratedStructure,
    dynamics: &Dynamics,
    runs: &[(&RunData<'_>, &Equations<'_>)],
) -> Option<CalibratedStructure> {
    calibrate_by(known, dynamics, |structure| {
        let setting = super::setting(rig, structure, dynamics);
        let parts: Vec<Step> =
            runs.par_iter().map(|(run, equations)| slopes(&setting, run, equations)).collect();
        parts.iter().fold(Step::zero(2 * known.modes), Step::add)
    })
}

/// What a periodic run holds beside its lines.
pub(super) enum Beside {
    /// Noise.
    Nothing,
    /// Forces in the contact.
    Contact(Box<RunBalance>),
    /// Something that no contact force makes.
    Foreign(Foreign),
}

/// Accelerations between the lines that no contact force makes.
pub(super) struct Foreign {
    /// Their power over that of the noise.
    power: f64,
    /// At how many times the sampling rate the lines fold, and their share of what exceeds the noise; where they do.
    folded: Option<(usize, f64)>,
    /// The loudest octave (Hz), and its power over that of the noise.
    loudest: ([f64; 2], f64),
}

/// What the lines of a periodic run leave, where that is more than noise: balanced over the whole spectrum where that explains it.
pub(super) fn beside_lines(setting: &Setting<'_>, equations: &Equations<'_>) -> Beside {
    let Some(rest) = equations.lines.rest.as_ref() else { return Beside::Nothing };
    let octaves = rest.excesses(&[]);
    let (sensors, loads) = (rest.accelerations.len(), equations.loads.len());
    if sensors > loads {
        let (known, share) = (Known::default(), (sensors - loads) as f64 / sensors as f64);
        let is_worth = |fitted: &[Vec<f64>]| bands::may_be_explained(&octaves, &rest.excesses(fitted), share);
        let from = (&known, equations.share());
        let found = Estimated::if_worth(setting, rest, from, &equations.loads, is_worth);
        if let Some(found) = found
            && bands::is_explained(&octaves, &rest.excesses(&found.fitted()))
        {
            return Beside::Contact(Box::new(found.balance()));
        }
    }
    let excitation = equations.lines.frequency.base * equations.lines.subharmonic_order as f64;
    let power = rest.power();
    let folded = if power > UNEVEN { folded(rest, excitation) } else { None };
    let loudest = octaves.iter().max_by(|a, b| a.excess.total_cmp(&b.excess));
    let hertz = |bin: usize| bin as f64 * rest.rate / rest.force.len() as f64;
    let loudest = loudest.map_or(([0.0; 2], power), |band| (band.bins.map(hertz), 1.0 + band.excess));
    Beside::Foreign(Foreign { power, folded, loudest })
}

/// Power over that of the noise up to which a record holds no more than its noise, however that is spread.
const UNEVEN: f64 = 1.0 + bands::LEAST;

/// Multiples of the sampling rate at which lines may have folded: that of the recorder, and those of a finer record that was thinned.
const RATES: usize = 8;
/// Share of what exceeds the noise that folded lines must hold.
const FOLDED: f64 = 0.5;

/// Whether harmonics of the excitation (rad/s) beyond half of `m` times the sampling rate fold into the band: they lie at the distance
/// `m f_s mod f` from its lines, on either side. At how many times, and their share of what exceeds the noise.
fn folded(rest: &Left, excitation: f64) -> Option<(usize, f64)> {
    let samples = rest.force.len();
    let line = excitation / TAU * samples as f64 / rest.rate;
    let mut power = vec![-1.0; samples / 2 + 1];
    for (a, noise) in rest.accelerations.iter().zip(&rest.noise_std) {
        let unit = samples as f64 * noise * noise * rest.accelerations.len() as f64;
        power.iter_mut().zip(spectrum(a)).for_each(|(sum, bin)| *sum += bin.norm_sqr() / unit);
    }
    let total: f64 = power.iter().skip(1).sum();
    let share = |rate: usize| {
        let apart = (rate * samples) as f64 % line;
        let near = |k: usize| [apart, line - apart].iter().any(|d| (k as f64 % line - d).abs() < 1.5);
        // Where they would fall on the lines themselves nothing can be told.
        let told = apart.min(line - apart) > 3.0;
        if told { (1..power.len()).filter(|k| near(*k)).map(|k| power[k]).sum::<f64>() / total } else { 0.0 }
    };
    (1..=RATES)
        .map(|rate| (rate, share(rate)))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, share)| *share > FOLDED)
}

impl std::fmt::Display for Foreign {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let level = self.power.sqrt();
        if self.power <= UNEVEN {
            let ([from, to], power) = self.loudest;
            return write!(
                out,
                "between the lines the accelerations hold their noise, yet not evenly: {power:.2} times its share from {from:.0} to {to:.0} Hz, which no contact force makes; coloured noise, weak hum or a loose sensor"
            );
        }
        write!(
            out,
            "between the lines the accelerations hold {level:.2} times their noise, which no contact force makes"
        )?;
        match self.folded {
            Some((rate, share)) => write!(
                out,
                ": {:.0} % of it are harmonics of the excitation that fold at {rate} times the sampling rate; sample finer or filter before",
                100.0 * share
            ),
            None => write!(out, "; look for hum, a loose sensor or another machine"),
        }
    }
}
