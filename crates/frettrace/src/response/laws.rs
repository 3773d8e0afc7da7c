//! Friction laws of a rig as elements of the harmonic balance.

use frettrace_forward::hb::{Declared, Element, Family, Friction};
use frettrace_forward::simulate::SimulatedLaw;
use frettrace_friction::effects::ModifiedLaw;
use frettrace_friction::{Bristle, FrictionModel, Scalar, Steady, laws};

/// A law of the bristle family.
struct Bristly(Bristle<f64>);

impl Family for Bristly {
    type Law<T: Scalar> = Friction<Bristle<T>>;

    fn parameters(&self) -> &[f64] {
        &[]
    }

    fn law<T: Scalar>(&self, _: &[T]) -> Self::Law<T> {
        Friction(self.0.lift())
    }
}

/// A bristle with effects in it.
struct Modified(ModifiedLaw<f64>);

impl Family for Modified {
    type Law<T: Scalar> = Friction<ModifiedLaw<T>>;

    fn parameters(&self) -> &[f64] {
        &[]
    }

    fn law<T: Scalar>(&self, _: &[T]) -> Self::Law<T> {
        Friction(self.0.lift(|_, value| T::from(value)))
    }
}

/// The law as an element; a law that is set-valued at rest gets a bristle of stiffness `sigma0`.
pub(super) fn law(law: &SimulatedLaw, sigma0: f64) -> Box<dyn Element> {
    let bristle = match law {
        SimulatedLaw::Modified(law) => return Box::new(Modified(*law)),
        // Effects in other formulas are refused before; what is left of them here is the declared bristle.
        SimulatedLaw::Foreign(law) => {
            let bristle = law.bristle;
            laws::Dahl { sigma0: bristle.sigma0, mu_k: bristle.mu_k, exponent: bristle.exponent }.bristle()
        }
        SimulatedLaw::Declared(model) => match model {
            FrictionModel::Coulomb(law) => Bristle::plain(sigma0, law.mu_k),
            FrictionModel::Stribeck(law) => Bristle {
                sigma2: law.sigma2,
                mu_s: law.mu_s,
                v_s: law.v_s,
                delta: law.delta,
                steady: Steady::Stribeck,
                ..Bristle::plain(sigma0, law.mu_k)
            },
            FrictionModel::Dahl(law) => law.bristle(),
            FrictionModel::Lugre(law) => law.bristle(),
            FrictionModel::Hybrid(law) => law.bristle(),
            FrictionModel::ElastoPlastic(law) => law.bristle(),
            FrictionModel::FilmStribeck(law) => {
                let laws::FilmStribeck { film, sigma2, inertia } = *law;
                let law = laws::FilmLugre { sigma0, sigma1: 0.0, film, sigma2, inertia };
                return Box::new(Declared(FrictionModel::FilmLugre(law)));
            }
            other => return Box::new(Declared(*other)),
        },
    };
    Box::new(Bristly(bristle))
}

/// Whether the force changes sign within a velocity, or a slip, that is small beside the motion.
pub(super) fn turns(law: &SimulatedLaw) -> bool {
    let SimulatedLaw::Declared(model) = law else { return false };
    matches!(model, FrictionModel::Coulomb(_) | FrictionModel::Stribeck(_))
        || model.named().contains_key("v_ref")
}
