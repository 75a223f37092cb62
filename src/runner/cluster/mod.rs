//! Blocks on the machines of a cluster: arrays of shards, each a run of blocks, given to a scheduler.
//!
//! The cache on the shared file system is the truth. A block is done when its object is there and sound; what the scheduler
//! says of a task only tells whether an object may still come. A task that runs twice, or two tasks that write one block,
//! do no harm: an object is published once, and the second writer compares. So nothing is lost when a machine, the
//! scheduler or the program that follows a run goes away: what is missing is submitted again, and nothing else.

pub mod driver;
pub mod folder;
pub mod options;
pub mod overview;
pub mod scheduler;
pub mod shards;
pub mod slurm;
mod tracking;
pub mod worker;

pub use driver::{Driver, Mode};
pub use folder::{RunFolder, RunPass, RunRecord};
pub use options::Options;
pub use scheduler::Scheduler;
