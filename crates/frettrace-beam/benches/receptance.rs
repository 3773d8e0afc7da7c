//! What a receptance costs: a probe's matrix at one frequency, one closed-form value, a new model for a calibration step.

use frettrace_beam::{Boundary, Dof, ExactBeam, ModalModel, ModalOptions, Receptance, UniformBeam};
use num_complex::Complex64;

fn main() {
    divan::main();
}

fn beam() -> (UniformBeam, Boundary) {
    (UniformBeam::rectangular(0.5, [0.03, 0.0075], 2.0e11, 7850.0), Boundary::spring(5e6))
}

fn dofs() -> Vec<Dof> {
    let sensors = [0.08, 0.14, 0.21, 0.3, 0.37, 0.44].map(Dof::displacement);
    sensors.into_iter().chain([Dof::displacement(0.23), Dof::rotation(0.5), Dof::displacement(0.5)]).collect()
}

#[divan::bench]
fn probe_of_nine(bencher: divan::Bencher) {
    let (beam, boundary) = beam();
    let Ok(model) = ModalModel::new(&beam, &boundary, &ModalOptions::default()) else { return };
    let probe = model.probe(&dofs());
    let mut matrix = vec![Complex64::ZERO; 81];
    bencher.bench_local(|| probe.receptances(&model, divan::black_box(653.0), &mut matrix));
}

#[divan::bench]
fn closed_form(bencher: divan::Bencher) {
    let (beam, boundary) = beam();
    let Ok(exact) = ExactBeam::new(&beam, &boundary, 0.01) else { return };
    bencher.bench(|| exact.receptance(Dof::displacement(0.3), Dof::rotation(0.5), divan::black_box(653.0)));
}

#[divan::bench]
fn new_model(bencher: divan::Bencher) {
    let (beam, boundary) = beam();
    bencher.bench(|| ModalModel::new(&beam, divan::black_box(&boundary), &ModalOptions::default()));
}
