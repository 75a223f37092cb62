//! What was tested of each input and each measured quantity by the measurements behind a prediction's posterior.

use crate::expression::Symbol;
use crate::inference::gaussian_process::tested_range::TestedRange;
use crate::job::predict::Prediction;
use crate::measurement::{Measurement, Rows};
use crate::study::Pass;
use crate::thermal::{Model, Quantity};

/// What the calibration behind a prediction saw.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tested {
    /// The prediction.
    pub job: String,
    /// Ranges of the inputs, SI.
    pub inputs: Vec<TestedRange>,
    /// Ranges of the readings by the node or quantity that they measure, SI.
    pub quantities: Vec<TestedRange>,
}

/// Value of an input in a row, SI.
pub fn input_in_row(measurement: &Measurement, row: usize, input: usize) -> Option<f64> {
    match &measurement.rows {
        Rows::Steady(phases) => phases.get(row)?.inputs.get(input).copied(),
        Rows::Transient { inputs, .. } => (input < inputs.base.len()).then(|| inputs.in_row(row, input)),
    }
}

/// What was tested for each prediction of a pass whose posterior is that of a calibration at hand.
pub fn of(pass: &Pass) -> Vec<Tested> {
    let predictions = pass.jobs.iter().filter_map(|job| Some((&job.name, job.spec.get::<Prediction>()?)));
    predictions
        .filter_map(|(name, prediction)| {
            let from = prediction.posterior.from.as_ref()?;
            let holder = find(pass, &from.file)?;
            let spec = &holder.jobs.iter().find(|job| job.name == from.job)?.spec;
            let mut tested = Tested { job: name.clone(), ..Tested::default() };
            for &index in spec.inference()?.data {
                tested.add(holder, holder.measurements.get(index)?);
            }
            // The readings of calibrations whose posteriors were its priors.
            for earlier in holder.posterior_priors.iter().flat_map(|reference| &reference.behind) {
                let of = find(holder, &earlier.calibration.file)?;
                tested.add(of, of.measurements.iter().find(|own| own.name == earlier.measurement)?);
            }
            Some(tested)
        })
        .collect()
}

/// A pass by its file: the pass itself, or one whose posterior it uses.
fn find<'p>(pass: &'p Pass, file: &str) -> Option<&'p Pass> {
    if pass.file == file { Some(pass) } else { pass.upstream.iter().find_map(|upstream| find(upstream, file)) }
}

impl Tested {
    /// Widens the ranges by the rows of a measurement that a fit used.
    fn add(&mut self, pass: &Pass, measurement: &Measurement) {
        let rows = || measurement.fitted_rows();
        // A clock and the switch of an adopted effect are no conditions of a test.
        let is_condition = |index: usize| !pass.model.clocks.has(index) && pass.model.inputs[index].settable;
        for (index, input) in pass.model.inputs.iter().enumerate().filter(|(index, _)| is_condition(*index)) {
            let values = rows().filter_map(|row| input_in_row(measurement, row, index));
            widen(&mut self.inputs, &input.name, &input.unit, values);
        }
        for (sensor, own) in measurement.sensors.iter().enumerate() {
            let Some(quantity) = pass.model.quantities.get(own.quantity) else { continue };
            let values = rows().filter_map(|row| measurement.reading(row, sensor));
            widen(&mut self.quantities, measured_as(&pass.model, quantity), &quantity.unit, values);
        }
    }
}

/// The name under which a quantity is held against what was measured: that of its node, where it is the temperature of one.
pub fn measured_as<'m>(model: &'m Model, quantity: &'m Quantity) -> &'m str {
    let symbols = model.graph.symbols(quantity.value.expression());
    let node = match symbols.into_iter().collect::<Vec<_>>().as_slice() {
        [Symbol::Node(node)] if quantity.is_temperature => model.nodes.get(*node as usize),
        _ => None,
    };
    node.map_or(quantity.name.as_str(), |node| node.name.as_str())
}

fn widen(ranges: &mut Vec<TestedRange>, name: &str, unit: &str, values: impl Iterator<Item = f64>) {
    for value in values.filter(|value| value.is_finite()) {
        match ranges.iter_mut().find(|own| own.input == name) {
            Some(own) => (own.lower, own.upper) = (own.lower.min(value), own.upper.max(value)),
            None => {
                ranges.push(TestedRange { input: name.to_owned(), unit: unit.to_owned(), lower: value, upper: value });
            }
        }
    }
}
