//! What a diagnosis suspects before it invents physics: priors that are too narrow, signs, units, the stated noise, phases that
//! drift; and what it must not lose on the way: nodes that begin to store heat, laws that are one thing here.

use bmv::batch::next_pass::{Asked, next_pass};
use bmv::diagnosis::{Output, Verdict};
use bmv::job::ready::Readiness;
use bmv::random::StreamKey;
use bmv::study::Pass;

use crate::serial;

/// A plate and a box behind it; `PRIOR` and `POWER` stand for a prior and the heater's power.
const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A plate and a box on a cold sink",
  "inputs": {"T_sink": {"unit": "K", "nominal": 280, "range": [260, 300]}, "Q": {"unit": "W", "nominal": 2, "range": [0, 10]}},
  "parameters": {"G": {"unit": "W/K", "nominal": 0.5, "prior": {"uniform": PRIOR}, "source": "assumed"},
    "G_b": {"unit": "W/K", "nominal": 0.3, "prior": {"uniform": [0.2, 0.4]}, "source": "assumed"}},
  "nodes": {"sink": {"boundary": "T_sink"}, "plate": {"capacity": 100}, "box": {"capacity": 50}},
  "conductors": {
    "feet": {"between": ["plate", "sink"], "conductance": "G"},
    "joint": {"between": ["plate", "box"], "conductance": "G_b"}
  },
  "loads": {"heater": {"into": "plate", "power": "POWER"}, "electronics": {"into": "box", "power": 2}}
}"#;
/// Sink in K, heater in W.
const PHASES: [[f64; 2]; 10] = [
    [280.0, 0.0],
    [280.0, 5.0],
    [265.0, 10.0],
    [300.0, 1.0],
    [270.0, 3.0],
    [290.0, 8.0],
    [260.0, 6.0],
    [295.0, 2.0],
    [285.0, 9.0],
    [275.0, 4.0],
];

struct Study(tempfile::TempDir);

impl Study {
    fn new(model: &str, table: &str, pass: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, text) in [("model.json", model), ("data.csv", table), ("pass-1.json", pass)] {
            std::fs::write(folder.path().join(name), text).expect("written");
        }
        Self(folder)
    }

    /// Steady phases of the plate and the box with these conductances and a heater of so many times its input; `noise` in K is
    /// what the readings have, `sigma` what is stated.
    fn steady(prior: &str, power: &str, [g, g_b, times]: [f64; 3], [noise, sigma]: [f64; 2], effects: &str) -> Self {
        let key = StreamKey::new(21, "suspects", "noise");
        let mut stream = key.stream(0);
        let mut table = String::from("phase,T_sink [K],Q [W],plate [K],box [K]\n");
        for (row, [sink, q]) in PHASES.iter().enumerate() {
            // By hand: all heat leaves through the feet.
            let plate = sink + (times * q + 2.0) / g;
            let read = [plate, plate + 2.0 / g_b].map(|value| value + noise * stream.normal());
            table.push_str(&format!("P{row},{sink},{q},{:e},{:e}\n", read[0], read[1]));
        }
        let sensor =
            |name: &str| format!(r#""{name}": {{"measures": "{name}", "sigma": {{"value": {sigma}, "unit": "K"}}}}"#);
        let pass = format!(
            r#"{{"format": "bmv-pass/1", "title": "Suspects", "parent": null, "model": "model.json", "seed": 3,
            "measurements": {{"test": {{"steady": {{"file": "data.csv", "sensors": {{{}, {}}}}}}}}},
            "jobs": {{"missing": {{"diagnose": {effects}}}}}}}"#,
            sensor("plate"),
            sensor("box")
        );
        Self::new(&MODEL.replace("PRIOR", prior).replace("POWER", power), &table, &pass)
    }

    fn load(&self, file: &str) -> Pass {
        bmv::job::load(&self.0.path().join(file)).unwrap_or_else(|wrong| panic!("{}", wrong.render(false, 20)))
    }

    fn result(&self) -> serde_json::Value {
        let (_, readiness) = bmv::job::ready(&self.load("pass-1.json")).into_iter().next().expect("a job");
        let Readiness::Ready(job) = readiness else { panic!("ready") };
        serial::run(job.as_ref()).expect("a result")
    }

    fn diagnosed(&self) -> Output {
        serde_json::from_value(self.result()).expect("a diagnosis")
    }
}

const ALL: &str = "{}";
const TRUE: [f64; 3] = [0.5, 0.3, 1.0];

#[test]
fn a_prior_that_excludes_the_truth_is_named_before_any_effect() {
    // Below its prior no path can help; the plate's conductor lets through too much.
    let study = Study::steady("[0.45, 0.55]", "Q", [0.35, 0.3, 1.0], [0.1, 0.1], ALL);
    let output = study.diagnosed();
    let said = (output.verdict, output.selected.as_slice());
    assert_eq!(said, (Verdict::Identified, &["prior-of:G".to_owned()][..]), "{:?}", output.words);
    let own = output.effects.iter().find(|effect| effect.id == "prior-of:G").expect("listed");
    let fitted = &own.amplitudes["G"];
    assert!((fitted.value - 0.35).abs() < 3.0 * fitted.sd && fitted.sd < 0.01, "{fitted:?}");
    assert!(output.words[1].starts_with("A prior is too narrow") && output.words[1].contains("0.450 to 0.550 W/K"));
    // Adopted, it is a wider prior with its reason, and what it takes for plausible holds the truth.
    let pass = study.load("pass-1.json");
    let asked = Asked::new("bmv adopt pass-1.json", &[]);
    let path = study.0.path().join("pass-2.json");
    let next = next_pass(&pass, "missing", &output, &asked, false, &path).unwrap_or_else(|_| panic!("it is written"));
    std::fs::write(&path, &next.text).expect("written");
    let after = study.load("pass-2.json");
    assert_eq!((after.adopted.len(), after.changes.len()), (0, 1), "{}", next.text);
    assert!(after.changes[0].name == "G" && after.changes[0].because.contains("too narrow for these data"));
    assert!((after.model.parameters[0].nominal - fitted.most_probable).abs() < 1e-3);
    let (low, high) = (after.priors[0].quantile(0.01), after.priors[0].quantile(0.99));
    assert!(0.0 < low && low < 0.35 && high > 0.55, "{low} {high}");
    assert_eq!(bmv::batch::next_pass::twin(&pass, &["prior-of:G"], None), Some(path), "it is there already");
    assert_eq!(bmv::batch::next_pass::twin(&pass, &["prior-of:G_b"], None), None);
}

#[test]
fn a_path_beside_a_conductor_and_its_prior_are_rivals_and_the_prior_goes_first() {
    let effects = r#"{"effects": ["prior-of", "conductive-path", "heat-load", "sensor-bias"]}"#;
    let study = Study::steady("[0.45, 0.55]", "Q", [0.75, 0.3, 1.0], [0.1, 0.1], effects);
    let output = study.diagnosed();
    assert_eq!(output.selected, ["prior-of:G"], "{:?}", output.words);
    let path = output.effects.iter().find(|effect| effect.id == "conductive-path:plate:sink").expect("a rival");
    assert!(path.group.is_some(), "{:?}", output.words);
    assert!(path.hints.iter().any(|hint| hint.contains("acts as `feet` at")), "{:?}", path.hints);
}

#[test]
fn nothing_is_said_of_priors_that_hold_the_truth() {
    let output = Study::steady("[0.3, 0.7]", "Q", TRUE, [0.1, 0.1], ALL).diagnosed();
    assert_eq!((output.verdict, output.warnings.len()), (Verdict::Adequate, 0), "{:?}", output.warnings);
    let why = |id: &str| output.unseen.iter().find(|unseen| unseen.id == id).map(|unseen| unseen.why.as_str());
    assert_eq!(why("prior-of:G"), Some("nothing presses the parameter out of its prior"));
}

#[test]
fn a_load_taken_back_twice_over_is_a_sign_error() {
    let effects = r#"{"effects": ["input-proportional-load", "heat-load", "sensor-bias"]}"#;
    let output = Study::steady("[0.3, 0.7]", "-Q", TRUE, [0.1, 0.1], effects).diagnosed();
    let own = output.effects.iter().find(|effect| effect.id == "input-proportional-load:plate:Q").expect("listed");
    let said = |hint: &String| hint.contains("`heater`") && hint.contains("sign error");
    assert!(own.hints.iter().any(said), "{:?} {:?}", own.hints, own.amplitudes);
    assert!(output.words.iter().any(|word| word.contains("sign error")), "{:?}", output.words);
}

#[test]
fn a_load_of_418_times_its_size_is_a_wrong_unit() {
    let effects = r#"{"effects": ["input-proportional-load", "heat-load", "sensor-bias"]}"#;
    let output = Study::steady("[0.499, 0.501]", "Q", [0.5, 0.3, 4.1868], [0.02, 0.02], effects).diagnosed();
    let own = output.effects.iter().find(|effect| effect.id == "input-proportional-load:plate:Q").expect("listed");
    assert!(own.hints.iter().any(|hint| hint.contains("cal for J")), "{:?} {:?}", own.hints, own.amplitudes);
    // At 1.5 times nothing is known of it but that it acts as the load does.
    let output = Study::steady("[0.499, 0.501]", "Q", [0.5, 0.3, 1.5], [0.02, 0.02], effects).diagnosed();
    let own = output.effects.iter().find(|effect| effect.id == "input-proportional-load:plate:Q").expect("listed");
    assert!(own.hints.len() == 1 && own.hints[0].contains("Check that number first"), "{:?}", own.hints);
}

#[test]
fn a_stated_noise_that_is_too_large_is_said_once_with_its_size() {
    let output = Study::steady("[0.3, 0.7]", "Q", TRUE, [0.1, 0.5], ALL).diagnosed();
    let said: Vec<&String> = output.warnings.iter().filter(|warning| warning.contains("`sigma`")).collect();
    assert_eq!(said.len(), 1, "{:?}", output.warnings);
    assert!(said[0].contains("plate 0.") && said[0].contains("instead of 0.5 K"), "{said:?}");
}

#[test]
fn laws_that_no_phase_tells_apart_are_one_thing() {
    let effects = r#"{"effects": ["input-proportional-load", "heater-efficiency"]}"#;
    let output = Study::steady("[0.499, 0.501]", "Q", [0.5, 0.3, 0.8], [0.1, 0.1], effects).diagnosed();
    assert_eq!(output.verdict, Verdict::Ambiguous, "{:?}", output.words);
    assert_eq!(output.discriminating_experiment, None);
    let one = output.one_thing.expect("one thing");
    let mut sets = one.sets.clone();
    sets.sort();
    assert_eq!(sets, ["heater-efficiency:heater", "input-proportional-load:plate:Q"]);
    assert!(
        one.probability < 0.6
            && output.words.iter().any(|word| word.starts_with("No steady phase within the stated ranges"))
    );
}

/// A box behind a blanket that the model takes for weightless; the start is given for the box, the only node that stores.
const BLANKET: &str = r#"{
  "format": "bmv-network/1",
  "title": "A box in a blanket",
  "inputs": {"T_sink": {"unit": "K", "nominal": 200, "range": [100, 300]}, "Q": {"unit": "W", "nominal": 2, "range": [0, 40]}},
  "parameters": {"G": {"unit": "W/K", "nominal": 0.2, "prior": {"uniform": [0.15, 0.25]}, "source": "assumed"}},
  "nodes": {"sink": {"boundary": "T_sink"}, "box": {"capacity": 400}, "mli": {}},
  "conductors": {"inner": {"between": ["box", "mli"], "conductance": "G"}, "outer": {"between": ["mli", "sink"], "conductance": 0.1}},
  "loads": {"heater": {"into": "box", "power": "Q"}}
}"#;

#[test]
#[ignore = "thorough"]
fn a_node_that_begins_to_store_heat_starts_in_balance_and_is_found() {
    let key = StreamKey::new(23, "suspects", "noise");
    let mut stream = key.stream(0);
    let mut table = String::from("time [s],T_sink [K],Q [W],box [K],mli [K]\n");
    // By hand, in steps of a second: the blanket has 150 J/K and starts where 0.2 (T_box - T) = 0.1 (T - 200 K).
    let (mut inner, mut blanket) = (300.0_f64, (0.2 * 300.0 + 0.1 * 200.0) / 0.3);
    let power = |second: usize| if second < 3000 { 2.0 } else { 12.0 };
    for second in 0..=6000_usize {
        if second.is_multiple_of(100) {
            let read = [inner, blanket].map(|value| value + 0.05 * stream.normal());
            table.push_str(&format!("{second},200,{},{:e},{:e}\n", power(second), read[0], read[1]));
        }
        let through = 0.2 * (inner - blanket);
        (inner, blanket) =
            (inner + (power(second) - through) / 400.0, blanket + (through - 0.1 * (blanket - 200.0)) / 150.0);
    }
    let sensor = |name: &str| format!(r#""{name}": {{"measures": "{name}", "sigma": {{"value": 0.05, "unit": "K"}}}}"#);
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": "Blanket", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {{"test": {{"transient": {{"file": "data.csv", "hold": ["Q"],
            "initial": {{"temperatures": {{"box": {{"value": 300, "unit": "K"}}}}}}, "sensors": {{{}, {}}}}}}}}},
        "jobs": {{"missing": {{"diagnose": {{"effects": ["thermal-mass", "heat-load", "hidden-node"]}}}}}}}}"#,
        sensor("box"),
        sensor("mli")
    );
    let study = Study::new(BLANKET, &table, &pass);
    let output = study.diagnosed();
    assert_eq!(output.selected, ["thermal-mass:mli"], "{:?} {:?}", output.words, output.warnings);
    let capacity =
        &output.effects.iter().find(|own| own.id == "thermal-mass:mli").expect("listed").amplitudes["capacity"];
    assert!((capacity.value - 150.0).abs() < 4.0 * capacity.sd + 1.0, "{capacity:?}");
    // Adopted, with no start of its own, it starts in balance too.
    let adopted = r#"{"format": "bmv-pass/1", "title": "Blanket", "parent": "pass-1.json", "seed": 3, "adopt": {"mass": {"effect": {"thermal-mass":
        {"where": "mli", "parameters": {"capacity": {"unit": "J/K", "prior": {"fixed": 150}}}}}, "because": "a test"},
        "part": {"effect": {"hidden-node": {"where": "mli"}}, "because": "a test"}},
        "jobs": {"fit": {"compare": {}}}}"#;
    std::fs::write(study.0.path().join("pass-2.json"), adopted).expect("written");
    let pass = study.load("pass-2.json");
    let predictor = bmv::measurement::prediction::Predictor::new(&pass.model, &[]).expect("compiled");
    let parameters: Vec<f64> = pass.model.parameters.iter().map(|own| own.nominal).collect();
    let found = predictor.predict(&mut predictor.workspace(), &pass.measurements[0], &parameters);
    assert!(found.failures.is_empty(), "{:?}", found.failures);
    assert!((found.readings[1] - (0.2 * 300.0 + 0.1 * 200.0) / 0.3).abs() < 1e-6, "{}", found.readings[1]);
}

/// A plate on feet, of which the test only ever moved the heater.
const ON_FEET: &str = r#"{
  "format": "bmv-network/1",
  "title": "A plate on feet",
  "inputs": {"T_sink": {"unit": "K", "nominal": 280, "range": [250, 310]}, "Q": {"unit": "W", "nominal": 2, "range": [0, 10]}},
  "parameters": {"G": {"unit": "W/K", "nominal": 0.3, "prior": {"uniform": [0.2, 0.4]}, "source": "assumed"}},
  "nodes": {"sink": {"boundary": "T_sink"}, "plate": {"capacity": 400}},
  "conductors": {"feet": {"between": ["plate", "sink"], "conductance": "G"}},
  "loads": {"heater": {"into": "plate", "power": "Q"}}
}"#;

/// The diagnosis of a plate that stores 40 J/K more than its model has, at the plate or in its feet: the heater is switched on once.
fn slow_plate(model: &str) -> Output {
    let key = StreamKey::new(29, "suspects", "noise");
    let mut stream = key.stream(0);
    let mut table = String::from("time [s],T_sink [K],Q [W],plate [K]\n");
    let mut plate = 280.0_f64;
    for second in 0..=6000_usize {
        let power = if second < 600 { 0.0 } else { 5.0 };
        if second.is_multiple_of(60) {
            table.push_str(&format!("{second},280,{power},{:e}\n", plate + 0.05 * stream.normal()));
        }
        // By hand, in steps of a second: 40 J/K more than the model has.
        plate += (power - 0.3 * (plate - 280.0)) / 440.0;
    }
    let pass = r#"{"format": "bmv-pass/1", "title": "Feet", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {"test": {"transient": {"file": "data.csv", "hold": ["Q"], "initial": {"steady": {}},
            "sensors": {"plate": {"measures": "plate", "sigma": {"value": 0.05, "unit": "K"}}}}}},
        "jobs": {"missing": {"diagnose": {"effects": ["thermal-mass", "path-capacity"]}}}}"#;
    Study::new(model, &table, pass).diagnosed()
}

/// Storage at the plate or in its feet: both are slow to follow the heater, and no steady phase can tell which it is. A step of
/// the sink can, which the feet's storage holds back.
#[test]
fn what_stores_heat_is_told_apart_by_a_step_and_by_no_steady_phase() {
    let output = slow_plate(ON_FEET);
    assert_eq!(output.verdict, Verdict::Ambiguous, "{:?}", output.words);
    assert_eq!((&output.discriminating_experiment, &output.one_thing), (&None, &None), "{:?}", output.words);
    let apart = output.only_in_transients.as_ref().expect("told apart by a transient");
    let mut between = apart.between.clone();
    between.sort();
    assert_eq!(between, ["path-capacity:feet", "thermal-mass:plate"]);
    let step = apart.step.as_ref().expect("a step");
    assert!(step.input == "T_sink" && step.probability > 0.8 && !step.was_set, "{step:?}");
    assert!((1000.0..3000.0).contains(&step.time_constant_s) && step.slowest == "plate", "{step:?}");
    assert!((step.duration_s / step.time_constant_s - 3.0).abs() < 1e-9, "{step:?}");
    let said = |text: &str| output.words.iter().any(|word| word.contains(text));
    assert!(said("No steady phase can tell") && said("a step of T_sink from"), "{:?}", output.words);
}

/// At 100 W the plate would end 333 K above the sink: the step is watched only until it is 30 K beyond all readings.
#[test]
fn a_step_is_watched_as_long_as_the_hardware_surely_bears_it() {
    let model = ON_FEET.replace("[250, 310]", "[279, 281]").replace("[0, 10]", "[0, 100]");
    let output = slow_plate(&model);
    let apart = output.only_in_transients.as_ref().expect("told apart by a transient");
    let step = apart.step.as_ref().expect("a step");
    assert!(step.input == "Q" && step.from.value == 0.0 && step.to.value == 100.0, "{step:?}");
    assert!(step.near_tested && step.limits_ok && step.ends_early && step.probability > 0.8, "{step:?}");
    assert!(output.words.iter().any(|words| words.contains("and must end then")), "{:?}", output.words);
    // By hand: without losses 440 J/K are warmed by 16 + 30 K in 203 s.
    assert!((150.0..300.0).contains(&step.duration_s), "{step:?}");
}
