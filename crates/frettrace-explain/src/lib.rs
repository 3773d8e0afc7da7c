//! Candidate effects and the evidence for them: what the model lacks; file-unaware.

pub mod aperiodic;
mod balance_fit;
mod case;
mod channels;
mod contact_fit;
mod contact_search;
mod controls;
mod deviation;
pub(crate) mod effects;
mod exhibit;
mod fitting;
mod force_laws;
mod kept;
mod law_starts;
mod left;
mod maps;
mod receptance;
mod records;
pub mod records_explain;
mod saturation;
pub(crate) mod search;
mod series;
mod series_fit;
mod shapes;
mod split;
mod start;
mod study;
pub mod support;
mod tangents;
mod unknown_force;
mod unsettled;
mod unshared;
mod verdict;

pub use case::{Case, DeclaredModes, Scales, positive, signed};
pub use channels::{ChannelFault, Clipped, records};
pub use controls::{Control, Question, controls};
pub use effects::effect_ids;
pub use exhibit::{Exhibit, Loop, exhibits};
pub use fitting::{AccelerationFit, Unknown};
pub use maps::{MapAxis, ResidualMap, maps};
pub use receptance::slip_receptance;
pub use records::{RunRecord, RunSamples};
pub use saturation::{Reading, Saturation};
pub use search::Explained;
pub use series::Series;
pub use shapes::{Shape, shapes};
pub use split::Split;
pub use start::histories;
pub use study::{ExplainError, Fitted, RunError, Study, soften};
pub use verdict::{
    BALANCE_CLOSED, BALANCE_CLOSED_RUN, Named, Outcome, Place, SeenSupport, Tried, Verdict, explain,
    peak_from_rest,
};
