//! A propagation for other programs: quantities and requirements by name.

use serde_json::{Map, Value, json};

use super::output::{Case, Distributed, Met, Output};
use crate::study::requirement::ALL;

/// The document of `show --json`: everything in SI.
///
/// `quantities`, `probability` and `failed` are of the nominal design in the first environment, which `environment`
/// names; `cases` has the same for every environment and design value, the nominal design (`design_value` null) first.
/// With draws in place of priors, `posterior_priors` says which, and `converged` whether their chains did.
/// `probability` always has `all`, also where there is but one requirement.
pub fn view(output: &Output) -> Value {
    let cases: Vec<Value> = output.cases.iter().map(case).collect();
    let first = cases.first();
    let of_first = |name: &str| first.map_or(Value::Null, |case| case[name].clone());
    let mut document = json!({
        "environment": of_first("environment"),
        "quantities": of_first("quantities"),
        "probability": of_first("probability"),
        "main": of_first("main"),
        "samples": output.samples,
        "failed": of_first("failed"),
        "sampling": output.sampling,
        "design_variable": output.design_variable,
        "design_written_unit": output.design_unit,
        "cases": cases,
        "reached": output.reached,
    });
    if !output.posterior_priors.is_empty() {
        document["posterior_priors"] = json!(output.posterior_priors);
        document["converged"] = json!(output.converged);
    }
    document
}

fn case(case: &Case) -> Value {
    let quantities: Map<String, Value> = case.quantities.iter().map(|q| (q.name.clone(), distribution(q))).collect();
    let mut probability: Map<String, Value> =
        case.requirements.iter().map(|met| (met.requirement.clone(), requirement(met))).collect();
    if let [only] = case.requirements.as_slice() {
        probability.insert(ALL.to_owned(), requirement(only));
    }
    json!({
        "environment": case.environment,
        "design_value": case.design_value,
        "quantities": quantities,
        "probability": probability,
        "failed": case.failed,
        "failures": case.failures,
        "joint": case.joint,
        "main": main_effects(case),
    })
}

/// Main effects by quantity then parameter.
fn main_effects(case: &Case) -> Value {
    let mut main: Map<String, Value> = Map::new();
    for effect in &case.main_effects {
        let entry = main.entry(effect.quantity.clone()).or_insert_with(|| json!({}));
        entry[effect.parameter.as_str()] = json!(effect.estimate);
    }
    Value::Object(main)
}

fn requirement(met: &Met) -> Value {
    json!({
        "value": met.probability.value,
        "lower": met.probability.lower,
        "upper": met.probability.upper,
        "required": met.required,
        "limit_below": met.below,
        "limit_above": met.above,
        "quantity": Some(&met.quantity).filter(|name| !name.is_empty()),
        "unit": Some(&met.unit).filter(|unit| !unit.is_empty()),
    })
}

fn distribution(q: &Distributed) -> Value {
    let by_probability = |value: fn(&super::Quantile) -> f64| -> Map<String, Value> {
        q.quantiles.iter().map(|quantile| (quantile.probability.to_string(), json!(value(quantile)))).collect()
    };
    json!({
        "unit": q.unit,
        "is_temperature": q.is_temperature,
        "nominal": q.nominal,
        "mean": q.mean,
        "mean_standard_error": q.mean_standard_error,
        "sd": q.sd,
        "sd_standard_error": q.sd_standard_error,
        "minimum": q.minimum,
        "maximum": q.maximum,
        "quantiles": by_probability(|quantile| quantile.value),
        "quantile_standard_errors": by_probability(|quantile| quantile.standard_error),
        "histogram_edges": q.histogram_edges,
        "histogram_counts": q.histogram_counts,
        "cdf": q.cdf,
    })
}
