//! The correlation as a job of one block.

use std::sync::Arc;

use serde_json::{Value, json};

use super::search::{Search, Step as Accepted};
use super::{Change, Correlated, Ended, Method, Output, Spec};
use crate::job::compare::{Deviation, KELVIN, deviation, verdicts};
use crate::job::{Done, Job, JobError, Parts, Step};
use crate::measurement::Measurement;
use crate::measurement::prediction::Predictor;
use crate::thermal::Model;

/// Share of its range within which a parameter counts as at an end.
const AT_BOUND: f64 = 1e-6;

/// A correlation, ready to run.
#[derive(Debug)]
pub struct Correlate {
    spec: Spec,
    model: Arc<Model>,
    measurements: Arc<Vec<Measurement>>,
    predictor: Predictor,
}

impl Correlate {
    /// Prepares the job; `measurements` are the pass's.
    ///
    /// # Errors
    /// A network that cannot be compiled.
    pub fn new(spec: Spec, model: Arc<Model>, measurements: Arc<Vec<Measurement>>) -> Result<Self, JobError> {
        let predictor = Predictor::new(&model, &[]).map_err(|error| JobError::Failed(error.to_string()))?;
        Ok(Self { spec, model, measurements, predictor })
    }

    /// Measured minus predicted, K, of readings in kelvin: those that are fitted, those held out.
    fn deviations(&self, values: &[f64]) -> [Vec<f64>; 2] {
        let mut parameters: Vec<f64> = self.model.parameters.iter().map(|parameter| parameter.nominal).collect();
        for (free, value) in self.spec.parameters.iter().zip(values) {
            parameters[free.index] = *value;
        }
        let mut workspace = self.predictor.workspace();
        let mut all = [Vec::new(), Vec::new()];
        for &index in &self.spec.data {
            let measurement = &self.measurements[index];
            let predicted = self.predictor.predict(&mut workspace, measurement, &parameters).readings;
            for row in (0..measurement.len()).filter(|&row| !measurement.ignored(row)) {
                for (position, sensor) in measurement.sensors.iter().enumerate() {
                    if self.model.quantities[sensor.quantity].unit != KELVIN {
                        continue;
                    }
                    if let Some(measured) = measurement.reading(row, position) {
                        let own = measured - predicted[row * measurement.sensors.len() + position];
                        all[usize::from(measurement.held_out(row))].push(own);
                    }
                }
            }
        }
        all
    }

    fn met(&self, fitted: &Deviation) -> bool {
        verdicts(&self.spec.criteria, fitted, &Deviation::default()).iter().all(|verdict| verdict.kept)
    }

    fn statistics(&self, deviations: &[f64]) -> Deviation {
        deviation(deviations, self.spec.criteria.each_k)
    }

    /// Changes the parameters.
    pub(super) fn run(&self) -> Result<Output, JobError> {
        let nominal: Vec<f64> =
            self.spec.parameters.iter().map(|free| self.model.parameters[free.index].nominal).collect();
        let [fitted, held_out] = self.deviations(&nominal);
        if fitted.is_empty() {
            return Err(JobError::Failed("no reading in kelvin is to be fitted: all are held out".to_owned()));
        }
        if fitted.iter().any(|own| !own.is_finite()) {
            let reason = "the delivered model has no prediction for every reading; a `compare` job says which";
            return Err(JobError::Failed(reason.to_owned()));
        }
        let (before, held_out_before) = (self.statistics(&fitted), self.statistics(&held_out));
        let met = |deviations: &[f64]| self.met(&self.statistics(deviations));
        let of = |values: &[f64]| self.deviations(values)[0].clone();
        let search =
            Search { ranges: self.spec.parameters.iter().map(|free| free.range).collect(), deviations: &of, met: &met };
        let met_as_delivered = self.met(&before);
        let accepted: Vec<Accepted> = match self.spec.method {
            Method::OneAtATime if met_as_delivered => Vec::new(),
            Method::OneAtATime => search.one_at_a_time(&nominal),
            Method::LeastSquares => search.least_squares(&nominal),
        };
        let values = accepted.last().map_or(nominal.clone(), |last| last.values.clone());
        let [fitted, held_out] = self.deviations(&values);
        let after = self.statistics(&fitted);
        let change = |step: &Accepted| {
            let own = self.statistics(&step.deviations);
            let named = step.parameter.map(|place| self.spec.parameters[place].index);
            Change {
                parameter: named.map(|index| self.model.parameters[index].name.clone()),
                value: step.parameter.map(|place| step.values[place]),
                rmse: own.rmse,
                max: own.max,
                met: self.met(&own),
            }
        };
        let correlated = |place: usize| {
            let free = &self.spec.parameters[place];
            let parameter = &self.model.parameters[free.index];
            let near = AT_BOUND * (free.range[1] - free.range[0]);
            Correlated {
                name: parameter.name.clone(),
                unit: parameter.unit.clone(),
                before: nominal[place],
                after: values[place],
                range: free.range,
                at_bound: free.range.iter().any(|end| (values[place] - end).abs() <= near),
            }
        };
        Ok(Output {
            method: self.spec.method,
            criteria: self.spec.criteria.clone(),
            ended: match (met_as_delivered, self.met(&after)) {
                (true, _) => Ended::MetAsDelivered,
                (false, true) => Ended::Met,
                (false, false) => Ended::NotMet,
            },
            changes: accepted.iter().map(change).collect(),
            parameters: (0..values.len()).map(correlated).collect(),
            before,
            after,
            held_out_before,
            held_out_after: self.statistics(&held_out),
        })
    }
}

impl Job for Correlate {
    type State = ();
    type Input = ();
    type Partial = Output;
    type Output = Output;

    fn kind(&self) -> &'static str {
        "correlate"
    }

    fn algorithm_version(&self) -> u32 {
        1
    }

    fn identity(&self) -> Value {
        json!({
            "data": self.spec.data.iter().map(|&index| self.measurements[index].identity()).collect::<Vec<_>>(),
            "parameters": self.spec.parameters,
            "criteria": self.spec.criteria,
            "method": self.spec.method,
            "model": self.model.identity(),
        })
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        Ok(Step::Blocks { stage: "changes".to_owned(), state: (), inputs: vec![()] })
    }

    fn block(&self, (): &(), (): (), _parts: &dyn Parts) -> Result<Output, JobError> {
        self.run()
    }

    fn is_last(&self, (): &()) -> bool {
        true
    }

    fn reduce(&self, (): (), blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let finished = blocks.into_iter().next().map(|(_, output)| Step::Done(Box::new(output)));
        finished.ok_or_else(|| JobError::Failed("there is no correlation".to_owned()))
    }
}
