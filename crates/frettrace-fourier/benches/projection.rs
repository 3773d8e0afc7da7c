//! Cost of projecting one channel of 4096 samples on its lines, and of the factorisation that all channels share.

use frettrace_fourier::{Lines, Projector};

fn main() {
    divan::main();
}

fn lines(order: usize) -> Lines {
    Lines { base: 311.0, order, samples: 4096, sampling_rate: 8192.0, drift: 1 }
}

#[divan::bench(args = [20, 80])]
fn factor(bencher: divan::Bencher<'_, '_>, order: usize) {
    bencher.bench(|| Projector::new(lines(order)));
}

#[divan::bench(args = [20, 80])]
fn project(bencher: divan::Bencher<'_, '_>, order: usize) {
    let signal: Vec<f64> = (0..4096).map(|j| (0.038 * f64::from(j)).sin()).collect();
    let Ok(projector) = Projector::new(lines(order)) else { return };
    bencher.bench(|| projector.project(&signal));
}
