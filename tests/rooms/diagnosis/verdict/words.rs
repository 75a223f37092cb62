//! Tests of `diagnosis/src/diagnosis/verdict/words.rs`.

use std::sync::Arc;

use bmv::diagnosis::Problem;
use bmv::diagnosis::output::{EffectResult, StoryStep};
use bmv::diagnosis::verdict::words::*;
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::thermal::element::{Drawing, Path};
use bmv::thermal::{Input, Model, NodeKind};
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};

#[test]
fn a_misfit_is_called_clear_only_where_the_tests_find_one() {
    assert_eq!(clearness(0.96, 0.01), "the tests find no misfit in that (p = 0.96)");
    let found = clearness(0.0, 0.01);
    assert!(found.starts_with("that is a misfit (p < 1e-6, "), "{found}");
}

#[test]
fn something_is_said_to_be_missing_only_where_the_tests_find_it() {
    let tried = "none of 9 effects, alone or in sets of up to 2,";
    assert!(unexplained(tried, true).starts_with("Something is missing, and none of 9 effects"));
    let errors = unexplained(tried, false);
    assert!(!errors.contains("missing") && errors.contains("errs by more than the instruments' noise, and none of 9"));
    assert!(unexplained("none of 9 effects", false).contains("none of 9 effects explains that"));
}

#[test]
fn a_set_off_the_steps_is_named_only_where_theirs_have_little() {
    let steps = [1];
    let of = |weights: &[f64]| off_the_steps(weights, |place| steps.contains(&place));
    assert_eq!(of(&[0.1, 0.05, 0.2, 0.65]), Some(3));
    assert_eq!(of(&[0.0, 0.15, 0.2, 0.65]), None, "the steps' sets have more than a tenth");
    assert_eq!(of(&[0.0, 0.9, 0.1]), None, "a step's set is the most probable");
    assert_eq!(of(&[0.9, 0.06, 0.04]), None, "neither is the most probable of all sets of effects");
    assert_eq!(of(&[0.9, 0.02, 0.03, 0.02]), Some(2), "the baseline model is no set of effects");
    assert_eq!(of(&[1.0]), None);
}

/// An effect with this most probable conductance, W/K.
pub fn effect(most_probable: f64) -> EffectResult {
    let amount = serde_json::json!({"value": 0.0307, "sd": 0.0131, "most_probable": most_probable, "unit": "W/K", "at_bound": false});
    serde_json::from_value(serde_json::json!({
        "id": "a:x", "effect": "a", "title": "A", "where": ["x"], "where_kind": "node", "input": null, "probability": 0.9,
        "log_bayes_factor": 9.0, "log_bayes_factor_scales": null, "group": null, "amplitudes": {"conductance": amount},
        "rmse_k": {"train": [null, null], "held_out": [null, null]}, "watts": null, "confused_with": [], "separate": ""
    }))
    .expect("an effect")
}

/// Unseen rows are the reason only where the next effect is more probable than nothing: many weak ones together may be so too.
#[test]
fn a_story_ends_for_want_of_probability_or_by_what_speaks_against_the_next_step() {
    let rmse = serde_json::json!({"train": [0.9, 0.9], "held_out": [0.9, 0.9]});
    let step = |effect: Option<&str>| -> StoryStep {
        let whole =
            serde_json::json!({"effect": effect, "probability": 0.2, "rmse_k": rmse, "alternatives": ["heat-load:x"]});
        serde_json::from_value(whole).expect("a step")
    };
    let of = |against: Option<Against>| ends(&step(None), against).expect("an end");
    let [by_unseen, by_fitted] = [Against::Unseen, Against::Fitted].map(|against| of(Some(against)));
    assert!(by_unseen.contains("heat-load:x would be more probable than nothing"), "{by_unseen}");
    assert!(by_fitted.contains("but the fitted rows speak against it"), "{by_fitted}");
    assert!(of(None).contains("probability of 20.0 %") && !of(None).contains("unseen"), "{}", of(None));
    assert_eq!(ends(&step(Some("sensor-bias:x")), Some(Against::Unseen)), None);
}

#[test]
fn errors_beside_later_steps_are_called_that() {
    let words = |beside_later: bool| {
        let rmse = serde_json::json!({"train": [1.3, 0.14], "held_out": [null, null]});
        let whole = serde_json::json!({
            "effect": "heat-load:x", "probability": 0.2, "rmse_k": rmse, "beside_later": beside_later, "alternatives": []
        });
        falls_to(&serde_json::from_value(whole).expect("a step"))
    };
    assert_eq!(words(false), "; the error falls from 1.30 to 0.14 K");
    assert_eq!(words(true), "; beside the later steps the error falls from 1.30 to 0.14 K");
}

/// A star in a steady test, and its effects at their places.
pub fn star() -> Problem {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Steady, InjectionRequest::default());
    case(&catalogue, &recipe, 1, 0).expect("a case").problem
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
    assert!(note.contains("If the test was in vacuum") && note.contains("otherwise nothing is to be done"), "{note}");
    // Where no heat is radiated, or a name tells of air or water, nobody asks for a vacuum.
    let quiet = |change: &dyn Fn(&mut Model)| {
        let mut model = warm.clone();
        change(&mut model);
        let other = Problem { model: Arc::new(model), ..problem.clone() };
        assert_eq!(of_gas(std::slice::from_ref(&convection), &other), None);
    };
    quiet(&|model| model.elements.retain(|own| own.physics().drawing() != Drawing::Path(Path::Radiation)));
    quiet(&|model| model.nodes[0].name = "air_gap".to_owned());
    quiet(&|model| model.inputs[0].name = "Water".to_owned());
    quiet(&|model| model.title = "A store of oil, outdoors".to_owned());
    let (name, unit, range, description) = ("pressure".to_owned(), "Pa".to_owned(), None, String::new());
    warm.inputs.push(Input { name, unit, nominal: 0.001, range, settable: true, description });
    problem.model = Arc::new(warm);
    assert_eq!(of_gas(&[convection], &problem), None);
}
