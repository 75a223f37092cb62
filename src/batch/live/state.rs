//! How a watched study stands: what its last good round gave, and what goes on since.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde_json::{Value, json};

use super::progress::RoundProgress;
use super::round::Round;

/// What goes on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    /// A round is under way.
    #[default]
    Running,
    /// The last round gave what is served.
    Ready,
    /// The last round gave nothing: what is served is older.
    Wrong,
}

/// How a watched study stands, for the loop that changes it and the requests that read it.
#[derive(Default)]
pub struct State {
    shared: Mutex<Shared>,
    /// Held while a pass is adopted.
    pub(super) adopting: Mutex<()>,
}

#[derive(Default)]
struct Shared {
    /// Counts the rounds that gave something.
    version: u64,
    phase: Phase,
    progress: RoundProgress,
    round: Option<Arc<Round>>,
    /// Errors of the passes in the round before.
    before: BTreeMap<String, String>,
    messages: String,
    adopted: Vec<PathBuf>,
}

/// What a page shows of the state.
pub(super) struct Shown {
    pub version: u64,
    pub state: &'static str,
    pub lines: Vec<String>,
    pub messages: String,
}

impl State {
    fn shared(&self) -> MutexGuard<'_, Shared> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A round begins, whose progress is shown here.
    pub fn begin(&self, progress: &RoundProgress) {
        let mut shared = self.shared();
        shared.phase = Phase::Running;
        shared.progress = progress.clone();
    }

    /// A round gave this: it is served from now on.
    pub fn publish(&self, round: Round) {
        let mut shared = self.shared();
        shared.messages = round.notes.iter().map(|note| uncoloured(note)).collect::<Vec<_>>().join("\n");
        if let Some(earlier) = shared.round.take() {
            shared.before = earlier.errors.clone();
        }
        shared.version += 1;
        shared.phase = Phase::Ready;
        shared.round = Some(Arc::new(round));
    }

    /// A round gave nothing: this is wrong, and what was served stays.
    pub fn fail(&self, messages: &str) {
        let mut shared = self.shared();
        shared.messages = uncoloured(messages);
        shared.phase = Phase::Wrong;
    }

    /// Passes that were adopted from the page since it was asked last.
    pub(super) fn adopted(&self) -> Vec<PathBuf> {
        std::mem::take(&mut self.shared().adopted)
    }

    pub(super) fn adopt(&self, pass: PathBuf) {
        self.shared().adopted.push(pass);
    }

    /// The last round that gave something, with its number.
    pub(super) fn round(&self) -> (u64, Option<Arc<Round>>) {
        let shared = self.shared();
        (shared.version, shared.round.clone())
    }

    pub(super) fn shown(&self) -> Shown {
        let shared = self.shared();
        let (state, lines) = match shared.phase {
            Phase::Running => ("running", shared.progress.lines()),
            Phase::Ready => ("ready", shared.errors()),
            Phase::Wrong => ("wrong", Vec::new()),
        };
        Shown { version: shared.version, state, lines, messages: shared.messages.clone() }
    }

    /// The state as the page's script asks for it.
    pub(super) fn json(&self) -> Value {
        let Shown { version, state, lines, messages } = self.shown();
        json!({ "version": version, "state": state, "lines": lines, "messages": messages })
    }

    /// What came out of the last round, a line a pass, as it was before where it is another.
    pub fn errors(&self) -> Vec<String> {
        self.shared().errors()
    }
}

impl Shared {
    fn errors(&self) -> Vec<String> {
        let line = |(pass, words): (&String, &String)| {
            let earlier = self.before.get(pass).filter(|earlier| *earlier != words);
            let earlier = earlier.and_then(|earlier| Some(earlier.split_once(": ")?.1));
            let earlier = earlier.map_or_else(String::new, |earlier| format!(" (before: {earlier})"));
            format!("{pass}: {words}{earlier}")
        };
        self.round.iter().flat_map(|round| &round.errors).map(line).collect()
    }
}

/// A rendered text without its colours; all else that could steer a terminal was shown by its code before.
pub fn uncoloured(text: &str) -> String {
    let mut parts = text.split("\u{1b}[");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |plain, part| plain + part.split_once('m').map_or(part, |(_, rest)| rest))
}
