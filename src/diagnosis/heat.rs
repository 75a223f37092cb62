//! Heat that the believed model lacks, whatever its cause: in steady data independent in every node and phase, in
//! transients in every node and stretch of time, beside a bias of every sensor.
//!
//! With `H` the whitened effect of these sources, columns scaled to norm 1, and amplitudes `q ~ N(0, s^2)`, the residuals
//! freed of the parameters are normal with covariance `I + s^2 H H'`; so evidence and heat are known in closed form
//! (Rasmussen & Williams 2006, section 2.7). Nodes and sensors are added one by one, each with the best of four sizes s,
//! while the evidence rises by more than the logarithm of the number of choices.

use nalgebra::{DMatrix, DVector};

use super::evidence::{Amplitude, Evidence};
use super::output::{GoesWith, Heat};
use super::products::{dot, orthonormal, project_out};
use super::signature::linearise;
use super::{Problem, Refit};
use crate::expression::{Names, Scope, Symbol, parse};
use crate::inference::likelihood::{Definition, Likelihood};
use crate::inference::measurement::{Measurement, Rows};
use crate::inference::target::{LeastSquares, Target};
use crate::math::functions::ln;
use crate::math::special::student_t_cdf;
use crate::random::Distribution;
use crate::thermal::element::{Element, ElementKind, Load};
use crate::thermal::{Model, NodeKind, Parameter};

/// Most nodes and sensors.
const MOST_KINDS: usize = 4;
/// Sizes s that are tried, in standard deviations of the noise.
const SIZES: [f64; 4] = [1.0, 4.0, 16.0, 64.0];
/// Stretches of time of a transient.
const STRETCHES: usize = 16;
/// Most sources.
const MOST_SOURCES: usize = 600;
/// Sources that move nothing are left out: share of the largest column.
const LEAST: f64 = 1e-9;
/// p-value below which heat is said to go with an input.
const GOES: f64 = 0.01;

/// The heat that is missing.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MissingHeat {
    /// Log evidence of a model with such sources.
    pub log_evidence: f64,
    /// The heat of each node and phase or stretch.
    pub heat: Vec<Heat>,
    /// What it goes with.
    pub goes_with: Vec<GoesWith>,
}

/// What sources are of one kind: their sizes are alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Heat of a node.
    Node(usize),
    /// The bias of a sensor, by measurement and sensor.
    Sensor(usize, usize),
}

/// Kinds that the residuals need, with their sizes.
struct Needed {
    sizes: Vec<(Kind, f64)>,
    /// Log evidence above that without sources, less the price of the choice.
    gain: f64,
}

/// Adds the kind that raises the evidence most, while it pays for its choice among all kinds and sizes.
fn needed(evidence: &Evidence<'_>, sources: &[Source], columns: &[Vec<f64>]) -> Option<Needed> {
    let without = evidence.log_evidence(&[])?;
    let mut kinds: Vec<Kind> = Vec::new();
    for source in sources {
        if !kinds.contains(&source.kind) {
            kinds.push(source.kind);
        }
    }
    let price = ln((kinds.len() * SIZES.len()) as f64);
    let mut needed = Needed { sizes: Vec::new(), gain: 0.0 };
    while needed.sizes.len() < MOST_KINDS {
        let mut best: Option<(f64, Kind, f64)> = None;
        for &kind in kinds.iter().filter(|kind| !needed.sizes.iter().any(|(known, _)| known == *kind)) {
            for size in SIZES {
                let with: Vec<(Kind, f64)> = needed.sizes.iter().copied().chain([(kind, size)]).collect();
                let added: Vec<Amplitude<'_>> = sources
                    .iter()
                    .zip(columns)
                    .filter_map(|(source, column)| {
                        let (_, sd) = with.iter().find(|(own, _)| *own == source.kind)?;
                        Some(Amplitude { values: column, sd: *sd, lower: f64::NEG_INFINITY, upper: f64::INFINITY })
                    })
                    .collect();
                let Some(value) = evidence.log_evidence(&added) else { continue };
                let gain = value - without - with.len() as f64 * price;
                if best.is_none_or(|(known, _, _)| gain > known) {
                    best = Some((gain, kind, size));
                }
            }
        }
        match best {
            Some((gain, kind, size)) if gain > needed.gain => {
                needed.sizes.push((kind, size));
                needed.gain = gain;
            }
            _ => break,
        }
    }
    Some(needed)
}

/// A source and where it acts.
struct Source {
    kind: Kind,
    phase: Option<String>,
    time_s: Option<f64>,
    /// Inputs there, SI.
    inputs: Vec<f64>,
    column: Vec<f64>,
    norm: f64,
}

/// The heat that a fit of the believed model lacks. `None` for networks that are too large or that cannot be solved so.
pub(super) fn missing_heat(problem: &Problem, believed: &Refit) -> Option<MissingHeat> {
    let likelihood = problem.hypothesis(&[], 1.0).ok()?.likelihood(problem).ok()?;
    let linear = linearise(&likelihood, &believed.unknowns).ok()?;
    let rows = linear.rows;
    let mut sources = Vec::new();
    let mut first = 0;
    for measurement in &problem.measurements {
        let own = likelihood_rows(&likelihood, problem, measurement);
        heat_columns(problem, measurement, believed, first, rows, &mut sources)?;
        first += own;
    }
    bias_columns(problem, &likelihood, rows, &mut sources);
    let largest = sources.iter().map(|source| source.norm).fold(0.0, f64::max);
    sources.retain(|source| source.norm > LEAST * largest);
    if sources.is_empty() || sources.len() > MOST_SOURCES {
        return None;
    }
    // Free of the parameters that are not held at a bound.
    let n = linear.parameters();
    let free: Vec<usize> = (0..n).filter(|&i| linear.lower[i] < 0.0 && linear.upper[i] > 0.0).collect();
    let slopes: Vec<Vec<f64>> =
        free.iter().map(|&i| (0..rows).map(|row| linear.jacobian[row * n + i]).collect()).collect();
    let slopes: Vec<&[f64]> = slopes.iter().map(Vec::as_slice).collect();
    let (basis, _) = orthonormal(&slopes, Vec::new(), 1e-10);
    let mut residual = linear.residuals.clone();
    project_out(&mut residual, &basis);
    let mut whole = Vec::new();
    for source in &mut sources {
        for value in &mut source.column {
            *value /= source.norm;
        }
        whole.push(source.column.clone());
        project_out(&mut source.column, &basis);
    }
    let chosen = needed(&Evidence::new(&linear), &sources, &whole)?;
    let places: Vec<(usize, f64)> = (0..sources.len())
        .filter_map(|place| {
            chosen.sizes.iter().find(|(kind, _)| *kind == sources[place].kind).map(|(_, size)| (place, *size))
        })
        .collect();
    let count = places.len();
    let column = |a: usize| sources[places[a].0].column.as_slice();
    let mut matrix = DMatrix::from_fn(count, count, |a, b| dot(column(a), column(b)));
    for a in 0..count {
        matrix[(a, a)] += 1.0 / (places[a].1 * places[a].1);
    }
    let right = DVector::from_fn(count, |a, _| dot(column(a), &residual));
    let factor = matrix.cholesky()?;
    let (mean, covariance) = (factor.solve(&right), factor.inverse());
    let log_evidence = believed.log_evidence + chosen.gain;
    let mut heat = Vec::new();
    for (position, &(place, _)) in places.iter().enumerate() {
        let source = &sources[place];
        let Kind::Node(node) = source.kind else { continue };
        heat.push(Heat {
            node: problem.model.nodes[node].name.clone(),
            phase: source.phase.clone(),
            time_s: source.time_s,
            watts: mean[position] / source.norm,
            sd: covariance[(position, position)].max(0.0).sqrt() / source.norm,
        });
    }
    let watts: Vec<(&Source, f64)> =
        places.iter().zip(mean.iter()).map(|(&(place, _), q)| (&sources[place], q / sources[place].norm)).collect();
    let goes_with = relations(problem, &watts);
    Some(MissingHeat { log_evidence, heat, goes_with })
}

/// Number of fitted readings of a measurement.
fn likelihood_rows(likelihood: &Likelihood, problem: &Problem, measurement: &Measurement) -> usize {
    let index = problem.measurements.iter().position(|other| other.name == measurement.name);
    likelihood.data().iter().filter(|datum| Some(datum.measurement) == index).count()
}

/// Columns of the sources of one measurement, whose rows begin at `first`.
fn heat_columns(
    problem: &Problem,
    measurement: &Measurement,
    believed: &Refit,
    first: usize,
    rows: usize,
    sources: &mut Vec<Source>,
) -> Option<()> {
    let mut model = (*problem.model).clone();
    let mut priors = problem.priors.clone();
    let mut parameters = problem.parameters.clone();
    let nodes: Vec<usize> =
        (0..model.nodes.len()).filter(|&node| !matches!(model.nodes[node].kind, NodeKind::Boundary { .. })).collect();
    let stretches = stretches(measurement);
    if nodes.len() * stretches.len().max(1) > MOST_SOURCES {
        return None;
    }
    for &node in &nodes {
        for stretch in 0..stretches.len().max(1) {
            let shape =
                stretches.get(stretch).map(|(middle, width)| format!("max(0, 1 - abs(t - {middle:e}) / {width:e})"));
            add_source(&mut model, node, stretch, shape.as_deref())?;
            priors.push(Distribution::Normal { mean: 0.0, sd: 1.0, lower: None, upper: None });
            parameters.push(model.parameters.len() - 1);
        }
    }
    let likelihood = Likelihood::new(&Definition {
        model: &model,
        priors: &priors,
        parameters: &parameters,
        measurements: &[measurement],
        input_errors: &problem.input_errors,
    })
    .ok()?;
    let known = believed.by_name();
    let at: Vec<f64> = likelihood.names().iter().map(|name| known.get(name).copied().unwrap_or(0.0)).collect();
    let (own, n) = (likelihood.residual_count(), likelihood.dimension());
    let (mut residuals, mut jacobian, mut gradient) = (vec![0.0; own], vec![0.0; own * n], vec![0.0; n]);
    likelihood.jacobian(&at, &mut likelihood.workspace(), &mut residuals, &mut jacobian, &mut gradient).ok()?;
    let before = problem.parameters.len();
    let mut place = before;
    for &node in &nodes {
        for stretch in 0..stretches.len().max(1) {
            let whole: Vec<f64> = (0..own).map(|row| -jacobian[row * n + place]).collect();
            place += 1;
            match &measurement.rows {
                Rows::Steady(phases) => {
                    for (row, phase) in phases.iter().enumerate() {
                        let mut column = vec![0.0; rows];
                        let mut any = false;
                        for (position, datum) in likelihood.data().iter().enumerate().filter(|(_, d)| d.row == row) {
                            column[first + position] = whole[position];
                            any |= datum.row == row;
                        }
                        if any {
                            sources.push(Source::new(
                                Kind::Node(node),
                                Some(phase.name.clone()),
                                None,
                                phase.inputs.clone(),
                                column,
                            ));
                        }
                    }
                }
                Rows::Transient { inputs, .. } => {
                    let mut column = vec![0.0; rows];
                    column[first..first + own].copy_from_slice(&whole);
                    let (middle, _) = stretches[stretch];
                    let row = inputs.times_s.partition_point(|&time| time < middle).min(inputs.times_s.len() - 1);
                    let values = (0..inputs.base.len()).map(|input| inputs.in_row(row, input)).collect();
                    sources.push(Source::new(Kind::Node(node), None, Some(middle), values, column));
                }
            }
        }
    }
    Some(())
}

impl Source {
    fn new(kind: Kind, phase: Option<String>, time_s: Option<f64>, inputs: Vec<f64>, column: Vec<f64>) -> Self {
        let norm = dot(&column, &column).sqrt();
        Self { kind, phase, time_s, inputs, column, norm }
    }
}

/// Middle and half width of the stretches of a transient, overlapping by half; none in steady data.
fn stretches(measurement: &Measurement) -> Vec<(f64, f64)> {
    let Rows::Transient { inputs, .. } = &measurement.rows else { return Vec::new() };
    let fitted = (0..measurement.len()).filter(|&row| !measurement.held_out(row) && !measurement.ignored(row));
    let last = fitted.max().map_or(0.0, |row| inputs.times_s[row]);
    let start = inputs.times_s.first().copied().unwrap_or(0.0);
    let width = (last - start) / (STRETCHES - 1) as f64;
    if !(width > 0.0) {
        return Vec::new();
    }
    (0..STRETCHES).map(|k| (start + width * k as f64, width)).collect()
}

/// Adds a source of 1 W per unit of a new parameter.
fn add_source(model: &mut Model, node: usize, stretch: usize, shape: Option<&str>) -> Option<()> {
    let name = format!("missing heat {node} {stretch}");
    let symbol = Symbol::Parameter(u32::try_from(model.parameters.len()).ok()?);
    let mut power = model.graph.symbol(symbol);
    if let Some(shape) = shape {
        let shape = parse(shape, &mut model.graph, &Scope::with(&Names::default(), Vec::new())).ok()?;
        power = model.graph.multiply(power, shape);
    }
    model.parameters.push(Parameter {
        name: name.clone(),
        unit: "W".to_owned(),
        nominal: 0.0,
        description: String::new(),
        source: String::new(),
    });
    model.elements.push(Element { name, kind: ElementKind::Load(Load { into: node, power }) });
    Some(())
}

/// A bias of every sensor; whitened it is a constant of its readings.
fn bias_columns(problem: &Problem, likelihood: &Likelihood, rows: usize, sources: &mut Vec<Source>) {
    for (index, measurement) in problem.measurements.iter().enumerate() {
        for sensor in 0..measurement.sensors.len() {
            let mut column = vec![0.0; rows];
            for (position, datum) in likelihood.data().iter().enumerate() {
                if datum.measurement == index && datum.sensor == sensor {
                    column[position] = 1.0;
                }
            }
            sources.push(Source::new(Kind::Sensor(index, sensor), None, None, Vec::new(), column));
        }
    }
}

/// Inputs that a node's missing heat goes with, by linear regression over its phases or stretches.
fn relations(problem: &Problem, watts: &[(&Source, f64)]) -> Vec<GoesWith> {
    let nodes: Vec<usize> = (0..problem.model.nodes.len()).collect();
    let tests = (nodes.len() * problem.model.inputs.len()).max(1) as f64;
    let mut found = Vec::new();
    for node in nodes {
        let own: Vec<&(&Source, f64)> = watts.iter().filter(|(source, _)| source.kind == Kind::Node(node)).collect();
        let heat: Vec<f64> = own.iter().map(|(_, watts)| *watts).collect();
        if own.len() < 4 {
            continue;
        }
        for (input, entry) in problem.model.inputs.iter().enumerate() {
            let x: Vec<f64> = own.iter().filter_map(|(source, _)| source.inputs.get(input).copied()).collect();
            if x.len() != heat.len() {
                continue;
            }
            let count = x.len() as f64;
            let (mx, my) = (x.iter().sum::<f64>() / count, heat.iter().sum::<f64>() / count);
            let sxx: f64 = x.iter().map(|v| (v - mx) * (v - mx)).sum();
            let sxy: f64 = x.iter().zip(&heat).map(|(v, w)| (v - mx) * (w - my)).sum();
            let syy: f64 = heat.iter().map(|w| (w - my) * (w - my)).sum();
            if !(sxx > 0.0 && syy > 0.0) {
                continue;
            }
            let square = (sxy * sxy / (sxx * syy)).min(1.0 - 1e-15);
            let t = (square * (count - 2.0) / (1.0 - square)).sqrt();
            let p = (tests * 2.0 * student_t_cdf(-t, count - 2.0)).min(1.0);
            if p < GOES {
                found.push(GoesWith {
                    node: problem.model.nodes[node].name.clone(),
                    input: entry.name.clone(),
                    slope: sxy / sxx,
                    p,
                });
            }
        }
    }
    found.sort_by(|a, b| a.p.total_cmp(&b.p));
    found
}
