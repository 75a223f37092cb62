//! Which directions stand out, and how surely.
//!
//! `score`, `multi_column`, `pairs`: how much each of one column or several, and each two, would lower the misfit. `family`, `null_maximum`: the probability that the best looks as
//! good by chance. `detectable`: what would have been seen. `screen`: all of them at a fit.

pub mod detectable;
pub mod family;
pub(crate) mod multi_column;
pub mod null_maximum;
pub mod pairs;
pub mod score;
pub(crate) mod screen;
