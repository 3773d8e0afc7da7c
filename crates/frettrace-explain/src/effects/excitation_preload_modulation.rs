//! `excitation.preload-modulation`.
//!
//! *Adds*: a preload that varies with the excitation or its second or third harmonic, as a sine, as a steeper wave
//! `tanh(κ cos ψ)/tanh κ`, or with harmonics of its own up to the fourth.
//!
//! *Shows as*: friction that follows a normal force of its own.
//!
//! *Mistaken for*: `friction.normal-dependence`, `contact.normal-stiffening`; told apart by a load cell under the support.

use super::{Change, ContactForm, Effect, EffectPlace, known};
use crate::Scales;
use frettrace_forward::accelerations::FrequencyRatio;
use frettrace_friction::effects::{Hook, ModifiedLaw};

pub(super) struct ExcitationPreloadModulation;

impl Effect for ExcitationPreloadModulation {
    fn id(&self) -> &'static str {
        "excitation.preload-modulation"
    }

    fn place(&self) -> EffectPlace {
        EffectPlace::Excitation
    }

    fn rivals(&self) -> &'static [&'static str] {
        &["friction.normal-dependence", "contact.normal-stiffening"]
    }

    fn experiment(&self) -> &'static str {
        "a load cell under the support"
    }

    fn contact_forms(&self, _law: &ModifiedLaw<f64>, scales: &Scales) -> Vec<ContactForm> {
        // The excitation's line, its double and triple, and the lines below it where a run moves at a fraction of it: those that hardly
        // do have no such line, and none of the modulation.
        let under = scales.subharmonic.max(1);
        let below = (1..under).map(|over| FrequencyRatio { over, under });
        below
            .chain([FrequencyRatio::ONE, FrequencyRatio::TWO, FrequencyRatio::THREE])
            .flat_map(|modulation| {
                let sine = vec![
                    Change::linear(Hook::ModulationCosine, 0.02, 0.05, (-1.5, 1.5)),
                    Change::linear(Hook::ModulationSine, 0.02, 0.05, (-1.5, 1.5)),
                ];
                // Another wave of the same phase: up to one that jumps from one level to the other.
                let steep = Change::between(Hook::ModulationSteepness, 1.0, (0.05, 20.0));
                let steep = sine.iter().cloned().chain([steep]).collect();
                [sine, steep].map(|changes| ContactForm { changes, modulation: Some(modulation) })
            })
            .collect()
    }

    /// Harmonics of its own: a wave that is neither a sine nor alike in both halves.
    fn other_shape(&self, law: &ModifiedLaw<f64>, _scales: &Scales) -> Vec<Change> {
        if !known(law, &[Hook::ModulationCosine]) {
            return Vec::new();
        }
        [
            Hook::ModulationCosine2,
            Hook::ModulationSine2,
            Hook::ModulationCosine3,
            Hook::ModulationSine3,
            Hook::ModulationCosine4,
            Hook::ModulationSine4,
        ]
        .map(|hook| Change::linear(hook, 0.0, 0.05, (-1.5, 1.5)))
        .into()
    }
}

#[cfg(test)]
mod tests {
    use crate::Scales;
    use crate::effects::ALL;
    use frettrace_friction::effects::{Hook, ModifiedLaw};

    /// A preload that is modulated stays so with the frequency that was found, whatever else is asked beside it: only a form that modulates has one.
    #[test]
    fn no_other_form_has_a_frequency_of_modulation() {
        let scales = Scales { slip: 2e-5, velocity: 4e-3, period: 0.05, subharmonic: 2, ..Scales::default() };
        let mut modulated = ModifiedLaw::dahl(1e5, 0.3);
        modulated.set(Hook::ModulationCosine, 0.2);
        modulated.set(Hook::ModulationSine, 0.0);
        let forms = ALL.iter().flat_map(|effect| effect.contact_forms(&modulated, &scales));
        let (mut with, mut without) = (0, 0);
        for form in forms {
            let modulates = form.changes.iter().any(|change| change.hook == Hook::ModulationCosine);
            assert_eq!(form.modulation.is_some(), modulates, "{:?}", form.formula());
            if modulates { with += 1 } else { without += 1 }
        }
        // Half the frequency, itself, its double and triple, each as a sine and steep.
        assert_eq!(with, 8);
        assert!(without > 40, "{without}");
    }
}
