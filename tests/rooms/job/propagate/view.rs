//! Tests of `src/job/propagate/view.rs`.

use bmv::job::propagate::output::{Case, Distributed, Met, Output};
use bmv::job::propagate::view::*;
use bmv::job::propagate::{Probability, Quantile};
use serde_json::json;

fn met(name: &str, value: f64) -> Met {
    Met {
        requirement: name.into(),
        probability: Probability { value, lower: value - 0.01, upper: value + 0.01 },
        required: 0.9,
        below: Some(308.15),
        above: None,
        unit: "K".into(),
        quantity: "T".into(),
    }
}

fn output(requirements: Vec<Met>) -> Output {
    let quantity = Distributed {
        name: "T".into(),
        unit: "K".into(),
        is_temperature: true,
        nominal: 299.0,
        mean: 300.0,
        mean_standard_error: 0.1,
        sd: 3.0,
        sd_standard_error: 0.2,
        minimum: 290.0,
        maximum: 310.0,
        quantiles: vec![
            Quantile { probability: 0.01, value: 293.0, standard_error: 0.5 },
            Quantile { probability: 0.5, value: 300.0, standard_error: 0.1 },
        ],
        histogram_edges: vec![],
        histogram_counts: vec![],
        cdf: vec![],
    };
    let case = |environment: &str, design_value, failed| Case {
        environment: environment.into(),
        design_value,
        quantities: vec![quantity.clone()],
        requirements: requirements.clone(),
        joint: vec![],
        main_effects: vec![],
        failed,
        failures: vec![],
    };
    Output {
        samples: 100,
        sampling: "sobol".into(),
        design_variable: Some("A".into()),
        design_unit: "m2".into(),
        cases: vec![case("hot", None, 2), case("hot", Some(0.3), 5)],
        reached: vec![],
        posterior_priors: vec![],
        discrepancy: vec![],
        converged: None,
    }
}

#[test]
fn quantities_and_probabilities_go_by_name() {
    let document = view(&output(vec![met("r", 0.95), met("q", 0.8), met("all", 0.79)]));
    assert_eq!(document["quantities"]["T"]["quantiles"]["0.01"], 293.0);
    assert_eq!(document["quantities"]["T"]["quantiles"]["0.5"], 300.0);
    assert_eq!(
        (&document["probability"]["q"]["value"], &document["probability"]["all"]["value"]),
        (&json!(0.8), &json!(0.79))
    );
    assert_eq!((&document["environment"], &document["failed"]), (&json!("hot"), &json!(2)));
    assert_eq!(document["cases"][1]["design_value"], 0.3);
}

#[test]
fn one_requirement_is_all_of_them_and_none_is_nothing() {
    let document = view(&output(vec![met("r", 0.95)]));
    assert_eq!(document["probability"]["all"], document["probability"]["r"]);
    assert_eq!(view(&output(vec![]))["probability"], json!({}));
}
