//! From the solved bins to the contact: force, slip, normal force and fit, with the errors that bins have in common.

use super::drift::{Polynomial, Seen, Weighed, levels};
use super::ends::JUMPS;
use super::sources::{Common, OUTPUTS, Outputs, Spectra, combined};
use super::{Round, Whole};
use crate::contact::{BalanceResidual, ContactHarmonics, RunBalance, SharedErrors};
use crate::dynamics::Load;
use faer::Mat;
use frettrace_fourier::{Harmonics, spectrum};
use num_complex::Complex64;
use rayon::prelude::*;

/// Bins that lose the variance which the drift has instead.
const SLOW: usize = 4;

/// All of one bin.
struct Row {
    forces: Vec<Complex64>,
    outputs: Outputs,
    /// What the outputs would be with what is allowed, less what they are.
    differences: Outputs,
    fit: Vec<Complex64>,
    /// Variances of outputs and fit that no other bin shares, and of the fit as a whole.
    own: [f64; OUTPUTS],
    fit_variances: Vec<f64>,
    residual: Vec<Complex64>,
    chi_square: f64,
    led_by_prior: bool,
}

/// Outputs of all bins, and what is uncertain of them.
struct Table {
    values: Spectra,
    variances: [Vec<f64>; OUTPUTS],
    sources: Vec<Spectra>,
}

impl Whole<'_> {
    /// The outcome of the estimate, with the bands of the round under what is `allowed`.
    pub(super) fn outcome(&self, round: &Round, allowed: &Round) -> RunBalance {
        let common = self.common(allowed);
        let line = spectrum(&self.known.contact[0]);
        let rows: Vec<Row> = (0..self.bins.len())
            .into_par_iter()
            .map(|k| self.row(k, (round, allowed), line.get(k + 1).copied().unwrap_or_default()))
            .collect();
        let mut table = Table {
            values: std::array::from_fn(|o| rows.iter().map(|row| row.outputs[o]).collect()),
            variances: std::array::from_fn(|o| rows.iter().map(|row| row.own[o]).collect()),
            // The errors of the common unknowns.
            sources: combined(&common.outputs.iter().collect::<Vec<_>>(), &common.root),
        };
        self.weigh_drift(&rows, (allowed, &common), &mut table);
        table.sources.push(std::array::from_fn(|o| rows.iter().map(|row| row.differences[o]).collect()));
        if !self.known.shared.is_empty() {
            table.sources.extend(self.structure_sources(allowed, &common));
        }
        let residual = BalanceResidual {
            chi_square: rows.iter().map(|row| row.chi_square).collect(),
            freedom: vec![2 * self.setting.dynamics.sensors(); rows.len()],
            whitened: rows.iter().map(|row| row.residual.clone()).collect(),
        };
        let regularised = (0..rows.len()).filter(|k| rows[*k].led_by_prior).map(|k| k + 1).collect();
        RunBalance { contact: self.contact(table, &rows), residual, regularised }
    }

    /// Forces, and outputs of a bin in one round.
    fn estimate(&self, k: usize, round: &Round) -> (Vec<Complex64>, Outputs) {
        let bin = &self.bins[k];
        let answered = self.forces(k, round).1;
        let jump = |u: usize, q: usize| round.common[self.jump(u, q)];
        let mut outputs = self.outputs(&bin.line, bin.exciter, &answered);
        self.add_jumps(k, &jump, &mut outputs);
        for (i, (decay, c)) in self.decays.all.iter().zip(&round.common).enumerate() {
            self.add_motion(i / 2, [decay.displacement[k] * c, decay.velocity[k] * c], &mut outputs);
        }
        let ramps = |u: usize| (0..JUMPS).map(|q| self.ramps[q][k] * jump(u, q)).sum::<Complex64>();
        (answered.iter().enumerate().map(|(u, a)| a + ramps(u)).collect(), outputs)
    }

    /// What contact and free decays make of the accelerations.
    fn contact_accelerations(&self, k: usize, (round, answered): (&Round, &[Complex64])) -> Vec<Complex64> {
        let line = &self.bins[k].line;
        let decays = self.decays.all.iter().zip(&round.common).enumerate();
        let free: Vec<(usize, Complex64)> =
            decays.map(|(i, (decay, c))| (i / 2, decay.acceleration[k] * c)).collect();
        (0..self.setting.dynamics.sensors())
            .map(|s| {
                let loads = self.loads.iter().zip(answered);
                let made: Complex64 = loads.map(|(load, f)| line.acceleration(s, *load) * f).sum();
                let shape = |n: usize| self.setting.dynamics.sensor_shape(n, s);
                made + free.iter().map(|(n, a)| a * shape(*n)).sum::<Complex64>()
            })
            .collect()
    }

    /// What contact and free decays make of the accelerations, and that with what the exciter makes.
    fn accelerations(&self, k: usize, made_by: (&Round, &[Complex64])) -> (Vec<Complex64>, Vec<Complex64>) {
        let (contact, bin) = (self.contact_accelerations(k, made_by), &self.bins[k]);
        let exciter = |s: usize| bin.line.acceleration(s, Load::Exciter) * bin.exciter;
        let fit = contact.iter().enumerate().map(|(s, a)| a + exciter(s)).collect();
        (contact, fit)
    }

    /// Samples of the fitted accelerations, sensor by sensor.
    pub(super) fn fitted(&self, round: &Round) -> Vec<Vec<f64>> {
        let fit = |k: usize| self.accelerations(k, (round, &self.forces(k, round).1)).1;
        let bins: Vec<Vec<Complex64>> = (0..self.bins.len()).into_par_iter().map(fit).collect();
        let sampled = |s: usize| {
            let amplitudes = std::iter::once(Complex64::ZERO).chain(bins.iter().map(|bin| bin[s]));
            let harmonics = Harmonics::exact(self.base, amplitudes.collect());
            harmonics.sample(self.record.rate, self.record.samples)
        };
        (0..self.setting.dynamics.sensors()).into_par_iter().map(sampled).collect()
    }

    fn row(&self, k: usize, (round, allowed): (&Round, &Round), line: Complex64) -> Row {
        let bin = &self.bins[k];
        let (held, answered) = self.forces(k, round);
        let (contact, fit) = self.accelerations(k, (round, &answered));
        let left = bin.measured.iter().zip(&contact).zip(&bin.weights);
        let residual: Vec<Complex64> = left.map(|((y, a), w)| (y - a) * w.sqrt()).collect();
        let prior = held.iter().zip(&round.priors).map(|(h, p)| h.norm_sqr() / p[k]);
        let chi_square = residual.iter().map(Complex64::norm_sqr).chain(prior).sum::<f64>() * 2.0;
        let scale = 2.0 / self.record.samples as f64;
        // A bin is known where its variance is less than half of its power, that of the lines included.
        let power = allowed.priors[0][k] + (line * scale).norm_sqr();
        let (forces, outputs) = self.estimate(k, round);
        let other = self.estimate(k, allowed).1;
        Row {
            forces,
            differences: std::array::from_fn(|o| other[o] - outputs[o]),
            outputs,
            fit,
            own: self.own_variances(k, allowed),
            fit_variances: self.fit_variances(k, allowed),
            led_by_prior: allowed.solved[k].covariance[0].re > 0.5 * power,
            residual,
            chi_square,
        }
    }

    /// Variances of the outputs from the forces' own covariance `K`, the common unknowns being given.
    fn own_variances(&self, k: usize, round: &Round) -> [f64; OUTPUTS] {
        let n = self.loads.len();
        let covariance = &round.solved[k].covariance;
        let unit = |u: usize| -> Vec<Complex64> {
            (0..n).map(|i| Complex64::from(if i == u { 1.0 } else { 0.0 })).collect()
        };
        let gains: Vec<_> =
            (0..n).map(|u| self.outputs(&self.bins[k].line, Complex64::ZERO, &unit(u))).collect();
        std::array::from_fn(|o| {
            (0..n * n)
                .map(|e| (gains[e / n][o] * covariance[e] * gains[e % n][o].conj()).re)
                .sum::<f64>()
                .max(0.0)
        })
    }

    /// Variances of the fitted accelerations. Both decays of a mode have its shape: a common unknown moves the fit by what the forces
    /// leave of its vector, so that products are formed of vectors and scaled.
    fn fit_variances(&self, k: usize, round: &Round) -> Vec<f64> {
        let (bin, solved, columns) = (&self.bins[k], &round.solved[k], self.columns(k, &round.jumps));
        let (size, loads) = (bin.size(), self.loads.len());
        let mut covariance = vec![Complex64::ZERO; size * size];
        let mut row = vec![Complex64::ZERO; size];
        for (i, (a, x)) in columns.iter().enumerate() {
            row.fill(Complex64::ZERO);
            for (j, (b, y)) in columns.iter().enumerate() {
                row[*b] += y.conj() * round.covariance[(i, j)];
            }
            covariance[a * size..][..size].iter_mut().zip(&row).for_each(|(sum, r)| *sum += x * r);
        }
        let made = |s: usize, u: usize| bin.line.acceleration(s, self.loads[u]);
        let variance = |s: usize| {
            let left = |d: usize| -> Complex64 {
                let vector = match d.checked_sub(self.record.modes) {
                    Some(load) => made(s, load),
                    None => Complex64::from(self.setting.dynamics.sensor_shape(d, s)),
                };
                vector - (0..loads).map(|u| made(s, u) * solved.taken(u, d)).sum::<Complex64>()
            };
            let moved: Vec<Complex64> = (0..size).map(left).collect();
            let along =
                |row: &[Complex64]| -> Complex64 { row.iter().zip(&moved).map(|(c, m)| c * m.conj()).sum() };
            let common: f64 =
                moved.iter().zip(covariance.chunks_exact(size)).map(|(m, row)| (m * along(row)).re).sum();
            let own: f64 = (0..loads * loads)
                .map(|e| (made(s, e / loads) * solved.covariance[e] * made(s, e % loads).conj()).re)
                .sum();
            (common + own).max(0.0)
        };
        (0..self.setting.dynamics.sensors()).map(variance).collect()
    }

    /// The structure's errors, what the lines have of each put to what the bins have.
    fn structure_sources(&self, round: &Round, common: &Common) -> Vec<Spectra> {
        let mut sources = self.structure(round, common);
        for (source, known) in sources.iter_mut().zip(&self.known.shared) {
            for (bins, samples) in source.iter_mut().zip(known) {
                self.put(bins, samples);
            }
        }
        sources
    }

    /// Adds samples to amplitudes; none where there are no samples.
    fn put(&self, bins: &mut [Complex64], samples: &[f64]) {
        if !samples.is_empty() {
            bins.iter_mut().zip(self.record.amplitudes(samples)).for_each(|(bin, more)| *bin += more);
        }
    }

    /// Weighs the drift of the forces against its level; what is taken out is taken out of all outputs.
    fn weigh_drift(&self, rows: &[Row], (round, common): (&Round, &Common), table: &mut Table) {
        let loads = self.loads.len();
        let polynomials = Polynomial::all(self.record.rate, self.record.samples);
        let forces: Vec<Vec<Complex64>> =
            (0..loads).map(|u| rows.iter().map(|row| row.forces[u]).collect()).collect();
        let seen: Vec<Seen> = forces
            .iter()
            .enumerate()
            .map(|(u, force)| Seen {
                still: self.without_drift(force, &polynomials),
                left: round.solved.iter().map(|s| s.covariance[u * loads + u].re).collect(),
                free: self.bins.iter().map(|bin| bin.variances[u]).collect(),
            })
            .collect();
        for polynomial in &polynomials {
            let content: Vec<f64> = forces.iter().map(|force| polynomial.of(force)).collect();
            let moved = Mat::from_fn(loads, common.forces.len(), |u, i| polynomial.of(&common.forces[i][u]));
            let contents = moved * &common.root;
            let own = Mat::from_fn(loads, loads, |u, v| {
                polynomial.of_independent(round.solved.iter().map(|s| s.covariance[u * loads + v].re))
            });
            let known = &contents * contents.transpose() + &own;
            let weighed = Weighed::new(&known, &levels(polynomial, &seen));
            let taken = |u: usize| (0..loads).map(|v| weighed.share[(u, v)] * content[v]).sum::<f64>();
            self.add_drift(&mut table.values, polynomial, &|u| -taken(u));
            for (s, source) in table.sources.iter_mut().enumerate().take(common.root.ncols()) {
                self.add_drift(source, polynomial, &|u| -contents[(u, s)]);
            }
            self.lose(&own, &mut table.variances);
            for p in 0..loads {
                let mut source: Spectra = std::array::from_fn(|_| vec![Complex64::ZERO; rows.len()]);
                self.add_drift(&mut source, polynomial, &|u| weighed.root[(u, p)]);
                table.sources.push(source);
            }
        }
    }

    /// Samples of a force without its drift.
    fn without_drift(&self, force: &[Complex64], polynomials: &[Polynomial]) -> Vec<f64> {
        let mut bins = vec![Complex64::ZERO; force.len() + 1];
        bins[1..].copy_from_slice(force);
        for polynomial in polynomials {
            let content = polynomial.of(force);
            bins[1..].iter_mut().zip(&polynomial.bins).for_each(|(bin, p)| *bin -= p * content);
        }
        Harmonics::exact(self.base, bins).sample(self.record.rate, self.record.samples)
    }

    /// Adds a polynomial in the forces to outputs, so much for each load.
    fn add_drift(&self, outputs: &mut Spectra, polynomial: &Polynomial, size: &dyn Fn(usize) -> f64) {
        let sum = |o: usize| (0..self.loads.len()).map(|u| self.slow[u].gain[o] * size(u)).sum::<f64>();
        for (o, output) in outputs.iter_mut().enumerate() {
            // The velocity is that of the slip.
            let (shape, gain) = if o == 2 { (&polynomial.slope, sum(1)) } else { (&polynomial.bins, sum(o)) };
            output.iter_mut().zip(shape).for_each(|(value, p)| *value += p * gain);
        }
    }

    /// Takes the drift's share, of the covariance given in the forces, off the variances of the first bins: it is a source now.
    fn lose(&self, own: &Mat<f64>, variances: &mut [Vec<f64>; OUTPUTS]) {
        let loads = self.loads.len();
        for (o, variances) in variances.iter_mut().enumerate() {
            let gain = |u: usize| self.slow[u].gain[o];
            let share: f64 = (0..loads * loads)
                .map(|e| gain(e / loads) * own[(e / loads, e % loads)] * gain(e % loads))
                .sum();
            let first = &mut variances[..SLOW.min(self.bins.len())];
            let sum = 0.5 * first.iter().sum::<f64>();
            let kept = if sum > 0.0 { (1.0 - share / sum).clamp(0.0, 1.0) } else { 1.0 };
            first.iter_mut().for_each(|v| *v *= kept);
        }
    }

    /// Harmonics of all outputs, what was known put back.
    fn contact(&self, mut table: Table, rows: &[Row]) -> ContactHarmonics {
        for (values, known) in table.values.iter_mut().zip(&self.known.contact) {
            self.put(values, known);
        }
        let with_mean = |mut bins: Vec<Complex64>| {
            bins.insert(0, Complex64::ZERO);
            bins
        };
        let mut shared: [Vec<Vec<Complex64>>; OUTPUTS] = Default::default();
        for source in table.sources {
            for (o, bins) in source.into_iter().enumerate() {
                let variances = table.variances[o].iter_mut().zip(&bins);
                variances.for_each(|(variance, bin)| *variance += bin.norm_sqr());
                shared[o].push(with_mean(bins));
            }
        }
        let harmonics = |coefficients: Vec<Complex64>, variances: Vec<f64>| Harmonics {
            base: self.base,
            coefficients: with_mean(coefficients),
            variance: std::iter::once(0.0).chain(variances).collect(),
        };
        let fit = |s: usize| {
            let mut values: Vec<Complex64> = rows.iter().map(|row| row.fit[s]).collect();
            self.put(&mut values, self.known.accelerations.get(s).map_or(&[], Vec::as_slice));
            harmonics(values, rows.iter().map(|row| row.fit_variances[s]).collect())
        };
        let acceleration_fit = (0..self.setting.dynamics.sensors()).map(fit).collect();
        let [friction, slip, velocity, normal, second] = shared;
        let mut outputs = table.values.into_iter().zip(table.variances).map(|(v, var)| harmonics(v, var));
        let mut next = || outputs.next().unwrap_or_else(|| Harmonics::exact(self.base, Vec::new()));
        let shared = SharedErrors { friction, slip, slip_velocity: velocity, normal, second_support: second };
        let [friction, slip, slip_velocity, normal, second] = std::array::from_fn(|_| next());
        let second_support = self.loads.contains(&Load::SecondSupport).then_some(second);
        ContactHarmonics { friction, slip, slip_velocity, normal, second_support, acceleration_fit, shared }
    }
}
