//! The map of the crates, from `cargo metadata`.

use std::collections::{BTreeMap, BTreeSet};

/// Edges from each crate of ours to others of ours.
pub type Edges = BTreeMap<String, BTreeSet<String>>;

/// Why there is no map.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// `cargo metadata` failed.
    #[error("cargo metadata: {0}")]
    Metadata(#[from] cargo_metadata::Error),
}

/// Edges of the crates under `crates/`: what they depend on when they are used, and in tests besides.
///
/// # Errors
/// [`MapError`] when `cargo metadata` fails.
pub fn edges() -> Result<(Edges, Edges), MapError> {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml");
    let metadata = cargo_metadata::MetadataCommand::new().manifest_path(manifest).no_deps().exec()?;
    let (mut used, mut tested) = (Edges::new(), Edges::new());
    for package in metadata.packages.iter().filter(|package| package.name.starts_with("frettrace")) {
        let ours = |kind: cargo_metadata::DependencyKind| -> BTreeSet<String> {
            let of_kind = package.dependencies.iter().filter(|dependency| dependency.kind == kind);
            of_kind.map(|d| d.name.clone()).filter(|name| name.starts_with("frettrace")).collect()
        };
        used.insert(package.name.to_string(), ours(cargo_metadata::DependencyKind::Normal));
        tested.insert(package.name.to_string(), ours(cargo_metadata::DependencyKind::Development));
    }
    Ok((used, tested))
}

/// The list of edges written in ARCHITECTURE.md.
#[must_use]
pub fn written(architecture: &str) -> Edges {
    let full = |name: &str| {
        if name.starts_with("frettrace") { name.to_owned() } else { format!("frettrace-{name}") }
    };
    between(architecture, "edges")
        .lines()
        .filter_map(|line| line.split_once("->"))
        .map(|(from, to)| (from.trim().to_owned(), to.split_whitespace().map(full).collect()))
        .collect()
}

/// The text between `<!-- name -->` and `<!-- /name -->`.
#[must_use]
pub fn between<'a>(text: &'a str, name: &str) -> &'a str {
    let after = text.split_once(&format!("<!-- {name} -->")).map_or("", |(_, after)| after);
    after.split_once(&format!("<!-- /{name} -->")).map_or("", |(inside, _)| inside)
}

/// The drawing: every edge that no path of other edges implies.
#[must_use]
pub fn drawing(edges: &Edges) -> String {
    let mut text = String::from("graph TD\n");
    for (from, targets) in edges {
        for to in targets {
            let implied = targets.iter().any(|via| via != to && reaches(edges, via, to));
            if !implied {
                text += &format!("  {} --> {}\n", short(from), short(to));
            }
        }
    }
    text
}

fn short(name: &str) -> &str {
    name.strip_prefix("frettrace-").unwrap_or(name)
}

fn reaches(edges: &Edges, from: &str, to: &str) -> bool {
    edges.get(from).is_some_and(|next| next.iter().any(|via| via == to || reaches(edges, via, to)))
}
