//! Tests of `core/src/diagnosis/verdict/words.rs`.

use std::sync::Arc;

use bmv::diagnosis::Problem;
use bmv::diagnosis::output::{EffectResult, StoryStep};
use bmv::diagnosis::verdict::words::*;
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::measurement::Rows;
use bmv::thermal::{Input, NodeKind};
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};

#[test]
fn a_misfit_is_called_clear_only_where_the_tests_find_one() {
    assert_eq!(clearness(0.96, 0.01), "the tests find no misfit in that (p = 0.96)");
    let found = clearness(0.0, 0.01);
    assert!(found.starts_with("that is a misfit (p < 1e-6, "), "{found}");
}

/// An effect with this most probable conductance, W/K.
fn effect(most_probable: f64) -> EffectResult {
    let amount = serde_json::json!({"value": 0.0307, "sd": 0.0131, "most_probable": most_probable, "unit": "W/K", "at_bound": false});
    serde_json::from_value(serde_json::json!({
        "id": "a:x", "effect": "a", "title": "A", "where": ["x"], "where_kind": "node", "input": null, "probability": 0.9,
        "log_bayes_factor": 9.0, "log_bayes_factor_scales": null, "group": null, "amplitudes": {"conductance": amount},
        "rmse_k": {"train": [null, null], "held_out": [null, null]}, "watts": null, "confused_with": [], "separate": ""
    }))
    .expect("an effect")
}

#[test]
fn why_errors_of_the_model_may_be_it_is_said_where_it_is_so() {
    let of = |model_error: f64, prior_width: f64| {
        or_model_error(&EffectResult { model_error, prior_width, ..effect(0.03) }, Likeness::None)
    };
    assert!(of(0.04, 1.0).is_empty());
    assert_eq!(of(0.13, 1.0), " Errors of the model itself explain as much with probability 13.0 %.");
    assert!(of(0.5, 10.0).starts_with(" It explains less than what else is missing"));
    assert_eq!(
        of(0.5, 100.0),
        " Errors of the model itself may be all that it stands for: half of the probability is given to them."
    );
    let pulled = or_model_error(&EffectResult { model_error: 0.5, ..effect(0.03) }, Likeness::Gradient);
    assert!(pulled.starts_with(" A gradient within the node would read the same"), "{pulled}");
    let warm = or_model_error(&EffectResult { model_error: 0.5, ..effect(0.03) }, Likeness::Source);
    assert!(warm.starts_with(" These surroundings are warmer than every boundary"), "{warm}");
}

/// Unseen rows are the reason only where the next effect is more probable than nothing: many weak ones together may be so too.
#[test]
fn a_story_ends_for_want_of_probability_or_by_the_unseen_rows() {
    let rmse = serde_json::json!({"train": [0.9, 0.9], "held_out": [0.9, 0.9]});
    let step = |effect: Option<&str>| -> StoryStep {
        let whole =
            serde_json::json!({"effect": effect, "probability": 0.2, "rmse_k": rmse, "alternatives": ["heat-load:x"]});
        serde_json::from_value(whole).expect("a step")
    };
    let of = |is_outweighed: bool| ends(&step(None), is_outweighed).expect("an end");
    assert!(of(true).contains("heat-load:x would be more probable than nothing"), "{}", of(true));
    assert!(of(false).contains("probability of 20.0 %") && !of(false).contains("unseen"), "{}", of(false));
    assert_eq!(ends(&step(Some("sensor-bias:x")), true), None);
}

#[test]
fn the_value_that_is_adopted_stands_beside_a_mean_that_lies_elsewhere() {
    assert_eq!(size(&effect(0.0308)), ", conductance 0.031 ± 0.013 W/K");
    assert_eq!(size(&effect(0.0347)), ", conductance 0.031 ± 0.013 W/K (most probable with all others 0.03470 W/K)");
}

#[test]
fn sizes_are_read_with_their_errors() {
    assert_eq!(with_error(0.05143, 0.00273), "0.0514 ± 0.0027");
    assert_eq!(with_error(8_680_000.0, 449_161.0), "(8.68 ± 0.45)e6");
    assert_eq!(with_error(-1234.0, 250.0), "(-1.23 ± 0.25)e3");
    assert_eq!(with_error(1.0, 0.0), "1.00 ± 0");
    assert_eq!(with_error(1.0, 1e-8), "1.00 ± 1.0e-8");
    assert_eq!(with_error(f64::NAN, 1.0), "NaN ± 1.0");
    assert_eq!(short(-0.0, 2), "0");
}

/// A star in a steady test, and its effects at their places.
fn star() -> Problem {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, InjectionRequest::default());
    case(&catalogue, &recipe, 1, 0).expect("a case").problem
}

#[test]
fn a_phase_beyond_what_was_set_is_said_with_what_keeps_it_out() {
    let problem = star();
    let input = &problem.model.inputs[0];
    let values: Vec<f64> = match &problem.measurements[0].rows {
        Rows::Steady(phases) => phases.iter().map(|phase| phase.inputs[0]).collect(),
        Rows::Transient { .. } => panic!("steady"),
    };
    let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let said = |value: f64| {
        let conditions = serde_json::json!({&input.name: {"value": value, "unit": ""}});
        let experiment =
            serde_json::from_value(serde_json::json!({"between": [], "conditions": conditions, "probability": 0.9,
            "repeat_probability": 0.5, "limits_ok": true, "predictions": {}}));
        beyond_what_was_set(&experiment.expect("an experiment"), &problem)
    };
    assert_eq!(said(values[0]), None);
    let beyond = said(highest + 500.0).expect("outside");
    assert!(beyond.contains(&format!("`{}` at ", input.name)) && beyond.contains("so far"), "{beyond}");
    assert!(beyond.contains("a narrower `range` of that input"), "{beyond}");
}

#[test]
fn what_needs_a_gas_is_said_where_nothing_tells_of_a_vacuum_and_what_the_note_names_ends_it() {
    let mut problem = star();
    let mut warm = (*problem.model).clone();
    let room = warm.graph.number(293.0);
    for node in &mut warm.nodes {
        if let NodeKind::Boundary { temperature } = &mut node.kind {
            *temperature = room;
        }
    }
    // The case has pressures of its own.
    warm.inputs.iter_mut().filter(|own| own.unit == "Pa").for_each(|own| own.unit = "1".to_owned());
    problem.model = Arc::new(warm.clone());
    let convection = EffectResult { effect: "convection".into(), id: "convection:a:b".into(), ..effect(0.03) };
    let note = of_gas(std::slice::from_ref(&convection), &problem).expect("a note");
    assert!(
        note.contains("`convection:a:b`") && note.contains(r#""pressure": {"unit": "Pa", "nominal": 0.001}"#),
        "{note}"
    );
    assert_eq!(of_gas(&[EffectResult { probability: 0.001, ..convection.clone() }], &problem), None);
    assert_eq!(of_gas(&[effect(0.03)], &problem), None);
    let (name, unit, range, description) = ("pressure".to_owned(), "Pa".to_owned(), None, String::new());
    warm.inputs.push(Input { name, unit, nominal: 0.001, range, settable: true, description });
    problem.model = Arc::new(warm);
    assert_eq!(of_gas(&[convection], &problem), None);
}
