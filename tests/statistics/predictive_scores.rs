//! Scores of steady phases against exact ones: a linear network with normal priors has a normal posterior, so that the
//! density of a phase given the others, and of one held out given all, is a normal density that can be written down.

use std::sync::Arc;

use bmv::inference::likelihood::InputError;
use bmv::job::calibrate::{Calibrate, Inputs, Output, Sampler, Spec};
use bmv::measurement::{Measurement, Phase, Rows, Uncertain};
use bmv::random::{Distribution, StreamKey};
use nalgebra::{Matrix2, Vector2};

use crate::verification::build::Build;
use crate::verification::network8_data::sensor;
use crate::verification::radiator::run;

const TO_ROOM_W_PER_K: f64 = 2.0;
const JOINT_W_PER_K: f64 = 0.5;
const SIGMA_K: [f64; 2] = [0.3, 0.5];
const PRIOR_SD_W: f64 = 2.0;
const FITTED: usize = 9;
const HELD_OUT: usize = 3;
const HALF_LN_TAU: f64 = 0.918_938_533_204_672_7;

/// Temperatures of both nodes over the room's, by the loads (box, then lid).
fn design() -> Matrix2<f64> {
    let (room, joint) = (1.0 / TO_ROOM_W_PER_K, 1.0 / JOINT_W_PER_K);
    Matrix2::new(room, room, room, room + joint)
}

/// Log density of a normal distribution.
fn log_normal(deviation: Vector2<f64>, covariance: &Matrix2<f64>) -> f64 {
    let inverse = covariance.try_inverse().expect("invertible");
    -0.5 * (deviation.dot(&(inverse * deviation)) + libm::log(covariance.determinant())) - 2.0 * HALF_LN_TAU
}

/// Log density of each reading pair given the fitted ones but itself.
fn exact(deviations: &[Vector2<f64>], noise: &Matrix2<f64>) -> Vec<f64> {
    let (a, weight) = (design(), noise.try_inverse().expect("invertible"));
    (0..deviations.len())
        .map(|left_out| {
            // Deviations are from the prediction at the prior's mean; the prior adds to the loads a normal about 0.
            let mut precision = Matrix2::identity() / (PRIOR_SD_W * PRIOR_SD_W);
            let mut pull = Vector2::zeros();
            for (_, own) in deviations[..FITTED].iter().enumerate().filter(|(index, _)| *index != left_out) {
                precision += a.transpose() * weight * a;
                pull += a.transpose() * weight * own;
            }
            let covariance = precision.try_inverse().expect("invertible");
            let predicted = a * covariance * a.transpose() + noise;
            log_normal(deviations[left_out] - a * covariance * pull, &predicted)
        })
        .collect()
}

/// Standard error of each log density as a mean over 400 draws of the posterior of all fitted phases: the logarithm of a
/// phase's density scatters over them with the variance `g'Vg + tr((HV)^2) / 2`, `g` its gradient and `H` its curvature, and a
/// log-normal density (or its inverse, for phases left out) has the relative variance `e^s2 - 1`.
fn errors(deviations: &[Vector2<f64>], noise: &Matrix2<f64>) -> Vec<f64> {
    let (a, weight) = (design(), noise.try_inverse().expect("invertible"));
    let curvature = a.transpose() * weight * a;
    let precision = Matrix2::identity() / (PRIOR_SD_W * PRIOR_SD_W) + curvature * FITTED as f64;
    let covariance = precision.try_inverse().expect("invertible");
    let pull: Vector2<f64> = deviations[..FITTED].iter().map(|own| a.transpose() * weight * own).sum();
    let product = curvature * covariance;
    let error = |own: &Vector2<f64>| {
        let gradient = a.transpose() * weight * (own - a * covariance * pull);
        let scatter = gradient.dot(&(covariance * gradient)) + 0.5 * (product * product).trace();
        (libm::expm1(scatter) / 400.0).sqrt()
    };
    deviations.iter().map(error).collect()
}

fn check(input_sigma_k: f64) {
    let mut b = Build::default();
    let loads = ["Q box", "Q lid"].map(|name| b.parameter(name, 10.0));
    let room = b.input("T_room", 290.0);
    b.diffusion("box", 900.0);
    b.diffusion("lid", 400.0);
    let room = b.boundary("room", room);
    let (to_room, joint) = (b.n(TO_ROOM_W_PER_K), b.n(JOINT_W_PER_K));
    b.conductor("to room", [0, room], to_room);
    b.conductor("joint", [0, 1], joint);
    for (node, load) in loads.into_iter().enumerate() {
        b.load(["box", "lid"][node], node, load);
    }
    b.temperature("box", 0);
    b.temperature("lid", 1);

    // Both nodes follow the room one to one.
    let noise = Matrix2::from_diagonal(&Vector2::from(SIGMA_K.map(|sd| sd * sd)))
        + Matrix2::from_element(input_sigma_k * input_sigma_k);
    let root = noise.cholesky().expect("positive definite").l();
    let mut stream = StreamKey::new(17, "predictive scores", "data").stream(0);
    let mut normals = || Vector2::new(stream.normal(), stream.normal());
    let truth = design() * (PRIOR_SD_W * normals());
    let deviations: Vec<Vector2<f64>> = (0..FITTED + HELD_OUT).map(|_| truth + root * normals()).collect();
    let (mut phases, mut readings) = (Vec::new(), Vec::new());
    for (row, own) in deviations.iter().enumerate() {
        let room_k = 280.0 + row as f64;
        let predicted = Vector2::from_element(room_k) + design() * Vector2::from_element(10.0) + own;
        readings.extend(predicted.iter().copied().map(Some));
        let (name, held_out) = (format!("P{row}"), row >= FITTED);
        phases.push(Phase { name, inputs: vec![room_k], held_out, ignored: None, stabilisation: None });
    }
    let sensors = (["box", "lid"].iter().enumerate())
        .map(|(place, name)| sensor(name, place, Uncertain::Known(SIGMA_K[place])))
        .collect();
    let measurement = Measurement {
        name: "test".into(),
        rows: Rows::Steady(phases),
        sensors,
        readings,
        file: "data.csv".into(),
        sha256: String::new(),
        unused_columns: vec![],
        time_zero_s: None,
        follows_gap: false,
        doubts: vec![],
    };
    let prior = Distribution::Normal { mean: 10.0, sd: PRIOR_SD_W, lower: None, upper: None };
    let sampler = Sampler::Nuts;
    let spec =
        Spec { data: vec![0], parameters: vec![0, 1], sampler, chains: 4, warmup: 300, draws: 500, acceptance: None };
    let inputs = Inputs {
        model: Arc::new(b.model),
        priors: vec![prior; 2],
        measurements: Arc::new(vec![measurement]),
        input_errors: vec![InputError { sigma: Some(input_sigma_k).filter(|sigma| *sigma > 0.0), bias: None }],
    };
    let output: Output = run(&Calibrate::new(spec, inputs, 5, "tuned").expect("a job"));

    let (exact, errors) = (exact(&deviations, &noise), errors(&deviations, &noise));
    assert_eq!(output.phases.len(), FITTED + HELD_OUT);
    for ((own, exact), error) in output.phases.iter().zip(&exact).zip(&errors) {
        let density = own.log_density;
        assert!((density - exact).abs() < 4.0 * error, "{}: {density} {exact} +- {error}", own.phase);
        assert!(*error < 0.1, "an error so large that anything passes would be no test");
        let held_out = own.phase[1..].parse::<usize>().expect("a number") >= FITTED;
        assert_eq!((own.readings, own.held_out, own.reliable), (2, held_out, true));
    }
    // The draws are the same for all phases, so that errors add up: the sums are held to the phases' own scores.
    let sum = |held_out: bool| -> f64 {
        output.phases.iter().filter(|own| own.held_out == held_out).map(|own| own.log_density).sum()
    };
    let left_out = output.leave_one_phase_out.expect("fitted phases").expected_log_density;
    assert!((left_out - sum(false)).abs() < 1e-9, "{left_out}");
    let held_out = output.held_out.expect("phases held out");
    assert!((held_out.log_density - sum(true)).abs() < 1e-9, "{held_out:?}");
    assert_eq!((held_out.phases, held_out.readings), (3, 6));
    // The band of a reading with its noise: variances of input, sensor and posterior add.
    let posterior = Matrix2::identity() / (PRIOR_SD_W * PRIOR_SD_W)
        + design().transpose() * noise.try_inverse().expect("invertible") * design() * FITTED as f64;
    let spread = design() * posterior.try_inverse().expect("invertible") * design().transpose() + noise;
    for (sensor, check) in output.predictive.iter().enumerate() {
        let [lower, upper] = check.rows[FITTED].band_with_noise;
        let wanted = 2.0 * 1.959_964 * spread[(sensor, sensor)].sqrt();
        // 400 draws give the posterior's part to a few per cent, and that is a tenth of the variance.
        assert!(((upper - lower) / wanted - 1.0).abs() < 0.02, "{} {wanted}", upper - lower);
    }
}

#[test]
fn phases_left_out_and_held_out_have_their_exact_densities() {
    check(0.0);
}

#[test]
fn errors_of_the_inputs_widen_the_densities_of_phases_held_out() {
    check(0.6);
}
