//! Draws of the hyperparameters from their posterior, by trajectories along the exact gradient of the marginal likelihood.
//!
//! What few values leave open of a length or a variance widens what is expected between and beyond them; the hyperparameters
//! of the highest likelihood alone leave that out. Priors are normal in the logarithms, cut at the bounds of the search: wide
//! round the usual start ([`Search::usual`]).

use super::fit::Search;
use super::marginal::{Factored, with_gradient};
use super::{Form, Training};
use crate::inference::sampler::chains::SampleError;
use crate::inference::sampler::nuts::{self, NutsSettings};
use crate::inference::target::{Rejected, Target};
use crate::random::{Distribution, StreamKey};
use crate::statistics::chain_diagnostics::r_hat;

/// Chains.
const CHAINS: u64 = 4;
/// Transitions of a chain that adapt.
const WARM_UP: u64 = 200;
/// Draws of a chain.
const DRAWS: u64 = 100;
/// Draws kept of all chains.
const KEPT: usize = 40;
/// Standard deviation of the prior of a variance's logarithm.
const VARIANCE_SD: f64 = 1.5;
/// Standard deviation of the prior of a length's logarithm.
const LENGTH_SD: f64 = 1.0;
/// Standard deviation of the prior of the scatter's logarithm.
const SCATTER_SD: f64 = 2.0;

/// Draws of hyperparameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampled {
    /// Draws, each the logarithms that [`Form::hyperparameters`] names.
    pub draws: Vec<Vec<f64>>,
    /// Largest R-hat; `None` where it has no value.
    pub r_hat: Option<f64>,
}

struct Hyperparameters<'t> {
    training: &'t Training,
    form: Form,
    names: Vec<String>,
    priors: Vec<Distribution>,
}

impl Target for Hyperparameters<'_> {
    type Workspace = ();

    fn names(&self) -> &[String] {
        &self.names
    }

    fn priors(&self) -> &[Distribution] {
        &self.priors
    }

    fn workspace(&self) {}

    fn log_likelihood(&self, parameters: &[f64], (): &mut ()) -> Result<f64, Rejected> {
        let factored = Factored::new(self.training, &self.form, parameters);
        factored.map(|factored| factored.log_likelihood()).map_err(|error| Rejected::new(error.to_string()))
    }

    fn log_likelihood_gradient(&self, parameters: &[f64], (): &mut (), gradient: &mut [f64]) -> Result<f64, Rejected> {
        with_gradient(self.training, &self.form, parameters, gradient).map_err(|error| Rejected::new(error.to_string()))
    }
}

/// Draws of the hyperparameters; each chain begins at the fitted ones.
///
/// # Errors
/// What the sampler gives.
pub fn sample(training: &Training, form: &Form, fitted: &[f64], key: &StreamKey) -> Result<Sampled, SampleError> {
    let search = Search::usual(training, form, 0);
    let lengths = if form.kernel.is_some() { training.inputs() } else { 0 };
    let sd = |place: usize| match place {
        0 if form.kernel.is_some() => VARIANCE_SD,
        place if place <= lengths && form.kernel.is_some() => LENGTH_SD,
        _ => SCATTER_SD,
    };
    let priors = (search.bounds.iter().zip(&search.start).enumerate()).map(|(place, ([lower, upper], mean))| {
        Distribution::Normal { mean: *mean, sd: sd(place), lower: Some(*lower), upper: Some(*upper) }
    });
    let names = (0..search.start.len()).map(|place| format!("hyperparameter {place}")).collect();
    let target = Hyperparameters { training, form: *form, names, priors: priors.collect() };
    let settings = NutsSettings { warm_up: WARM_UP, draws: DRAWS, ..NutsSettings::default() };
    let inside: Vec<f64> = (fitted.iter().zip(&search.bounds))
        .map(|(value, [lower, upper])| {
            let margin = 1e-3 * (upper - lower);
            value.clamp(lower + margin, upper - margin)
        })
        .collect();
    let chains = (0..CHAINS)
        .map(|chain| nuts::sample(&target, &settings, key, chain, Some(&inside)))
        .collect::<Result<Vec<_>, _>>()?;
    let of_parameter = |place: usize| -> Vec<Vec<f64>> { chains.iter().map(|chain| chain.parameter(place)).collect() };
    let values: Vec<Option<f64>> = (0..search.start.len()).map(|place| r_hat(&of_parameter(place))).collect();
    let all: Vec<&[f64]> = chains.iter().flat_map(|chain| (0..chain.len()).map(|i| chain.draw(i))).collect();
    let draws = (0..KEPT.min(all.len())).map(|k| all[k * all.len() / KEPT.min(all.len())].to_vec()).collect();
    let largest = values.iter().try_fold(0.0, |most: f64, value| value.map(|value| most.max(value)));
    Ok(Sampled { draws, r_hat: largest })
}
