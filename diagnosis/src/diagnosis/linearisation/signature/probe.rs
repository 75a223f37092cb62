//! Effects that are not smooth at amplitude 0, by finite values.

use super::{Base, Found};
use crate::diagnosis::FitError;
use crate::diagnosis::error::NoDirection;
use crate::diagnosis::hypothesis::Hypothesis;
use crate::diagnosis::linearisation::linear::Direction;
use crate::effect::form::Sign;
use crate::effect::{Applied, Effect, EffectParameter};
use crate::inference::likelihood::Likelihood;
use crate::inference::target::{LeastSquares, Target};
use crate::measurement::unknown::start_name;
use crate::measurement::{Initial, Rows, Uncertain};
use crate::random::Distribution;

/// Most probes of an effect.
const MOST_PROBES: usize = 9;

/// How many times as large probes are where the model is wrong everywhere.
const FAR: f64 = 30.0;

/// A model with an effect, and the values at which this is tried.
pub(super) struct Probes {
    /// The model with the effect.
    pub hypothesis: Hypothesis,
    /// What the effect added.
    pub applied: Applied,
    /// Values of its parameters, SI.
    pub values: Vec<Vec<f64>>,
}

impl Probes {
    /// Those of a candidate.
    pub fn new(base: &Base<'_>, position: usize, effect: &Effect) -> Result<Self, FitError> {
        let problem = base.problem;
        let candidate = &problem.candidates[position];
        let written = effect.parameters(&problem.model, &candidate.bound);
        let mut hypothesis = problem.hypothesis(&[], 1.0)?;
        let parameters: Vec<EffectParameter> = written
            .iter()
            .map(|parameter| EffectParameter {
                // Any prior with spread makes an unknown of a parameter. At amplitude 0 the covariance is that without it.
                prior: Distribution::Uniform { lower: -1.0, upper: 1.0 },
                nominal: if parameter.amplitude { 0.0 } else { parameter.nominal },
                ..parameter.clone()
            })
            .collect();
        let applied = hypothesis.add_as(problem, candidate, effect, &candidate.id, parameters)?;
        let near = probes(&written);
        let mut values = near.clone();
        if problem.is_misspecified {
            // There a part may be far larger than what is plausible, and near ones may not lead to it.
            let far = |probe: &Vec<f64>| -> Vec<f64> {
                let of = |(value, parameter): (&f64, &EffectParameter)| {
                    if parameter.amplitude { FAR * value } else { *value }
                };
                probe.iter().zip(&written).map(of).collect()
            };
            values.extend(near.iter().map(far));
        }
        Ok(Self { hypothesis, applied, values })
    }
}

/// The directions of an effect's probes.
pub(super) fn directions(base: &Base<'_>, position: usize, effect: &Effect) -> Found {
    let Probes { mut hypothesis, applied, values } = Probes::new(base, position, effect)?;
    begin_as_fitted(base, &mut hypothesis, &applied.nodes);
    let mut likelihood = hypothesis.likelihood(base.problem)?;
    if likelihood.residual_count() != base.residuals.len() {
        return Err(NoDirection::ChangesMeasurement.into());
    }
    let model_parameters = base.likelihood.model_parameters();
    let mut unknowns = base.carried(&likelihood);
    let mut memory = likelihood.workspace();
    let mut probe_directions: Vec<Direction> = Vec::new();
    let mut solved = false;
    for probe in values {
        unknowns[model_parameters..model_parameters + probe.len()].copy_from_slice(&probe);
        let Some(residuals) = evaluate(&mut likelihood, &unknowns, &mut memory) else { continue };
        solved = true;
        let mut columns: Vec<f64> =
            base.residuals.iter().zip(&residuals).map(|(before, after)| before - after).collect();
        let usable = columns.iter().all(|value| value.is_finite()) && columns.iter().any(|value| *value != 0.0);
        columns.resize(base.rows, 0.0);
        // A parameter that the data do not see gives the same column again.
        if usable && probe_directions.iter().all(|other| other.columns != columns) {
            probe_directions.push(share(position, columns, probe));
        }
    }
    match (probe_directions.is_empty(), solved) {
        (false, _) => Ok(probe_directions),
        (true, true) => Err(NoDirection::NoReading.into()),
        (true, false) => Err(NoDirection::NoSolution.into()),
    }
}

/// A direction whose amplitude is a share of what made its column.
pub(super) fn share(candidate: usize, columns: Vec<f64>, probe: Vec<f64>) -> Direction {
    Direction {
        candidate,
        columns,
        lower: vec![0.0],
        upper: vec![f64::INFINITY],
        plausible: vec![1.0],
        probe,
        ..Direction::default()
    }
}

/// Residuals, from where the model without the effect stands or, where that does not lead there, from afresh.
fn evaluate(
    likelihood: &mut Likelihood,
    unknowns: &[f64],
    memory: &mut <Likelihood as Target>::Workspace,
) -> Option<Vec<f64>> {
    let mut residuals = vec![0.0; likelihood.residual_count()];
    if likelihood.residuals(unknowns, memory, &mut residuals).is_err() {
        likelihood.set_reference(unknowns);
        likelihood.residuals(unknowns, memory, &mut residuals).ok()?;
    }
    Some(residuals)
}

/// Nodes that were added begin at their hosts' fitted temperatures.
fn begin_as_fitted(base: &Base<'_>, hypothesis: &mut Hypothesis, added: &[(usize, usize)]) {
    let unknowns = base.likelihood.unknowns();
    for measurement in &mut hypothesis.measurements {
        let name = measurement.name.clone();
        let Rows::Transient { initial: Initial::Temperatures { values, shared, .. }, .. } = &mut measurement.rows
        else {
            continue;
        };
        for &(node, host) in added.iter().filter(|(node, _)| !shared.contains(node)) {
            let host = hypothesis.model.nodes.get(host).map_or("", |node| node.name.as_str());
            let place = unknowns.names.iter().position(|unknown| *unknown == start_name(&name, host));
            if let (Some(value), Some(place)) = (values.get_mut(node), place) {
                *value = Uncertain::Known(base.unknowns[place]);
            }
        }
    }
}

/// Values of all parameters: the product of the amplitudes' probes, the others at their nominal values.
fn probes(parameters: &[EffectParameter]) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = vec![Vec::new()];
    for parameter in parameters {
        let values = match (parameter.amplitude, parameter.probes.as_slice()) {
            (false, _) => vec![parameter.nominal],
            (true, []) => match parameter.sign {
                Sign::Positive => vec![parameter.plausible],
                Sign::Negative => vec![-parameter.plausible],
                Sign::Either => vec![-parameter.plausible, parameter.plausible],
            },
            (true, probes) => probes.to_vec(),
        };
        all = all.iter().flat_map(|before| values.iter().map(move |&v| [before.as_slice(), &[v]].concat())).collect();
    }
    let count = all.len();
    if count > MOST_PROBES {
        // Spread over the product, its ends among them.
        all = (0..MOST_PROBES).map(|k| all[k * (count - 1) / (MOST_PROBES - 1)].clone()).collect();
    }
    all
}
