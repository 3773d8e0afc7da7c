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
/// to μ_k N where it breaks away: on the level at which that begins the curve ends, and says why.
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
    assert_eq!(unfinished, [("sdfm", 1.0, JUMPED)]);
}

/// A contact that sticks on a spring and breaks away at μ_s N = 6 N, to slide at 4 N: its curve ends where the force of the spring, a sinusoid
/// of one line, has reached 6 N, and not before. The march of the same rig still sticks 0.2 Hz below, with a force that is a sinusoid, and slides
/// 0.2 Hz above, with one that is not: there is no motion between them.
#[test]
fn a_curve_ends_where_the_force_jumps() {
    let law =
        "tangential_stiffness_n_per_m = 5e7\ntangential_damping_n_s_per_m = 100.0\nmu_s = 0.6\nmu_k = 0.4\n";
    let text = RIG
        .replace(
            "slip = \"rotation\"\nlever_arm_m = 0.0037\nnormal_stiffness_n_per_m = 5.0e6\n",
            "slip = \"transverse\"\n",
        )
        .replace("law = \"dahl\"", "law = \"sdfm\"")
        .replace("sigma0_per_m = 5.0e5\nmu_k = 0.25\nexponent = 1.0\n", law)
        .replace("preload_n = 70.0", "preload_n = 10.0")
        .replace("[1.0, 8.0]", "[0.5]");
    let range_hz = Some([100.0, 118.0]);
    let options = ResponseOptions { range_hz, stability: false, ..ResponseOptions::default() };
    let found = response(&rig(&text), &options, &Progress::silent()).unwrap();
    let level = &found.levels[0];
    let end = level.points.last().unwrap();
    assert_eq!(level.status, JUMPED);
    // The steps end at 1e-7 of the range of 18 Hz, over which the force grows about tenfold; 128 samples a period see its peak to 3e-4.
    assert!((end.friction_force_n / 6.0 - 1.0).abs() < 3e-4, "{end:?}");
    assert!(
        level.points.iter().all(|point| point.friction_force_n <= end.friction_force_n),
        "it sticks all along"
    );
    // Crest of the force: largest over root mean square, √2 of a sinusoid.
    let crest = |hertz: f64| {
        let beside = text.replace("frequency_hz = 104.0", &format!("frequency_hz = {hertz}"));
        let made = simulate::simulate(&rig(&beside), &Progress::silent()).unwrap();
        let samples = &made.truth.runs[0].friction_force;
        let square = samples.iter().map(|f| f * f).sum::<f64>() / samples.len() as f64;
        samples.iter().fold(0.0_f64, |most, f| most.max(f.abs())) / square.sqrt()
    };
    let [below, above] = [-0.2, 0.2].map(|step| crest(end.frequency_hz + step));
    // The record of 13.2 periods is no whole number of them.
    assert!((below / 2.0_f64.sqrt() - 1.0).abs() < 0.02, "{below}");
    assert!(above > 1.06 * below, "{below} {above}");
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
