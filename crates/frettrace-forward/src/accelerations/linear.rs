//! Linearisation of one run: what the laws answer to a change of forces, motions or parameters.

use super::contact::{Begun, Local, PARAMETERS};
use super::momentary::Momentary;
use super::response::{Moves, Response};
use super::run::{Evaluation, LEAK, State, coefficient, store, velocity};
use super::setting::PortPlace;
use frettrace_fourier::GridScratch;
use frettrace_friction::effects::{Hook, STATES};
use num_complex::Complex64;
use rayon::prelude::*;

/// `L` directions side by side: motions of slip, normal force and ports on the grid, and the law parameter that changes.
#[derive(Clone, Debug, Default)]
pub(super) struct Direction<const L: usize> {
    pub slip: Vec<[f64; L]>,
    pub velocity: Vec<[f64; L]>,
    /// Change of the force that a rigid contact takes as long as it holds.
    pub trial: Vec<[f64; L]>,
    /// Change of the support's force from the motion of the end.
    pub support: Vec<[f64; L]>,
    pub ports: Vec<[Vec<[f64; L]>; 2]>,
    /// Index of the hook among those differentiated.
    pub hook: Option<usize>,
    /// Port and coefficient that change.
    pub coefficient: Option<(usize, usize)>,
}

/// A motion on the grid to which forces answer.
#[derive(Clone, Copy, Debug)]
pub(super) enum Moved {
    Slip,
    Velocity,
    /// The force that a rigid contact takes as long as it holds.
    Trial,
    /// The support's force from the motion of the end.
    Support,
    Port(usize),
    PortVelocity(usize),
}

/// What every step of a period answers to small changes.
pub(super) struct Tangent<'a> {
    pub(super) evaluation: &'a Evaluation<'a>,
    pub(super) locals: Vec<Local>,
    begun: Begun,
    /// `∂f/∂d`, `∂f/∂ḋ` and `∂f/∂c` of every port at every sample.
    pub(super) ports: Vec<Vec<super::ports::PortForce>>,
    response: Response,
}

impl<'a> Tangent<'a> {
    pub fn new(evaluation: &'a Evaluation<'a>, state: &'a State, hooks: &[Hook]) -> Self {
        let (locals, begun) = evaluation.locals(state, hooks);
        let ports = (evaluation.setting.ports.iter().zip(&state.ports))
            .map(|(port, [d, v])| {
                d.iter().zip(v).map(|(d, v)| port.law.force(&port.coefficients, *d, *v)).collect()
            })
            .collect();
        let response = Response::new(
            &locals,
            &begun,
            (evaluation.setting.law.states(), evaluation.deflection.is_some(), evaluation.contact().dt),
        );
        Self { evaluation, locals, begun, ports, response }
    }

    /// The direction of given lines of motion in every row.
    pub fn direction(
        &self,
        row: impl Fn(usize) -> Vec<Complex64>,
        scratch: &mut GridScratch,
    ) -> Direction<1> {
        let e = self.evaluation;
        let mut sampled = |lines: &[Complex64]| {
            let mut samples = vec![0.0; e.grid.samples()];
            e.grid.evaluate(lines, &mut samples, scratch);
            samples.into_iter().map(|x| [x]).collect::<Vec<_>>()
        };
        let mut slip = row(0);
        e.centre(&mut slip);
        let speed = velocity(&slip, e.lines.omega);
        let mut direction =
            Direction { slip: sampled(&slip), velocity: sampled(&speed), ..Direction::default() };
        if e.rigid() {
            let resistance = e.resistance();
            direction.trial = direction.velocity.iter().map(|[v]| [v * resistance]).collect();
        }
        if e.support_stiffness > 0.0 && e.rotation {
            direction.support = sampled(&row(1));
            direction.support.iter_mut().for_each(|[w]| *w *= e.support_stiffness);
        }
        for p in 0..e.layout.ports {
            let lines = row(e.layout.port_row(p));
            let speed = velocity(&lines, e.lines.omega);
            direction.ports.push([sampled(&lines), sampled(&speed)]);
        }
        direction
    }

    /// Force harmonics (all ports) that answer to each of the directions.
    pub fn answer<const L: usize>(
        &self,
        direction: &Direction<L>,
        scratch: &mut GridScratch,
    ) -> [Vec<f64>; L] {
        let e = self.evaluation;
        let width = 2 * e.order() + 1;
        let mut out: [Vec<f64>; L] = std::array::from_fn(|_| vec![0.0; e.width()]);
        let mut lines = vec![Complex64::ZERO; e.order() + 1];
        let mut samples = vec![0.0; e.grid.samples()];
        let mut project = |force: &[[f64; L]], port: usize| {
            for (lane, out) in out.iter_mut().enumerate() {
                samples.iter_mut().zip(force).for_each(|(x, force)| *x = force[lane]);
                e.grid.project(&samples, &mut lines, scratch);
                store(&lines, &mut out[port * width..(port + 1) * width]);
            }
        };
        let mut normal: Vec<[f64; L]> = direction.support.iter().map(|s| s.map(|s| -s)).collect();
        for p in 0..e.layout.ports {
            let force = self.port_answer(p, direction);
            if e.setting.ports[p].place == PortPlace::Support {
                normal.resize(e.grid.samples(), [0.0; L]);
                for (normal, force) in normal.iter_mut().zip(&force) {
                    normal.iter_mut().zip(force).for_each(|(n, f)| *n -= f);
                }
            }
            project(&force, 1 + p);
        }
        project(&self.friction_answer(direction, &normal), 0);
        out
    }

    fn port_answer<const L: usize>(&self, port: usize, direction: &Direction<L>) -> Vec<[f64; L]> {
        let moved = direction.ports.get(port);
        let changed = direction.coefficient.filter(|(p, _)| *p == port);
        self.ports[port]
            .iter()
            .enumerate()
            .map(|(k, local)| {
                let fixed = changed.map_or(0.0, |(_, c)| local.coefficients[c]);
                std::array::from_fn(|lane| {
                    let by_motion =
                        moved.map_or(0.0, |[d, v]| local.stiffness * d[k][lane] + local.damping * v[k][lane]);
                    by_motion + fixed
                })
            })
            .collect()
    }

    /// Friction force that answers to each of the directions, with the state's own period closed.
    fn friction_answer<const L: usize>(
        &self,
        direction: &Direction<L>,
        normal: &[[f64; L]],
    ) -> Vec<[f64; L]> {
        let hook = direction.hook.filter(|h| *h < PARAMETERS).map(|h| Local::PARAMETER + h);
        let Direction { slip, velocity, trial, .. } = direction;
        let by_hook = |k: usize| {
            let (local, hook) = (&self.locals[k], hook?);
            Some(std::array::from_fn(|i| if i == 0 { local.force[hook] } else { local.state[i - 1][hook] }))
        };
        let begun = hook.map_or([0.0; STATES], |hook| self.begun.map(|state| state[hook]));
        self.response.answer(&Moves { slip, velocity, normal, trial }, (by_hook, begun))
    }

    /// Change of the residual `f − Φ(f)` along some forces: the [`jacobian`](Self::jacobian) times them, and all lines answer.
    pub fn product(&self, forces: &[f64], scratch: &mut GridScratch) -> Vec<f64> {
        let e = self.evaluation;
        let moved = |row: usize, line: usize| {
            let held = line == 0
                && (0..e.layout.ports).any(|p| e.layout.port_row(p) == row && e.rest_of(p).is_some());
            let acting = (0..=e.layout.ports).filter(|port| *port > 0 || !held);
            acting
                .map(|port| -e.block.at(line, row, 1 + port) * coefficient(forces, e.order(), port, line))
                .sum()
        };
        let mut direction =
            self.direction(|row| (0..=e.order()).map(|line| moved(row, line)).collect(), scratch);
        if e.rigid() {
            let mut own: Vec<_> =
                (0..=e.order()).map(|line| coefficient(forces, e.order(), 0, line)).collect();
            own[0] *= 1.0 - LEAK;
            let mut samples = vec![0.0; e.grid.samples()];
            e.grid.evaluate(&own, &mut samples, scratch);
            direction.trial.iter_mut().zip(&samples).for_each(|([trial], own)| *trial += own);
        }
        let [answer] = self.answer(&direction, scratch);
        forces.iter().zip(&answer).map(|(force, answer)| force - answer).collect()
    }

    /// Change of the residual `f − Φ(f)` per unknown, column by column.
    ///
    /// Lines above [`FULL_LINES`] whose forces move the contacts too little to be answered ([`COUPLED`]) stay identity: there
    /// the plain iteration contracts by itself. A stiff contact answers on all its lines.
    pub fn jacobian(&self) -> faer::Mat<f64> {
        let e = self.evaluation;
        let per_port = 2 * e.order() + 1;
        let mut jacobian = faer::Mat::<f64>::identity(e.width(), e.width());
        let slopes = self.slopes();
        let resistance = e.rigid().then(|| e.resistance());
        let is_coupled = |place: (usize, usize)| {
            let always = resistance.is_some() || place.1 <= FULL_LINES * e.subharmonic();
            always || self.strength(&slopes, place) >= COUPLED
        };
        // A run that is hard to balance may be the last one that anything waits for.
        if let Some(momentary) = Momentary::new(self) {
            let moved = |moved: Moved, place: (usize, usize)| self.moved(moved, place, resistance);
            momentary.subtract_from(&mut jacobian, is_coupled, moved);
            return jacobian;
        }
        let places = (0..=e.layout.ports).flat_map(|port| (0..=e.order()).map(move |line| (port, line)));
        let coupled: Vec<(usize, usize)> = places.filter(|&place| is_coupled(place)).collect();
        for (&(port, line), answers) in coupled.iter().zip(&self.answers(&coupled, resistance)) {
            let first = port * per_port + (2 * line).saturating_sub(1);
            let columns = if line == 0 { 1 } else { 2 };
            for (column, answer) in (first..first + columns).zip(answers) {
                for (value, answer) in jacobian.col_as_slice_mut(column).iter_mut().zip(answer) {
                    *value -= answer;
                }
            }
        }
        jacobian
    }

    /// What all forces answer where real and imaginary part of a port's force on a line alone change, through a contact that may remember.
    fn answers(&self, places: &[(usize, usize)], resistance: Option<f64>) -> Vec<[Vec<f64>; 2]> {
        let e = self.evaluation;
        let tables = Tables::new(e.grid.samples());
        let begin = || (self.still(), e.grid.scratch());
        let answered = |(direction, scratch): &mut (Direction<LANES>, GridScratch),
                        group: &[(usize, usize)]| {
            for (pair, &place) in group.iter().enumerate() {
                self.single_line(direction, (&tables, 2 * pair), place, resistance);
            }
            let mut lanes = self.answer(direction, scratch).into_iter();
            let mut pair = || Some([lanes.next()?, lanes.next()?]);
            group.iter().map_while(|_| pair()).collect::<Vec<_>>()
        };
        let groups = places.par_chunks(LANES / 2);
        groups.map_init(begin, |kept, group| answered(kept, group)).flatten_iter().collect()
    }

    /// Directions in which nothing moves yet.
    fn still(&self) -> Direction<LANES> {
        let e = self.evaluation;
        let none = || vec![[0.0; LANES]; e.grid.samples()];
        let if_any = |any: bool| if any { none() } else { Vec::new() };
        Direction {
            slip: none(),
            velocity: none(),
            trial: if_any(e.rigid()),
            support: if_any(e.support_stiffness > 0.0 && e.rotation),
            ports: (0..e.layout.ports).map(|_| [none(), none()]).collect(),
            ..Direction::default()
        }
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

    /// Two directions, from `lane` on: what moves where real and imaginary part of a port's force on a line alone change.
    fn single_line(
        &self,
        direction: &mut Direction<LANES>,
        (tables, lane): (&Tables, usize),
        (port, line): (usize, usize),
        resistance: Option<f64>,
    ) {
        let place = (port, line);
        let wave = |moved: Moved, out: &mut [[f64; LANES]]| {
            tables.wave((line, lane), self.moved(moved, place, resistance), out);
        };
        wave(Moved::Slip, &mut direction.slip);
        wave(Moved::Velocity, &mut direction.velocity);
        if !direction.support.is_empty() {
            wave(Moved::Support, &mut direction.support);
        }
        if !direction.trial.is_empty() {
            wave(Moved::Trial, &mut direction.trial);
        }
        for (p, [d, v]) in direction.ports.iter_mut().enumerate() {
            wave(Moved::Port(p), d);
            wave(Moved::PortVelocity(p), v);
        }
    }

    /// Line `line` of a motion where the real part of a port's force on it alone changes by one.
    fn moved(&self, moved: Moved, (port, line): (usize, usize), resistance: Option<f64>) -> Complex64 {
        let e = self.evaluation;
        let turn = Complex64::new(0.0, line as f64 * e.lines.omega);
        let row = |row: usize| -e.block.at(line, row, 1 + port);
        let slip = || {
            let mut slip = row(0);
            if line == 0 {
                e.centre(std::slice::from_mut(&mut slip));
            }
            slip
        };
        let of_port = |p: usize| {
            let held = (port, line) == (0, 0) && e.rest_of(p).is_some();
            if held { Complex64::ZERO } else { row(e.layout.port_row(p)) }
        };
        match moved {
            Moved::Slip => slip(),
            Moved::Velocity => slip() * turn,
            Moved::Support => row(1) * e.support_stiffness,
            Moved::Trial => {
                let own = if port == 0 { Complex64::ONE } else { Complex64::ZERO };
                let own = if line == 0 { own * (1.0 - LEAK) } else { own };
                own + slip() * turn * resistance.unwrap_or_default()
            }
            Moved::Port(p) => of_port(p),
            Moved::PortVelocity(p) => of_port(p) * turn,
        }
    }
}

/// Directions that a derivative of the balance answers side by side: a step's derivatives are read once for all of them, and
/// none waits for the state of another.
const LANES: usize = 8;

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

    /// `Re x̂ e^{ihτ}` on the grid into a lane, `Re i x̂ e^{ihτ}` into the next.
    fn wave<const L: usize>(&self, (line, lane): (usize, usize), value: Complex64, out: &mut [[f64; L]]) {
        let samples = self.cosine.len();
        let mut at = 0;
        for out in out {
            let (cosine, sine) = (self.cosine[at], self.sine[at]);
            out[lane] = value.re * cosine - value.im * sine;
            out[lane + 1] = -value.im * cosine - value.re * sine;
            at += line;
            if at >= samples {
                at -= samples;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Momentary, Moved, Tangent};
    use crate::accelerations::{AccelerationModel, Port, PortLaw, PortPlace, Rig, RunLines, Setting};
    use frettrace_beam::{Boundary, UniformBeam};
    use frettrace_friction::effects::{Hook, ModifiedLaw};
    use num_complex::Complex64;

    /// A product is the derivative, column by column and by the slopes' lines, times the forces: of a bristle whose friction changes with its place, under a support
    /// with a mean of its own, and of a rigid contact.
    #[test]
    fn products_are_those_of_the_columns() {
        let rig = Rig {
            beam: UniformBeam::rectangular(0.5, [0.03, 0.0075], 2e11, 7850.0),
            boundary: Boundary::spring(5e6),
            exciter: 0.23,
            sensors: vec![0.12, 0.41],
            lever: Some(0.0037),
            known_support: None,
            modes: 20,
        };
        let mut force = vec![Complex64::ZERO; 6];
        force[1] = 2.5.into();
        let run = RunLines {
            omega: std::f64::consts::TAU * 94.3,
            preload: 70.0,
            progress: 0.0,
            worked: [0.0; 2],
            force,
            acceleration: vec![vec![Complex64::ZERO; 6]; 2],
            deviation: vec![vec![1e-3; 6]; 2],
            base_phase: 0.0,
            known_force: Vec::new(),
            contact_order: 12,
            samples: 128,
        };
        let model = AccelerationModel::new(rig, vec![run]).expect("a model");
        let mut placed = ModifiedLaw::dahl(5e5, 0.25);
        placed.set(Hook::Position, 2e4);
        let modes = vec![620.0, 3900.0];
        for (law, rigid) in [(placed, false), (ModifiedLaw::dahl(5e5, 0.25), true)] {
            let mut setting = Setting { rigid, ..Setting::new(modes.clone(), vec![0.02; 2], law, 2) };
            let port = |place| Port { place, law: PortLaw::Polynomial, coefficients: [800.0, 0.3, 1e9, 2.0] };
            setting.ports = vec![port(PortPlace::At(0.31)), port(PortPlace::Support)];
            setting.rests = (0, vec![1e-6]);
            let structure = model.structure(&setting).expect("a structure");
            let prepared = model.prepare(&structure, &setting, 0);
            let e = model.evaluation(structure.layout(), &setting, &prepared, 0);
            let forces: Vec<f64> = (0..e.width()).map(|k| 3.0 * (0.7 * k as f64).sin()).collect();
            let state = e.evaluate(&forces, &mut e.grid.scratch());
            let tangent = Tangent::new(&e, &state, &[]);
            // Of what does not remember the quick way answers as the columns do.
            let momentary = Momentary::new(&tangent);
            assert_eq!(momentary.is_some(), rigid);
            let resistance = rigid.then(|| e.resistance());
            for place in (0..3).flat_map(|port| [0, 1, 7, 12].map(|line| (port, line))) {
                let Some(momentary) = &momentary else { continue };
                let slow = tangent.answers(&[place], resistance);
                let mut quick = [(); 2].map(|()| vec![0.0; e.width()]);
                let [real, imaginary] = &mut quick;
                let moved = |moved: Moved| tangent.moved(moved, place, resistance);
                momentary.subtract(place.1, moved, (real, imaginary));
                let size = slow[0][0].iter().chain(&slow[0][1]).fold(0.0, |most: f64, x| most.max(x.abs()));
                for column in 0..if place.1 == 0 { 1 } else { 2 } {
                    for (a, b) in slow[0][column].iter().zip(&quick[column]) {
                        assert!((a + b).abs() < 1e-12 * size, "{place:?}: {a} {b}");
                    }
                }
            }
            let change = faer::Col::from_fn(e.width(), |k| (1.9 * k as f64).cos());
            let expected = tangent.jacobian() * &change;
            let change: Vec<f64> = change.iter().copied().collect();
            let found = tangent.product(&change, &mut e.grid.scratch());
            let apart = found.iter().zip(expected.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let size = expected.iter().zip(&change).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(size > 0.1 && apart < 1e-9 * size, "rigid {rigid}: {apart:e} of {size:e}");
        }
    }
}
