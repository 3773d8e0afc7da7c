use super::*;
use crate::exact::ExactBeam;

const UNIT: UniformBeam = UniformBeam { length: 1.0, bending_stiffness: 1.0, mass_per_length: 1.0 };

fn measured() -> ModalModel {
    let options = ModalOptions {
        natural_frequency: vec![15.3, 50.2, 104.0],
        damping_ratio: vec![0.004, 0.006, 0.005],
        ..ModalOptions::default()
    };
    ModalModel::new(&UNIT, &Boundary::spring(500.0), &options).unwrap()
}

#[test]
fn share_of_the_static_compliance_captured_by_n_modes() {
    // Independent computation: share of L/(4EI) at the pinned end.
    for (modes, share) in
        [(1, 0.549), (2, 0.708), (3, 0.785), (5, 0.859), (10, 0.925), (20, 0.961), (50, 0.984)]
    {
        let model =
            ModalModel::new(&UNIT, &Boundary::pinned(), &ModalOptions { modes, ..ModalOptions::default() })
                .unwrap();
        let end = Dof::rotation(1.0);
        let captured = 1.0 - model.residual(end, end) / 0.25;
        // The table has three digits.
        assert!((captured - share).abs() < 6e-4, "{modes}: {captured}");
    }
}

#[test]
fn modal_sum_with_residual_meets_the_closed_form() {
    let exact = ExactBeam::new(&UNIT, &Boundary::pinned(), 0.0).unwrap();
    let model = ModalModel::new(&UNIT, &Boundary::pinned(), &ModalOptions::default()).unwrap();
    let dofs = [Dof::displacement(0.4), Dof::rotation(1.0), Dof::rotation(0.25)];
    for omega in [4.0, 15.0, 40.0, 200.0, 900.0] {
        for output in dofs {
            for input in dofs {
                let (a, b) = (model.receptance(output, input, omega), exact.receptance(output, input, omega));
                // Left out: Σ_{n>100} φφω²/ω_n⁴ ≤ ω² Σ 2b²/b⁸ ~ ω² 4e-14 for two rotations at ω = 900: 3e-8.
                assert!(
                    (a - b).norm() < 1e-13 + 1e-13 * omega * omega,
                    "{output:?} {input:?} {omega}: {a} {b}"
                );
            }
        }
    }
}

#[test]
fn a_probe_equals_the_plain_sum_and_is_reciprocal() {
    let model = measured();
    let dofs = [Dof::displacement(0.3), Dof::displacement(0.71), Dof::rotation(1.0)];
    let probe = model.probe(&dofs);
    let mut matrix = vec![Complex64::ZERO; 9];
    for (k, residual) in probe.residual().iter().enumerate() {
        assert!((residual - model.residual(dofs[k / 3], dofs[k % 3])).abs() < 1e-15);
    }
    for omega in [3.0, 15.29, 77.0, 310.0] {
        probe.receptances(&model, omega, &mut matrix);
        for (i, &output) in dofs.iter().enumerate() {
            for (j, &input) in dofs.iter().enumerate() {
                let plain = model.receptance(output, input, omega);
                assert!((matrix[3 * i + j] - plain).norm() < 1e-13 * plain.norm().max(1e-3));
                assert!((matrix[3 * i + j] - matrix[3 * j + i]).norm() < 1e-15);
            }
        }
    }
}

#[test]
fn gradients_are_central_differences() {
    let model = measured();
    let dofs = [Dof::displacement(0.3), Dof::rotation(1.0)];
    let probe = model.probe(&dofs);
    let omega = 15.1;
    let mut gradient = [vec![Complex64::ZERO; 4], vec![Complex64::ZERO; 4]];
    let [first, second] = &mut gradient;
    probe.gradient(&model, 0, omega, [first, second]);
    for (which, step) in [(0, 1e-5), (1, 1e-6)] {
        let at = |sign: f64| {
            let mut shifted = model.clone();
            let delta = |index| if index == which { sign * step } else { 0.0 };
            shifted.set_mode(0, 15.3 + delta(0), 0.004 + delta(1));
            let mut matrix = vec![Complex64::ZERO; 4];
            probe.receptances(&shifted, omega, &mut matrix);
            matrix
        };
        for ((plus, minus), analytic) in at(1.0).iter().zip(at(-1.0)).zip(&gradient[which]) {
            let numeric = (plus - minus) / (2.0 * step);
            // Curvature of the resonance: (step/width)² with a half-width of 0.06 rad/s.
            assert!((numeric - analytic).norm() < 1e-6 * analytic.norm(), "{which}: {numeric} {analytic}");
        }
    }
}

#[test]
fn a_measured_frequency_moves_its_own_share_of_the_flexibility_only() {
    let declared = ModalModel::new(&UNIT, &Boundary::spring(500.0), &ModalOptions::default()).unwrap();
    let model = measured();
    let end = Dof::rotation(1.0);
    assert!((declared.residual(end, end) - model.residual(end, end)).abs() < 1e-15);
    let difference = (model.receptance(end, end, 0.0) - declared.receptance(end, end, 0.0)).re;
    let share: f64 = (0..3)
        .map(|n| {
            let slope = model.shapes()[n].at(end);
            slope * slope * (model.natural_frequency()[n].powi(-2) - declared.natural_frequency()[n].powi(-2))
        })
        .sum();
    assert!((difference - share).abs() < 1e-14);
    assert_eq!(model.damping_ratio()[50], 0.005);
}

#[test]
fn other_measured_values_on_known_shapes_are_those_of_a_new_model() {
    let boundary = Boundary::spring(500.0);
    let declared = ModalModel::new(&UNIT, &boundary, &ModalOptions::default()).unwrap();
    let model = measured();
    assert_eq!(declared.with_measured(&[15.3, 50.2, 104.0], &[0.004, 0.006, 0.005]), Ok(model));
    let refused = declared.with_measured(&[15.3], &[1.5]).unwrap_err();
    assert!(matches!(refused, BeamError::OutOfRange { quantity: "damping ratio", .. }), "{refused}");
}

#[test]
fn too_many_measured_modes_are_refused() {
    let options = ModalOptions { modes: 2, natural_frequency: vec![1.0; 3], ..ModalOptions::default() };
    let refused = ModalModel::new(&UNIT, &Boundary::pinned(), &options);
    assert_eq!(refused.unwrap_err(), BeamError::TooManyMeasured { given: 3, held: 2 });
}
