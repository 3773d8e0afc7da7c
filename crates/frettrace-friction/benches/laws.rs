//! What does a sample cost? One closed period of 1024 samples for every law of the catalogue, in plain numbers and
//! with derivatives to motion and parameters, by [`Gradient`] and by `DualSVec64`.

use divan::counter::ItemsCount;
use frettrace_friction::{FrictionLaw, FrictionModel, Gradient, Law, Period, Scalar, Visitor};
use num_dual::DualSVec64;

const SAMPLES: usize = 1024;

fn main() {
    divan::main();
}

/// Slip of amplitude 1e-5 m with a third harmonic, at 20 Hz, under a normal force that varies by a third.
fn motion(index: usize) -> [f64; 3] {
    let omega = 2.0 * std::f64::consts::PI * 20.0;
    let phase = 2.0 * std::f64::consts::PI * index as f64 / SAMPLES as f64;
    let slip = 1e-5 * (phase.sin() + 0.2 * (3.0 * phase).cos());
    let velocity = 1e-5 * omega * (phase.cos() - 0.6 * (3.0 * phase).sin());
    [slip, velocity, 100.0 + 30.0 * phase.cos()]
}

struct March<'a, T> {
    period: Period<'a, T>,
    force: &'a mut [T],
}

impl<T: Scalar> Visitor<T> for March<'_, T> {
    type Output = f64;

    fn visit<L: FrictionLaw<T>>(self, law: &L) -> f64 {
        self.period
            .march(law, law.rest(), self.force)
            .map_or(f64::NAN, |state| state.as_ref().iter().map(|value| value.re()).sum::<f64>())
    }
}

fn bench<T: Scalar>(bencher: divan::Bencher, law: Law, seed: impl Fn(f64, usize) -> T) {
    let columns: [Vec<T>; 3] =
        std::array::from_fn(|k| (0..SAMPLES).map(|index| seed(motion(index)[k], k)).collect());
    let values: Vec<T> = law.example().iter().enumerate().map(|(k, value)| seed(*value, k + 3)).collect();
    let Ok(model): Result<FrictionModel<T>, _> = law.with_values(&values) else { return };
    let mut force = vec![T::from(0.0); SAMPLES];
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let period = Period {
            slip: &columns[0],
            velocity: &columns[1],
            normal: &columns[2],
            dt: 0.05 / SAMPLES as f64,
        };
        model.visit(March { period, force: &mut force })
    });
}

#[divan::bench(args = Law::ALL)]
fn plain(bencher: divan::Bencher, law: &Law) {
    bench(bencher, *law, |value, _| value);
}

#[divan::bench(args = Law::ALL)]
fn gradient_8(bencher: divan::Bencher, law: &Law) {
    bench(bencher, *law, |value, k| Gradient::<8>::variable(value, k % 8));
}

#[divan::bench(args = Law::ALL)]
fn gradient_16(bencher: divan::Bencher, law: &Law) {
    bench(bencher, *law, |value, k| Gradient::<16>::variable(value, k % 16));
}

#[divan::bench(args = [Law::Dahl, Law::Lugre, Law::Hybrid])]
fn dual_svec_16(bencher: divan::Bencher, law: &Law) {
    bench(bencher, *law, |value, k| DualSVec64::<16>::from_re(value).derivative(k % 16));
}
