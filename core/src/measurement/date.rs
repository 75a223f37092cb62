//! When readings were taken, as an input of a model: what changes at a date depends on it.

use crate::document::calendar::date_and_time;
use crate::thermal::{Input, Model};

use super::{Measurement, Rows};

/// Name of the input, unless the model has one of that name.
const NAME: &str = "date of the row";
/// Value where no measurement says when: after all of them, s.
const AFTER_ALL_S: f64 = 1e9;

/// When the rows of the measurements of a pass were taken: numbers of the steady phases from 1 on, or seconds where there are
/// transients.
struct Dates {
    unit: &'static str,
    /// The first and the last.
    range: [f64; 2],
    /// From one steady phase to the next.
    step: f64,
    /// By name of a measurement: what is added to its times, s; of steady ones the first phase.
    starts: Vec<(String, f64)>,
}

/// The first and the last instant of a transient, s.
fn span(measurement: &Measurement) -> Option<[f64; 2]> {
    let Rows::Transient { inputs, .. } = &measurement.rows else { return None };
    Some([*inputs.times_s.first()?, *inputs.times_s.last()?])
}

impl Dates {
    /// Measurements follow one another as they are written, a steady phase beside transients as long as one of these on
    /// average. Transients alone are at the times that they state where these do not overlap. `None` of less than two instants.
    fn of(measurements: &[Measurement]) -> Option<Self> {
        let spans: Vec<[f64; 2]> = measurements.iter().filter_map(span).collect();
        let named = |measurement: &Measurement, start: f64| (measurement.name.clone(), start);
        if spans.len() == measurements.len() && spans.is_sorted_by(|a, b| a[1] <= b[0]) {
            let range = [spans.first()?[0], spans.last()?[1]];
            let starts = measurements.iter().map(|measurement| named(measurement, 0.0)).collect();
            return (range[0] < range[1]).then_some(Self { unit: "s", range, step: 0.0, starts });
        }
        let passed: f64 = spans.iter().map(|span| span[1] - span[0]).sum();
        let (unit, first, step) = match spans.len() {
            0 => ("1", 1.0, 1.0),
            count => ("s", 0.0, passed / count as f64),
        };
        let (mut now, mut last, mut starts) = (first, first, Vec::new());
        for measurement in measurements {
            match span(measurement) {
                None => {
                    starts.push(named(measurement, now));
                    now += step * measurement.len() as f64;
                    last = now - step;
                }
                Some([from, to]) => {
                    starts.push(named(measurement, now - from));
                    now += to - from;
                    last = now;
                }
            }
        }
        (first < last).then_some(Self { unit, range: [first, last], step, starts })
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

    /// Gives the input that says when its unit and range, and measurements their values of it, `all` being those of the
    /// pass. A model without it gets it where dates can be said.
    pub fn set_dates(&mut self, all: &[Measurement], measurements: &mut [Measurement]) {
        let Some(dates) = Dates::of(all) else { return };
        let date = self.date_input();
        let input = &mut self.inputs[date];
        dates.unit.clone_into(&mut input.unit);
        (input.range, input.nominal) = (Some(dates.range), dates.range[1]);
        for measurement in measurements {
            let dated = dates.starts.iter().find(|(name, _)| *name == measurement.name);
            let start = dated.map_or(dates.range[1], |(_, start)| *start);
            let put = |inputs: &mut Vec<f64>, value: f64| {
                inputs.resize(inputs.len().max(date + 1), 0.0);
                inputs[date] = value;
            };
            match &mut measurement.rows {
                Rows::Steady(phases) => {
                    let phases = phases.iter_mut().enumerate();
                    phases.for_each(|(row, phase)| put(&mut phase.inputs, start + dates.step * row as f64));
                }
                Rows::Transient { inputs, .. } => put(&mut inputs.base, start),
            }
        }
    }
}

/// Date and time at which the input that says when has this value, where a transient that was running then says when its time
/// is 0.
pub fn calendar(model: &Model, measurements: &[Measurement], when: f64) -> Option<String> {
    let date = model.date?;
    measurements.iter().find_map(|measurement| {
        let Rows::Transient { inputs, .. } = &measurement.rows else { return None };
        let time_s = when - inputs.base.get(date)?;
        let [first, last] = span(measurement)?;
        let is_running = (first..=last).contains(&time_s);
        date_and_time(measurement.time_zero_s.filter(|_| is_running)? + time_s)
    })
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
