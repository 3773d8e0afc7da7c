use super::*;
use std::f64::consts::TAU;

const RATE: f64 = 2048.0;
const SAMPLES: usize = 2048;
/// The nominal frequency is 0.2 Hz off, as files may be.
const TRUE_FREQUENCY: f64 = 50.2;

/// Noise without a random generator: an irrational rotation squared, uniform on [−½, ½), standard deviation 1/√12.
fn noise(k: usize, seed: f64) -> f64 {
    let x = (k as f64 * k as f64 * 0.618_033_988_749 + seed) * 0.754_877_666_247;
    x.fract() - 0.5
}

fn run_of(motion: impl Fn(f64) -> f64) -> Run {
    let time: Vec<f64> = (0..SAMPLES).map(|k| k as f64 / RATE).collect();
    let channel = |gain: f64, seed: f64| -> Vec<f64> {
        time.iter().enumerate().map(|(k, t)| gain * motion(*t) + 0.01 * noise(k, seed)).collect()
    };
    Run {
        id: "0001".into(),
        label: "made".into(),
        sampling_rate: RATE,
        excitation_frequency: 50.0,
        preload: 10.0,
        lubricated: None,
        temperature: None,
        acceleration: vec![channel(1.0, 0.1), channel(2.0, 0.2)],
        force: time.iter().map(|t| 3.0 * (TAU * TRUE_FREQUENCY * t).cos()).collect(),
    }
}

fn sensors() -> Sensors {
    Sensors { position: vec![0.1, 0.2], noise_std: None, name: None }
}

fn phase(t: f64) -> f64 {
    TAU * TRUE_FREQUENCY * t
}

/// A clean periodic run: level √((½·1.01 + ½·4·1.01)/2), a tenth of it in the third harmonic, frequency refined.
#[test]
fn a_periodic_run_is_good() {
    let quality = judge(&run_of(|t| phase(t).cos() + 0.1 * (3.0 * phase(t)).sin()), &sensors()).unwrap();
    assert!((quality.frequency - TRUE_FREQUENCY).abs() < 1e-6, "{}", quality.frequency);
    assert!((quality.level - (1.01_f64 * 5.0 / 4.0).sqrt()).abs() < 2e-3, "{}", quality.level);
    assert!((quality.harmonic_share - 0.0995).abs() < 1e-3, "{}", quality.harmonic_share);
    assert_eq!(quality.subharmonic_order, 1);
    assert!(quality.unsteadiness < 1e-3 && quality.unexplained_share < 5e-3);
    assert!(quality.channels.iter().all(|channel| channel.state == ChannelState::Good));
    // Noise 0.01/√12 under a level of 0.71: 48 dB.
    assert!((quality.channels[0].signal_to_noise_db - 47.8).abs() < 1.0);
}

/// A line at a third of the excitation frequency is found as order 3, not 6; one at a half as 2.
#[test]
fn the_lowest_subharmonic_order_is_found() {
    for order in [2, 3] {
        let run = run_of(|t| phase(t).cos() + 0.05 * (phase(t) / order as f64).cos());
        assert_eq!(judge(&run, &sensors()).unwrap().subharmonic_order, order);
    }
}

/// An amplitude that grows by 30 % over the record grows by about 20 % between the middles of the outer thirds.
#[test]
fn a_settling_run_is_unsteady() {
    let quality = judge(&run_of(|t| (1.0 + 0.3 * t) * phase(t).cos()), &sensors()).unwrap();
    assert!((quality.unsteadiness - 0.2 / 1.05).abs() < 0.01, "{}", quality.unsteadiness);
}

/// A limiter leaves plateaus; an unplugged channel holds noise only.
#[test]
fn clipped_and_dead_channels_are_named() {
    let mut run = run_of(|t| phase(t).cos());
    for value in &mut run.acceleration[0] {
        *value = value.clamp(-0.8, 0.8);
    }
    run.acceleration[1] = (0..SAMPLES).map(|k| 0.01 * noise(k, 0.3)).collect();
    let quality = judge(&run, &sensors()).unwrap();
    assert_eq!(quality.channels[0].state, ChannelState::Clipped);
    assert_eq!(quality.channels[1].state, ChannelState::Dead);
}

/// A constant channel is dead too, and no figure of it is undefined in a way that stops the rest.
#[test]
fn a_constant_channel_is_dead() {
    let mut run = run_of(|t| phase(t).cos());
    run.acceleration[1] = vec![0.0; SAMPLES];
    let quality = judge(&run, &sensors()).unwrap();
    assert_eq!(quality.channels[1].state, ChannelState::Dead);
    assert!(quality.level.is_finite());
}

/// Ten periods of a sine of amplitude 2: span 4, nineteen crossings of the mid line.
#[test]
fn cycles_of_a_contact_record_are_counted() {
    let slip: Vec<f64> = (0..1000).map(|k| 2.0 * (TAU * f64::from(k) / 100.0).sin()).collect();
    let run = ContactRun {
        id: "0001".into(),
        label: String::new(),
        preload: None,
        time: (0..1000).map(|k| f64::from(k) * 1e-3).collect(),
        sampling_rate: Some(1000.0),
        force: slip.iter().map(|u| u.signum()).collect(),
        slip_displacement: slip,
        slip_velocity: None,
        slip_acceleration: None,
        normal_force: None,
        force_noise_std: None,
    };
    let quality = judge_contact(&run);
    assert_eq!(quality.cycles, 10);
    assert!((quality.slip_span - 4.0).abs() < 1e-12 && (quality.duration - 0.999).abs() < 1e-12);
}

/// A second, incommensurable tone is motion of no period; without a declared noise nothing is said about it.
#[test]
fn a_quasi_periodic_run_is_not_periodic() {
    let run = run_of(|t| phase(t).cos() + 0.2 * (TAU * 31.4159 * t).sin());
    let declared = Sensors { noise_std: Some(vec![0.003; 2]), ..sensors() };
    assert_eq!(judge(&run, &declared).unwrap().periodic, Some(false));
    assert_eq!(judge(&run, &sensors()).unwrap().periodic, None);
    assert_eq!(judge(&run_of(|t| phase(t).cos()), &declared).unwrap().periodic, Some(true));
}
