//! Summaries of weighted draws.

use super::output::KeptDraws;
use crate::inference::sampler::chains::Chains;

/// Draws of all chains with a weight each, which sum to one.
pub struct Weighted<'a> {
    chains: &'a Chains,
    /// Weight of a draw, by chain.
    weights: Vec<f64>,
}

impl<'a> Weighted<'a> {
    /// Every draw of a chain has the chain's weight; equal weights if none are given.
    pub fn new(chains: &'a Chains, of_chains: Option<&[f64]>) -> Self {
        let mut weights: Vec<f64> = (chains.chains.iter().enumerate())
            .map(|(index, chain)| {
                of_chains.and_then(|all| all.get(index)).copied().unwrap_or(1.0) / chain.len().max(1) as f64
            })
            .collect();
        let all =
            chains.chains.iter().zip(&weights).flat_map(|(chain, weight)| std::iter::repeat_n(weight, chain.len()));
        let total: f64 = all.sum();
        for weight in &mut weights {
            *weight /= total;
        }
        Self { chains, weights }
    }

    /// Draws of a parameter with their weights.
    fn values(&self, parameter: usize) -> impl Iterator<Item = (f64, f64)> {
        self.chains.chains.iter().zip(&self.weights).flat_map(move |(chain, &weight)| {
            chain.draws.iter().skip(parameter).step_by(chain.dimension.max(1)).map(move |&value| (value, weight))
        })
    }

    /// Mean of a parameter.
    pub fn mean(&self, parameter: usize) -> f64 {
        self.values(parameter).map(|(x, w)| x * w).sum()
    }

    /// Covariance of two parameters.
    pub fn covariance(&self, first: usize, second: usize) -> f64 {
        let (a, b) = (self.mean(first), self.mean(second));
        self.values(first).zip(self.values(second)).map(|((x, w), (y, _))| w * (x - a) * (y - b)).sum()
    }

    /// Quantiles of a parameter: the smallest draws below which lies at least that share of the weight.
    pub fn quantiles(&self, parameter: usize, shares: &[f64]) -> Vec<f64> {
        let mut pairs: Vec<(f64, u32)> = Vec::with_capacity(self.chains.len());
        for (index, chain) in (0..).zip(&self.chains.chains) {
            let column = chain.draws.iter().skip(parameter).step_by(chain.dimension.max(1));
            pairs.extend(column.map(|&value| (value, index)));
        }
        // Draws of one chain weigh the same, so that only the order of equal draws of different chains is to be kept.
        pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        shares
            .iter()
            .map(|share| {
                let mut below = 0.0;
                pairs
                    .iter()
                    .find(|(_, chain)| {
                        below += self.weights[*chain as usize];
                        below >= *share
                    })
                    .or(pairs.last())
                    .map_or(f64::NAN, |pair| pair.0)
            })
            .collect()
    }

    /// Correlations of all parameters.
    pub fn correlations(&self, count: usize) -> Vec<Vec<f64>> {
        let covariance: Vec<Vec<f64>> =
            (0..count).map(|i| (0..count).map(|j| self.covariance(i, j)).collect()).collect();
        let correlation = |i: usize, j: usize| {
            let size = (covariance[i][i] * covariance[j][j]).sqrt();
            if i == j {
                1.0
            } else if size > 0.0 {
                (covariance[i][j] / size).clamp(-1.0, 1.0)
            } else {
                0.0
            }
        };
        (0..count).map(|i| (0..count).map(|j| correlation(i, j)).collect()).collect()
    }

    /// At most `most` draws, evenly spaced in cumulated weight.
    pub fn kept(&self, most: usize) -> KeptDraws {
        let all = self.chains.len();
        let count = most.min(all);
        let mut places = (self.chains.chains.iter().enumerate())
            .flat_map(|(chain, draws)| (0..draws.len()).map(move |draw| (chain, draw)));
        let mut kept = KeptDraws::default();
        let Some(mut place) = places.next() else { return kept };
        let (mut position, mut below) = (0, self.weights[place.0]);
        for k in 0..count {
            let target = (k as f64 + 0.5) / count as f64;
            while below < target && position + 1 < all {
                let Some(next) = places.next() else { break };
                place = next;
                position += 1;
                below += self.weights[place.0];
            }
            let (chain, draw) = place;
            let chain_draws = &self.chains.chains[chain];
            kept.index.push([chain as u64, draw as u64]);
            kept.values.push(chain_draws.draw(draw).to_vec());
            kept.log_likelihoods.push(chain_draws.log_likelihoods[draw]);
        }
        kept
    }
}
