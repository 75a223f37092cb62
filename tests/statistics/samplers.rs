//! Every sampler on posteriors with known answers.
//!
//! A moment is right when it lies within four Monte Carlo standard errors of the exact value; seeds are fixed, so that a
//! pass is a pass for ever.

use bmv::inference::chains::{Chain, Chains};
use bmv::inference::metropolis::{self, MetropolisSettings};
use bmv::inference::nuts::{self, NutsSettings};
use bmv::inference::smc::{self, SmcResult, SmcSettings};
use bmv::inference::target::Target;
use bmv::random::StreamKey;

use super::models;

#[test]
fn speed() {
    let l = models::LinearGaussian::new(10, 25);
    let t = std::time::Instant::now();
    let c = nuts_chains(&l.model(), &NutsSettings::default());
    println!("nuts {:?} {:?} {:?}", t.elapsed(), c.work(), c.chains[0].moves);
    let t = std::time::Instant::now();
    let c = metropolis_chains(&l.model(), &MetropolisSettings::default());
    println!("am {:?} {:?} {:?}", t.elapsed(), c.work(), c.chains[0].moves);
    let t = std::time::Instant::now();
    let c = smc_result(&l.model(), &SmcSettings::default());
    println!("smc {:?} {:?} {} {} {}", t.elapsed(), c.chains.work(), c.log_evidence, c.log_evidence_error, l.exact().2);
    println!("{:?}", c.stages[0]);
    let t = std::time::Instant::now();
    let c = smc_result(&models::two_modes(), &SmcSettings::default());
    println!(
        "smc {:?} {:?} {} {} {}",
        t.elapsed(),
        c.chains.work(),
        c.log_evidence,
        c.log_evidence_error,
        -(400.0_f64).ln()
    );
    println!("{:?}", c.stages[0]);
}

fn key(purpose: &str) -> StreamKey {
    StreamKey::new(20_260_101, "samplers", purpose)
}

fn collect<T: Target>(target: &T, chains: Vec<Chain>) -> Chains {
    Chains { names: target.names().to_vec(), chains }
}

fn nuts_chains<T: Target>(target: &T, settings: &NutsSettings) -> Chains {
    collect(target, (0..4).map(|c| nuts::sample(target, settings, &key("nuts"), c, None).expect("a chain")).collect())
}

fn metropolis_chains<T: Target>(target: &T, settings: &MetropolisSettings) -> Chains {
    let chain = |c| metropolis::sample(target, settings, &key("metropolis"), c, None).expect("a chain");
    collect(target, (0..4).map(chain).collect())
}

fn smc_result<T: Target>(target: &T, settings: &SmcSettings) -> SmcResult {
    let islands = (0..settings.islands).map(|i| smc::run_island(target, settings, &key("smc"), i).expect("an island"));
    smc::combine(target.names(), islands.collect())
}
