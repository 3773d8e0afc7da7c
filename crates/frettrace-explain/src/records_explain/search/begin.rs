//! Where the search begins: the declared law from many starts.

use super::super::model::RecordModel;
use super::super::setting::has_stiffness;
use super::super::{RecordRun, RecordSetting, RecordUnknown};
use super::{Search, Trial};
use frettrace_identify::contact::Guess;
use frettrace_identify::{Fit, FitSettings, IdentifyError, Model, fit, fit_from_many, starts};
use rayon::prelude::*;

/// Steps of the ladder of stiffnesses, those of its fits that are followed, and starts around each.
const LADDER: u32 = 14;
const KEPT: usize = 3;
const STARTS: usize = 3;
/// What the level of sliding depends on.
const LEVEL: [&str; 4] = ["mu_k", "force_offset", "moving_mass", "sigma2"];

impl Search<'_> {
    /// The declared law from many starts.
    pub(super) fn baseline(&self) -> Result<Trial, IdentifyError> {
        let histories: Vec<_> = self.case.training.iter().map(|run| &run.history).collect();
        let guess = Guess::of(&histories);
        let setting = RecordSetting::declared(self.case, &guess, &self.scales);
        let told = [guess.mu, guess.sigma0].iter().all(|value| value.is_finite() && *value > 0.0);
        if !told || self.thinned.is_empty() {
            return Err(IdentifyError::Empty { parameters: setting.unknowns.len(), residuals: 0 });
        }
        let model = RecordModel::new(&setting, &self.thinned);
        let spread: Vec<f64> = setting.unknowns.iter().map(|u| spread(&u.parameter.name)).collect();
        let mut from = Vec::new();
        for start in self.sliding(&setting, &guess) {
            from.extend(starts(model.parameters(), &start, &spread, STARTS));
        }
        let quick = FitSettings { max_iterations: 25, ..FitSettings::default() };
        let many = fit_from_many(&model, &from, &quick)?;
        Ok(self.trial(&setting, many.best()))
    }

    /// Starts: the level of sliding and the offset fitted at each of a ladder of stiffnesses, the best ones kept. Fitted
    /// together from afar, stiffness and level may run away to a bristle that never slides.
    fn sliding(&self, setting: &RecordSetting, guess: &Guess) -> Vec<Vec<f64>> {
        let model = RecordModel::new(setting, &self.thinned);
        let name = |u: &RecordUnknown| u.parameter.name.clone();
        let settings = FitSettings {
            free: setting.unknowns.iter().map(|u| LEVEL.contains(&name(u).as_str())).collect(),
            max_iterations: 8,
            ..FitSettings::default()
        };
        let reach = |run: &RecordRun| run.history.amplitude();
        let least = self.case.training.iter().map(reach).fold(f64::INFINITY, f64::min);
        // From a widest loop that just slides to one whose narrowest loop is square.
        let (low, high) = (guess.mu / self.scales.slip, 200.0 * guess.mu / least.max(f64::MIN_POSITIVE));
        let ladder = (0..=LADDER).map(|k| low * (high / low).powf(f64::from(k) / f64::from(LADDER)));
        let begun = |sigma0: f64| {
            let at = |u: &RecordUnknown| if u.parameter.name == "sigma0" { sigma0 } else { u.value };
            setting.unknowns.iter().map(at).collect::<Vec<f64>>()
        };
        let ladder: Vec<f64> =
            if has_stiffness(self.case.law) { ladder.collect() } else { vec![guess.sigma0] };
        let mut found: Vec<Fit> =
            ladder.par_iter().filter_map(|sigma0| fit(&model, &begun(*sigma0), &settings).ok()).collect();
        found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let best = found.into_iter().take(KEPT).map(|fit| fit.values);
        best.chain(std::iter::once(begun(guess.sigma0))).collect()
    }
}

/// Half-width of the starts: a factor of e for what loops show, more for velocities.
fn spread(name: &str) -> f64 {
    match name {
        "mu_k" => 0.3,
        "sigma0" | "exponent" | "delta" | "breakaway" | "mu_rise" => 1.0,
        "sigma1" | "sigma2" | "moving_mass" => 0.5,
        "force_offset" => 0.0,
        _ => 2.0,
    }
}
