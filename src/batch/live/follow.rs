//! Round after round: a study is run again whenever one of its files changes.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::changes::Stamp;
use super::progress::RoundProgress;
use super::round::{RoundError, round};
use super::state::State;
use crate::batch::{BatchError, Executed, Prepared, Reading};
use crate::runner::polling::{stopped_when, wait_until};
use crate::runner::{Listener, StopFlag};

/// How often the files are looked at.
const GLANCE: Duration = Duration::from_millis(300);
/// A file that is being written is left alone until it stays the same for so long.
const SETTLED: Duration = Duration::from_millis(100);
/// Changed files that are named.
const MOST_NAMED: usize = 4;

/// What is followed.
pub struct Followed {
    /// Folder of the study.
    pub folder: PathBuf,
    /// What was asked for: the folder, or one of its passes.
    pub path: PathBuf,
    /// How passes are read.
    pub reading: Reading,
}

/// Runs prepared passes until that is done or the flag is raised, and tells the listener of it.
pub type Run<'r> = &'r dyn Fn(Prepared, &StopFlag, &dyn Listener) -> Result<Executed, BatchError>;

/// Follows a study until the process ends. A change stops the round under way.
pub fn follow(followed: &Followed, state: &State, run: Run<'_>, tell: &dyn Fn(&str)) -> ! {
    let mut adopted: Vec<PathBuf> = Vec::new();
    loop {
        let before = Stamp::of(&followed.folder);
        // A pass that was adopted is wanted too, where not all of the folder is; it may be deleted again.
        let there = adopted.iter().filter(|pass| pass.is_file());
        let paths: Vec<PathBuf> = std::iter::once(&followed.path).chain(there).cloned().collect();
        let progress = RoundProgress::default();
        state.begin(&progress);
        let has_changed = || Stamp::of(&followed.folder) != before;
        let given = stopped_when(GLANCE, has_changed, |stop| {
            round(&paths, &followed.reading.anew(), |prepared| run(prepared, stop, &progress))
        });
        match given {
            Ok(round) => {
                round.notes.iter().for_each(|note| tell(note));
                state.publish(round);
                state.errors().iter().for_each(|line| tell(line));
                tell("up to date");
            }
            Err(RoundError::Wrong(messages)) => {
                state.fail(&messages);
                tell(&messages);
            }
            Err(RoundError::Stopped) => {}
        }
        wait_until(GLANCE, has_changed);
        tell(&changed(&before, &settled(&followed.folder)));
        adopted.extend(state.adopted());
    }
}

/// The files, once they stay as they are.
fn settled(folder: &Path) -> Stamp {
    let mut last = Stamp::of(folder);
    wait_until(SETTLED, || {
        let now = Stamp::of(folder);
        now == std::mem::replace(&mut last, now.clone())
    });
    last
}

/// What changed, in a line.
fn changed(before: &Stamp, now: &Stamp) -> String {
    let names = before.differences(now);
    let more = names.len().saturating_sub(MOST_NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let named: Vec<&str> = names.iter().take(MOST_NAMED).map(String::as_str).collect();
    format!("changed: {}{more}", named.join(", "))
}
