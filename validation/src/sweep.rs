//! The sweep: many rigs with a known truth through the whole program, and what became of them.
//!
//! `cargo run -p validation -- sweep --output FILE` makes rigs at random from a seed, simulates each ([`rigs`], [`effects`],
//! [`made`], [`kept`]), asks `explain` what it lacks and compares ([`judged`]); one line of JSON a finished set, so that a sweep that was
//! stopped goes on where it was, each set in a process of its own ([`apart`]). [`tables`] counts.

pub mod apart;
pub mod coverage;
pub mod effects;
pub mod judged;
pub mod kept;
pub mod made;
pub mod mended;
pub mod plan;
pub mod rigs;
pub mod tables;

use anyhow::Context;
use frettrace::Progress;
use rayon::ThreadPoolBuilder;
use serde::{Serialize, de::DeserializeOwned};
use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::num::NonZero;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// The seed of the plan that is reported, …
pub const SEED: u64 = 261;
/// … and its clean sets.
pub const CLEAN: usize = 200;

/// A finished set, one line of a file.
pub trait Finished: Serialize + DeserializeOwned + Send {
    /// Name of the set in the plan.
    fn name(&self) -> &str;
}

/// Reads the finished sets of a file; none where there is no file. A last line cut off by a stop is dropped.
///
/// # Errors
/// Where the file cannot be read.
pub fn read<T: Finished>(path: &Path) -> anyhow::Result<Vec<T>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let lines = BufReader::new(File::open(path)?).lines().collect::<Result<Vec<_>, _>>()?;
    Ok(lines.iter().filter_map(|line| serde_json::from_str(line).ok()).collect())
}

/// Runs what a file does not have yet, in parallel, and appends each set when it is done.
///
/// # Errors
/// Where the file cannot be read or written.
pub fn resume<P: Sync, T: Finished>(
    path: &Path,
    plan: &[P],
    name: impl Fn(&P) -> &str + Sync,
    run: impl Fn(&P) -> T + Sync,
) -> anyhow::Result<Vec<T>> {
    let done: BTreeSet<String> = read::<T>(path)?.iter().map(|set| set.name().to_owned()).collect();
    let open: Vec<&P> = plan.iter().filter(|set| !done.contains(name(set))).collect();
    let file = OpenOptions::new().create(true).append(true).open(path);
    let file = Mutex::new(file.with_context(|| format!("{} cannot be written", path.display()))?);
    let progress = Progress::terminal();
    progress.start(open.len() as u64, "sweeping");
    let next = AtomicUsize::new(0);
    let work = || -> anyhow::Result<()> {
        // A pool of its own, of one thread: a worker of a common pool would begin other sets while it waits for parts of one.
        let alone = ThreadPoolBuilder::new().num_threads(1).build()?;
        while let Some(set) = open.get(next.fetch_add(1, Ordering::Relaxed)) {
            let line = serde_json::to_string(&alone.install(|| run(set)))? + "\n";
            // A whole line at once: a thread that panicked elsewhere cannot have left half of one.
            file.lock().unwrap_or_else(PoisonError::into_inner).write_all(line.as_bytes())?;
            progress.step();
        }
        Ok(())
    };
    let workers = thread::available_parallelism().map_or(1, NonZero::get);
    thread::scope(|scope| {
        let begun: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        begun.into_iter().try_for_each(|worker| {
            worker.join().unwrap_or_else(|_| Err(anyhow::anyhow!("a set of the sweep broke off")))
        })
    })?;
    progress.finish();
    read(path)
}
