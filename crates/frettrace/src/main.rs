//! The program `frettrace`: arguments in, results out; everything between is the library's.

mod commands;

use clap::Parser;
use std::process::ExitCode;

/// Exit code 0: done; 1: the data or a file is at fault, told in one line; 2: usage (clap ends with it by itself).
fn main() -> ExitCode {
    match commands::run(commands::Program::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if commands::reader_has_gone(&error) => ExitCode::SUCCESS,
        Err(error) => {
            // Every message of ours holds its cause already.
            let line = error.to_string().replace('\n', " ");
            eprintln!("frettrace: {line}");
            ExitCode::FAILURE
        }
    }
}
