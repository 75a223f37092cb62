//! The writer of a next pass: every effect of the catalogue at every kind of place, what is refused, what is written.

use bmv::batch::next_pass::{Acting, Asked, Mended, NextPass, acts_in, destination, next_pass, twin, write};
use bmv::diagnosis::Output;
use bmv::document::Diagnostics;
use bmv::effect::{Bound, Candidate, Catalogue, GroupPlace, Site, candidates};
use bmv::measurement::{Initial, Rows, Uncertain, sensor_places};
use bmv::random::Distribution;
use bmv::study::problem::dated;
use serde_json::{Value, json};

use crate::diagnostics::pass_study::Study;

/// A cooled detector in a box on a plate, seeing a shroud: one of each kind of element, groups of each kind of member,
/// inputs of several units.
const MODEL: &str = r#"{"format": "bmv-network/1", "title": "All kinds",
 "inputs": {"T_plate": {"unit": "degC", "nominal": 17, "range": [-20, 45]}, "T_shroud": {"unit": "K", "nominal": 120, "range": [90, 150]},
            "Q": {"unit": "W", "nominal": 6, "range": [0, 9]}, "p": {"unit": "mbar", "nominal": 0.02, "range": [0.01, 0.03]},
            "i": {"unit": "mA", "nominal": 800, "range": [400, 1200]}, "flux": {"unit": "W/m2", "nominal": 10, "range": [0, 1361.3]},
            "share": {"unit": "%", "nominal": 50, "range": [0, 100]}, "roll": {"unit": "deg", "nominal": 40, "range": [0, 180]}, "free": {"unit": "s", "nominal": 3},
            "T_bay": {"unit": "degC", "nominal": 5, "range": [-10, 20]}},
 "parameters": {"G": {"unit": "W/K", "nominal": 0.6, "prior": {"uniform": [0.3, 0.9]}}},
 "nodes": {"plate": {"boundary": "T_plate"}, "shroud": {"boundary": "T_shroud"}, "box": {"capacity": 900}, "panel": {"capacity": 300},
           "blanket": {}, "detector": {"capacity": 20}},
 "conductors": {"bolts": {"between": ["box", "plate"], "conductance": "G"}, "strap": {"between": ["box", "panel"], "conductance": 0.25},
                "leads": {"between": ["detector", "box"], "conductance": 0.01}},
 "radiations": {"panel to shroud": {"between": ["panel", "shroud"], "exchange_area": 0.03},
                "inside": {"between": ["box", "blanket"], "exchange_area": 0.002}, "outside": {"between": ["blanket", "shroud"], "exchange_area": 0.05}},
 "loads": {"board": {"into": "box", "power": "Q"}},
 "coolers": {"cooler": {"cold": "detector", "hot": "box", "current": "i", "seebeck": 4e-4, "resistance": 0.02, "conductance": 1.5e-3, "couples": [17]}},
 "heaters": {"panel heater": {"into": "panel", "senses": "panel", "power": 3, "proportional": {"set_point": 265, "band": 20}}},
 "groups": {"surfaces": {"nodes": {"box": 1, "panel": 0.5}}, "joints": {"conductors": ["bolts", "strap"]},
            "layers": {"radiations": ["inside", "outside"]}, "powers": {"loads": ["board"]}, "bonded": {"sensors": ["TC box", "TC panel"]}}}
"#;

const PASS: &str = r#"{"format": "bmv-pass/1", "title": "Bench, pass 1: as delivered", "parent": null, "model": "model.json", "seed": 7,
 "measurements": {
   "balance": {"steady": {"file": "data/balance.csv", "inputs": {"T_plate": {"value": 17, "unit": "degC"}, "T_shroud": 120, "p": {"value": 0.02, "unit": "mbar"}, "i": {"value": 800, "unit": "mA"},
       "flux": {"value": 10, "unit": "W/m2"}, "share": {"value": 50, "unit": "%"}, "roll": {"value": 40, "unit": "deg"}, "free": {"value": 3, "unit": "s"}, "T_bay": {"value": 5, "unit": "degC"}}, "sensors": {
     "TC box": {"measures": "box", "sigma": {"value": 0.25, "unit": "K"}}, "TC panel": {"measures": "panel", "sigma": {"value": 0.25, "unit": "K"}},
     "TC detector": {"measures": "detector", "sigma": {"value": 0.25, "unit": "K"}}}}},
   "run": {"transient": {"file": "data/run.csv", "inputs": {"T_plate": {"value": 17, "unit": "degC"}, "T_shroud": 120, "p": {"value": 0.02, "unit": "mbar"}, "i": {"value": 800, "unit": "mA"},
       "flux": {"value": 10, "unit": "W/m2"}, "share": {"value": 50, "unit": "%"}, "roll": {"value": 40, "unit": "deg"}, "free": {"value": 3, "unit": "s"}, "T_bay": {"value": 5, "unit": "degC"}}, "initial": {"temperatures": {"all": {"value": 17, "unit": "degC"}}},
     "sensors": {"TC box": {"measures": "box", "sigma": {"value": 0.25, "unit": "K"}, "bias": {"value": 0, "unit": "K"}}}}}},
 "jobs": {"tuned": {"calibrate": {"draws": 1e3, "parameters": ["G"]}}, "fit": {"compare": {"criteria": "precision-1k"}}, "missing": {"diagnose": {"false_alarm": 5e-3}}}}
"#;

const BALANCE: &str = "phase,Q [W],TC box [degC],TC panel [degC],TC detector [degC]\nP1,6,20,10,5\nP2,3,18,9,\n";
const RUN: &str = "time [s],Q [W],TC box [degC]\n0,6,17\n60000,6,18\n120000,0,18.5\n";

fn study() -> Study {
    let study = Study::new();
    study.put("model.json", MODEL).put("pass-1.json", PASS).put("data/balance.csv", BALANCE).put("data/run.csv", RUN);
    study
}

fn groups(pass: &bmv::study::Pass) -> Vec<GroupPlace> {
    let node = |name: &str| pass.model.nodes.iter().position(|node| node.name == name).expect("there");
    let element = |name: &str| pass.model.elements.iter().position(|element| element.name == name).expect("there");
    let sensors = sensor_places(pass.measurements.iter());
    let bonded = sensors.into_iter().filter(|sensor| sensor.name != "TC detector").collect();
    vec![
        GroupPlace { name: "surfaces".into(), site: Site::Nodes([(node("box"), 1.0), (node("panel"), 0.5)].into()) },
        GroupPlace { name: "joints".into(), site: Site::Elements([element("bolts"), element("strap")].into()) },
        GroupPlace { name: "layers".into(), site: Site::Elements([element("inside"), element("outside")].into()) },
        GroupPlace { name: "powers".into(), site: Site::Elements([element("board")].into()) },
        GroupPlace { name: "bonded".into(), site: Site::Sensors(bonded) },
    ]
}

/// A finding as `diagnose --json` gives it.
fn finding(candidate: &Candidate) -> Value {
    json!({"id": candidate.id, "effect": candidate.effect, "where": candidate.place, "where_kind": candidate.where_kind,
        "input": candidate.input, "probability": 0.98, "log_bayes_factor": 41.2, "group": 1, "amplitudes": {},
        "rmse_k": {"train": [0.71, 0.26], "held_out": [0.83, null]}})
}

/// Adds what a document does not say.
fn fill(document: &mut Value, base: Value) {
    let (Value::Object(document), Value::Object(base)) = (document, base) else { panic!("objects") };
    for (name, value) in base {
        document.entry(name).or_insert(value);
    }
}

/// A diagnosis that says this, and else as little as it may.
fn output(mut whole: Value) -> Output {
    let rmse = json!({"train": null, "held_out": null});
    let effect = json!({"title": "", "probability": 0.0, "log_bayes_factor": 0.0, "group": null, "amplitudes": {},
        "rmse_k": {"train": [null, null], "held_out": [null, null]}, "confused_with": [], "separate": ""});
    for own in whole["effects"].as_array_mut().expect("effects") {
        fill(own, effect.clone());
        for amplitude in own["amplitudes"].as_object_mut().expect("amplitudes").values_mut() {
            fill(amplitude, json!({"at_bound": false}));
        }
    }
    for model in whole.get_mut("models").and_then(Value::as_array_mut).into_iter().flatten() {
        fill(model, json!({"log_evidence": 0.0, "chi_square": 0.0, "rmse_k": rmse}));
    }
    if let Some(experiment @ Value::Object(_)) = whole.get_mut("separating_experiment") {
        fill(experiment, json!({"predictions": {}}));
    }
    let misfit = json!({"reduced_chi2": 1.0, "family_wise_p": 0.5, "rmse_k": rmse, "tests": []});
    let base = json!({"words": [], "probability_nothing": 0.0, "probability_unexplained": 0.0, "misfit": misfit,
        "models": [], "selected": [], "unseen": [], "detectable": {}, "noise": {}, "separating_experiment": null,
        "heat": [], "goes_with": [], "held_out_test": null, "remaining_p": null, "looked_at": [0, 0, 0],
        "warnings": []});
    fill(&mut whole, base);
    serde_json::from_value(whole).expect("a diagnosis")
}

fn findings(verdict: &str, effects: Vec<Value>, selected: &[&str]) -> Output {
    let whole = json!({"verdict": verdict, "effects": effects, "selected": selected,
        "unseen": [{"id": "thermal-mass:box", "why": "steady data see no capacity"}],
        "separating_experiment": {"between": [], "conditions": {"T_plate": {"value": 313.0, "unit": "K"}}, "probability": 0.97,
            "repeat_probability": 0.6, "limits_ok": true}});
    output(whole)
}

fn close(one: f64, other: f64) -> bool {
    // Six digits are written.
    (one - other).abs() <= 1e-5 * one.abs().max(other.abs())
}

fn same_prior(one: &Distribution, other: &Distribution) -> bool {
    [0.02, 0.5, 0.98].iter().all(|&share| close(one.quantile(share), other.quantile(share)))
}

#[test]
#[ignore = "thorough"]
fn every_effect_at_every_kind_of_place_is_written_and_read_again() {
    let study = study();
    // Rows within a day, for laws of its hours.
    study.put(
        "data/run.csv",
        "time [s],Q [W],TC box [degC]\n0,6,17\n20000,6,17.4\n40000,6,17.8\n60000,6,18\n120000,0,18.5\n",
    );
    // Two runs: something may happen at the same time into both.
    let run = &PASS[PASS.find(r#""run": "#).expect("a run")..PASS.find("},\n \"jobs\"").expect("jobs")];
    study.edit("pass-1.json", run, &format!("{run},\n   {}", run.replacen("run", "again", 1)));
    let pass = study.load();
    let catalogue = Catalogue::embedded(&mut Diagnostics::new());
    let (model, measurements) = dated(&pass, pass.measurements.clone());
    let all = candidates(&model, &groups(&pass), &sensor_places(measurements.iter()), &catalogue);
    let mut seen: Vec<(String, &str, String)> = Vec::new();
    for candidate in &all {
        // Once for each kind of place, and of what inputs stand for.
        let bound = candidate.bound.iter().map(|bound| match bound {
            Bound::Input(index) => model.inputs[*index].unit.as_str(),
            Bound::Node(_) => "node",
        });
        let kind = (candidate.effect.clone(), candidate.where_kind, bound.collect::<Vec<_>>().join("*"));
        if seen.contains(&kind) || kind.2.matches('*').count() == 1 && seen.iter().filter(|k| k.0 == kind.0).count() > 6
        {
            continue;
        }
        let findings = findings("identified", vec![finding(candidate)], &[&candidate.id]);
        let asked = Asked::new("bmv adopt pass-1.json", &[]);
        let next = next_pass(&pass, "missing", &findings, &asked, false, &study.path("pass-2.json"))
            .unwrap_or_else(|wrong| panic!("{}: {}", candidate.id, wrong.render(false, 9)));
        study.put("pass-2.json", &next.text);
        let read = bmv::job::load(&study.path("pass-2.json"));
        let read = read.unwrap_or_else(|wrong| panic!("{}: {}\n{}", candidate.id, wrong.render(false, 9), next.text));
        assert!(read.warnings.is_empty(), "{}: {}", candidate.id, read.warnings.render(false, 9));
        let [adopted] = read.adopted.as_slice() else { panic!("{}: one effect", candidate.id) };
        assert_eq!((&adopted.id, &adopted.name), (&candidate.id, &next.adopted[0].0));
        let effect = catalogue.get(&candidate.effect).expect("there");
        let expected = effect.parameters(&model, &candidate.bound);
        assert_eq!(adopted.parameters.len(), expected.len());
        for (index, expected) in adopted.parameters.clone().zip(&expected) {
            let parameter = &read.model.parameters[index];
            assert!(same_prior(&read.priors[index], &expected.prior), "{}: {}", candidate.id, next.text);
            assert!(close(parameter.nominal, expected.nominal), "{} {}", candidate.id, parameter.name);
        }
        assert_eq!(read.jobs.len(), pass.jobs.len());
        seen.push(kind);
    }
    for effect in catalogue.effects() {
        assert!(seen.iter().any(|kind| kind.0 == effect.name), "{}", effect.name);
    }
    let kinds: std::collections::BTreeSet<&str> = seen.iter().map(|kind| kind.1).collect();
    for kind in [
        "nodes",
        "node",
        "boundary",
        "conductor",
        "radiation",
        "load",
        "cooler",
        "heater",
        "sensor",
        "sensors",
        "group",
    ] {
        assert!(kinds.contains(kind), "{kind} among {kinds:?}");
    }
}

fn harness(group: Option<u64>) -> Value {
    json!({"id": "conductive-path:box:detector", "effect": "conductive-path", "where": ["box", "detector"], "where_kind": "nodes",
        "input": null, "probability": 0.98, "log_bayes_factor": 41.2, "group": group,
        "amplitudes": {"conductance": {"value": 0.0491, "sd": 0.00312, "most_probable": 0.0474, "unit": "W/K"}},
        "rmse_k": {"train": [0.71, 0.26], "held_out": [0.83, 0.27]}})
}

fn other(id: &str, kind: &str, group: Option<u64>) -> Value {
    let parts: Vec<&str> = id.split(':').collect();
    json!({"id": id, "effect": parts[0], "where": parts[1..], "where_kind": kind, "probability": 0.01, "group": group})
}

fn adopt<'f>(study: &Study, findings: &'f Output, effects: &[&str], forced: bool) -> Result<NextPass<'f>, String> {
    let effects: Vec<String> = effects.iter().map(|&text| text.to_owned()).collect();
    let asked = Asked::new("bmv adopt pass-1.json", &effects);
    next_pass(&study.load(), "missing", findings, &asked, forced, &study.path("pass-2.json"))
        .map_err(|wrong| wrong.render(false, 9))
}

#[test]
fn the_file_is_readable_and_says_why() {
    let study = study();
    let effects = vec![
        harness(Some(1)),
        other("radiative-path:box:detector", "nodes", Some(1)),
        other("joule-heating:box", "node", None),
    ];
    let found = findings("ambiguous", effects, &["conductive-path:box:detector"]);
    let next = adopt(&study, &found, &["conductive-path"], false).expect("adopted");
    assert_eq!(next.extended, ["tuned"]);
    insta::assert_snapshot!(next.text, @r#"
    {
      "format": "bmv-pass/1",
      "title": "Bench, pass 2: as delivered, with box-detector conductive path",
      "description": "pass-1.json with what its diagnosis missing names: box-detector conductive path. All else is inherited, and the calibration starts from the original priors; nominal values of the effect are those that the diagnosis fitted.",
      "parent": "pass-1.json",
      "model": "model.json",
      "adopt": {
        "box-detector conductive path": {
          "effect": {"conductive-path": {
            "where": ["box", "detector"],
            "parameters": {"conductance": {"unit": "W/K", "nominal": 0.0474, "prior": {"halfnormal": 0.1}}}
          }},
          "because": "diagnosis `missing` of pass-1.json: ambiguous; probability 0.980, log Bayes factor 41.2; conductance 0.0474 W/K (most probable; standard deviation 0.0031 W/K); RMSE 0.71 K -> 0.26 K, on held-out readings 0.83 K -> 0.27 K; these data cannot tell it from `radiative-path:box:detector`",
          "evidence": {"pass": "pass-1.json", "job": "missing", "probability": 0.98, "sd": {"conductance": 0.0031}}
        }
      },
      "jobs": {
        "tuned": {"calibrate": {"draws": 1e3, "parameters": ["G", "box-detector conductive path.conductance"]}},
        "fit": {"compare": {"criteria": "precision-1k"}},
        "missing": {"diagnose": {"false_alarm": 5e-3}}
      }
    }
    "#);
    insta::assert_snapshot!(next.warnings.render(false, 9), @r"
    warning[adopt-ambiguous]: these data leave open whether it is `conductive-path:box:detector` (probability 0.980); its rivals: `radiative-path:box:detector` (0.010)
     --> command line:1:1
      |
    1 | bmv adopt pass-1.json conductive-path
      | ^^^^^^^^^^^^^^^^^^^^^
      |
      = help: a phase at T_plate = 39.85 degC would tell them apart with probability 97.0 % (repeating a phase: 60.0 %)
    ");
}

/// Two parts of a measurement have one start, whose bounds hold both.
#[test]
fn inferred_starts_of_added_nodes_are_adopted_with_their_priors() {
    let study = Study::transient();
    let start = |measurement: &str, mean: f64| {
        json!({"measurement": measurement, "node": "hidden-node:panel.hidden", "most_probable_k": 301.0,
            "prior_k": [mean, 5.0], "bounds_k": [mean - 20.0, mean + 20.0]})
    };
    let mut part = other("hidden-node:panel", "node", Some(1));
    part["starts"] = json!([start("balance", 290.0), start("balance (part 2)", 294.0)]);
    let found = findings("identified", vec![part], &["hidden-node:panel"]);
    let next = adopt(&study, &found, &[], false).expect("adopted");
    study.put("pass-2.json", &next.text);
    let read = bmv::job::load(&study.path("pass-2.json")).unwrap_or_else(|wrong| panic!("{}", wrong.render(false, 9)));
    let Rows::Transient { initial: Initial::Temperatures { values, .. }, .. } = &read.measurements[0].rows else {
        panic!("temperatures")
    };
    let hidden = read.model.nodes.iter().position(|node| node.name.ends_with(".hidden")).expect("there");
    let Uncertain::InferredFrom { prior, nominal } = values[hidden] else { panic!("{:?}", values[hidden]) };
    let Distribution::Normal { mean, sd, lower: Some(lower), upper: Some(upper) } = prior else { panic!("{prior:?}") };
    assert!(close(nominal, 301.0), "the model as delivered starts where the diagnosis found it: {nominal}");
    assert!(close(mean, 292.0) && close(sd, 5.0) && close(lower, 270.0) && close(upper, 314.0), "{}", next.text);
}

#[test]
fn what_the_data_do_not_settle_is_adopted_by_name_with_its_odds() {
    let study = study();
    let whole = |more: Value| {
        let mut whole = json!({"verdict": "ambiguous",
            "effects": [harness(Some(1)), other("radiative-path:box:detector", "nodes", Some(1)), other("heat-load:box", "node", None)],
            "selected": ["conductive-path:box:detector"],
            "models": [{"effects": ["conductive-path:box:detector"], "probability": 0.501}, {"effects": ["heat-load:box"], "probability": 0.3}]});
        whole.as_object_mut().expect("an object").extend(more.as_object().expect("an object").clone());
        output(whole)
    };
    let parts = json!({"separating_experiment": {"between": [], "conditions": {"T_plate": {"value": 313.0, "unit": "K"}},
        "probability": 0.97, "repeat_probability": 0.6, "limits_ok": true}});
    let found = whole(parts);
    let said = adopt(&study, &found, &[], false).expect_err("refused");
    insta::assert_snapshot!(said, @r"
    error[adopt-refused]: diagnosis `missing` is ambiguous: these data leave open whether it is `conductive-path:box:detector` (probability 0.980); its rivals: `radiative-path:box:detector` (0.010)
     --> command line:1:1
      |
    1 | bmv adopt pass-1.json
      | ^^^^^^^^^^^^^^^^^^^^^ the name of what you adopt
      |
      = help: to adopt it all the same, name it: bmv adopt pass-1.json conductive-path:box:detector; a phase at T_plate = 39.85 degC would tell them apart with probability 97.0 % (repeating a phase: 60.0 %)
    ");
    for (effects, forced) in [(&["conductive-path"][..], false), (&[][..], true)] {
        let next = adopt(&study, &found, effects, forced).expect("adopted");
        let said = "these data leave open whether it is `conductive-path:box:detector` (probability 0.980); its rivals: `radiative-path:box:detector` (0.010)";
        assert_eq!(next.warnings.plain()[0].message, said);
    }
    // Both are laws of one thing, which is settled.
    let kind = json!({"kinds": [{"group": 1, "what": "heat between `box` and `detector`", "open": "whose law", "probability": 0.99}]});
    let of_kind = whole(kind);
    let next = adopt(&study, &of_kind, &["conductive-path"], false).expect("adopted");
    let said = "what is missing is heat between `box` and `detector`, whose law is open (probability 0.990); these data leave open whether it is `conductive-path:box:detector` (probability 0.980); its rivals: `radiative-path:box:detector` (0.010)";
    assert_eq!(next.warnings.plain()[0].message, said);
    // What shares no group with it: other sets.
    let mut alone = found.clone();
    alone
        .effects
        .iter_mut()
        .for_each(|effect| (effect.group, effect.probability) = (None, effect.probability.min(0.5)));
    let next = adopt(&study, &alone, &["conductive-path"], false).expect("adopted");
    assert!(
        next.warnings.plain()[0].message.ends_with("its rivals: `heat-load:box` (0.300)"),
        "{:?}",
        next.warnings.plain()
    );
    // The diagnosis found no phase that parts them, and this says the same.
    let none = whole(json!({"one_thing": {"sets": ["conductive-path:box:detector", "radiative-path:box:detector"],
        "probability": 0.557, "repeat_probability": 0.5}}));
    let next = adopt(&study, &none, &["conductive-path"], false).expect("adopted");
    let help = next.warnings.plain()[0].help.clone().expect("help");
    assert!(
        help.starts_with("no steady phase within the stated ranges reliably tells") && help.contains("55.7 %"),
        "{help}"
    );
    // What all likely sets have is settled, and adopted alone without a word.
    let both = ["conductive-path:box:detector", "heat-load:box"];
    let open = vec![harness(Some(1)), other(both[1], "node", Some(2)), other("heat-load:detector", "node", Some(2))];
    let sets = [
        json!({"effects": both, "probability": 0.5}),
        json!({"effects": [both[0], "heat-load:detector"], "probability": 0.48}),
    ];
    let part = output(json!({"verdict": "ambiguous", "effects": open, "selected": both, "models": sets}));
    assert!(adopt(&study, &part, &["conductive-path"], false).expect("adopted").warnings.is_empty());
    let said = adopt(&study, &part, &[], false).expect_err("refused");
    assert!(said.contains("what is settled can be adopted alone: bmv adopt pass-1.json conductive-path:box:detector; to adopt it all the same"), "{said}");
    // What is settled is adopted without a word.
    let settled = findings("identified", vec![harness(None)], &["conductive-path:box:detector"]);
    assert!(adopt(&study, &settled, &[], false).expect("adopted").warnings.is_empty());
}

#[test]
fn every_knot_of_a_curve_has_the_size_that_was_fitted() {
    let study = study();
    let pass = study.load();
    let catalogue = Catalogue::embedded(&mut Diagnostics::new());
    let all = candidates(&pass.model, &groups(&pass), &sensor_places(pass.measurements.iter()), &catalogue);
    let curve = all.iter().find(|candidate| candidate.effect == "input-function-load").expect("a curve");
    let mut fitted = finding(curve);
    let knot = |value: f64| json!({"value": 9.0, "sd": 0.1, "most_probable": value, "unit": "W"});
    fitted["amplitudes"] = json!({"knot_1": knot(0.25), "knot_2": knot(-0.5)});
    let found = findings("identified", vec![fitted], &[&curve.id]);
    let next = adopt(&study, &found, &[], false).unwrap_or_else(|said| panic!("{said}"));
    study.put("pass-2.json", &next.text);
    let read = bmv::job::load(&study.path("pass-2.json")).unwrap_or_else(|wrong| panic!("{}", wrong.render(false, 9)));
    let nominals: Vec<f64> =
        read.adopted[0].parameters.clone().map(|index| read.model.parameters[index].nominal).collect();
    assert_eq!(nominals[..2], [0.25, -0.5], "{}", next.text);
    for part in ["knot 1 0.25 W (most probable; standard deviation 0.1 W)", "knot 2 -0.5 W (most probable"] {
        assert!(next.text.contains(part), "{part}: {}", next.text);
    }
}

#[test]
fn a_second_next_pass_goes_on_from_the_first() {
    let study = study();
    let found = findings("identified", vec![harness(None)], &["conductive-path:box:detector"]);
    study.put("pass-2.json", &adopt(&study, &found, &[], false).expect("adopted").text);
    let pass = bmv::job::load(&study.path("pass-2.json")).unwrap_or_else(|wrong| panic!("{}", wrong.render(false, 9)));
    let effects = vec![other("heat-load:box", "node", None), harness(None)];
    let found = findings("identified", effects, &["heat-load:box", "conductive-path:box:detector"]);
    let asked = Asked::new("bmv adopt pass-2.json", &[]);
    let next = next_pass(&pass, "missing", &found, &asked, false, &study.path("pass-3.json"));
    let next = next.unwrap_or_else(|wrong| panic!("{}", wrong.render(false, 9)));
    let names: Vec<&str> = next.adopted.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["box heat load", "box-detector conductive path 2"], "names are free");
    let written: Value = serde_json::from_str(&next.text).expect("JSON");
    let title = "Bench, pass 3: as delivered, with box-detector conductive path, box heat load and box-detector conductive path 2";
    assert_eq!((&written["title"], &written["parent"]), (&json!(title), &json!("pass-2.json")));
    study.put("pass-3.json", &next.text);
    let third = bmv::job::load(&study.path("pass-3.json")).unwrap_or_else(|wrong| panic!("{}", wrong.render(false, 9)));
    assert_eq!(third.adopted.len(), 3);
}

#[test]
fn what_the_diagnosis_does_not_support_is_refused_with_what_it_does() {
    let study = study();
    let effects = || {
        vec![
            harness(Some(1)),
            other("radiative-path:box:detector", "nodes", Some(1)),
            other("heat-load:box", "node", Some(2)),
            other("heat-load:panel", "node", None),
        ]
    };
    let found = findings("ambiguous", effects(), &["conductive-path:box:detector"]);
    let said = adopt(&study, &found, &["heat-load:box"], false).expect_err("refused");
    insta::assert_snapshot!(said, @r#"
    error[adopt-refused]: diagnosis `missing` does not support `heat-load:box` (probability 0.010)
     --> command line:1:23
      |
    1 | bmv adopt pass-1.json heat-load:box
      |                       ^^^^^^^^^^^^^ the verdict is `ambiguous`, selected is `conductive-path:box:detector`
      |
      = help: accepted: `conductive-path:box:detector`, or what these data cannot tell from it: `radiative-path:box:detector`; --force adopts it all the same, and the new pass says so
    "#);
    let forced = adopt(&study, &found, &["heat-load:box"], true).expect("forced");
    assert!(
        forced.text.contains("adopted against diagnosis `missing` of pass-1.json, whose verdict is `ambiguous`"),
        "{}",
        forced.text
    );
    // A member of the group, by its effect's name alone, by the beginning of its id, with the ends exchanged.
    for text in ["radiative-path", "radiative-path:b", "radiative-path:detector:box"] {
        let next = adopt(&study, &found, &[text], false).unwrap_or_else(|said| panic!("{said}"));
        assert_eq!(next.adopted[0].1.id, "radiative-path:box:detector");
    }
    let both = ["conductive-path", "radiative-path"];
    let said = adopt(&study, &found, &both, false).expect_err("rivals");
    assert!(
        said.contains("these data cannot tell them apart") && said.contains("a phase at T_plate = 39.85 degC"),
        "{said}"
    );
    assert_eq!(adopt(&study, &found, &both, true).expect("forced").adopted.len(), 2);
    for (text, part) in [
        ("heat-load", "stands for 2 effects of diagnosis `missing`"),
        ("heat-laod:box", "the nearest: `heat-load:box`"),
        ("thermal-mass:box", "these data cannot see `thermal-mass:box`: steady data see no capacity"),
        ("", "diagnosis `missing` has no effect (an empty name)"),
    ] {
        let said = adopt(&study, &found, &[text], false).expect_err("refused");
        assert!(said.contains(part), "{text}: {said}");
    }
    for (verdict, part) in [
        ("adequate", "these data need no further effect"),
        ("unexplained", "nothing of the catalogue explains it"),
        ("ambiguous", "name one of `conductive-path:box:detector` and `radiative-path:box:detector`"),
    ] {
        let found = findings(verdict, effects(), &[]);
        let said = adopt(&study, &found, &[], false).expect_err("nothing selected");
        assert!(said.contains(part), "{said}");
        assert_eq!(adopt(&study, &found, &["conductive-path"], false).is_ok(), verdict == "ambiguous");
    }
}

#[test]
fn a_next_pass_lies_beside_its_parent_and_replaces_nothing_unasked() {
    let study = study();
    let pass = study.load();
    let asked = Asked::new("bmv adopt pass-1.json", &[]);
    let at = |out: Option<&str>| {
        let out = out.map(|name| study.path(name));
        destination(&pass, out.as_deref(), &asked.command()).map_err(|wrong| wrong.message)
    };
    assert_eq!(at(None), Ok(study.path("pass-2.json")));
    study.put("pass-2.json", "mine").put("pass-4.json", "mine");
    assert_eq!(at(None), Ok(study.path("pass-3.json")), "the first free number");
    assert_eq!(at(Some("pass-9.json")), Ok(study.path("pass-9.json")));
    for wrong in ["pass-1.json", "model.json", "data/pass-2.json", "pass-2", "none/pass-2.json", "../pass-2.json"] {
        assert!(at(Some(wrong)).is_err(), "{wrong}");
    }
    let found = findings("identified", vec![harness(None)], &["conductive-path:box:detector"]);
    let text = adopt(&study, &found, &[], false).expect("adopted").text;
    let (second, third) = (study.path("pass-2.json"), study.path("pass-3.json"));
    assert!(write(&text, &[], &second, false, &asked.command()).is_err());
    assert_eq!(std::fs::read_to_string(&second).expect("readable"), "mine");
    assert!(
        write(&text, &[], &second, true, &asked.command()).is_ok()
            && write(&text, &[], &third, false, &asked.command()).is_ok()
    );
    // What does not load is not written.
    let broken = text.replace("conductive-path\": {", "conductive-pat\": {");
    let wrong = write(&broken, &[], &study.path("pass-5.json"), false, &asked.command()).expect_err("unknown");
    assert!(wrong.render(false, 9).contains("unknown effect `conductive-pat`"));
    let mut files: Vec<_> =
        std::fs::read_dir(study.path("")).expect("readable").flatten().map(|file| file.file_name()).collect();
    files.sort();
    assert_eq!(files, ["data", "model.json", "pass-1.json", "pass-2.json", "pass-3.json", "pass-4.json"]);
}

#[test]
fn what_belongs_to_the_test_alone_acts_in_no_prediction() {
    let study = study();
    let with_flight = PASS.replace(r#""jobs": {"#, r#""environments": {"orbit": {"Q": 9}}, "jobs": {"#);
    study.put("pass-1.json", &with_flight);
    let pass = study.load();
    let found = findings("identified", vec![harness(None)], &["conductive-path:box:detector"]);
    let written = |acting: Acting| {
        let asked = Asked::new("bmv adopt pass-1.json", &[]).acting(acting);
        let next = next_pass(&pass, "missing", &found, &asked, false, &study.path("pass-2.json"));
        let next = next.map_err(|wrong| wrong.render(false, 9))?;
        assert!(next.acts_on_model);
        study.put("pass-2.json", &next.text);
        Ok::<_, String>(
            bmv::job::load(&study.path("pass-2.json")).unwrap_or_else(|wrong| panic!("{}", wrong.render(false, 9))),
        )
    };
    let everywhere = written(Acting::Everywhere).expect("adopted");
    assert!(["balance", "run", "run (part 2)", "orbit"].iter().all(|name| everywhere.adopted[0].acts_in(name)));
    let evidence = everywhere.adopted[0].evidence.clone().expect("there");
    assert_eq!((evidence.job.as_str(), evidence.probability), ("missing", Some(0.98)));
    assert_eq!(evidence.sd, [("conductance".to_owned(), 0.0031)]);
    let ids = ["conductive-path:box:detector"];
    assert!(twin(&pass, &ids, None).is_some(), "the same");
    let of_tests = ["balance".to_owned(), "run".to_owned()];
    assert!(twin(&pass, &ids, Some(&of_tests)).is_none(), "it acts elsewhere");
    let test_only = written(Acting::InTests).expect("adopted");
    assert_eq!(test_only.adopted[0].applies_to, of_tests);
    // Where nothing is asked for, a pass in which it was said by hand is the same too.
    assert!(twin(&pass, &ids, None).is_some() && twin(&pass, &ids, Some(&of_tests)).is_some());
    assert!(test_only.adopted[0].acts_in("run (part 2)") && !test_only.adopted[0].acts_in("orbit"));
    let switch = test_only.model.inputs.iter().position(|input| input.name.ends_with(".applies")).expect("there");
    assert_eq!(test_only.environments[0].inputs[switch], 0.0, "flight is without it");
    let named = written(Acting::In(vec!["balance".into(), "orbit".into()])).expect("adopted");
    assert_eq!(named.environments[0].inputs[switch], 1.0);
    let wrong = written(Acting::In(vec!["orbti".into()])).map(|_| ()).expect_err("unknown");
    assert!(wrong.contains("unknown measurement or environment `orbti`") && wrong.contains("`orbit`"), "{wrong}");
    let (words, tests) = acts_in(&pass, &Acting::Everywhere, true);
    assert_eq!(
        words,
        "it acts in measurements `balance` and `run` and in environment `orbit`, and in every prediction of later passes"
    );
    assert_eq!(tests.as_deref(), Some(r#"["balance", "run"]"#));
    let (words, tests) = acts_in(&pass, &Acting::InTests, false);
    assert_eq!(
        (words.starts_with("they act in measurements `balance` and `run` alone; environment `orbit`"), tests),
        (true, None),
        "{words}"
    );
}

#[test]
fn a_probability_of_a_diagnosis_is_none_beyond_0_and_1() {
    let study = study();
    let found = findings("identified", vec![harness(None)], &["conductive-path:box:detector"]);
    let next = adopt(&study, &found, &[], false).expect("adopted");
    study.put("pass-2.json", next.text.replace(r#""probability": 0.98"#, r#""probability": 98"#));
    let wrong = bmv::job::load(&study.path("pass-2.json")).map(|_| ()).expect_err("refused").render(false, 9);
    assert!(wrong.contains("a probability of 98") && wrong.contains("a number from 0 to 1"), "{wrong}");
}

/// Trajectories ask for gradients of all rows: long records are calibrated by one likelihood a draw.
#[test]
fn the_calibration_that_is_added_suits_the_length_of_the_record() {
    let sampler = |rows: usize, bias: &str| {
        let study = study();
        let log: String = (0..rows).map(|row| format!("{},6,17.{}\n", 600 * row, row % 7)).collect();
        study.put("data/run.csv", format!("time [s],Q [W],TC box [degC]\n{log}"));
        let without = PASS.replace(r#""tuned": {"calibrate": {"draws": 1e3, "parameters": ["G"]}}, "#, "");
        study.put("pass-1.json", without.replace(r#""bias": {"value": 0, "unit": "K"}"#, bias));
        let found = findings("identified", vec![harness(None)], &["conductive-path:box:detector"]);
        let next = adopt(&study, &found, &[], false).expect("adopted");
        let written: Value = serde_json::from_str(&next.text).expect("JSON");
        written["jobs"]["tuned"]["calibrate"].clone()
    };
    let known = r#""bias": {"value": 0, "unit": "K"}"#;
    let long = sampler(200, known);
    assert_eq!((&long["sampler"], &long["draws"]), (&json!("independence-metropolis"), &json!(8000)), "{long}");
    let short = sampler(199, known);
    assert_eq!((&short["sampler"], &short["draws"]), (&Value::Null, &Value::Null), "{short}");
    // Offsets of sensors make ridges.
    let inferred = sampler(199, r#""bias": {"prior": {"normal": {"mean": 0, "sd": 0.75}}, "unit": "K"}"#);
    assert_eq!(inferred["acceptance"], json!(0.95), "{inferred}");
}

/// Settings that failed are not written again: those stand there that the result of the parent names.
#[test]
fn a_calibration_that_did_not_converge_is_mended_in_the_next_pass() {
    let study = study();
    let found = findings("identified", vec![harness(None)], &["conductive-path:box:detector"]);
    let written = |settings: &str| {
        let mended = vec![Mended { job: "tuned".into(), settings: settings.into() }];
        let asked = Asked::new("bmv adopt pass-1.json", &[]).mending(mended);
        let pass = study.load();
        let next = next_pass(&pass, "missing", &found, &asked, false, &study.path("pass-2.json")).expect("adopted");
        assert_eq!(next.mended.len(), 1);
        study.put("pass-2.json", &next.text);
        bmv::job::load(&study.path("pass-2.json")).map(|_| ()).expect("what is proposed is accepted");
        let text: Value = serde_json::from_str(&next.text).expect("JSON");
        text["jobs"]["tuned"]["calibrate"].clone()
    };
    let short_steps = written(r#""acceptance": 0.95, "warmup": 1000"#);
    assert_eq!((&short_steps["acceptance"], &short_steps["draws"]), (&json!(0.95), &json!(1e3)), "{short_steps}");
    let other = written(r#""sampler": "smc""#);
    assert_eq!((&other["sampler"], &other["draws"]), (&json!("smc"), &Value::Null), "{other}");
    assert!(other["parameters"].as_array().is_some_and(|names| names.len() == 2), "{other}");
}

#[test]
fn an_effect_is_named_by_its_last_places_where_these_stand_for_one() {
    let study = study();
    let all = vec![harness(None), other("heat-load:panel", "node", None), other("thermal-mass:panel", "node", None)];
    let found = findings("identified", all, &["conductive-path:box:detector"]);
    let next = adopt(&study, &found, &["box:detector"], false).expect("adopted");
    assert_eq!(next.adopted[0].1.id, "conductive-path:box:detector");
    let wrong = adopt(&study, &found, &["panel"], true).expect_err("two end so");
    assert!(wrong.contains("`panel` stands for 2 effects") && wrong.contains("`thermal-mass:panel`"), "{wrong}");
    // A part of a name is none.
    assert!(adopt(&study, &found, &["tector"], false).is_err());
}
