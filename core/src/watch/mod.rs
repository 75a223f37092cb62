//! What long loops ask and tell who runs them: whether to go on, and how far they have come. Nothing here has a part in
//! a result.

pub mod share;
pub mod stop;

pub use share::{Share, at, with_share};
pub use stop::{Flag, Stopped, check, lend};
