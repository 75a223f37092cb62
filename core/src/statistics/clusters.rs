//! What samples are worth that share something, such as the draw of a posterior that each was computed from.
//!
//! With clusters of `m` samples each and intraclass correlation `rho`, the variance of a mean is that of independent
//! samples times the design effect `1 + (m - 1) rho` (Kish 1965, section 5.4). `rho` is estimated by the analysis of
//! variance of one way (Donner 1986, equation 2.2).

/// Samples by cluster.
#[derive(Clone, Debug, PartialEq)]
pub struct Clusters {
    /// Cluster of each sample.
    pub of: Vec<usize>,
    /// Number of clusters.
    pub count: usize,
    /// How many independent clusters they are worth, at most `count`.
    pub effective: f64,
}

impl Clusters {
    /// Intraclass correlation of values (one a sample; those that are not finite are left out), 0 to 1. 1 where it cannot
    /// be computed: values that do not vary, or no cluster with two samples.
    pub fn correlation(&self, values: &[f64]) -> f64 {
        let mut sums = vec![(0.0, 0.0); self.count];
        let (mut total, mut number) = (0.0, 0.0);
        for (&cluster, value) in self.of.iter().zip(values).filter(|(_, value)| value.is_finite()) {
            sums[cluster].0 += value;
            sums[cluster].1 += 1.0;
            total += value;
            number += 1.0;
        }
        let groups = sums.iter().filter(|(_, size)| *size > 0.0).count() as f64;
        if groups < 2.0 || number <= groups {
            return 1.0;
        }
        let mean = total / number;
        let mut within = 0.0;
        for (&cluster, value) in self.of.iter().zip(values).filter(|(_, value)| value.is_finite()) {
            let cluster_mean = sums[cluster].0 / sums[cluster].1;
            within += (value - cluster_mean) * (value - cluster_mean);
        }
        let (mut between, mut squares) = (0.0, 0.0);
        for (sum, size) in sums.iter().filter(|(_, size)| *size > 0.0) {
            between += size * (sum / size - mean) * (sum / size - mean);
            squares += size * size;
        }
        let (between, within) = (between / (groups - 1.0), within / (number - groups));
        let size = (number - squares / number) / (groups - 1.0);
        let correlation = (between - within) / (between + (size - 1.0) * within);
        if correlation.is_finite() { correlation.clamp(0.0, 1.0) } else { 1.0 }
    }

    /// The design effect on the variance of the values' mean, at least 1.
    pub fn design_effect(&self, values: &[f64]) -> f64 {
        let size = values.len() as f64 / self.effective.max(1.0);
        1.0 + (size - 1.0).max(0.0) * self.correlation(values)
    }
}

/// How many independent samples values are worth that lie in clusters of several kinds; their number without any.
pub fn effective_samples(clusters: &[Clusters], values: &[f64]) -> f64 {
    let effect: f64 = clusters.iter().map(|kind| kind.design_effect(values) - 1.0).sum();
    values.len() as f64 / (1.0 + effect)
}
