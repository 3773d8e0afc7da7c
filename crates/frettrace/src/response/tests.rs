use super::*;
use crate::rig::parse_rig;
use crate::rig::tests::RIG;
use frettrace_friction::Law;
use std::path::Path;

fn rig(text: &str) -> Rig {
    parse_rig(text, Path::new("RIG.toml")).unwrap()
}

/// The first point of the sweep is the rig's own run: accelerations are those of the time march. 1024 samples at 8192 Hz
/// hold 13 periods of 104 Hz.
#[test]
fn the_response_is_the_simulation() {
    let rig = rig(&RIG.replace("noise_std_m_per_s2 = 0.05", "noise_std_m_per_s2 = 0.0"));
    let options =
        ResponseOptions { range_hz: Some([104.0, 110.0]), order: Some(31), ..ResponseOptions::default() };
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

/// The rig with another law and its parameters.
fn with_law(law: Law, values: &[f64]) -> Rig {
    let keys = law.parameters().iter().map(crate::rig::parameter_key);
    let lines: String = keys.zip(values).map(|(key, value)| format!("{key} = {value:e}\n")).collect();
    let dahl = "sigma0_per_m = 5.0e5\nmu_k = 0.25\nexponent = 1.0\n";
    let text = RIG.replace("law = \"dahl\"", &format!("law = \"{}\"", law.name()));
    rig(&text.replace(dahl, &lines).replace("noise_std_m_per_s2 = 0.05", "noise_std_m_per_s2 = 0.0"))
}

/// Every law of the catalogue is followed to the end of the range, but for one that is refused, and one whose force falls from μ_s N
/// to μ_k N where it breaks away, with no motion beside it: on the level at which that begins there is no curve to follow.
#[test]
fn every_law_has_a_response() {
    let options =
        ResponseOptions { range_hz: Some([100.0, 110.0]), stability: false, ..ResponseOptions::default() };
    let mut unfinished = Vec::new();
    for law in Law::ALL {
        let rig = with_law(*law, &law.example());
        let found = match response(&rig, &options, &Progress::silent()) {
            Ok(found) => found,
            Err(error) => {
                let message = error.to_string();
                assert!(*law == Law::Fbfm && message.contains("support.law is fbfm"), "{message}");
                assert_eq!(message.lines().count(), 1);
                continue;
            }
        };
        for level in &found.levels {
            assert!(!level.points.is_empty(), "{}", law.name());
            if level.status != "finished" {
                unfinished.push((law.name(), level.force_amplitude_n, level.status));
            }
        }
    }
    let breaks_away = [("sdfm", 1.0, "stalled")];
    assert!(unfinished.iter().all(|ended| breaks_away.contains(ended)), "{unfinished:?}");
}

/// The order follows the truncation asked, point by point, and the highest lines change the motion by no more than it says.
#[test]
fn the_order_follows_the_truncation() {
    let rig = with_law(Law::Jenkins, &[3.0e7, 0.25]);
    let range_hz = Some([100.0, 110.0]);
    let follow = |truncation, order| {
        let options = ResponseOptions { range_hz, truncation, order, stability: false };
        response(&rig, &options, &Progress::silent()).unwrap()
    };
    let [coarse, fine] = [follow(1e-2, None), follow(1e-4, None)];
    let orders = |found: &FrequencyResponse| -> Vec<usize> {
        found.levels.iter().flat_map(|level| level.points.iter().map(|point| point.order)).collect()
    };
    assert!(orders(&coarse).iter().max() < orders(&fine).iter().max());
    assert!(orders(&fine).iter().min() < orders(&fine).iter().max(), "one order for all points");
    for (found, truncation) in [(&coarse, 1e-2), (&fine, 1e-4)] {
        assert!(
            found.levels.iter().all(|level| level.status == "finished" && level.truncation <= truncation)
        );
    }
    // The curve starts at a given frequency: there the slip of order 63 is the reference.
    let reference = follow(1e-3, Some(63));
    for (found, truncation) in [(&coarse, 1e-2), (&fine, 1e-4)] {
        for (level, exact) in found.levels.iter().zip(&reference.levels) {
            let error = level.points[0].slip_m / exact.points[0].slip_m - 1.0;
            // The whole answers what is cut off, amplified by at most a few.
            assert!(error.abs() < 5.0 * truncation, "{error:e} {truncation:e}");
        }
    }
}

/// Laws of other families against the time march of the same rig, on the run's own frequency: 13 periods in 1024 samples.
#[test]
fn laws_of_other_families_answer_as_the_simulation() {
    let options = ResponseOptions {
        range_hz: Some([104.0, 106.0]),
        order: Some(31),
        stability: false,
        ..ResponseOptions::default()
    };
    for (law, values) in [
        (Law::Jenkins, vec![3.0e7, 0.25]),
        (Law::Iwan, vec![5.0e5, 0.25, -0.5, 0.5]),
        (Law::BoucWen, vec![5.0e5, 0.25, 1.5, 0.7]),
        (Law::MaxwellSlip, vec![2.0e5, 1.5e5, 1.0e5, 5.0e4, 0.05, 0.1, 0.07, 0.06]),
    ] {
        let rig = with_law(law, &values);
        let found = response(&rig, &options, &Progress::silent()).unwrap();
        let simulated = simulate::simulate(&rig, &Progress::silent()).unwrap();
        for (level, run) in found.levels.iter().zip(&simulated.measurement.runs) {
            assert_eq!(level.status, "finished", "{}", law.name());
            for (sensor, expected) in level.points[0].acceleration_m_per_s2.iter().enumerate() {
                let square: f64 = run.acceleration[sensor].iter().map(|a| a * a).sum::<f64>() / 1024.0;
                let error = square.sqrt() / expected - 1.0;
                // The recording filters what lies above half its rate, the balance what lies above order 31.
                assert!(error.abs() < 2e-3, "{} {sensor}: {error:e}", law.name());
            }
        }
    }
}
