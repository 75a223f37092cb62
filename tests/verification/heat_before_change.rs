//! Heat that was logged goes before a conductance that follows it where it explains nearly as much: what the sun warms is asked first.

use bmv::diagnosis::Output;
use bmv::math::functions::{pow, sin};
use bmv::random::StreamKey;

use super::small_study;

/// A box with a lamp in the sun, which the model does not use.
const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A box with a lamp",
  "inputs": {"sun": {"unit": "W/m2", "nominal": 0, "range": [0, 1000]}, "air": {"unit": "degC", "nominal": 15, "range": [0, 40]}},
  "parameters": {
    "G": {"unit": "W/K", "nominal": 0.5, "prior": {"lognormal": {"median": 0.5, "factor": 2}}, "source": "assumed"},
    "Q": {"unit": "W", "nominal": 1, "prior": {"uniform": [0.01, 50]}, "source": "assumed"}
  },
  "nodes": {"outside": {"boundary": "air"}, "box": {"capacity": 4000}},
  "conductors": {"walls": {"between": ["box", "outside"], "conductance": "G"}},
  "loads": {"lamp": {"into": "box", "power": "Q"}}
}"#;
const NOISE_K: f64 = 0.05;
const DAY_S: f64 = 86_400.0;
const TURN: f64 = 2.0 * std::f64::consts::PI;
const BY_SUN: &str = "input-proportional-load:box:sun";
const WALLS_BY_SUN: &str = "input-dependent-conductance:walls:sun";

/// The diagnosis of five days, of which the last is held out. The heat goes as a power of the sun, as behind a glass that darkens, and an
/// unlogged wind moves the loss.
fn diagnosed(exponent: f64, wind: f64) -> Output {
    let mut stream = StreamKey::new(7, "heat before change", "noise").stream(0);
    let mut table = String::from("time [s],sun [W/m2],air [degC],box [degC]\n");
    let mut own = 17.0_f64;
    for minute in 0..5 * 1440_usize {
        let time_s = 60.0 * minute as f64;
        let days = time_s / DAY_S;
        let cloud = 0.65 + 0.35 * sin(TURN * days / 0.31) * sin(TURN * days / 1.9);
        let sun = 900.0 * sin(TURN * (days - 0.25)).max(0.0) * cloud;
        let air = 15.0 + 5.0 * sin(TURN * (days - 0.4)) + 2.0 * sin(TURN * days / 2.7);
        if minute.is_multiple_of(20) {
            table.push_str(&format!("{time_s},{sun:.1},{air:.2},{:.3}\n", own + NOISE_K * stream.normal()));
        }
        // By hand, in steps of a minute of a time constant of two hours.
        let heat = 1.0 + 3.6 * pow(sun / 900.0, exponent);
        let loss = 0.5 * (1.0 + wind * sin(TURN * days / 0.83)) * (own - air);
        own += 60.0 * (heat - loss) / 4000.0;
    }
    let pass = r#"{"format": "bmv-pass/1", "title": "A box with a lamp", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {"days": {"transient": {"file": "data.csv",
            "initial": {"temperatures": {"all": {"value": 17, "unit": "degC"}}},
            "sensors": {"box": {"measures": "box", "sigma": {"prior": {"lognormal": {"median": 0.1, "factor": 4}}, "unit": "K"}}},
            "held_out": {"intervals": [{"from": {"value": 345600, "unit": "s"}}]}}}},
        "jobs": {"missing": {"diagnose": {"effects": ["input-proportional-load", "input-dependent-conductance"]}}}}"#;
    let folder = tempfile::tempdir().unwrap();
    let files = [("model.json", MODEL), ("data.csv", table.as_str()), ("pass-1.json", pass)];
    small_study::diagnosed(&small_study::loaded(folder.path(), &files))
}

/// Probabilities of the sets of the conductance and of the heat alone.
fn alone(output: &Output) -> [f64; 2] {
    [WALLS_BY_SUN, BY_SUN]
        .map(|id| output.models.iter().find(|model| model.effects == [id]).expect("a set of one effect").probability)
}

/// What the heat explains of what the conductance does, in squares of the errors of the fitted and of the unseen rows.
fn shares_of_heat(output: &Output) -> [f64; 2] {
    let errors = |ids: &[&str]| {
        let model = output.models.iter().find(|model| model.effects == ids).expect("a set of these effects");
        [model.rmse_k.train, model.rmse_k.held_out].map(|error| error.expect("an error"))
    };
    let [nothing, heat, walls] = [errors(&[]), errors(&[BY_SUN]), errors(&[WALLS_BY_SUN])];
    [0, 1].map(|rows| {
        let explained = |errors: [f64; 2]| nothing[rows] * nothing[rows] - errors[rows] * errors[rows];
        explained(heat) / explained(walls)
    })
}

#[test]
fn logged_heat_goes_before_a_conductance_that_follows_it_and_explains_little_more() {
    let output = diagnosed(0.45, 0.05);
    let shares = shares_of_heat(&output);
    assert!(shares.iter().all(|share| (0.9..1.0).contains(share)), "{shares:?}");
    let [walls, heat] = alone(&output);
    assert!(walls > 1.2 * heat, "{walls} {heat}");
    assert_eq!(output.selected[0], BY_SUN, "{:?}", output.words);
}

#[test]
fn a_conductance_that_explains_far_more_than_the_heat_it_follows_goes_first() {
    let output = diagnosed(0.3, 0.15);
    let shares = shares_of_heat(&output);
    assert!(shares.iter().any(|share| *share < 0.9), "{shares:?}");
    assert_eq!(output.selected[0], WALLS_BY_SUN, "{:?}", output.words);
}
