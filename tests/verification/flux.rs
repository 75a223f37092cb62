//! Propagation of an algebraic model with exact moments: `q = eps sigma A (Th^4 - Ts^4) - alpha S A`, six uniforms.

use std::path::Path;

use bmv::job::propagate;
use bmv::job::ready::Readiness;

use super::radiator::run;

/// `E[x^k]` of a uniform variable.
fn moment([a, b]: [f64; 2], k: i32) -> f64 {
    let power = |x: f64| (0..=k).fold(1.0, |product, _| product * x);
    (power(b) - power(a)) / (f64::from(k + 1) * (b - a))
}

/// Mean and standard deviation in closed form.
fn exact() -> (f64, f64) {
    let sigma = 5.670374419e-8;
    let (eps, area, hot, cold) = ([0.80, 0.90], [0.95, 1.05], [285.0, 305.0], [3.0, 50.0]);
    let (alpha, sun) = ([0.10, 0.25], [1322.0, 1414.0]);
    let fourth = moment(hot, 4) - moment(cold, 4);
    let eighth = moment(hot, 8) - 2.0 * moment(hot, 4) * moment(cold, 4) + moment(cold, 8);
    let mean = moment(area, 1) * (sigma * moment(eps, 1) * fourth - moment(alpha, 1) * moment(sun, 1));
    let square = moment(area, 2)
        * (sigma * sigma * moment(eps, 2) * eighth
            - 2.0 * sigma * moment(eps, 1) * fourth * moment(alpha, 1) * moment(sun, 1)
            + moment(alpha, 2) * moment(sun, 2));
    (mean, (square - mean * mean).sqrt())
}

#[test]
fn moments_are_exact_within_their_standard_errors_in_all_samplings() {
    let (mean, sd) = exact();
    // Computed once with other software.
    assert!((mean - 126.3966285).abs() < 1e-7 && (sd - 67.24918143).abs() < 1e-7, "{mean} {sd}");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/verification/flux/pass-1.json");
    let Ok(pass) = bmv::job::load(&file) else { panic!("the study loads") };
    let jobs = bmv::job::ready(&pass);
    // Largest errors of mean and standard deviation in standard errors of independent draws: 4 by chance alone. The mean
    // is nearly a sum of functions of one variable, whose error slices remove; the square is not. Sobol points do both.
    for (name, largest, largest_of_sd) in
        [("monte carlo", 4.0, 4.0), ("latin hypercube", 0.5, 4.0), ("sobol", 0.02, 0.1)]
    {
        let Some((_, Readiness::Ready(job))) = jobs.iter().find(|(found, _)| found == name) else { panic!("{name}") };
        let result: propagate::Output = run(job.as_ref());
        let found = &result.cases[0].quantities[0];
        assert_eq!((result.sampling.as_str(), result.cases[0].failed), (name.replace(' ', "-").as_str(), 0));
        let error = (found.mean - mean) / found.mean_standard_error;
        assert!(error.abs() < largest, "{name}: {} is {error} standard errors off {mean}", found.mean);
        let error = (found.sd - sd) / found.sd_standard_error;
        assert!(error.abs() < largest_of_sd, "{name}: {} is {error} standard errors off {sd}", found.sd);
        // The stated standard errors are those of independent draws: sd / sqrt(N), and for the sd about sd / sqrt(2N) here.
        assert!((found.mean_standard_error * 128.0 / sd - 1.0).abs() < 0.02);
        assert!((found.sd_standard_error * 128.0 * 2.0_f64.sqrt() / sd - 1.0).abs() < 0.3);
    }
}
