use super::*;
use crate::results::{
    Amplitudes, Candidate, ChannelSpectrum, ContactCurve, ContactLoop, Effect, Exhibits, ResidualMap,
    ResidualShape, Waveform,
};

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
    let amplitudes = || Amplitudes { frequency: vec![1.0, 2.0], amplitude: vec![0.1, 0.01] };
    let spectrum = ChannelSpectrum {
        run: "0003".into(),
        channel: "acceleration of sensor 0 [m/s²]".into(),
        measured: amplitudes(),
        floor_name: "noise floor (declared)".into(),
        floor: amplitudes(),
        before: amplitudes(),
        after: amplitudes(),
        ..ChannelSpectrum::default()
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
        exhibits: Exhibits {
            loops: vec![contact],
            waveforms: vec![waveform],
            spectra: vec![spectrum],
            ..Exhibits::default()
        },
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
    assert_eq!(page.matches("<svg").count(), 5, "two loops, a signal, its residual and its spectrum");
    assert!(page.contains("noise floor (declared)") && page.contains("left with the effects"));
    assert!(!page.contains("<b>") && !page.contains("<script"));
    assert!(!page.contains("src=") && !page.contains("@import") && !page.contains("url("));
    // The only address is the name of SVG's namespace.
    assert_eq!(page.matches("http").count(), page.matches("http://www.w3.org/2000/svg").count());
}

/// Whether a force was measured or recovered is said by what the file holds, not by what the errors are errors of: those of runs without a period are
/// errors of a force that was recovered.
#[test]
fn recovered_forces_are_not_called_measured() {
    let mut found = found();
    found.baseline.error.force = Some(0.1);
    let recovered = html("x", &found);
    assert!(
        recovered.contains("<th>recovered</th>") && recovered.contains("cannot be seen by accelerometers")
    );
    found.exhibits.contact_is_measured = true;
    let measured = html("x", &found);
    assert!(measured.contains("<th>measured</th>") && measured.contains("load cell"));
}

/// An undefined number appears as such, never as NaN.
#[test]
fn undefined_numbers_are_said_in_words() {
    let page = html("x", &found());
    assert!(page.contains("unknown") && page.contains("not determined") && !page.contains("NaN"));
}

/// With what the residual depends on, and a verdict that leaves it open.
fn open() -> Explanation {
    let mut open = Explanation { verdict: Verdict::Unexplained, ..found() };
    let shape = |against: &str| ResidualShape {
        against: against.into(),
        unit: "1".into(),
        centre: vec![0.25, 0.75],
        before: vec![3.0, 9.0],
        after: vec![2.0, 4.0],
    };
    open.exhibits.residual =
        ["slip", "slip velocity", "normal force", "phase", "time", "level", "sensor"].map(shape).into();
    open.exhibits.maps = vec![ResidualMap {
        across: "phase".into(),
        x: vec![0.25, 0.75],
        up: "level".into(),
        y: vec![1.0, 2.0],
        before: vec![vec![3.0, 9.0]; 2],
        after: vec![vec![2.0, 4.0]; 2],
        ..ResidualMap::default()
    }];
    open
}

/// Everything a person decides by, in the order it is read; the residual's shape in plots, maps and numbers.
#[test]
fn the_page_holds_what_a_decision_needs() {
    let page = html("x", &open());
    let heads: Vec<&str> = page.split("<h2>").skip(1).filter_map(|rest| rest.split("</h2>").next()).collect();
    let expected = [
        "Error before and after",
        "Friction loops",
        "Signals and residuals",
        "Spectra",
        "Shape of the residual",
        "Energy per cycle",
        "Evidence of all candidates",
        "Parameters with intervals",
        "What this rests on",
    ];
    assert_eq!(heads, expected);
    for quantity in ["slip", "slip velocity", "normal force", "phase", "time", "level", "sensor"] {
        assert!(page.contains(&format!("aria-label=\"Residual against {quantity}\"")), "{quantity}");
        assert!(page.contains(&format!("<tr><td>{quantity}</td><td>3.000</td><td>9.000</td>")), "{quantity}");
    }
    for map in ["phase and level, declared model", "phase and level, with the effects"] {
        assert!(page.contains(&format!("aria-label=\"Residual over {map}\"")), "{map}");
    }
    assert!(page.contains("<p>What is left changes most with sensor: 2.000 to 4.000"), "{page}");
}

/// What a browser would stumble over: every element is closed, every table may scroll on a phone, no picture has a size of its own,
/// and the page says how it looks in the dark and on paper.
#[test]
fn the_page_is_sound_without_a_browser() {
    let page = html("x", &open());
    for tag in [
        "html", "head", "body", "style", "div", "table", "tr", "td", "th", "p", "ul", "li", "svg", "text",
        "details",
    ] {
        let opened = page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count();
        assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "{tag}");
    }
    assert_eq!(page.matches("<table").count(), page.matches("<div class=\"scroll\"><table").count());
    assert_eq!(page.matches("<svg role=\"img\"").count(), page.matches("<svg").count());
    for style in [
        "@media (prefers-color-scheme: dark)",
        "@media print",
        "break-inside: avoid",
        "break-after: avoid",
        "name=\"viewport\" content=\"width=device-width",
    ] {
        assert!(page.contains(style), "{style}");
    }
    // Colours of pictures come from the page, so that they can be read in the dark; only maps have their own.
    let fixed = page
        .split("#")
        .skip(1)
        .filter(|rest| rest.len() > 6 && rest.as_bytes()[..6].iter().all(|b| b.is_ascii_hexdigit()));
    let in_pictures = fixed.filter(|rest| rest.as_bytes().get(6) == Some(&b'"')).count();
    assert_eq!(in_pictures, 2 * (4 + 48), "cells and scale of two maps");
}
