//! What a discrepancy job adds to the samples of a prediction.

use std::sync::Arc;

use serde::Deserialize as _;
use serde_json::{Value, json};

use super::run::{Added, Term};
use crate::job::JobError;
use crate::job::discrepancy::{self, Case, Rebuilt};
use crate::job::propagate::{Adjustment, CaseInputs, Propagate};
use crate::math::sort::sort_by_key;
use crate::study::posterior_prior::PosteriorPrior;
use crate::study::resolved::PosteriorReference;

/// What is added.
pub(super) struct Laws {
    /// A sensor each.
    pub adjustments: Vec<Adjustment>,
    /// By case, then sensor.
    pub terms: Vec<Term>,
    /// Whether the chains behind it converged.
    pub converged: bool,
    /// The posterior of the parameters that was had together with the laws, where it was.
    pub posterior: Option<PosteriorPrior>,
}

/// What of the job decides a prediction beside its key.
pub(super) fn identity(added: &Added) -> Value {
    json!({ "source": added.source, "sensors": added.sensors })
}

/// From the results of the calibration whose posterior is carried and of the discrepancy job after it.
///
/// Each sample takes the discrepancy that belongs to its draw of the posterior: the residuals behind it at that draw, by their
/// slopes with the unknowns.
///
/// # Errors
/// Results that do not belong together.
pub(super) fn laws(
    added: &Added,
    propagate: &Propagate,
    posterior: &PosteriorReference,
    calibration: &Arc<Value>,
    law: &Arc<Value>,
) -> Result<Laws, JobError> {
    let failed = |reason: String| JobError::Failed(format!("the discrepancy of {}: {reason}", added.source));
    let output = discrepancy::Output::deserialize(law.as_ref()).map_err(|error| failed(error.to_string()))?;
    let mut all = posterior.draws.clone();
    all.names.clone_from(&output.unknowns);
    all.parameters = vec![usize::MAX; output.unknowns.len()];
    // Parameters that were inferred together with the laws have a posterior of their own.
    let joint = output.joint.as_ref().and_then(|_| law.get("joint"));
    let draws = all.filled(joint.unwrap_or(calibration))?.draws;
    let of_joint = joint.map(|joint| posterior.draws.filled(joint)).transpose()?;
    let deviation =
        |draw: &Vec<f64>| -> Vec<f64> { draw.iter().zip(&output.means).map(|(value, mean)| value - mean).collect() };
    let deviations: Arc<Vec<Vec<f64>>> = Arc::new(draws.iter().map(deviation).collect());
    let cases = propagate.described();
    let (is_paired, converged) = (of_joint.is_some(), output.converged);
    let mut laws = Laws { adjustments: Vec::new(), terms: Vec::new(), converged, posterior: of_joint };
    for (name, positions) in &added.sensors {
        let own = output.sensors.iter().find(|own| own.sensor == *name);
        let own = own.ok_or_else(|| failed(format!("it has no sensor `{name}`")))?;
        let rebuilt = Rebuilt::new(&output, own).map_err(|error| failed(error.to_string()))?;
        let deviations = Arc::clone(&deviations);
        let mut adjustment = Adjustment { positions: positions.clone(), cases: Vec::new(), deviations, is_paired };
        for CaseInputs { environment, design_value, inputs } in &cases {
            let value = |input: &String| inputs.iter().find(|(name, _)| name == input).map(|(_, value)| *value);
            let values = output
                .inputs
                .iter()
                .map(|input| value(input).ok_or_else(|| failed(format!("this model has no input `{input}`"))));
            let case: Case = rebuilt.at(&values.collect::<Result<Vec<f64>, _>>()?);
            let (mean, sd) = case.moments();
            laws.terms.push(Term {
                environment: environment.clone(),
                design_value: *design_value,
                sensor: name.clone(),
                quantities: positions.iter().map(|&position| propagate.quantity_name(position)).collect(),
                law: own.law.words().to_owned(),
                unit: own.unit.clone(),
                mean,
                sd,
                outside: output.outside(inputs),
                distance: case.distance,
            });
            adjustment.cases.push(case.draws);
        }
        laws.adjustments.push(adjustment);
    }
    // By case, then sensor: as people read them.
    let order = |term: &Term| {
        let same = |case: &CaseInputs| case.environment == term.environment && case.design_value == term.design_value;
        cases.iter().position(same)
    };
    sort_by_key(&mut laws.terms, order);
    Ok(laws)
}
