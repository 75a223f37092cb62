//! What is diagnosed.

use std::sync::Arc;

use crate::effect::{Candidate, Catalogue};
use crate::inference::likelihood::InputError;
use crate::inference::measurement::Measurement;
use crate::random::Distribution;
use crate::thermal::Model;

/// A believed model, its measurements, and the effects that it may be missing.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The believed model.
    pub model: Arc<Model>,
    /// Priors of its parameters, SI, in the model's order.
    pub priors: Vec<Distribution>,
    /// Positions of the parameters that are inferred; their priors are not fixed.
    pub parameters: Vec<usize>,
    /// The measurements; rows that are held out are in them, marked.
    pub measurements: Vec<Measurement>,
    /// Own errors of the inputs, in the model's order; may be shorter.
    pub input_errors: Vec<InputError>,
    /// The effects.
    pub catalogue: Arc<Catalogue>,
    /// Effects at places, of [`crate::effect::candidates`].
    pub candidates: Vec<Candidate>,
}
