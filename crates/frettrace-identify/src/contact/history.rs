/// Whether a history repeats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Closure {
    /// One period: after the last sample comes the first, at this time after the first (s).
    Periodic {
        /// Period (s).
        period: f64,
    },
    /// A record with a beginning and an end.
    Open,
}

/// One draw of the noise of a history: what the measurement might have been wrong by.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseDraw {
    /// Error of the slip, `n` samples.
    pub slip: Vec<f64>,
    /// Error of the slip velocity, `n` samples.
    pub velocity: Vec<f64>,
    /// Error of the force (N), `n` samples.
    pub force: Vec<f64>,
}

/// Motion and force of a contact, sample by sample.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactHistory {
    /// Name of the run.
    pub label: String,
    /// Times (s), ascending, `n` samples.
    pub time: Vec<f64>,
    /// Slip (m or rad).
    pub slip: Vec<f64>,
    /// Slip velocity (m/s or rad/s).
    pub velocity: Vec<f64>,
    /// Slip acceleration, where a mass moves with the contact.
    pub acceleration: Option<Vec<f64>>,
    /// Normal force (N); 1 throughout where it is unknown, so that coefficients become forces.
    pub normal: Vec<f64>,
    /// Force (N).
    pub force: Vec<f64>,
    /// Whether it repeats.
    pub closure: Closure,
    /// Whether the mean of the force was measured (accelerometers cannot see it).
    pub mean_is_seen: bool,
    /// Standard deviation of the noise of a force sample (N).
    pub force_std: f64,
    /// Draws of the noise of slip and force with its true correlation; none where the slip is exact.
    pub draws: Vec<NoiseDraw>,
    /// First sample that counts: the state of the contact before it is not known.
    pub first: usize,
}

impl ContactHistory {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Half the range of the slip.
    #[must_use]
    pub fn amplitude(&self) -> f64 {
        let (low, high) = range(&self.slip);
        0.5 * (high - low)
    }

    /// Largest speed.
    #[must_use]
    pub fn top_speed(&self) -> f64 {
        self.velocity.iter().fold(0.0, |m, v| v.abs().max(m))
    }

    /// Mean normal force (N).
    #[must_use]
    pub fn mean_normal(&self) -> f64 {
        self.normal.iter().sum::<f64>() / self.len().max(1) as f64
    }

    /// Samples the law is asked for, in the order of its steps: `(from, to, duration)`.
    pub(super) fn steps(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        let n = self.len();
        let inner = (1..n).map(|k| (k - 1, k, self.time[k] - self.time[k - 1]));
        let closing = match self.closure {
            Closure::Periodic { period } if n > 0 => {
                Some((n - 1, 0, self.time[0] + period - self.time[n - 1]))
            }
            _ => None,
        };
        inner.chain(closing)
    }

    /// Which samples count in the residual.
    pub(super) fn counted(&self) -> std::ops::Range<usize> {
        let first = match self.closure {
            Closure::Periodic { .. } => 0,
            Closure::Open => self.first.max(1),
        };
        first.min(self.len())..self.len()
    }
}

/// Smallest and largest value.
pub(super) fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)))
}
