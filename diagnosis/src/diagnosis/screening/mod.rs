//! Which directions stand out, and how surely.
//!
//! `score`, `multi_column`, `pairs`: how much each of one column or several, and each two, would lower the misfit.
//! `family`: the probability that the best looks as good by chance. `detectable`: what would have been seen. `between_values`: dates and thresholds about the best of those that are tried.
//! `screen`: all of them at a fit.

pub(crate) mod between_values;
pub mod detectable;
pub mod family;
pub(crate) mod multi_column;
pub mod pairs;
pub mod score;
pub(crate) mod screen;
