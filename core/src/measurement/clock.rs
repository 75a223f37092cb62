//! When readings were taken, as inputs of a model: what changes at a date, or at a time into every run, depends on them.

use crate::document::calendar::date_and_time;
use crate::thermal::{Clock, Input, Model};

use super::{Measurement, Rows};

/// Value of the date where no measurement says when: after all of them, s.
const AFTER_ALL_S: f64 = 1e9;
/// Least length of the second longest run as a share of the longest's where changes at a time into every run are looked for.
const COMPARABLE: f64 = 0.25;

/// When the rows of the measurements of a pass were taken, by one clock.
struct Times {
    unit: &'static str,
    /// The first and the last.
    range: [f64; 2],
    /// Where nothing was measured.
    elsewhere: f64,
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

impl Times {
    fn of(clock: Clock, measurements: &[Measurement]) -> Option<Self> {
        match clock {
            Clock::Date => Self::dates(measurements),
            Clock::Elapsed => Self::elapsed(measurements),
        }
    }

    /// By the date: numbers of the steady phases from 1 on, or seconds where there are transients. Measurements follow one another as
    /// they are written, a steady phase beside transients as long as one of these on average. Transients alone are at the times that they state where these do not overlap. `None` of less than two instants.
    fn dates(measurements: &[Measurement]) -> Option<Self> {
        let spans: Vec<[f64; 2]> = measurements.iter().filter_map(span).collect();
        let named = |measurement: &Measurement, start: f64| (measurement.name.clone(), start);
        if spans.len() == measurements.len() && spans.is_sorted_by(|a, b| a[1] <= b[0]) {
            let range = [spans.first()?[0], spans.last()?[1]];
            let starts = measurements.iter().map(|measurement| named(measurement, 0.0)).collect();
            return (range[0] < range[1]).then_some(Self { unit: "s", range, elsewhere: range[1], step: 0.0, starts });
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
        (first < last).then_some(Self { unit, range: [first, last], elsewhere: last, step, starts })
    }

    /// By the time since the start of each run, up to the end of the second longest: later there is but one. What follows a gap is
    /// of the same run. Steady phases are at 0, before any change. `None` without a run.
    fn elapsed(measurements: &[Measurement]) -> Option<Self> {
        let runs = runs(measurements);
        let lengths = sorted_lengths(&runs);
        let last = *lengths.get(1).or(lengths.first())?;
        let starts = runs.into_iter().flat_map(|run| run.parts.into_iter().map(move |part| (part, -run.begin_s)));
        (last > 0.0).then(|| Self {
            unit: "s",
            range: [0.0, last],
            elsewhere: 0.0,
            step: 0.0,
            starts: starts.collect(),
        })
    }
}

/// A transient with what goes on after its gaps.
struct Run {
    begin_s: f64,
    end_s: f64,
    /// Names of the measurements.
    parts: Vec<String>,
}

fn runs(measurements: &[Measurement]) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for measurement in measurements {
        let Some([begin_s, end_s]) = span(measurement) else { continue };
        match runs.last_mut().filter(|_| measurement.follows_gap) {
            Some(run) => {
                run.end_s = end_s;
                run.parts.push(measurement.name.clone());
            }
            None => runs.push(Run { begin_s, end_s, parts: vec![measurement.name.clone()] }),
        }
    }
    runs
}

/// The longest first, s.
fn sorted_lengths(runs: &[Run]) -> Vec<f64> {
    let mut lengths: Vec<f64> = runs.iter().map(|run| run.end_s - run.begin_s).collect();
    lengths.sort_by(|a, b| b.total_cmp(a));
    lengths
}

/// Whether there are two runs of like length.
fn has_runs_alike(measurements: &[Measurement]) -> bool {
    let lengths = sorted_lengths(&runs(measurements));
    lengths.first().zip(lengths.get(1)).is_some_and(|(longest, second)| *second >= COMPARABLE * longest)
}

/// Median time from one row of a transient to the next, s; 0 without transients.
fn rows_apart_s(measurements: &[Measurement]) -> f64 {
    let mut apart: Vec<f64> = Vec::new();
    for measurement in measurements {
        if let Rows::Transient { inputs, .. } = &measurement.rows {
            apart.extend(inputs.times_s.windows(2).map(|pair| pair[1] - pair[0]));
        }
    }
    apart.sort_by(f64::total_cmp);
    apart.get(apart.len() / 2).copied().unwrap_or(0.0)
}

impl Model {
    /// The input of a clock, added where the model has none.
    pub fn clock_input(&mut self, clock: Clock) -> usize {
        if let Some(input) = self.clocks.get(clock) {
            return input;
        }
        let (name, nominal, description) = match clock {
            Clock::Date => ("date of the row", AFTER_ALL_S, "when: time of a transient, number of a steady phase"),
            Clock::Elapsed => ("time since the start", 0.0, "when: time since the start of the run"),
        };
        let is_used = |name: &str| {
            self.inputs.iter().any(|input| input.name == name) || self.nodes.iter().any(|node| node.name == name)
        };
        let mut name = name.to_owned();
        while is_used(&name) {
            name.push('_');
        }
        self.inputs.push(Input {
            name,
            unit: "s".to_owned(),
            nominal,
            range: None,
            settable: false,
            description: description.to_owned(),
        });
        self.clocks.set(clock, self.inputs.len() - 1);
        self.inputs.len() - 1
    }

    /// Gives a model the clocks by which something may change in measurements, and these their values, `all` being those of the
    /// pass.
    pub fn set_clocks(&mut self, all: &[Measurement], measurements: &mut [Measurement]) {
        self.clocks.rows_apart_s = rows_apart_s(all);
        for clock in Clock::ALL {
            let is_sought = clock == Clock::Date || has_runs_alike(measurements);
            if is_sought && Times::of(clock, all).is_some() {
                self.clock_input(clock);
            }
            self.set_clock(clock, all, measurements);
        }
    }

    /// Gives the input of a clock its unit and range, and measurements their values of it, `all` being those of the pass. The
    /// input, where the model has it.
    pub fn set_clock(&mut self, clock: Clock, all: &[Measurement], measurements: &mut [Measurement]) -> Option<usize> {
        let position = self.clocks.get(clock)?;
        let input = &mut self.inputs[position];
        let (mut starts, mut step) = (Vec::new(), 0.0);
        if let Some(times) = Times::of(clock, all) {
            times.unit.clone_into(&mut input.unit);
            (input.range, input.nominal) = (Some(times.range), times.elsewhere);
            (starts, step) = (times.starts, times.step);
        }
        let elsewhere = input.nominal;
        for measurement in measurements {
            let own = starts.iter().find(|(name, _)| *name == measurement.name);
            let start = own.map_or(elsewhere, |(_, start)| *start);
            let put = |inputs: &mut Vec<f64>, value: f64| {
                inputs.resize(inputs.len().max(position + 1), 0.0);
                inputs[position] = value;
            };
            match &mut measurement.rows {
                Rows::Steady(phases) => {
                    let phases = phases.iter_mut().enumerate();
                    phases.for_each(|(row, phase)| put(&mut phase.inputs, start + step * row as f64));
                }
                Rows::Transient { inputs, .. } => put(&mut inputs.base, start),
            }
        }
        Some(position)
    }
}

/// Date and time at which the input that says when has this value, where a transient that was running then says when its time
/// is 0.
pub fn calendar(model: &Model, measurements: &[Measurement], when: f64) -> Option<String> {
    let date = model.clocks.get(Clock::Date)?;
    measurements.iter().find_map(|measurement| {
        let Rows::Transient { inputs, .. } = &measurement.rows else { return None };
        let time_s = when - inputs.base.get(date)?;
        let [first, last] = span(measurement)?;
        let is_running = (first..=last).contains(&time_s);
        date_and_time(measurement.time_zero_s.filter(|_| is_running)? + time_s)
    })
}

impl Measurement {
    /// Value of an input in a row, SI; of a clock with the time that has passed.
    pub fn level(&self, model: &Model, row: usize, input: usize) -> Option<f64> {
        match &self.rows {
            Rows::Steady(phases) => phases[row].inputs.get(input).copied(),
            Rows::Transient { inputs, .. } => {
                let passed = if model.clocks.has(input) { inputs.times_s[row] } else { 0.0 };
                Some(inputs.in_row(row, input) + passed)
            }
        }
    }
}
