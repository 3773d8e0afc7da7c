//! The map in ARCHITECTURE.md against the manifests.

use std::collections::BTreeSet;
use validation::architecture::{between, drawing, edges, written};

const ARCHITECTURE: &str = include_str!("../../ARCHITECTURE.md");

/// The manifests have exactly the edges of the list: a new edge is first written down, with its reason.
#[test]
fn edges_are_those_written_down() {
    let (used, _) = edges().unwrap();
    assert_eq!(used.len(), 9, "crates under crates/");
    assert_eq!(used, written(ARCHITECTURE));
}

/// Tests may use `forward` besides, and nothing else.
#[test]
fn tests_may_use_the_forward_model_only() {
    let allowed = BTreeSet::from(["frettrace-forward".to_owned()]);
    let (used, tested) = edges().unwrap();
    for (name, targets) in tested {
        let beyond: Vec<_> =
            targets.difference(&used[&name]).filter(|target| !allowed.contains(*target)).collect();
        assert!(beyond.is_empty(), "{name} uses {beyond:?} in its tests");
    }
}

/// The forbidden edges by name, should somebody change list and manifest together.
#[test]
fn forbidden_edges_do_not_exist() {
    let (used, _) = edges().unwrap();
    let forbidden = [
        ("frettrace-inverse", "frettrace-friction"),
        ("frettrace-inverse", "frettrace-measurement"),
        ("frettrace-friction", "frettrace-beam"),
        ("frettrace-friction", "frettrace-fourier"),
        ("frettrace-identify", "frettrace-beam"),
        ("frettrace-identify", "frettrace-measurement"),
        ("frettrace-identify", "frettrace-forward"),
    ];
    for (from, to) in forbidden {
        assert!(!used[from].contains(to), "{from} -> {to}");
    }
}

/// The drawing is the one the manifests give.
#[test]
fn the_drawing_matches() {
    let expected = format!("\n```mermaid\n{}```\n", drawing(&edges().unwrap().0));
    assert_eq!(between(ARCHITECTURE, "drawing"), expected, "the drawing should be:\n{expected}");
}
