//! The radiator's study from its files: golden numbers of the first case study (made with the equations
//! `T = ((Q/A + alpha (q_sun cos(theta) + q_alb) + eps q_IR) / (eps sigma) + T_sink^4)^(1/4)` in double precision, sampled
//! 2^20 times) through loading, jobs and engine.

use std::path::Path;
use std::sync::Arc;

use bmv::expression::Symbol;
use bmv::job::conventional::Basis;
use bmv::job::propagate::Discrepancy;
use bmv::job::propagate::{Propagate, Sampling, Spec};
use bmv::job::ready::Readiness;
use bmv::job::{Runnable, conventional, propagate};
use bmv::random::Distribution;
use bmv::study::Pass;
use bmv::study::variable::Sweep;
use bmv::thermal::{Network, Start};
use serde::de::DeserializeOwned;

use crate::serial;

fn radiator() -> Pass {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/radiator/pass-1.json");
    let Ok(pass) = bmv::job::load(&file) else { panic!("the radiator loads") };
    assert!(pass.reconstructed.as_ref().is_some_and(|text| text.contains("reconstructed")));
    pass
}

/// Runs a job to its end.
pub fn run<T: DeserializeOwned>(job: &dyn Runnable) -> T {
    serde_json::from_value(serial::run(job).unwrap()).unwrap()
}

/// Settings of the pass's propagation.
pub fn propagation(pass: &Pass) -> Spec {
    let spec = pass.jobs.iter().find_map(|job| job.spec.get::<bmv::job::propagate::Spec>().cloned());
    spec.unwrap()
}

/// Result of a propagation of the pass's model with other settings and priors.
fn propagated(pass: &Pass, spec: Spec, priors: Vec<Distribution>) -> propagate::Output {
    run(&Propagate::new(spec, Arc::new(pass.model.clone()), priors, pass.seed, "prior").unwrap())
}

/// Sobol points along the given areas.
fn along(pass: &Pass, samples: u64, areas: &[f64]) -> Spec {
    let spec = propagation(pass);
    let sweep = Sweep { values: areas.to_vec(), ..spec.sweep.clone().unwrap() };
    Spec { samples, sampling: Sampling::Sobol, sweep: Some(sweep), ..spec }
}

#[test]
fn a_discrepancy_of_the_model_adds_its_variance() {
    let pass = radiator();
    let spec = Spec { samples: 16_384, sweep: None, ..along(&pass, 16_384, &[0.1]) };
    let plain = propagated(&pass, spec.clone(), pass.priors.clone());
    let quantity = spec.quantities[0];
    let job = Propagate::new(spec, Arc::new(pass.model.clone()), pass.priors.clone(), pass.seed, "prior").unwrap();
    let identity = job.identity();
    let job = job.with_discrepancy(vec![Discrepancy { quantity, sd: 3.0 }], pass.seed, "prior").unwrap();
    assert_ne!(job.identity(), identity);
    let added: propagate::Output = run(&job);
    for (with, without) in added.cases.iter().zip(&plain.cases) {
        let (with, without) = (&with.quantities[0], &without.quantities[0]);
        // Independent normal errors: four standard errors of their mean and of the variance with its cross term.
        let count = 16_384.0_f64;
        assert!((with.mean - without.mean).abs() < 4.0 * 3.0 / count.sqrt(), "{} {}", with.mean, without.mean);
        let (own, wanted) = (with.sd * with.sd, without.sd * without.sd + 9.0);
        let error = (2.0 * 81.0 + 4.0 * 9.0 * without.sd * without.sd).sqrt() / count.sqrt();
        assert!((own - wanted).abs() < 4.0 * error, "{own} {wanted}");
    }
}

#[test]
fn nominal_temperature_and_slopes() {
    let pass = radiator();
    let names = ["Q", "eps", "alpha", "q_sun", "theta", "q_alb", "q_IR"];
    let place = |name: &str| pass.model.parameters.iter().position(|p| p.name == name).unwrap();
    let symbols: Vec<Symbol> = names.iter().map(|name| Symbol::Parameter(place(name) as u32)).collect();
    let network = Network::compile(&pass.model, &symbols).unwrap();
    let mut workspace = network.workspace();
    network.solve_steady(&mut workspace, Start::Default).unwrap();
    let quantity = pass.model.quantities.iter().position(|q| q.name == "radiator temperature").unwrap();
    // Printed to nine digits.
    let temperature_k = network.quantity(&workspace, quantity);
    assert!((temperature_k / 301.978924 - 1.0).abs() < 1e-8, "{temperature_k}");
    let mut slopes = vec![0.0; network.quantities() * names.len()];
    network.quantity_tangent(&mut workspace, &mut slopes).unwrap();
    let slopes = &slopes[quantity * names.len()..][..names.len()];
    // The printed slopes have five digits; the closed form has all.
    let golden = [0.62785, -85.050, 47.537, 0.0065415, -50.714, 0.037671, 0.16010];
    let closed = closed_form_slopes(temperature_k);
    for (((name, slope), golden), closed) in names.iter().zip(slopes).zip(golden).zip(closed) {
        assert!((slope / golden - 1.0).abs() < 2e-5, "{name}: {slope}, printed {golden}");
        assert!((slope / closed - 1.0).abs() < 1e-6, "{name}: {slope}, closed form {closed}");
    }
}

/// Slopes of `T^4 = B / (eps sigma) + T_sink^4` by hand: `dT = dB / (4 eps sigma T^3)`, in the order of the names.
fn closed_form_slopes(temperature_k: f64) -> [f64; 7] {
    let (q, eps, alpha, sun, albedo, area) = (100.0, 0.85, 0.2, 1367.0, 15.0, 0.3);
    let theta = 80.0 * std::f64::consts::PI / 180.0;
    let emitted = 4.0 * eps * 5.670374419e-8 * temperature_k * temperature_k * temperature_k;
    // What does not scale with the emittance is divided by it.
    let other = q / area + alpha * (sun * libm::cos(theta) + albedo);
    [
        1.0 / area / emitted,
        -other / eps / emitted,
        (sun * libm::cos(theta) + albedo) / emitted,
        alpha * libm::cos(theta) / emitted,
        -alpha * sun * libm::sin(theta) / emitted,
        alpha / emitted,
        eps / emitted,
    ]
}

#[test]
fn prior_distribution_of_the_temperature() {
    let pass = radiator();
    let spec = Spec { sweep: None, ..along(&pass, 65536, &[0.3]) };
    let result = propagated(&pass, spec, pass.priors.clone());
    let temperature = result.cases[0].quantities.iter().find(|q| q.name == "radiator temperature").unwrap();
    // Printed to 0.01 K.
    assert!((temperature.mean - 273.15 - 28.91).abs() < 0.01, "{}", temperature.mean - 273.15);
    assert!((temperature.sd - 4.19).abs() < 0.01, "{}", temperature.sd);
    // Printed to 0.1 K, so up to 0.05 K off; the 1 % points of 65536 samples are known to 0.05 K; 0.15 K covers both.
    for (probability, golden_c) in [(0.01, 20.2), (0.05, 22.2), (0.5, 28.8), (0.95, 35.9), (0.99, 38.0)] {
        let found = temperature.quantiles.iter().find(|q| q.probability == probability).unwrap();
        assert!((found.value - 273.15 - golden_c).abs() < 0.15, "{probability}: {}", found.value - 273.15);
    }
}

#[test]
#[ignore = "thorough"]
fn probability_of_a_cool_radiator_by_area() {
    let pass = radiator();
    let golden = [(0.28, 0.644), (0.29, 0.805), (0.30, 0.919), (0.31, 0.978), (0.32, 0.997), (0.33, 1.000)];
    let spec = along(&pass, 65536, &golden.map(|(area, _)| area));
    let result = propagated(&pass, spec, pass.priors.clone());
    for (case, (area, golden)) in result.cases[1..].iter().zip(golden) {
        assert_eq!(case.design_value, Some(area));
        let found = case.requirements[0].probability;
        assert!((found.value - golden).abs() < 0.01, "{area} m2: {found:?}");
        assert!(found.lower <= found.value && found.value <= found.upper);
    }
}

#[test]
#[ignore = "thorough"]
fn sizes_by_probability_before_and_after_a_measurement_of_the_emittance() {
    let pass = radiator();
    let size = |areas: &[f64], priors: Vec<Distribution>| {
        let result = propagated(&pass, along(&pass, 1 << 17, areas), priors);
        let reached = &result.reached[0];
        assert_eq!((reached.requirement.as_str(), reached.probability), ("radiator", 0.99));
        reached.design_value.unwrap()
    };
    let prior = size(&[0.310, 0.312, 0.314, 0.316, 0.317], pass.priors.clone());
    assert!((prior - 0.3144).abs() < 0.0005, "{prior}");
    let mut measured = pass.priors.clone();
    let emittance = pass.model.parameters.iter().position(|p| p.name == "eps").unwrap();
    measured[emittance] = Distribution::Normal { mean: 0.88, sd: 0.005, lower: None, upper: None };
    let after = size(&[0.280, 0.282, 0.284, 0.286, 0.288], measured);
    assert!((after - 0.2835).abs() < 0.0005, "{after}");
}

#[test]
fn sizes_by_margin_rules() {
    let pass = radiator();
    let jobs = bmv::job::ready(&pass);
    let Some((_, Readiness::Ready(job))) = jobs.iter().find(|(name, _)| name == "margins") else { panic!("margins") };
    let result: conventional::Output = run(job.as_ref());
    let size = |rule: &str, basis: Basis| {
        let found = result.sizes.iter().find(|s| s.rule.name == rule && s.basis == basis);
        found.unwrap_or_else(|| panic!("{rule}")).size.unwrap()
    };
    // Printed to 0.0001 m2.
    for (rule, nominal, stacked) in [
        ("none", 0.2724, 0.3422),
        ("nasa-gsfc-5k", 0.2945, 0.3729),
        ("military-11k", 0.3244, 0.4152),
        ("military-17k", 0.3586, 0.4649),
    ] {
        for (basis, golden) in [(Basis::Nominal, nominal), (Basis::StackedWorstCase, stacked)] {
            let found = size(rule, basis);
            assert!((found - golden).abs() < 0.0005, "{rule} {basis:?}: {found}, golden {golden}");
        }
    }
    // A quarter more heat load: the area grows in proportion, for it is Q over a flux that holds no Q.
    for basis in [Basis::Nominal, Basis::StackedWorstCase] {
        let (plain, more) = (size("none", basis), size("heat-load-25", basis));
        assert!((more - 1.25 * plain).abs() < 0.0005, "{basis:?}: {plain} {more}");
    }
}
