//! The derivative of a balance in which no force remembers: a transform a motion in place of one a column.
//!
//! Where the forces answer to the motion of the moment alone, as those of a rigid contact and of ports do, a force that changes on one line `h` changes them by
//! `δf(τ) = Σ_m g_m(τ) x_m(τ)`, over the motions `x_m = Re(c_m e^{ihτ})` of slip, velocity, held force, support and ports. With the lines
//! `G_m(q) = 1/N Σ_k g_m(τ_k) e^{−iqτ_k}` of the slopes, which come again after `N`, those of the answer are
//!
//! `δf̂_l = Σ_m c_m G_m(l − h) + c̄_m G_m(l + h)`, and half of that at `l = 0`:
//!
//! a Toeplitz matrix and a Hankel matrix. The sum over `τ_k` is that of the phase grid, so that it is the same derivative as by columns, aliases and all.

use super::contact::Local;
use super::linear::{Moved, Tangent};
use super::setting::PortPlace;
use faer::{ColMut, Mat};
use frettrace_fourier::{Grid, GridScratch};
use num_complex::Complex64;
use rayon::prelude::*;

/// Slopes of one force by one motion: `G(q)` for `q = −H..=2H`.
struct Slope {
    moved: Moved,
    lines: Vec<Complex64>,
}

/// Slopes of all forces, friction first.
pub(super) struct Momentary {
    order: usize,
    forces: Vec<Vec<Slope>>,
}

impl Momentary {
    /// `None` where the friction answers to an earlier moment too.
    pub fn new(tangent: &Tangent<'_>) -> Option<Self> {
        let e = tangent.evaluation;
        let remembers = |local: &Local| {
            let earlier = [0, 2, 4].map(|at| Local::MOTION + at);
            local.force[..Local::MOTION].iter().any(|by| *by != 0.0)
                || earlier.iter().any(|&at| local.force[at] != 0.0)
        };
        if e.deflection.is_some() || tangent.locals.iter().any(remembers) {
            return None;
        }
        // A step answers for the sample where it ends.
        let friction = |at: usize| {
            let last = tangent.locals.last().into_iter();
            last.chain(&tangent.locals).take(tangent.locals.len()).map(move |local| local.force[at])
        };
        let (slip, velocity, normal) = (Local::MOTION + 1, Local::MOTION + 3, Local::MOTION + 5);
        let mut scratch = e.grid.scratch();
        let mut slope =
            |moved: Moved, values: Vec<f64>| Slope::new((moved, values), (e.grid, e.order()), &mut scratch);
        let mut of_friction = vec![
            slope(Moved::Slip, friction(slip).collect()),
            slope(Moved::Velocity, friction(velocity).collect()),
        ];
        if e.rigid() {
            of_friction.push(slope(Moved::Trial, friction(Local::TRIAL).collect()));
        }
        if e.support_stiffness > 0.0 && e.rotation {
            of_friction.push(slope(Moved::Support, friction(normal).map(|by| -by).collect()));
        }
        let mut forces = Vec::new();
        for (p, port) in tangent.ports.iter().enumerate() {
            if e.setting.ports[p].place == PortPlace::Support {
                let pressed = || friction(normal).zip(port);
                of_friction
                    .push(slope(Moved::Port(p), pressed().map(|(by, port)| -by * port.stiffness).collect()));
                of_friction.push(slope(
                    Moved::PortVelocity(p),
                    pressed().map(|(by, port)| -by * port.damping).collect(),
                ));
            }
            forces.push(vec![
                slope(Moved::Port(p), port.iter().map(|port| port.stiffness).collect()),
                slope(Moved::PortVelocity(p), port.iter().map(|port| port.damping).collect()),
            ]);
        }
        forces.insert(0, of_friction);
        let forces = forces.into_iter().map(|slopes| slopes.into_iter().flatten().collect()).collect();
        Some(Self { order: e.order(), forces })
    }

    /// Takes what the forces answer to those on each line of each port that is coupled from the columns of these; `moved` is the line of a motion where the
    /// real part of one changes by one.
    pub fn subtract_from(
        &self,
        columns: &mut Mat<f64>,
        is_coupled: impl Fn((usize, usize)) -> bool + Sync,
        moved: impl Fn(Moved, (usize, usize)) -> Complex64 + Sync,
    ) {
        let mut none = vec![0.0; columns.nrows()];
        let contiguous = columns.col_iter_mut().filter_map(ColMut::try_as_col_major_mut);
        let mut columns: Vec<&mut [f64]> = contiguous.map(ColMut::as_slice_mut).collect();
        for (port, own) in columns.chunks_mut(2 * self.order + 1).enumerate() {
            let of_line = |line: usize, real: &mut [f64], imaginary: &mut [f64]| {
                if is_coupled((port, line)) {
                    self.subtract(line, |what| moved(what, (port, line)), (real, imaginary));
                }
            };
            let Some((mean, lines)) = own.split_first_mut() else { continue };
            of_line(0, mean, &mut none);
            lines.par_chunks_exact_mut(2).enumerate().for_each(|(at, pair)| {
                if let [real, imaginary] = pair {
                    of_line(at + 1, real, imaginary);
                }
            });
        }
    }

    /// The same on one line, from the columns of the real and of the imaginary part of the force; a mean has the former only.
    pub fn subtract(
        &self,
        line: usize,
        moved: impl Fn(Moved) -> Complex64,
        (real, imaginary): (&mut [f64], &mut [f64]),
    ) {
        let width = 2 * self.order + 1;
        let outs = real.chunks_mut(width).zip(imaginary.chunks_mut(width));
        for (slopes, (real, imaginary)) in self.forces.iter().zip(outs) {
            for slope in slopes {
                let wave = moved(slope.moved);
                let of = |below: Complex64, above: Complex64| (wave * below, wave.conj() * above);
                let below = &slope.lines[self.order - line..];
                let above = &slope.lines[self.order + line..];
                let (a, b) = of(below[0], above[0]);
                real[0] -= 0.5 * (a + b).re;
                imaginary[0] += 0.5 * (a - b).im;
                let pairs = real[1..].chunks_exact_mut(2).zip(imaginary[1..].chunks_exact_mut(2));
                for ((real, imaginary), (below, above)) in pairs.zip(below[1..].iter().zip(&above[1..])) {
                    let (a, b) = of(*below, *above);
                    real[0] -= a.re + b.re;
                    real[1] -= a.im + b.im;
                    imaginary[0] -= b.im - a.im;
                    imaginary[1] -= a.re - b.re;
                }
            }
        }
    }
}

impl Slope {
    /// `None` where nothing answers.
    fn new(
        (moved, values): (Moved, Vec<f64>),
        (grid, order): (&Grid, usize),
        scratch: &mut GridScratch,
    ) -> Option<Self> {
        if values.iter().all(|value| *value == 0.0) {
            return None;
        }
        let bins = grid.bins(&values, scratch);
        let samples = grid.samples();
        let line = |q: usize| match bins.get(q % samples) {
            Some(bin) => *bin,
            None => bins[samples - q % samples].conj(),
        };
        let below = (1..=order).rev().map(|q| line(q).conj());
        Some(Self { moved, lines: below.chain((0..=2 * order).map(line)).collect() })
    }
}
