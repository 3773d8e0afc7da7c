//! The structure as receptances between the points the model needs, line by line.

use super::run::RunLines;
use super::setting::{PortPlace, Quantity, Rig, Setting, course};
use frettrace_beam::{BeamError, Boundary, Dof, Element, ModalModel, Probe};
use num_complex::Complex64;

/// Functionals of the structure: participation of every mode, and the static residual between any two.
#[derive(Clone, Debug)]
pub(super) struct Structure {
    model: ModalModel,
    /// Natural frequency and damping ratio of every mode before both are scaled, as far as no setting holds them.
    own: Vec<(f64, f64)>,
    /// Scales of all natural frequencies and of all damping ratios. A structure whose frequencies scale by `s` has `1/s²` of the static
    /// flexibility.
    stretch: f64,
    loss: f64,
    /// Ratios by which a compliant clamp lowers the measured frequencies; empty where it is stiff.
    clamp: Vec<f64>,
    /// `participation[mode·count + functional]`.
    participation: Vec<f64>,
    count: usize,
    /// Functionals of the rows and columns of a block, an added mass behind both.
    rows: Vec<usize>,
    columns: Vec<usize>,
    /// `φ_r φ_c` of every row and column, mode by mode, and what the static residual adds: a block is their sum weighted with
    /// the modal receptances, line after line.
    products: Vec<f64>,
    residual: Vec<f64>,
    layout: Layout,
    mass: Option<f64>,
    drift: f64,
    drift_course: [f64; 2],
    contact_compliance: f64,
    /// Participation of a uniform motion of the base in each mode, `∫ρA φ dx`.
    rigid: Vec<f64>,
}

/// Which functional is what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    pub sensors: usize,
    pub ports: usize,
    pub known: bool,
    pub mass: bool,
}

impl Layout {
    pub const EXCITER: usize = 0;
    pub const SLIP: usize = 1;

    pub fn port(self, p: usize) -> usize {
        3 + self.sensors + p
    }

    pub fn known(self) -> usize {
        3 + self.sensors + self.ports
    }

    fn mass(self) -> usize {
        self.known() + usize::from(self.known)
    }

    /// Rows of a block: slip, end, sensors, ports.
    pub fn rows(self) -> usize {
        2 + self.sensors + self.ports
    }

    /// Columns of a block: exciter, friction, ports, known force.
    pub fn columns(self) -> usize {
        2 + self.ports + usize::from(self.known)
    }

    /// Functionals of the rows: all but the exciter and a known force, an added mass behind them.
    fn rows_of_blocks(self) -> Vec<usize> {
        (1..=self.rows()).chain(self.mass.then(|| self.mass())).collect()
    }

    /// Functionals of the columns, an added mass behind them.
    fn columns_of_blocks(self) -> Vec<usize> {
        [Self::EXCITER, Self::SLIP]
            .into_iter()
            .chain((0..self.ports).map(|p| self.port(p)))
            .chain(self.known.then(|| self.known()))
            .chain(self.mass.then(|| self.mass()))
            .collect()
    }

    /// Row of a sensor.
    pub fn sensor_row(s: usize) -> usize {
        2 + s
    }

    /// Row of a port.
    pub fn port_row(self, p: usize) -> usize {
        2 + self.sensors + p
    }
}

/// Receptances of one run: `values[(line·rows + row)·columns + column]`.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    pub values: Vec<Complex64>,
    pub rows: usize,
    pub columns: usize,
}

impl Block {
    pub fn at(&self, line: usize, row: usize, column: usize) -> Complex64 {
        self.values[(line * self.rows + row) * self.columns + column]
    }
}

impl Structure {
    /// Of a rig whose declared beam has been solved already.
    pub fn new((rig, declared): (&Rig, &ModalModel), setting: &Setting) -> Result<Self, BeamError> {
        let layout = Layout {
            sensors: rig.sensors.len(),
            ports: setting.ports.len(),
            known: rig.known_support.is_some(),
            mass: setting.mass.is_some(),
        };
        let (model, clamp) = modal_model((rig, declared), setting)?;
        let (dofs, modal) = functionals(rig, setting);
        let probe = model.probe(&dofs);
        let count = dofs.len();
        let mut scale = vec![1.0; count];
        scale[Layout::SLIP] = rig.lever.unwrap_or(1.0);
        let mut participation = vec![0.0; count * model.mode_count()];
        for mode in 0..model.mode_count() {
            for f in 0..count {
                participation[mode * count + f] = match modal[f] {
                    Some(n) => f64::from(u8::from(n == mode)),
                    None => probe.shape(mode)[f] * scale[f],
                };
            }
        }
        let static_residual = scaled_residual(&probe, &scale, &modal);
        let (rows, columns) = (layout.rows_of_blocks(), layout.columns_of_blocks());
        let pairs = || rows.iter().flat_map(|&row| columns.iter().map(move |&column| (row, column)));
        let residual = pairs().map(|(row, column)| static_residual[row * count + column]).collect();
        let products = participation
            .chunks_exact(count)
            .flat_map(|shape| pairs().map(|(row, column)| shape[row] * shape[column]))
            .collect();
        let rigid = if setting.base.is_some() { rigid_participation(rig, &model) } else { Vec::new() };
        let own =
            model.natural_frequency().iter().copied().zip(model.damping_ratio().iter().copied()).collect();
        let mut structure = Self {
            model,
            own,
            stretch: 1.0,
            loss: 1.0,
            clamp,
            participation,
            count,
            rows,
            columns,
            products,
            residual,
            layout,
            mass: setting.mass.map(|m| m[0]),
            drift: setting.drift,
            drift_course: setting.drift_course,
            contact_compliance: setting.contact_compliance,
            rigid,
        };
        structure.retune(setting);
        Ok(structure)
    }

    /// Takes over frequencies, damping, mass and drift; the points stay.
    pub fn retune(&mut self, setting: &Setting) {
        let [stretch, loss] = [1.0 + setting.frequency_scale, 1.0 + setting.damping_scale];
        for mode in 0..self.own.len() {
            let (mut frequency, mut damping) = self.own[mode];
            if let (Some(known), Some(loss)) = (setting.frequency.get(mode), setting.damping.get(mode)) {
                (frequency, damping) = (self.lowered(mode) * known, *loss);
            }
            self.model.set_mode(mode, stretch * frequency, loss * damping);
        }
        (self.stretch, self.loss) = (stretch, loss);
        self.mass = setting.mass.map(|m| m[0]);
        self.drift = setting.drift;
        self.drift_course = setting.drift_course;
        self.contact_compliance = setting.contact_compliance;
    }

    /// Ratio by which a compliant clamp lowers a measured frequency.
    fn lowered(&self, mode: usize) -> f64 {
        self.clamp.get(mode).copied().unwrap_or(1.0)
    }

    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Natural frequency (rad/s), damping ratio and mass-normalised participation of the slip (kg^−½) of every mode.
    pub fn modes_of_slip(&self) -> impl Iterator<Item = [f64; 3]> {
        let values = self.model.natural_frequency().iter().zip(self.model.damping_ratio());
        let shapes = self.participation.chunks_exact(self.count);
        values.zip(shapes).map(|((frequency, damping), shape)| [*frequency, *damping, shape[Layout::SLIP]])
    }

    /// Receptances on the lines `0..=order` of `omega` for a run at `progress` between the first and the last.
    pub fn block(&self, omega: f64, order: usize, progress: f64) -> Block {
        let (rows, columns) = (self.layout.rows(), self.layout.columns());
        let width = self.columns.len();
        let mut wide = vec![Complex64::ZERO; self.rows.len() * width];
        let mut values = Vec::with_capacity((order + 1) * rows * columns);
        // A structure whose frequencies scale by s answers at ω like the nominal one at ω/s, over s².
        let stretch = 1.0 + self.drift * course(self.drift_course, progress);
        for line in 0..=order {
            let at = line as f64 * omega / stretch;
            self.fill(&mut wide, at);
            if let Some(mass) = self.mass {
                add_mass(&mut wide, columns, Element::Mass(mass).dynamic_stiffness(at));
            }
            wide[1] += self.contact_compliance;
            for row in wide.chunks_exact(width).take(rows) {
                values.extend(row[..columns].iter().map(|v| v / (stretch * stretch)));
            }
        }
        Block { values, rows, columns }
    }

    fn fill(&self, wide: &mut [Complex64], omega: f64) {
        for (value, &residual) in wide.iter_mut().zip(&self.residual) {
            *value = Complex64::from(residual / (self.stretch * self.stretch));
        }
        for (mode, products) in self.products.chunks_exact(wide.len()).enumerate() {
            let gain = self.model.modal_receptance(mode, omega);
            for (value, &product) in wide.iter_mut().zip(products) {
                *value += gain * product;
            }
        }
    }

    /// Whether the derivative by a mode's values has rank one.
    pub fn plain(&self) -> bool {
        self.mass.is_none() && self.drift == 0.0 && self.rigid.is_empty()
    }

    /// Derivative of a block by frequency or damping of one mode (only where [`Self::plain`]).
    pub fn mode_gradient(&self, mode: usize, damping: bool, omega: f64, order: usize) -> Block {
        let (rows, columns) = (self.layout.rows(), self.layout.columns());
        let shape = &self.participation[mode * self.count..(mode + 1) * self.count];
        let mut values = Vec::with_capacity((order + 1) * rows * columns);
        let inner = if damping { self.loss } else { self.stretch * self.lowered(mode) };
        for line in 0..=order {
            let gradient = self.model.modal_receptance_gradient(mode, line as f64 * omega);
            let gain = gradient[usize::from(damping)] * inner;
            for row in 0..rows {
                let scaled = gain * shape[self.rows[row]];
                values.extend(self.columns[..columns].iter().map(|&column| scaled * shape[column]));
            }
        }
        Block { values, rows, columns }
    }

    /// Motion of every row per unit motion of the base, on which clamp and supports stand: `ω² Σ φ_r ∫ρAφ dx /(…)` against the
    /// base for contact, end and ports, and one more for sensors, which see the motion in space.
    pub fn transmissibility(&self, omega: f64, order: usize) -> Vec<Complex64> {
        let rows = self.layout.rows();
        let sensors = Layout::sensor_row(0)..Layout::sensor_row(self.layout.sensors);
        let mut out = Vec::with_capacity((order + 1) * rows);
        for line in 0..=order {
            let at = line as f64 * omega;
            out.extend((0..rows).map(|row| Complex64::from(f64::from(u8::from(sensors.contains(&row))))));
            let moved = &mut out[line * rows..];
            for (mode, (shape, rigid)) in
                self.participation.chunks_exact(self.count).zip(&self.rigid).enumerate()
            {
                let gain = self.model.modal_receptance(mode, at) * (at * at * rigid);
                for (value, &functional) in moved.iter_mut().zip(&self.rows) {
                    *value += gain * shape[functional];
                }
            }
        }
        out
    }

    /// Motion of every row with the base of a setting in a run, `rows` values a line; empty where the base is at rest.
    pub fn base_lines(&self, setting: &Setting, (lines, run): (&RunLines, usize)) -> Vec<Complex64> {
        let Some([re, im]) = setting.base else { return Vec::new() };
        let (rows, factor) = (self.layout.rows(), Complex64::new(re, im));
        let unit = self.transmissibility(lines.omega, lines.contact_order).into_iter().enumerate();
        unit.map(|(k, t)| t * factor * setting.clamp_unit(lines, (run, k / rows))).collect()
    }

    /// Whether a quantity moves points or shapes, so that the structure must be built anew.
    pub fn rebuilds(quantity: Quantity) -> bool {
        matches!(
            quantity,
            Quantity::PortPosition(_)
                | Quantity::MassPosition
                | Quantity::ClampCompliance
                | Quantity::Shift(_)
                | Quantity::CommonShift
        )
    }
}

/// Measured modes on the declared beam; a compliant clamp lowers every mode by the declared beam's own ratios, which come with
/// them (none where the clamp is stiff).
fn modal_model(
    (rig, declared): (&Rig, &ModalModel),
    setting: &Setting,
) -> Result<(ModalModel, Vec<f64>), BeamError> {
    if setting.clamp_compliance <= 0.0 {
        return Ok((declared.with_measured(&setting.frequency, &setting.damping)?, Vec::new()));
    }
    let flexural = rig.beam.bending_stiffness / rig.beam.length;
    let soft = Boundary { clamp_rotational_stiffness: flexural / setting.clamp_compliance, ..rig.boundary };
    let loose = rig.declared(&soft)?;
    let modes = loose.natural_frequency().iter().zip(declared.natural_frequency());
    let ratios: Vec<f64> = modes.map(|(loose, stiff)| loose / stiff).take(setting.frequency.len()).collect();
    let frequency: Vec<f64> = setting.frequency.iter().zip(&ratios).map(|(f, ratio)| f * ratio).collect();
    Ok((loose.with_measured(&frequency, &setting.damping)?, ratios))
}

/// Degrees of freedom of all functionals, and the mode of those that are modal coordinates.
fn functionals(rig: &Rig, setting: &Setting) -> (Vec<Dof>, Vec<Option<usize>>) {
    let length = rig.beam.length;
    let contact = if rig.lever.is_some() { Dof::rotation(length) } else { Dof::displacement(length) };
    let mut dofs = vec![Dof::displacement(rig.exciter), contact, Dof::displacement(length)];
    dofs.extend(
        rig.sensors.iter().zip(&setting.sensors).map(|(x, s)| Dof::displacement(x + s.shift + setting.shift)),
    );
    let mut modal = vec![None; dofs.len()];
    for port in &setting.ports {
        let (dof, mode) = match port.place {
            PortPlace::At(position) => (Dof::displacement(position), None),
            PortPlace::Turn(position) => (Dof::rotation(position), None),
            PortPlace::Support => (Dof::displacement(length), None),
            PortPlace::Mode(mode) => (Dof::displacement(length), Some(mode)),
        };
        dofs.push(dof);
        modal.push(mode);
    }
    dofs.extend(rig.known_support.map(Dof::displacement));
    dofs.extend(setting.mass.map(|m| Dof::displacement(m[1])));
    modal.resize(dofs.len(), None);
    (dofs, modal)
}

fn scaled_residual(probe: &Probe, scale: &[f64], modal: &[Option<usize>]) -> Vec<f64> {
    let count = scale.len();
    (0..count * count)
        .map(|k| {
            let (i, j) = (k / count, k % count);
            if modal[i].is_some() || modal[j].is_some() {
                0.0
            } else {
                probe.residual()[k] * scale[i] * scale[j]
            }
        })
        .collect()
}

/// `∫ρA φ_n dx`.
fn rigid_participation(rig: &Rig, model: &ModalModel) -> Vec<f64> {
    model.shapes().iter().map(|shape| shape.integral() * rig.beam.mass_per_length).collect()
}

/// `H ← H − h_a Z/(1 + Z H_aa) h_aᵀ` for the attachment in the last row and column.
fn add_mass(wide: &mut [Complex64], columns: usize, stiffness: Complex64) {
    let width = columns + 1;
    let rows = wide.len() / width;
    let last = (rows - 1) * width;
    let gain = stiffness / (1.0 + stiffness * wide[last + columns]);
    for row in 0..rows - 1 {
        let factor = wide[row * width + columns] * gain;
        for column in 0..columns {
            let load = wide[last + column];
            wide[row * width + column] -= factor * load;
        }
    }
}
