//! Linearisation of one run: what the laws answer to a change of forces, motions or parameters.

use super::contact::{Local, PARAMETERS};
use super::response::Response;
use super::run::{Evaluation, LEAK, State, store, velocity};
use super::setting::PortPlace;
use frettrace_fourier::GridScratch;
use frettrace_friction::effects::Hook;
use num_complex::Complex64;

/// One direction: motions of slip, normal force and ports on the grid, and the law parameter that changes.
#[derive(Clone, Debug, Default)]
pub(super) struct Direction {
    pub slip: Vec<f64>,
    pub velocity: Vec<f64>,
    /// Change of the force that a rigid contact takes as long as it holds.
    pub trial: Vec<f64>,
    /// Change of the support's force from the motion of the end.
    pub support: Vec<f64>,
    pub ports: Vec<[Vec<f64>; 2]>,
    /// Index of the hook among those differentiated.
    pub hook: Option<usize>,
    /// Port and coefficient that change.
    pub coefficient: Option<(usize, usize)>,
}

/// What every step of a period answers to small changes.
pub(super) struct Tangent<'a> {
    evaluation: &'a Evaluation<'a>,
    locals: Vec<Local>,
    /// `∂f/∂d`, `∂f/∂ḋ` and `∂f/∂c` of every port at every sample.
    ports: Vec<Vec<super::ports::PortForce>>,
    response: Response,
}

impl<'a> Tangent<'a> {
    pub fn new(evaluation: &'a Evaluation<'a>, state: &'a State, hooks: &[Hook]) -> Self {
        let mut locals = Vec::with_capacity(evaluation.grid.samples());
        let law = &evaluation.setting.law;
        let start = state.start.unwrap_or_else(|| law.rest_at(0.0));
        evaluation.contact().locals(&state.contact, start, hooks, &mut locals);
        let ports = (evaluation.setting.ports.iter().zip(&state.ports))
            .map(|(port, [d, v])| {
                d.iter().zip(v).map(|(d, v)| port.law.force(&port.coefficients, *d, *v)).collect()
            })
            .collect();
        let used = if law.get(Hook::ForceLag).is_some() {
            4
        } else if law.get(Hook::Backlash).is_some() {
            3
        } else if law.remembers() {
            2
        } else {
            1
        };
        let response = Response::new(&locals, used);
        Self { evaluation, locals, ports, response }
    }

    /// The direction of given lines of motion in every row.
    pub fn direction(&self, row: impl Fn(usize) -> Vec<Complex64>, scratch: &mut GridScratch) -> Direction {
        let e = self.evaluation;
        let mut sampled = |lines: &[Complex64]| {
            let mut samples = vec![0.0; e.grid.samples()];
            e.grid.evaluate(lines, &mut samples, scratch);
            samples
        };
        let mut slip = row(0);
        if let Some(mean) = slip.first_mut() {
            *mean = Complex64::ZERO;
        }
        let speed = velocity(&slip, e.lines.omega);
        let mut direction =
            Direction { slip: sampled(&slip), velocity: sampled(&speed), ..Direction::default() };
        if e.rigid() {
            let resistance = e.resistance();
            direction.trial = direction.velocity.iter().map(|v| v * resistance).collect();
        }
        if e.support_stiffness > 0.0 && e.rotation {
            direction.support = sampled(&row(1));
            direction.support.iter_mut().for_each(|w| *w *= e.support_stiffness);
        }
        for p in 0..e.layout.ports {
            let lines = row(e.layout.port_row(p));
            let speed = velocity(&lines, e.lines.omega);
            direction.ports.push([sampled(&lines), sampled(&speed)]);
        }
        direction
    }

    /// Force harmonics (all ports) that answer to a direction.
    pub fn answer(&self, direction: &Direction, scratch: &mut GridScratch) -> Vec<f64> {
        let e = self.evaluation;
        let width = 2 * e.order() + 1;
        let mut out = vec![0.0; e.width()];
        let mut lines = vec![Complex64::ZERO; e.order() + 1];
        let mut normal = vec![0.0; e.grid.samples()];
        if !direction.support.is_empty() {
            normal.iter_mut().zip(&direction.support).for_each(|(n, s)| *n = -s);
        }
        for p in 0..e.layout.ports {
            let force = self.port_answer(p, direction);
            if e.setting.ports[p].place == PortPlace::Support {
                normal.iter_mut().zip(&force).for_each(|(n, f)| *n -= f);
            }
            e.grid.project(&force, &mut lines, scratch);
            store(&lines, &mut out[(1 + p) * width..(2 + p) * width]);
        }
        let force = self.friction_answer(direction, &normal);
        e.grid.project(&force, &mut lines, scratch);
        store(&lines, &mut out[..width]);
        out
    }

    fn port_answer(&self, port: usize, direction: &Direction) -> Vec<f64> {
        let moved = direction.ports.get(port);
        let changed = direction.coefficient.filter(|(p, _)| *p == port);
        self.ports[port]
            .iter()
            .enumerate()
            .map(|(k, local)| {
                let by_motion = moved.map_or(0.0, |[d, v]| local.stiffness * d[k] + local.damping * v[k]);
                by_motion + changed.map_or(0.0, |(_, c)| local.coefficients[c])
            })
            .collect()
    }

    /// Friction force that answers to a direction, with the state's own period closed.
    fn friction_answer(&self, direction: &Direction, normal: &[f64]) -> Vec<f64> {
        let samples = self.locals.len();
        let moves = !direction.slip.is_empty();
        let still = vec![0.0; if moves { 0 } else { samples }];
        let (slip, speed) = if moves { (&direction.slip, &direction.velocity) } else { (&still, &still) };
        let hook = direction.hook.filter(|h| *h < PARAMETERS).map(|h| Local::PARAMETER + h);
        self.response.answer(
            |k, next| {
                let trial = direction.trial.get(next).copied().unwrap_or_default();
                [slip[k], slip[next], speed[k], speed[next], normal[k], normal[next], trial]
            },
            |k| {
                let (local, hook) = (&self.locals[k], hook?);
                Some(std::array::from_fn(
                    |i| if i == 0 { local.force[hook] } else { local.state[i - 1][hook] },
                ))
            },
        )
    }

    /// Change of the residual `f − Φ(f)` per unknown, column by column.
    ///
    /// Lines above [`FULL_LINES`] whose forces move the contacts too little to be answered ([`COUPLED`]) stay identity: there
    /// the plain iteration contracts by itself. A stiff contact answers on all its lines.
    pub fn jacobian(&self, scratch: &mut GridScratch) -> faer::Mat<f64> {
        let e = self.evaluation;
        let width = e.width();
        let per_port = 2 * e.order() + 1;
        let mut jacobian = faer::Mat::<f64>::identity(width, width);
        let tables = Tables::new(e.grid.samples());
        let mut direction = Direction::default();
        let slopes = self.slopes();
        let resistance = e.rigid().then(|| e.resistance());
        for column in 0..width {
            let (port, place) = (column / per_port, column % per_port);
            let line = place.div_ceil(2);
            let always = resistance.is_some() || line <= FULL_LINES * e.subharmonic();
            if !always && self.strength(&slopes, (port, line)) < COUPLED {
                continue;
            }
            let unit = if place % 2 == 1 || place == 0 { Complex64::ONE } else { Complex64::I };
            self.single_line(&mut direction, &tables, line, |row| -e.block.at(line, row, 1 + port) * unit);
            if let Some(resistance) = resistance {
                let own = if port == 0 { unit } else { Complex64::ZERO };
                tables.wave(line, if line == 0 { own * (1.0 - LEAK) } else { own }, &mut direction.trial);
                let pairs = direction.trial.iter_mut().zip(&direction.velocity);
                pairs.for_each(|(trial, v)| *trial += resistance * v);
            }
            for (row, value) in self.answer(&direction, scratch).into_iter().enumerate() {
                jacobian[(row, column)] -= value;
            }
        }
        jacobian
    }

    /// Mean stiffness and damping of every port over the period, friction first.
    fn slopes(&self) -> Vec<[f64; 2]> {
        let mean = |count: usize, sum: f64| sum / count.max(1) as f64;
        // The stiffness of a step shows in its new slip alone: the old state answers for the old slip.
        let m = Local::MOTION;
        let contact = [
            mean(self.locals.len(), self.locals.iter().map(|local| local.force[m + 1].abs()).sum()),
            mean(
                self.locals.len(),
                self.locals.iter().map(|l| (l.force[m + 2] + l.force[m + 3]).abs()).sum(),
            ),
        ];
        let of_port = |port: &Vec<super::ports::PortForce>| {
            [
                mean(port.len(), port.iter().map(|local| local.stiffness.abs()).sum()),
                mean(port.len(), port.iter().map(|local| local.damping.abs()).sum()),
            ]
        };
        std::iter::once(contact).chain(self.ports.iter().map(of_port)).collect()
    }

    /// What the contacts answer on a line to a unit force of a port on it.
    fn strength(&self, slopes: &[[f64; 2]], (port, line): (usize, usize)) -> f64 {
        let e = self.evaluation;
        let turn = line as f64 * e.lines.omega;
        let answered = slopes.iter().enumerate().map(|(q, [stiffness, damping])| {
            let row = if q == 0 { 0 } else { e.layout.port_row(q - 1) };
            e.block.at(line, row, 1 + port).norm() * (stiffness + turn * damping)
        });
        answered.fold(0.0, f64::max)
    }

    /// A direction in which every row moves on one line only.
    fn single_line(
        &self,
        direction: &mut Direction,
        tables: &Tables,
        line: usize,
        row: impl Fn(usize) -> Complex64,
    ) {
        let e = self.evaluation;
        let turn = Complex64::new(0.0, line as f64 * e.lines.omega);
        let slip = if line == 0 { Complex64::ZERO } else { row(0) };
        tables.wave(line, slip, &mut direction.slip);
        tables.wave(line, slip * turn, &mut direction.velocity);
        if e.support_stiffness > 0.0 && e.rotation {
            tables.wave(line, row(1) * e.support_stiffness, &mut direction.support);
        }
        direction.ports.resize(e.layout.ports, [Vec::new(), Vec::new()]);
        for (p, [d, v]) in direction.ports.iter_mut().enumerate() {
            let motion = row(e.layout.port_row(p));
            tables.wave(line, motion, d);
            tables.wave(line, motion * turn, v);
        }
    }
}

/// Lines (of the excitation) whose forces are always coupled in the derivative of the balance.
const FULL_LINES: usize = 40;
/// Answer to a unit force from which a line above them is coupled too: without it the iteration contracts by this factor.
const COUPLED: f64 = 0.1;

/// One period of the cosine on the grid.
struct Tables {
    cosine: Vec<f64>,
    sine: Vec<f64>,
}

impl Tables {
    fn new(samples: usize) -> Self {
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / samples as f64;
        Self {
            cosine: (0..samples).map(|k| angle(k).cos()).collect(),
            sine: (0..samples).map(|k| angle(k).sin()).collect(),
        }
    }

    /// `Re x̂ e^{ihτ}` on the grid.
    fn wave(&self, line: usize, value: Complex64, out: &mut Vec<f64>) {
        let samples = self.cosine.len();
        out.clear();
        let mut at = 0;
        for _ in 0..samples {
            out.push(value.re * self.cosine[at] - value.im * self.sine[at]);
            at += line;
            if at >= samples {
                at -= samples;
            }
        }
    }
}
