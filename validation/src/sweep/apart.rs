//! A set in a process of its own, which can be stopped: one that never answers must not hold up the others.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

/// The line a process prints when its set is made and the question is put.
pub const MADE: &str = "made";

/// A set that could not be made in time: nothing was asked of it.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("not made within {} s", .0.as_secs())]
pub struct NotMade(pub Duration);

/// What a program prints on one core after the line [`MADE`]; it has a limit for coming there and one for the answer.
///
/// # Errors
/// [`NotMade`], or where it cannot be run, fails, or does not answer in time.
pub fn printed(mut program: Command, [making, answering]: [Duration; 2]) -> anyhow::Result<String> {
    let mut child = program.env("RAYON_NUM_THREADS", "1").stdout(Stdio::piped()).spawn()?;
    let out = child.stdout.take();
    let (sender, lines) = mpsc::channel();
    thread::spawn(move || {
        let lines = out.into_iter().flat_map(|out| BufReader::new(out).lines()).map_while(Result::ok);
        // Whoever has stopped the program listens no more.
        lines.map(|line| sender.send(line)).take_while(Result::is_ok).for_each(drop);
    });
    let (mut text, mut begun, mut asked) = (String::new(), Instant::now(), false);
    loop {
        let limit = if asked { answering } else { making };
        match lines.recv_timeout(limit.saturating_sub(begun.elapsed())) {
            Ok(line) if line == MADE => (begun, asked) = (Instant::now(), true),
            Ok(line) => text += &(line + "\n"),
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {
                child.kill()?;
                child.wait()?;
                anyhow::ensure!(asked, NotMade(limit));
                anyhow::bail!("no answer within {} s", limit.as_secs());
            }
        }
    }
    let status = child.wait()?;
    anyhow::ensure!(status.success(), "broke off: {status}");
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn a_program_that_does_not_end_is_stopped() {
        let (long, short) = (Duration::from_secs(20), Duration::from_millis(200));
        assert_eq!(printed(shell("echo made; echo $RAYON_NUM_THREADS"), [long; 2]).unwrap(), "1\n");
        assert!(printed(shell("exit 3"), [long; 2]).unwrap_err().to_string().contains('3'));
        let begun = Instant::now();
        let stopped = printed(shell("echo made; exec sleep 60"), [long, short]).unwrap_err();
        assert!(stopped.to_string().starts_with("no answer") && begun.elapsed() < long, "{stopped}");
        let unmade = printed(shell("exec sleep 60"), [short, long]).unwrap_err();
        assert_eq!(unmade.downcast_ref(), Some(&NotMade(short)));
    }
}
