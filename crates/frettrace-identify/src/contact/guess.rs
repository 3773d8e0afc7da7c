use super::drive::{forces, start_of};
use super::{ContactHistory, Family};

/// Values a fit of any law may start from, read off the loops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guess {
    /// Presliding stiffness over normal force (1/m).
    pub sigma0: f64,
    /// Friction coefficient (friction force where the normal force is not known).
    pub mu: f64,
    /// Largest sliding speed (m/s).
    pub speed: f64,
    /// Normal force (N).
    pub normal: f64,
}

impl Guess {
    /// Friction coefficient from the widest loop, stiffness from the best of a grid of Dahl's laws on all loops.
    #[must_use]
    pub fn of(histories: &[&ContactHistory]) -> Self {
        let widest = histories.iter().max_by(|a, b| a.amplitude().total_cmp(&b.amplitude()));
        let speed = histories.iter().map(|h| h.top_speed()).fold(0.0, f64::max);
        let mu = widest.map_or(1.0, |h| level(h));
        let normal = widest.map_or(1.0, |h| h.mean_normal());
        let reach =
            histories.iter().map(|h| h.amplitude()).fold(f64::INFINITY, f64::min).max(f64::MIN_POSITIVE);
        let far = widest.map_or(1.0, |h| h.amplitude()).max(f64::MIN_POSITIVE);
        // From a loop that barely slides at its widest to one that slides at its narrowest.
        let (low, high) = ((0.3 * mu / far).ln(), (30.0 * mu / reach).ln());
        let count = 24;
        let grid = (0..=count).flat_map(|k| {
            let sigma0 = (low + (high - low) * f64::from(k) / f64::from(count)).exp();
            // Where the widest loop does not slide, the level is not the friction coefficient.
            [1.0, 1.5, 3.0].map(|factor| (sigma0, factor * mu))
        });
        let best = grid
            .map(|(sigma0, mu)| (miss(histories, sigma0, mu), sigma0, mu))
            .filter(|c| c.0.is_finite())
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let (sigma0, mu) = best.map_or((mu / far, mu), |(_, sigma0, mu)| (sigma0, mu));
        Self { sigma0, mu, speed: speed.max(f64::MIN_POSITIVE), normal }
    }

    /// Start of the parameters of a law.
    #[must_use]
    pub fn parameters(&self, family: Family) -> Vec<f64> {
        let value = |name: &&str| match *name {
            "sigma0" => self.sigma0,
            "mu_k" => self.mu,
            "mu_s" => 1.15 * self.mu,
            "exponent" => 1.0,
            // A tenth of the friction at a tenth of the top speed; a hundredth of it at the top speed.
            "sigma1" => self.mu / self.speed,
            "sigma2" => 0.01 * self.mu * self.normal / self.speed,
            "v_d" | "v_s" => 0.2 * self.speed,
            "delta" => 2.0,
            _ => 0.3,
        };
        family.parameter_names().iter().map(value).collect()
    }
}

/// Level of `|F|/N` of a loop where it slides: the mean over the samples of at least half the top speed.
fn level(history: &ContactHistory) -> f64 {
    let middle =
        if history.mean_is_seen { 0.0 } else { history.force.iter().sum::<f64>() / history.len() as f64 };
    let top = history.top_speed();
    let (mut sum, mut count) = (0.0, 0.0);
    for k in history.counted() {
        if history.velocity[k].abs() >= 0.5 * top && history.normal[k] > 0.0 {
            sum += (history.force[k] - middle).abs() / history.normal[k];
            count += 1.0;
        }
    }
    f64::max(sum / f64::max(count, 1.0), f64::MIN_POSITIVE)
}

/// χ²-like misfit of a Dahl law, each history by its own mean square, so that small loops speak too.
fn miss(histories: &[&ContactHistory], sigma0: f64, mu: f64) -> f64 {
    let values = [sigma0, mu, 1.0];
    histories
        .iter()
        .map(|history| {
            let mut out = vec![0.0; history.len()];
            let start = start_of(Family::Dahl, &values, history, 0.0);
            forces((Family::Dahl, &values), history, (start, None), &mut out);
            let counted = history.counted();
            let count = counted.len() as f64;
            let mean = if history.mean_is_seen {
                0.0
            } else {
                counted.clone().map(|k| out[k] - history.force[k]).sum::<f64>() / count
            };
            let error: f64 = counted.clone().map(|k| (out[k] - history.force[k] - mean).powi(2)).sum();
            let size: f64 = counted.map(|k| history.force[k].powi(2)).sum();
            error / size.max(f64::MIN_POSITIVE)
        })
        .sum()
}
