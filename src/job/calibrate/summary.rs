//! Summaries of weighted draws.

use super::output::KeptDraws;
use crate::inference::chains::Chains;

/// Draws of all chains with a weight each, which sum to one.
pub(super) struct Weighted<'a> {
    chains: &'a Chains,
    weights: Vec<f64>,
}

impl<'a> Weighted<'a> {
    /// Every draw of a chain has the chain's weight; equal weights if none are given.
    pub fn new(chains: &'a Chains, of_chains: Option<&[f64]>) -> Self {
        let mut weights = Vec::with_capacity(chains.len());
        for (index, chain) in chains.chains.iter().enumerate() {
            let own = of_chains.and_then(|all| all.get(index)).copied().unwrap_or(1.0);
            weights.extend(std::iter::repeat_n(own / chain.len().max(1) as f64, chain.len()));
        }
        let total: f64 = weights.iter().sum();
        for weight in &mut weights {
            *weight /= total;
        }
        Self { chains, weights }
    }

    fn values(&self, parameter: usize) -> Vec<f64> {
        self.chains.chains.iter().flat_map(|chain| chain.parameter(parameter)).collect()
    }

    /// Mean of a parameter.
    pub fn mean(&self, parameter: usize) -> f64 {
        self.values(parameter).iter().zip(&self.weights).map(|(x, w)| x * w).sum()
    }

    /// Covariance of two parameters.
    pub fn covariance(&self, first: usize, second: usize) -> f64 {
        let (a, b) = (self.mean(first), self.mean(second));
        let pairs = self.values(first).into_iter().zip(self.values(second));
        pairs.zip(&self.weights).map(|((x, y), w)| w * (x - a) * (y - b)).sum()
    }

    /// Quantiles of a parameter: the smallest draws below which lies at least that share of the weight.
    pub fn quantiles(&self, parameter: usize, shares: &[f64]) -> Vec<f64> {
        let mut pairs: Vec<(f64, f64)> = self.values(parameter).into_iter().zip(self.weights.iter().copied()).collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        shares
            .iter()
            .map(|share| {
                let mut below = 0.0;
                pairs
                    .iter()
                    .find(|(_, weight)| {
                        below += weight;
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
        let places: Vec<(usize, usize)> = (self.chains.chains.iter().enumerate())
            .flat_map(|(chain, own)| (0..own.len()).map(move |draw| (chain, draw)))
            .collect();
        let count = most.min(places.len());
        let mut kept = KeptDraws::default();
        let (mut place, mut below) = (0, self.weights.first().copied().unwrap_or(0.0));
        for k in 0..count {
            let target = (k as f64 + 0.5) / count as f64;
            while below < target && place + 1 < places.len() {
                place += 1;
                below += self.weights[place];
            }
            let (chain, draw) = places[place];
            let own = &self.chains.chains[chain];
            kept.index.push([chain as u64, draw as u64]);
            kept.values.push(own.draw(draw).to_vec());
            kept.log_likelihoods.push(own.log_likelihoods[draw]);
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::chains::Chain;

    fn chains() -> Chains {
        let chain = |from: f64| Chain {
            dimension: 2,
            draws: (0..4).flat_map(|k| [from + f64::from(k), -2.0 * (from + f64::from(k))]).collect(),
            log_priors: vec![0.0; 4],
            log_likelihoods: (0..4).map(f64::from).collect(),
            ..Chain::default()
        };
        Chains { names: vec!["a".into(), "b".into()], chains: vec![chain(0.0), chain(10.0)] }
    }

    #[test]
    fn weights_of_chains_weigh_their_draws() {
        let chains = chains();
        let equal = Weighted::new(&chains, None);
        assert!((equal.mean(0) - 6.5).abs() < 1e-12);
        let first = Weighted::new(&chains, Some(&[1.0, 0.0]));
        assert!((first.mean(0) - 1.5).abs() < 1e-12);
        assert!((first.covariance(0, 0) - 1.25).abs() < 1e-12, "0, 1, 2, 3");
        assert_eq!(first.correlations(2), [[1.0, -1.0], [-1.0, 1.0]]);
        assert_eq!(first.quantiles(0, &[0.5, 1.0]), [1.0, 3.0]);
        assert_eq!(first.kept(2).index, [[0, 0], [0, 2]]);
        assert_eq!(equal.kept(100).values.len(), 8);
        assert_eq!(equal.kept(100).values[5], [11.0, -22.0]);
    }
}
