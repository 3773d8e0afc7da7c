//! How the outputs of each bin move with what is uncertain of the structure, the measurements being given.
//!
//! When `θ = ln ω_n` or `ln ζ_n` moves, the accelerations that mode `n` makes move by `−φ_n z` in each bin, with
//! `z = ω² ∂g_n p_n − ∂d_n`: its receptance `g_n` under the generalised force `p_n`, and its free decay `d_n`. Forces and common unknowns
//! answer as they would to accelerations `φ_n z`.

use super::ends::{Decay, Decays};
use super::sources::{Common, Outputs, Spectra, combined};
use super::{Round, Whole};
use crate::calibration::generalised_force;
use crate::contact::COMPLIANCE_DOUBT;
use crate::dynamics::Load;
use faer::Mat;
use num_complex::Complex64;
use rayon::prelude::*;

/// One parameter in one bin.
struct Moved {
    /// What it makes of the accelerations, along its mode's shape.
    z: Complex64,
    outputs: Outputs,
}

impl Whole<'_> {
    /// Independent sources of error: those of [`crate::CalibratedStructure::roots`], then the flexibility beyond the beam theory.
    pub(super) fn structure(&self, round: &Round, common: &Common) -> Vec<Spectra> {
        let roots = self.setting.roots();
        let decays = self.moved_decays(round);
        let moved: Vec<Vec<Moved>> = (0..self.bins.len())
            .into_par_iter()
            .map(|k| {
                let answered = self.forces(k, round).1;
                let moved = decays.iter().enumerate();
                moved.map(|(p, decay)| self.moved((k, p), (decay, &answered), round)).collect()
            })
            .collect();
        let answers = self.answers(&moved, decays.len(), round);
        let own: Vec<Spectra> = (0..decays.len())
            .into_par_iter()
            .map(|p| spectra(moved.iter().map(|bin| bin[p].outputs)))
            .collect();
        // Each source moves the parameters by its root, and the common unknowns by what they answer to that.
        let shares = Mat::from_fn(own.len() + answers.len(), roots.len(), |i, source| {
            let root = &roots[source];
            match i.checked_sub(own.len()) {
                None => root[i],
                Some(unknown) => answers[unknown].iter().zip(root).map(|(a, r)| a * r).sum(),
            }
        });
        let moving: Vec<&Spectra> = own.iter().chain(&common.outputs).collect();
        let mut found = combined(&moving, &shares);
        found.push(spectra((0..self.bins.len()).map(|k| self.compliance(k, round))));
        found
    }

    /// Derivatives of the free decays of the calibrated modes, two a mode.
    pub(super) fn moved_decays(&self, round: &Round) -> Vec<Decay> {
        let modes = self.setting.structure.modes.min(self.record.modes);
        let model = &self.setting.structure.model;
        (0..2 * modes)
            .into_par_iter()
            .map(|p| {
                let start = Complex64::new(round.common[p / 2 * 2], round.common[p / 2 * 2 + 1]);
                Decays::derivative(model, &self.record, (p / 2, start), p % 2)
            })
            .collect()
    }

    fn moved(
        &self,
        (k, parameter): (usize, usize),
        (decay, answered): (&Decay, &[Complex64]),
        round: &Round,
    ) -> Moved {
        let (mode, bin, solved) = (parameter / 2, &self.bins[k], &round.solved[k]);
        let omega = bin.line.omega();
        let motion = self.motion((k, parameter), answered);
        let z = motion * (omega * omega) - decay.acceleration[k];
        let forces: Vec<Complex64> = (0..self.loads.len()).map(|u| solved.taken(u, mode) * z).collect();
        let mut outputs = self.outputs(&bin.line, Complex64::ZERO, &forces);
        let turned = motion * Complex64::new(0.0, omega);
        self.add_motion(mode, [motion + decay.displacement[k], turned + decay.velocity[k]], &mut outputs);
        Moved { z, outputs }
    }

    /// Derivative `∂g_n p_n` of a mode's coordinate in a bin under the forces that the structure answers.
    pub(super) fn motion(&self, (k, parameter): (usize, usize), answered: &[Complex64]) -> Complex64 {
        let (mode, kind) = (parameter / 2, parameter % 2);
        let (bin, model) = (&self.bins[k], &self.setting.structure.model);
        let load = generalised_force(self.setting.dynamics, mode, bin.exciter, self.loads, answered);
        let scale = [model.natural_frequency()[mode], model.damping_ratio()[mode]][kind];
        model.modal_receptance_gradient(mode, bin.line.omega())[kind] * scale * load
    }

    /// Change of the common unknowns, a row each, with each parameter.
    fn answers(&self, moved: &[Vec<Moved>], parameters: usize, round: &Round) -> Vec<Vec<f64>> {
        let unknowns = round.common.len();
        let mut right = vec![vec![0.0; parameters]; unknowns];
        for (k, (bin, moved)) in self.bins.iter().zip(moved).enumerate() {
            let (products, along) = bin.left(&round.solved[k]);
            for (row, (d, x)) in right.iter_mut().zip(self.columns(k, &round.jumps)) {
                for (p, (entry, moved)) in row.iter_mut().zip(moved).enumerate() {
                    *entry += 2.0 * (x.conj() * products[d * along.len() + p / 2] * moved.z).re;
                }
            }
        }
        let row = |i: usize, p: usize| (0..unknowns).map(|j| round.covariance[(i, j)] * right[j][p]).sum();
        (0..unknowns).map(|i| (0..parameters).map(|p| row(i, p)).collect()).collect()
    }

    /// Change of the outputs per standard deviation of the flexibility that the beam theory does not hold for; sensors do not see it.
    fn compliance(&self, k: usize, round: &Round) -> Outputs {
        let (bin, dynamics) = (&self.bins[k], self.setting.dynamics);
        let answered = self.forces(k, round).1;
        let moved = |output: usize| -> Complex64 {
            let loads = self.loads.iter().zip(&answered);
            let sum: Complex64 = loads.map(|(load, f)| f * dynamics.doubtful(output, *load)).sum();
            (sum + bin.exciter * dynamics.doubtful(output, Load::Exciter)) * COMPLIANCE_DOUBT
        };
        let (slip, end) = (moved(dynamics.sensors()), moved(dynamics.sensors() + 1));
        let velocity = slip * Complex64::new(0.0, bin.line.omega());
        [Complex64::ZERO, slip, velocity, -end * self.setting.normal_stiffness, Complex64::ZERO]
    }
}

/// Outputs of all bins, output by output.
fn spectra(bins: impl Iterator<Item = Outputs>) -> Spectra {
    let mut found: Spectra = std::array::from_fn(|_| Vec::new());
    for outputs in bins {
        found.iter_mut().zip(outputs).for_each(|(spectrum, value)| spectrum.push(value));
    }
    found
}
