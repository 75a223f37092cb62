//! Convergence of chains: rank-normalised split R-hat, effective sample sizes, and Monte Carlo standard errors
//! (Vehtari, Gelman, Simpson, Carpenter & Buerkner 2021; autocorrelations summed as Geyer 1992).
//!
//! All functions take equally long chains of one quantity. They answer `None` where there is nothing to judge: chains of
//! fewer than four draws, of different lengths, or with a number that is not finite.

use super::monte_carlo::StandardError;
use super::quantile::quantile_sorted;
use crate::math::functions::{ln, sqrt};
use crate::math::special::{beta_quantile, normal_quantile};

/// Probability below one standard deviation under the mean of a normal distribution.
const BELOW_ONE_SIGMA: f64 = 0.158_655_253_931_457_05;
/// Effective draws for a degree of freedom of a standard error. An autocorrelation time summed over a window of `m` lags of
/// `n` draws has the relative variance `2 (2m + 1) / n` (Sokal 1997, section 3), hence `n / (2m + 1)` degrees of freedom; sums
/// end after about five autocorrelation times.
const DRAWS_A_DEGREE: f64 = 10.0;

/// The larger of the rank-normalised split R-hats of the draws and of their distances from the median; `None` also for
/// draws that never change.
pub fn r_hat<C: AsRef<[f64]>>(chains: &[C]) -> Option<f64> {
    let split = split(chains)?;
    let bulk = plain_r_hat(&rank_normalise(&split));
    let median = quantile_sorted(&sorted_draws(&split), 0.5);
    let folded = map(&split, |x| (x - median).abs());
    let tail = plain_r_hat(&rank_normalise(&folded));
    let worse = if tail > bulk { tail } else { bulk };
    worse.is_finite().then_some(worse)
}

/// Effective sample size of the rank-normalised draws: how well the bulk is known.
pub fn ess_bulk<C: AsRef<[f64]>>(chains: &[C]) -> Option<f64> {
    Some(effective(rank_normalise(&split(chains)?)))
}

/// The smaller effective sample size of the 5 % and 95 % quantiles.
pub fn ess_tail<C: AsRef<[f64]>>(chains: &[C]) -> Option<f64> {
    let (low, high) = (ess_quantile(chains, 0.05)?, ess_quantile(chains, 0.95)?);
    Some(if high < low { high } else { low })
}

/// Effective sample size for the mean.
pub fn ess_mean<C: AsRef<[f64]>>(chains: &[C]) -> Option<f64> {
    Some(effective(split(chains)?.into_iter().map(<[f64]>::to_vec).collect()))
}

/// Effective sample size for a quantile (`probability` within 0 to 1).
pub fn ess_quantile<C: AsRef<[f64]>>(chains: &[C], probability: f64) -> Option<f64> {
    let halves = split(chains)?;
    let limit = quantile_sorted(&sorted_draws(chains), probability);
    Some(effective(map(&halves, |x| if x <= limit { 1.0 } else { 0.0 })))
}

/// Monte Carlo standard error of the mean.
pub fn mcse_mean<C: AsRef<[f64]>>(chains: &[C]) -> Option<f64> {
    let ess = ess_mean(chains)?;
    let (_, variance) = mean_and_variance(chains.iter().flat_map(|chain| chain.as_ref().iter().copied()));
    Some((variance / ess).sqrt())
}

/// Monte Carlo standard error of the standard deviation.
pub fn mcse_sd<C: AsRef<[f64]>>(chains: &[C]) -> Option<f64> {
    split(chains)?;
    let count = chains.iter().map(|chain| chain.as_ref().len()).sum::<usize>() as f64;
    let mean = chains.iter().flat_map(|chain| chain.as_ref()).sum::<f64>() / count;
    let squares = map(chains, |x| (x - mean) * (x - mean));
    let ess = ess_mean(&squares)?;
    let variance = squares.iter().flatten().sum::<f64>() / count;
    let fourth = squares.iter().flatten().map(|s| s * s).sum::<f64>() / count;
    Some(((fourth - variance * variance) / ess / variance / 4.0).sqrt())
}

/// Monte Carlo standard error of a quantile (`probability` within 0 to 1): half the spread between the order statistics at
/// the one-sigma limits of the beta distribution with the quantile's effective sample size (Vehtari et al. 2021, section 4.4).
pub fn mcse_quantile<C: AsRef<[f64]>>(chains: &[C], probability: f64) -> Option<f64> {
    let ess = ess_quantile(chains, probability)?;
    let draws = sorted_draws(chains);
    let last = draws.len() as f64 - 1.0;
    let (a, b) = (ess * probability + 1.0, ess * (1.0 - probability) + 1.0);
    let place = |sigma: f64| beta_quantile(sigma, a, b) * draws.len() as f64 - 1.0;
    let low = place(BELOW_ONE_SIGMA).clamp(0.0, last).floor();
    let high = place(1.0 - BELOW_ONE_SIGMA).clamp(0.0, last).ceil();
    Some(0.5 * (draws[high as usize] - draws[low as usize]))
}

/// Error of the mean of a function's values along chains, as [`mcse_mean`], with what it is known by. `weights`, one a chain,
/// are those of independent islands: then the error is that of a ratio of sums over them, from their scatter (Cochran 1977,
/// section 6.4).
pub fn error_of_mean<C: AsRef<[f64]>>(chains: &[C], weights: Option<&[f64]>) -> Option<StandardError> {
    let Some(weights) = weights else {
        return StandardError::new(mcse_mean(chains)?, Some(ess_mean(chains)? / DRAWS_A_DEGREE));
    };
    if weights.len() != chains.len() || split(chains).is_none() {
        return None;
    }
    let total: f64 = weights.iter().sum();
    let means: Vec<f64> =
        chains.iter().map(|chain| chain.as_ref().iter().sum::<f64>() / chain.as_ref().len() as f64).collect();
    let islands = || weights.iter().map(|weight| weight / total).zip(&means);
    let mean: f64 = islands().map(|(weight, mean)| weight * mean).sum();
    let squares: f64 = islands().map(|(weight, own)| weight * weight * (own - mean) * (own - mean)).sum();
    let effective = 1.0 / islands().map(|(weight, _)| weight * weight).sum::<f64>();
    let count = means.len() as f64;
    StandardError::new((squares * count / (count - 1.0)).sqrt(), Some(effective - 1.0))
}

/// Error of the standard deviation, as [`error_of_mean`] of the squared deviations from the mean.
pub fn error_of_sd<C: AsRef<[f64]>>(
    chains: &[C],
    weights: Option<&[f64]>,
    mean: f64,
    sd: f64,
) -> Option<StandardError> {
    let error = error_of_mean(&map(chains, |x| (x - mean) * (x - mean)), weights)?;
    StandardError::new(error.standard_error / (2.0 * sd), error.degrees_of_freedom)
}

/// Error of the covariance of two quantities, as [`error_of_mean`] of the products of their deviations from the means.
pub fn error_of_covariance<C: AsRef<[f64]>>(
    chains: [&[C]; 2],
    weights: Option<&[f64]>,
    means: [f64; 2],
) -> Option<StandardError> {
    let pairs = chains[0].iter().zip(chains[1]);
    let products: Vec<Vec<f64>> = pairs
        .map(|(a, b)| a.as_ref().iter().zip(b.as_ref()).map(|(a, b)| (a - means[0]) * (b - means[1])).collect())
        .collect();
    error_of_mean(&products, weights)
}

/// Error of a quantile; `quantile` gives that of the (weighted) draws at any probability. Without weights it is
/// [`mcse_quantile`], which rests on the spacing of about `k = 2 sqrt(n p (1 - p))` of the `n` effective draws: a sum of `k`
/// nearly exponential spacings has the relative variance `1/k`, its square `4/k`, so that it has `k/2` degrees of freedom.
pub fn error_of_quantile<C: AsRef<[f64]>>(
    chains: &[C],
    weights: Option<&[f64]>,
    probability: f64,
    quantile: impl Fn(f64) -> f64,
) -> Option<StandardError> {
    if weights.is_none() {
        let ess = ess_quantile(chains, probability)?;
        let of_spacing = sqrt(ess * probability * (1.0 - probability));
        return StandardError::new(mcse_quantile(chains, probability)?, Some(of_spacing.min(ess / DRAWS_A_DEGREE)));
    }
    let limit = quantile(probability);
    let error = error_of_mean(&map(chains, |x| if x <= limit { 1.0 } else { 0.0 }), weights)?;
    let at = |side: f64| quantile((probability + side * error.standard_error).clamp(0.0, 1.0));
    StandardError::new(0.5 * (at(1.0) - at(-1.0)), error.degrees_of_freedom)
}

/// The first and the last half of each chain; the middle draw of an odd number belongs to neither.
fn split<C: AsRef<[f64]>>(chains: &[C]) -> Option<Vec<&[f64]>> {
    let length = chains.first()?.as_ref().len();
    let sound = |chain: &C| chain.as_ref().len() == length && chain.as_ref().iter().all(|x| x.is_finite());
    if length < 4 || !chains.iter().all(sound) {
        return None;
    }
    let half = length / 2;
    let first = chains.iter().map(|chain| &chain.as_ref()[..half]);
    let last = chains.iter().map(|chain| &chain.as_ref()[length - half..]);
    Some(first.chain(last).collect())
}

fn map<C: AsRef<[f64]>>(chains: &[C], f: impl Fn(f64) -> f64) -> Vec<Vec<f64>> {
    chains.iter().map(|chain| chain.as_ref().iter().map(|&x| f(x)).collect()).collect()
}

fn sorted_draws<C: AsRef<[f64]>>(chains: &[C]) -> Vec<f64> {
    let mut all = Vec::with_capacity(chains.iter().map(|chain| chain.as_ref().len()).sum());
    chains.iter().for_each(|chain| all.extend_from_slice(chain.as_ref()));
    all.sort_by(f64::total_cmp);
    all
}

/// Mean and variance (divisor count - 1), in two passes.
fn mean_and_variance(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let (mut count, mut sum) = (0.0, 0.0);
    for value in values.clone() {
        count += 1.0;
        sum += value;
    }
    let mean = sum / count;
    let squares: f64 = values.map(|x| (x - mean) * (x - mean)).sum();
    (mean, squares / (count - 1.0))
}

/// Normal quantiles of the ranks among all chains, equal draws sharing their mean rank (Blom's 3/8).
fn rank_normalise<C: AsRef<[f64]>>(chains: &[C]) -> Vec<Vec<f64>> {
    let length = chains[0].as_ref().len();
    let count = length * chains.len();
    let at = |place: u32| chains[place as usize / length].as_ref()[place as usize % length];
    // Chains of 2^32 draws do not fit into memory.
    let mut order: Vec<u32> = (0..u32::try_from(count).unwrap_or(u32::MAX)).collect();
    // Equal draws share a score, so that their order does not matter.
    order.sort_unstable_by(|&a, &b| at(a).total_cmp(&at(b)));
    let mut scores = vec![vec![0.0; length]; chains.len()];
    let mut first = 0;
    while first < order.len() {
        let mut last = first;
        while last + 1 < order.len() && at(order[last + 1]) == at(order[first]) {
            last += 1;
        }
        let rank = 0.5 * (first + last) as f64 + 1.0;
        let score = normal_quantile((rank - 0.375) / (count as f64 + 0.25));
        for &place in &order[first..=last] {
            scores[place as usize / length][place as usize % length] = score;
        }
        first = last + 1;
    }
    scores
}

fn plain_r_hat(chains: &[Vec<f64>]) -> f64 {
    let draws = chains[0].len() as f64;
    let moments: Vec<(f64, f64)> = chains.iter().map(|chain| mean_and_variance(chain.iter().copied())).collect();
    let within = moments.iter().map(|m| m.1).sum::<f64>() / moments.len() as f64;
    let (_, between) = mean_and_variance(moments.iter().map(|m| m.0));
    ((draws * between / within + draws - 1.0) / draws).sqrt()
}

/// Effective sample size of chains as they are.
///
/// Autocorrelations are summed in pairs while the pairs stay positive, each pair at most as large as the one before.
/// They are computed lag by lag as far as they are needed.
fn effective(chains: Vec<Vec<f64>>) -> f64 {
    let mut centred = chains;
    let draws = centred[0].len();
    let count = (centred.len() * draws) as f64;
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for &x in centred.iter().flatten() {
        least = least.min(x);
        most = most.max(x);
    }
    if most - least < 1e-15 {
        return count;
    }
    let means: Vec<f64> = centred.iter().map(|chain| chain.iter().sum::<f64>() / draws as f64).collect();
    for (chain, mean) in centred.iter_mut().zip(&means) {
        chain.iter_mut().for_each(|x| *x -= mean);
    }
    // Mean over the chains of the autocovariance at a lag (divisor: number of draws).
    let autocovariance = |lag: usize| {
        let sums = centred.iter().map(|chain| {
            let products: f64 = chain.iter().zip(&chain[lag..]).map(|(a, b)| a * b).sum();
            products / draws as f64
        });
        sums.sum::<f64>() / centred.len() as f64
    };
    let within = autocovariance(0) * draws as f64 / (draws as f64 - 1.0);
    let mut variance = within * (draws as f64 - 1.0) / draws as f64;
    if means.len() > 1 {
        variance += mean_and_variance(means.iter().copied()).1;
    }
    let correlation = |lag: usize| 1.0 - (within - autocovariance(lag)) / variance;

    // Sums of the correlations at an even lag and the odd one after it.
    let (mut even, mut odd) = (1.0, correlation(1));
    let mut pairs = vec![even + odd];
    let mut lag = 1;
    while lag + 3 < draws && even + odd > 0.0 {
        even = correlation(lag + 1);
        odd = correlation(lag + 2);
        pairs.push(even + odd);
        lag += 2;
    }
    let mut sum = 0.0;
    let mut bound = f64::INFINITY;
    for &pair in &pairs[..pairs.len() - 1] {
        bound = pair.min(bound);
        sum += bound;
    }
    // The pair that ended the sum gives its even correlation once, if positive: that lowers the estimate's variance.
    let extra = if even > 0.0 || even + odd >= 0.0 { even } else { 0.0 };
    let time = (2.0 * sum - 1.0 + extra).max(core::f64::consts::LN_10 / ln(count));
    count / time
}
