//! Progress of long steps: a bar on a terminal, nothing in a pipe.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Where a study tells how far it is. Shared freely between threads; draws on standard error, and only on a terminal.
#[derive(Clone, Debug)]
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar on standard error where that is a terminal, nothing otherwise.
    #[must_use]
    pub fn terminal() -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        if let Ok(style) = ProgressStyle::with_template("{msg:24} {bar:32} {pos}/{len} {elapsed}") {
            bar.set_style(style);
        }
        Self { bar }
    }

    /// No output at all.
    #[must_use]
    pub fn silent() -> Self {
        Self { bar: ProgressBar::hidden() }
    }

    /// A step of `steps` equal parts begins.
    pub fn start(&self, steps: u64, what: &str) {
        self.bar.reset();
        self.bar.set_length(steps);
        self.bar.set_message(what.to_owned());
    }

    /// One part is done.
    pub fn step(&self) {
        self.bar.inc(1);
    }

    /// A line for the person who watches; it is dropped where no bar is drawn.
    pub fn note(&self, line: &str) {
        self.bar.println(line);
    }

    /// Does what must not be painted over by the bar.
    pub fn suspend<T>(&self, act: impl FnOnce() -> T) -> T {
        self.bar.suspend(act)
    }

    /// All is done; the bar disappears.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A silent progress counts all the same, from several threads.
    #[test]
    fn parts_are_counted_from_several_threads() {
        let progress = Progress::silent();
        progress.start(8, "counting");
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| progress.step());
            }
        });
        assert_eq!(progress.bar.position(), 8);
        assert!(progress.bar.is_hidden());
    }
}
