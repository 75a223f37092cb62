//! The calibration job on the electronics box of 8 nodes, against a posterior had apart, and its refusals.

use std::sync::Arc;

use bmv::job::JobError;
use bmv::job::calibrate::{Calibrate, Inputs, Output, Sampler, Spec};
use bmv::measurement::{Measurement, Rows, Uncertain};

use crate::serial::run;
use crate::verification::network8_data::{measurement, model, priors};

fn job(sampler: Sampler, draws: u64, change: &dyn Fn(&mut Measurement)) -> Result<Calibrate, JobError> {
    job_of(sampler, (sampler.defaults().0, draws), change)
}

fn job_of(
    sampler: Sampler,
    (warmup, draws): (u64, u64),
    change: &dyn Fn(&mut Measurement),
) -> Result<Calibrate, JobError> {
    let model = model();
    let mut data = measurement(&model);
    change(&mut data);
    let spec =
        Spec { data: vec![0], parameters: vec![0, 1, 2, 3], sampler, chains: 4, warmup, draws, acceptance: None };
    let inputs = Inputs {
        model: Arc::new(model),
        priors: priors().to_vec(),
        measurements: Arc::new(vec![data]),
        input_errors: vec![],
    };
    Calibrate::new(spec, inputs, 7, "tuned")
}

fn calibrated(sampler: Sampler, draws: u64) -> Output {
    let job = job(sampler, draws, &|_| ()).expect("a job");
    serde_json::from_value(run(&job).expect("runs")).expect("an output")
}

/// Mean and standard deviation by importance sampling with 30 000 draws, printed to four or more digits.
const REFERENCE: [(&str, f64, f64); 4] = [
    ("G_tim", 4.038_625, 0.043_92),
    ("eps_rad", 0.854_990_4, 0.001_619),
    ("eps_mli", 0.029_916_27, 0.000_122_6),
    ("alpha", 0.153_397_4, 0.001_080),
];

fn agrees(output: &Output) {
    assert!(output.converged, "{:?}", output.objections);
    for (name, mean, sd) in REFERENCE {
        let own = &output.parameters[name];
        // Four standard errors of ours and of the reference's 24 400 effective draws; of a normal's sd, 1 / sqrt(2 n).
        let (ess, other) = (own.ess_bulk.expect("ess"), 24_400.0_f64);
        let error = sd * (1.0 / ess + 1.0 / other).sqrt();
        assert!((own.mean - mean).abs() < 4.0 * error, "{name}: {} {mean} {error}", own.mean);
        let error = sd * (0.5 / ess + 0.5 / other).sqrt();
        assert!((own.sd - sd).abs() < 4.0 * error + 5e-4 * sd, "{name}: {} {sd} {error}", own.sd);
        assert!(own.q025 < own.q50 && own.q50 < own.q975 && own.at_bound == 0.0);
    }
    let (value, sd) = (output.log_evidence.value.expect("evidence"), output.log_evidence.sd.expect("error"));
    assert!((value + 185.6152).abs() < 4.0 * (sd * sd + 0.0028 * 0.0028).sqrt(), "{value} {sd}");
    assert!((output.log_evidence.laplace.expect("laplace") + 185.6205).abs() < 1e-3);
    assert!((output.most_probable.chi_square - 235.5621).abs() < 1e-4);
    assert_eq!(output.draws.values.len(), 1000);
}

#[test]
#[ignore = "thorough"]
fn nuts_finds_the_reference_posterior() {
    let output = calibrated(Sampler::Nuts, 1000);
    agrees(&output);
    // Predictive checks of a model that is right: coverage of 215 readings within the 99.9 % range of a binomial
    // with 95 %, about 193 to 214 of 215.
    let inside: u64 = output.predictive.iter().map(|check| check.train.inside).sum();
    assert!((193..=214).contains(&inside), "{inside}");
    assert_eq!(output.predictive.iter().map(|check| check.pit.iter().sum::<u64>()).sum::<u64>(), 215);
    // chi-square of about 239.6 on average over the posterior, 215 readings: p near 0.12.
    let p = output.p_value.expect("p");
    assert!((0.10..0.16).contains(&p), "{p}");
    let left_out = output.leave_one_out.expect("leave-one-out");
    // A regular model of four parameters.
    assert!((3.0..6.0).contains(&left_out.effective_parameters), "{left_out:?}");
    assert_eq!(left_out.unreliable, 0);
    assert!(output.findings.is_empty() && output.warnings.is_empty(), "{:?} {:?}", output.findings, output.warnings);
}

#[test]
#[ignore = "thorough"]
fn short_chains_are_not_called_converged() {
    let output = calibrated(Sampler::Nuts, 20);
    assert!(!output.converged);
    assert!(output.objections.iter().any(|o| o.contains("effective sample size")), "{:?}", output.objections);
}

#[test]
#[ignore = "thorough"]
fn held_out_readings_do_not_change_the_posterior() {
    let at = |value: f64| {
        let job = job_of(Sampler::Nuts, (50, 20), &|data| {
            let Rows::Steady(phases) = &mut data.rows else { unreachable!() };
            phases[5].held_out = true;
            data.readings[27] = Some(value);
        })
        .expect("a job");
        let output: Output = serde_json::from_value(run(&job).expect("runs")).expect("an output");
        (output.parameters, output.draws, output.log_evidence, output.p_value)
    };
    assert_eq!(at(250.0), at(330.0));
}

#[test]
fn what_cannot_be_calibrated_is_refused() {
    let refused = |change: &dyn Fn(&mut Measurement)| job(Sampler::Nuts, 50, change).err().map(|e| e.to_string());
    let all_out = refused(&|data| {
        if let Rows::Steady(phases) = &mut data.rows {
            phases.iter_mut().for_each(|phase| phase.held_out = true);
        }
    });
    assert!(all_out.is_some_and(|e| e.contains("there is no reading to fit")));
    assert!(refused(&|data| data.sensors[0].sigma = None).is_some_and(|e| e.contains("has no `sigma`")));
    let zero = refused(&|data| data.sensors[0].sigma = Some(Uncertain::Known(0.0)));
    assert!(zero.is_some_and(|e| e.contains("expected a value above 0")));
    // A boundary at no temperature: no start can be evaluated.
    let lost = job(Sampler::Nuts, 50, &|data| {
        if let Rows::Steady(phases) = &mut data.rows {
            phases[0].inputs[4] = f64::NAN;
        }
    })
    .expect("a job");
    let error = run(&lost).expect_err("no start").to_string();
    assert!(error.contains("starting points could be evaluated") && error.contains("P00"), "{error}");
}

mod nightly {
    use super::*;

    #[test]
    #[ignore = "nightly"]
    fn adaptive_metropolis_finds_the_reference_posterior() {
        agrees(&calibrated(Sampler::AdaptiveMetropolis, 3000));
    }

    #[test]
    #[ignore = "nightly"]
    fn independent_proposals_find_the_reference_posterior() {
        agrees(&calibrated(Sampler::IndependenceMetropolis, 4000));
    }

    #[test]
    #[ignore = "nightly"]
    fn sequential_monte_carlo_finds_the_reference_posterior() {
        agrees(&calibrated(Sampler::Smc, 400));
    }
}
