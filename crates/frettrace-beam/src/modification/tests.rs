use super::*;
use crate::beam::{Boundary, UniformBeam};
use crate::exact::ExactBeam;

const UNIT: UniformBeam = UniformBeam { length: 1.0, bending_stiffness: 1.0, mass_per_length: 1.0 };

fn beam(boundary: &Boundary) -> ExactBeam {
    ExactBeam::new(&UNIT, boundary, 0.02).unwrap()
}

fn with(element: Element, dof: Dof) -> Modified<ExactBeam> {
    Modified { base: beam(&Boundary::spring(300.0)), attachments: vec![Attachment { dof, element }] }
}

#[test]
fn an_end_spring_equals_the_boundary_with_it() {
    let direct = beam(&Boundary { support_rotational_stiffness: 5.0, ..Boundary::spring(700.0) });
    let modified = Modified {
        base: beam(&Boundary::cantilever()),
        attachments: vec![
            Attachment { dof: Dof::displacement(1.0), element: Element::Spring(700.0) },
            Attachment { dof: Dof::rotation(1.0), element: Element::Spring(5.0) },
        ],
    };
    for omega in [2.0, 17.0, 333.0] {
        for pair in
            [[Dof::displacement(0.4), Dof::rotation(1.0)], [Dof::displacement(1.0), Dof::displacement(0.2)]]
        {
            let (a, b) =
                (direct.receptance(pair[0], pair[1], omega), modified.receptance(pair[0], pair[1], omega));
            assert!((a - b).norm() < 1e-11 * a.norm(), "{omega}: {a} {b}");
        }
    }
}

#[test]
fn the_matrix_update_keeps_every_entry() {
    let base = beam(&Boundary::pinned());
    let attachment = Attachment { dof: Dof::displacement(0.6), element: Element::Mass(0.3) };
    let modified = Modified { base, attachments: vec![attachment] };
    let dofs = [Dof::rotation(1.0), attachment.dof, Dof::displacement(0.3)];
    let omega = 23.0;
    let mut matrix: Vec<Complex64> =
        dofs.iter().flat_map(|&o| dofs.iter().map(move |&i| base.receptance(o, i, omega))).collect();
    attachment.attach(&mut matrix, 3, 1, omega);
    for (i, &output) in dofs.iter().enumerate() {
        for (j, &input) in dofs.iter().enumerate() {
            let expected = modified.receptance(output, input, omega);
            assert!((matrix[3 * i + j] - expected).norm() < 1e-13 * expected.norm(), "{i} {j}");
        }
    }
}

#[test]
fn derivatives_are_central_differences() {
    let pair = [Dof::displacement(0.35), Dof::rotation(1.0)];
    let omega = 21.0;
    let place = Dof::displacement(0.62);
    for (element, shifted) in [
        (Element::Mass(0.2), (|p| Element::Mass(p)) as fn(f64) -> Element),
        (Element::Spring(0.2), |p| Element::Spring(p)),
        (Element::Dashpot(0.2), |p| Element::Dashpot(p)),
    ] {
        let modified = with(element, place);
        let at = |p: f64| with(shifted(p), place).receptance(pair[0], pair[1], omega);
        let numeric = (at(0.2 + 1e-4) - at(0.2 - 1e-4)) / 2e-4;
        let analytic = modified.value_derivative(0, pair, omega);
        // Second-order differences with a step of 1e-4 of a well-scaled quantity.
        assert!((numeric - analytic).norm() < 1e-5 * analytic.norm(), "{element:?}: {numeric} {analytic}");
        let moved = |x: f64| with(element, Dof::displacement(x)).receptance(pair[0], pair[1], omega);
        let numeric = (moved(0.62 + 1e-4) - moved(0.62 - 1e-4)) / 2e-4;
        let analytic = modified.position_derivative(0, pair, omega).unwrap();
        assert!((numeric - analytic).norm() < 1e-5 * analytic.norm(), "{element:?}: {numeric} {analytic}");
    }
    assert!(with(Element::Spring(1.0), Dof::rotation(0.5)).position_derivative(0, pair, omega).is_none());
}
