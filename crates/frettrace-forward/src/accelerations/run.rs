//! One run: its measured lines, and the balance of its contact forces.

use super::contact::{Begun, Contact, Local, Motion};
use super::phase::FrequencyRatio;
use super::setting::{PortPlace, Setting};
use super::structure::{Block, Layout};
use frettrace_fourier::{Grid, GridScratch};
use frettrace_friction::effects::{Circumstance, Hook, ModifiedState};
use num_complex::Complex64;

/// What was measured in one run, on lines `h·omega`, `h = 0..=H`.
#[derive(Clone, Debug, PartialEq)]
pub struct RunLines {
    /// Base angular frequency (rad/s).
    pub omega: f64,
    /// Preload (N).
    pub preload: f64,
    /// Place between the first run (0) and the last (1).
    pub progress: f64,
    /// The same in the work that friction had done when the run began and when it ended.
    pub worked: [f64; 2],
    /// Excitation force (N).
    pub force: Vec<Complex64>,
    /// Accelerations (m/s²), one vector of lines a sensor.
    pub acceleration: Vec<Vec<Complex64>>,
    /// Standard deviation of real and imaginary part of each line (m/s²).
    pub deviation: Vec<Vec<f64>>,
    /// Phase (rad) at the first sample of a base line that follows the excitation: see [`RunLines::follow_excitation`].
    pub base_phase: f64,
    /// Lines of the force of a second support that is known from elsewhere (N); empty where there is none.
    pub known_force: Vec<Complex64>,
    /// Order of the unknown contact forces, at least the order of the lines.
    pub contact_order: usize,
    /// Samples of the phase grid.
    pub samples: usize,
}

impl RunLines {
    /// Highest measured line.
    #[must_use]
    pub fn order(&self) -> usize {
        self.force.len().saturating_sub(1)
    }

    /// What a law needs to know of the run beside the motion; no phase of a modulation.
    #[must_use]
    pub fn circumstance(&self) -> Circumstance {
        Circumstance {
            preload: self.preload,
            progress: self.progress,
            worked: self.worked,
            ..Circumstance::default()
        }
    }

    /// First strong line of the excitation; 1 where there is none.
    #[must_use]
    pub fn driven(&self) -> usize {
        let largest = self.force.iter().map(|f| f.norm()).fold(0.0, f64::max);
        self.force.iter().position(|f| f.norm() > 0.5 * largest && largest > 0.0).unwrap_or(1).max(1)
    }
}

impl RunLines {
    /// Motion of the base on a line for a unit value of its setting ([`super::Setting::base_line`]).
    pub(super) fn clamp_unit(&self, base_line: Option<FrequencyRatio>, line: usize) -> Complex64 {
        let Some(own) = base_line else { return self.force.get(line).copied().unwrap_or_default() };
        if own.line(self.driven()) != Some(line) {
            return Complex64::ZERO;
        }
        Complex64::from_polar(-(line as f64 * self.omega).powi(-2), line as f64 * self.base_phase)
    }
}

/// Force harmonics of all ports (friction first), `2H + 1` reals each.
pub(super) type Unknowns = Vec<f64>;

pub(super) fn coefficient(unknowns: &[f64], order: usize, port: usize, line: usize) -> Complex64 {
    let base = port * (2 * order + 1);
    if line == 0 {
        Complex64::new(unknowns[base], 0.0)
    } else {
        Complex64::new(unknowns[base + 2 * line - 1], unknowns[base + 2 * line])
    }
}

/// Writes lines as reals.
pub(super) fn store(lines: &[Complex64], out: &mut [f64]) {
    for (h, line) in lines.iter().enumerate() {
        if h == 0 {
            out[0] = line.re;
        } else {
            out[2 * h - 1] = line.re;
            out[2 * h] = line.im;
        }
    }
}

/// One run with everything its evaluation needs.
pub(super) struct Evaluation<'a> {
    pub lines: &'a RunLines,
    pub setting: &'a Setting,
    pub block: &'a Block,
    pub layout: Layout,
    /// Motion of every row caused by the motion of the base, `rows` values a line; empty without it.
    pub base: &'a [Complex64],
    pub support_stiffness: f64,
    pub rotation: bool,
    pub grid: &'a Grid,
    /// Port that the mean of the friction displaces by a known way, and that way ([`Setting::rests`]).
    pub rest: Option<(usize, f64)>,
    /// Deflection with which the period begins, where the contact has not settled ([`Setting::deflections`]).
    pub deflection: Option<f64>,
}

/// Motions and forces of one run on the phase grid.
#[derive(Clone, Debug, Default)]
pub(super) struct State {
    pub contact: Motion,
    /// Displacement and velocity of each port.
    pub ports: Vec<[Vec<f64>; 2]>,
    /// Force of each port, friction first.
    pub forces: Vec<Vec<f64>>,
    pub start: Option<ModifiedState<f64>>,
}

impl Evaluation<'_> {
    pub fn order(&self) -> usize {
        self.lines.contact_order
    }

    /// Lines of the base frequency from one strong line of the excitation to the next.
    pub fn subharmonic(&self) -> usize {
        self.lines.driven()
    }

    pub fn width(&self) -> usize {
        (1 + self.layout.ports) * (2 * self.order() + 1)
    }

    fn force_line(&self, line: usize) -> Complex64 {
        self.lines.force.get(line).copied().unwrap_or_default()
    }

    /// Displacement of a row on a line.
    pub fn displacement(&self, unknowns: &[f64], row: usize, line: usize) -> Complex64 {
        let mut sum = self.block.at(line, row, 0) * self.force_line(line);
        for port in 0..=self.layout.ports {
            sum -= self.block.at(line, row, 1 + port) * coefficient(unknowns, self.order(), port, line);
        }
        if self.layout.known {
            let known = self.lines.known_force.get(line).copied().unwrap_or_default();
            sum -= self.block.at(line, row, 2 + self.layout.ports) * known;
        }
        if let Some(base) = self.base.get(line * self.layout.rows() + row) {
            sum += base;
        }
        sum
    }

    /// Lines of a row and of its velocity.
    fn motion_lines(&self, unknowns: &[f64], row: usize) -> [Vec<Complex64>; 2] {
        let lines: Vec<_> = (0..=self.order()).map(|h| self.displacement(unknowns, row, h)).collect();
        let velocity = velocity(&lines, self.lines.omega);
        [lines, velocity]
    }

    fn sample(&self, lines: &[Complex64], scratch: &mut GridScratch) -> Vec<f64> {
        let mut samples = vec![0.0; self.grid.samples()];
        self.grid.evaluate(lines, &mut samples, scratch);
        samples
    }

    /// Displacement of a port that the mean of the friction makes, where that is known; it is the law's own otherwise.
    pub fn rest_of(&self, port: usize) -> Option<f64> {
        self.rest.filter(|(own, _)| *own == port).map(|(_, rest)| rest)
    }

    /// Takes the mean from the lines of the slip where no law asks for it: the contact starts from it then, whatever holds it there.
    pub fn centre(&self, slip: &mut [Complex64]) {
        if let Some(mean) = slip.first_mut().filter(|_| !self.setting.law.depends_on_place()) {
            *mean = Complex64::ZERO;
        }
    }

    /// Motions, then forces, of the given harmonics.
    pub fn evaluate(&self, unknowns: &[f64], scratch: &mut GridScratch) -> State {
        let mut state = State::default();
        let [mut slip, velocity] = self.motion_lines(unknowns, 0);
        self.centre(&mut slip);
        state.contact.slip = self.sample(&slip, scratch);
        state.contact.velocity = self.sample(&velocity, scratch);
        let mut support = vec![0.0; self.grid.samples()];
        if self.support_stiffness > 0.0 && self.rotation {
            let [end, _] = self.motion_lines(unknowns, 1);
            support = self.sample(&end, scratch);
            support.iter_mut().for_each(|w| *w *= self.support_stiffness);
        }
        let mut port_forces = Vec::new();
        for (p, port) in self.setting.ports.iter().enumerate() {
            let mut lines = self.motion_lines(unknowns, self.layout.port_row(p));
            if let Some(rest) = self.rest_of(p) {
                let row = self.layout.port_row(p);
                let law = self.block.at(0, row, 1) * coefficient(unknowns, self.order(), 0, 0);
                lines[0][0] += law + rest;
            }
            let motion = lines.map(|l| self.sample(&l, scratch));
            let force: Vec<f64> = (motion[0].iter().zip(&motion[1]))
                .map(|(d, v)| port.law.force(&port.coefficients, *d, *v).force)
                .collect();
            if port.place == PortPlace::Support {
                support.iter_mut().zip(&force).for_each(|(s, f)| *s += f);
            }
            state.ports.push(motion);
            port_forces.push(force);
        }
        state.contact.normal = support.iter().map(|s| self.lines.preload - s).collect();
        if self.rigid() {
            let mut force: Vec<_> =
                (0..=self.order()).map(|h| coefficient(unknowns, self.order(), 0, h)).collect();
            force[0] *= 1.0 - LEAK;
            let resistance = self.resistance();
            state.contact.trial = self.sample(&force, scratch);
            for (trial, v) in state.contact.trial.iter_mut().zip(&state.contact.velocity) {
                *trial += resistance * v;
            }
        }
        state.contact.drift = self.contact().drift(&state.contact);
        let mut friction = vec![0.0; self.grid.samples()];
        state.start = Some(self.contact().start(&state.contact, &mut friction));
        state.forces = std::iter::once(friction).chain(port_forces).collect();
        state
    }

    /// Whether the contact is set-valued at rest.
    pub fn rigid(&self) -> bool {
        self.setting.holds_rigidly()
    }

    /// Resistance (N·s/m) with which velocity enters the held force of a rigid contact: the mean impedance that the
    /// structure has there, so that forces and velocities weigh alike.
    pub fn resistance(&self) -> f64 {
        let impedance = |h: usize| -(self.block.at(h, 0, 1).norm() * h as f64 * self.lines.omega).ln();
        ((1..=self.order()).map(impedance).sum::<f64>() / self.order().max(1) as f64).exp()
    }

    pub fn contact(&self) -> Contact<'_> {
        let modulation = self.setting.modulation.line(self.lines.driven()).unwrap_or(0);
        Contact {
            law: &self.setting.law,
            dt: std::f64::consts::TAU / self.lines.omega / self.grid.samples() as f64,
            preload: self.lines.preload,
            progress: self.lines.progress,
            worked: self.lines.worked,
            modulation,
            modulation_phase: modulation as f64 * self.lines.base_phase,
            deflection: self.deflection,
        }
    }

    /// Local derivatives of every step of the settled contact, by the given hooks too, and those of the state with which its period starts.
    pub fn locals(&self, state: &State, hooks: &[Hook]) -> (Vec<Local>, Begun) {
        let start = state.start.unwrap_or_else(|| self.setting.law.rest_at(0.0));
        let mut locals = Vec::with_capacity(self.grid.samples());
        let begun = self.contact().locals(&state.contact, start, hooks, &mut locals);
        (locals, begun)
    }

    /// Force harmonics that the laws answer to the given ones.
    pub fn answer(&self, state: &State, scratch: &mut GridScratch) -> Unknowns {
        let width = 2 * self.order() + 1;
        let mut out = vec![0.0; self.width()];
        let mut lines = vec![Complex64::ZERO; self.order() + 1];
        for (force, out) in state.forces.iter().zip(out.chunks_mut(width)) {
            self.grid.project(force, &mut lines, scratch);
            store(&lines, out);
        }
        out
    }

    /// Accelerations at the sensors, undistorted: `−(hΩ)²` times the displacements.
    pub fn accelerations(&self, unknowns: &[f64]) -> Vec<Vec<Complex64>> {
        (0..self.layout.sensors)
            .map(|s| {
                (0..=self.lines.order())
                    .map(|h| {
                        let at = h as f64 * self.lines.omega;
                        self.displacement(unknowns, Layout::sensor_row(s), h) * (-at * at)
                    })
                    .collect()
            })
            .collect()
    }
}

/// Share of the mean force that a rigid contact lets go: where it never slides nothing determines that mean.
pub(super) const LEAK: f64 = 1e-6;

/// Lines of the velocity of a motion.
pub(super) fn velocity(lines: &[Complex64], omega: f64) -> Vec<Complex64> {
    lines.iter().enumerate().map(|(h, x)| x * Complex64::new(0.0, h as f64 * omega)).collect()
}
