//! Comparisons of made-up measurements whose statistics follow by hand.

use std::sync::Arc;

use bmv::job::compare::{Compare, Output, Spec};
use bmv::measurement::{Initial, InputColumn, InputTable, Measurement, Phase, Rows, Sensor, Uncertain};
use bmv::study::profile::Criteria;
use bmv::thermal::Model;

use super::build::Build;
use crate::serial;

fn criteria() -> Criteria {
    Criteria {
        name: "own".into(),
        title: "Own".into(),
        each_k: Some(2.0),
        mean_k: Some(1.0),
        sd_k: None,
        share: None,
        stabilisation_k_per_s: None,
        source: String::new(),
    }
}

fn sensor(name: &str, quantity: usize, sigma: f64) -> Sensor {
    Sensor {
        name: name.into(),
        quantity,
        unit: "K".into(),
        sigma: Some(Uncertain::Known(sigma)),
        bias: None,
        lag_s: None,
        behind_s: Vec::new(),
        correlation_time_s: None,
        white: None,
    }
}

fn measurement(rows: Rows, sensors: Vec<Sensor>, readings: Vec<Option<f64>>) -> Measurement {
    Measurement {
        name: "test".into(),
        rows,
        sensors,
        readings,
        file: String::new(),
        sha256: String::new(),
        unused_columns: Vec::new(),
        time_zero_s: None,
        follows_gap: false,
        doubts: vec![],
    }
}

fn phase(name: &str, held_out: bool) -> Phase {
    Phase { name: name.into(), inputs: Vec::new(), held_out, ignored: None, stabilisation: None }
}

fn compare(model: Model, measurement: Measurement) -> Output {
    let spec = Spec { data: vec![0], criteria: criteria(), from: "nominal".into(), calibration: None };
    let parameters = model.parameters.iter().map(|p| p.nominal).collect();
    let job = Compare::new(spec, Arc::new(model), Arc::new(vec![measurement]), parameters).unwrap();
    serde_json::from_value(serial::run(&job).unwrap()).unwrap()
}

/// 1 W through 0.5 W/K to 290 K: 292 K, 1 W into the boundary.
fn plate() -> Build {
    let mut b = Build::default();
    let sink = b.n(290.0);
    let plate = b.diffusion("plate", 1000.0);
    let sink = b.boundary("sink", sink);
    let (conductance, power) = (b.n(0.5), b.n(1.0));
    b.conductor("link", [plate, sink], conductance);
    b.load("heater", plate, power);
    b.temperature("plate", plate);
    b.model.quantities[0].unit = "K".into();
    b
}

#[test]
fn kelvins_and_amperes_are_not_averaged() {
    let mut b = plate();
    let current = b.n(0.1);
    b.quantity("current", current);
    b.model.quantities[1].unit = "A".into();
    // The plate is 3 K above its prediction in both phases, the current right: every temperature breaks the 2 K.
    let rows = Rows::Steady(vec![phase("P1", false), phase("P2", false)]);
    let readings = vec![Some(295.0), Some(0.1), Some(295.0), Some(0.1)];
    let sensors = vec![sensor("T", 0, 1.0), sensor("I", 1, 1.0)];
    let output = compare(b.model, measurement(rows, sensors, readings));
    assert_eq!(output.train.count, 2);
    assert!((output.train.mean - 3.0).abs() < 1e-9 && (output.train.rmse - 3.0).abs() < 1e-9, "{:?}", output.train);
    assert_eq!(output.train.within_limit, 0.0);
    assert!((output.phases[0].deviation.mean - 3.0).abs() < 1e-9, "{:?}", output.phases[0]);
    assert!(output.verdicts.iter().all(|verdict| !verdict.kept), "{:?}", output.verdicts);
}

#[test]
fn few_rows_held_out_are_judged_by_the_scatter_of_few() {
    // Noise of 1 K. Forty rows at +-1 K (RMSE 1) and one held out at 2 K: one reading in twenty-two lies as far, its
    // 97.5 % bound is sqrt(5.0239) = 2.24 K, that of 41 readings 1.22 K.
    let phases = (0..41).map(|i| phase(&format!("P{i}"), i == 40)).collect();
    let readings = (0..41).map(|i| Some(292.0 + [1.0, -1.0, 2.0][if i == 40 { 2 } else { i % 2 }])).collect();
    let output = compare(plate().model, measurement(Rows::Steady(phases), vec![sensor("T", 0, 1.0)], readings));
    assert!((output.held_out.rmse - 2.0).abs() < 1e-9);
    assert!(output.fails.is_empty(), "{:?}", output.fails);
}

#[test]
fn the_heat_of_a_stretch_ends_before_the_step_that_ends_it() {
    // The sink stands at 300 K as the plate does, and is held at 350 K from 100 s on: no heat before; after it
    // T = 350 - 50 exp(-(t - 100) / 1000), and what is stored is C times the rise.
    let mut b = Build::default();
    let sink = b.input("T_sink", 300.0);
    let plate = b.diffusion("plate", 1000.0);
    let sink = b.boundary("sink", sink);
    let conductance = b.n(1.0);
    b.conductor("link", [plate, sink], conductance);
    b.temperature("plate", plate);
    b.model.quantities[0].unit = "K".into();
    let times_s: Vec<f64> = (0..=20).map(|i| 10.0 * f64::from(i)).collect();
    let values: Vec<f64> = times_s.iter().map(|&t| if t < 100.0 { 300.0 } else { 350.0 }).collect();
    let rows = Rows::Transient {
        held_out: vec![false; times_s.len()],
        ignored: vec![None; times_s.len()],
        initial: Initial::Temperatures {
            values: vec![Uncertain::Known(300.0); 2],
            shared: Vec::new(),
            balanced: Vec::new(),
        },
        inputs: InputTable { times_s, columns: vec![InputColumn { input: 0, values, hold: true }], base: vec![300.0] },
    };
    let output = compare(b.model, measurement(rows, vec![sensor("T", 0, 1.0)], vec![Some(300.0); 21]));
    let [before, after] = &output.heat[..] else { panic!("{:?}", output.heat) };
    assert!(before.into_boundaries_w[0].1.abs() < 1e-9 && before.stored_w.abs() < 1e-9, "{before:?}");
    assert!(before.imbalance_w.abs() < 1e-9, "{before:?}");
    let rise = 50.0 * (1.0 - libm::exp(-0.1));
    assert!((after.stored_w - 1000.0 * rise / 100.0).abs() < 1e-2, "{after:?}");
    // Straight lines between rows of 10 s miss the curve by (10 / 1000)^2 / 12 of the heat.
    assert!((after.into_boundaries_w[0].1 + 1000.0 * rise / 100.0).abs() < 1e-2, "{after:?}");
    assert!(after.imbalance_w.abs() < 2e-2, "{after:?}");
}
