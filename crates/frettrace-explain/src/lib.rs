//! Candidate effects and the evidence for them: what the model lacks; file-unaware.

mod balance_fit;
mod case;
mod channels;
mod contact_fit;
mod contact_search;
mod controls;
pub(crate) mod effects;
mod exhibit;
mod fitting;
mod force_laws;
mod maps;
mod records;
pub mod records_explain;
pub(crate) mod search;
mod series_fit;
mod shapes;
mod start;
mod study;
mod tangents;
mod unknown_force;
mod verdict;

pub use case::{Case, DeclaredModes, Scales, positive, signed};
pub use channels::{ChannelFault, Clipped, records};
pub use controls::{Control, Question, controls};
pub use effects::effect_ids;
pub use exhibit::{Exhibit, Loop, exhibits};
pub use fitting::{AccelerationFit, Unknown};
pub use maps::{MapAxis, ResidualMap, maps};
pub use records::{RunRecord, RunSamples};
pub use search::Explained;
pub use series_fit::Series;
pub use shapes::{Shape, shapes};
pub use start::histories;
pub use study::{ExplainError, Fitted, RunError, Split, Study};
pub use verdict::{Named, Outcome, Place, Tried, Verdict, explain};
