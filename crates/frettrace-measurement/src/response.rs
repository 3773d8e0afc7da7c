//! The result file of `response`: frequency responses over levels, with stability and backbone.
//!
//! Every dataset carries `units`. A response may turn back, so its points are numbered along the curve and `frequency`
//! is a scale of that axis that need not rise.

use std::path::Path;

use crate::error::Error;
use crate::hdf5::{FileWriter, NewArray};
use crate::write::{list, rows};

/// The response at one amplitude of the force; all lists have one number a point along the curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResponseLevel {
    /// Amplitude of the force \[N\].
    pub force_amplitude: f64,
    /// How the curve ended: `finished`, `returned`, `stalled`, `no-start` or `point-limit`.
    pub status: String,
    /// Largest motion of the harmonics cut off, relative to the slip.
    pub truncation: f64,
    /// Excitation frequency \[Hz\].
    pub frequency: Vec<f64>,
    /// Root mean square of the acceleration (m/s²), sensor by sensor.
    pub acceleration: Vec<Vec<f64>>,
    /// Amplitude of the slip on the excitation's line \[m\].
    pub slip: Vec<f64>,
    /// Amplitude of the friction force on the excitation's line \[N\].
    pub friction_force: Vec<f64>,
    /// Harmonic order of each point.
    pub order: Vec<f64>,
    /// Whether small disturbances die out; `None` where that was not asked.
    pub stable: Vec<Option<bool>>,
}

/// Resonance without excitation and loss; all lists have one number a point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResponseBackbone {
    /// Amplitude of the slip \[m\].
    pub slip: Vec<f64>,
    /// Frequency \[Hz\].
    pub frequency: Vec<f64>,
    /// Damping ratio of the mode, friction included.
    pub damping_ratio: Vec<f64>,
}

/// Frequency responses of a rig.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResponseFile {
    /// Title.
    pub title: String,
    /// Positions of the sensors \[m\].
    pub sensor_position: Vec<f64>,
    /// One response for each amplitude of the force.
    pub levels: Vec<ResponseLevel>,
    /// The backbone.
    pub backbone: ResponseBackbone,
}

/// Format name of frequency responses.
const FORMAT: &str = "frettrace-response";

/// Writes frequency responses, beside `path` first and renamed when whole.
///
/// # Errors
/// [`Error::Write`].
pub fn write_response(path: impl AsRef<Path>, response: &ResponseFile) -> Result<(), Error> {
    let file = FileWriter::create(path.as_ref())?.uncompressed();
    file.text("/", "format", FORMAT)?;
    file.integer("/", "format_version", 1)?;
    file.text("/", "title", &response.title)?;
    file.group("/levels")?;
    for (index, level) in response.levels.iter().enumerate() {
        write_level(&file, &format!("/levels/{:04}", index + 1), level, &response.sensor_position)?;
    }
    write_backbone(&file, &response.backbone)?;
    file.finish()
}

fn write_level(file: &FileWriter, place: &str, level: &ResponseLevel, sensors: &[f64]) -> Result<(), Error> {
    file.group(place)?;
    file.number(place, "force_amplitude", level.force_amplitude)?;
    file.text(place, "status", &level.status)?;
    file.number(place, "truncation", level.truncation)?;
    if level.frequency.is_empty() {
        return Ok(());
    }
    let frequency = list(file, &format!("{place}/frequency"), &level.frequency, "Hz")?;
    file.scale(&frequency, "frequency")?;
    let stable: Vec<f64> =
        level.stable.iter().map(|stable| stable.map_or(f64::NAN, |yes| f64::from(u8::from(yes)))).collect();
    for (name, values, units) in [
        ("slip_displacement", &level.slip, "m"),
        ("friction_force", &level.friction_force, "N"),
        ("order", &level.order, "1"),
        ("stable", &stable, "1"),
    ] {
        file.attach(&list(file, &format!("{place}/{name}"), values, units)?, 0, &frequency)?;
    }
    let position = list(file, &format!("{place}/sensor_position"), sensors, "m")?;
    file.scale(&position, "sensor_position")?;
    let array = NewArray {
        shape: &[level.frequency.len(), level.acceleration.len()],
        values: &rows(&level.acceleration),
        units: "m/s^2",
    };
    let written = file.array(&format!("{place}/acceleration"), array)?;
    file.describe(&written, "measure", "root mean square over a period")?;
    file.attach(&written, 0, &frequency)?;
    file.attach(&written, 1, &position)
}

fn write_backbone(file: &FileWriter, backbone: &ResponseBackbone) -> Result<(), Error> {
    file.group("/backbone")?;
    if backbone.slip.is_empty() {
        return Ok(());
    }
    let slip = list(file, "/backbone/slip_displacement", &backbone.slip, "m")?;
    file.scale(&slip, "slip_displacement")?;
    for (name, values, units) in
        [("frequency", &backbone.frequency, "Hz"), ("damping_ratio", &backbone.damping_ratio, "1")]
    {
        file.attach(&list(file, &format!("/backbone/{name}"), values, units)?, 0, &slip)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Attribute, DataFile};

    /// What is written is read back, the unknown stability as NaN.
    #[test]
    fn a_response_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("response.h5");
        let level = ResponseLevel {
            force_amplitude: 2.0,
            status: "finished".into(),
            truncation: 1e-5,
            frequency: vec![80.0, 81.0, 80.5],
            acceleration: vec![vec![1.0, 2.0, 3.0], vec![4.0, 5.0, 6.0]],
            slip: vec![1e-6, 2e-6, 3e-6],
            friction_force: vec![0.1, 0.2, 0.3],
            order: vec![7.0, 15.0, 15.0],
            stable: vec![Some(true), Some(false), None],
        };
        let backbone =
            ResponseBackbone { slip: vec![1e-6], frequency: vec![90.0], damping_ratio: vec![0.01] };
        let response = ResponseFile {
            title: "rig".into(),
            sensor_position: vec![0.1, 0.2],
            levels: vec![level.clone(), ResponseLevel::default()],
            backbone,
        };
        write_response(&path, &response).unwrap();
        let file = DataFile::open(&path).unwrap();
        assert_eq!(file.attribute("/", "format").unwrap(), Some(Attribute::Text(FORMAT.into())));
        assert_eq!(file.groups("/levels"), ["0001", "0002"]);
        assert_eq!(file.array("/levels/0001/acceleration").unwrap().columns(), level.acceleration);
        assert_eq!(file.array("/levels/0001/frequency").unwrap().values, level.frequency);
        assert_eq!(file.array("/levels/0001/order").unwrap().values, level.order);
        let stable = file.array("/levels/0001/stable").unwrap().values;
        assert!(stable[..2] == [1.0, 0.0] && stable[2].is_nan(), "{stable:?}");
        assert_eq!(file.array("/backbone/damping_ratio").unwrap().values, [0.01]);
    }
}
