//! Passes that adopt effects: the model, its priors, its measurements and environments follow.

use bmv::effect::Bound;
use bmv::measurement::prediction::Predictor;
use bmv::measurement::{Initial, Rows, Uncertain};
use bmv::random::Distribution;
use bmv::study::Pass;
use bmv::thermal::{Network, Start};

use crate::diagnostics::pass_study::Study;

fn adopting(study: &Study, entries: &str) -> Pass {
    study.edit("pass-1.json", r#""design": {"A""#, &format!(r#""adopt": {{{entries}}}, "design": {{"A""#));
    let pass = study.load();
    assert!(pass.warnings.is_empty(), "{}", pass.warnings.render(false, 9));
    pass
}

fn parameter(pass: &Pass, name: &str) -> usize {
    let names: Vec<&str> = pass.model.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    names.iter().position(|own| *own == name).unwrap_or_else(|| panic!("{name} among {names:?}"))
}

#[test]
fn a_path_brings_its_parameter_its_prior_and_its_heat() {
    let study = Study::new();
    study.edit(
        "pass-1.json",
        r#""requirements": {"#,
        r#""quantities": {"through": {"heat": "harness"}}, "requirements": {"#,
    );
    study.edit(
        "pass-1.json",
        r#"{"measures": "panel"}"#,
        r#"{"measures": "panel", "sigma": {"value": 0.25, "unit": "K"}}"#,
    );
    let entry = r#""harness": {"effect": {"conductive-path": {"where": ["panel", "plate"],
        "parameters": {"conductance": {"unit": "mW/K", "nominal": 50, "prior": {"uniform": [0, 200]}}}}}, "because": "cable seen"}"#;
    let pass = adopting(&study, entry);
    let conductance = parameter(&pass, "harness.conductance");
    assert_eq!(pass.priors[conductance], Distribution::Uniform { lower: 0.0, upper: 0.2 });
    assert_eq!(pass.model.parameters[conductance].nominal, 0.05);
    assert_eq!(pass.priors.len(), pass.model.parameters.len());
    let adopted = &pass.adopted[0];
    assert_eq!((adopted.name.as_str(), adopted.because.as_str()), ("harness", "cable seen"));
    assert_eq!(
        (adopted.place.as_slice(), adopted.file.as_ref()),
        (&["panel".to_owned(), "plate".to_owned()][..], None)
    );
    let network = Network::compile(&pass.model, &[]).expect("compiled");
    let mut workspace = network.workspace();
    network.solve_steady(&mut workspace, Start::Default).expect("solved");
    let through = pass.model.quantities.iter().position(|quantity| quantity.name == "through").expect("there");
    let temperatures = workspace.temperatures();
    // Plate, shroud, box, panel.
    let expected = 0.05 * (temperatures[3] - temperatures[0]);
    assert!((network.quantity(&workspace, through) - expected).abs() < 1e-9);
    // The jobs are made of the model with the effect.
    let jobs = bmv::job::ready(&pass);
    assert_eq!(jobs.len(), pass.jobs.len());
}

#[test]
fn an_effect_may_be_there_in_a_test_only() {
    let entry = r#""harness": {"effect": {"conductive-path": {"where": ["panel", "plate"],
        "parameters": {"conductance": {"prior": {"fixed": 0.1}}}}}, "because": "test cable", "applies_to": ["balance"]}"#;
    let pass = adopting(&Study::new(), entry);
    let switch = pass.model.inputs.iter().position(|input| input.name == "harness.applies").expect("there");
    assert_eq!((pass.model.inputs[switch].nominal, pass.model.inputs[switch].settable), (0.0, false));
    assert_eq!(pass.environments[0].inputs[switch], 0.0, "it does not fly");
    let problem = bmv::study::problem::problem(&pass);
    let follows = |bound: &[Bound]| bound.contains(&Bound::Input(switch));
    assert!(!problem.candidates.iter().any(|candidate| follows(&candidate.bound)), "no physics follows the switch");
    let Rows::Steady(phases) = &pass.measurements[0].rows else { panic!("steady") };
    assert!(phases.iter().all(|phase| phase.inputs[switch] == 1.0));
    let network = Network::compile(&pass.model, &[]).expect("compiled");
    let panel = |present: f64| {
        let mut workspace = network.workspace();
        let mut inputs = phases[0].inputs.clone();
        inputs[switch] = present;
        network.set_inputs(&mut workspace, &inputs);
        network.solve_steady(&mut workspace, Start::Default).expect("solved");
        workspace.temperatures()[3]
    };
    let without = {
        let bare = Study::new().load();
        let network = Network::compile(&bare.model, &[]).expect("compiled");
        let mut workspace = network.workspace();
        network.set_inputs(&mut workspace, &phases[0].inputs[..3]);
        network.solve_steady(&mut workspace, Start::Default).expect("solved");
        workspace.temperatures()[3]
    };
    assert!((panel(0.0) - without).abs() < 1e-9);
    assert!(panel(1.0) > without + 1.0, "the plate warms the panel");
}

#[test]
fn sensors_read_by_their_law() {
    let entry = r#""offset": {"effect": {"sensor-bias": {"where": "box", "parameters": {"bias": {"nominal": 1.5}}}}, "because": "soak"},
        "leads": {"effect": {"sensor-conduction": {"where": ["box", "plate"], "parameters": {"ratio": {"prior": {"fixed": 0.1}}}}}, "because": "thick leads"}"#;
    let pass = adopting(&Study::new(), entry);
    let predictor = Predictor::new(&pass.model, &[]).expect("compiled");
    let parameters: Vec<f64> = pass.model.parameters.iter().map(|parameter| parameter.nominal).collect();
    let prediction = predictor.predict(&mut predictor.workspace(), &pass.measurements[0], &parameters);
    let (plate, cabinet) = (prediction.temperatures[0], prediction.temperatures[2]);
    let biased = cabinet + 1.5;
    let expected = biased + 0.1 * (plate - biased);
    assert!((prediction.readings[0] - expected).abs() < 1e-9, "{} {expected}", prediction.readings[0]);
    assert!((prediction.readings[1] - prediction.temperatures[3]).abs() < 1e-12, "the other sensor is as before");
    parameter(&pass, "offset.bias");
}

#[test]
fn exchanged_channels_read_one_another() {
    let entry = r#""swap": {"effect": {"swapped-channels": {"where": ["panel", "box"]}}, "because": "labels"}"#;
    let pass = adopting(&Study::new(), entry);
    let sensors = &pass.measurements[0].sensors;
    let measured = |position: usize| pass.model.quantities[sensors[position].quantity].name.as_str();
    assert_eq!((sensors[0].name.as_str(), measured(0), sensors[0].sigma.is_some()), ("box", "panel", false));
    assert_eq!((sensors[1].name.as_str(), measured(1), sensors[1].sigma.is_some()), ("panel", "box", true));
}

#[test]
fn a_lag_is_a_parameter_and_a_hidden_node_starts_with_its_host() {
    let study = Study::transient();
    study.edit("pass-1.json", r#"{"all": {"value": 20, "unit": "degC"}}"#, r#"{"box": 293.15, "panel": 280}"#);
    let entry = r#""slow": {"effect": {"sensor-lag": {"where": "box", "parameters": {"time_constant": {"unit": "min", "nominal": 0.5}}}}, "because": "step"},
        "inside": {"effect": {"hidden-node": {"where": "panel"}}, "because": "two time constants"}"#;
    let pass = adopting(&study, entry);
    let lag = parameter(&pass, "slow.time_constant");
    assert_eq!(pass.measurements[0].sensors[0].lag_s, Some(Uncertain::Parameter { index: lag, nominal: 30.0 }));
    let Rows::Transient { initial: Initial::Temperatures { values: start, .. }, .. } = &pass.measurements[0].rows
    else {
        panic!("temperatures")
    };
    let hidden = pass.model.nodes.iter().position(|node| node.name == "inside.hidden").expect("there");
    assert_eq!(start[hidden], Uncertain::Known(280.0));
    let predictor = Predictor::new(&pass.model, &[]).expect("compiled");
    let mut parameters: Vec<f64> = pass.model.parameters.iter().map(|parameter| parameter.nominal).collect();
    let mut read = |lag_s: f64| {
        parameters[lag] = lag_s;
        let prediction = predictor.predict(&mut predictor.workspace(), &pass.measurements[0], &parameters);
        assert!(prediction.failures.is_empty(), "{:?}", prediction.failures);
        prediction.readings
    };
    let (prompt, late) = (read(0.0), read(60.0));
    assert_eq!(prompt[0], late[0]);
    assert!((prompt[1] - 293.15).abs() > (late[1] - 293.15).abs(), "a lagging sensor has moved less");
}

/// A part inside the panel, which starts between 10 and 30 degC.
const WARM_PART: &str = r#""inside": {"effect": {"hidden-node": {"where": "panel"}}, "because": "two time constants",
    "starts": {"balance": {"prior": {"normal": {"mean": 20, "sd": 4, "lower": 10, "upper": 30}}, "unit": "degC"}}}"#;

#[test]
fn a_node_that_an_effect_adds_starts_as_its_entry_says() {
    for initial in [r#"{"temperatures": {"all": {"value": 20, "unit": "degC"}}}"#, r#"{"measured": {}}"#] {
        let study = Study::transient();
        study.edit("pass-1.json", r#"{"temperatures": {"all": {"value": 20, "unit": "degC"}}}"#, initial);
        let pass = adopting(&study, WARM_PART);
        let Rows::Transient { initial: Initial::Temperatures { values, shared, balanced }, .. } =
            &pass.measurements[0].rows
        else {
            panic!("temperatures")
        };
        let hidden = pass.model.nodes.iter().position(|node| node.name == "inside.hidden").expect("there");
        let prior = Distribution::Normal { mean: 293.15, sd: 4.0, lower: Some(283.15), upper: Some(303.15) };
        assert_eq!(values[hidden], Uncertain::Inferred(prior), "{initial}");
        assert!(!shared.contains(&hidden) && !balanced.contains(&hidden), "{initial}");
    }
}

#[test]
fn the_nominal_start_of_an_added_node_lies_where_its_prior_allows() {
    let with =
        |nominal: &str| WARM_PART.replace(r#""unit": "degC""#, &format!(r#""unit": "degC", "nominal": {nominal}"#));
    let study = Study::transient();
    let pass = adopting(&study, &with("27.5"));
    let Rows::Transient { initial: Initial::Temperatures { values, .. }, .. } = &pass.measurements[0].rows else {
        panic!("temperatures")
    };
    let hidden = pass.model.nodes.iter().position(|node| node.name == "inside.hidden").expect("there");
    assert!((values[hidden].nominal() - 300.65).abs() < 1e-9, "{:?}", values[hidden]);
    assert!(values[hidden].prior().is_some(), "it is inferred all the same");
    let study = Study::transient();
    study.edit("pass-1.json", r#""design": {"A""#, &format!(r#""adopt": {{{}}}, "design": {{"A""#, with("31")));
    let said = study.said("pass-1.json");
    assert!(said.contains("the prior excludes 31") && said.contains("a value that the prior allows"), "{said}");
}

#[test]
fn a_start_that_nothing_can_have_is_refused() {
    let said = |entry: &str, initial: &str| {
        let study = Study::transient();
        study.edit("pass-1.json", r#"{"temperatures": {"all": {"value": 20, "unit": "degC"}}}"#, initial);
        study.edit("pass-1.json", r#""design": {"A""#, &format!(r#""adopt": {{{entry}}}, "design": {{"A""#));
        study.said("pass-1.json")
    };
    let all = r#"{"temperatures": {"all": {"value": 20, "unit": "degC"}}}"#;
    let elsewhere = WARM_PART.replace(r#""balance""#, r#""log""#);
    assert!(said(&elsewhere, all).contains("unknown transient measurement `log`"), "{}", said(&elsewhere, all));
    let load = WARM_PART.replace("hidden-node", "heat-load");
    assert!(said(&load, all).contains("`inside` adds no node that could start"), "{}", said(&load, all));
    let lag = WARM_PART.replace("hidden-node", "sensor-lag").replace(r#""where": "panel""#, r#""where": "box""#);
    assert!(said(&lag, all).contains("`inside` adds no node that could start"), "{}", said(&lag, all));
    let elsewhere = WARM_PART.replace(r#""because""#, r#""applies_to": [], "because""#);
    assert!(said(&elsewhere, all).contains("`inside` does not apply to `balance`"), "{}", said(&elsewhere, all));
    // Kelvins that were meant as degrees Celsius: a tail of a normal prior, and one that lies there as a whole.
    for (unit, low) in [(r#""unit": "K""#, "-4.7"), (r#""unit": "degC""#, "")] {
        let wide =
            WARM_PART.replace(r#""sd": 4, "lower": 10, "upper": 30"#, r#""sd": 8"#).replace(r#""unit": "degC""#, unit);
        let answer = said(&wide, all);
        let is_refused =
            answer.contains("pass-1.json:") && answer.contains("a share of the prior lies below absolute zero");
        assert_eq!(is_refused, !low.is_empty(), "{answer}");
        assert!(answer.contains(low), "{answer}");
    }
    let everywhere = r#"{"temperatures": {"all": {"prior": {"uniform": [-40, 60]}}}}"#;
    let answer = said(WARM_PART, everywhere);
    assert!(answer.contains("below absolute zero: 0.001 of it below -39.9000 K"), "{answer}");
    assert!(answer.contains("\"unit\": \"degC\""), "{answer}");
    let steady = said(WARM_PART, r#"{"steady": {}}"#);
    assert!(steady.contains("whose start follows from its inputs"), "{steady}");
}

#[test]
fn an_adopted_offset_in_time_adds_to_what_is_declared() {
    let study = Study::transient();
    let declared = r#""sensors": {"box": {"clock_behind": {"value": 1, "unit": "min"}, "#;
    study.edit("pass-1.json", r#""sensors": {"box": {"#, declared);
    let entry = r#""late": {"effect": {"sensor-clock": {"where": "box", "parameters": {"behind": {"unit": "min", "nominal": -3}}}}, "because": "two loggers"}"#;
    let pass = adopting(&study, entry);
    let index = parameter(&pass, "late.behind");
    let sensor = &pass.measurements[0].sensors[0];
    assert_eq!(sensor.behind_s, [Uncertain::Known(60.0), Uncertain::Parameter { index, nominal: -180.0 }]);
    let parameters: Vec<f64> = pass.model.parameters.iter().map(|parameter| parameter.nominal).collect();
    assert_eq!(sensor.timing(&parameters).behind_s, -120.0);
}

#[test]
fn a_study_brings_its_own_effect() {
    let study = Study::new();
    // The example of docs/effects.md.
    let guide = include_str!("../../docs/effects.md");
    let begin = guide.find("{\"format\": \"bmv-effect/1\"").expect("an example");
    let text = &guide[begin..begin + guide[begin..].find("```").expect("its end")];
    study.put("effects/heat-pipe.json", text);
    let entry = r#""pipe": {"effect": {"heat-pipe": {"where": ["box", "panel"], "inputs": {"tilt": "Q"}}}, "because": "dry-out"}"#;
    study.edit("pass-1.json", r#""design": {"A""#, &format!(r#""adopt": {{{entry}}}, "design": {{"A""#));
    assert!(study.said("pass-1.json").contains("`Q` cannot stand for the input `tilt`"), "units are checked");
    study.edit("model.json", r#""T_s": {"#, r#""tilt": {"unit": "deg", "nominal": 2, "range": [0, 10]}, "T_s": {"#);
    study.edit("pass-1.json", r#""tilt": "Q""#, r#""tilt": "tilt""#);
    let pass = study.load();
    assert_eq!(pass.adopted[0].file.as_deref(), Some("effects/heat-pipe.json"));
    parameter(&pass, "pipe.conductance");
    let before = pass.definition_sha256.clone();
    study.put("effects/heat-pipe.json", text.replace("0.5", "0.6"));
    assert_ne!(study.load().definition_sha256, before, "an own effect is part of the definition");
}

#[test]
fn a_factor_changes_the_quantities_that_ask_for_it() {
    let entry = r#""aging": {"effect": {"temperature-dependent-conductance": {"where": "bolts", "parameters": {"coefficient": {"prior": {"fixed": 0.004}}}}}, "because": "hot and cold differ"}"#;
    let pass = adopting(&Study::new(), entry);
    let network = Network::compile(&pass.model, &[]).expect("compiled");
    let mut workspace = network.workspace();
    network.solve_steady(&mut workspace, Start::Default).expect("solved");
    let temperatures = workspace.temperatures();
    let (plate, cabinet) = (temperatures[0], temperatures[2]);
    let expected = 0.8 * (1.0 + 0.004 * (0.5 * (plate + cabinet) - 293.15)) * (cabinet - plate);
    assert!((network.quantity(&workspace, 0) - expected).abs() < 1e-9, "`leak` is the heat through the bolts");
}

/// The prior of an effect that scales with an input without a stated range: by the data's largest value, as a diagnosis
/// of the same data scales it.
#[test]
fn effects_scale_with_the_ranges_of_the_data() {
    use bmv::effect::{Bound, Catalogue};
    let study = Study::new();
    study.edit("data/balance.csv", "P2,0,5,", "P2,0,7,");
    let entry = r#""share": {"effect": {"input-proportional-load": {"where": "box", "inputs": {"input": "Q"}}}, "because": "losses"}"#;
    let pass = adopting(&study, entry);
    let input = pass.model.inputs.iter().position(|input| input.name == "Q").expect("there");
    assert_eq!(pass.model.inputs[input].range.map(|[lower, _]| lower), Some(5.0));
    assert_eq!(pass.ranges_from_data, ["Q"]);
    let catalogue = Catalogue::embedded(&mut bmv::document::Diagnostics::new());
    let effect = catalogue.get("input-proportional-load").expect("there");
    let expected = effect.parameters(&pass.model, &[Bound::Input(input)]);
    let [adopted] = pass.adopted.as_slice() else { panic!("one") };
    assert_eq!(pass.priors[adopted.parameters.start], expected[0].prior);
    assert_ne!(pass.model.inputs[input].range, Some([2.5, 7.5]), "half the nominal value on either side");
}

#[test]
fn a_sensor_whose_data_are_wrong_or_not_here_is_no_unknown_one() {
    let study = Study::new();
    let other = r#""other": {"steady": {"file": "data/other.csv", "sensors": {"case": {"measures": "box"}}, "inputs": {"T_s": 90}}}, "balance""#;
    study.edit("pass-1.json", r#""balance": {"steady""#, &format!("{other}: {{\"steady\""));
    study.put("data/other.csv", "phase,T_if [degC],Q [W],case [degC]\nP1,20,x,24.5\n");
    let entry =
        r#""adopt": {"off": {"effect": {"sensor-bias": {"where": "case"}}, "because": "seen"}}, "design": {"A""#;
    study.edit("pass-1.json", r#""design": {"A""#, entry);
    let said = study.said("pass-1.json");
    assert!(said.contains("`x` is not a number") && said.matches("error[").count() == 1, "{said}");
    study.edit("data/other.csv", "x", "5");
    assert!(!study.said("pass-1.json").contains("error["), "{}", study.said("pass-1.json"));
    study.edit("pass-1.json", r#""where": "case""#, r#""where": "cas""#);
    assert!(study.said("pass-1.json").contains("unknown sensor `cas`"), "{}", study.said("pass-1.json"));
}

/// A rate is that of a node's temperature; where there is none, the reason is the true one.
#[test]
fn a_sensor_whose_rate_is_not_known_says_why() {
    let said = |first: &str| {
        let study = Study::transient();
        let own = r#"{"format": "bmv-effect/1", "title": "Own", "applies": {"sensor": {}},
            "parameters": {"behind": {"unit": "s", "prior": {"halfnormal": 60}}},
            "adds": {"reading": "T + behind * rate"}, "source": "a test"}"#;
        study.put("effects/early.json", own);
        let entry = r#""early": {"effect": {"early": {"where": "box"}}, "because": "clocks"}"#;
        let entries = format!("{first}{entry}");
        study.edit("pass-1.json", r#""design": {"A""#, &format!(r#""adopt": {{{entries}}}, "design": {{"A""#));
        study.said("pass-1.json").split_whitespace().collect::<Vec<_>>().join(" ")
    };
    assert!(!said("").contains("the rate of what sensor"), "{}", said(""));
    let twice = said(r#""warm": {"effect": {"sensor-self-heating": {"where": "box"}}, "because": "current"}, "#);
    assert!(twice.contains("which is computed and no temperature of a node by itself"), "{twice}");
}
