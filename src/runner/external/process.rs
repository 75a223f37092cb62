//! A program in a folder of its own: it ends with all that it started, in time and with bounded output.

use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Most bytes of what a program writes to one stream.
pub(super) const MOST_BYTES: u64 = 64 << 20;
/// First and longest pause between two looks at the program.
const FIRST_LOOK: Duration = Duration::from_micros(200);
const LONGEST_LOOK: Duration = Duration::from_millis(10);

/// How a program ended.
pub enum End {
    /// By itself.
    Exited(ExitStatus),
    /// It took too long.
    TimedOut,
    /// It wrote more than it may.
    WroteTooMuch,
    /// The run was left.
    Left,
}

/// A program with all that it started; dropped, it is ended.
struct Group {
    child: Child,
    is_reaped: bool,
}

impl Group {
    /// Whether the program has ended; what it started may go on.
    fn has_ended(&mut self) -> std::io::Result<bool> {
        use rustix::process::{Pid, WaitId, WaitIdOptions, waitid};
        let Some(pid) = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw) else { return Ok(false) };
        // It is left as it is, so that its group keeps its number.
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        Ok(waitid(WaitId::Pid(pid), options)?.is_some())
    }

    /// Ends the whole group, and gives how the program ended.
    fn end(&mut self) -> std::io::Result<ExitStatus> {
        use rustix::process::{Pid, Signal, kill_process_group};
        if let Some(pid) = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw).filter(|_| !self.is_reaped) {
            // There may be none left.
            let _ = kill_process_group(pid, Signal::KILL);
        }
        self.is_reaped = true;
        self.child.wait()
    }
}

impl Drop for Group {
    fn drop(&mut self) {
        if !self.is_reaped {
            let _ = self.end();
        }
    }
}

/// Runs a program whose streams go into these files, which are there already.
///
/// # Errors
/// The system does not start it, or does not tell how it ended.
pub fn run(
    mut command: Command,
    output: &Path,
    errors: &Path,
    timeout: Duration,
    is_over: &dyn Fn() -> bool,
) -> std::io::Result<End> {
    use std::os::unix::process::CommandExt;
    command.stdin(Stdio::null()).stdout(std::fs::File::create(output)?).stderr(std::fs::File::create(errors)?);
    let until = Instant::now() + timeout;
    let mut group = Group { child: command.process_group(0).spawn()?, is_reaped: false };
    let size = |path: &Path| std::fs::metadata(path).map_or(0, |file| file.len());
    let mut pause = FIRST_LOOK;
    loop {
        if group.has_ended()? {
            let status = group.end()?;
            let is_too_much = size(output).max(size(errors)) > MOST_BYTES;
            return Ok(if is_too_much { End::WroteTooMuch } else { End::Exited(status) });
        }
        let end = if Instant::now() > until {
            Some(End::TimedOut)
        } else if pause == LONGEST_LOOK && size(output).max(size(errors)) > MOST_BYTES {
            Some(End::WroteTooMuch)
        } else if is_over() {
            Some(End::Left)
        } else {
            None
        };
        if let Some(end) = end {
            group.end()?;
            return Ok(end);
        }
        std::thread::sleep(pause);
        pause = (pause + pause / 4).min(LONGEST_LOOK);
    }
}
