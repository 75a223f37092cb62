//! A study that is run again whenever one of its files changes, and served to a browser on this machine.
//!
//! A round loads, runs and renders; what it gives is kept in memory, and requests are answered from there alone. So no
//! request can name a file: nothing is read for it, and the one thing that it can write is the next pass, as `bmv adopt`
//! does.

pub mod changes;
mod follow;
pub mod page;
mod progress;
mod round;
pub mod session;
pub mod site;
pub mod state;

pub use follow::{Followed, follow};
pub use site::Site;
pub use state::State;
