//! `frettrace inspect`.

use super::Session;
use clap::Args;
use frettrace::{inspect::Inspection, report::words::percent};
use frettrace_measurement::quality::{ChannelState, ContactQuality, RunQuality};
use std::path::PathBuf;

/// What a file holds: levels, signal-to-noise, steadiness, subharmonics, clipping, dead sensors
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  frettrace inspect rig.h5\n  frettrace inspect rig.h5 --json | jq '.runs[].level'"
)]
pub struct Arguments {
    /// Measurement file or contact record
    file: PathBuf,
}

pub fn run(arguments: &Arguments, session: &Session) -> anyhow::Result<()> {
    let recording = frettrace_measurement::read(&arguments.file)?;
    let found = frettrace::inspect::inspect(&recording, &session.progress)?;
    session.answer(&found, &text(&found))
}

fn text(found: &Inspection) -> String {
    match found {
        Inspection::Measurement { title, law, slip, modes, second_support_m, sensor_position_m, runs } => {
            let second = second_support_m.map_or(String::new(), |x| format!(", second support at {x:.4} m"));
            let head = format!(
                "{title}\nmeasurement file: law {law}, slip by {slip}, {modes} measured modes, {} sensors, {} runs{second}\n\n\
                 run     frequency [Hz]  force [N]  level [m/s²]  harmonics  unsteady  unexplained   SNR [dB]  form\n",
                sensor_position_m.len(),
                runs.len()
            );
            head + &runs.iter().map(measured_row).collect::<String>()
        }
        Inspection::Contact { title, law, slip_unit, runs } => {
            let head = format!(
                "{title}\ncontact record: law {law}, {} runs\n\n\
                 run     samples  duration [s]  force rms [N]  slip span [{slip_unit}]  cycles  sampling\n",
                runs.len()
            );
            head + &runs.iter().map(contact_row).collect::<String>()
        }
    }
}

fn measured_row(run: &RunQuality) -> String {
    let ratios = run.channels.iter().map(|channel| channel.signal_to_noise_db);
    let (low, high) =
        ratios.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let form = match run.subharmonic_order {
        _ if run.periodic == Some(false) => "not periodic".to_owned(),
        1 => "harmonic".to_owned(),
        order => format!("subharmonic of order {order}"),
    };
    let bad: String = run
        .channels
        .iter()
        .enumerate()
        .filter(|(_, channel)| channel.state != ChannelState::Good)
        .map(|(index, channel)| format!("; sensor {index} {}", state(channel.state)))
        .collect();
    format!(
        "{:6} {:15.4} {:10.4} {:13.4} {:>10} {:>9} {:>12}  {low:4.0}…{high:<4.0}  {form}{bad}\n",
        run.id,
        run.frequency,
        run.force_rms,
        run.level,
        percent(run.harmonic_share),
        percent(run.unsteadiness),
        percent(run.unexplained_share),
    )
}

fn state(state: ChannelState) -> &'static str {
    match state {
        ChannelState::Good => "good",
        ChannelState::Clipped => "clipped",
        ChannelState::Dead => "dead",
    }
}

fn contact_row(run: &ContactQuality) -> String {
    let sampling = if run.uniform { "uniform" } else { "not uniform" };
    format!(
        "{:6} {:8} {:13.4} {:14.4} {:14.4e} {:7}  {sampling}\n",
        run.id, run.samples, run.duration, run.force_rms, run.slip_span, run.cycles
    )
}
