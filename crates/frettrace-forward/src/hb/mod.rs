//! Harmonic balance of a structure with a few contacts; the unknowns are the contacts' own harmonics.
//!
//! # Specified, unknown, equations
//! | specified | unknown | equations |
//! |---|---|---|
//! | receptances `G_cd[h]`, free motion `x̂0_c[h]`, laws | contact forces `f̂_d[h]`, `2H + 1` reals each | `f̂ = F(x̂0 − G f̂)` |
//!
//! `F` takes the motion to samples, through the laws, and the forces back to harmonics (alternating frequency-time).
//! The states of the laws are periodic to rounding, whether they fade or not, and the Jacobian is the exact one of the
//! sampled balance: partials of each step from dual numbers, chained through the period.

mod adaptive;
mod bordered;
mod chain;
mod contact;
mod continuation;
mod dense;
mod element;
mod floquet;
mod follower;
mod laws;
mod lines;
mod modes;
mod network;
mod newton;
mod period;
mod response;
mod solver;
mod system;
mod tangent;
#[cfg(test)]
mod tests;
mod wedge;

pub use adaptive::{Accuracy, Adapted, AdaptiveSolver};
pub use contact::{Contact, ContactLaw, Declared, Family, Friction, Normal, STATE_LIMIT};
pub use continuation::{Curve, Point, Sweep, SweepStatus};
pub use element::{Element, Motion, Orbit, Partials};
pub use floquet::Floquet;
pub use laws::{ElasticContact, LocalElement, Stop};
pub use lines::Lines;
pub use modes::{ModePoint, Modes};
pub use network::{Load, Network, Reading, Support};
pub use newton::Status;
pub use response::{
    BackbonePoint, FrictionBeam, LevelResponse, Response, ResponseOptions, ResponsePoint, response,
};
pub use solver::{Settings, Solution, Solver};
pub use system::Problem;
pub use tangent::Tangents;
pub use wedge::{Interface, OpposedLoop, WedgeDamper};
