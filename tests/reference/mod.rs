//! Results against stored references made by other programs.

mod arviz;
mod nist;
mod posteriordb;

use bmv::math::special::beta_quantile;
use bmv::statistics::chain_diagnostics::ess_quantile;
use bmv::statistics::quantile::sorted;

/// Monte Carlo standard error of a quantile (`probability` within 0 to 1): half the spread between the order statistics
/// at the one-sigma limits of the beta distribution with the quantile's effective sample size.
fn mcse_quantile(chains: &[Vec<f64>], probability: f64) -> Option<f64> {
    let ess = ess_quantile(chains, probability)?;
    let draws = sorted(&chains.concat());
    let size = draws.len() as f64;
    let (a, b) = (ess * probability + 1.0, ess * (1.0 - probability) + 1.0);
    let low = (beta_quantile(0.158_655_3, a, b) * size - 1.0).max(0.0).floor();
    let high = (beta_quantile(0.841_344_7, a, b) * size - 1.0).min(size - 1.0).ceil();
    Some(0.5 * (draws[high as usize] - draws[low as usize]))
}
