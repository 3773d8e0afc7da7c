//! Receptances of a rig, line by line: from every load that acts to every motion that is wanted.

use crate::{Rig, Slip};
use frettrace_beam::{Dof, Freedom, ModalModel, ModeShape, mode_shapes};
use num_complex::Complex64;
use std::ops::Range;

/// A load on the beam.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Load {
    /// The excitation force (N).
    Exciter,
    /// The friction force (N); it resists positive slip.
    Friction,
    /// Deviation of the normal reaction from its linear spring (N), positive towards positive `w`.
    NormalDeviation,
    /// Transverse force of the second support on the beam (N).
    SecondSupport,
}

impl Load {
    /// All loads, in the order of the columns.
    pub const ALL: [Self; 4] = [Self::Exciter, Self::Friction, Self::NormalDeviation, Self::SecondSupport];

    fn column(self) -> usize {
        match self {
            Self::Exciter => 0,
            Self::Friction => 1,
            Self::NormalDeviation => 2,
            Self::SecondSupport => 3,
        }
    }
}

/// Columns of a table of flexibilities.
const COLUMNS: usize = 4;

/// Shapes and residual flexibilities between the loads and the outputs (sensors, slip, displacement of the end).
///
/// Frequencies and damping are read from the structure at evaluation, so one value serves a whole calibration.
#[derive(Clone, Debug)]
pub struct Dynamics {
    sensors: usize,
    columns: usize,
    modes: usize,
    /// Shapes at the outputs, one row of `S + 2` a mode.
    output: Vec<f64>,
    /// Shapes at the loads, one row of four a mode.
    input: Vec<f64>,
    /// Products of both for the loads that act: `S + 2` rows a mode, of a column each.
    products: Vec<f64>,
    /// Residual flexibility, `S + 2` rows of four.
    residual: Vec<f64>,
    /// Flexibility of the modes beyond those the beam theory holds for, `S + 2` rows of four.
    doubtful: Vec<f64>,
}

/// Receptances of one line.
#[derive(Clone, Debug, Default)]
pub struct LineReceptances {
    omega: f64,
    sensors: usize,
    /// Loads that act: the last column, of the second support, is left out where there is none.
    columns: usize,
    matrix: Vec<Complex64>,
}

/// What a structure makes of the lines of a run with the modes that no calibration moves.
#[derive(Clone, Debug, Default)]
pub(crate) struct FixedReceptances {
    /// Modes that are not in it.
    modes: usize,
    lines: Vec<LineReceptances>,
}

impl LineReceptances {
    /// Angular frequency (rad/s).
    #[must_use]
    pub fn omega(&self) -> f64 {
        self.omega
    }

    /// Accelerance from a load to a sensor (m/s² per N).
    #[must_use]
    pub fn acceleration(&self, sensor: usize, load: Load) -> Complex64 {
        self.of(sensor, load) * -(self.omega * self.omega)
    }

    /// Slip per load (m/N).
    #[must_use]
    pub fn slip(&self, load: Load) -> Complex64 {
        self.of(self.sensors, load)
    }

    /// Transverse displacement of the end per load (m/N).
    #[must_use]
    pub fn end(&self, load: Load) -> Complex64 {
        self.of(self.sensors + 1, load)
    }

    fn of(&self, output: usize, load: Load) -> Complex64 {
        let column = load.column();
        if column < self.columns { self.matrix[output * self.columns + column] } else { Complex64::ZERO }
    }
}

impl Dynamics {
    /// Shapes of the rig's structure at its points.
    #[must_use]
    pub fn new(rig: &Rig) -> Self {
        let end = rig.structure.beam().length;
        let (slip, lever) = match rig.slip {
            Slip::Rotation { lever_arm } => (Dof { position: end, freedom: Freedom::Rotation }, lever_arm),
            Slip::Transverse => (Dof { position: end, freedom: Freedom::Displacement }, 1.0),
        };
        let transverse = |position| (Dof { position, freedom: Freedom::Displacement }, 1.0);
        let mut outputs: Vec<(Dof, f64)> = rig.sensors.iter().map(|s| transverse(s.position)).collect();
        outputs.extend([(slip, lever), transverse(end)]);
        let second = rig.second_support.map_or((transverse(end).0, 0.0), transverse);
        let inputs = [transverse(rig.exciter), (slip, -lever), transverse(end), second];
        let model = &rig.structure;
        let at = |points: &[(Dof, f64)]| -> Vec<f64> {
            model.shapes().iter().flat_map(|shape| points.iter().map(|(dof, c)| c * shape.at(*dof))).collect()
        };
        let beyond = beyond(rig);
        let table = |flexibility: &dyn Fn(Dof, Dof) -> f64| -> Vec<f64> {
            let row = |(o, c): &(Dof, f64)| {
                inputs.iter().map(|(i, d)| c * d * flexibility(*o, *i)).collect::<Vec<_>>()
            };
            outputs.iter().flat_map(row).collect()
        };
        let residual = table(&|o, i| model.residual(o, i));
        let doubtful =
            table(&|o, i| model.residual(o, i) + beyond.iter().map(|b| b.between(o, i)).sum::<f64>());
        let columns = if rig.second_support.is_some() { COLUMNS } else { COLUMNS - 1 };
        let (output, input) = (at(&outputs), at(&inputs));
        let modes = output.chunks_exact(outputs.len()).zip(input.chunks_exact(COLUMNS));
        let products = modes
            .flat_map(|(output, input)| {
                output.iter().flat_map(move |o| input[..columns].iter().map(move |i| o * i))
            })
            .collect();
        Self {
            doubtful,
            sensors: rig.sensors.len(),
            columns,
            modes: model.mode_count(),
            output,
            input,
            products,
            residual,
        }
    }

    /// Flexibility (m/N) from a load to an output (sensors, slip, end) of the modes that the beam theory does not hold for.
    pub(crate) fn doubtful(&self, output: usize, load: Load) -> f64 {
        self.doubtful[output * COLUMNS + load.column()]
    }

    /// Number of sensors.
    #[must_use]
    pub fn sensors(&self) -> usize {
        self.sensors
    }

    /// Shape of a mode at a sensor.
    #[must_use]
    pub fn sensor_shape(&self, mode: usize, sensor: usize) -> f64 {
        self.output[mode * (self.sensors + 2) + sensor]
    }

    /// Shape of a mode at all sensors.
    pub(crate) fn sensor_shapes(&self, mode: usize) -> &[f64] {
        &self.output[mode * (self.sensors + 2)..][..self.sensors]
    }

    /// Shape of a mode at the slip, and at the end.
    #[must_use]
    pub fn contact_shape(&self, mode: usize) -> [f64; 2] {
        let row = &self.output[mode * (self.sensors + 2)..(mode + 1) * (self.sensors + 2)];
        [row[self.sensors], row[self.sensors + 1]]
    }

    /// Generalised force of a mode per unit load.
    #[must_use]
    pub fn load_shape(&self, mode: usize, load: Load) -> f64 {
        self.input[mode * COLUMNS + load.column()]
    }

    /// Fills `line` with the receptances at `omega` (rad/s).
    pub fn fill(&self, structure: &ModalModel, omega: f64, line: &mut LineReceptances) {
        self.start(omega, line);
        self.add_modes(structure, 0..self.modes, line);
    }

    /// The residual flexibility.
    fn start(&self, omega: f64, line: &mut LineReceptances) {
        (line.omega, line.sensors, line.columns) = (omega, self.sensors, self.columns);
        line.matrix.clear();
        line.matrix.reserve((self.sensors + 2) * self.columns);
        let rows = self.residual.chunks_exact(COLUMNS);
        line.matrix.extend(rows.flat_map(|row| row[..self.columns].iter().map(|r| Complex64::from(*r))));
    }

    /// Adds modes to the receptances of a line, as many rows as it has.
    fn add_modes(&self, structure: &ModalModel, modes: Range<usize>, line: &mut LineReceptances) {
        let count = (self.sensors + 2) * self.columns;
        for mode in modes {
            let gain = structure.modal_receptance(mode, line.omega);
            let products = &self.products[mode * count..(mode + 1) * count];
            line.matrix.iter_mut().zip(products).for_each(|(entry, product)| *entry += gain * *product);
        }
    }

    /// What the modes from `modes` on, which stay as they are, make of the lines `1..=order` of a base frequency (rad/s).
    pub(crate) fn fixed(
        &self,
        structure: &ModalModel,
        modes: usize,
        (base, order): (f64, usize),
    ) -> FixedReceptances {
        let line = |h: usize| {
            let mut line = LineReceptances::default();
            self.start(base * h as f64, &mut line);
            self.add_modes(structure, modes..self.modes, &mut line);
            line
        };
        FixedReceptances { modes, lines: (1..=order).map(line).collect() }
    }

    /// Fills `line` with the receptances of line `h ≥ 1` upon those that stay as they are.
    pub(crate) fn fill_upon(
        &self,
        structure: &ModalModel,
        fixed: &FixedReceptances,
        h: usize,
        line: &mut LineReceptances,
    ) {
        self.fill_rows(structure, fixed, (h, self.sensors + 2), line);
    }

    /// The same for the sensors alone: slip and end are not in it.
    pub(crate) fn fill_sensors_upon(
        &self,
        structure: &ModalModel,
        fixed: &FixedReceptances,
        h: usize,
        line: &mut LineReceptances,
    ) {
        self.fill_rows(structure, fixed, (h, self.sensors), line);
    }

    fn fill_rows(
        &self,
        structure: &ModalModel,
        fixed: &FixedReceptances,
        (h, rows): (usize, usize),
        line: &mut LineReceptances,
    ) {
        let start = &fixed.lines[h - 1];
        (line.omega, line.sensors, line.columns) = (start.omega, start.sensors, start.columns);
        line.matrix.clear();
        line.matrix.extend_from_slice(&start.matrix[..rows * start.columns]);
        self.add_modes(structure, 0..fixed.modes, line);
    }
}

/// A mode between the last one summed and the last one that the beam theory holds for; its flexibility counts against the
/// residual, or for it where more modes are summed than the theory holds for.
struct Between {
    shape: ModeShape,
    sign: f64,
}

impl Between {
    fn between(&self, output: Dof, input: Dof) -> f64 {
        self.sign * self.shape.at(output) * self.shape.at(input) / self.shape.natural_frequency().powi(2)
    }
}

fn beyond(rig: &Rig) -> Vec<Between> {
    let (summed, held) = (rig.structure.mode_count(), rig.beam_modes);
    let sign = if held > summed { -1.0 } else { 1.0 };
    // The shapes exist for as many modes as were summed; where those beyond cannot be computed nothing is taken off.
    let shapes = mode_shapes(rig.structure.beam(), rig.structure.boundary(), held.max(summed));
    let first = summed.min(held);
    let count = held.max(summed) - first;
    shapes
        .unwrap_or_default()
        .into_iter()
        .skip(first)
        .take(count)
        .map(|shape| Between { shape, sign })
        .collect()
}
