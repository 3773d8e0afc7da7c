//! One mass on a spring with a contact; its normal force follows the friction force a little.

use crate::hb::Lines;
use num_complex::Complex64;

/// `m ẍ + c ẋ + k x = p0 + cos ωt − f`, `N = 1 − 0.1 x`.
#[derive(Clone, Copy, Debug)]
pub(in crate::hb) struct Oscillator {
    pub stiffness: f64,
    pub damping: f64,
    pub omega: f64,
    pub static_load: f64,
}

impl Default for Oscillator {
    fn default() -> Self {
        Self { stiffness: 1.0, damping: 0.05, omega: 0.7, static_load: 0.0 }
    }
}

impl Oscillator {
    pub fn dynamic_stiffness(&self, h: usize) -> Complex64 {
        let omega = h as f64 * self.omega;
        Complex64::new(self.stiffness - omega * omega, self.damping * omega)
    }

    pub fn load(&self, h: usize) -> f64 {
        [self.static_load, 1.0].get(h).copied().unwrap_or(0.0)
    }

    pub fn lines(&self, order: usize) -> Lines {
        let mut lines = Lines::zeros(self.omega, order, [2, 1]);
        for h in 0..=order {
            let receptance = 1.0 / self.dynamic_stiffness(h);
            lines.free_mut(0)[h] = receptance * self.load(h);
            lines.receptance_mut(0, 0)[h] = receptance;
            lines.free_mut(1)[h] = -0.1 * receptance * self.load(h);
            lines.receptance_mut(1, 0)[h] = -0.1 * receptance;
        }
        lines.free_mut(1)[0] += 1.0;
        lines
    }
}
