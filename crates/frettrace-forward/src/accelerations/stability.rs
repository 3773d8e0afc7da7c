//! Stability of a settled motion against what is fast beside it.
//!
//! For motions that are fast beside the settled one the contact stands still on its way: it answers `δF = K δu + c δv` with the slopes
//! `K = ∂F/∂u` and `c = ∂F/∂v` of that instant, the bristle's own included. The beam answers with `δu = −R δF`, and a growth `e^{st}` is held
//! where
//! ```text
//! 1 + (K + c s) R(s) = 0,   R(s) = Σ φ_n²/(s² + 2ζ_n ω_n s + ω_n²)
//! ```
//! (`φ_n` the mass-normalised participation of the slip, lever arm included). The left side is 1 without a contact and where this is fast
//! beyond the beam, so that it has a root where its least value is below nothing: there the contact passes a fold and snaps to another part of
//! its characteristic, within a time that no line of a balance resolves. Near that the beam gives way, and a balance, whose lines end, is
//! another motion than the beam's. Damping of the bristle that fades with the velocity is what makes `K` and `c` negative.
//!
//! What grows no faster than the lines of the balance follow is in the balance: friction that falls within a stroke makes `K` strongly negative, and the
//! balance has the beam's own motion all the same. Rates are asked from a share of the last line's `HΩ` on.

use super::contact::Local;
use super::model::{AccelerationError, AccelerationModel, Memory};
use super::setting::Setting;

/// Directions of slip and velocity at the end of a step among those of its motion.
const SLIP: usize = Local::MOTION + 1;
const VELOCITY: usize = Local::MOTION + 3;
/// Share of the last line's frequency up to which lines follow a growth: by a fifth within half a wave of that line.
const FOLLOWED: f64 = 1.0 / 16.0;
/// Rates of growth that are asked, four in each octave, …
const PER_OCTAVE: f64 = 4.0;
/// … from there to this many times the highest natural frequency.
const BEYOND: f64 = 4.0;

impl AccelerationModel {
    /// Least `1 + (K + c s) R(s)` over all instants of a run's settled motion and all rates `s` that its lines do not follow, one value a selected
    /// run: 1 where the contact only holds and damps, below nothing where it snaps, `None` where the run's balance does not close. A rigid
    /// contact has no slopes, and 1.
    ///
    /// # Errors
    /// [`AccelerationError`] where the structure cannot be built.
    pub fn stability_margin(
        &self,
        setting: &Setting,
        selected: &[usize],
        memory: &mut Memory,
    ) -> Result<Vec<Option<f64>>, AccelerationError> {
        if setting.holds_rigidly() {
            return Ok(vec![Some(1.0); selected.len()]);
        }
        let structure = self.structure(setting)?;
        let modes: Vec<[f64; 3]> = structure.modes_of_slip().collect();
        Ok(self.each(selected, memory, |run, kept| {
            let margin = self.settled((&structure, setting), run, kept, |evaluation, state| {
                let last = evaluation.order() as f64 * self.runs[run].omega;
                let receptance = growing(&modes, FOLLOWED * last);
                let margin = |local: &Local| {
                    let [stiffness, damping] = [SLIP, VELOCITY].map(|at| local.force[at]);
                    receptance.iter().map(|[s, r]| 1.0 + (stiffness + damping * s) * r).fold(1.0, f64::min)
                };
                let (locals, _) = evaluation.locals(&state, &[]);
                locals.iter().map(margin).fold(1.0, f64::min)
            });
            margin.ok()
        }))
    }
}

/// Rates of growth (1/s), from the slowest on, and the slip per force (m/N) that grows with each, of modes of a natural frequency (rad/s), a damping
/// ratio and a participation.
fn growing(modes: &[[f64; 3]], slowest: f64) -> Vec<[f64; 2]> {
    let highest = modes.iter().map(|[frequency, ..]| *frequency).fold(0.0, f64::max);
    let octaves = (BEYOND * highest / slowest).log2().max(0.0);
    let receptance = |s: f64| -> f64 {
        let one = |[frequency, damping, participation]: &[f64; 3]| {
            participation * participation / (s * (s + 2.0 * damping * frequency) + frequency * frequency)
        };
        modes.iter().map(one).sum()
    };
    let rates = (0..=(PER_OCTAVE * octaves) as usize).map(|k| slowest * (k as f64 / PER_OCTAVE).exp2());
    rates.map(|s| [s, receptance(s)]).collect()
}
