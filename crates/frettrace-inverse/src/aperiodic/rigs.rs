//! A rig of tests.

use crate::{ModeTrust, Rig, Sensor, Slip};
use frettrace_beam::{Boundary, ModalModel, ModalOptions, UniformBeam};

/// A clamped beam on a spring, with five sensors: so many modes of one damping ratio, the first of them measured.
pub(super) fn rig(modes: usize, damping: f64, measured: usize) -> Rig {
    let beam = UniformBeam::rectangular(0.7, [0.03, 0.006], 2.05e11, 7850.0);
    let options = ModalOptions { modes, damping_ratio: vec![damping], ..ModalOptions::default() };
    let sensor = |position| Sensor { position, noise_std: None };
    Rig {
        structure: ModalModel::new(&beam, &Boundary::spring(1e5), &options).unwrap(),
        trust: vec![ModeTrust { frequency: 1e-3, damping: 1e-2 }; measured],
        beam_modes: modes,
        slip: Slip::Rotation { lever_arm: 3e-3 },
        normal_stiffness: 1e5,
        second_support: None,
        exciter: 0.28,
        sensors: [0.11, 0.22, 0.33, 0.45, 0.56].map(sensor).into(),
    }
}
