use super::*;
use crate::beam::Boundary;
use crate::shape::mode_shapes;

const UNIT: UniformBeam = UniformBeam { length: 1.0, bending_stiffness: 1.0, mass_per_length: 1.0 };

/// Rigid enough to pin the end, soft enough for the eigenvalue iteration: shifts the modes by less than 1e-8.
const PIN: f64 = 1e11;

#[test]
fn error_of_the_frequencies_falls_with_the_fourth_power() {
    // Relative error of the clamped-pinned frequencies 1-5 with consistent mass, from an independent computation.
    let table: [(usize, [f64; 5]); 4] = [
        (4, [6.3e-4, 6.2e-3, 2.3e-2, 0.12, 0.20]),
        (8, [4.0e-5, 4.2e-4, 1.8e-3, 5.0e-3, 1.1e-2]),
        (16, [2.5e-6, 2.6e-5, 1.1e-4, 3.3e-4, 7.6e-4]),
        (32, [1.6e-7, 1.7e-6, 7.2e-6, 2.1e-5, 4.9e-5]),
    ];
    let exact = mode_shapes(&UNIT, &Boundary::pinned(), 5).unwrap();
    for (elements, errors) in table {
        let mut mesh = FiniteElements::clamped(&UNIT, elements).unwrap();
        mesh.add_spring(Dof::displacement(1.0), PIN);
        let found = mesh.eigenmodes().unwrap();
        for (n, error) in errors.into_iter().enumerate() {
            let relative = found.natural_frequency[n] / exact[n].natural_frequency() - 1.0;
            // The table has two digits (0.05 in 1.1 at worst); the rounding of the smallest entries is that of K's 1e11.
            assert!((relative - error).abs() < 0.05 * error + 2e-8, "{elements} {n}: {relative} {error}");
        }
    }
}

#[test]
fn modes_are_mass_normalised_and_equal_the_closed_form() {
    let mut mesh = FiniteElements::clamped(&UNIT, 40).unwrap();
    mesh.add_spring(Dof::displacement(1.0), 500.0);
    let found = mesh.eigenmodes().unwrap();
    let exact = mode_shapes(&UNIT, &Boundary::spring(500.0), 4).unwrap();
    for (n, shape) in exact.iter().enumerate() {
        let at = |dof: Dof| mesh.row(dof).iter().zip(0..).map(|(r, i)| r * found.modes[(i, n)]).sum::<f64>();
        let sign = at(Dof::displacement(0.05)).signum();
        for dof in [Dof::displacement(0.337), Dof::rotation(0.81), Dof::rotation(1.0)] {
            // Error of the shape with 40 elements: (b/40)⁴/100 ~ 1e-4 at mode 4.
            assert!((sign * at(dof) - shape.at(dof)).abs() < 3e-4 * shape.wavenumber(), "{n} {dof:?}");
        }
    }
}

#[test]
fn a_point_mass_on_a_light_beam_is_an_oscillator() {
    let light = UniformBeam { mass_per_length: 1e-4, ..UNIT };
    let mut mesh = FiniteElements::clamped(&light, 6).unwrap();
    mesh.add_mass(Dof::displacement(1.0), 2.0);
    let found = mesh.eigenmodes().unwrap();
    // Cantilever tip stiffness 3EI/L³, mass 2 and Rayleigh's share 33/140 of the beam's; the rest is of order 1e-9.
    let rayleigh = (3.0_f64 / (2.0 + 33.0 / 140.0 * 1e-4)).sqrt();
    assert!(
        (found.natural_frequency[0] - rayleigh).abs() < 1e-8,
        "{}",
        found.natural_frequency[0] - rayleigh
    );
    assert_eq!(mesh.index(0, Freedom::Rotation), None);
    assert_eq!(mesh.index(6, Freedom::Rotation), Some(11));
    assert_eq!(mesh.index(7, Freedom::Displacement), None);
}
