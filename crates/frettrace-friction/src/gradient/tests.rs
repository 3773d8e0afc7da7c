//! Against `num_dual::DualSVec64`, function by function.

use num_dual::{DualNum, DualSVec64};

use super::Gradient;

/// Every function, on numbers inside its domain: x in (0, 1), y around 1.5.
fn functions<D: DualNum<Primitive = f64> + Copy>(x: D, y: D) -> Vec<D> {
    let above = y + 0.5;
    let mut grown = x;
    grown += y;
    grown *= 2.0;
    grown -= x * y;
    grown /= above;
    vec![
        x + y,
        x - y,
        x * y,
        x / y,
        -x,
        x + 2.0,
        x - 2.0,
        x * 3.0,
        x / 3.0,
        grown,
        x.recip(),
        x.powi(3),
        x.powi(0),
        x.powf(2.3),
        x.powd(y),
        x.sqrt(),
        x.cbrt(),
        x.exp(),
        x.exp2(),
        x.exp_m1(),
        x.ln(),
        x.log(3.0),
        x.log2(),
        x.log10(),
        x.ln_1p(),
    ]
}

/// The circular and hyperbolic functions, sums and products.
fn more_functions<D: DualNum<Primitive = f64> + Copy>(x: D, y: D) -> Vec<D> {
    let (sine, cosine) = x.sin_cos();
    vec![
        x.sin(),
        x.cos(),
        x.tan(),
        sine,
        cosine,
        x.asin(),
        x.acos(),
        x.atan(),
        x.atan2(y),
        x.sinh(),
        x.cosh(),
        x.tanh(),
        x.asinh(),
        y.acosh(),
        x.atanh(),
        x.sph_j0(),
        x.sph_j1(),
        x.sph_j2(),
        (-x).abs(),
        x.signum(),
        x.mul_add(y, x),
        x.inv(),
        x.scale(&y_inner::<D>()),
        [x, y, x].into_iter().sum(),
        [x, y, x].into_iter().product(),
    ]
}

fn y_inner<D: DualNum<Primitive = f64>>() -> D::InnerDual {
    num_traits::FromPrimitive::from_f64(1.7).unwrap_or_else(num_traits::Zero::zero)
}

#[test]
fn every_function_agrees_with_the_reference() {
    let (x, y) = (DualSVec64::<2>::from_re(0.37).derivative(0), DualSVec64::<2>::from_re(1.52).derivative(1));
    let reference = [functions(x, y), more_functions(x, y)].concat();
    let (x, y) = (Gradient::<2>::variable(0.37, 0), Gradient::<2>::variable(1.52, 1));
    let ours = [functions(x, y), more_functions(x, y)].concat();
    for (index, (ours, reference)) in ours.iter().zip(&reference).enumerate() {
        // Two ways of rounding the same formula.
        assert!((ours.re - reference.re).abs() < 1e-14, "{index}: {ours} {reference}");
        for direction in 0..2 {
            let expected = reference.eps.0.map_or(0.0, |slopes| slopes[direction]);
            let close = (ours.slopes[direction] - expected).abs() < 1e-12;
            assert!(close, "{index}: {ours} {reference}");
        }
    }
}

#[test]
fn comparisons_look_at_the_value() {
    let (x, y) = (Gradient::<1>::variable(1.0, 0), Gradient::<1>::constant(1.0));
    assert!(x == y && x < 2.0 && x <= y && x == 1.0);
}
