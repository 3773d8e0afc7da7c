//! What the inverse recovers of a run over its whole spectrum, and what it leaves open.

use num_complex::Complex64;

/// Histories of the contact, one value a sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// Friction force (N).
    pub force: Vec<f64>,
    /// Slip (m).
    pub slip: Vec<f64>,
    /// Slip velocity (m/s).
    pub velocity: Vec<f64>,
    /// Normal force (N).
    pub normal: Vec<f64>,
}

impl Motion {
    /// Adds so much of another one.
    pub(crate) fn add(&mut self, other: &Self, share: f64) {
        let pairs = [
            (&mut self.force, &other.force),
            (&mut self.slip, &other.slip),
            (&mut self.velocity, &other.velocity),
            (&mut self.normal, &other.normal),
        ];
        for (own, other) in pairs {
            own.iter_mut().zip(other).for_each(|(own, other)| *own += share * other);
        }
    }

    /// None.
    pub(crate) fn nothing(samples: usize) -> Self {
        let zero = || vec![0.0; samples];
        Self { force: zero(), slip: zero(), velocity: zero(), normal: zero() }
    }

    /// So many values a sample: cubic between neighbours.
    pub(crate) fn refined(&self, fine: usize) -> Self {
        if fine == 1 {
            return self.clone();
        }
        let slopes = |x: &[f64]| -> Vec<f64> {
            let at = |k: usize| x[k.min(x.len() - 1)];
            (0..x.len()).map(|k| 0.5 * (at(k + 1) - at(k.saturating_sub(1)))).collect()
        };
        let between = |x: &[f64], slope: &[f64]| -> Vec<f64> {
            let mut out = Vec::with_capacity(fine * x.len());
            for k in 0..x.len() {
                let next = (k + 1).min(x.len() - 1);
                let (rise, [from, to]) = (x[next] - x[k], [slope[k], slope[next]]);
                for step in 0..fine {
                    let s = step as f64 / fine as f64;
                    let bent = s * (3.0 * rise - 2.0 * from - to + s * (from + to - 2.0 * rise));
                    out.push(x[k] + s * (from + bent));
                }
            }
            out
        };
        let plain = |x: &[f64]| between(x, &slopes(x));
        Self {
            force: plain(&self.force),
            slip: plain(&self.slip),
            velocity: plain(&self.velocity),
            normal: plain(&self.normal),
        }
    }

    /// Mean square of the force (N²).
    pub(crate) fn force_power(&self) -> f64 {
        self.force.iter().map(|f| f * f).sum::<f64>() / self.force.len().max(1) as f64
    }
}

/// A run without a period as it was recovered without a law.
///
/// With `x = (F, u, v, N)` the histories are `x̂ + Σ_p ξ_p x_p + e`: errors `x_p` that all bins have in common, of unit size (states at the
/// ends of the record, drift, the structure within its standard deviations), and errors `e` of each bin of its own.
#[derive(Clone, Debug, Default)]
pub struct WholeRun {
    /// Duration between two samples (s).
    pub dt: f64,
    /// The estimate `x̂`; the normal force holds the declared preload.
    pub found: Motion,
    /// Errors `x_p`.
    pub shared: Vec<Motion>,
    /// Standard deviation of real and imaginary part of the force in each bin of the record, from 0, beside the shared errors (N).
    pub own: Vec<f64>,
    /// The same of the normal force (N).
    pub own_normal: Vec<f64>,
    /// What no contact force makes of the accelerations, over their standard deviation: `[bin][sensor]`, from bin 1.
    pub left: Vec<Vec<Complex64>>,
    /// χ² of the balance without a law, and its degrees of freedom.
    pub balance: [f64; 2],
}

impl WholeRun {
    /// χ² per degree of freedom of the balance without a law.
    #[must_use]
    pub fn reduced(&self) -> f64 {
        self.balance[0] / self.balance[1].max(1.0)
    }
}
