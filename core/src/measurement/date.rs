//! When readings were taken, as an input of a model: what changes at a date depends on it.

use crate::thermal::{Input, Model};

use super::{Measurement, Rows};

/// Name of the input, unless the model has one of that name.
const NAME: &str = "date";
/// Value where no measurement says when: after all of them, s.
const AFTER_ALL_S: f64 = 1e9;

/// When the rows of measurements were taken: numbers of the steady phases from 1 on, or seconds of the transients.
struct Dates {
    unit: &'static str,
    /// The first and the last.
    range: [f64; 2],
    /// By measurement: what is added to its times, s, or to the numbers of its phases from 0 on.
    starts: Vec<f64>,
}

impl Dates {
    /// Phases follow one another as they are written. Transients are at the times that they state where these do not
    /// overlap, else they follow one another. `None` of steady phases beside transients, and of fewer than two rows.
    fn of(measurements: &[Measurement]) -> Option<Self> {
        let mut starts = Vec::new();
        let mut spans: Vec<[f64; 2]> = Vec::new();
        let mut phases = 0;
        for measurement in measurements {
            match &measurement.rows {
                Rows::Steady(own) => {
                    starts.push((phases + 1) as f64);
                    phases += own.len();
                }
                Rows::Transient { inputs, .. } => {
                    let [first, .., last] = inputs.times_s.as_slice() else { return None };
                    spans.push([*first, *last]);
                }
            }
        }
        if spans.is_empty() {
            return (phases > 1).then(|| Self { unit: "1", range: [1.0, phases as f64], starts });
        }
        if !starts.is_empty() {
            return None;
        }
        if !spans.is_sorted_by(|a, b| a[1] <= b[0]) {
            let mut end = 0.0;
            for span in &mut spans {
                starts.push(end - span[0]);
                *span = [end, end + span[1] - span[0]];
                end = span[1];
            }
        }
        starts.resize(spans.len(), 0.0);
        Some(Self { unit: "s", range: [spans.first()?[0], spans.last()?[1]], starts })
    }
}

impl Model {
    /// The input that says when, added where the model has none: in seconds, after all measurements.
    pub fn date_input(&mut self) -> usize {
        if let Some(date) = self.date {
            return date;
        }
        let is_used = |name: &str| {
            self.inputs.iter().any(|input| input.name == name) || self.nodes.iter().any(|node| node.name == name)
        };
        let mut name = NAME.to_owned();
        while is_used(&name) {
            name.push('_');
        }
        self.inputs.push(Input {
            name,
            unit: "s".to_owned(),
            nominal: AFTER_ALL_S,
            range: None,
            settable: false,
            description: "when: time of a transient, number of a steady phase".to_owned(),
        });
        self.date = Some(self.inputs.len() - 1);
        self.inputs.len() - 1
    }

    /// Gives the input that says when its unit and range, and the measurements their values of it. A model without it gets
    /// it where dates can be said of these measurements.
    pub fn set_dates(&mut self, measurements: &mut [Measurement]) {
        let Some(dates) = Dates::of(measurements) else { return };
        let date = self.date_input();
        let input = &mut self.inputs[date];
        dates.unit.clone_into(&mut input.unit);
        (input.range, input.nominal) = (Some(dates.range), dates.range[1]);
        for (measurement, start) in measurements.iter_mut().zip(&dates.starts) {
            let put = |inputs: &mut Vec<f64>, value: f64| {
                inputs.resize(inputs.len().max(date + 1), 0.0);
                inputs[date] = value;
            };
            match &mut measurement.rows {
                Rows::Steady(phases) => {
                    phases.iter_mut().enumerate().for_each(|(row, phase)| put(&mut phase.inputs, start + row as f64));
                }
                Rows::Transient { inputs, .. } => put(&mut inputs.base, *start),
            }
        }
    }
}

impl Measurement {
    /// Value of an input in a row, SI; of the one that says when with the time that has passed.
    pub fn level(&self, model: &Model, row: usize, input: usize) -> Option<f64> {
        match &self.rows {
            Rows::Steady(phases) => phases[row].inputs.get(input).copied(),
            Rows::Transient { inputs, .. } => {
                let passed = if model.date == Some(input) { inputs.times_s[row] } else { 0.0 };
                Some(inputs.in_row(row, input) + passed)
            }
        }
    }
}
