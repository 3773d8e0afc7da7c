//! Wedge damper: two coupled inclined interfaces, their equivalent stiffness and damping, and a blade's forced response.
//! An argument names a figure (SVG).

#![expect(clippy::print_stdout, reason = "an example prints")]

use frettrace::report::chart::{Chart, Curve, Ink, Role};
use frettrace_beam::{Boundary, Dof, ModalModel, ModalOptions, UniformBeam};
use frettrace_forward::hb::{
    Contact, Load, Network, Normal, Reading, Settings, Solver, Sweep, SweepStatus, WedgeDamper,
};
use frettrace_forward::march::{Port, Structure};
use std::f64::consts::TAU;

fn main() -> anyhow::Result<()> {
    // Parameters: a steel blade of 0.25 m; wedges of 40° pressed with 60 N, neighbours moving out of phase.
    let damper = WedgeDamper {
        angle: 40.0_f64.to_radians(),
        centrifugal_force: 60.0,
        normal_stiffness: 6e5,
        tangential_stiffness: 4e5,
        friction_coefficient: 0.35,
        neighbour: -1.0,
    };
    let blade = UniformBeam::rectangular(0.25, [0.04, 0.006], 2.0e11, 7850.0);

    // The loop: it sticks, slips one way, slips the other; first harmonic over a cycle of amplitude A.
    // ANCHOR: loop
    let closed = damper.opposed();
    let [low, high] = closed.limits;
    println!("sticks with {:.4e} N/m, slips at {low:.3} N and {high:.3} N", closed.stiffness);
    for amplitude in [2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3] {
        let [stiffness, loss] = closed.equivalent(amplitude);
        println!("{:5.0} um: {stiffness:.3e} N/m, loss {loss:.3e} N/m", 1e6 * amplitude);
    }
    // ANCHOR_END: loop

    // Problem: excited at its tip, its platform at a fifth of its length.
    let options = ModalOptions { modes: 12, damping_ratio: vec![0.002], ..ModalOptions::default() };
    let model = ModalModel::new(&blade, &Boundary::spring(0.0), &options)?;
    let port = |x| Port { dof: Dof::displacement(x), factor: 1.0 };
    let structure = Structure::from_beam(&model, &[port(0.05), port(0.25)])?;
    let mut network = Network::new(structure, vec![Reading::motion(0), Reading::motion(1)], vec![0]);
    network.loads.push(Load { port: 1, harmonic: 1, amplitude: 1.0.into() });
    let contact =
        Contact { slip: 0, normal: Normal::Constant(0.0), force: 0, normal_force: None, element: &damper };

    // Solve: the response at each force, by harmonic balance and continuation; look at its resonance. From 1 to 2 N the loop's
    // mean shakes down within the first cycle: the continuation, whose slopes know one cycle only, would stall there.
    let mut responses = Vec::new();
    for force in [0.5, 0.7, 3.0, 5.0, 10.0, 20.0] {
        let settings = Settings { order: 9, samples: 256, tolerance: 1e-7, iterations: 40 };
        let sweep = Sweep { range: [TAU * 70.0, TAU * 130.0], level: force, ..Sweep::default() };
        let curve = Solver::new(settings)?.follow(&network, &[contact], &sweep)?;
        anyhow::ensure!(curve.status == SweepStatus::Finished, "{force} N: {:?}", curve.status);
        let (mut frequency, mut tip) = (Vec::new(), Vec::new());
        for point in &curve.points {
            let motion = network.lines(point.omega, 9, force)?.motion(1, &point.forces);
            frequency.push(point.omega / TAU);
            tip.push(motion[1].norm() / force);
        }
        let (at, largest) = frequency
            .iter()
            .zip(&tip)
            .fold((0.0, 0.0), |most, (f, x)| if *x > most.1 { (*f, *x) } else { most });
        println!("{force:4.1} N: resonance {at:5.1} Hz, tip {:6.0} um/N", 1e6 * largest);
        responses.push((format!("{force} N"), frequency, tip));
    }
    if let Some(path) = std::env::args().nth(1) {
        let curves = responses.iter().enumerate();
        let chart = Chart {
            title: "Blade with wedge dampers",
            x_label: "excitation frequency [Hz]",
            y_label: "tip / force [m/N]",
            logarithmic: true,
            curves: curves.map(|(n, (name, x, y))| Curve::line(name, Role::Number(n), x, y)).collect(),
        };
        std::fs::write(path, chart.picture(Ink::File).svg)?;
    }
    Ok(())
}
