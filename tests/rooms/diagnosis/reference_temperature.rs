//! Tests of `diagnosis/src/diagnosis/reference_temperature.rs`.

use bmv::diagnosis::Problem;

use crate::verification::small_study;

/// A cold head on a strap to a logged stage, behind it a shield without a thermometer that sees deep space, and a warm box.
const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A cold head",
  "inputs": {"T_stage": {"unit": "K", "nominal": 100, "range": [20, 400]}, "Q": {"unit": "W", "nominal": 1, "range": [0, 5]}},
  "parameters": {"G": {"unit": "W/K", "nominal": 0.1, "prior": {"uniform": [0.01, 1]}, "source": "assumed"}},
  "nodes": {"stage": {"boundary": "T_stage"}, "space": {"boundary": 3}, "head": {}, "shield": {}, "box": {"capacity": 100}},
  "conductors": {"strap": {"between": ["head", "stage"], "conductance": "G"}, "mount": {"between": ["shield", "head"], "conductance": 0.1},
    "feet": {"between": ["box", "head"], "conductance": 0.001}},
  "radiations": {"shield to space": {"between": ["shield", "space"], "exchange_area": 0.01}},
  "loads": {"dissipation": {"into": "head", "power": "Q"}, "heater": {"into": "box", "power": 1}}
}"#;

/// The last two phases are held out.
const DATA: &str = "phase,T_stage [K],Q [W],head [K],box [K]\nP1,90,1,118,290\nP2,100,1,121,300\nP3,110,1,500,310\nP4,400,1,900,20\nP5,400,1,900,20\n";

fn problem() -> Problem {
    let pass = r#"{"format": "bmv-pass/1", "title": "Cold", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {"cold": {"steady": {"file": "data.csv",
            "sensors": {"head": {"measures": "head", "sigma": {"value": 0.1, "unit": "K"}}, "box": {"measures": "box", "sigma": {"value": 0.1, "unit": "K"}}},
            "held_out": {"phases": ["P4", "P5"]}}}},
        "jobs": {"missing": {"diagnose": {}}}}"#;
    small_study::problem(&[("model.json", MODEL), ("data.csv", DATA), ("pass-1.json", pass)])
}

/// Medians of the readings that are fitted: 121 K of the head and 300 K of the box, one of each far off; of the stage what was logged,
/// 100 K; of the shield that of the head.
#[test]
fn a_place_refers_to_where_it_worked_if_that_is_far_from_room_temperature() {
    let problem = problem();
    let of = |id: &str| {
        let candidate = problem.candidates.iter().find(|own| own.id == id).unwrap_or_else(|| panic!("{id}"));
        // In degrees Celsius, which are whole.
        let celsius = |own: f64| (own - 273.15).round() as i64;
        (celsius(problem.reference_k(candidate)), problem.stated_reference_k(candidate).map(celsius))
    };
    // The mean of 121 K and 100 K is -162.65 degC.
    assert_eq!(of("temperature-dependent-conductance:strap"), (-160, Some(-160)));
    // The hotter end, 121 K, not space.
    assert_eq!(of("temperature-dependent-emittance:shield to space"), (-150, Some(-150)));
    assert_eq!(of("dissipation-temperature:dissipation"), (-150, Some(-150)));
    // 300 K is near: 20 degC. So is nothing that has no such law.
    assert_eq!(of("dissipation-temperature:heater"), (20, None));
    assert_eq!(of("conductive-path:box:head").1, None);
}
