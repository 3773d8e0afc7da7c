//! A set in a process of its own, which can be stopped: one that never answers must not hold up the others.

use std::io::Read;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// How often a process is looked after.
const LOOK: Duration = Duration::from_millis(50);

/// What a program prints on one core within a limit.
///
/// # Errors
/// Where it cannot be run, fails, or takes longer.
pub fn printed(mut program: Command, limit: Duration) -> anyhow::Result<String> {
    let mut child = program.env("RAYON_NUM_THREADS", "1").stdout(Stdio::piped()).spawn()?;
    let begun = Instant::now();
    let status = loop {
        match child.try_wait()? {
            Some(status) => break status,
            None if begun.elapsed() > limit => {
                child.kill()?;
                child.wait()?;
                anyhow::bail!("no answer within {} s", limit.as_secs());
            }
            None => thread::sleep(LOOK),
        }
    };
    let mut text = String::new();
    child.stdout.take().map(|mut out| out.read_to_string(&mut text)).transpose()?;
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
        let long = Duration::from_secs(20);
        assert_eq!(printed(shell("echo $RAYON_NUM_THREADS"), long).unwrap(), "1\n");
        assert!(printed(shell("exit 3"), long).unwrap_err().to_string().contains('3'));
        let begun = Instant::now();
        let stopped = printed(shell("exec sleep 60"), Duration::from_millis(200)).unwrap_err();
        assert!(stopped.to_string().starts_with("no answer") && begun.elapsed() < long, "{stopped}");
    }
}
