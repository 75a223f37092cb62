//! More samples keep the ones before: blocks of jobs that differ in nothing but their number of samples.

use std::path::Path;
use std::sync::Arc;

use bmv::job::propagate::{Propagate, Sampling, Spec};
use bmv::job::{Job, NoParts, Step};

/// Temperatures of the radiator's nominal case, sample by sample, out of the blocks.
fn samples(count: u64, sampling: Sampling) -> Vec<u64> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/radiator/pass-1.json");
    let Ok(pass) = bmv::job::load(&file) else { panic!("the radiator loads") };
    let spec = pass.jobs.iter().find_map(|job| job.spec.get::<bmv::job::propagate::Spec>().cloned());
    let mut spec = Spec { samples: count, sampling, sweep: None, ..spec.unwrap() };
    spec.quantities.truncate(1);
    let job = Propagate::new(spec, Arc::new(pass.model), pass.priors, pass.seed, "prior").unwrap();
    let Step::Blocks { inputs, .. } = job.begin().unwrap() else { panic!("blocks first") };
    let mut values = Vec::new();
    for input in inputs {
        let block = job.block(&(), input, &NoParts).unwrap();
        values.extend(block.values.iter().map(|value| value.to_bits()));
    }
    assert_eq!(values.len() as u64, count);
    values
}

#[test]
fn the_first_thousand_of_two_thousand_are_the_thousand_of_before() {
    for sampling in [Sampling::MonteCarlo, Sampling::Sobol] {
        let (thousand, two) = (samples(1000, sampling), samples(2000, sampling));
        assert_eq!(thousand, two[..1000], "{sampling:?}");
        assert_ne!(thousand, two[1000..]);
    }
    // Over the edge of a block, and for a number that is no multiple of the lanes.
    let (few, many) = (samples(8195, Sampling::MonteCarlo), samples(9001, Sampling::MonteCarlo));
    assert_eq!(few, many[..8195]);
}
