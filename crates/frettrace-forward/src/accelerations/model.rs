//! The model of all runs: prediction of the accelerations' lines from the excitation alone, and its derivatives.

use super::differentiation::{Differentiation, distort};
use super::run::{Evaluation, RunLines, State};
use super::setting::{Quantity, Rig, Setting};
use super::solve::{RunMemory, approach, solve};
use super::structure::{Block, Layout, Structure};
use frettrace_beam::{BeamError, ModalModel};
use frettrace_fourier::{Grid, GridError};
use num_complex::Complex64;
use rayon::prelude::*;
use std::sync::Arc;

/// Why the model cannot be evaluated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AccelerationError {
    /// The beam cannot be modelled.
    #[error(transparent)]
    Beam(#[from] BeamError),
    /// The phase grid cannot carry the lines.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// The contact forces of a run were not found.
    #[error(
        "run {}: the balance of the contact forces does not close (left {left:.3} standard deviations)", .run + 1
    )]
    NotBalanced {
        /// Index of the run.
        run: usize,
        /// What is left, in standard deviations of the lines.
        left: f64,
    },
}

/// Predicted lines of all sensors of one run: `[sensor][line]`.
pub type Prediction = Vec<Vec<Complex64>>;

/// A prediction with its derivatives by physical values.
#[derive(Clone, Debug, Default)]
pub struct Linearised {
    /// The prediction.
    pub prediction: Prediction,
    /// Its derivatives, one a quantity, in the order asked for.
    pub columns: Vec<Prediction>,
}

/// What is kept between evaluations.
#[derive(Clone, Default)]
pub struct Memory {
    runs: Vec<RunMemory>,
}

impl Memory {
    /// Begins a run from a mean of the friction force (N): no accelerometer sees it, and where friction depends on the contact's place
    /// several may be in balance.
    pub fn begin_from(&mut self, run: usize, mean: f64) {
        if self.runs.len() <= run {
            self.runs.resize_with(run + 1, RunMemory::default);
        }
        self.runs[run] = RunMemory::with_mean_force(mean);
    }

    /// Whether a solution of the run, or where to begin it, is known.
    #[must_use]
    pub fn knows(&self, run: usize) -> bool {
        self.runs.get(run).is_some_and(RunMemory::is_begun)
    }

    /// The same solutions without the factors of their balances, which take most of the memory and are soon made again.
    #[must_use]
    pub fn without_factors(&self) -> Self {
        Self { runs: self.runs.iter().map(RunMemory::without_factor).collect() }
    }

    /// The factors of these balances, with nothing of their solutions but the mean of each: every run begins anew from its accelerations, and ends beside
    /// the motion that they show whatever these solutions were.
    #[must_use]
    pub fn factors(&self) -> Self {
        Self { runs: self.runs.iter().map(RunMemory::factor_alone).collect() }
    }

    /// The solutions of a setting with `ports` ports, for the same setting with one more that exerts nothing.
    #[must_use]
    pub fn with_idle_port(&self, ports: usize) -> Self {
        Self { runs: self.runs.iter().map(|run| run.with_idle_port(ports)).collect() }
    }
}

/// Accelerations of a rig under known forces.
#[derive(Clone)]
pub struct AccelerationModel {
    rig: Rig,
    /// Its beam, without measured values.
    declared: ModalModel,
    /// The runs.
    pub runs: Vec<RunLines>,
    grids: Arc<Vec<Grid>>,
    /// What is added to the predicted lines of a run ([`Self::corrected`]).
    corrections: Vec<Option<Prediction>>,
    /// Largest imbalance of a line that still counts as balanced, in standard deviations of the line.
    pub tolerance: f64,
}

/// The phase grids of a model: what was predicted on them holds for a copy of the model, and for none with other grids.
#[derive(Clone)]
pub struct OnGrids(Arc<Vec<Grid>>);

impl PartialEq for OnGrids {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// What the laws and the structure of one run are at given values.
pub(super) struct Prepared {
    block: Block,
    base: Vec<Complex64>,
}

impl AccelerationModel {
    /// A model of the given runs.
    ///
    /// # Errors
    /// [`AccelerationError::Grid`] where a phase grid would alias, [`AccelerationError::Beam`] where the beam cannot be modelled, or ends on a
    /// pin, whose reaction no motion tells.
    pub fn new(rig: Rig, runs: Vec<RunLines>) -> Result<Self, AccelerationError> {
        rig.boundary.reaction_stiffness()?;
        let declared = rig.declared(&rig.boundary)?;
        Ok(Self { rig, declared, grids: grids(&runs)?, runs, corrections: Vec::new(), tolerance: 0.02 })
    }

    /// The same rig, held to the same tolerance, with other runs and no corrections; its beam is not solved again.
    ///
    /// # Errors
    /// [`AccelerationError::Grid`] where a phase grid would alias.
    pub fn with_runs(&self, runs: Vec<RunLines>) -> Result<Self, AccelerationError> {
        let (rig, declared) = (self.rig.clone(), self.declared.clone());
        let (grids, corrections) = (grids(&runs)?, Vec::new());
        Ok(Self { rig, declared, grids, runs, corrections, tolerance: self.tolerance })
    }

    /// The same model whose predictions of each run have a correction `d` added to their lines, where there is one: a prediction on a coarse grid
    /// with `d = p_fine(θ₀) − p_coarse(θ₀)` is that of the fine grid at `θ₀`, and beside it as far as the error of the coarse one is the same
    /// there. Derivatives are those of the coarse grid (defect correction: Stetter, Numer. Math. 29 (1978) 425).
    ///
    /// # Errors
    /// As [`Self::with_runs`].
    pub fn corrected(&self, corrections: Vec<Option<Prediction>>) -> Result<Self, AccelerationError> {
        Ok(Self { corrections, ..self.with_runs(self.runs.clone())? })
    }

    fn correct(&self, run: usize, mut predicted: Prediction) -> Prediction {
        if let Some(correction) = self.corrections.get(run).and_then(Option::as_ref) {
            let lines = predicted.iter_mut().flatten().zip(correction.iter().flatten());
            lines.for_each(|(line, more)| *line += more);
        }
        predicted
    }

    /// Its phase grids.
    #[must_use]
    pub fn on_grids(&self) -> OnGrids {
        OnGrids(self.grids.clone())
    }

    /// The declared rig.
    #[must_use]
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    pub(super) fn structure(&self, setting: &Setting) -> Result<Structure, BeamError> {
        Structure::new((&self.rig, &self.declared), setting)
    }

    /// The solutions of a setting with `ports` ports for a model of the same runs on other lines, as starts on the lines of this one.
    #[must_use]
    pub fn on_lines(&self, memory: &Memory, ports: usize) -> Memory {
        let runs = memory.runs.iter().zip(&self.runs);
        Memory { runs: runs.map(|(kept, run)| kept.on_lines(ports, run.contact_order)).collect() }
    }

    /// Fresh memory: nothing known of any run.
    #[must_use]
    pub fn memory(&self) -> Memory {
        Memory { runs: vec![RunMemory::default(); self.runs.len()] }
    }

    pub(super) fn prepare(&self, structure: &Structure, setting: &Setting, run: usize) -> Prepared {
        let lines = &self.runs[run];
        let block = structure.block(lines.omega, lines.contact_order, lines.progress);
        let base = structure.base_lines(setting, (lines, run));
        Prepared { block, base }
    }

    pub(super) fn evaluation<'a>(
        &'a self,
        layout: Layout,
        setting: &'a Setting,
        prepared: &'a Prepared,
        run: usize,
    ) -> Evaluation<'a> {
        Evaluation {
            lines: &self.runs[run],
            setting,
            block: &prepared.block,
            layout,
            base: &prepared.base,
            support_stiffness: self.rig.boundary.support_stiffness,
            rotation: self.rig.lever.is_some(),
            grid: &self.grids[run],
            rest: setting.rests.1.get(run).map(|rest| (setting.rests.0, *rest)),
            deflection: setting.deflections.get(run).copied().flatten(),
        }
    }

    /// Predicted lines of the selected runs.
    ///
    /// # Errors
    /// [`AccelerationError`] where the structure cannot be built or a run's balance does not close.
    pub fn predict(
        &self,
        setting: &Setting,
        selected: &[usize],
        memory: &mut Memory,
    ) -> Result<Vec<Prediction>, AccelerationError> {
        self.predict_each(setting, selected, memory)?.into_iter().collect()
    }

    /// As [`Self::predict`], with the runs whose balance closes where that of others does not.
    ///
    /// # Errors
    /// [`AccelerationError::Beam`] where the structure cannot be built.
    pub fn predict_each(
        &self,
        setting: &Setting,
        selected: &[usize],
        memory: &mut Memory,
    ) -> Result<Vec<Result<Prediction, AccelerationError>>, AccelerationError> {
        self.predict_by(setting, selected, memory, |e, kept, _| solve(e, kept, self.tolerance))
    }

    /// As [`Self::predict`], by a longer way where that finds no solution: from those of other runs, and from what was recovered.
    ///
    /// # Errors
    /// As [`Self::predict`].
    pub fn approach(
        &self,
        setting: &Setting,
        selected: &[usize],
        memory: &mut Memory,
    ) -> Result<Vec<Prediction>, AccelerationError> {
        self.approach_each(setting, selected, memory)?.into_iter().collect()
    }

    /// As [`Self::approach`], with the runs whose balance closes where that of others does not.
    ///
    /// # Errors
    /// As [`Self::predict_each`].
    pub fn approach_each(
        &self,
        setting: &Setting,
        selected: &[usize],
        memory: &mut Memory,
    ) -> Result<Vec<Result<Prediction, AccelerationError>>, AccelerationError> {
        let known = memory.clone();
        self.predict_by(setting, selected, memory, |e, kept, run| {
            let beside = self.nearest(run).into_iter().filter_map(|other| known.runs.get(other));
            approach(e, kept, (beside, self.tolerance))
        })
    }

    fn predict_by(
        &self,
        setting: &Setting,
        selected: &[usize],
        memory: &mut Memory,
        solved: impl Fn(&Evaluation<'_>, &mut RunMemory, usize) -> Result<(), f64> + Sync,
    ) -> Result<Vec<Result<Prediction, AccelerationError>>, AccelerationError> {
        let structure = self.structure(setting)?;
        Ok(self.each(selected, memory, |run, kept| {
            let prepared = self.prepare(&structure, setting, run);
            let evaluation = self.evaluation(structure.layout(), setting, &prepared, run);
            solved(&evaluation, kept, run).map_err(|left| not_balanced(run, left))?;
            let plain = distort(evaluation.accelerations(&kept.unknowns), setting, self.runs[run].omega);
            Ok(self.correct(run, plain))
        }))
    }

    /// The other runs, those of the nearest excitation first.
    fn nearest(&self, run: usize) -> Vec<usize> {
        let level = |run: usize| self.runs[run].force.iter().map(|f| f.norm()).fold(0.0, f64::max).ln();
        let mut others: Vec<usize> = (0..self.runs.len()).filter(|other| *other != run).collect();
        others.sort_by(|&a, &b| {
            let away = |other: usize| (level(other) - level(run)).abs();
            away(a).total_cmp(&away(b))
        });
        others
    }

    /// Works on the selected runs side by side, each with what is remembered of it.
    pub(super) fn each<T: Send>(
        &self,
        selected: &[usize],
        memory: &mut Memory,
        work: impl Fn(usize, &mut RunMemory) -> T + Sync,
    ) -> Vec<T> {
        memory.runs.resize_with(self.runs.len(), RunMemory::default);
        let mut kept: Vec<(usize, RunMemory)> =
            selected.iter().map(|&run| (run, std::mem::take(&mut memory.runs[run]))).collect();
        let results = kept.par_iter_mut().map(|(run, kept)| work(*run, kept)).collect();
        for (run, kept) in kept {
            memory.runs[run] = kept;
        }
        results
    }

    /// Predicted lines of the selected runs and their derivatives.
    ///
    /// # Errors
    /// As [`Self::predict`].
    pub fn linearise(
        &self,
        setting: &Setting,
        quantities: &[Quantity],
        selected: &[usize],
        memory: &mut Memory,
    ) -> Result<Vec<Linearised>, AccelerationError> {
        let structure = self.structure(setting)?;
        let moved = quantities
            .iter()
            .map(|&quantity| self.moved(&structure, setting, quantity))
            .collect::<Result<Vec<_>, _>>()?;
        self.each(selected, memory, |run, kept| {
            let prepared = self.prepare(&structure, setting, run);
            let evaluation = self.evaluation(structure.layout(), setting, &prepared, run);
            solve(&evaluation, kept, self.tolerance).map_err(|left| not_balanced(run, left))?;
            let differentiation = Differentiation {
                evaluation: &evaluation,
                structure: &structure,
                quantities,
                moved: &moved,
                run,
            };
            let found = differentiation.at(kept);
            Ok(Linearised { prediction: self.correct(run, found.prediction), ..found })
        })
        .into_iter()
        .collect()
    }

    /// For a quantity whose effect on the structure is differenced: the structure beside it, and the distance.
    pub(super) fn moved(
        &self,
        structure: &Structure,
        setting: &Setting,
        quantity: Quantity,
    ) -> Result<Option<(Structure, f64)>, AccelerationError> {
        let length = self.rig.beam.length;
        let distance = match quantity {
            Quantity::ModeFrequency(n) if !structure.plain() => 1e-6 * setting.frequency[n],
            Quantity::ModeDamping(n) if !structure.plain() => 1e-4 * setting.damping[n],
            Quantity::PortPosition(_)
            | Quantity::MassPosition
            | Quantity::Shift(_)
            | Quantity::CommonShift => 1e-7 * length,
            Quantity::ClampCompliance => 1e-6,
            Quantity::AddedMass => 1e-6 * self.rig.beam.mass_per_length * length,
            Quantity::Drift | Quantity::FrequencyScale => 1e-7,
            Quantity::DampingScale => 1e-5,
            Quantity::DriftRate | Quantity::DriftSlowing => 1e-4,
            Quantity::ContactCompliance => 1e-6 * length / self.rig.beam.bending_stiffness,
            _ => return Ok(None),
        };
        let mut beside = setting.clone();
        beside.set(quantity, setting.get(quantity).unwrap_or_default() + distance);
        if Structure::rebuilds(quantity) {
            return Ok(Some((self.structure(&beside)?, distance)));
        }
        let mut other = structure.clone();
        other.retune(&beside);
        Ok(Some((other, distance)))
    }

    /// What is asked of the settled state of a run.
    pub(super) fn settled<T>(
        &self,
        (structure, setting): (&Structure, &Setting),
        run: usize,
        kept: &mut RunMemory,
        asked: impl FnOnce(&Evaluation<'_>, State) -> T,
    ) -> Result<T, AccelerationError> {
        let prepared = self.prepare(structure, setting, run);
        let evaluation = self.evaluation(structure.layout(), setting, &prepared, run);
        solve(&evaluation, kept, self.tolerance).map_err(|left| not_balanced(run, left))?;
        let state = evaluation.evaluate(&kept.unknowns, &mut evaluation.grid.scratch());
        Ok(asked(&evaluation, state))
    }

    /// Recovered motions and forces of a run: the settled state at the current memory, for plots and shapes.
    ///
    /// # Errors
    /// As [`Self::predict`].
    pub fn contact(
        &self,
        setting: &Setting,
        run: usize,
        memory: &mut Memory,
    ) -> Result<ContactHistory, AccelerationError> {
        let structure = self.structure(setting)?;
        let mut histories = self.each(&[run], memory, |run, kept| {
            self.settled((&structure, setting), run, kept, |evaluation, state| ContactHistory {
                deflection: state.start.map_or(0.0, |start| start.0[0]),
                creep: evaluation.contact().creep(&state.contact),
                slip: state.contact.slip,
                velocity: state.contact.velocity,
                normal: state.contact.normal,
                force: state.forces.into_iter().next().unwrap_or_default(),
            })
        });
        histories.pop().unwrap_or_else(|| Ok(ContactHistory::default()))
    }
}

/// Motion and force of the contact over one period, on the phase grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactHistory {
    /// Slip (m).
    pub slip: Vec<f64>,
    /// Slip velocity (m/s).
    pub velocity: Vec<f64>,
    /// Normal force (N).
    pub normal: Vec<f64>,
    /// Friction force (N).
    pub force: Vec<f64>,
    /// Deflection with which the period begins, in units of the friction coefficient.
    pub deflection: f64,
    /// What that gains in the period, where it was given ([`Setting::deflections`]).
    pub creep: f64,
}

fn grids(runs: &[RunLines]) -> Result<Arc<Vec<Grid>>, GridError> {
    let grids: Result<Vec<Grid>, GridError> =
        runs.iter().map(|r| Grid::new(r.contact_order, r.samples)).collect();
    grids.map(Arc::new)
}

fn not_balanced(run: usize, left: f64) -> AccelerationError {
    AccelerationError::NotBalanced { run, left }
}
