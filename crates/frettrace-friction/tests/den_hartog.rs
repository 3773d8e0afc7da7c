//! One degree of freedom with Coulomb friction under a harmonic force (Den Hartog 1931).
//!
//! `ẍ + 2 ζ ẋ + x + F_t = cos r t` with F_t in the set of [`Coulomb::bounds`]; lengths in P/k, time in 1/ω_n, β = F_c/P.

use std::f64::consts::PI;

use frettrace_friction::laws::Coulomb;

/// Amplitude without stops: V, U, H of the closed form with damping.
fn closed_form(r: f64, zeta: f64, beta: f64) -> f64 {
    let s = (1.0 - zeta * zeta).sqrt();
    let d = (zeta * PI / r).cosh() + (s * PI / r).cos();
    let g = ((zeta * PI / r).sinh() - zeta / s * (s * PI / r).sin()) / d;
    let h = (s * PI / r).sin() / (r * s * d);
    let linear = 1.0 / ((1.0 - r * r).powi(2) + (2.0 * zeta * r).powi(2));
    -g * beta + (linear - (h * beta).powi(2)).sqrt()
}

/// Linear motion between events from (t0, x0, v0) under a constant friction force.
#[derive(Clone, Copy)]
struct Slip {
    r: f64,
    zeta: f64,
    friction: f64,
    start: f64,
    free: [f64; 2],
}

impl Slip {
    fn new((r, zeta): (f64, f64), friction: f64, start: f64, [x, v]: [f64; 2]) -> Self {
        let mut slip = Slip { r, zeta, friction, start, free: [0.0; 2] };
        let [forced, speed] = slip.at(start);
        let s = (1.0 - zeta * zeta).sqrt();
        slip.free = [x - forced, (v - speed + zeta * (x - forced)) / s];
        slip
    }

    fn at(&self, t: f64) -> [f64; 2] {
        let Slip { r, zeta, .. } = *self;
        let (a, b) = (1.0 - r * r, 2.0 * zeta * r);
        let (norm, sine, cosine) = (a * a + b * b, (r * t).sin(), (r * t).cos());
        let (x, v) = ((a * cosine + b * sine) / norm, r * (b * cosine - a * sine) / norm);
        let s = (1.0 - zeta * zeta).sqrt();
        let (age, [p, q]) = (t - self.start, self.free);
        let (decay, c, d) = ((-zeta * age).exp(), (s * age).cos(), (s * age).sin());
        let free = decay * (p * c + q * d);
        let speed = decay * s * (q * c - p * d) - zeta * free;
        [x + free - self.friction, v + speed]
    }
}

/// First root of `f` after `start`, found in strides and halved to rounding; `None` up to `end`.
fn first_root(f: impl Fn(f64) -> f64, start: f64, end: f64) -> Option<f64> {
    let stride = 1e-2;
    let mut low = start + 1e-9;
    let sign = f(low).signum();
    while low < end {
        let mut high = low + stride;
        if f(high).signum() != sign {
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if f(middle).signum() == sign { low = middle } else { high = middle }
            }
            return Some(0.5 * (low + high));
        }
        low = high;
    }
    None
}

/// Amplitude and share of time in stick of the steady motion, from event to event.
fn simulate(r: f64, zeta: f64, beta: f64, periods: f64) -> (f64, f64) {
    let law = Coulomb { mu_k: beta };
    let [low, high] = law.bounds(0.0, 1.0);
    let period = 2.0 * PI / r;
    let (begin, end) = ((periods - 4.0) * period, periods * period);
    let (mut t, mut x, mut amplitude, mut stuck) = (0.0, 0.0, 0.0_f64, 0.0);
    while t < end {
        let push = |t: f64| (r * t).cos() - x;
        if push(t) > low && push(t) < high {
            let leaves = |t: f64| (high - push(t)).min(push(t) - low);
            let next = first_root(leaves, t, end).unwrap_or(end);
            stuck += (next.min(end) - t.max(begin)).max(0.0);
            t = next;
            if t >= end {
                break;
            }
        }
        let sense = push(t).signum();
        let slip = Slip::new((r, zeta), law.bounds(sense, 1.0)[0], t, [x, 0.0]);
        t = first_root(|t| slip.at(t)[1], t, f64::INFINITY).unwrap_or(end);
        x = slip.at(t)[0];
        if t > begin {
            amplitude = amplitude.max(x.abs());
        }
    }
    (amplitude, stuck / (end - begin))
}

#[test]
fn slip_without_stops() {
    type Row = (f64, f64, &'static [(f64, f64)]);
    let table: [Row; 11] = [
        (0.6, 0.0, &[(0.1, 1.55953422), (0.3, 1.53560181), (0.5, 1.48658157)]),
        (0.8, 0.0, &[(0.1, 2.76133667), (0.3, 2.62610488), (0.5, 2.33223499), (0.7, 1.80379042)]),
        (1.2, 0.0, &[(0.1, 2.25134751), (0.3, 2.07238427), (0.5, 1.65746747), (0.7, 0.65255744)]),
        (1.5, 0.0, &[(0.1, 0.79162281), (0.3, 0.72111026), (0.5, 0.55377492)]),
        (2.0, 0.0, &[(0.1, 0.32956200), (0.3, 0.29767618), (0.5, 0.22047928)]),
        (0.4, 0.0, &[(0.1, 1.16393022)]),
        (0.6, 0.1, &[(0.1, 1.49370300), (0.3, 1.39326134)]),
        (0.9, 0.1, &[(0.1, 3.47269586), (0.3, 2.69764730), (0.5, 1.80862293)]),
        (1.0, 0.1, &[(0.1, 4.36282053), (0.3, 3.08785748), (0.5, 1.81208858)]),
        (1.2, 0.1, &[(0.1, 1.85827059), (0.3, 1.48968286), (0.5, 0.96693445)]),
        (2.0, 0.1, &[(0.1, 0.32110852), (0.3, 0.27870117), (0.5, 0.19223242)]),
    ];
    for (r, zeta, rows) in table {
        for (beta, amplitude) in rows {
            let exact = closed_form(r, zeta, *beta);
            assert!((exact - amplitude).abs() < 6e-9, "closed form, r {r} ζ {zeta} β {beta}: {exact}");
            let (found, stuck) = simulate(r, zeta, *beta, 3000.0);
            assert!((found - amplitude).abs() < 1e-6, "events, r {r} ζ {zeta} β {beta}: {found}");
            assert!(stuck < 1e-6, "r {r} ζ {zeta} β {beta} stuck for {stuck}");
        }
    }
}

#[test]
fn stick_slip() {
    let table = [
        (0.25, 0.2, 0.99322479, 0.130729),
        (0.25, 0.5, 0.69146406, 0.584080),
        (0.4, 0.3, 1.12762377, 0.277346),
        (0.4, 0.5, 1.07907407, 0.345072),
        (0.4, 0.7, 0.94956736, 0.396471),
        (0.6, 0.7, 1.35193093, 0.119503),
        (0.8, 0.9, 0.06834538, 0.506253),
        (1.2, 0.8, 0.11436452, 0.300813),
        (2.0, 0.7, 0.07009969, 0.179907),
    ];
    for (r, beta, amplitude, stuck) in table {
        let (found, rest) = simulate(r, 0.0, beta, 400.0);
        assert!((found - amplitude).abs() < 1e-6, "r {r} β {beta}: {found} for {amplitude}");
        // Six decimals are given.
        assert!((rest - stuck).abs() < 1e-6, "r {r} β {beta}: {rest} for {stuck}");
    }
}

/// Where the stops begin: `β² = V²/(U² + S²/r⁴)`, `S` the largest of `[r sin(t/r) + U r² (cos t − cos(t/r))]/sin t`. A little below it the
/// mass never rests, a little above it does.
#[test]
fn stops_begin_at_the_limit() {
    let table = [
        (0.6, 0.531513),
        (0.8, 0.817406),
        (1.2, 0.713207),
        (1.5, 0.646579),
        (2.0, 0.596285),
        (0.4, 0.143890),
    ];
    for (r, tabled) in table {
        let v = 1.0 / (1.0 - r * r);
        let u = (PI / r).sin() / (r * (1.0 + (PI / r).cos()));
        let slope = |t: f64| (r * (t / r).sin() + u * r * r * (t.cos() - (t / r).cos())) / t.sin();
        let points = 100_000;
        let steepest = (1..points).map(|k| slope(PI * f64::from(k) / f64::from(points))).fold(1.0, f64::max);
        let limit = (v * v / (u * u + (steepest / (r * r)).powi(2))).sqrt();
        // The table cuts off after six decimals.
        assert!((limit - tabled).abs() < 1.2e-6, "r {r}: {limit}");
        assert!(simulate(r, 0.0, 0.98 * limit, 400.0).1 < 1e-9, "r {r}: rests below the limit");
        assert!(simulate(r, 0.0, 1.02 * limit, 400.0).1 > 5e-3, "r {r}: never rests above the limit");
    }
}
