//! Plan, execute, cache, keys, manifest, events, progress; the only user of threads.
//!
//! A run takes a [`Plan`] (jobs and what they build upon), looks each job's key up in the [`Cache`], runs what is missing
//! block by block, and tells every [`Listener`] what happens. Results are canonical JSON with arrays beside it, and hold no time, thread or path.

pub mod baseline;
pub mod cache;
pub mod cluster;
pub mod difference;
pub mod engine;
pub mod error;
pub mod event_log;
pub mod events;
pub mod external;
pub mod forecast;
pub mod http;
pub mod interrupt;
pub mod key;
pub mod manifest;
pub mod plan;
pub mod polling;
pub mod progress;
pub mod replay;
pub mod stored;

pub use baseline::Baseline;
pub use cache::{Cache, Kind};
pub use difference::{Difference, differences};
pub use engine::{Finished, Outcome, RunSummary, Settings, StopFlag};
pub use error::RunnerError;
pub use event_log::{EventLog, WorkHistory};
pub use events::{Event, Listener};
pub use key::{ENGINE_VERSION, Key, KeyMaterial};
pub use manifest::Manifest;
pub use plan::{Node, Plan, Ready, Task};
pub use progress::Progress;
