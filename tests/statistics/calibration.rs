//! Simulation-based calibration (Talts, Betancourt, Simpson, Vehtari & Gelman 2018): the rank of a true parameter among
//! draws from its posterior is uniform over data sets simulated from the prior.

use bmv::inference::sampler::chains::Chain;
use bmv::inference::sampler::metropolis::{self, MetropolisSettings};
use bmv::inference::sampler::nuts::{self, NutsSettings};
use bmv::inference::sampler::smc::{self, SmcSettings};
use bmv::inference::target::Target;
use bmv::random::StreamKey;

use super::models::{Model, log_normal_density, normal, uniform};

const TIMES: [f64; 5] = [0.2, 0.5, 1.0, 2.0, 4.0];
const NOISE: f64 = 0.15;

/// A decay `a e^(-b t)` with a normal and a uniform prior.
fn decay(readings: [f64; 5]) -> Model {
    Model::new(vec![normal(1.0, 0.4), uniform(0.1, 2.0)], move |x, g| {
        let mut sum = 0.0;
        for (t, y) in TIMES.iter().zip(readings) {
            let shape = libm::exp(-x[1] * t);
            let deviation = y - x[0] * shape;
            sum += log_normal_density(deviation, NOISE);
            let pull = deviation / (NOISE * NOISE);
            g[0] += pull * shape;
            g[1] -= pull * x[0] * t * shape;
        }
        Ok(sum)
    })
}

/// Draws compared with the truth: ranks of 0 to 63, in eight bins.
const DRAWS: usize = 63;

fn chi_squares(data_sets: u64, run: impl Fn(&Model, &StreamKey, u64) -> Chain) -> [f64; 2] {
    let key = StreamKey::new(5, "calibration", "data");
    let sampler_key = StreamKey::new(5, "calibration", "sampler");
    let mut bins = [[0_u32; 8]; 2];
    for set in 0..data_sets {
        let mut stream = key.stream(set);
        let priors = decay([0.0; 5]).priors().to_vec();
        let truth: Vec<f64> = priors.iter().map(|prior| prior.quantile(stream.uniform())).collect();
        let readings = TIMES.map(|t| truth[0] * libm::exp(-truth[1] * t) + NOISE * stream.normal());
        let chain = run(&decay(readings), &sampler_key, set);
        assert!(chain.len() >= DRAWS);
        let stride = chain.len() / DRAWS;
        for parameter in 0..2 {
            let rank = (0..DRAWS).filter(|i| chain.draw(i * stride)[parameter] < truth[parameter]).count();
            bins[parameter][rank / 8] += 1;
        }
    }
    let expected = data_sets as f64 / 8.0;
    bins.map(|row| row.iter().map(|&n| (f64::from(n) - expected) * (f64::from(n) - expected) / expected).sum())
}

fn check(name: &str, data_sets: u64, run: impl Fn(&Model, &StreamKey, u64) -> Chain) {
    let chi_squares = chi_squares(data_sets, run);
    println!("{name}: {chi_squares:?}");
    // Seven degrees of freedom, 99.9 %.
    assert!(chi_squares.iter().all(|x| *x < 24.32), "{name}: {chi_squares:?}");
}

fn calibrate(data_sets: u64) {
    check("nuts", data_sets, |model, key, set| {
        let settings = NutsSettings { warm_up: 200, draws: 4 * DRAWS as u64, ..Default::default() };
        nuts::sample(model, &settings, key, set, None).expect("a chain")
    });
    check("metropolis", data_sets, |model, key, set| {
        let settings = MetropolisSettings { warm_up: 1500, draws: DRAWS as u64, thin: 25, ..Default::default() };
        metropolis::sample(model, &settings, key, set, None).expect("a chain")
    });
    check("smc", data_sets, |model, key, set| {
        let settings = SmcSettings { particles: 126, ..Default::default() };
        smc::run_island(model, &settings, key, set).expect("an island").chain
    });
}

#[test]
#[ignore = "thorough"]
fn ranks_are_uniform_over_few_data_sets() {
    calibrate(100);
}

mod nightly {
    use super::*;

    #[test]
    #[ignore = "nightly"]
    fn ranks_are_uniform_over_many_data_sets() {
        calibrate(1000);
    }
}
