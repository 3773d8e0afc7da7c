//! The parameters of the modified law.

/// Number of hooks.
pub const HOOKS: usize = 88;

/// A parameter of [`ModifiedLaw`](super::ModifiedLaw): those of the declared laws first, then those of effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(usize)]
pub enum Hook {
    /// Presliding stiffness over the normal force `σ0` (1/m).
    Sigma0,
    /// Kinetic friction coefficient `μ_k`.
    MuKinetic,
    /// Exponent `i` of Dahl's law.
    Exponent,
    /// Presliding damping `σ1` (s/m).
    Sigma1,
    /// Velocity over which the presliding damping fades `v_d` (m/s).
    DampingVelocity,
    /// Viscous coefficient `σ2` (N·s/m).
    Viscous,
    /// Rise of the friction coefficient towards rest `μ_s − μ_k`.
    StribeckRise,
    /// Stribeck velocity `v_s` (m/s).
    StribeckVelocity,
    /// Stribeck exponent `δ`.
    StribeckExponent,
    /// Share of the rational decay `1/(1+x^δ)` beside the exponential one `exp(−x^δ)`.
    RationalShare,
    /// Elastic share of the steady deflection.
    Breakaway,
    /// Relative difference of the friction coefficient between the two directions, `μ(1 + a·sgn v)`.
    Asymmetry,
    /// Time by which the friction coefficient lags behind velocity \[s\].
    LagTime,
    /// Loss of friction when a film has built up, as a share of `μ`.
    FilmLoss,
    /// Time constant with which the film builds up \[s\].
    FilmRise,
    /// Time constant with which the film breaks down \[s\].
    FilmFall,
    /// Velocity at which the film is complete (m/s).
    FilmVelocity,
    /// Gain of friction per e-fold of the contact's age, as a share of `μ`.
    AgeingGain,
    /// Slip that renews the contact \[m\].
    AgeingDistance,
    /// Age from which strengthening is seen \[s\].
    AgeingTime,
    /// Relative change of the friction coefficient with slip (1/m).
    Position,
    /// The same, second order [1/m²].
    PositionSquare,
    /// Periodic change of the friction coefficient with slip: cosine share.
    PeriodicCosine,
    /// Periodic change of the friction coefficient with slip: sine share.
    PeriodicSine,
    /// Its wave number (rad/m).
    PeriodicNumber,
    /// Exponent `n` in `μ ∝ (N/N₀)^(−n)`.
    NormalExponent,
    /// Relative change of the friction coefficient from the first run to the last.
    Wear,
    /// Compliance in series with the contact (m/N).
    SeriesCompliance,
    /// Spring beside the contact (N/m).
    ParallelStiffness,
    /// Cubic spring beside the contact (N/m³).
    ParallelCubic,
    /// Half the play of the contact \[m\].
    Backlash,
    /// Relative modulation of the preload: cosine of the phase.
    ModulationCosine,
    /// Relative modulation of the preload: sine of the phase.
    ModulationSine,
    /// Time constant of a first-order lag of the friction force \[s\].
    ForceLag,
    /// Viscous coefficient of second degree [N·s²/m²].
    ViscousSquare,
    /// Time by which the speed that sets the friction coefficient lags behind the speed \[s\].
    SpeedLag,
    /// Time by which the velocity that sets the friction coefficient lags behind the velocity, signs included \[s\].
    VelocityLag,
    /// Normal force at which the friction coefficient is the stated one, for its dependence on it \[N\].
    NormalReference,
    /// Power `q` of the same dependence where it is not `−n`, by `s = q + n`: `μ ∝ 1 − n(x^q − 1)/q`, `x = N/N₀`. A straight line has
    /// `q = 1`, a logarithm 0, a constant shear strength −1.
    NormalPower,
    /// Exponent of the course of wear over the runs, `progress^k`.
    WearExponent,
    /// Exponent `p` of a film thickness `1 − exp(−(|v|/v_b)^p)`.
    FilmExponent,
    /// Share of an ageing that ends, `1 − e^{−age/time}`, beside one that goes on with the logarithm.
    AgeingSaturation,
    /// Relative change of the friction coefficient with slip, third order [1/m³].
    PositionCube,
    /// Velocity over which the asymmetry turns over, `v/√(v² + v_a²)` in place of `sgn v` (m/s).
    AsymmetryVelocity,
    /// Share of a straight rise of the plastic flow after breakaway beside the half sine.
    BreakawayShape,
    /// Share of a rational fading `1/(1 + (v/v_d)²)` of the presliding damping beside the Gaussian one.
    DampingRational,
    /// Power `n` of the loading in the flow `1 − r|r|^{n−1}` of the bristle, in place of `1 − r`.
    FlowPower,
    /// Slip beyond which the change of the friction coefficient with slip saturates, `u/√(1 + (u/s)²)` \[m\].
    PositionScale,
    /// Power `p` of the viscous force, `σ2·v·|v/v₀|^{p−1}`.
    ViscousPower,
    /// Its reference velocity `v₀` (m/s).
    ViscousReference,
    /// Saturation `κ` of a lag whose rate is bounded, `(s − m)/(τ(1 + κ|s − m|))`, in units of the curve or of `v_s`.
    LagSaturation,
    /// Steepness `κ` of the modulation of the preload, `tanh(κ cos ψ)/tanh κ` in place of `cos ψ`.
    ModulationSteepness,
    /// Share of a rational approach `x^p/(1 + x^p)`, `x = |v|/v_b`, of the film's thickness beside the exponential one.
    FilmRational,
    /// Second harmonic of the periodic change of the friction coefficient with slip: cosine share.
    PeriodicCosine2,
    /// The same, sine share.
    PeriodicSine2,
    /// Third harmonic of the periodic change of the friction coefficient with slip: cosine share.
    PeriodicCosine3,
    /// The same, sine share.
    PeriodicSine3,
    /// Rate `κ` at which wear settles: `(1 − e^{−κx})/(1 − e^{−κ})` in place of its course `x`.
    WearSettling,
    /// Power `p` of the turn-over of an asymmetry, `y/(1 + y^p)^{1/p}` with `y = |v|/v_a`; 2 is the plain one.
    AsymmetryPower,
    /// Power `p` of the end of a change with slip, `u/(1 + |u/s|^p)^{1/p}`; 2 is the plain one.
    PositionPower,
    /// Power `p` of the bound of a lag's rate, `(s − m)/(τ (1 + (κ|s − m|)^p)^{1/p})`; 1 is the plain one.
    LagPower,
    /// Sharpness `k` of the periodic change with slip, `asin(k w)/asin k` of its wave `w`: 0 leaves the wave, 1 is a triangle.
    PeriodicSharpness,
    /// Power `n` with which play closes, `dw = max(y·sgn v, 0)ⁿ du` with `y = (u − w)/β` and half the play `β` (Bouc and Wen's element with
    /// `γ = ½`): without it all at once.
    BacklashPower,
    /// Share `a` by which what a lag sets is ahead of it again, `m + a(m − s)`: 0 is a lag of first order, 1 the all-pass of first order, which delays by
    /// twice its time without another change (Padé).
    LagDelay,
    /// Viscous coefficient of the normal force, `c N v` (s/m).
    ViscousNormal,
    /// Force along the path over the normal force that comes again with the wave number: cosine share.
    LatticeCosine,
    /// The same, sine share.
    LatticeSine,
    /// Relative difference of the bristle's force between its two sides, `b(1 + a y/√(1 + y²))` with `y = b/(s μ_k)`.
    BristleAsymmetry,
    /// Share `s` of the sliding deflection over which that turns over.
    BristleTurn,
    /// Share of a course of wear with the work that friction has done, beside one with the number of the run.
    WearWork,
    /// Share of a run's own work that counts in its wear; half of it where this is not set.
    WearOwn,
    /// Spring beside the contact that is met beyond a gap on either side (N/m).
    ShoulderStiffness,
    /// That gap \[m\].
    ShoulderGap,
    /// Share of a presliding damping `σ1 v (1 − |r|)`, alike before and after a reversal, beside `σ1 ż`.
    DampingStuck,
    /// Whether the dependence on the normal force is that of the whole bristle force, its stiffness included (1), or of its limit (0).
    NormalWhole,
    /// Share `c` of the reference velocity up to which a viscous force with a power is straight, `σ2·v·(y^q + c^q)^{(p−1)/q}` with `y = |v|/v₀`.
    ViscousCore,
    /// Sharpness `q` with which it turns over there; 2 is the plain one.
    ViscousTurn,
    /// Power `p` of an ageing, `((1 + age/time)^p − 1)/p` in place of the logarithm, which is `p = 0`; below 0 it ends.
    AgeingPower,
    /// Steepness `κ` of the periodic change with slip, `g(κ w)/g(κ)` of its wave `w` with `g(x) = x/(1 + |x|^m)^{1/m}`: a square wave in the end.
    PeriodicSteepness,
    /// Corner `m` between its slopes and its levels: near 1 it is as round as an arc tangent's, near 2 as a hyperbolic tangent's, and sharp in the end;
    /// 2 where it is not given.
    PeriodicCorner,
    /// Second harmonic of the modulation of the preload: cosine share.
    ModulationCosine2,
    /// The same, sine share.
    ModulationSine2,
    /// Third harmonic of the modulation of the preload: cosine share.
    ModulationCosine3,
    /// The same, sine share.
    ModulationSine3,
    /// Fourth harmonic of the modulation of the preload: cosine share.
    ModulationCosine4,
    /// The same, sine share.
    ModulationSine4,
    /// Power `p` of the fading of the presliding damping, `exp(−|v/v_d|^p)` and `1/(1 + |v/v_d|^p)`; 2 is the plain one.
    DampingPower,
    /// Bend `q` of the Stribeck curve, `(1 + (q − 1) x^δ)₊^{−1/(q − 1)}` (Tsallis' exponential) in place of exponential and rational decay: 1 is the
    /// exponential, 2 the rational one, and 0 a curve that ends, with `δ = 1` a straight line.
    StribeckBend,
}

impl Hook {
    /// All hooks, in the order of their numbers.
    pub const ALL: [Self; HOOKS] = [
        Self::Sigma0,
        Self::MuKinetic,
        Self::Exponent,
        Self::Sigma1,
        Self::DampingVelocity,
        Self::Viscous,
        Self::StribeckRise,
        Self::StribeckVelocity,
        Self::StribeckExponent,
        Self::RationalShare,
        Self::Breakaway,
        Self::Asymmetry,
        Self::LagTime,
        Self::FilmLoss,
        Self::FilmRise,
        Self::FilmFall,
        Self::FilmVelocity,
        Self::AgeingGain,
        Self::AgeingDistance,
        Self::AgeingTime,
        Self::Position,
        Self::PositionSquare,
        Self::PeriodicCosine,
        Self::PeriodicSine,
        Self::PeriodicNumber,
        Self::NormalExponent,
        Self::Wear,
        Self::SeriesCompliance,
        Self::ParallelStiffness,
        Self::ParallelCubic,
        Self::Backlash,
        Self::ModulationCosine,
        Self::ModulationSine,
        Self::ForceLag,
        Self::ViscousSquare,
        Self::SpeedLag,
        Self::VelocityLag,
        Self::NormalReference,
        Self::NormalPower,
        Self::WearExponent,
        Self::FilmExponent,
        Self::AgeingSaturation,
        Self::PositionCube,
        Self::AsymmetryVelocity,
        Self::BreakawayShape,
        Self::DampingRational,
        Self::FlowPower,
        Self::PositionScale,
        Self::ViscousPower,
        Self::ViscousReference,
        Self::LagSaturation,
        Self::ModulationSteepness,
        Self::FilmRational,
        Self::PeriodicCosine2,
        Self::PeriodicSine2,
        Self::PeriodicCosine3,
        Self::PeriodicSine3,
        Self::WearSettling,
        Self::AsymmetryPower,
        Self::PositionPower,
        Self::LagPower,
        Self::PeriodicSharpness,
        Self::BacklashPower,
        Self::LagDelay,
        Self::ViscousNormal,
        Self::LatticeCosine,
        Self::LatticeSine,
        Self::BristleAsymmetry,
        Self::BristleTurn,
        Self::WearWork,
        Self::WearOwn,
        Self::ShoulderStiffness,
        Self::ShoulderGap,
        Self::DampingStuck,
        Self::NormalWhole,
        Self::ViscousCore,
        Self::ViscousTurn,
        Self::AgeingPower,
        Self::PeriodicSteepness,
        Self::PeriodicCorner,
        Self::ModulationCosine2,
        Self::ModulationSine2,
        Self::ModulationCosine3,
        Self::ModulationSine3,
        Self::ModulationCosine4,
        Self::ModulationSine4,
        Self::DampingPower,
        Self::StribeckBend,
    ];

    /// Value at which the hook adds nothing, where it measures the size of an effect; `None` for shapes, times and scales.
    #[must_use]
    pub fn nothing(self) -> Option<f64> {
        match self {
            Self::Exponent | Self::FlowPower => Some(1.0),
            Self::Sigma1
            | Self::Viscous
            | Self::ViscousSquare
            | Self::StribeckRise
            | Self::Breakaway
            | Self::Asymmetry
            | Self::LagTime
            | Self::SpeedLag
            | Self::VelocityLag
            | Self::ForceLag
            | Self::FilmLoss
            | Self::AgeingGain
            | Self::Position
            | Self::PositionSquare
            | Self::PositionCube
            | Self::PeriodicCosine
            | Self::PeriodicSine
            | Self::PeriodicCosine2
            | Self::PeriodicSine2
            | Self::PeriodicCosine3
            | Self::PeriodicSine3
            | Self::NormalExponent
            | Self::NormalPower
            | Self::Wear
            | Self::SeriesCompliance
            | Self::ParallelStiffness
            | Self::ParallelCubic
            | Self::Backlash
            | Self::ViscousNormal
            | Self::LatticeCosine
            | Self::LatticeSine
            | Self::BristleAsymmetry
            | Self::ShoulderStiffness
            | Self::ModulationCosine
            | Self::ModulationSine
            | Self::ModulationCosine2
            | Self::ModulationSine2
            | Self::ModulationCosine3
            | Self::ModulationSine3
            | Self::ModulationCosine4
            | Self::ModulationSine4 => Some(0.0),
            _ => None,
        }
    }

    /// Its name in results and its unit.
    #[must_use]
    pub fn name_and_unit(self) -> (&'static str, &'static str) {
        match self {
            Self::Sigma0 => ("sigma0", "1/m"),
            Self::MuKinetic => ("mu_k", "1"),
            Self::Exponent => ("exponent", "1"),
            Self::Sigma1 => ("sigma1", "s/m"),
            Self::DampingVelocity => ("v_d", "m/s"),
            Self::Viscous => ("sigma2", "N·s/m"),
            Self::StribeckRise => ("mu_rise", "1"),
            Self::StribeckVelocity => ("v_s", "m/s"),
            Self::StribeckExponent => ("delta", "1"),
            Self::RationalShare => ("rational_share", "1"),
            Self::Breakaway => ("breakaway", "1"),
            Self::Asymmetry => ("asymmetry", "1"),
            Self::LagTime => ("lag_time", "s"),
            Self::FilmLoss => ("film_loss", "1"),
            Self::FilmRise => ("film_rise_time", "s"),
            Self::FilmFall => ("film_fall_time", "s"),
            Self::FilmVelocity => ("film_velocity", "m/s"),
            Self::AgeingGain => ("ageing_gain", "1"),
            Self::AgeingDistance => ("ageing_distance", "m"),
            Self::AgeingTime => ("ageing_time", "s"),
            Self::Position => ("position_slope", "1/m"),
            Self::PositionSquare => ("position_curvature", "1/m^2"),
            Self::PeriodicCosine => ("periodic_cosine", "1"),
            Self::PeriodicSine => ("periodic_sine", "1"),
            Self::PeriodicNumber => ("wave_number", "rad/m"),
            Self::PeriodicCosine2 => ("periodic_cosine_2", "1"),
            Self::PeriodicSine2 => ("periodic_sine_2", "1"),
            Self::PeriodicCosine3 => ("periodic_cosine_3", "1"),
            Self::PeriodicSine3 => ("periodic_sine_3", "1"),
            Self::NormalExponent => ("normal_exponent", "1"),
            Self::Wear => ("wear", "1"),
            Self::SeriesCompliance => ("series_compliance", "m/N"),
            Self::ParallelStiffness => ("parallel_stiffness", "N/m"),
            Self::ParallelCubic => ("parallel_cubic", "N/m^3"),
            Self::Backlash => ("half_play", "m"),
            Self::ModulationCosine => ("modulation_cosine", "1"),
            Self::ModulationSine => ("modulation_sine", "1"),
            Self::ForceLag => ("force_lag_time", "s"),
            Self::ViscousSquare => ("sigma2_square", "N·s^2/m^2"),
            Self::SpeedLag => ("speed_lag_time", "s"),
            Self::VelocityLag => ("velocity_lag_time", "s"),
            Self::NormalReference => ("normal_reference", "N"),
            Self::NormalPower => ("normal_power_shift", "1"),
            Self::WearExponent => ("wear_exponent", "1"),
            Self::WearSettling => ("wear_settling", "1"),
            Self::AsymmetryPower => ("asymmetry_power", "1"),
            Self::PositionPower => ("position_power", "1"),
            Self::LagPower => ("lag_power", "1"),
            Self::PeriodicSharpness => ("periodic_sharpness", "1"),
            Self::BacklashPower => ("backlash_power", "1"),
            Self::FilmExponent => ("film_exponent", "1"),
            Self::FilmRational => ("film_rational_share", "1"),
            Self::AgeingSaturation => ("ageing_saturation", "1"),
            Self::PositionCube => ("position_cube", "1/m^3"),
            Self::AsymmetryVelocity => ("asymmetry_velocity", "m/s"),
            Self::BreakawayShape => ("breakaway_shape", "1"),
            Self::DampingRational => ("damping_rational", "1"),
            Self::FlowPower => ("flow_power", "1"),
            Self::PositionScale => ("position_scale", "m"),
            Self::ViscousPower => ("viscous_power", "1"),
            Self::ViscousReference => ("viscous_reference", "m/s"),
            Self::LagSaturation => ("lag_saturation", "1"),
            Self::ModulationSteepness => ("modulation_steepness", "1"),
            Self::LagDelay => ("lag_delay", "1"),
            Self::ViscousNormal => ("sigma2_normal", "s/m"),
            Self::LatticeCosine => ("lattice_cosine", "1"),
            Self::LatticeSine => ("lattice_sine", "1"),
            Self::BristleAsymmetry => ("bristle_asymmetry", "1"),
            Self::BristleTurn => ("bristle_turn", "1"),
            Self::WearWork => ("wear_by_work", "1"),
            Self::WearOwn => ("wear_own_work", "1"),
            Self::ShoulderStiffness => ("shoulder_stiffness", "N/m"),
            Self::ShoulderGap => ("shoulder_gap", "m"),
            Self::DampingStuck => ("damping_stuck", "1"),
            Self::NormalWhole => ("normal_whole", "1"),
            Self::ViscousCore => ("viscous_core", "1"),
            Self::ViscousTurn => ("viscous_turn", "1"),
            Self::AgeingPower => ("ageing_power", "1"),
            Self::PeriodicSteepness => ("periodic_steepness", "1"),
            Self::PeriodicCorner => ("periodic_corner", "1"),
            Self::ModulationCosine2 => ("modulation_cosine_2", "1"),
            Self::ModulationSine2 => ("modulation_sine_2", "1"),
            Self::ModulationCosine3 => ("modulation_cosine_3", "1"),
            Self::ModulationSine3 => ("modulation_sine_3", "1"),
            Self::ModulationCosine4 => ("modulation_cosine_4", "1"),
            Self::ModulationSine4 => ("modulation_sine_4", "1"),
            Self::DampingPower => ("damping_power", "1"),
            Self::StribeckBend => ("stribeck_bend", "1"),
        }
    }
}
