//! Heat that was logged goes before heat that comes every day where it explains nearly as much: what comes every day fits whatever the
//! logged heat is not.

use bmv::diagnosis::Output;
use bmv::math::functions::{exp, ln, sin};
use bmv::random::StreamKey;

use super::small_study;

/// A box in the sun, which the model does not use.
const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A box under the sun",
  "inputs": {"sun": {"unit": "W/m2", "nominal": 0, "range": [0, 1000]}, "air": {"unit": "degC", "nominal": 15, "range": [0, 40]}},
  "parameters": {"G": {"unit": "W/K", "nominal": 0.5, "prior": {"lognormal": {"median": 0.5, "factor": 2}}, "source": "assumed"}},
  "nodes": {"outside": {"boundary": "air"}, "box": {"capacity": 4000}},
  "conductors": {"walls": {"between": ["box", "outside"], "conductance": "G"}}
}"#;
const NOISE_K: f64 = 0.05;
const AREA_M2: f64 = 0.004;
const DAY_S: f64 = 86_400.0;
/// Hours at which a mast begins to shade the pyranometer on each day.
const SHADED_FROM_H: [f64; 5] = [9.0, 14.0, 11.0, 13.0, 10.0];
const TURN: f64 = 2.0 * std::f64::consts::PI;

/// The diagnosis of five days, of which the last is held out. A tree shades the box about noon, a mast the pyranometer for some hours from
/// another one on each day, and an unlogged wind moves the loss by a quarter.
fn diagnosed(shaded_h: f64) -> Output {
    let mut stream = StreamKey::new(7, "heat by clock", "noise").stream(0);
    let mut table = String::from("time [s],sun [W/m2],air [degC],box [degC]\n");
    let mut own = 15.0_f64;
    for minute in 0..5 * 1440_usize {
        let time_s = 60.0 * minute as f64;
        let hour = time_s % DAY_S / 3600.0;
        let clear = 900.0 * sin(TURN * (hour - 6.0) / 24.0).max(0.0);
        let from = SHADED_FROM_H[minute / 1440];
        let sun = if (from..from + shaded_h).contains(&hour) { 0.25 * clear } else { clear };
        let air = 15.0 + 5.0 * sin(TURN * (time_s / DAY_S - 0.4)) + 2.0 * sin(TURN * time_s / (2.7 * DAY_S));
        if minute.is_multiple_of(20) {
            table.push_str(&format!("{time_s},{sun:.1},{air:.2},{:.3}\n", own + NOISE_K * stream.normal()));
        }
        // By hand, in steps of a minute of a time constant of two hours.
        let from_noon = (hour - 12.7) / 1.2;
        let heat = AREA_M2 * clear * (1.0 - 0.35 * exp(-from_noon * from_noon));
        let loss = 0.5 * (1.0 + 0.25 * sin(TURN * time_s / (0.83 * DAY_S))) * (own - air);
        own += 60.0 * (heat - loss) / 4000.0;
    }
    let pass = r#"{"format": "bmv-pass/1", "title": "A box under the sun", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {"days": {"transient": {"file": "data.csv",
            "initial": {"temperatures": {"all": {"value": 15, "unit": "degC"}}},
            "sensors": {"box": {"measures": "box", "sigma": {"prior": {"lognormal": {"median": 0.1, "factor": 4}}, "unit": "K"}}},
            "held_out": {"intervals": [{"from": {"value": 345600, "unit": "s"}}]}}}},
        "jobs": {"missing": {"diagnose": {"effects": ["input-proportional-load", "daily-load", "daily-hours-load"]}}}}"#;
    let folder = tempfile::tempdir().unwrap();
    let files = [("model.json", MODEL), ("data.csv", table.as_str()), ("pass-1.json", pass)];
    small_study::diagnosed(&small_study::loaded(folder.path(), &files))
}

const BY_SUN: &str = "input-proportional-load:box:sun";
const BY_CLOCK: &str = "daily-hours-load:box";

/// Log odds of heat by the clock over heat by the sun, each alone.
fn lead_of_clock(output: &Output) -> f64 {
    let of = |id: &str| {
        let own = output.models.iter().find(|model| model.effects == [id]).expect("a set of one effect");
        ln(own.probability)
    };
    of(BY_CLOCK) - of(BY_SUN)
}

/// What heat by the sun explains of what heat by the clock does, in squares of the errors of the fitted and of the unseen rows.
fn share_of_sun(output: &Output) -> [f64; 2] {
    let errors = |ids: &[&str]| {
        let model = output.models.iter().find(|model| model.effects == ids).expect("a set of these effects");
        [model.rmse_k.train, model.rmse_k.held_out].map(|error| error.expect("an error"))
    };
    let [nothing, by_sun, by_clock] = [errors(&[]), errors(&[BY_SUN]), errors(&[BY_CLOCK])];
    let of = |rows: usize| {
        let explained = |errors: [f64; 2]| nothing[rows] * nothing[rows] - errors[rows] * errors[rows];
        explained(by_sun) / explained(by_clock)
    };
    [of(0), of(1)]
}

#[test]
fn logged_heat_goes_before_heat_by_the_clock_that_explains_little_more() {
    let output = diagnosed(2.0);
    let shares = share_of_sun(&output);
    assert!(shares.iter().all(|share| (0.9..1.0).contains(share)), "{shares:?}");
    assert!(lead_of_clock(&output) > 3.0, "{}", lead_of_clock(&output));
    assert_eq!(output.selected[0], BY_SUN, "{:?}", output.words);
}

#[test]
fn heat_by_the_clock_that_explains_far_more_goes_first() {
    let output = diagnosed(5.0);
    let shares = share_of_sun(&output);
    assert!(shares.iter().all(|share| *share < 0.9), "{shares:?}");
    assert_eq!(output.selected[0], BY_CLOCK, "{:?}", output.words);
}
