//! Spectra of a recording, with the floor of its noise.

use super::chart::{Chart, Curve, Ink, Role};
use super::kind::{Figure, Kind, title};
use crate::results::{Amplitudes, ChannelSpectrum};
use frettrace_fourier::{spectrum, tapered_spectrum};
use frettrace_measurement::{ContactRun, Measurement, Run};

/// Pairs of points a spectrum shows at most: in a file of its own, and where a page holds several.
const PAIRS: usize = 700;
const FEWER: usize = 240;
/// Lines below this share of the largest are rounding.
const ROUNDING: f64 = 1e-9;
/// Fewest bins a local median is taken over: its standard error is then below 10 %.
const BLOCK: usize = 128;
/// Hann's window of mean square one takes `√(2/3)` of a line's amplitude: by this a line stands at its amplitude again.
const LINE: f64 = 1.224_744_871_391_589;

/// Amplitudes of the accelerations over frequency, and the floor.
pub(super) fn accelerations(measurement: &Measurement, run: &Run, names: &[String], ink: Ink) -> Figure {
    let spectra: Vec<Spectrum> =
        run.acceleration.iter().map(|y| Spectrum::of(y, run.sampling_rate)).collect();
    let declared = measurement.sensors.noise_std.as_deref().map(|std| {
        let mean = std.iter().map(|std| std * std).sum::<f64>() / std.len().max(1) as f64;
        mean.sqrt()
    });
    let floor = Floor::of(&spectra, declared.filter(|std| *std > 0.0), run.force.len());
    let shown: Vec<Spectrum> = spectra.iter().map(|all| all.envelope(PAIRS)).collect();
    let sensors = shown.iter().zip(names).enumerate();
    let mut curves: Vec<Curve<'_>> = sensors
        .map(|(number, (s, name))| Curve::line(name, Role::Number(number), &s.frequency, &s.amplitude))
        .collect();
    curves.push(floor.curve(Role::Measured));
    let chart = Chart {
        title: &title("Spectra", &run.id, &run.label, false),
        x_label: "frequency [Hz]",
        y_label: "amplitude [m/s²]",
        logarithmic: true,
        curves,
    };
    Figure::new(format!("spectrum-{}", run.id), Kind::Spectra, chart.picture(ink))
}

/// Amplitudes of the force over frequency, and the floor; none where samples are not equidistant.
pub(super) fn force(run: &ContactRun, ink: Ink) -> Option<Figure> {
    let spectrum = Spectrum::of(&run.force, run.sampling_rate?);
    let floor = Floor::of(std::slice::from_ref(&spectrum), run.force_noise_std, run.force.len());
    let shown = spectrum.envelope(PAIRS);
    let chart = Chart {
        title: &title("Spectrum", &run.id, &run.label, false),
        x_label: "frequency [Hz]",
        y_label: "amplitude of the force [N]",
        logarithmic: true,
        curves: vec![
            Curve::line("measured", Role::Measured, &shown.frequency, &shown.amplitude),
            floor.curve(Role::Before),
        ],
    };
    Some(Figure::new(format!("spectrum-{}", run.id), Kind::Spectra, chart.picture(ink)))
}

/// One channel and what models leave of it.
pub(crate) struct Channel<'a> {
    /// Samples of the whole record.
    pub signal: &'a [f64],
    /// Sampling rate (Hz).
    pub sampling_rate: f64,
    /// Standard deviation of its noise, where it is declared.
    pub noise_std: Option<f64>,
    /// Residual of the declared model and of the one with the effects.
    pub residual: [Residual<'a>; 2],
}

/// Over what a residual is known.
pub(crate) enum Residual<'a> {
    /// The samples of the record.
    Samples(&'a [f64]),
    /// One period of so many seconds: amplitudes of its lines, exactly.
    Period(&'a [f64], f64),
}

/// The numbers of a channel's spectrum, for whoever draws them; the names are left to be filled in.
pub(crate) fn channel(of: &Channel<'_>) -> ChannelSpectrum {
    let all = [Spectrum::of(of.signal, of.sampling_rate)];
    let floor = Floor::of(&all, of.noise_std.filter(|std| *std > 0.0), of.signal.len());
    let [before, after] = of.residual.each_ref().map(|residual| match residual {
        Residual::Samples(x) => Spectrum::of(x, of.sampling_rate).envelope(FEWER).amplitudes(),
        Residual::Period(x, period) => lines(x, *period).amplitudes(),
    });
    ChannelSpectrum {
        measured: all[0].envelope(FEWER).amplitudes(),
        floor_name: floor.name.to_owned(),
        floor: Spectrum { frequency: floor.frequency, amplitude: floor.amplitude }.amplitudes(),
        before,
        after,
        ..ChannelSpectrum::default()
    }
}

/// Amplitudes `2|X_k|/n` of one period of a signal at `k/period`, as far as they are more than rounding.
fn lines(x: &[f64], period: f64) -> Spectrum {
    let bins = spectrum(x);
    let amplitude: Vec<f64> = bins.iter().skip(1).map(|bin| 2.0 * bin.norm() / x.len() as f64).collect();
    let least = ROUNDING * amplitude.iter().copied().fold(0.0, f64::max);
    let kept = amplitude.iter().rposition(|y| *y > least).map_or(0, |last| last + 1);
    Spectrum {
        frequency: (1..=kept).map(|k| k as f64 / period).collect(),
        amplitude: amplitude[..kept].to_vec(),
    }
}

/// The spectrum of a channel, with what the models leave.
pub(super) fn explained(of: &ChannelSpectrum, named: bool, ink: Ink) -> Figure {
    let mut curves = vec![
        curve("measured", Role::Measured, &of.measured),
        curve("left by the declared model", Role::Before, &of.before),
    ];
    if named {
        curves.push(curve("left with the effects", Role::After, &of.after));
    }
    curves.push(Curve::dashed(&of.floor_name, Role::Floor, &of.floor.frequency, &of.floor.amplitude));
    let chart = Chart {
        title: &title("Spectrum", &of.run, &of.label, of.held_out),
        x_label: "frequency [Hz]",
        y_label: &of.channel,
        logarithmic: true,
        curves,
    };
    Figure::new(format!("spectrum-{}", of.run), Kind::Spectra, chart.picture(ink))
}

fn curve<'a>(name: &'a str, role: Role, of: &'a Amplitudes) -> Curve<'a> {
    Curve::line(name, role, &of.frequency, &of.amplitude)
}

/// Amplitudes over frequency, without the mean.
struct Spectrum {
    frequency: Vec<f64>,
    amplitude: Vec<f64>,
}

impl Spectrum {
    fn of(signal: &[f64], sampling_rate: f64) -> Self {
        let amplitude: Vec<f64> =
            tapered_spectrum(signal).iter().skip(1).map(|bin| LINE * bin.norm()).collect();
        let step = sampling_rate / signal.len().max(1) as f64;
        Self { frequency: (1..=amplitude.len()).map(|k| k as f64 * step).collect(), amplitude }
    }

    /// For a file, with six significant digits.
    fn amplitudes(self) -> Amplitudes {
        let [frequency, amplitude] =
            [self.frequency, self.amplitude].map(|values| crate::exhibits::rounded(&values));
        Amplitudes { frequency, amplitude }
    }

    /// Highest and lowest amplitude of each of at most so many stretches: lines and floor stay where a page has fewer pixels.
    fn envelope(&self, pairs: usize) -> Self {
        let stretch = self.amplitude.len().div_ceil(pairs).max(1);
        if stretch < 3 {
            return Self { frequency: self.frequency.clone(), amplitude: self.amplitude.clone() };
        }
        let mut shown = Self { frequency: Vec::new(), amplitude: Vec::new() };
        for (f, y) in self.frequency.chunks(stretch).zip(self.amplitude.chunks(stretch)) {
            let (low, high) =
                y.iter().fold((f64::INFINITY, 0.0), |(low, high), y| (f64::min(low, *y), f64::max(high, *y)));
            shown.frequency.extend([f[0], f[f.len() / 2]]);
            shown.amplitude.extend([high, low]);
        }
        shown
    }
}

/// What a perfect model would leave of every amplitude, in quadratic mean.
struct Floor {
    name: &'static str,
    frequency: Vec<f64>,
    amplitude: Vec<f64>,
}

impl Floor {
    fn of(spectra: &[Spectrum], declared: Option<f64>, samples: usize) -> Self {
        let ends = |all: &Spectrum| [all.frequency.first(), all.frequency.last()].map(|f| f.copied());
        match (declared, spectra.first().map(ends)) {
            // White noise of deviation σ has amplitudes 2σ/√n under a window of mean square one.
            (Some(std), Some([Some(first), Some(last)])) => Self {
                name: "noise floor (declared)",
                frequency: vec![first, last],
                amplitude: vec![LINE * 2.0 * std / (samples as f64).sqrt(); 2],
            },
            _ => Self::estimated(spectra),
        }
    }

    /// From the median of each stretch, which lines do not move: that of the modulus of complex noise is `√ln 2` of its
    /// quadratic mean.
    fn estimated(spectra: &[Spectrum]) -> Self {
        let mut floor =
            Self { name: "noise floor (between the lines)", frequency: Vec::new(), amplitude: Vec::new() };
        let bins = spectra.first().map_or(0, |all| all.amplitude.len());
        for start in (0..bins).step_by(BLOCK) {
            let end = (start + BLOCK).min(bins);
            let mut block: Vec<f64> =
                spectra.iter().flat_map(|all| &all.amplitude[start..end]).copied().collect();
            block.sort_by(f64::total_cmp);
            floor.frequency.push(spectra[0].frequency[(start + end) / 2]);
            floor.amplitude.push(block[block.len() / 2] / std::f64::consts::LN_2.sqrt());
        }
        floor
    }

    /// Dashed over the spectra, in a colour that stands out from theirs.
    fn curve(&self, role: Role) -> Curve<'_> {
        Curve::dashed(self.name, role, &self.frequency, &self.amplitude)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const RATE: f64 = 1000.0;

    /// A line of amplitude 3 in white noise of deviation 0.2.
    fn signal(samples: usize) -> Vec<f64> {
        let mut random = rand_pcg::Pcg64::seed_from_u64(7);
        let noise =
            |k: usize, x: f64| 0.2 * x + 3.0 * (std::f64::consts::TAU * 125.0 * k as f64 / RATE).cos() + 10.0;
        (0..samples).map(|k| noise(k, StandardNormal.sample(&mut random))).collect()
    }

    /// A line stands at its amplitude, and the floor from the median is that of the stated noise: 8192 bins in blocks of 128 scatter
    /// by 10 % each, their mean by 1.3 %.
    #[test]
    fn lines_and_floor_have_their_heights() {
        let spectrum = Spectrum::of(&signal(16384), RATE);
        let line = spectrum.amplitude.iter().copied().fold(0.0, f64::max);
        assert!((line - 3.0).abs() < 0.02, "{line}");
        let all = [spectrum];
        let (stated, found) = (Floor::of(&all, Some(0.2), 16384), Floor::of(&all, None, 16384));
        let mean = found.amplitude.iter().sum::<f64>() / found.amplitude.len() as f64;
        assert!((mean / stated.amplitude[0] - 1.0).abs() < 0.05, "{mean} {}", stated.amplitude[0]);
        // σ√(6/n)
        assert!((stated.amplitude[0] - 0.2 * (6.0_f64 / 16384.0).sqrt()).abs() < 1e-12);
    }

    /// What a model leaves of one period has the lines that were put in: 0.5 at the second and 0.02 at the fifth of 40 Hz.
    #[test]
    fn residuals_have_their_lines() {
        let period = 1.0 / 40.0;
        let phase = |k: usize| std::f64::consts::TAU * k as f64 / 240.0;
        let left: Vec<f64> =
            (0..240).map(|k| 0.5 * (2.0 * phase(k)).cos() - 0.02 * (5.0 * phase(k)).sin()).collect();
        let signal = signal(4096);
        let residual = [Residual::Period(&left, period), Residual::Samples(&signal)];
        let found =
            channel(&Channel { signal: &signal, sampling_rate: RATE, noise_std: Some(0.2), residual });
        assert_eq!(found.before.frequency, [40.0, 80.0, 120.0, 160.0, 200.0]);
        let expected = [0.0, 0.5, 0.0, 0.0, 0.02];
        assert!(found.before.amplitude.iter().zip(expected).all(|(y, e)| (y - e).abs() < 1e-9), "{found:?}");
        assert_eq!((found.after, found.floor_name.as_str()), (found.measured, "noise floor (declared)"));
    }

    /// Thinning keeps the line, the floor, and the order of frequencies.
    #[test]
    fn an_envelope_keeps_the_line() {
        let spectrum = Spectrum::of(&signal(65536), RATE);
        let shown = spectrum.envelope(PAIRS);
        assert!(shown.amplitude.len() <= 2 * PAIRS);
        let highest = |all: &Spectrum| all.amplitude.iter().copied().fold(0.0, f64::max);
        assert_eq!(highest(&shown), highest(&spectrum));
        assert!(shown.frequency.is_sorted());
    }
}
