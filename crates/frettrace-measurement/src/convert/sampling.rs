//! Sampling times: uniform or not, cut to a piece, and resampled.

use super::description::Method;

/// Share of the interval by which a sample may be late in uniform sampling: times are printed with few digits.
const JITTER: f64 = 0.1;

/// The uniform rate \[Hz\] of a list of times, `None` where some sample is off the even grid.
pub(super) fn uniform_rate(time: &[f64]) -> Option<f64> {
    let (first, last) = (*time.first()?, *time.last()?);
    let interval = (last - first) / (time.len().checked_sub(1).filter(|&steps| steps > 0)? as f64);
    let on_grid =
        |(index, at): (usize, &f64)| (at - first - index as f64 * interval).abs() <= JITTER * interval;
    (interval > 0.0 && time.iter().enumerate().all(on_grid)).then(|| 1.0 / interval)
}

/// Index of the first time that does not lie after the one before it.
pub(super) fn first_not_rising(time: &[f64]) -> Option<usize> {
    time.windows(2).position(|pair| pair[1] <= pair[0]).map(|index| index + 1)
}

/// The samples from one time to another, both included.
pub(super) fn window(time: &[f64], from: Option<f64>, to: Option<f64>) -> std::ops::Range<usize> {
    let start = from.map_or(0, |from| time.partition_point(|&at| at < from));
    let end = to.map_or(time.len(), |to| time.partition_point(|&at| at <= to));
    start..end.max(start)
}

/// Values at the even times `time[0] + k/rate` up to the last time.
///
/// Both methods pass through the samples. Straight lines err by at most `(2π f Δt)²/8` of the amplitude at
/// frequency `f` with samples `Δt` apart; the cubics err less where the signal is smooth and never overshoot at its
/// corners (F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal. 17 (1980) 238, doi:10.1137/0717021).
pub(super) fn resample(time: &[f64], values: &[f64], rate: f64, method: Method) -> Vec<f64> {
    let slopes = match method {
        Method::Linear => None,
        Method::Pchip => Some(monotone_slopes(time, values)),
    };
    let count = ((time[time.len() - 1] - time[0]) * rate + 1e-9).floor() as usize + 1;
    let mut interval = 0;
    let mut out = Vec::with_capacity(count);
    for sample in 0..count {
        let at = time[0] + sample as f64 / rate;
        while interval + 2 < time.len() && time[interval + 1] <= at {
            interval += 1;
        }
        let width = time[interval + 1] - time[interval];
        let share = (at - time[interval]) / width;
        let (left, right) = (values[interval], values[interval + 1]);
        let straight = left + share * (right - left);
        let bend = slopes.as_ref().map_or(0.0, |slopes| {
            let chord = (right - left) / width;
            let (start, end) = (slopes[interval] - chord, slopes[interval + 1] - chord);
            width * share * (1.0 - share) * ((1.0 - share) * start - share * end)
        });
        out.push(straight + bend);
    }
    out
}

/// Slopes at the samples that keep the cubics monotone: the weighted harmonic mean of the chords beside a sample, 0
/// where they differ in sign.
fn monotone_slopes(time: &[f64], values: &[f64]) -> Vec<f64> {
    let width = |index: usize| time[index + 1] - time[index];
    let chord = |index: usize| (values[index + 1] - values[index]) / width(index);
    let last = time.len() - 1;
    (0..=last)
        .map(|index| {
            if index == 0 {
                return chord(0);
            }
            if index == last {
                return chord(last - 1);
            }
            let (before, after) = (chord(index - 1), chord(index));
            if before * after <= 0.0 {
                return 0.0;
            }
            let (left, right) =
                (2.0 * width(index) + width(index - 1), width(index) + 2.0 * width(index - 1));
            (left + right) / (left / before + right / after)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_times_are_found_through_rounding() {
        let rounded: Vec<f64> = (0..1000).map(|k| (f64::from(k) / 3200.0 * 1e6).floor() / 1e6).collect();
        // The last time is cut by at most 1e-6 s of 0.312 s: 4e-6 relative.
        assert!((uniform_rate(&rounded).unwrap() / 3200.0 - 1.0).abs() < 4e-6);
        assert_eq!(uniform_rate(&[0.0, 0.01, 0.02, 0.13]), None);
        assert_eq!(uniform_rate(&[0.0]), None);
        assert_eq!(first_not_rising(&[0.0, 1.0, 1.0]), Some(2));
    }

    #[test]
    fn pieces() {
        let time = [0.0, 1.0, 2.0, 3.0];
        assert_eq!(window(&time, Some(1.0), Some(2.0)), 1..3);
        assert_eq!(window(&time, None, None), 0..4);
        assert!(window(&time, Some(9.0), None).is_empty());
    }

    #[test]
    fn both_methods_pass_through_samples_and_lines() {
        let time = [0.0, 0.3, 0.4, 1.0];
        let line: Vec<f64> = time.iter().map(|t| 2.0 * t - 1.0).collect();
        for method in [Method::Linear, Method::Pchip] {
            for (k, value) in resample(&time, &line, 10.0, method).iter().enumerate() {
                // A straight line is reproduced to rounding.
                assert!((value - (0.2 * k as f64 - 1.0)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn cubics_are_closer_on_a_sine_and_do_not_overshoot_a_step() {
        let time: Vec<f64> = (0..40).map(|k| f64::from(k) * 0.025 + 0.005 * f64::from(k % 2)).collect();
        let sine: Vec<f64> = time.iter().map(|t| (6.3 * t).sin()).collect();
        let error = |method| {
            let out = resample(&time, &sine, 400.0, method);
            let errors =
                out.iter().enumerate().map(|(k, value)| (value - (6.3 * k as f64 / 400.0).sin()).abs());
            errors.fold(0.0, f64::max)
        };
        // Straight lines err by (ω Δt)²/8 = (6.3·0.03)²/8 = 4.5e-3 at most.
        assert!(error(Method::Linear) < 4.5e-3);
        assert!(error(Method::Pchip) < error(Method::Linear));
        let step: Vec<f64> = time.iter().map(|&t| f64::from(t > 0.5)).collect();
        let out = resample(&time, &step, 400.0, Method::Pchip);
        assert!(out.iter().all(|value| (-1e-12..=1.0 + 1e-12).contains(value)));
    }
}
