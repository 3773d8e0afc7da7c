//! The laws that may be declared, and how a parameter vector becomes one of them.

use crate::Parameter;
use frettrace_friction::Scalar;
use frettrace_friction::effects::{Hook, ModifiedLaw};

/// A declared friction law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Family {
    /// `F = ±μ_k N`.
    Coulomb,
    /// `F = ±μ(v) N + σ2 v`.
    Stribeck,
    /// Dahl's bristle.
    Dahl,
    /// The bristle of Canudas de Wit and others, with a damping that fades with speed.
    LuGre,
    /// Elastic, partial and full slip: the bristle with a breakaway.
    Hybrid,
}

/// Names of the parameters of all laws, in the order of the contract's table.
pub const LAW_PARAMETERS: [&str; 10] =
    ["sigma0", "mu_k", "exponent", "sigma1", "v_d", "sigma2", "mu_s", "v_s", "delta", "breakaway"];

/// Parameters that are a hook of the law as they are.
const HOOKS: [(&str, Hook); 7] = [
    ("exponent", Hook::Exponent),
    ("sigma1", Hook::Sigma1),
    ("v_d", Hook::DampingVelocity),
    ("sigma2", Hook::Viscous),
    ("v_s", Hook::StribeckVelocity),
    ("delta", Hook::StribeckExponent),
    ("breakaway", Hook::Breakaway),
];

impl Family {
    /// All laws, simple ones first.
    pub const ALL: [Self; 5] = [Self::Coulomb, Self::Stribeck, Self::Dahl, Self::LuGre, Self::Hybrid];

    /// Name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Coulomb => "coulomb",
            Self::Stribeck => "stribeck",
            Self::Dahl => "dahl",
            Self::LuGre => "lugre",
            Self::Hybrid => "hybrid",
        }
    }

    /// The law of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|family| family.name() == name)
    }

    /// Whether force depends on the present velocity alone.
    #[must_use]
    pub fn is_static(self) -> bool {
        matches!(self, Self::Coulomb | Self::Stribeck)
    }

    /// Names of its free parameters, in the order of every vector.
    #[must_use]
    pub fn parameter_names(self) -> &'static [&'static str] {
        match self {
            Self::Coulomb => &["mu_k"],
            Self::Stribeck => &["mu_k", "sigma2", "mu_s", "v_s", "delta"],
            Self::Dahl => &["sigma0", "mu_k", "exponent"],
            Self::LuGre => &["sigma0", "mu_k", "sigma1", "v_d", "sigma2", "mu_s", "v_s", "delta"],
            Self::Hybrid => {
                &["sigma0", "mu_k", "sigma1", "v_d", "sigma2", "mu_s", "v_s", "delta", "breakaway"]
            }
        }
    }

    /// Whether it is the other law with more parameters, so that a fit of the other is a start of its own. Stribeck contains
    /// Coulomb, and LuGre Dahl with exponent 1; the hybrid law, elastic when unloaded, is near LuGre but never it.
    #[must_use]
    pub fn extends(self, other: Self) -> bool {
        let pairs = [(Self::Stribeck, Self::Coulomb), (Self::LuGre, Self::Dahl), (Self::Hybrid, Self::LuGre)];
        pairs.contains(&(self, other))
    }

    /// Values of this law nearest to another law with the given values: what both have, neutral values of what only this one
    /// has (no damping, no rise at rest), and for speeds and exponents, which are idle then, those of `typical`.
    #[must_use]
    pub fn nearest(self, (other, values): (Self, &[f64]), typical: &[f64]) -> Vec<f64> {
        let of = |name: &str| {
            let place = other.parameter_names().iter().position(|n| *n == name);
            place.and_then(|j| values.get(j).copied())
        };
        let neutral = |name: &str, typical: f64| match name {
            "sigma1" | "sigma2" | "breakaway" => 0.0,
            "exponent" => 1.0,
            "mu_s" => of("mu_k").unwrap_or(typical),
            _ => typical,
        };
        let names = self.parameter_names().iter().zip(typical);
        names.map(|(name, typical)| of(name).unwrap_or_else(|| neutral(name, *typical))).collect()
    }

    /// Its parameters around typical values, with the experiment that tells each.
    #[must_use]
    pub fn parameters(self, typical: &[f64]) -> Vec<Parameter> {
        self.parameter_names().iter().zip(typical).map(|(name, value)| parameter(name, *value)).collect()
    }

    /// The parameter values of a law: the other way than [`Self::law`].
    #[must_use]
    pub fn values(self, law: &ModifiedLaw<f64>) -> Vec<f64> {
        let of = |hook: Hook| law.get(hook).unwrap_or_default();
        let value = |name: &&str| match *name {
            "sigma0" => of(Hook::Sigma0),
            "mu_k" => of(Hook::MuKinetic),
            "mu_s" => of(Hook::MuKinetic) + of(Hook::StribeckRise),
            other => HOOKS.iter().find(|(name, _)| *name == other).map_or(0.0, |(_, hook)| of(*hook)),
        };
        self.parameter_names().iter().map(value).collect()
    }

    /// The law with these parameter values.
    #[must_use]
    pub fn law<T: Scalar>(self, values: &[T]) -> ModifiedLaw<T> {
        let value = |name: &str| {
            let place = self.parameter_names().iter().position(|n| *n == name);
            place.and_then(|j| values.get(j).copied())
        };
        let kinetic = value("mu_k").unwrap_or_else(|| T::from(0.0));
        let mut law = ModifiedLaw::dahl(value("sigma0").unwrap_or_else(|| T::from(1.0)), kinetic);
        for (name, hook) in HOOKS {
            if let Some(value) = value(name) {
                law.set(hook, value);
            }
        }
        if let Some(still) = value("mu_s") {
            law.set(Hook::StribeckRise, still - kinetic);
        }
        law
    }
}

/// Unit, transform, bounds and telling experiment of a parameter of a law.
fn parameter(name: &str, typical: f64) -> Parameter {
    let wide =
        |unit: &str, factor: f64| Parameter::positive(name, unit, (typical / factor, typical * factor));
    let from_zero = |unit: &str| Parameter {
        transform: crate::Transform::Linear { scale: typical },
        ..Parameter::positive(name, unit, (0.0, 1e4 * typical))
    };
    match name {
        "sigma0" => wide("1/m", 1e3).told_by(
            "runs whose slip stays below three sliding distances (amplitude under 3 mu/sigma0): only there the loop \
             shows its stiffness",
        ),
        "mu_k" => wide("1", 1e2).told_by("runs that slide: amplitude above 2 mu/sigma0"),
        "exponent" => Parameter::positive(name, "1", (0.02, 8.0))
            .told_by("runs with amplitudes from 0.3 to 5 sliding distances mu/sigma0"),
        "sigma1" => from_zero("s/m").told_by("small loops at two or more frequencies, the highest possible"),
        "v_d" => wide("m/s", 1e3).told_by("partial slip at several speeds around v_d"),
        "sigma2" => from_zero("N·s/m").told_by("sliding at speeds of several v_s, friction removed from damping"),
        "mu_s" => wide("1", 1e2).told_by("sliding slower than a third of v_s"),
        "v_s" => wide("m/s", 1e2).told_by("sliding speeds from zero to three v_s"),
        "delta" => Parameter::positive(name, "1", (0.25, 6.0)).told_by("sliding speeds from zero to three v_s"),
        _ => Parameter {
            transform: crate::Transform::Linear { scale: 0.2 },
            ..Parameter::positive(name, "1", (0.0, 0.95))
        }
        .told_by("amplitudes around one sliding distance mu/sigma0, in small steps"),
    }
}
