//! From fits to the verdict and its sentences.
//!
//! `conclude`: the verdict. `discriminating_experiment`: the test that would part rivals. `few_readings`, `hints`, `trend`, `still`
//! (channels that stand still while the model moves): what to check first. `laws`: laws that describe a curve. `lumped_nodes`: errors that every
//! network has. `nearly_as_good`: rivals within the model error. `selection`: which set goes first. `small_effects`: what errors of the model may be. `words`: the sentences.

pub(crate) mod conclude;
pub(crate) mod discriminating_experiment;
mod everywhere;
pub(crate) mod few_readings;
pub(crate) mod hints;
mod laws;
mod lumped_nodes;
mod nearly_as_good;
mod selection;
mod small_effects;
pub(crate) mod still;
pub(crate) mod trend;
pub(crate) mod words;
