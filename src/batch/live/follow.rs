//! Round after round: a study is run again whenever one of its files changes.

use std::path::PathBuf;
use std::time::Duration;

use super::changes::Watched;
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
    let watched = Watched::new(&followed.folder);
    loop {
        // A pass that was adopted is wanted too, where not all of the folder is; it may be deleted again.
        let there = adopted.iter().filter(|pass| pass.is_file());
        let paths: Vec<PathBuf> = std::iter::once(&followed.path).chain(there).cloned().collect();
        let progress = RoundProgress::default();
        state.begin(&progress);
        let given = stopped_when(
            GLANCE,
            || watched.has_changed(),
            |stop| {
                round(&paths, &followed.reading.anew(), |prepared| {
                    watched.narrow(prepared.passes());
                    run(prepared, stop, &progress)
                })
            },
        );
        match given {
            Ok(round) => {
                round.notes.iter().for_each(|note| tell(note));
                state.publish(round);
                state.errors().iter().for_each(|line| tell(line));
                tell("up to date");
            }
            Err(RoundError::Wrong(messages)) => {
                watched.widen();
                state.fail(&messages);
                tell(&messages);
            }
            Err(RoundError::Stopped) => {}
        }
        wait_until(GLANCE, || watched.has_changed());
        settle(&watched);
        tell(&changed(&watched.renew()));
        adopted.extend(state.adopted());
    }
}

/// Waits until the files stay as they are.
fn settle(watched: &Watched) {
    let mut last = watched.now();
    wait_until(SETTLED, || {
        let now = watched.now();
        let is_settled = now == last;
        last = now;
        is_settled
    });
}

/// What changed, in a line.
fn changed(names: &[String]) -> String {
    let more = names.len().saturating_sub(MOST_NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let named: Vec<&str> = names.iter().take(MOST_NAMED).map(String::as_str).collect();
    format!("changed: {}{more}", named.join(", "))
}
