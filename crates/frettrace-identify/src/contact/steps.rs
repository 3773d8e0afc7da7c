//! The steps: small loops, sliding, velocity dependence, breakaway and damping, everything.

use super::{ContactFit, ContactHistory, ContactModel, Extras, Family, Guess, StepReport, noise};
use crate::fit::ManyFits;
use crate::{FitSettings, IdentifyError, IdentifySettings, Model, fit, fit_from_many, identify, starts};

/// How a law is fitted to histories.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactSettings {
    /// Starts of the last step.
    pub starts: usize,
    /// Laws fitted to the same histories, with their values: the last step starts from each of them too, so that a law which
    /// contains another one does not come out worse.
    pub fitted: Vec<(Family, Vec<f64>)>,
    /// What is fitted beside the law.
    pub extras: Extras,
    /// Settings of the fit.
    pub fit: FitSettings,
    /// Whether intervals come from profiles (slower) or from the covariance.
    pub profiles: bool,
}

impl Default for ContactSettings {
    fn default() -> Self {
        Self {
            starts: 16,
            fitted: Vec::new(),
            extras: Extras::default(),
            fit: FitSettings::default(),
            profiles: true,
        }
    }
}

/// Fits of a step, and of a start before it is known whether it leads anywhere: within a thousandth of χ².
const SPRINT: FitSettings = FitSettings {
    free: Vec::new(),
    max_iterations: 10,
    relative_tolerance: 1e-3,
    absolute_tolerance: 0.1,
    secant: false,
};

/// Parameters each step frees beside those before it, and whether it uses small, large or all loops.
const STEPS: [(&str, &[&str], Loops); 4] = [
    ("stiffness from the lowest levels", &["sigma0"], Loops::Small),
    ("sliding friction from the highest levels", &["mu_k"], Loops::Large),
    (
        "velocity dependence of the friction coefficient",
        &["sigma0", "mu_k", "mu_s", "v_s", "delta", "sigma2"],
        Loops::All,
    ),
    ("breakaway and presliding damping", &["breakaway", "exponent", "sigma0", "sigma1", "v_d"], Loops::All),
];

#[derive(Clone, Copy, PartialEq)]
enum Loops {
    Small,
    Large,
    All,
}

/// Identifies a law from motion and force of the contact, step by step.
///
/// # Errors
/// [`IdentifyError`] where the histories are empty or the law has no solution on them.
pub fn identify_contact(
    family: Family,
    histories: &[&ContactHistory],
    settings: &ContactSettings,
) -> Result<ContactFit, IdentifyError> {
    let guess = Guess::of(histories);
    let typical = guess.parameters(family);
    let mut start = typical.clone();
    if settings.extras.wanted_mass {
        start.push(mass_guess(histories));
    }
    start.extend(settings.extras.offset.map(|_| 0.0));
    let mut steps = Vec::new();
    for (name, freed, loops) in STEPS {
        let used = chosen(histories, loops);
        let mut model = ContactModel::new(family, used, &typical, settings.extras);
        let free = mask(&model, |name| freed.contains(&name));
        if free.iter().any(|f| *f) {
            model.set_weights(noise::weights(&model, &start));
            let found = fit(&model, &start, &FitSettings { free, max_iterations: 20, ..SPRINT })?;
            start = found.values;
            steps.push(report(name, &model, &start, |name| freed.contains(&name)));
        }
    }
    last_step((family, histories, &typical), start, (steps, settings))
}

/// Everything together from many starts, with weights renewed at the solution, and what may be said of it.
fn last_step(
    (family, histories, typical): (Family, &[&ContactHistory], &[f64]),
    start: Vec<f64>,
    (mut steps, settings): (Vec<StepReport>, &ContactSettings),
) -> Result<ContactFit, IdentifyError> {
    let mut model = ContactModel::new(family, histories.to_vec(), typical, settings.extras);
    model.set_weights(noise::weights(&model, &start));
    let spread: Vec<f64> = model.parameters().iter().map(|p| spread(&p.name)).collect();
    let scattered = starts(model.parameters(), &start, &spread, settings.starts);
    let heats = fit_from_many(&model, &scattered, &SPRINT)?;
    let (mut lanes, agreement) = distinct(&model, &heats);
    let law = family.parameter_names().len();
    lanes.extend(settings.fitted.iter().map(|(other, values)| {
        let own = family.nearest((*other, values), typical);
        [&own[..], &start[law..]].concat()
    }));
    let finals = fit_from_many(&model, &lanes, &settings.fit)?;
    let first = finals.best().values.clone();
    let others = finals.fits[1..].iter().map(|f| f.values[..law].to_vec()).collect();
    model.set_weights(noise::weights(&model, &first));
    let best = fit(&model, &first, &settings.fit)?;
    let profiled = if settings.profiles { Vec::new() } else { vec![false; best.values.len()] };
    let judge = IdentifySettings {
        fit: settings.fit.clone(),
        profiled,
        effective_count: Some(effective_count(&model, &best.values)),
        ..IdentifySettings::default()
    };
    let mut identified = identify(&model, &best, &judge)?;
    if let Some(covariance) = noise::covariance(&model, &best.values, &best.free) {
        identified.widen(&covariance, model.parameters());
        identified.settle(model.parameters(), judge.widest);
    }
    steps.push(report("all parameters on all levels", &model, &best.values, |_| true));
    let error = model.relative_error(&best.values);
    Ok(ContactFit { family, identified, steps, error, agreement, others })
}

/// Minima that are followed to their end.
const KEPT: usize = 4;
/// Fits that differ by less than this in every coordinate are on the way to one minimum.
const APART: f64 = 0.3;

/// The best few of the fits that are not on the way to the same minimum, and the share of fits on the way to the best.
fn distinct(model: &ContactModel<'_>, many: &ManyFits) -> (Vec<Vec<f64>>, f64) {
    let coordinates = |values: &[f64]| -> Vec<f64> {
        model.parameters().iter().zip(values).map(|(p, v)| p.transform.coordinate(*v)).collect()
    };
    let near = |a: &[f64], b: &[f64]| {
        coordinates(a).iter().zip(coordinates(b)).all(|(a, b)| (a - b).abs() < APART || *a == b)
    };
    let mut kept: Vec<Vec<f64>> = Vec::new();
    for fit in &many.fits {
        if kept.len() < KEPT && !kept.iter().any(|other| near(other, &fit.values)) {
            kept.push(fit.values.clone());
        }
    }
    let alike = many.fits.iter().filter(|f| near(&many.best().values, &f.values)).count();
    (kept, alike as f64 / (many.fits.len() + many.failed).max(1) as f64)
}

fn report(name: &str, model: &ContactModel<'_>, values: &[f64], freed: impl Fn(&str) -> bool) -> StepReport {
    let parameters = model.parameters().iter().map(|p| p.name.clone()).filter(|n| freed(n)).collect();
    StepReport { name: name.to_owned(), parameters, error: model.relative_error(values) }
}

fn mask(model: &ContactModel<'_>, freed: impl Fn(&str) -> bool) -> Vec<bool> {
    model.parameters().iter().map(|p| freed(&p.name)).collect()
}

/// The third with the smallest amplitudes, the third with the largest, or all.
fn chosen<'a>(histories: &[&'a ContactHistory], loops: Loops) -> Vec<&'a ContactHistory> {
    let mut sorted = histories.to_vec();
    sorted.sort_by(|a, b| a.amplitude().total_cmp(&b.amplitude()));
    let share = histories.len().div_ceil(3);
    match loops {
        Loops::Small => sorted[..share].to_vec(),
        Loops::Large => sorted[sorted.len() - share..].to_vec(),
        Loops::All => histories.to_vec(),
    }
}

/// Half-width of the starts in the coordinate: a factor of e for what loops show well, more for velocities.
fn spread(name: &str) -> f64 {
    match name {
        "mu_k" | "mu_s" | "moving_mass" => 0.2,
        "sigma0" | "exponent" | "delta" => 0.7,
        "breakaway" => 1.0,
        "force_offset" => 0.0,
        _ => 2.0,
    }
}

/// Slope of force over acceleration: the mass, when friction is odd in velocity.
fn mass_guess(histories: &[&ContactHistory]) -> f64 {
    let (mut product, mut square) = (0.0, 0.0);
    for history in histories {
        for (a, f) in history.acceleration.iter().flatten().zip(&history.force) {
            product += a * f;
            square += a * a;
        }
    }
    f64::max(product / f64::max(square, f64::MIN_POSITIVE), 1e-6)
}

/// Independent samples of the residual: `n/(1 + 2Σρ_k)` while the autocorrelation stays positive, run by run.
fn effective_count(model: &ContactModel<'_>, values: &[f64]) -> f64 {
    (0..model.histories().len()).map(|index| independent(&model.force_residual(index, values))).sum()
}

pub(super) fn independent(residual: &[f64]) -> f64 {
    let n = residual.len();
    let square: f64 = residual.iter().map(|r| r * r).sum();
    if square <= 0.0 {
        return n as f64;
    }
    let mut sum = 1.0;
    for lag in 1..n / 2 {
        let product: f64 = residual[lag..].iter().zip(residual).map(|(a, b)| a * b).sum();
        // Below two standard errors of a white residual's autocorrelation there is nothing to add.
        if product / square < 2.0 / (n as f64).sqrt() {
            break;
        }
        sum += 2.0 * product / square;
    }
    (n as f64 / sum).max(4.0)
}
