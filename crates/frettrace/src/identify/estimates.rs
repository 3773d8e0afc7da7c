//! Identified parameters as they stand in result files.

use crate::results::Estimate;
use frettrace_identify::{Identifiability, IdentifiedParameter};

/// A parameter of the result; one that is not identified has an open interval.
pub(crate) fn estimate(parameter: &IdentifiedParameter) -> Estimate {
    let (low, high) = parameter.interval95.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    Estimate {
        value: parameter.value,
        std: parameter.std.unwrap_or(f64::INFINITY),
        interval95: [low, high],
        unit: parameter.unit.clone(),
        identifiable: parameter.is_identifiable(),
    }
}

/// What a reader must know of a parameter that is not identified.
pub(super) fn remark(name: &str, parameter: &IdentifiedParameter) -> Option<String> {
    match &parameter.identifiability {
        Identifiability::NotIdentifiable { reason, experiment, .. } if experiment.is_empty() => {
            Some(format!("{name} is not identifiable: {reason}"))
        }
        Identifiability::NotIdentifiable { reason, experiment, .. } => {
            Some(format!("{name} is not identifiable: {reason}; what would tell: {experiment}"))
        }
        _ => None,
    }
}
