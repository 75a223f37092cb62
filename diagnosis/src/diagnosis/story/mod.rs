//! How effects are added one by one where the model is a little wrong everywhere: what a larger set gains there at once is
//! as likely to be model error.
//!
//! `rules`: what is asked of an effect, as functions of numbers. `sets`: what an effect gains that one fitted set adds to another.
//! `plainness`: which laws are plainer than others. `step`: which effect is added to a set. `exchange`: when an earlier effect gives
//! way. `course`: the whole story.

pub(crate) mod course;
pub(crate) mod exchange;
pub(crate) mod plainness;
pub mod rules;
pub(crate) mod sets;
pub(crate) mod step;
