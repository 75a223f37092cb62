//! A call at a point, and how it fails.

use crate::study::external::External;
use crate::thermal::Fault;

/// A call.
pub(super) struct Call<'a> {
    /// The model.
    pub external: &'a External,
    /// The numbers that are given: parameters, then inputs.
    pub given: &'a [f64],
    /// Called now and then while it waits; may unwind. Whether the call is given up.
    pub is_over: &'a dyn Fn() -> bool,
}

/// How a call fails.
pub(super) enum Failure {
    /// At this point.
    At(Fault),
    /// At this point, and again however often it is tried.
    Refused(Fault),
    /// At every point, so that the model is not asked any more.
    Broken(String),
}

impl Failure {
    pub fn at(what: &'static str, detail: impl Into<String>) -> Self {
        Self::At(Fault { what, detail: detail.into() })
    }
}

impl Call<'_> {
    /// The outputs, SI, of the numbers that were given back.
    pub fn outputs(&self, numbers: &[f64]) -> Result<Vec<f64>, Failure> {
        let outputs = &self.external.outputs;
        if numbers.len() != outputs.len() {
            let detail = format!("{} of {} outputs were given back", numbers.len(), outputs.len());
            return Err(Failure::at("outputs are missing", detail));
        }
        let values = numbers.iter().zip(outputs).enumerate().map(|(place, (number, output))| {
            let value = self.external.to_si(place, *number);
            // A unit whose zero is not that of SI is one of temperatures; differences are in kelvin.
            if output.unit.offset != 0.0 && value < 0.0 {
                let unit = &output.unit.text;
                let detail = format!("`{}` is {number} {unit}", output.name);
                return Err(Failure::at("an output is below absolute zero", detail));
            }
            if value.is_finite() {
                return Ok(value);
            }
            Err(Failure::at("an output is no finite number", format!("`{}` is {number}", output.name)))
        });
        values.collect()
    }
}
