//! The solar X-ray monitor's prior uncertainty through its study (its golden solutions are in `steady`).

use std::path::Path;
use std::sync::Arc;

use bmv::job::propagate::{Output, Propagate};

use super::radiator::{propagation, run};

#[test]
#[ignore = "thorough"]
fn prior_distributions_and_probabilities_by_deck_temperature() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/verification/sxm/pass-1.json");
    let Ok(pass) = bmv::job::load(&file) else { panic!("the study loads") };
    let job = Propagate::new(propagation(&pass), Arc::new(pass.model.clone()), pass.priors.clone(), pass.seed, "prior");
    let result: Output = run(&job.unwrap());
    let nominal = &result.cases[0];
    assert_eq!(nominal.failed, 0);
    // Case study 4.7: mean and standard deviation of 4096 samples, printed to 0.1 K; their sampling error is 0.05 K.
    for (quantity, (mean_c, sd_k)) in nominal.quantities.iter().zip([(-38.8, 2.98), (42.2, 3.7), (42.4, 3.2)]) {
        assert!((quantity.mean - 273.15 - mean_c).abs() < 0.2, "{}: {}", quantity.name, quantity.mean - 273.15);
        assert!((quantity.sd - sd_k).abs() < 0.15, "{}: {}", quantity.name, quantity.sd);
    }
    // Probability that each requirement is met, 8192 samples with a standard error up to 0.006; 0.02 covers three.
    let detector = [1.0, 0.998, 0.992, 0.983, 0.957, 0.922, 0.872, 0.796, 0.677, 0.515, 0.327, 0.157, 0.057];
    let housing = [1.0, 1.0, 1.0, 1.0, 1.0, 0.997, 0.985, 0.955, 0.915, 0.866, 0.789, 0.677, 0.489];
    let board = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.999, 0.994, 0.974, 0.930, 0.855];
    for (position, case) in result.cases[1..].iter().enumerate() {
        for (met, golden) in case.requirements.iter().zip([detector, housing, board]) {
            let found = met.probability.value;
            let deck = case.design_value;
            assert!((found - golden[position]).abs() < 0.02, "{} at {deck:?}: {found}", met.requirement);
        }
        let together = case.requirements.last().unwrap();
        assert_eq!(together.requirement, "all");
        assert!(case.requirements.iter().all(|met| together.probability.value <= met.probability.value));
    }
}
