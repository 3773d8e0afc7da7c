//! The commands, one file each: arguments, one call into the library, the answer.

mod convert;
mod demo;
mod explain;
mod identify;
mod inspect;
mod modes;
mod plot;
mod reconstruct;
mod response;
mod simulate;
mod tables;

use clap::{Parser, Subcommand};
use frettrace::Progress;
use serde::Serialize;
use std::io::Write;

/// From accelerometers on a beam to the friction at its support: contact forces, friction law, and what the model
/// lacks.
#[derive(Parser, Debug)]
#[command(version, propagate_version = true, after_help = "Start with:  frettrace demo")]
pub struct Program {
    #[command(subcommand)]
    command: Command,
    /// Print the result as JSON on standard output and nothing else there
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Subcommand, Debug)]
enum Command {
    Demo(demo::Arguments),
    Inspect(inspect::Arguments),
    Modes(modes::Arguments),
    Convert(convert::Arguments),
    Simulate(simulate::Arguments),
    Response(response::Arguments),
    Reconstruct(reconstruct::Arguments),
    Identify(identify::Arguments),
    Explain(explain::Arguments),
    Plot(plot::Arguments),
}

/// Runs one command.
pub fn run(program: Program) -> anyhow::Result<()> {
    let session = Session { json: program.json, progress: Progress::terminal() };
    match &program.command {
        Command::Demo(_) => demo::run(&session),
        Command::Convert(arguments) => convert::run(arguments, &session),
        Command::Explain(arguments) => explain::run(arguments, &session),
        Command::Identify(arguments) => identify::run(arguments, &session),
        Command::Inspect(arguments) => inspect::run(arguments, &session),
        Command::Modes(arguments) => modes::run(arguments, &session),
        Command::Plot(arguments) => plot::run(arguments, &session),
        Command::Reconstruct(arguments) => reconstruct::run(arguments, &session),
        Command::Response(arguments) => response::run(arguments, &session),
        Command::Simulate(arguments) => simulate::run(arguments, &session),
    }
}

/// What all commands share.
struct Session {
    json: bool,
    progress: Progress,
}

impl Session {
    /// A line for the person who watches, on standard error.
    fn log(&self, line: &str) {
        self.progress.suspend(|| eprintln!("{line}"));
    }

    /// The answer on standard output: `result` as JSON where that was asked for, else `text`.
    fn answer(&self, result: &impl Serialize, text: &str) -> anyhow::Result<()> {
        self.progress.finish();
        let mut out = std::io::stdout().lock();
        if self.json {
            serde_json::to_writer_pretty(&mut out, result)?;
            writeln!(out)?;
        } else {
            writeln!(out, "{}", text.trim_end())?;
        }
        Ok(out.flush()?)
    }
}

/// Whether whoever read our output stopped reading (`frettrace … | head`): no fault of ours.
pub fn reader_has_gone(error: &anyhow::Error) -> bool {
    let broken = |error: &std::io::Error| error.kind() == std::io::ErrorKind::BrokenPipe;
    error.chain().any(|cause| {
        cause.downcast_ref::<std::io::Error>().is_some_and(broken)
            || cause
                .downcast_ref::<serde_json::Error>()
                .is_some_and(|error| error.io_error_kind() == Some(std::io::ErrorKind::BrokenPipe))
    })
}
