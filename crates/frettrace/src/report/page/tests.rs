use super::*;
use crate::results::{Candidate, ContactCurve, ContactLoop, Effect, Exhibits, Waveform};

fn found() -> Explanation {
    let x: Vec<f64> = (0..64).map(|k| f64::from(k) * 0.1).collect();
    let y: Vec<f64> = x.iter().map(|x| x.sin()).collect();
    let contact = ContactLoop {
        run: "0003".into(),
        slip_unit: "m".into(),
        measured: ContactCurve {
            slip: x.clone(),
            slip_velocity: x.clone(),
            force: y.clone(),
            energy_per_cycle_j: 0.0125,
        },
        ..ContactLoop::default()
    };
    let waveform = Waveform {
        run: "0003".into(),
        channel: "acceleration of sensor 0 [m/s²]".into(),
        time: x,
        measured: y.clone(),
        before: y.clone(),
        after: y,
        ..Waveform::default()
    };
    let mut baseline = Identification { law: "dahl".into(), ..Identification::default() };
    let estimate = Estimate {
        value: 1.5e5,
        std: 1e3,
        interval95: [f64::NEG_INFINITY, 1.6e5],
        unit: "1/m".into(),
        identifiable: false,
    };
    baseline.parameters.insert("sigma0".into(), estimate);
    Explanation {
        verdict: Verdict::Explained,
        effects: vec![Effect { id: "friction.<b>".into(), ..Effect::default() }],
        candidates: vec![Candidate { id: "friction.stribeck".into(), error: 0.01, evidence: 120.0 }],
        error: BeforeAfter { before: 0.1, after: f64::NAN, noise_floor: 0.01, ..BeforeAfter::default() },
        exhibits: Exhibits { loops: vec![contact], waveforms: vec![waveform], residual: vec![] },
        baseline,
        ..Explanation::default()
    }
}

/// The page holds every part, refers to nothing outside itself, and what comes from a file cannot become markup.
#[test]
fn the_page_is_complete_and_stands_alone() {
    let page = html("Rig & run", &found());
    for part in
        ["Rig &amp; run", "Error before and after", "Friction loops", "Evidence", "not determined", "12.50"]
    {
        assert!(page.contains(part), "{part}");
    }
    assert_eq!(page.matches("<svg").count(), 4, "two loops, a signal and its residual");
    assert!(!page.contains("<b>") && !page.contains("<script"));
    assert!(!page.contains("src=") && !page.contains("@import") && !page.contains("url("));
    // The only address is the name of SVG's namespace.
    assert_eq!(page.matches("http").count(), page.matches("http://www.w3.org/2000/svg").count());
}

/// An undefined number appears as such, never as NaN.
#[test]
fn undefined_numbers_are_said_in_words() {
    let page = html("x", &found());
    assert!(page.contains("unknown") && page.contains("not determined") && !page.contains("NaN"));
}
