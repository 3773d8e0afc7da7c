//! Spectra of a recording, with the floor of its noise.

use super::chart::{Chart, Curve, Ink, Role};
use super::kind::{Figure, Kind, title};
use frettrace_fourier::tapered_spectrum;
use frettrace_measurement::{ContactRun, Measurement, Run};

/// Pairs of points a spectrum shows at most.
const PAIRS: usize = 700;
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
    let shown: Vec<Spectrum> = spectra.iter().map(Spectrum::envelope).collect();
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
    let shown = spectrum.envelope();
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

    /// Highest and lowest amplitude of each of at most [`PAIRS`] stretches: lines and floor stay where a page has fewer pixels.
    fn envelope(&self) -> Self {
        let stretch = self.amplitude.len().div_ceil(PAIRS).max(1);
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

    /// Thinning keeps the line, the floor, and the order of frequencies.
    #[test]
    fn an_envelope_keeps_the_line() {
        let spectrum = Spectrum::of(&signal(65536), RATE);
        let shown = spectrum.envelope();
        assert!(shown.amplitude.len() <= 2 * PAIRS);
        let highest = |all: &Spectrum| all.amplitude.iter().copied().fold(0.0, f64::max);
        assert_eq!(highest(&shown), highest(&spectrum));
        assert!(shown.frequency.is_sorted());
    }
}
