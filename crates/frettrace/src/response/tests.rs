use super::*;
use crate::rig::parse_rig;
use crate::rig::tests::RIG;
use std::path::Path;

fn rig(text: &str) -> Rig {
    parse_rig(text, Path::new("RIG.toml")).unwrap()
}

/// The first point of the sweep is the rig's own run: accelerations are those of the time march. 1024 samples at 8192 Hz
/// hold 13 periods of 104 Hz.
#[test]
fn the_response_is_the_simulation() {
    let rig = rig(&RIG.replace("noise_std_m_per_s2 = 0.05", "noise_std_m_per_s2 = 0.0"));
    let options = ResponseOptions { range_hz: Some([104.0, 110.0]), order: 31, stability: true };
    let found = response(&rig, &options, &Progress::silent()).unwrap();
    let simulated = simulate::simulate(&rig, &Progress::silent()).unwrap();
    for (level, run) in found.levels.iter().zip(&simulated.measurement.runs) {
        assert_eq!(level.status, "finished");
        for (sensor, expected) in level.points[0].acceleration_m_per_s2.iter().enumerate() {
            let square: f64 = run.acceleration[sensor].iter().map(|a| a * a).sum::<f64>() / 1024.0;
            // The recording filters what lies above half its rate, the balance what lies above order 31.
            assert!((square.sqrt() / expected - 1.0).abs() < 2e-3, "{} {expected}", square.sqrt());
        }
        assert!(level.points.iter().all(|point| point.stable == Some(true)));
    }
}

/// The backbone runs from the stuck contact to the sliding one: frequency falls, damping rises and falls again.
#[test]
fn the_backbone_softens() {
    let found = response(&rig(RIG), &ResponseOptions::default(), &Progress::silent()).unwrap();
    let backbone = &found.backbone;
    assert!(backbone.len() > 10);
    assert!(backbone.first().unwrap().frequency_hz > backbone.last().unwrap().frequency_hz);
    // Never below the structure's own damping of 2 %.
    assert!(backbone.iter().all(|point| point.damping_ratio > 0.019));
}

#[test]
fn what_is_not_periodic_is_refused() {
    let effect = "\n[[effect]]\nid = \"structure.frequency-drift\"\nrelative_change = 0.01\n";
    let refused = response(&rig(&format!("{RIG}{effect}")), &ResponseOptions::default(), &Progress::silent());
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("structure.frequency-drift"), "{message}");
}

/// A law without a bristle would otherwise be answered as another one.
#[test]
fn laws_that_are_not_followed_are_refused() {
    let text = RIG
        .replace("law = \"dahl\"", "law = \"jenkins\"")
        .replace("sigma0_per_m = 5.0e5", "tangential_stiffness_n_per_m = 1.0e5")
        .replace("exponent = 1.0\n", "");
    let refused = response(&rig(&text), &ResponseOptions::default(), &Progress::silent());
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("jenkins") && message.contains("support.law"), "{message}");
}
