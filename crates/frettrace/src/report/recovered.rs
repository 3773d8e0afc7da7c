//! Figures of a reconstruction (`REC.h5`): loops, forces, spectra; with the measurement besides, accelerations measured and rebuilt.

use super::chart::{Chart, Curve, Ink, Role};
use super::kind::{Figure, Kind, title};
use super::residuals;
use super::signals::{PERIODS, sensor_name, thin};
use crate::StudyError;
use crate::results::ResidualMap;
use frettrace_identify::HALF_INTERVAL95;
use frettrace_measurement::{Attribute, DataFile, Measurement};

/// Cells of a period in a map.
const CELLS: usize = 40;

/// Figures of a reconstruction, run by run; a run that could not be solved has none.
///
/// # Errors
/// [`StudyError::File`] when the file is not such a file, [`StudyError::Unlike`] when `measured` is not what it was made from.
pub fn figures(file: &DataFile, measured: Option<&Measurement>, ink: Ink) -> Result<Vec<Figure>, StudyError> {
    let runs: Vec<Recovered> =
        file.groups("/runs").iter().map(|id| Recovered::read(file, id)).collect::<Result<_, _>>()?;
    let solved = runs.iter().filter(|run| run.friction.iter().any(|f| f.is_finite()));
    let mut figures: Vec<Figure> = solved.flat_map(|run| run.contact(ink)).collect();
    if let Some(measurement) = measured {
        let compared = runs
            .iter()
            .map(|run| Compared::new(file, run, measurement))
            .collect::<Result<Vec<Compared<'_>>, StudyError>>()?;
        figures.extend(compared.iter().map(|run| run.waveform(measurement, ink)));
        figures.extend(maps(&compared, ink));
    }
    Ok(figures)
}

/// One run of the file.
struct Recovered {
    id: String,
    label: String,
    /// Samples of a few periods, or of the whole run where it has none.
    shown: usize,
    periodic: bool,
    fundamental: f64,
    noise_floor: f64,
    time: Vec<f64>,
    friction: Vec<f64>,
    friction_std: Vec<f64>,
    normal: Vec<f64>,
    slip: Vec<f64>,
    velocity: Vec<f64>,
    fit: Vec<Vec<f64>>,
    /// Frequencies, moduli and standard deviations of the friction force's lines.
    lines: [Vec<f64>; 3],
}

impl Recovered {
    fn read(file: &DataFile, id: &str) -> Result<Self, StudyError> {
        let place = format!("/runs/{id}");
        let column = |name: &str| Ok::<_, StudyError>(file.array(&format!("{place}/{name}"))?.values);
        let word = |name: &str| match file.attribute(&place, name) {
            Ok(Some(Attribute::Text(text))) => text,
            _ => String::new(),
        };
        let number = |name: &str| match file.attribute(&place, name) {
            Ok(Some(Attribute::Numbers(numbers))) => numbers.first().copied().unwrap_or(f64::NAN),
            _ => f64::NAN,
        };
        let (time, fundamental) = (column("time")?, number("fundamental_frequency"));
        let periodic = word("form") != "aperiodic";
        let wanted = time.iter().take_while(|t| **t < PERIODS / fundamental).count();
        Ok(Self {
            id: id.to_owned(),
            label: word("label"),
            shown: if periodic && wanted > 0 { wanted } else { time.len() },
            periodic,
            fundamental,
            noise_floor: number("noise_floor"),
            friction: column("friction_force")?,
            friction_std: column("friction_force_std")?,
            normal: column("normal_force")?,
            slip: column("slip_displacement")?,
            velocity: column("slip_velocity")?,
            fit: file.array(&format!("{place}/acceleration_fit"))?.columns(),
            lines: lines(file, &format!("{place}/harmonics"))?,
            time,
        })
    }

    fn few(&self, values: &[f64]) -> Vec<f64> {
        thin(&values[..self.shown.min(values.len())])
    }

    fn contact(&self, ink: Ink) -> Vec<Figure> {
        let friction = self.few(&self.friction);
        let name = title("Recovered friction", &self.id, &self.label, false);
        let draw = |name: &str, kind, chart: Chart<'_>| {
            Figure::new(format!("{name}-{}", self.id), kind, chart.picture(ink))
        };
        let chart = |x_label, curves| Chart {
            title: &name,
            x_label,
            y_label: "force [N]",
            logarithmic: false,
            curves,
        };
        let alone = |x| vec![Curve::line("friction force", Role::Measured, x, &friction)];
        let (slip, velocity) = (self.few(&self.slip), self.few(&self.velocity));
        let (time, normal) = (self.few(&self.time), self.few(&self.normal));
        let std = self.few(&self.friction_std);
        let edge = |side: f64| -> Vec<f64> {
            friction.iter().zip(&std).map(|(force, std)| force + side * HALF_INTERVAL95 * std).collect()
        };
        let (low, high) = (edge(-1.0), edge(1.0));
        let forces = vec![
            Curve::line("normal force", Role::After, &time, &normal),
            Curve::line("friction force", Role::Measured, &time, &friction),
            Curve::dashed("its 95 % band", Role::Before, &time, &low),
            Curve::dashed("", Role::Before, &time, &high),
        ];
        let mut figures = vec![
            draw("loop", Kind::Loops, chart("slip [m]", alone(&slip))),
            draw("velocity", Kind::Loops, chart("slip velocity [m/s]", alone(&velocity))),
            draw(
                "forces",
                Kind::Signals,
                Chart {
                    title: &title("Recovered contact", &self.id, &self.label, false),
                    ..chart("time [s]", forces)
                },
            ),
        ];
        figures.extend(self.spectrum(ink));
        figures
    }

    /// Lines of the friction force and what they are known to; none where the run has no lines.
    fn spectrum(&self, ink: Ink) -> Option<Figure> {
        let [frequency, modulus, deviation] = &self.lines;
        let chart = Chart {
            title: &title("Spectrum of the friction", &self.id, &self.label, false),
            x_label: "frequency [Hz]",
            y_label: "amplitude of the force [N]",
            logarithmic: true,
            curves: vec![
                Curve::line("recovered", Role::Measured, frequency, modulus),
                Curve::dashed("its standard deviation", Role::Floor, frequency, deviation),
            ],
        };
        let name = format!("spectrum-{}", self.id);
        (!frequency.is_empty()).then(|| Figure::new(name, Kind::Spectra, chart.picture(ink)))
    }
}

/// The friction force's lines without the mean, which nobody sees.
fn lines(file: &DataFile, place: &str) -> Result<[Vec<f64>; 3], StudyError> {
    if !file.has_dataset(&format!("{place}/friction_force")) {
        return Ok([Vec::new(), Vec::new(), Vec::new()]);
    }
    let (real, imaginary) = file.complex(&format!("{place}/friction_force"))?;
    let column = |name: &str| Ok::<_, StudyError>(file.array(&format!("{place}/{name}"))?.values);
    let modulus: Vec<f64> = real.values.iter().zip(&imaginary.values).map(|(re, im)| re.hypot(*im)).collect();
    let all = [column("frequency")?, modulus, column("friction_force_std")?];
    Ok(all.map(|values| values.into_iter().skip(1).collect()))
}

/// A run as measured beside its reconstruction.
struct Compared<'a> {
    run: &'a Recovered,
    measured: &'a [Vec<f64>],
    /// Mean square of what was measured (m²/s⁴), without means.
    mean_square: f64,
    /// Standard deviation of each sensor's noise (m/s²).
    noise: Vec<f64>,
}

impl<'a> Compared<'a> {
    fn new(file: &DataFile, run: &'a Recovered, measurement: &'a Measurement) -> Result<Self, StudyError> {
        let same = |other: &&frettrace_measurement::Run| {
            other.id == run.id
                && other.force.len() == run.time.len()
                && other.acceleration.len() == run.fit.len()
        };
        let unlike = || StudyError::Unlike { path: file.path().to_owned(), run: run.id.clone() };
        let measured = &measurement.runs.iter().find(same).ok_or_else(unlike)?.acceleration;
        let squares = measured.iter().map(|y| {
            let mean = y.iter().sum::<f64>() / y.len() as f64;
            y.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / y.len() as f64
        });
        let mean_square = squares.sum::<f64>() / measured.len().max(1) as f64;
        let floor = run.noise_floor * mean_square.sqrt();
        let noise = measurement.sensors.noise_std.clone().unwrap_or_else(|| vec![floor; measured.len()]);
        Ok(Self { run, measured, mean_square, noise })
    }

    /// Measured minus rebuilt of a sensor, in standard deviations of its noise.
    fn left(&self, sensor: usize) -> impl Iterator<Item = f64> {
        let noise = self.noise[sensor].max(f64::MIN_POSITIVE);
        self.measured[sensor].iter().zip(&self.run.fit[sensor]).map(move |(y, fit)| (y - fit) / noise)
    }

    /// The sensor that the reconstruction misses most, measured and rebuilt.
    fn waveform(&self, measurement: &Measurement, ink: Ink) -> Figure {
        let missed = |sensor: &usize| self.left(*sensor).map(|r| r * r).sum::<f64>();
        let worst = (0..self.measured.len()).max_by(|a, b| missed(a).total_cmp(&missed(b))).unwrap_or(0);
        let run = self.run;
        let (time, measured, fit) =
            (run.few(&run.time), run.few(&self.measured[worst]), run.few(&run.fit[worst]));
        let chart = Chart {
            title: &title(
                &format!("Acceleration of {}", sensor_name(measurement, worst)),
                &run.id,
                &run.label,
                false,
            ),
            x_label: "time [s]",
            y_label: "acceleration [m/s²]",
            logarithmic: false,
            curves: vec![
                Curve::line("measured", Role::Measured, &time, &measured),
                Curve::line("rebuilt", Role::After, &time, &fit),
            ],
        };
        Figure::new(format!("rebuilt-{}", run.id), Kind::Signals, chart.picture(ink))
    }

    /// Mean squares of what is left over one period, sensor by sensor; none where the run has no period.
    fn by_phase(&self) -> Option<Vec<Vec<f64>>> {
        let run = self.run;
        let solved = run.fit.iter().flatten().all(|y| y.is_finite());
        (run.periodic && solved).then(|| {
            let cell = |t: f64| ((t * run.fundamental).rem_euclid(1.0) * CELLS as f64) as usize % CELLS;
            let fold = |sensor: usize| {
                let mut sums = vec![(0.0, 0.0); CELLS];
                for (t, r) in run.time.iter().zip(self.left(sensor)) {
                    let (sum, count) = &mut sums[cell(*t)];
                    (*sum, *count) = (*sum + r * r, *count + 1.0);
                }
                sums.into_iter().map(|(sum, count)| sum / count).collect()
            };
            (0..self.measured.len()).map(fold).collect()
        })
    }
}

/// What the reconstruction leaves over phase and sensor, and over phase and level.
fn maps(compared: &[Compared<'_>], ink: Ink) -> Vec<Figure> {
    let mut folded: Vec<(f64, Vec<Vec<f64>>)> =
        compared.iter().filter_map(|run| Some((run.mean_square.sqrt(), run.by_phase()?))).collect();
    folded.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(sensors) = folded.first().map(|(_, cells)| cells.len()) else { return Vec::new() };
    let mean = |rows: &[&Vec<f64>]| -> Vec<f64> {
        let cell = |k: usize| {
            let known = rows.iter().map(|row| row[k]).filter(|square| square.is_finite());
            let (sum, count) = known.fold((0.0, 0.0), |(sum, count), square| (sum + square, count + 1.0));
            f64::sqrt(sum / count)
        };
        (0..CELLS).map(cell).collect()
    };
    let of_sensor = |sensor: usize| mean(&folded.iter().map(|(_, cells)| &cells[sensor]).collect::<Vec<_>>());
    let of_level = |(_, cells): &(f64, Vec<Vec<f64>>)| mean(&cells.iter().collect::<Vec<_>>());
    let phase: Vec<f64> = (0..CELLS).map(|k| (k as f64 + 0.5) / CELLS as f64).collect();
    let map = |up: &str, unit: &str, y: Vec<f64>, before: Vec<Vec<f64>>| ResidualMap {
        across: "phase".into(),
        across_unit: "periods".into(),
        x: phase.clone(),
        up: up.into(),
        up_unit: unit.into(),
        y,
        before,
        after: Vec::new(),
    };
    let levels = folded.iter().map(|(level, _)| *level).collect();
    [
        map(
            "sensor",
            "index",
            (0..sensors).map(|s| s as f64).collect(),
            (0..sensors).map(of_sensor).collect(),
        ),
        map("level", "m/s² RMS", levels, folded.iter().map(of_level).collect()),
    ]
    .iter()
    .flat_map(|map| residuals::maps(map, &[("no law", "rebuilt", &map.before)], ink))
    .collect()
}
