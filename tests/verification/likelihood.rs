//! The likelihood against references made apart, and its gradient against differences.

use bmv::expression::Symbol;
use bmv::inference::estimate::point_estimate::{self, PointSettings};
use bmv::inference::likelihood::{Definition, InputError, Likelihood, LikelihoodError};
use bmv::inference::target::{LeastSquares, Target};
use bmv::measurement::{Initial, InputColumn, InputTable, Measurement, Rows, Uncertain};
use bmv::random::{Distribution, StreamKey};
use bmv::thermal::{InitialState, Model, Network, TransientRequest};

use super::build::Build;
use super::network8_data::{SIGMA_K, TRUTH, likelihood, measurement, model, priors, sensor};

const HALF_LN_TAU: f64 = 0.918_938_533_204_672_7;

/// Gradient against central differences with one relative step, to a share of each component's own scale.
fn check_gradient(target: &Likelihood, at: &[f64], step: f64, tolerance: f64) {
    let mut memory = target.workspace();
    let mut gradient = vec![0.0; at.len()];
    let value = target.log_likelihood_gradient(at, &mut memory, &mut gradient).expect("evaluates");
    assert_eq!(target.log_likelihood(at, &mut memory), Ok(value), "with and without gradient");
    for i in 0..at.len() {
        let step = step * at[i].abs().max(1e-2);
        let mut value = |by: f64| {
            let mut point = at.to_vec();
            point[i] += by;
            target.log_likelihood(&point, &mut memory).expect("evaluates")
        };
        let difference = (value(step) - value(-step)) / (2.0 * step);
        let size = gradient[i].abs().max(1.0 / at[i].abs().max(1e-2));
        let name = &target.names()[i];
        assert!((difference - gradient[i]).abs() < tolerance * size, "{name}: {difference} {}", gradient[i]);
    }
}

#[test]
fn network8_has_the_reference_likelihood_and_gradient() {
    let target = likelihood();
    let mut memory = target.workspace();
    let mut gradient = [0.0; 4];
    let value = target.log_likelihood_gradient(&TRUTH, &mut memory, &mut gradient).unwrap();
    let constant = 215.0 * (HALF_LN_TAU + libm::log(SIGMA_K));
    // The reference solves to 1e-9 K and prints ten digits.
    assert!((value + constant + 123.648_294_7).abs() < 1e-6, "{}", value + constant);
    for (own, reference) in gradient.iter().zip([25.607_920_06, 1_222.603_83, 4_728.700_076, 1_512.330_728]) {
        assert!((own / reference - 1.0).abs() < 1e-6, "{own} {reference}");
    }
    check_gradient(&target, &[4.5, 0.8, 0.04, 0.2], 1e-5, 1e-5);
}

#[test]
fn an_evaluation_depends_on_its_arguments_only() {
    let target = likelihood();
    let mut memory = target.workspace();
    let far = target.log_likelihood(&[1.2, 0.72, 0.07, 0.3], &mut memory);
    let first = target.log_likelihood(&TRUTH, &mut memory);
    assert_eq!(first, target.log_likelihood(&TRUTH, &mut target.workspace()));
    assert_eq!(far, target.log_likelihood(&[1.2, 0.72, 0.07, 0.3], &mut memory));
}

#[test]
fn network8_has_the_reference_estimate() {
    let target = likelihood();
    let key = StreamKey::new(1, "network8", "estimate");
    let estimate = point_estimate::estimate(&target, &PointSettings::default(), &key, &[]).unwrap();
    assert!((estimate.chi_square - 235.5621).abs() < 1e-4, "{}", estimate.chi_square);
    let map = [4.037_043_3, 0.854_974_54, 0.029_918_138, 0.153_392_09];
    let sd = [0.044_035_38, 0.001_621_17, 0.000_123_4, 0.001_081_15];
    for i in 0..4 {
        assert!((estimate.parameters[i] - map[i]).abs() < 1e-4 * sd[i], "{i}: {}", estimate.parameters[i]);
        // The reference's Jacobian is by differences of relative step 1e-5 and printed to four digits.
        assert!((estimate.sd()[i] / sd[i] - 1.0).abs() < 1e-3, "{i}: {}", estimate.sd()[i]);
    }
    let evidence = estimate.log_evidence.unwrap();
    assert!((evidence + 185.6205).abs() < 1e-3, "{evidence}");
}

#[test]
fn readings_held_out_ignored_or_missing_change_nothing() {
    let model = model();
    let changed = |value: f64| {
        let mut measurement = measurement(&model);
        let Rows::Steady(phases) = &mut measurement.rows else { unreachable!() };
        phases[3].held_out = true;
        phases[7].ignored = Some("not stabilised".into());
        for row in [3, 7] {
            for sensor in 0..5 {
                measurement.readings[row * 5 + sensor] = Some(value);
            }
        }
        measurement.readings[2] = None;
        Likelihood::new(&Definition {
            model: &model,
            priors: &priors(),
            parameters: &[0, 1, 2, 3],
            measurements: &[&measurement],
            input_errors: &[],
        })
        .unwrap()
    };
    let (a, b) = (changed(300.0), changed(-1e9));
    assert_eq!(a.residual_count(), 215 - 10 - 1);
    let (mut ga, mut gb) = ([0.0; 4], [0.0; 4]);
    let la = a.log_likelihood_gradient(&TRUTH, &mut a.workspace(), &mut ga);
    assert_eq!(la, b.log_likelihood_gradient(&TRUTH, &mut b.workspace(), &mut gb));
    assert_eq!(ga, gb);
}

/// Two heaters with inputs that hold, sensors that lag, are biased and correlated, and fitted start temperatures.
fn bench() -> (Model, Vec<Measurement>) {
    let mut b = Build::default();
    let g = b.parameter("G", 0.02);
    let c = b.parameter("C", 20.0);
    let power = b.input("P", 0.0);
    let room = b.input("T_room", 295.0);
    b.diffusion_of("a", c);
    b.diffusion("b", 30.0);
    let room = b.boundary("room", room);
    b.conductor("ar", [0, room], g);
    b.conductor("br", [1, room], g);
    let link = b.n(0.01);
    b.conductor("ab", [0, 1], link);
    b.load("heater", 0, power);
    for node in 0..2 {
        let value = b.graph().symbol(Symbol::Node(node));
        b.quantity(&format!("T{node}"), value);
    }
    let times_s: Vec<f64> = (0..80).map(|i| f64::from(i) * 5.0 + if i % 7 == 3 { 1.3 } else { 0.0 }).collect();
    let values: Vec<f64> = (0..80).map(|i| if i < 40 { 0.6 } else { 0.1 }).collect();
    let inputs = InputTable {
        times_s: times_s.clone(),
        columns: vec![InputColumn { input: 0, values, hold: true }],
        base: vec![0.0, 295.0],
    };
    let network = Network::compile(&b.model, &[]).unwrap();
    let request =
        TransientRequest::new(&[0.021, 21.0], &inputs, InitialState::Temperatures(&[294.0, 294.0, 0.0]), &times_s);
    let solution = network.solve_transient(&request).unwrap();
    let readings =
        (0..160).map(|k| (k % 11 != 5).then(|| solution.quantities[k] + 0.2 * libm::sin(k as f64 * 1.7))).collect();
    let inferred = |lower: f64, upper: f64| Uncertain::Inferred(Distribution::LogUniform { lower, upper });
    let uniform = |lower: f64, upper: f64| Uncertain::Inferred(Distribution::Uniform { lower, upper });
    let mut one = sensor("one", 0, inferred(0.01, 5.0));
    one.correlation_time_s = Some(inferred(1.0, 300.0));
    one.lag_s = Some(uniform(0.0, 60.0));
    let mut two = sensor("two", 1, inferred(0.01, 5.0));
    two.correlation_time_s = Some(inferred(1.0, 300.0));
    two.white = Some(inferred(0.01, 5.0));
    two.bias = Some(uniform(-2.0, 2.0));
    let start = uniform(280.0, 310.0);
    let transient = Measurement {
        name: "bench".into(),
        rows: Rows::Transient {
            inputs,
            initial: Initial::Temperatures {
                values: vec![start.clone(), start.clone(), start],
                shared: vec![0, 1, 2],
                balanced: vec![],
            },
            held_out: (0..80).map(|i| i >= 60).collect(),
            ignored: (0..80).map(|i| (i == 20).then(|| "a draught".to_owned())).collect(),
        },
        sensors: vec![one, two],
        readings,
        file: String::new(),
        sha256: String::new(),
        unused_columns: vec![],
        time_zero_s: None,
        follows_gap: false,
        doubts: vec![],
    };
    let phase = |name: &str, power: f64| bmv::measurement::Phase {
        name: name.into(),
        inputs: vec![power, 295.0],
        held_out: false,
        ignored: None,
        stabilisation: None,
    };
    let steady = Measurement {
        name: "steady".into(),
        rows: Rows::Steady(vec![phase("low", 0.1), phase("high", 0.5)]),
        sensors: vec![sensor("one", 0, inferred(0.01, 5.0)), sensor("two", 1, Uncertain::Known(0.3))],
        readings: vec![Some(298.9), Some(296.4), Some(314.0), None],
        file: String::new(),
        sha256: String::new(),
        unused_columns: vec![],
        time_zero_s: None,
        follows_gap: false,
        doubts: vec![],
    };
    (b.model, vec![transient, steady])
}

fn bench_likelihood(model: &Model, measurements: &[Measurement]) -> Likelihood {
    let uniform = |lower: f64, upper: f64| Distribution::Uniform { lower, upper };
    let errors =
        [InputError { sigma: Some(0.02), bias: None }, InputError { sigma: Some(0.4), bias: Some(uniform(-1.0, 1.0)) }];
    let measurements: Vec<&Measurement> = measurements.iter().collect();
    Likelihood::new(&Definition {
        model,
        priors: &[uniform(0.01, 0.05), uniform(5.0, 60.0)],
        parameters: &[0, 1],
        measurements: &measurements,
        input_errors: &errors,
    })
    .unwrap()
}

#[test]
fn all_that_can_be_inferred_of_data_has_a_name_and_an_exact_gradient() {
    let (model, measurements) = bench();
    let target = bench_likelihood(&model, &measurements);
    let names = [
        "G",
        "C",
        "bench.one.sigma",
        "bench.one.correlation_time",
        "bench.one.lag",
        "bench.two.sigma",
        "bench.two.white",
        "bench.two.bias",
        "bench.two.correlation_time",
        "bench.start.all",
        "steady.one.sigma",
        "T_room.bias",
    ];
    assert_eq!(target.names(), names);
    // The steps of the integration are fixed for derivatives, so that differences agree to its error control only.
    let at = [0.022, 20.0, 0.3, 20.0, 8.0, 0.2, 0.15, 0.3, 30.0, 293.0, 0.4, 0.25];
    check_gradient(&target, &at, 1e-4, 2e-3);
}

/// The value at a clock that is behind by so much, with all rows and with those that are used.
fn with_clock(behind_s: f64) -> [f64; 2] {
    let (model, mut measurements) = bench();
    measurements[0].sensors[0].behind_s = vec![Uncertain::Known(behind_s)];
    let at = [0.022, 20.0, 0.3, 20.0, 8.0, 0.2, 0.15, 0.3, 30.0, 293.0, 0.4, 0.25];
    let whole = bench_likelihood(&model, &measurements);
    let used = 60;
    let Rows::Transient { inputs, held_out, ignored, .. } = &mut measurements[0].rows else { panic!("a transient") };
    inputs.times_s.truncate(used);
    inputs.columns.iter_mut().for_each(|column| column.values.truncate(used));
    held_out.truncate(used);
    ignored.truncate(used);
    measurements[0].readings.truncate(2 * used);
    let cut = bench_likelihood(&model, &measurements);
    [&whole, &cut].map(|target| target.log_likelihood(&at, &mut target.workspace()).unwrap())
}

#[test]
fn a_clock_that_is_behind_shows_rows_beyond_the_last_that_is_used() {
    for behind_s in [-23.1, 0.0] {
        let [whole, cut] = with_clock(behind_s);
        assert!((whole - cut).abs() < 1e-4, "{behind_s}: {whole} {cut}");
    }
    let [whole, cut] = with_clock(23.1);
    assert!((whole - cut).abs() > 0.01, "{whole} {cut}");
}

/// Its derivative is exact where it meets no row.
#[test]
fn the_time_of_a_clock_has_an_exact_gradient() {
    let (model, mut measurements) = bench();
    let uniform = |lower: f64, upper: f64| Uncertain::Inferred(Distribution::Uniform { lower, upper });
    measurements[0].sensors[0].behind_s = vec![uniform(-60.0, 60.0)];
    let target = bench_likelihood(&model, &measurements);
    assert_eq!(target.names()[5], "bench.one.clock_behind");
    for behind_s in [-17.3, 0.4, 23.1] {
        let at = [0.022, 20.0, 0.3, 20.0, 8.0, behind_s, 0.2, 0.15, 0.3, 30.0, 293.0, 0.4, 0.25];
        check_gradient(&target, &at, 1e-4, 2e-3);
    }
}

#[test]
fn a_lag_that_is_a_parameter_of_the_model_is_the_lag_of_its_sensor() {
    let (model, measurements) = bench();
    let own = bench_likelihood(&model, &measurements);
    // The same lag as an adopted effect brings it: a parameter of the model that the sensor refers to.
    let (mut model, mut measurements) = (model, measurements);
    let mut lag = model.parameters[0].clone();
    (lag.name, lag.nominal) = ("slow.time_constant".into(), 8.0);
    model.parameters.push(lag);
    measurements[0].sensors[0].lag_s = Some(Uncertain::Parameter { index: 2, nominal: 8.0 });
    let uniform = |lower: f64, upper: f64| Distribution::Uniform { lower, upper };
    let errors =
        [InputError { sigma: Some(0.02), bias: None }, InputError { sigma: Some(0.4), bias: Some(uniform(-1.0, 1.0)) }];
    let borrowed: Vec<&Measurement> = measurements.iter().collect();
    let adopted = |parameters: &[usize]| {
        Likelihood::new(&Definition {
            model: &model,
            priors: &[uniform(0.01, 0.05), uniform(5.0, 60.0), uniform(0.0, 60.0)],
            parameters,
            measurements: &borrowed,
            input_errors: &errors,
        })
        .unwrap()
    };
    let at_own = [0.022, 20.0, 0.3, 20.0, 8.0, 0.2, 0.15, 0.3, 30.0, 293.0, 0.4, 0.25];
    let at_fitted = [0.022, 20.0, 8.0, 0.3, 20.0, 0.2, 0.15, 0.3, 30.0, 293.0, 0.4, 0.25];
    let at_held = [0.022, 20.0, 0.3, 20.0, 0.2, 0.15, 0.3, 30.0, 293.0, 0.4, 0.25];
    let expected = own.log_likelihood(&at_own, &mut own.workspace()).unwrap();
    let (fitted, held) = (adopted(&[0, 1, 2]), adopted(&[0, 1]));
    assert_eq!(fitted.log_likelihood(&at_fitted, &mut fitted.workspace()), Ok(expected));
    assert_eq!(held.log_likelihood(&at_held, &mut held.workspace()), Ok(expected));
    let (mut slopes_own, mut slopes_fitted) = ([0.0; 12], [0.0; 12]);
    own.log_likelihood_gradient(&at_own, &mut own.workspace(), &mut slopes_own).unwrap();
    fitted.log_likelihood_gradient(&at_fitted, &mut fitted.workspace(), &mut slopes_fitted).unwrap();
    assert!(slopes_own[4].abs() > 1e-3 && (slopes_own[4] - slopes_fitted[2]).abs() < 1e-9 * slopes_own[4].abs());
}

#[test]
fn changing_held_out_rows_of_a_transient_changes_nothing() {
    let (model, mut measurements) = bench();
    let before = bench_likelihood(&model, &measurements);
    for row in (60..80).chain([20]) {
        measurements[0].readings[2 * row] = Some(-1e6);
        measurements[0].readings[2 * row + 1] = None;
    }
    let after = bench_likelihood(&model, &measurements);
    let at = [0.022, 20.0, 0.3, 20.0, 8.0, 0.2, 0.15, 0.3, 30.0, 293.0, 0.4, 0.25];
    let (mut a, mut b) = (vec![0.0; 12], vec![0.0; 12]);
    let value = before.log_likelihood_gradient(&at, &mut before.workspace(), &mut a);
    assert_eq!(value, after.log_likelihood_gradient(&at, &mut after.workspace(), &mut b));
    assert_eq!(a, b);
}

#[test]
fn input_errors_enter_the_covariance_of_a_phase() {
    // One node between a plate and a heater: T = T_room + P / (2 g), readings twice of the same node.
    let mut b = Build::default();
    let g = b.parameter("G", 0.5);
    let power = b.input("P", 1.0);
    let room = b.input("T_room", 290.0);
    b.diffusion("a", 1.0);
    let room = b.boundary("room", room);
    b.conductor("ar", [0, room], g);
    b.load("heater", 0, power);
    let value = b.graph().symbol(Symbol::Node(0));
    b.quantity("T", value);
    let measurement = Measurement {
        name: "m".into(),
        rows: Rows::Steady(vec![bmv::measurement::Phase {
            name: "p".into(),
            inputs: vec![1.0, 290.0],
            held_out: false,
            ignored: None,
            stabilisation: None,
        }]),
        sensors: vec![sensor("x", 0, Uncertain::Known(0.3)), sensor("y", 0, Uncertain::Known(0.4))],
        readings: vec![Some(292.5), Some(291.8)],
        file: String::new(),
        sha256: String::new(),
        unused_columns: vec![],
        time_zero_s: None,
        follows_gap: false,
        doubts: vec![],
    };
    let errors = [InputError { sigma: Some(0.1), bias: None }, InputError { sigma: Some(0.5), bias: None }];
    let target = Likelihood::new(&Definition {
        model: &b.model,
        priors: &[Distribution::Uniform { lower: 0.1, upper: 1.0 }],
        parameters: &[0],
        measurements: &[&measurement],
        input_errors: &errors,
    })
    .unwrap();
    let value = target.log_likelihood(&[0.5], &mut target.workspace()).unwrap();
    // By hand: dT/dP = 2, dT/dT_room = 1, so that both share the variance (2 x 0.1)^2 + 0.5^2 = 0.29.
    let (xx, yy, xy): (f64, f64, f64) = (0.09 + 0.29, 0.16 + 0.29, 0.29);
    let determinant = xx * yy - xy * xy;
    let (dx, dy): (f64, f64) = (0.5, -0.2);
    let square = (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / determinant;
    let expected = -0.5 * square - 0.5 * libm::log(determinant) - 2.0 * HALF_LN_TAU;
    assert!((value - expected).abs() < 1e-9, "{value} {expected}");
}

#[test]
fn what_cannot_be_fitted_is_said() {
    let model = model();
    let build = |change: &dyn Fn(&mut Measurement), parameters: &[usize]| {
        let mut measurement = measurement(&model);
        change(&mut measurement);
        Likelihood::new(&Definition {
            model: &model,
            priors: &priors(),
            parameters,
            measurements: &[&measurement],
            input_errors: &[],
        })
        .err()
    };
    let all = [0, 1, 2, 3];
    assert_eq!(build(&|m| m.readings.fill(None), &all), Some(LikelihoodError::NoData));
    assert_eq!(build(&|_| (), &[]), Some(LikelihoodError::NoUnknowns));
    let error = build(&|m| m.sensors[1].sigma = None, &all).map(|e| e.to_string());
    assert!(error.is_some_and(|e| e.contains("sensor `s2` of `balance test` has no `sigma`")));
    let error = build(&|m| m.sensors[1].sigma = Some(Uncertain::Known(0.0)), &all).map(|e| e.to_string());
    assert!(error.is_some_and(|e| e.contains("is 0, expected a value above 0")));
}

/// Values of unknowns by the last part of their names.
fn values_of(target: &Likelihood) -> Vec<f64> {
    let known = [("G", 0.022), ("C", 20.0), ("correlation_time", 20.0), ("lag", 8.0), ("white", 0.15), ("all", 293.0)];
    let value = |name: &String| {
        let last = name.rsplit('.').next().unwrap();
        known.iter().find(|(own, _)| *own == last).map_or(0.3, |(_, value)| *value)
    };
    target.names().iter().map(value).collect()
}

/// Side by side or one after the other: the bits are those of each transient alone.
#[test]
fn several_long_transients_have_the_likelihood_of_each_alone() {
    let (model, measurements) = bench();
    let copies = 6;
    let all: Vec<Measurement> =
        (0..copies).map(|copy| Measurement { name: format!("bench {copy}"), ..measurements[0].clone() }).collect();
    let together = bench_likelihood(&model, &all);
    assert!(together.residual_count() >= 500, "so many that they are handed over");
    let at = values_of(&together);
    let (mut memory, mut residuals) = (together.workspace(), vec![0.0; together.residual_count()]);
    together.residuals(&at, &mut memory, &mut residuals).unwrap();
    let mut slopes = vec![0.0; at.len()];
    together.log_likelihood_gradient(&at, &mut memory, &mut slopes).unwrap();
    let alone = bench_likelihood(&model, &all[..1]);
    let own_at = values_of(&alone);
    let (mut memory, mut own) = (alone.workspace(), vec![0.0; alone.residual_count()]);
    alone.residuals(&own_at, &mut memory, &mut own).unwrap();
    for part in residuals.chunks_exact(own.len()) {
        assert_eq!(part, own);
    }
    let mut own_slopes = vec![0.0; own_at.len()];
    alone.log_likelihood_gradient(&own_at, &mut memory, &mut own_slopes).unwrap();
    for (all, one) in slopes.iter().zip(&own_slopes).take(2) {
        assert!((all - f64::from(copies) * one).abs() < 1e-9 * all.abs().max(1.0), "{all} {one}");
    }
}
