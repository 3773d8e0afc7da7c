//! The friction law behind a recording: accelerations of a beam, or motion and force of the contact itself.

mod accelerations;
pub(crate) mod contact_record;
pub(crate) mod estimates;

use crate::results::Identification;
use crate::{Progress, StudyError};
use frettrace_identify::contact::Family;
use frettrace_measurement::Recording;

/// What is asked of an identification.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IdentifyOptions {
    /// Name of the law, `auto` for the one the data speak for, `None` for the declared one.
    pub law: Option<String>,
}

/// Identifies the friction law of a recording.
///
/// # Errors
/// [`StudyError`] where the law is not known or the data cannot be fitted.
pub fn identify(
    recording: &Recording,
    options: &IdentifyOptions,
    progress: &Progress,
) -> Result<Identification, StudyError> {
    match recording {
        Recording::Measurement(measurement) => {
            accelerations::identify(measurement, &families(options, &measurement.support.law)?, progress)
        }
        Recording::Contact(record) => {
            contact_record::identify(record, &families(options, &record.law)?, progress)
        }
    }
}

/// The laws to fit: one, or all of them.
fn families(options: &IdentifyOptions, declared: &str) -> Result<Vec<Family>, StudyError> {
    match options.law.as_deref().unwrap_or(declared) {
        "auto" => Ok(Family::ALL.to_vec()),
        name => match Family::named(name) {
            Some(family) => Ok(vec![family]),
            None => Err(StudyError::UnknownLaw { name: name.to_owned() }),
        },
    }
}
