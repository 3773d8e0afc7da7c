//! The projector against dense least squares on the columns as they stand in the definition.

use super::*;

fn record(n: usize) -> Vec<f64> {
    (0..n)
        .map(|j| ((j * j) as f64 * 0.0137).sin() + 0.4 * (j as f64 * 0.11).cos() + 1e-3 * j as f64)
        .collect()
}

fn oracle(x: &[f64], lines: &Lines) -> Vec<f64> {
    let theta = lines.base / lines.sampling_rate;
    let n = lines.samples;
    let columns = Mat::from_fn(n, 2 * lines.order + 1 + lines.drift, |j, i| match i {
        i if i <= lines.order => (theta * (i * j) as f64).cos(),
        i if i <= 2 * lines.order => (theta * ((i - lines.order) * j) as f64).sin(),
        _ => 2.0 * j as f64 / (n - 1) as f64 - 1.0,
    });
    let solved = faer::prelude::SolveLstsq::solve_lstsq(&columns.qr(), Mat::from_fn(n, 1, |j, _| x[j]));
    (0..solved.nrows()).map(|i| solved[(i, 0)]).collect()
}

/// Records of no integer number of periods, with and without drift. The condition number is below 10, so both
/// solutions agree to some hundred times the rounding of values of size one.
#[test]
fn agrees_with_dense_least_squares() {
    for (base, drift) in [(61.3, 0), (61.3, 1), (40.1, 1)] {
        let lines = Lines { base, order: 7, samples: 413, sampling_rate: 200.0, drift };
        let x = record(lines.samples);
        let found = Projector::new(lines).unwrap().project(&x).unwrap();
        let expected = oracle(&x, &lines);
        for (h, value) in found.harmonics.coefficients.iter().enumerate() {
            let sine = if h == 0 { 0.0 } else { expected[7 + h] };
            assert!((value - Complex64::new(expected[h], -sine)).norm() < 1e-11, "line {h}");
        }
        if drift == 1 {
            assert!((found.drift[0] - expected[15]).abs() < 1e-11);
        }
    }
}

/// A record that is made of lines and a straight line leaves nothing.
#[test]
fn lines_and_drift_are_recovered_exactly() {
    let lines = Lines { base: 33.7, order: 3, samples: 500, sampling_rate: 256.0, drift: 1 };
    let given = Harmonics::exact(
        33.7,
        vec![
            Complex64::new(2.0, 0.0),
            Complex64::new(1.0, -0.5),
            Complex64::new(0.1, 0.2),
            Complex64::new(0.0, 3.0),
        ],
    );
    let mut x = given.sample(256.0, 500);
    x.iter_mut().enumerate().for_each(|(j, v)| *v += 0.7 * (2.0 * j as f64 / 499.0 - 1.0));
    let found = Projector::new(lines).unwrap().project(&x).unwrap();
    for (a, b) in found.harmonics.coefficients.iter().zip(&given.coefficients) {
        assert!((a - b).norm() < 1e-12);
    }
    assert!((found.drift[0] - 0.7).abs() < 1e-12);
    assert!(found.residual_std < 1e-12);
}

/// The stated variance is that of white noise of known variance: E|ε|² = 4σ²/n for long records. 200 repeats of 12
/// lines give the mean of 2400 squared errors, so 10 % is five standard deviations of it.
#[test]
fn variance_is_that_of_the_errors() {
    use rand::SeedableRng;
    use rand_distr::Distribution;
    let lines = Lines { base: 50.0, order: 12, samples: 1024, sampling_rate: 512.0, drift: 0 };
    let projector = Projector::new(lines).unwrap();
    let mut random = rand_pcg::Pcg64::seed_from_u64(3);
    let normal = rand_distr::Normal::new(0.0, 0.3).unwrap();
    let (mut errors, mut stated) = (0.0, 0.0);
    for _ in 0..200 {
        let x: Vec<f64> = (0..1024).map(|_| normal.sample(&mut random)).collect();
        let found = projector.project(&x).unwrap().harmonics;
        errors += found.coefficients[1..].iter().map(Complex64::norm_sqr).sum::<f64>();
        stated += found.variance[1..].iter().sum::<f64>();
    }
    assert!((errors / stated - 1.0).abs() < 0.1, "{}", errors / stated);
    assert!((stated / (200.0 * 12.0) / (4.0 * 0.09 / 1024.0) - 1.0).abs() < 0.05);
}

#[test]
fn what_cannot_be_resolved_is_refused() {
    let lines = Lines { base: 1.0, order: 4, samples: 100, sampling_rate: 100.0, drift: 0 };
    assert!(matches!(Projector::new(lines).err(), Some(ProjectionError::Unresolved { .. })));
    let short = Lines { base: 60.0, order: 50, samples: 100, sampling_rate: 1000.0, drift: 0 };
    assert!(matches!(Projector::new(short).err(), Some(ProjectionError::TooShort { .. })));
    let lines = Lines { base: 60.0, order: 2, samples: 100, sampling_rate: 100.0, drift: 0 };
    let projector = Projector::new(lines).unwrap();
    assert!(matches!(projector.project(&[0.0; 7]).err(), Some(ProjectionError::Length { .. })));
}
