//! The structure as harmonic balance sees it: free motion and receptance of each channel, line by line.

use num_complex::Complex64;

/// The linear structure between contact forces and channels, on the lines `hω`, `h = 0..=H`:
///
/// `x̂_c[h] = x̂0_c[h] − Σ_d G_cd[h] f̂_d[h]`,  `x(t) = Re Σ_h x̂_h e^{ihωt}`.
///
/// A channel is whatever a contact reads: slip (m), the opening of a gap (m), or a normal force (N) (preload in line 0,
/// `G` then in N/N). A force `f_d` (N) is positive when it resists positive motion of its own channel.
/// Line 0 is real: its imaginary parts are ignored.
#[derive(Clone, Debug, PartialEq)]
pub struct Lines {
    omega: f64,
    order: usize,
    channels: usize,
    forces: usize,
    free: Vec<Complex64>,
    receptance: Vec<Complex64>,
}

impl Lines {
    /// Lines `0..=order` of the base frequency `omega` (rad/s), all zero, to be filled in.
    #[must_use]
    pub fn zeros(omega: f64, order: usize, [channels, forces]: [usize; 2]) -> Self {
        let row = order + 1;
        Self {
            omega,
            order,
            channels,
            forces,
            free: vec![Complex64::ZERO; channels * row],
            receptance: vec![Complex64::ZERO; channels * forces * row],
        }
    }

    /// Base angular frequency `ω = Ω/ν` (rad/s).
    #[must_use]
    pub fn omega(&self) -> f64 {
        self.omega
    }

    /// Highest line `H`.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Number of forces.
    #[must_use]
    pub fn forces(&self) -> usize {
        self.forces
    }

    /// Lines of the motion of `channel` without contact forces, `H + 1`.
    #[must_use]
    pub fn free(&self, channel: usize) -> &[Complex64] {
        let row = self.order + 1;
        &self.free[channel * row..(channel + 1) * row]
    }

    /// As [`Self::free`], to be filled in.
    pub fn free_mut(&mut self, channel: usize) -> &mut [Complex64] {
        let row = self.order + 1;
        &mut self.free[channel * row..(channel + 1) * row]
    }

    /// Receptance of `channel` to `force`, `H + 1` lines.
    #[must_use]
    pub fn receptance(&self, channel: usize, force: usize) -> &[Complex64] {
        let row = self.order + 1;
        let start = (channel * self.forces + force) * row;
        &self.receptance[start..start + row]
    }

    /// As [`Self::receptance`], to be filled in.
    pub fn receptance_mut(&mut self, channel: usize, force: usize) -> &mut [Complex64] {
        let row = self.order + 1;
        let start = (channel * self.forces + force) * row;
        &mut self.receptance[start..start + row]
    }

    /// Lines of the motion of `channel` under the contact forces (`D × (H' + 1)`, force by force, `H' ≤ H`), for the
    /// lines that `motion` has room for. Lines above `H'` move freely.
    pub fn respond(&self, channel: usize, forces: &[Complex64], motion: &mut [Complex64]) {
        let count = motion.len().min(self.order + 1);
        motion[..count].copy_from_slice(&self.free(channel)[..count]);
        motion[count..].fill(Complex64::ZERO);
        let row = forces.len() / self.forces.max(1);
        for (d, force) in forces.chunks_exact(row.max(1)).take(self.forces).enumerate() {
            for ((x, g), f) in motion.iter_mut().zip(self.receptance(channel, d)).zip(force) {
                *x -= g * f;
            }
        }
    }
}
