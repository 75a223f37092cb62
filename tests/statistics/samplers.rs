//! Every sampler on posteriors with known answers.
//!
//! A moment is right when it lies within four Monte Carlo standard errors of the exact value; seeds are fixed, so that a
//! pass is a pass for ever.

use bmv::inference::prior::triangular_transport::NormalApproximation;
use bmv::inference::sampler::chains::{Chain, Chains};
use bmv::inference::sampler::convergence::{Convergence, ConvergenceLimits, Objection, judge};
use bmv::inference::sampler::importance::{ImportanceEstimate, ImportanceSettings, estimate as importance};
use bmv::inference::sampler::independence::{self, IndependenceSettings};
use bmv::inference::sampler::metropolis::{self, MetropolisSettings};
use bmv::inference::sampler::nuts::{self, NutsSettings};
use bmv::inference::sampler::parts::Parts;
use bmv::inference::sampler::smc::{self, SmcResult, SmcSettings};
use bmv::inference::target::Target;
use bmv::random::StreamKey;
use bmv::statistics::chain_diagnostics::{mcse_mean, mcse_sd};

use super::models::{self, check_gradient};

fn key(purpose: &str) -> StreamKey {
    StreamKey::new(20_260_101, "samplers", purpose)
}

fn collect<T: Target>(target: &T, chains: Vec<Chain>) -> Chains {
    Chains { names: target.names().to_vec(), chains }
}

pub fn nuts_chains<T: Target>(target: &T, settings: &NutsSettings) -> Chains {
    collect(target, (0..4).map(|c| nuts::sample(target, settings, &key("nuts"), c, None).expect("a chain")).collect())
}

pub fn metropolis_chains<T: Target>(target: &T, settings: &MetropolisSettings) -> Chains {
    let chain = |c| metropolis::sample(target, settings, &key("metropolis"), c, None).expect("a chain");
    collect(target, (0..4).map(chain).collect())
}

pub fn smc_result<T: Target>(target: &T, settings: &SmcSettings) -> SmcResult {
    let islands = (0..settings.islands).map(|i| smc::run_island(target, settings, &key("smc"), i).expect("an island"));
    smc::combine(target.names(), islands.collect())
}

/// The three samplers with their default settings.
pub fn every_sampler<T: Target>(target: &T) -> [(&'static str, Chains); 3] {
    [
        ("nuts", nuts_chains(target, &NutsSettings::default())),
        ("metropolis", metropolis_chains(target, &MetropolisSettings::default())),
        ("smc", smc_result(target, &SmcSettings::default()).chains),
    ]
}

fn verdict<T: Target>(target: &T, chains: &Chains) -> Convergence {
    judge(chains, target.priors(), &ConvergenceLimits::default())
}

/// Mean and standard deviation of a quantity of the draws, each within four standard errors of its exact value.
fn check_moments(what: &str, chains: &Chains, of: impl Fn(&[f64]) -> f64, mean: f64, sd: f64) {
    let values: Vec<Vec<f64>> =
        chains.chains.iter().map(|chain| (0..chain.len()).map(|i| of(chain.draw(i))).collect()).collect();
    let count = chains.len() as f64;
    let own_mean = values.iter().flatten().sum::<f64>() / count;
    let own_sd = (values.iter().flatten().map(|x| (x - own_mean) * (x - own_mean)).sum::<f64>() / count).sqrt();
    let (mean_error, sd_error) = (mcse_mean(&values).expect("an error"), mcse_sd(&values).expect("an error"));
    assert!((own_mean - mean).abs() < 4.0 * mean_error, "{what}: mean {own_mean} +- {mean_error}, exact {mean}");
    assert!((own_sd - sd).abs() < 4.0 * sd_error, "{what}: sd {own_sd} +- {sd_error}, exact {sd}");
    // An error so large that anything passes would be no test.
    assert!(mean_error < 0.1 * sd, "{what}: error {mean_error} of a mean with sd {sd}");
}

#[test]
fn gradients_of_the_models_are_right() {
    check_gradient(&models::conjugate().0, &[1.7]);
    check_gradient(&models::LinearGaussian::new(10, 25).model(), &[0.3; 10]);
    check_gradient(&models::banana(), &[1.0, -2.0]);
    check_gradient(&models::two_modes(), &[-2.0, 0.7]);
    check_gradient(&models::pressed(), &[0.3]);
    check_gradient(&models::inferred_noise(), &[1.0, 0.4, 0.8, 0.3, -0.5, 1.1]);
    check_gradient(&models::failing(), &[0.3, -0.8]);
}

#[test]
fn conjugate_normal() {
    let (model, [mean, sd, evidence]) = models::conjugate();
    for (name, chains) in every_sampler(&model) {
        check_moments(name, &chains, |draw| draw[0], mean, sd);
        let verdict = verdict(&model, &chains);
        assert!(name == "smc" || verdict.converged, "{name}: {:?}", verdict.objections);
        assert!(verdict.leaning.is_empty());
    }
    let smc = smc_result(&model, &SmcSettings::default());
    assert!((smc.log_evidence - evidence).abs() < 3.0 * smc.log_evidence_error, "{} {evidence}", smc.log_evidence);
}

#[test]
#[ignore = "thorough"]
fn linear_gaussian_in_ten_dimensions() {
    let linear = models::LinearGaussian::new(10, 25);
    let model = linear.model();
    let (mean, covariance, evidence) = linear.exact();
    for (name, chains) in every_sampler(&model) {
        for i in 0..10 {
            check_moments(&format!("{name} {i}"), &chains, |draw| draw[i], mean[i], covariance[(i, i)].sqrt());
        }
        // Correlations by sums of neighbours.
        for i in 0..9 {
            let variance = covariance[(i, i)] + covariance[(i + 1, i + 1)] + 2.0 * covariance[(i, i + 1)];
            let sum = |draw: &[f64]| draw[i] + draw[i + 1];
            check_moments(&format!("{name} sum {i}"), &chains, sum, mean[i] + mean[i + 1], variance.sqrt());
        }
    }
    let smc = smc_result(&model, &SmcSettings::default());
    assert!(smc.finished);
    assert!((smc.log_evidence - evidence).abs() < 3.0 * smc.log_evidence_error, "{} {evidence}", smc.log_evidence);
    assert!(smc.log_evidence_error < 0.1);
}

/// About the exact posterior, and about one that is a standard deviation away and twice as wide: a normal approximation
/// decides how well the chains mix, not where they go.
#[test]
fn independent_proposals_about_a_right_and_a_wrong_normal_approximation() {
    let linear = models::LinearGaussian::new(4, 25);
    let model = linear.model();
    let (mean, covariance, _) = linear.exact();
    for (shift, factor) in [(0.0, 1.0), (1.0, 2.0)] {
        let mode = (0..4).map(|i| mean[i] + shift * covariance[(i, i)].sqrt()).collect();
        let covariance_of_normal = covariance.iter().map(|value| factor * value).collect();
        let normal = NormalApproximation { mode, covariance: covariance_of_normal };
        let settings = IndependenceSettings { draws: 4000, ..IndependenceSettings::about(normal) };
        let run = |c| independence::sample(&model, &settings, &key("independence"), c, None).expect("a chain");
        let chains = collect(&model, (0..4).map(run).collect());
        for i in 0..4 {
            let what = format!("independence {shift} {i}");
            check_moments(&what, &chains, |draw| draw[i], mean[i], covariance[(i, i)].sqrt());
        }
        let verdict = verdict(&model, &chains);
        assert!(verdict.converged, "{:?}", verdict.objections);
        let acceptance = chains.chains[0].moves.acceptance;
        assert!(acceptance > 0.1 && acceptance < 0.9, "{shift}: {acceptance}");
    }
}

#[test]
#[ignore = "thorough"]
fn banana() {
    let model = models::banana();
    let nuts = NutsSettings { warm_up: 1000, draws: 2000, acceptance: 0.95, ..Default::default() };
    let metropolis = MetropolisSettings { draws: 20_000, thin: 3, ..Default::default() };
    let smc = smc_result(&model, &SmcSettings::default());
    for (name, chains) in [
        ("nuts", nuts_chains(&model, &nuts)),
        ("metropolis", metropolis_chains(&model, &metropolis)),
        ("smc", smc.chains),
    ] {
        check_moments(&format!("{name} 0"), &chains, |draw| draw[0], 0.0, 2.0);
        check_moments(&format!("{name} 1"), &chains, |draw| draw[1], 0.0, 3.0);
    }
    // The box has the density 1 / (40 * 180), and all but 1e-9 of the banana lies in it.
    let exact = -libm::log(40.0 * 180.0);
    assert!((smc.log_evidence - exact).abs() < 3.0 * smc.log_evidence_error, "{} {exact}", smc.log_evidence);
}

#[test]
fn sequential_monte_carlo_weighs_two_modes() {
    let model = models::two_modes();
    let smc = smc_result(&model, &SmcSettings::default());
    let mut share = 0.0;
    let mut shares = Vec::new();
    for (chain, weight) in smc.chains.chains.iter().zip(&smc.weights) {
        let own = (0..chain.len()).filter(|&i| chain.draw(i)[0] < 0.0).count() as f64 / chain.len() as f64;
        share += weight * own;
        shares.push(own);
    }
    // The scatter of eight islands: standard error of their mean.
    let spread = shares.iter().map(|s| (s - share) * (s - share)).sum::<f64>() / 7.0 / 8.0;
    assert!(
        (share - 0.3).abs() < 4.0 * spread.sqrt() && spread.sqrt() < 0.03,
        "{share} +- {} {shares:?}",
        spread.sqrt()
    );
    let exact = -libm::log(400.0);
    assert!((smc.log_evidence - exact).abs() < 3.0 * smc.log_evidence_error, "{}", smc.log_evidence);
    // The weights of the islands are shares.
    assert!((smc.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
}

#[test]
fn trajectories_follow_a_narrow_ridge_to_a_bound() {
    let (model, mode) = models::ridge();
    check_gradient(&model, &[0.79, 0.0349]);
    let (rho, [a, b]) = models::RIDGE;
    let covariance = vec![a * a, rho * a * b, rho * a * b, b * b];
    let normal = Some(NormalApproximation { mode: mode.to_vec(), covariance });
    // The first parameter is a normal cut two standard deviations below its mode, the second its regression and a rest.
    let lambda = libm::exp(-2.0 - models::HALF_LN_TAU) / 0.977_249_868_051_820_8;
    let variance = 1.0 - 2.0 * lambda - lambda * lambda;
    let (mean, sd) = ([mode[0] + a * lambda, mode[1] + rho * b * lambda], [a, b]);
    let sd = [sd[0] * variance.sqrt(), sd[1] * (rho * rho * variance + 1.0 - rho * rho).sqrt()];
    let chains = nuts_chains(&model, &NutsSettings { normal, ..Default::default() });
    for i in 0..2 {
        check_moments(&format!("ridge {i}"), &chains, |draw| draw[i], mean[i], sd[i]);
    }
    let verdict = verdict(&model, &chains);
    assert!(verdict.converged, "{:?}", verdict.objections);
    assert_eq!(chains.chains.iter().map(|chain| chain.moves.divergences).sum::<u64>(), 0);
    // Nothing of the ridge is left: without the shear it takes ten times the gradients and diverges.
    assert!(chains.work().gradients < 60_000, "{:?}", chains.work());
}

#[test]
fn chains_in_different_modes_are_refused() {
    let model = models::two_modes();
    let chains = nuts_chains(&model, &NutsSettings::default());
    let verdict = verdict(&model, &chains);
    assert!(!verdict.converged);
    assert!(verdict.objections.iter().any(|o| matches!(o, Objection::RHat { parameter: 0, .. })), "{verdict:?}");
}

#[test]
fn a_posterior_pressed_against_a_bound() {
    let model = models::pressed();
    // An exponential of rate 20, cut at 1, where e^-20 is left: mean and sd 1/20 to 1e-7.
    for (name, chains) in every_sampler(&model) {
        check_moments(name, &chains, |draw| draw[0], 0.05, 0.05);
        let verdict = verdict(&model, &chains);
        // P(x < 0.01) = 1 - e^-0.2 = 0.18.
        assert_eq!(verdict.leaning.len(), 1, "{name}");
        assert!(!verdict.leaning[0].upper && (verdict.leaning[0].share - 0.181).abs() < 0.03, "{verdict:?}");
    }
    let smc = smc_result(&model, &SmcSettings::default());
    let exact = pressed_evidence();
    assert!((smc.log_evidence - exact).abs() < 3.0 * smc.log_evidence_error, "{}", smc.log_evidence);
    assert!(smc.log_evidence_error < 0.08);
}

/// Root mean square of the error by the stated one over seeds, and how many seeds lie beyond two stated errors.
fn by_stated_error(exact: f64, seeds: u64, estimate: impl Fn(&StreamKey) -> (f64, f64)) -> (f64, u32) {
    let (mut squares, mut beyond) = (0.0, 0);
    for seed in 0..seeds {
        let (value, error) = estimate(&StreamKey::new(seed, "samplers", "evidence"));
        let z = (value - exact) / error;
        squares += z * z;
        beyond += u32::from(!(z.abs() < 2.0));
    }
    ((squares / seeds as f64).sqrt(), beyond)
}

/// Four islands, as many as a study has where it says nothing.
fn islands<T: Target>(model: &T, particles: usize, key: &StreamKey) -> SmcResult {
    let settings = SmcSettings { particles, islands: 4, ..SmcSettings::default() };
    let islands = (0..4).map(|i| smc::run_island(model, &settings, key, i).expect("an island")).collect();
    smc::combine(model.names(), islands)
}

/// Log evidence of the posterior pressed against a bound.
fn pressed_evidence() -> f64 {
    libm::log((1.0 - libm::exp(-20.0)) / 20.0)
}

#[test]
#[ignore = "thorough"]
fn the_error_of_the_evidence_of_four_islands_is_the_stated_one() {
    let (pressed, linear) = (models::pressed(), models::LinearGaussian::new(3, 8));
    let linear_model = linear.model();
    let of = |smc: SmcResult| (smc.log_evidence, smc.log_evidence_error);
    let found = [
        by_stated_error(pressed_evidence(), 32, |key| of(islands(&pressed, 128, key))),
        by_stated_error(linear.exact().2, 32, |key| of(islands(&linear_model, 128, key))),
    ];
    println!("{found:?}");
    // Of 32 seeds a root mean square of 1 has a standard error of 1 / sqrt(64): two and a half of them. Read off the scatter of four
    // islands it is that of Student's t with three degrees of freedom, 1.7. Beyond two lie 5 %: more than 5 once in 170.
    for (scale, beyond) in found {
        assert!((0.69..1.31).contains(&scale) && beyond <= 5, "{found:?}");
    }
}

#[test]
fn draws_of_the_evidence_end_at_the_wanted_error_and_keep_the_stated_one() {
    let linear = models::LinearGaussian::new(10, 25);
    let (model, start, exact) = (linear.model(), linear.exact().0, linear.exact().2);
    let settings = ImportanceSettings { wanted_error: 0.05, ..Default::default() };
    let (scale, beyond) = by_stated_error(exact, 32, |key| {
        let found = importance(&model, &settings, key, 0, Some(start.as_slice())).expect("an estimate");
        assert!(found.log_evidence_error <= 0.05 && found.work.likelihoods < 4000, "{found:?}");
        (found.log_evidence, found.log_evidence_error)
    });
    // Bounds as for the islands.
    assert!((0.69..1.31).contains(&scale) && beyond <= 5, "{scale} {beyond}");
}

#[test]
fn draws_of_the_evidence_end_where_the_weights_have_no_mean() {
    // A narrow peak on a plateau with nearly all of the mass: of draws by a t density with one degree of freedom round the
    // peak the weights go with the distance squared, whose tail has the shape 2.
    let model = models::Model::new(vec![models::uniform(-1e3, 1e3)], |x, slopes| {
        let peak = libm::exp(-5e3 * x[0] * x[0]);
        slopes[0] = -1e4 * x[0] * peak / (peak + 1e-3);
        Ok(libm::log(peak + 1e-3))
    });
    let settings = ImportanceSettings { wanted_error: 0.05, degrees: 1, ..Default::default() };
    let found = importance(&model, &settings, &StreamKey::new(1, "samplers", "plateau"), 0, Some(&[0.0]));
    let found = found.expect("an estimate");
    assert!(found.pareto_k.is_none_or(|k| k > 1.0) && found.work.likelihoods < 4000, "{found:?}");
}

#[test]
#[ignore = "thorough"]
fn samplers_agree_on_inferred_noise_in_a_hierarchy() {
    let model = models::inferred_noise();
    let nuts = nuts_chains(&model, &NutsSettings { draws: 2000, acceptance: 0.95, ..Default::default() });
    let metropolis = metropolis_chains(&model, &MetropolisSettings { draws: 20_000, ..Default::default() });
    let smc = smc_result(&model, &SmcSettings::default()).chains;
    for i in 0..6 {
        let moments = |chains: &Chains| {
            let values = chains.parameter(i);
            let mean = values.iter().flatten().sum::<f64>() / chains.len() as f64;
            (mean, mcse_mean(&values).expect("an error"))
        };
        let (a, a_error) = moments(&nuts);
        for other in [&metropolis, &smc] {
            let (b, b_error) = moments(other);
            assert!((a - b).abs() < 4.0 * (a_error * a_error + b_error * b_error).sqrt(), "{i}: {a} {b}");
        }
    }
    let work = nuts.work();
    // Early trajectories may run out of the numbers; nothing else is refused.
    assert!(
        work.rejections.by_reason.iter().all(|(reason, _)| reason == "the prior density is not finite"),
        "{work:?}"
    );
}

#[test]
fn failing_regions_are_counted_and_cut_out() {
    let model = models::failing();
    // A standard normal cut to -2..1, by its density p and probability P: mean (p(-2) - p(1)) / (P(1) - P(-2)).
    let p = |z: f64| libm::exp(-0.5 * z * z - models::HALF_LN_TAU);
    let (lower, upper, inside) = (p(-2.0), p(1.0), 0.841_344_746_068_542_9 - 0.022_750_131_948_179_2);
    let mean = (lower - upper) / inside;
    let sd = (1.0 + (-2.0 * lower - upper) / inside - mean * mean).sqrt();
    for (name, chains) in every_sampler(&model) {
        check_moments(name, &chains, |draw| draw[0], mean, sd);
        let work = chains.work();
        let count = |reason: &str| work.rejections.by_reason.iter().find(|(r, _)| r == reason).map_or(0, |r| r.1);
        assert!(count("the solver did not converge") > 100, "{name}: {work:?}");
        assert!(count("the log likelihood is not finite") > 10, "{name}: {work:?}");
        assert!(chains.chains.iter().all(|chain| chain.moves.divergences == 0), "{name}");
    }
}

#[test]
fn a_target_that_always_fails_is_an_error_with_its_reason() {
    let model = models::Model::new(vec![models::uniform(0.0, 1.0)], |_, _| {
        Err(bmv::inference::target::Rejected::new("no heat path"))
    });
    let error = nuts::sample(&model, &NutsSettings::default(), &key("nuts"), 0, None).expect_err("no start");
    assert!(error.to_string().contains("no heat path"), "{error}");
    let error = smc::run_island(&model, &SmcSettings::default(), &key("smc"), 0).expect_err("no start");
    assert!(error.to_string().contains("no heat path"), "{error}");
    let settings = NutsSettings { draws: 0, ..Default::default() };
    let error = nuts::sample(&model, &settings, &key("nuts"), 0, None).expect_err("no draws");
    assert_eq!(error.to_string(), "the setting draws is 0; accepted: 1 or more");
}

#[test]
fn a_chain_depends_on_its_index_alone_and_survives_serialisation() {
    let (model, _) = models::conjugate();
    let settings = NutsSettings { warm_up: 100, draws: 50, ..Default::default() };
    let run = |chain| nuts::sample(&model, &settings, &key("nuts"), chain, None).expect("a chain");
    let (second, first, again) = (run(1), run(0), run(1));
    assert_eq!(second, again);
    assert_ne!(first.draws, second.draws);
    let text = serde_json::to_string(&second).expect("serialises");
    let back: Chain = serde_json::from_str(&text).expect("parses");
    assert_eq!(back, second);
    assert_eq!(second.len(), 50);
}

#[test]
#[ignore = "thorough"]
fn work_of_a_fixed_seed_is_kept() {
    let model = models::LinearGaussian::new(4, 12).model();
    let nuts = nuts_chains(&model, &NutsSettings::default());
    let smc = smc_result(&model, &SmcSettings::default());
    let effective: f64 = (0..4)
        .map(|i| bmv::statistics::chain_diagnostics::ess_bulk(&nuts.parameter(i)).expect("a number"))
        .fold(f64::INFINITY, f64::min);
    let gradients = nuts.work().gradients;
    // Kept so that lost efficiency fails a test: gradients, effective draws a thousand gradients, likelihoods.
    println!("{gradients} {effective} {}", smc.chains.work().likelihoods);
    assert!(gradients < 50_000, "{gradients}");
    assert!(1000.0 * effective / gradients as f64 > 80.0, "{effective} of {gradients}");
    assert!(smc.chains.work().likelihoods < 200_000);
}

/// A chain that goes on from any of the states that it left is the same to the bit; the states pass through bytes.
#[test]
fn a_chain_that_goes_on_from_a_state_is_the_same() {
    fn states<S: bmv::job::stored::Block>(every: u64, run: impl Fn(&mut Parts<'_, S>) -> Chain) -> (Chain, Vec<Chain>) {
        let mut kept: Vec<Vec<u8>> = Vec::new();
        let mut keep = |part: u64, state: S| {
            assert_eq!(part, kept.len() as u64 + 1, "states are numbered");
            kept.push(state.into_bytes().expect("bytes"));
        };
        let whole = run(&mut Parts { from: None, every, is_due: &|| true, keep: &mut keep });
        let read = |bytes: &Vec<u8>| S::from_bytes(bytes, "state").expect("reads back");
        let again = |bytes| {
            Parts::none(|parts| {
                parts.from = Some(read(bytes));
                run(parts)
            })
        };
        (whole, kept.iter().map(again).collect())
    }
    let (model, _) = models::conjugate();
    for warm_up in [0, 60, 200] {
        let settings = NutsSettings { warm_up, draws: 90, ..Default::default() };
        let run = |parts: &mut Parts<'_, _>| nuts::sample_in_parts(&model, &settings, &key("nuts"), 1, None, parts);
        let (whole, again) = states(20, |parts| run(parts).expect("a chain"));
        assert_eq!(whole, nuts::sample(&model, &settings, &key("nuts"), 1, None).expect("a chain"));
        assert_eq!(again.len() as u64, (warm_up + 89) / 20);
        assert!(again.iter().all(|own| *own == whole), "warm-up {warm_up}");
    }
    for adapt_throughout in [false, true] {
        let settings = MetropolisSettings { warm_up: 300, draws: 200, thin: 2, adapt_throughout, ..Default::default() };
        let run =
            |parts: &mut Parts<'_, _>| metropolis::sample_in_parts(&model, &settings, &key("walk"), 1, None, parts);
        let (whole, again) = states(70, |parts| run(parts).expect("a chain"));
        assert_eq!(whole, metropolis::sample(&model, &settings, &key("walk"), 1, None).expect("a chain"));
        assert!(again.len() == 9 && again.iter().all(|own| *own == whole), "{adapt_throughout}");
    }
    let normal = NormalApproximation { mode: vec![1.0], covariance: vec![0.5] };
    let settings = IndependenceSettings { warm_up: 10, draws: 60, ..IndependenceSettings::about(normal) };
    let run = |parts: &mut Parts<'_, _>| {
        independence::sample_in_parts(&model, &settings, &key("independence"), 1, None, parts).expect("a chain")
    };
    let (whole, again) = states(30, run);
    assert!(again.len() == 2 && again.iter().all(|own| *own == whole));
}

mod nightly {
    use super::*;

    #[test]
    #[ignore = "nightly: 50 seeds"]
    fn the_stated_errors_of_the_evidence_are_kept() {
        const SEEDS: u64 = 50;
        let (pressed, modes, linear) = (models::pressed(), models::two_modes(), models::LinearGaussian::new(10, 25));
        let (linear_model, linear_evidence) = (linear.model(), linear.exact().2);
        let start = linear.exact().0;
        let of = |smc: SmcResult| (smc.log_evidence, smc.log_evidence_error);
        let sampled = |found: ImportanceEstimate| (found.log_evidence, found.log_evidence_error);
        let settings = ImportanceSettings::default();
        let found = [
            ("islands, linear", by_stated_error(linear_evidence, SEEDS, |key| of(islands(&linear_model, 500, key)))),
            ("islands, pressed", by_stated_error(pressed_evidence(), SEEDS, |key| of(islands(&pressed, 500, key)))),
            ("islands, two modes", by_stated_error(-libm::log(400.0), SEEDS, |key| of(islands(&modes, 500, key)))),
            (
                "importance, linear",
                by_stated_error(linear_evidence, SEEDS, |key| {
                    sampled(importance(&linear_model, &settings, key, 0, Some(start.as_slice())).expect("an estimate"))
                }),
            ),
            (
                "importance, pressed",
                by_stated_error(pressed_evidence(), SEEDS, |key| {
                    sampled(importance(&pressed, &settings, key, 0, Some(&[0.0])).expect("an estimate"))
                }),
            ),
        ];
        for (name, (scale, beyond)) in found {
            println!("{name}: root mean square {scale:.2}, {beyond} of {SEEDS} beyond two");
        }
        // Beyond two lie 5 %: more than 6 of 50 once in 25 runs of one case.
        for (name, (scale, beyond)) in found {
            assert!((0.8..1.2).contains(&scale) && beyond <= 6, "{name}: {scale} {beyond}");
        }
    }

    #[test]
    #[ignore = "nightly: 50 seeds"]
    fn the_stated_errors_of_the_mean_are_kept() {
        let (model, [mean, ..]) = models::conjugate();
        let settings = NutsSettings { warm_up: 300, draws: 500, ..Default::default() };
        let (scale, beyond) = by_stated_error(mean, 50, |key| {
            let chain = |c| nuts::sample(&model, &settings, key, c, None).expect("a chain");
            let chains = collect(&model, (0..4).map(chain).collect());
            let values = chains.parameter(0);
            (values.iter().flatten().sum::<f64>() / chains.len() as f64, mcse_mean(&values).expect("an error"))
        });
        println!("chains: root mean square {scale:.2}, {beyond} of 50 beyond two");
        assert!((0.8..1.2).contains(&scale) && beyond <= 6, "{scale} {beyond}");
    }
}
