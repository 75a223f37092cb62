//! Wrong effects and wrong adoptions.

use crate::diagnostics::pass_study::Study;

/// What is said of a pass with these entries put in before `design`.
fn said(entries: &str) -> String {
    let study = Study::new();
    study.edit("pass-1.json", r#""design": {"A""#, &format!(r#"{entries}"design": {{"A""#));
    study.said("pass-1.json")
}

/// What is said of a study with an effect of its own.
fn said_of_own(text: &str) -> String {
    let study = Study::new();
    study.put("effects/own.json", text);
    study.said("pass-1.json")
}

#[test]
fn an_unknown_effect() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"conductiv-path": {"where": ["box", "panel"]}},
   "because": "seen"}},
 "##), @r##"
    error[unknown-effect]: unknown effect `conductiv-path`
     --> study/pass-1.json:8:35
      |
    8 |  "adopt": {"harness": {"effect": {"conductiv-path": {"where": ["box", "panel"]}},
      |                                   ^^^^^^^^^^^^^^^^ one of `conductive-path`, `radiative-path`, `gas-conduction`, `convection`, `path-to-ambient`, `path-to-logged-temperature`, `radiation-to-ambient`, `free-convection`, `heat-load`, `input-proportional-load`, `joule-heating`, `product-load` and 40 more
      |
      = note: at $.adopt.harness.effect["conductiv-path"]
      = help: did you mean `conductive-path`?
    "##);
}

#[test]
fn no_place() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"conductive-path": {}},
   "because": "seen"}},
 "##), @r##"
    error[effect-place]: `conductive-path` does not say where it acts
     --> study/pass-1.json:8:35
      |
    8 |  "adopt": {"harness": {"effect": {"conductive-path": {}},
      |                                   ^^^^^^^^^^^^^^^^^ "where": two nodes
      |
      = note: at $.adopt.harness.effect["conductive-path"]
    "##);
}

#[test]
fn an_unknown_node() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "pannel"]}},
   "because": "seen"}},
 "##), @r##"
    error[effect-place]: unknown node `pannel`
     --> study/pass-1.json:8:72
      |
    8 |  "adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "pannel"]}},
      |                                                                        ^^^^^^^^ one of `plate`, `shroud`, `box` and `panel`
      |
      = note: at $.adopt.harness.effect["conductive-path"].where[1]
      = help: did you mean `panel`?
    "##);
}

#[test]
fn one_node_for_a_pair() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"conductive-path": {"where": "box"}},
   "because": "seen"}},
 "##), @r##"
    error[effect-place]: `conductive-path` does not act on one name
     --> study/pass-1.json:8:64
      |
    8 |  "adopt": {"harness": {"effect": {"conductive-path": {"where": "box"}},
      |                                                                ^^^^^ two nodes
      |
      = note: at $.adopt.harness.effect["conductive-path"].where
    "##);
}

#[test]
fn a_node_twice() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "box"]}},
   "because": "seen"}},
 "##), @r##"
    error[effect-place]: `box` stands twice
     --> study/pass-1.json:8:72
      |
    8 |  "adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "box"]}},
      |                                                                        ^^^^^ two nodes
      |
      = note: at $.adopt.harness.effect["conductive-path"].where[1]
    "##);
}

#[test]
fn a_boundary_where_a_node_is_wanted() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"heat-load": {"where": "plate"}},
   "because": "seen"}},
 "##), @r##"
    error[effect-place]: `plate` is a boundary
     --> study/pass-1.json:8:58
      |
    8 |  "adopt": {"harness": {"effect": {"heat-load": {"where": "plate"}},
      |                                                          ^^^^^^^ a node that is no boundary, or {"group": NAME}: `box` and `panel`
      |
      = note: at $.adopt.harness.effect["heat-load"].where
    "##);
}

#[test]
fn an_unknown_conductor() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"temperature-dependent-conductance": {"where": "strip"}},
   "because": "seen"}},
 "##), @r##"
    error[effect-place]: unknown conductor `strip`
     --> study/pass-1.json:8:82
      |
    8 |  "adopt": {"harness": {"effect": {"temperature-dependent-conductance": {"where": "strip"}},
      |                                                                                  ^^^^^^^ one of `bolts` and `strap`
      |
      = note: at $.adopt.harness.effect["temperature-dependent-conductance"].where
      = help: did you mean `strap`?
    "##);
}

#[test]
fn an_unknown_group() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"path-to-ambient": {"where": {"group": "rod"}}},
   "because": "seen"}},
 "##), @r##"
    error[unknown-name]: unknown group `rod`
     --> study/pass-1.json:8:74
      |
    8 |  "adopt": {"harness": {"effect": {"path-to-ambient": {"where": {"group": "rod"}}},
      |                                                                          ^^^^^ there is no group
      |
      = note: at $.adopt.harness.effect["path-to-ambient"].where.group
    "##);
}

#[test]
fn an_input_that_is_not_bound() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"joule-heating": {"where": "box"}},
   "because": "seen"}},
 "##), @r##"
    error[effect-input]: the input `current` of `joule-heating` is not bound
     --> study/pass-1.json:8:35
      |
    8 |  "adopt": {"harness": {"effect": {"joule-heating": {"where": "box"}},
      |                                   ^^^^^^^^^^^^^^^ "inputs": {"current": NAME}, an input of the model
      |
      = note: at $.adopt.harness.effect["joule-heating"]
    "##);
}

#[test]
fn all_inputs_that_are_not_bound() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"product-load": {"where": "box"}},
   "because": "seen"}},
 "##), @r##"
    error[effect-input]: the inputs `first` and `second` of `product-load` are not bound
     --> study/pass-1.json:8:35
      |
    8 |  "adopt": {"harness": {"effect": {"product-load": {"where": "box"}},
      |                                   ^^^^^^^^^^^^^^ "inputs": {"first": NAME, "second": NAME}, inputs of the model
      |
      = note: at $.adopt.harness.effect["product-load"]
    "##);
}

#[test]
fn an_input_of_another_unit() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"joule-heating": {"where": "box", "inputs": {"current": "T_s"}}},
   "because": "seen"}},
 "##), @r##"
    error[effect-input]: `T_s` cannot stand for the input `current`
     --> study/pass-1.json:8:91
      |
    8 |  "adopt": {"harness": {"effect": {"joule-heating": {"where": "box", "inputs": {"current": "T_s"}}},
      |                                                                                           ^^^^^ an input in A or V or W
      |
      = note: at $.adopt.harness.effect["joule-heating"].inputs.current
    "##);
}

#[test]
fn an_unknown_input() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"input-proportional-load": {"where": "box", "inputs": {"input": "R"}}},
   "because": "seen"}},
 "##), @r##"
    error[effect-input]: unknown input `R`
     --> study/pass-1.json:8:99
      |
    8 |  "adopt": {"harness": {"effect": {"input-proportional-load": {"where": "box", "inputs": {"input": "R"}}},
      |                                                                                                   ^^^ one of `T_if`, `Q` and `T_s`
      |
      = note: at $.adopt.harness.effect["input-proportional-load"].inputs.input
      = help: did you mean `Q`?
    "##);
}

#[test]
fn an_input_that_the_effect_lacks() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"heat-load": {"where": "box", "inputs": {"current": "Q"}}},
   "because": "seen"}},
 "##), @r##"
    error[effect-input]: `heat-load` has no input `current`
     --> study/pass-1.json:8:76
      |
    8 |  "adopt": {"harness": {"effect": {"heat-load": {"where": "box", "inputs": {"current": "Q"}}},
      |                                                                            ^^^^^^^^^ none
      |
      = note: at $.adopt.harness.effect["heat-load"].inputs.current
    "##);
}

#[test]
fn an_unknown_parameter() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "panel"], "parameters": {"conductivity": {"prior": {"uniform": [0, 1]}}}}},
   "because": "seen"}},
 "##), @r##"
    error[effect-parameter]: `conductive-path` has no parameter `conductivity`
     --> study/pass-1.json:8:97
      |
    8 |  "adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "panel"], "parameters": {"conductivity": {"prior": {"uniform":...
      |                                                                                                 ^^^^^^^^^^^^^^ `conductance`
      |
      = note: at $.adopt.harness.effect["conductive-path"].parameters.conductivity
    "##);
}

#[test]
fn a_parameter_of_another_unit() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "panel"],
    "parameters": {"conductance": {"unit": "W", "prior": {"uniform": [0, 1]}}}}},
   "because": "seen"}},
 "##), @r##"
    error[wrong-dimension]: the unit `W` does not fit here
     --> study/pass-1.json:9:44
      |
    9 |     "parameters": {"conductance": {"unit": "W", "prior": {"uniform": [0, 1]}}}}},
      |                                            ^^^ a unit of W/K
      |
      = note: at $.adopt.harness.effect["conductive-path"].parameters.conductance.unit
    "##);
}

#[test]
fn a_prior_on_the_wrong_side() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "panel"],
    "parameters": {"conductance": {"prior": {"uniform": [-1, 1]}}}}},
   "because": "seen"}},
 "##), @r##"
    error[effect-parameter]: the prior of `conductance` reaches values that are not physical
     --> study/pass-1.json:9:35
      |
    9 |     "parameters": {"conductance": {"prior": {"uniform": [-1, 1]}}}}},
      |                                   ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ a prior on values of 0 and more
      |
      = note: at $.adopt.harness.effect["conductive-path"].parameters.conductance
    "##);
}

#[test]
fn a_blank_reason() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "panel"]}},
   "because": " "}},
 "##), @r##"
    error[because-missing]: the reason is blank
     --> study/pass-1.json:9:15
      |
    9 |    "because": " "}},
      |               ^^^ a reason in words
      |
      = note: at $.adopt.harness.because
    "##);
}

#[test]
fn two_effects_in_one_entry() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "panel"]}, "heat-load": {"where": "box"}},
   "because": "seen"}},
 "##), @r##"
    error[one-kind]: `harness` adopts 2 effects
     --> study/pass-1.json:8:23
      |
    8 |  "adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "panel"]}, "heat-load": {"where": "box"}},
      |                       ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ an object with one key, the effect's name
      |
      = note: at $.adopt.harness
    "##);
}

#[test]
fn an_unknown_measurement() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "panel"]}},
   "because": "seen", "applies_to": ["balence"]}},
 "##), @r##"
    error[unknown-name]: unknown measurement or environment `balence`
     --> study/pass-1.json:9:38
      |
    9 |    "because": "seen", "applies_to": ["balence"]}},
      |                                      ^^^^^^^^^ one of `balance` and `hot`
      |
      = note: at $.adopt.harness.applies_to[0]
      = help: did you mean `balance`?
    "##);
}

#[test]
fn an_unknown_sensor() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"sensor-bias": {"where": "boxx"}},
   "because": "seen"}},
 "##), @r##"
    error[effect-place]: unknown sensor `boxx`
     --> study/pass-1.json:8:60
      |
    8 |  "adopt": {"harness": {"effect": {"sensor-bias": {"where": "boxx"}},
      |                                                            ^^^^^^ one of `box` and `panel`
      |
      = note: at $.adopt.harness.effect["sensor-bias"].where
      = help: did you mean `box`?
    "##);
}

#[test]
fn evidence_that_is_not_there() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "panel"]}},
   "because": "seen",
   "evidence": {"pass": "pass-0.json", "job": "missing"}}},
 "##), @r##"
    error[file-missing]: the file `pass-0.json` does not exist in the study's folder
      --> study/pass-1.json:10:25
       |
    10 |    "evidence": {"pass": "pass-0.json", "job": "missing"}}},
       |                         ^^^^^^^^^^^^^
       |
       = note: at $.adopt.harness.evidence.pass
    "##);
}

#[test]
fn an_own_effect_that_does_not_fit() {
    insta::assert_snapshot!(said_of_own(r##"{"format": "bmv-effect/1", "title": "Own", "applies": {"sensor": {}},
 "parameters": {"g": {"unit": "W/K", "prior": {"halfnormal": 0.1}, "sign": "positive"}},
 "adds": {"flow": "g * (Ta - Tb)"}, "source": "bench"}
"##), @r##"
    error[effect-file]: `flow` cannot act on a sensor
     --> study/effects/own.json:3:10
      |
    3 |  "adds": {"flow": "g * (Ta - Tb)"}, "source": "bench"}
      |          ^^^^^^^^^^^^^^^^^^^^^^^^^ under `applies`: `pair` and `node`
      |
      = note: at $.adds
    "##);
}

#[test]
fn an_own_effect_with_an_unknown_name() {
    insta::assert_snapshot!(said_of_own(r##"{"format": "bmv-effect/1", "title": "Own", "applies": {"pair": {}},
 "parameters": {"g": {"unit": "W/K", "prior": {"halfnormal": 0.1}, "sign": "positive"}},
 "adds": {"flow": "h * (Ta - Tb)"}, "source": "bench"}
"##), @r##"
    error[unknown-name]: unknown name `h`
     --> study/effects/own.json:3:20
      |
    3 |  "adds": {"flow": "h * (Ta - Tb)"}, "source": "bench"}
      |                    ^
      |
      = note: at $.adds.flow
      = help: did you mean `g`?
    "##);
}

#[test]
fn an_own_effect_whose_prior_and_sign_differ() {
    insta::assert_snapshot!(said_of_own(r##"{"format": "bmv-effect/1", "title": "Own", "applies": {"pair": {}},
 "parameters": {"g": {"unit": "W/K", "prior": {"uniform": [-1, 1]}, "sign": "positive"}},
 "adds": {"flow": "g * (Ta - Tb)"}, "source": "bench"}
"##), @r##"
    error[effect-file]: the prior of `g` reaches the sign that its `sign` excludes (positive)
     --> study/effects/own.json:2:17
      |
    2 |  "parameters": {"g": {"unit": "W/K", "prior": {"uniform": [-1, 1]}, "sign": "positive"}},
      |                 ^^^ a prior on one side of 0
      |
      = note: at $.parameters.g
    "##);
}

#[test]
fn a_reference_temperature_that_no_law_has() {
    insta::assert_snapshot!(said(r##""adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "panel"], "reference": {"value": -100, "unit": "degC"}}},
   "because": "seen"}},
 "##), @r##"
    error[effect-parameter]: the law of `conductive-path` has no reference temperature
     --> study/pass-1.json:8:95
      |
    8 |  "adopt": {"harness": {"effect": {"conductive-path": {"where": ["box", "panel"], "reference": {"value": -100, "unit": "degC"}}},
      |                                                                                               ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ no `reference`
      |
      = note: at $.adopt.harness.effect["conductive-path"].reference
    "##);
}

#[test]
fn a_reference_temperature_below_absolute_zero() {
    insta::assert_snapshot!(said(r##""adopt": {"paint": {"effect": {"temperature-dependent-emittance": {"where": "panel", "reference": -100}},
   "because": "seen"}},
 "##), @r##"
    error[out-of-range]: a reference temperature of -100 K
     --> study/pass-1.json:8:100
      |
    8 |  "adopt": {"paint": {"effect": {"temperature-dependent-emittance": {"where": "panel", "reference": -100}},
      |                                                                                                    ^^^^ a temperature above 0 K, such as {"value": 20, "unit": "degC"}
      |
      = note: at $.adopt.paint.effect["temperature-dependent-emittance"].reference
    "##);
}

/// `Tr` in a factor is the reference temperature.
#[test]
fn a_parameter_with_the_name_of_the_reference_temperature() {
    insta::assert_snapshot!(said_of_own(r##"{"format": "bmv-effect/1", "title": "Softer", "family": "properties",
  "applies": {"conductor": {}},
  "parameters": {"Tr": {"unit": "1", "prior": {"normal": {"mean": 0, "sd": 1}}}},
  "adds": {"factor": "1 + Tr"}, "source": "bench"}
"##), @r##"
    error[effect-file]: in a factor `Tr` means something else already
     --> study/effects/own.json:3:18
      |
    3 |   "parameters": {"Tr": {"unit": "1", "prior": {"normal": {"mean": 0, "sd": 1}}}},
      |                  ^^^^ another name: `Tr` is the reference temperature
      |
      = note: at $.parameters.Tr
    "##);
}

/// `rate` in a reading is how fast it changes, so that a parameter of that name would never act.
#[test]
fn a_parameter_whose_name_a_reading_has_already() {
    insta::assert_snapshot!(said_of_own(r##"{"format": "bmv-effect/1", "title": "Own", "applies": {"sensor": {}},
 "parameters": {"rate": {"unit": "K/s", "prior": {"normal": {"mean": 0, "sd": 1e-5}}}},
 "adds": {"reading": "T + rate * t"}, "source": "bench"}
"##), @r##"
    error[effect-file]: in a reading `rate` means something else already
     --> study/effects/own.json:2:17
      |
    2 |  "parameters": {"rate": {"unit": "K/s", "prior": {"normal": {"mean": 0, "sd": 1e-5}}}},
      |                 ^^^^^^ another name: `rate` is the reading's rate of change, `zero` its zero
      |
      = note: at $.parameters.rate
    "##);
}

#[test]
fn a_flow_without_its_other_end() {
    insta::assert_snapshot!(said_of_own(r##"{"format": "bmv-effect/1", "title": "Own", "applies": {"node": {}},
 "parameters": {"g": {"unit": "W/K", "prior": {"halfnormal": 0.1}, "sign": "positive"}},
 "adds": {"flow": "g * (Ta - Tb)"}, "source": "bench"}
"##), @r##"
    error[effect-file]: a `flow` of one node needs an `ambient` as its other end
     --> study/effects/own.json:3:10
      |
    3 |  "adds": {"flow": "g * (Ta - Tb)"}, "source": "bench"}
      |          ^^^^^^^^^^^^^^^^^^^^^^^^^ "ambient": {"temperature": ...}
      |
      = note: at $.adds
    "##);
}

#[test]
fn an_own_effect_without_prior() {
    insta::assert_snapshot!(said_of_own(r##"{"format": "bmv-effect/1", "title": "Own", "applies": {"pair": {}},
 "parameters": {"g": {"unit": "W/K"}},
 "adds": {"flow": "g * (Ta - Tb)"}, "source": "bench"}
"##), @r##"
    error[missing-field]: `g` has no prior
     --> study/effects/own.json:2:17
      |
    2 |  "parameters": {"g": {"unit": "W/K"}},
      |                 ^^^ `prior`
      |
      = note: at $.parameters.g
    "##);
}

#[test]
fn an_own_effect_at_no_such_place() {
    insta::assert_snapshot!(said_of_own(r##"{"format": "bmv-effect/1", "title": "Own", "applies": {"pairs": {}},
 "parameters": {"g": {"unit": "W/K", "prior": {"halfnormal": 0.1}, "sign": "positive"}},
 "adds": {"flow": "g * (Ta - Tb)"}, "source": "bench"}
"##), @r##"
    error[effect-file]: the effect has no kind of place
     --> study/effects/own.json:1:55
      |
    1 | {"format": "bmv-effect/1", "title": "Own", "applies": {"pairs": {}},
      |                                                       ^^^^^^^^^^^^^ such as {"pair": {}}
      |
      = note: at $.applies

    error[unknown-field]: unknown field `pairs`
     --> study/effects/own.json:1:56
      |
    1 | {"format": "bmv-effect/1", "title": "Own", "applies": {"pairs": {}},
      |                                                        ^^^^^^^
      |
      = note: at $.applies.pairs
      = help: did you mean `pair`?
    "##);
}
