//! `frettrace response`.

use super::Session;
use anyhow::ensure;
use clap::Args;
use frettrace::report::{chart::Ink, responses};
use frettrace::response::{FrequencyResponse, JUMPED, ResponseOptions, response};
use frettrace::store;
use frettrace_measurement::DataFile;
use std::path::PathBuf;

/// Frequency responses of a rig over the force amplitudes of its runs, with stability and backbone, by harmonic balance
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  frettrace response data/demo/rig.toml -o response.h5\n  \
        frettrace response data/demo/rig.toml -o response.h5 --range 60 120 --figures figures\n\n\
        The harmonic order rises and falls along each curve so that what is cut off stays below --truncation;\n\
        the table gives the highest order used and the truncation reached.\n\n\
        The rig is that of `simulate`. Each response is followed through its turning points; a point says\n\
        whether small disturbances die out. The backbone is the resonance without excitation and loss.")]
pub struct Arguments {
    /// Rig (TOML)
    rig: PathBuf,
    /// Responses (HDF5)
    #[arg(short, long)]
    output: PathBuf,
    /// Excitation frequencies at the ends [Hz]; 20 % beyond the rig's runs unless given
    #[arg(long, num_args = 2, value_names = ["FROM", "TO"])]
    range: Option<Vec<f64>>,
    /// Motion that the harmonics cut off may cause, relative to the slip; the order of each point follows from it
    #[arg(long, default_value_t = ResponseOptions::default().truncation)]
    truncation: f64,
    /// Harmonics of the contact force, the same for every point
    #[arg(long, conflicts_with = "truncation")]
    order: Option<usize>,
    /// Leave stability out
    #[arg(long)]
    without_stability: bool,
    /// Folder for figures (SVG)
    #[arg(long)]
    figures: Option<PathBuf>,
}

pub fn run(arguments: &Arguments, session: &Session) -> anyhow::Result<()> {
    let rig = frettrace::rig::read_rig(&arguments.rig)?;
    let range_hz = match arguments.range.as_deref() {
        Some(&[from, to]) => {
            let fine = from > 0.0 && to > 0.0 && from != to && (from + to).is_finite();
            ensure!(fine, "--range {from} {to}: two different frequencies above 0 Hz are wanted");
            Some([from, to])
        }
        _ => None,
    };
    let (truncation, order) = (arguments.truncation, arguments.order);
    ensure!(
        truncation > 0.0 && truncation < 1.0,
        "--truncation {truncation}: a share between 0 and 1 is wanted"
    );
    if let Some(order) = order {
        ensure!((1..=500).contains(&order), "--order {order}: 1 to 500 harmonics");
    }
    let options = ResponseOptions { range_hz, truncation, order, stability: !arguments.without_stability };
    let found = response(&rig, &options, &session.progress)?;
    frettrace_measurement::write_response(&arguments.output, &found.file(&rig.title))?;
    if let Some(folder) = &arguments.figures {
        let figures = responses::figures(&DataFile::open(&arguments.output)?, Ink::File)?;
        store::write_figures(folder, &figures)?;
    }
    session.answer(&found, &text(&found))
}

fn text(found: &FrequencyResponse) -> String {
    let head = "force [N]  points  resonance [Hz]  slip there [m]  unstable  order  truncation  ended\n";
    let rows = found.levels.iter().map(|level| {
        let largest = level.points.iter().max_by(|a, b| a.slip_m.total_cmp(&b.slip_m));
        let [frequency, slip] = largest.map_or([f64::NAN; 2], |point| [point.frequency_hz, point.slip_m]);
        let order = level.points.iter().map(|point| point.order).max().unwrap_or(0);
        let unstable = level.points.iter().filter(|point| point.stable == Some(false)).count();
        format!(
            "{:9.4}  {:6}  {frequency:14.4}  {slip:14.4e}  {unstable:8}  {order:5}  {:10.1e}  {}\n",
            level.force_amplitude_n,
            level.points.len(),
            level.truncation,
            level.status
        )
    });
    let backbone = match found.backbone.as_slice() {
        [first, .., last] => format!(
            "\nbackbone: {:.4} Hz at a slip of {:.3e} m to {:.4} Hz at {:.3e} m, {} points; damping ratio at most {:.4}\n",
            first.frequency_hz,
            first.slip_m,
            last.frequency_hz,
            last.slip_m,
            found.backbone.len(),
            found.backbone.iter().map(|point| point.damping_ratio).fold(0.0, f64::max),
        ),
        _ => "\nbackbone: none found\n".to_owned(),
    };
    let jumped = found.levels.iter().any(|level| level.status == JUMPED);
    let meaning = if jumped {
        "\njumped: there the force of the law falls by a finite step (it breaks away), and beside it is no motion to go on with\n"
    } else {
        ""
    };
    head.to_owned() + &rows.collect::<String>() + meaning + &backbone
}
