//! What a model leaves on lines, beside their noise.

/// Standard deviations of χ² that chance may bring.
const CHANCE: f64 = 5.0;

/// χ² that a model leaves on some lines.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LeftLines {
    pub chi_squared: f64,
    /// Real residuals.
    pub count: f64,
}

impl LeftLines {
    /// What is left beside the noise, per residual.
    pub fn excess(self) -> f64 {
        self.chi_squared / self.count.max(1.0) - 1.0
    }

    /// Standard deviation of that by chance.
    pub fn chance(self) -> f64 {
        (2.0 / self.count.max(1.0)).sqrt()
    }

    /// Whether it is no more than the noise, `χ²` within five of its standard deviations: far stricter than an error over the noise of all
    /// samples.
    pub fn is_noise(self) -> bool {
        self.excess() <= CHANCE * self.chance()
    }

    /// Whether what is left beside the noise is no more than that: right models of simulated rigs leave up to 0.8 of it where their contacts
    /// are hard to balance, wrong names that follow the fitted runs four to twenty times.
    pub fn is_near_noise(self) -> bool {
        self.excess() <= 1.0
    }
}
