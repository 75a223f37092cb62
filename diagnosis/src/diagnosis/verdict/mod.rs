//! From fits to the verdict and its sentences.
//!
//! `collinear`: inputs that move together. `conclude`: the verdict. `discriminating_experiment`, `discriminating_step`: the tests that would part rivals, `rival`: what one of these predicts there, `tested`: what the data have tested. `findings`: the sets, weighed. `far_from_priors`, `few_readings`, `hints`, `trend`, `still`
//! (channels that stand still while the model moves): what to check first. `laws`: laws that describe a curve. `lumped_nodes`: errors that every
//! network has. `nearly_as_good`: rivals within the model error. `one_kind`: what the effects of a group are together. `open_step`: where the steps that are stated end. `precedence`: why one goes before a more probable one. `results`: what is written out. `selection`: which set goes first. `small_effects`: what errors of the model may be. `storage_alternative`: what stores heat in place of warm surroundings. `surroundings`: those that were never logged. `words`: the sentences, with `effect_words` and `experiment_words` of an effect and of a test, and `numbers`.

pub mod collinear;
pub(crate) mod conclude;
pub mod discriminating_experiment;
mod discriminating_step;
pub mod effect_words;
pub mod everywhere;
pub mod experiment_words;
pub mod far_from_priors;
pub mod few_readings;
mod findings;
pub(crate) mod hints;
mod laws;
pub mod lumped_nodes;
mod nearly_as_good;
pub mod numbers;
pub mod one_kind;
pub mod open_step;
pub mod precedence;
mod results;
mod rival;
pub mod selection;
pub mod small_effects;
pub mod still;
pub mod storage_alternative;
pub mod surroundings;
mod tested;
pub mod trend;
pub mod words;
