//! Batches of passes: the graph of their jobs across passes and studies, what of it runs, the history of a study's error,
//! the archived report of a pass, the index of reports, its results against their baselines, the pass that follows a diagnosis,
//! the rounds of a study that is watched. Knows how passes, jobs, the runner and reports meet;
//! may not print, nor know of verbs and their options.

pub mod archive;
pub mod cluster;
mod error;
mod executed;
pub mod export;
mod graph;
pub mod history;
pub mod index;
mod inputs;
pub mod live;
pub mod load;
pub mod memory;
pub mod next_pass;
mod prepared;
pub mod print;
pub mod regression;
pub mod served;
pub mod view;

pub use error::BatchError;
pub use executed::{Executed, is_judge};
pub use history::history;
pub use load::{Loaded, LoadedPass, Reading, RefusedJob, load, load_with_seed, parents, passes};
pub use prepared::{NotThere, Prepared, prepare};
pub use view::{Document, document, view, without_rows};
