//! Sources of heat in every node and phase or stretch of time, and a bias of every sensor: what they do to the readings.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::diagnosis::FitError;
use crate::diagnosis::fits::refit::TOLERANCE_ON_FEWER_ROWS;
use crate::diagnosis::linearisation::signature::linearise;
use crate::diagnosis::{Linear, Problem, Refit};
use crate::expression::{Names, Scope, Symbol, parse};
use crate::inference::estimate::natural::NaturalObjective;
use crate::inference::estimate::optimise::Objective;
use crate::inference::likelihood::{Definition, FewerRows, Likelihood};
use crate::inference::target::Target;
use crate::math::dense::dot_of_columns as dot;
use crate::math::functions::ln;
use crate::measurement::{Measurement, Rows};
use crate::random::Distribution;
use crate::thermal::element::{Element, ElementKind, Load};
use crate::thermal::{Model, NodeKind, Parameter};

/// Stretches of time of a transient.
const STRETCHES: usize = 16;
/// Most sources.
const MOST_SOURCES: usize = 600;
/// Sources that move nothing are left out: share of the largest column.
const LEAST: f64 = 1e-9;
/// Heat beyond this, W, is no heat.
const UNBOUNDED_W: f64 = 1e12;

/// What sources are of one kind: their sizes are alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Heat of a node.
    Node(usize),
    /// The bias of a sensor, by measurement and sensor.
    Sensor(usize, usize),
}

/// A source and where it acts.
pub struct Source {
    /// What it is a source of.
    pub kind: Kind,
    /// The steady phase.
    pub phase: Option<String>,
    /// The instant in a record, s.
    pub time_s: Option<f64>,
    /// Inputs there, SI.
    pub inputs: Vec<f64>,
}

/// The baseline model with sources, over the rows of a steady phase or of a transient.
struct Field {
    likelihood: Likelihood,
    /// Positions of its readings among all.
    rows: Vec<usize>,
    /// Position of each of its unknowns among the baseline model's.
    unknowns: Vec<Option<usize>>,
    /// The source that each of its unknowns is.
    sources: Vec<Option<usize>>,
}

/// All sources of a problem.
pub struct Sources {
    likelihood: Likelihood,
    fields: Vec<Field>,
    list: Vec<Source>,
    /// Columns of the biases: they do not depend on the state.
    biases: Vec<(usize, Vec<f64>)>,
}

/// The problem linearised with sources in it. Its residuals are those without sources as far as their slopes tell, so that
/// amplitudes count from 0.
#[derive(Clone)]
pub struct State {
    /// Unknowns of the baseline model, SI.
    pub unknowns: Vec<f64>,
    /// Amplitudes of the sources, W (of biases in standard deviations).
    pub amplitudes: Vec<f64>,
    /// The baseline model there.
    pub linear: Linear,
    /// Columns of the sources.
    pub columns: Vec<Vec<f64>>,
    /// Half the sum of squares with the sources, rows of the priors with it.
    pub half_square: f64,
}

/// Why heat of unknown origin is not known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoHeat {
    /// It would have too many sources.
    TooMany,
    /// Sources cannot be put into the model: where, and why.
    NotMade(String),
    /// The model has no solution with it.
    NotSolved,
    /// The readings do not determine its size.
    NotDetermined,
}

impl State {
    /// The same with some of the sources; the others have no heat.
    pub fn only(self, places: &[usize]) -> Self {
        let mut columns = self.columns;
        let amplitudes = places.iter().map(|&place| self.amplitudes[place]).collect();
        let columns = places.iter().map(|&place| std::mem::take(&mut columns[place])).collect();
        Self { amplitudes, columns, ..self }
    }
}

impl NoHeat {
    /// The reason, after a colon.
    pub fn in_words(&self) -> String {
        match self {
            Self::TooMany => format!(
                "a source for each node and each phase (of a transient, each of {STRETCHES} stretches of every part) makes more than \
                 {MOST_SOURCES}"
            ),
            Self::NotMade(why) => format!("the model takes no source of heat: {why}"),
            Self::NotSolved => "the model has no solution with such heat".to_owned(),
            Self::NotDetermined => "the readings do not determine how much it is".to_owned(),
        }
    }
}

impl Field {
    /// Its unknowns, SI and W.
    fn at(&self, unknowns: &[f64], amplitudes: &[f64]) -> Vec<f64> {
        let value = |(unknown, source): (&Option<usize>, &Option<usize>)| {
            let amplitude = source.map(|source| amplitudes[source]);
            unknown.map(|place| unknowns[place]).or(amplitude).unwrap_or(0.0)
        };
        self.unknowns.iter().zip(&self.sources).map(value).collect()
    }
}

impl Sources {
    /// Sources in every node that has a balance, and a bias of every sensor.
    ///
    /// # Errors
    /// They are too many, or cannot be made.
    pub fn new(problem: &Problem) -> Result<Self, NoHeat> {
        Self::of(problem, &|_| true)
    }

    /// Sources of the kinds that are wanted.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(problem: &Problem, is_wanted: &dyn Fn(Kind) -> bool) -> Result<Self, NoHeat> {
        let not_made = |error: FitError| NoHeat::NotMade(error.to_string());
        let likelihood = problem.hypothesis(&[], 1.0).map_err(not_made)?.likelihood(problem).map_err(not_made)?;
        let mut all = Self { likelihood, fields: Vec::new(), list: Vec::new(), biases: Vec::new() };
        // What heat over a stretch of time does is seen well enough on fewer rows.
        let thinned = problem.thinned(TOLERANCE_ON_FEWER_ROWS);
        let fewer = thinned.map_or_else(Vec::new, |thinned| thinned.slopes_on(&thinned.problem.measurements));
        for index in 0..problem.measurements.len() {
            all.add_measurement(problem, index, fewer.get(index..=index).unwrap_or_default(), is_wanted)?;
            if all.list.len() > MOST_SOURCES {
                return Err(NoHeat::TooMany);
            }
        }
        for (index, measurement) in problem.measurements.iter().enumerate() {
            for sensor in (0..measurement.sensors.len()).filter(|&sensor| is_wanted(Kind::Sensor(index, sensor))) {
                let is_of_sensor = |datum: &crate::inference::likelihood::Datum| {
                    f64::from(u8::from(datum.measurement == index && datum.sensor == sensor))
                };
                all.biases.push((all.list.len(), all.likelihood.data().iter().map(is_of_sensor).collect()));
                all.list.push(Source {
                    kind: Kind::Sensor(index, sensor),
                    phase: None,
                    time_s: None,
                    inputs: Vec::new(),
                });
            }
        }
        Ok(all)
    }

    /// The sources.
    pub fn list(&self) -> &[Source] {
        &self.list
    }

    fn add_measurement(
        &mut self,
        problem: &Problem,
        index: usize,
        fewer: &[Option<FewerRows>],
        is_wanted: &dyn Fn(Kind) -> bool,
    ) -> Result<(), NoHeat> {
        let measurement = &problem.measurements[index];
        let mut model = (*problem.model).clone();
        let nodes: Vec<usize> = (0..model.nodes.len())
            .filter(|&node| !matches!(model.nodes[node].kind, NodeKind::Boundary { .. }) && is_wanted(Kind::Node(node)))
            .collect();
        let data: Vec<(usize, usize)> = (self.likelihood.data().iter().enumerate())
            .filter(|(_, datum)| datum.measurement == index)
            .map(|(position, datum)| (position, datum.row))
            .collect();
        if data.is_empty() {
            // All of it is held out or ignored: no heat is sought there.
            return Ok(());
        }
        match &measurement.rows {
            Rows::Steady(phases) => {
                let names: Vec<String> =
                    nodes.iter().map(|&node| add_source(&mut model, node, 0, None)).collect::<Result<_, _>>()?;
                for (row, phase) in phases.iter().enumerate() {
                    let rows: Vec<usize> = data
                        .iter()
                        .filter(|(_, row_of_datum)| *row_of_datum == row)
                        .map(|(position, _)| *position)
                        .collect();
                    if rows.is_empty() {
                        continue;
                    }
                    let first = self.list.len();
                    self.list.extend(nodes.iter().map(|&node| Source {
                        kind: Kind::Node(node),
                        phase: Some(phase.name.clone()),
                        time_s: None,
                        inputs: phase.inputs.clone(),
                    }));
                    let mut alone = measurement.clone();
                    let width = alone.sensors.len();
                    for (place, reading) in alone.readings.iter_mut().enumerate() {
                        if place / width.max(1) != row {
                            *reading = None;
                        }
                    }
                    self.add_field(problem, &model, (index, &alone, &[]), rows, &names, first)?;
                }
            }
            Rows::Transient { inputs, .. } => {
                let first = self.list.len();
                let mut names = Vec::new();
                for &node in &nodes {
                    for (stretch, (middle, width)) in stretches(measurement).into_iter().enumerate() {
                        let shape = format!("max(0, 1 - abs(t - {middle:e}) / {width:e})");
                        names.push(add_source(&mut model, node, stretch, Some(&shape))?);
                        let row = inputs.times_s.partition_point(|&time| time < middle);
                        let row = row.min(inputs.times_s.len().saturating_sub(1));
                        self.list.push(Source {
                            kind: Kind::Node(node),
                            phase: None,
                            time_s: Some(middle),
                            inputs: (0..inputs.base.len()).map(|input| inputs.in_row(row, input)).collect(),
                        });
                    }
                }
                let rows = data.into_iter().map(|(position, _)| position).collect();
                self.add_field(problem, &model, (index, measurement, fewer), rows, &names, first)?;
            }
        }
        Ok(())
    }

    fn add_field(
        &mut self,
        problem: &Problem,
        model: &Model,
        (index, measurement, fewer): (usize, &Measurement, &[Option<FewerRows>]),
        rows: Vec<usize>,
        names: &[String],
        first: usize,
    ) -> Result<(), NoHeat> {
        let mut priors = problem.priors.clone();
        let mut parameters = problem.parameters.clone();
        for position in problem.priors.len()..model.parameters.len() {
            priors.push(Distribution::Uniform { lower: -UNBOUNDED_W, upper: UNBOUNDED_W });
            parameters.push(position);
        }
        let likelihood = Likelihood::new(&Definition {
            model,
            priors: &priors,
            parameters: &parameters,
            measurements: &[measurement],
            input_errors: &problem.input_errors,
        })
        .map_err(|error| NoHeat::NotMade(format!("in the rows of `{}`, {error}", measurement.name)))?;
        let likelihood = problem
            .informed(likelihood, problem.most_steps.get(index..=index).unwrap_or_default())
            .with_slopes_on(fewer);
        let of_believed: BTreeMap<&str, usize> =
            self.likelihood.names().iter().enumerate().map(|(place, name)| (name.as_str(), place)).collect();
        let unknown_names = likelihood.names().iter();
        let unknowns = unknown_names.clone().map(|name| of_believed.get(name.as_str()).copied()).collect();
        let sources = unknown_names
            .map(|name| names.iter().position(|source_name| source_name == name).map(|place| first + place))
            .collect();
        self.fields.push(Field { likelihood, rows, unknowns, sources });
        Ok(())
    }

    /// Linearises at unknowns (SI) and amplitudes of the sources. `None` where a phase cannot be solved so.
    pub fn at(&self, unknowns: &[f64], amplitudes: &[f64]) -> Option<State> {
        let (linear, of_fields) = rayon::join(
            || linearise(&self.likelihood, unknowns).ok(),
            || self.each_field(|field| linearise(&field.likelihood, &field.at(unknowns, amplitudes)).ok()),
        );
        let (mut linear, of_fields) = (linear?, of_fields?);
        let n = linear.parameters();
        let mut columns = vec![vec![0.0; linear.rows]; self.list.len()];
        for (field, field_linear) in self.fields.iter().zip(of_fields) {
            let width = field.unknowns.len();
            if field_linear.readings != field.rows.len() {
                return None;
            }
            for (row, &position) in field.rows.iter().enumerate() {
                linear.residuals[position] = field_linear.residuals[row];
                linear.jacobian[position * n..(position + 1) * n].fill(0.0);
                for place in 0..width {
                    let slope = field_linear.jacobian[row * width + place];
                    if let Some(unknown) = field.unknowns[place] {
                        linear.jacobian[position * n + unknown] = slope;
                    }
                    if let Some(source) = field.sources[place] {
                        columns[source][position] = slope;
                    }
                }
            }
        }
        for (source, column) in &self.biases {
            columns[*source][..column.len()].copy_from_slice(column);
            for (residual, value) in linear.residuals.iter_mut().zip(column) {
                *residual -= amplitudes[*source] * value;
            }
        }
        let half_square = 0.5 * dot(&linear.residuals, &linear.residuals);
        for (column, amplitude) in columns.iter().zip(amplitudes).filter(|(_, amplitude)| **amplitude != 0.0) {
            for (residual, value) in linear.residuals.iter_mut().zip(column) {
                *residual += amplitude * value;
            }
        }
        let (unknowns, amplitudes) = (unknowns.to_vec(), amplitudes.to_vec());
        half_square.is_finite().then_some(State { unknowns, amplitudes, linear, columns, half_square })
    }

    /// Applies a function to all fields side by side; `None` if it fails for one.
    fn each_field<T: Send>(&self, of: impl Fn(&Field) -> Option<T> + Send + Sync) -> Option<Vec<T>> {
        self.fields.par_iter().map(of).collect()
    }

    /// [`State::half_square`] alone.
    pub fn half_square(&self, unknowns: &[f64], amplitudes: &[f64]) -> Option<f64> {
        let (residuals, of_fields) = rayon::join(
            || self::residuals(&self.likelihood, unknowns),
            || self.each_field(|field| self::residuals(&field.likelihood, &field.at(unknowns, amplitudes))),
        );
        let mut residuals = residuals?;
        for (field, of_field) in self.fields.iter().zip(of_fields?) {
            for (&position, residual) in field.rows.iter().zip(of_field) {
                residuals[position] = residual;
            }
        }
        for (source, column) in &self.biases {
            for (residual, value) in residuals.iter_mut().zip(column) {
                *residual -= amplitudes[*source] * value;
            }
        }
        Some(0.5 * dot(&residuals, &residuals)).filter(|half_square| half_square.is_finite())
    }

    /// What the logarithm of an evidence of the whitened, standardised problem is short of that of the readings: the
    /// normalisation of the noise, which is settled, and of the priors, whose rows are standardised.
    pub fn constant(&self, state: &State, baseline: &Refit) -> Option<f64> {
        let linear = &state.linear;
        let objective = NaturalObjective::new(&self.likelihood).ok()?;
        let noise = baseline.log_likelihood + 0.5 * baseline.chi_square;
        let prior_rows = &linear.residuals[linear.readings..];
        let priors = objective.log_prior(&objective.coordinates(&state.unknowns)) + 0.5 * dot(prior_rows, prior_rows);
        let widths = objective.bounds();
        let widths = widths.lower.iter().zip(&widths.upper).map(|(lower, upper)| upper - lower);
        let widths: f64 = widths.filter(|width| width.is_finite()).map(ln).sum();
        Some(noise + priors + widths + 0.5 * linear.rows as f64 * ln(2.0 * std::f64::consts::PI))
    }

    /// Unknowns (SI) after a step of the baseline model's natural coordinates.
    pub fn stepped(&self, unknowns: &[f64], step: &[f64]) -> Option<Vec<f64>> {
        let objective = NaturalObjective::new(&self.likelihood).ok()?;
        let moved: Vec<f64> = objective.coordinates(unknowns).iter().zip(step).map(|(x, d)| x + d).collect();
        Some(objective.parameters(&moved))
    }
}

/// How many sources a problem has at most: heat of each node with a balance in each phase or stretch, and a bias of each sensor.
pub(in crate::diagnosis) fn count(problem: &Problem) -> usize {
    let nodes = problem.model.nodes.iter().filter(|node| !matches!(node.kind, NodeKind::Boundary { .. })).count();
    let of_measurement = |measurement: &Measurement| {
        let fitted = measurement.fitted_rows().count();
        let times = match &measurement.rows {
            Rows::Steady(_) => fitted,
            Rows::Transient { .. } => STRETCHES.min(fitted),
        };
        nodes * times + measurement.sensors.len()
    };
    problem.measurements.iter().map(of_measurement).sum::<usize>().min(MOST_SOURCES)
}

/// Whitened residuals at unknowns (SI), with the rows of the priors.
fn residuals(likelihood: &Likelihood, unknowns: &[f64]) -> Option<Vec<f64>> {
    let mut objective = NaturalObjective::new(likelihood).ok()?;
    let at = objective.coordinates(unknowns);
    let mut residuals = vec![0.0; objective.rows()];
    objective.value(&at, &mut residuals)?;
    Some(residuals)
}

/// Lengths of the columns; 0 for those that move nothing.
pub(super) fn norms(columns: &[Vec<f64>]) -> Vec<f64> {
    let norms: Vec<f64> = columns.iter().map(|column| dot(column, column).sqrt()).collect();
    let largest = norms.iter().copied().fold(0.0, f64::max);
    norms.into_iter().map(|norm| if norm > LEAST * largest { norm } else { 0.0 }).collect()
}

/// Middle and half width of the stretches of a transient, overlapping by half; none in steady data.
fn stretches(measurement: &Measurement) -> Vec<(f64, f64)> {
    let Rows::Transient { inputs, .. } = &measurement.rows else { return Vec::new() };
    let last = measurement.fitted_rows().max().map_or(0.0, |row| inputs.times_s[row]);
    let start = inputs.times_s.first().copied().unwrap_or(0.0);
    let width = (last - start) / (STRETCHES - 1) as f64;
    if !(width > 0.0) {
        return Vec::new();
    }
    (0..STRETCHES).map(|k| (start + width * k as f64, width)).collect()
}

/// Adds a source of 1 W per unit of a new parameter, whose name comes back.
fn add_source(model: &mut Model, node: usize, stretch: usize, shape: Option<&str>) -> Result<String, NoHeat> {
    let name = format!("missing heat {node} {stretch}");
    let of_node = |why: &str| NoHeat::NotMade(format!("in the node `{}`, {why}", model.nodes[node].name));
    let number = u32::try_from(model.parameters.len()).map_err(|_| of_node("there are too many parameters"))?;
    let mut power = model.graph.symbol(Symbol::Parameter(number));
    if let Some(shape) = shape {
        let shape = parse(shape, &mut model.graph, &Scope::with(&Names::default(), Vec::new()));
        let shape = shape.map_err(|_| NoHeat::NotMade(format!("`{name}` has no course")))?;
        power = model.graph.multiply(power, shape);
    }
    model.parameters.push(Parameter {
        name: name.clone(),
        unit: "W".to_owned(),
        nominal: 0.0,
        description: String::new(),
        source: String::new(),
    });
    model.elements.push(Element { name: name.clone(), kind: ElementKind::Load(Load { into: node, power }) });
    Ok(name)
}
