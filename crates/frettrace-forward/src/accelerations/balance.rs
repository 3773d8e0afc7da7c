//! Contact force without a law: what the accelerations of a run say about it, line by line.

use super::run::{Evaluation, store};
use super::structure::Layout;
use num_complex::Complex64;

/// Force harmonics (all ports) recovered by weighted least squares over the sensors, for a start.
///
/// Only the friction force is recovered; a line whose force is smaller than three standard deviations starts from 0.
pub(super) fn recover(e: &Evaluation<'_>) -> Vec<f64> {
    let order = e.order();
    let zeros = vec![0.0; e.width()];
    let mut lines = vec![Complex64::ZERO; order + 1];
    for (h, force) in lines.iter_mut().enumerate().take(e.lines.order() + 1).skip(1) {
        let at = h as f64 * e.lines.omega;
        let (mut numerator, mut denominator) = (Complex64::ZERO, 0.0);
        for s in 0..e.layout.sensors {
            let row = Layout::sensor_row(s);
            let gain = -e.block.at(h, row, 1) * (-at * at);
            let left = e.lines.acceleration[s][h] - e.displacement(&zeros, row, h) * (-at * at);
            let weight = e.lines.deviation[s][h].powi(-2);
            numerator += gain.conj() * left * weight;
            denominator += gain.norm_sqr() * weight;
        }
        let estimate = numerator / denominator;
        if estimate.norm() * denominator.sqrt() > 3.0 {
            *force = estimate;
        }
    }
    let mut out = zeros;
    store(&lines, &mut out[..2 * order + 1]);
    out
}
