//! Heat that was logged goes before a conductance that follows it where it explains nearly as much: whether the sun warms something is asked
//! first. Heat that cools is none, as with a fan whose power was logged.

use bmv::diagnosis::Output;
use bmv::math::functions::{ln, pow, sin};
use bmv::random::StreamKey;

use super::small_study;

/// A box with a lamp, and an input that the model does not use.
const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A box with a lamp",
  "inputs": {"driver": {"unit": "UNIT", "nominal": 0, "range": [0, 1000]}, "air": {"unit": "degC", "nominal": 15, "range": [0, 40]}},
  "parameters": {
    "G": {"unit": "W/K", "nominal": 0.5, "prior": {"lognormal": {"median": 0.5, "factor": 2}}, "source": "assumed"},
    "Q": {"unit": "W", "nominal": 5, "prior": {"uniform": [0.01, 50]}, "source": "assumed"}
  },
  "nodes": {"outside": {"boundary": "air"}, "box": {"capacity": 4000}},
  "conductors": {"walls": {"between": ["box", "outside"], "conductance": "G"}},
  "loads": {"lamp": {"into": "box", "power": "Q"}}
}"#;
const NOISE_K: f64 = 0.05;
const DAY_S: f64 = 86_400.0;
const TURN: f64 = 2.0 * std::f64::consts::PI;
const HEAT: &str = "input-proportional-load:box:driver";
const WALLS: &str = "input-dependent-conductance:walls:driver";

/// What happens to the box.
struct Truth {
    unit: &'static str,
    /// Driver by days.
    driver: fn(f64) -> f64,
    /// Swing of the air over a day, K.
    air_k: f64,
    /// Heat, W, with the driver as a share of its largest value.
    heat: fn(f64) -> f64,
    /// Conductance of the walls, W/K, by the same.
    conductance: fn(f64) -> f64,
    /// Largest driver.
    most: f64,
}

impl Truth {
    /// The diagnosis of five days, of which the last is held out. An unlogged wind moves the loss.
    fn diagnosed(&self, wind: f64) -> Output {
        let mut stream = StreamKey::new(7, "heat before change", "noise").stream(0);
        let unit = self.unit;
        let mut table = format!("time [s],driver [{unit}],air [degC],box [degC]\n");
        let start = 15.0 + (self.heat)(0.0) / (self.conductance)(0.0);
        let mut own = start;
        for minute in 0..5 * 1440_usize {
            let time_s = 60.0 * minute as f64;
            let days = time_s / DAY_S;
            let driver = (self.driver)(days);
            let air = 15.0 + self.air_k * (sin(TURN * (days - 0.4)) + 0.4 * sin(TURN * days / 2.7));
            if minute.is_multiple_of(20) {
                table.push_str(&format!("{time_s},{driver:.2},{air:.2},{:.3}\n", own + NOISE_K * stream.normal()));
            }
            // By hand, in steps of a minute of a time constant of one to two hours.
            let share = driver / self.most;
            let loss = (self.conductance)(share) * (1.0 + wind * sin(TURN * days / 0.83)) * (own - air);
            own += 60.0 * ((self.heat)(share) - loss) / 4000.0;
        }
        let pass = r#"{"format": "bmv-pass/1", "title": "A box with a lamp", "parent": null, "model": "model.json", "seed": 3,
            "measurements": {"days": {"transient": {"file": "data.csv",
                "initial": {"temperatures": {"all": {"value": START, "unit": "degC"}}},
                "sensors": {"box": {"measures": "box", "sigma": {"prior": {"lognormal": {"median": 0.1, "factor": 4}}, "unit": "K"}}},
                "held_out": {"intervals": [{"from": {"value": 345600, "unit": "s"}}]}}}},
            "jobs": {"missing": {"diagnose": {"effects": ["input-proportional-load", "input-dependent-conductance"]}}}}"#;
        let (model, pass) = (MODEL.replace("UNIT", unit), pass.replace("START", &start.to_string()));
        let folder = tempfile::tempdir().unwrap();
        let files = [("model.json", model.as_str()), ("data.csv", table.as_str()), ("pass-1.json", pass.as_str())];
        small_study::diagnosed(&small_study::loaded(folder.path(), &files))
    }
}

/// A sun among clouds, W/m2.
fn sun(days: f64) -> f64 {
    let cloud = 0.65 + 0.35 * sin(TURN * days / 0.31) * sin(TURN * days / 1.9);
    900.0 * sin(TURN * (days - 0.25)).max(0.0) * cloud
}

/// Heat of the sun behind a glass that darkens as it gets brighter.
fn in_the_sun(heat: fn(f64) -> f64) -> Truth {
    Truth { unit: "W/m2", driver: sun, air_k: 5.0, heat, conductance: |_| 0.5, most: 900.0 }
}

/// Log odds of the conductance over the heat, each alone.
fn lead_of_conductance(output: &Output) -> f64 {
    let of = |id: &str| {
        let own = output.models.iter().find(|model| model.effects == [id]).expect("a set of one effect");
        ln(own.probability)
    };
    of(WALLS) - of(HEAT)
}

/// What the heat explains of what the conductance does, in squares of the errors of the fitted and of the unseen rows.
fn shares_of_heat(output: &Output) -> [f64; 2] {
    let errors = |ids: &[&str]| {
        let model = output.models.iter().find(|model| model.effects == ids).expect("a set of these effects");
        [model.rmse_k.train, model.rmse_k.held_out].map(|error| error.expect("an error"))
    };
    let [nothing, heat, walls] = [errors(&[]), errors(&[HEAT]), errors(&[WALLS])];
    [0, 1].map(|rows| {
        let explained = |errors: [f64; 2]| nothing[rows] * nothing[rows] - errors[rows] * errors[rows];
        explained(heat) / explained(walls)
    })
}

#[test]
fn logged_heat_goes_before_a_conductance_that_follows_it_and_explains_little_more() {
    let output = in_the_sun(|sun| 1.0 + 3.6 * pow(sun, 0.42)).diagnosed(0.05);
    let shares = shares_of_heat(&output);
    assert!(shares.iter().all(|share| (0.9..1.0).contains(share)), "{shares:?}");
    assert!(lead_of_conductance(&output) > 1.5, "{}", lead_of_conductance(&output));
    assert_eq!(output.selected[0], HEAT, "{:?}", output.words);
}

/// The truth is heat here too, but so far from proportional that readings which want the conductance are believed.
#[test]
fn a_conductance_that_explains_far_more_than_the_heat_it_follows_goes_first() {
    let output = in_the_sun(|sun| 1.0 + 3.6 * pow(sun, 0.3)).diagnosed(0.15);
    let shares = shares_of_heat(&output);
    assert!(shares.iter().any(|share| *share < 0.9), "{shares:?}");
    assert_eq!(output.selected[0], WALLS, "{:?}", output.words);
}

/// While the air hardly changes, heat that cools explains nearly as much.
#[test]
fn a_conductance_that_follows_the_power_of_a_fan_is_not_displaced_by_heat_that_cools() {
    let fan = |days: f64| {
        let on = 0.5 + 1.5 * sin(TURN * days / 0.37) + sin(TURN * days / 1.3);
        2.0 * on.clamp(0.0, 1.0)
    };
    let truth =
        Truth { unit: "W", driver: fan, air_k: 0.5, heat: |_| 5.0, conductance: |fan| 0.5 * (1.0 + fan), most: 2.0 };
    let output = truth.diagnosed(0.05);
    let shares = shares_of_heat(&output);
    assert!(shares.iter().all(|share| (0.9..1.0).contains(share)), "{shares:?}");
    assert_eq!(output.selected, [WALLS], "{:?}", output.words);
}
