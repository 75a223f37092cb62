//! Draws of the hyperparameters from their posterior, by trajectories along the exact gradient of the marginal likelihood.
//!
//! What few values leave open of a length or a variance widens what is expected between and beyond them; the hyperparameters
//! of the highest likelihood alone leave that out. Priors are normal in the logarithms: where nothing else is known wide round
//! the usual start ([`Search::usual`]) and cut at the bounds of the search.

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

/// Logarithms beyond so many standard deviations of a prior that is known beforehand are cut off.
const CUT_SDS: f64 = 6.0;

/// What is known of hyperparameters beforehand: mean and standard deviation of their logarithms, in the units of values and
/// points.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Beforehand {
    /// Of the smooth part's variance.
    pub variance: Option<[f64; 2]>,
    /// Of its length in each input; may be shorter.
    pub lengths: Vec<Option<[f64; 2]>>,
    /// Of the scatter's variance.
    pub scatter: Option<[f64; 2]>,
}

/// Priors of the hyperparameters (logarithms): what is known beforehand, else the usual ones.
pub fn priors(training: &Training, form: &Form, beforehand: &Beforehand) -> Vec<Distribution> {
    let search = Search::usual(training, form, 0);
    let lengths = if form.kernel.is_some() { training.inputs() } else { 0 };
    let of = |place: usize| match place {
        0 if form.kernel.is_some() => (VARIANCE_SD, beforehand.variance),
        place if place <= lengths && form.kernel.is_some() => {
            (LENGTH_SD, beforehand.lengths.get(place - 1).copied().flatten())
        }
        _ => (SCATTER_SD, beforehand.scatter),
    };
    let prior = |(place, ([lower, upper], mean)): (usize, (&[f64; 2], &f64))| match of(place) {
        (_, Some([mean, sd])) => {
            let (lower, upper) = (mean - CUT_SDS * sd, mean + CUT_SDS * sd);
            Distribution::Normal { mean, sd, lower: Some(lower), upper: Some(upper) }
        }
        (sd, None) => Distribution::Normal { mean: *mean, sd, lower: Some(*lower), upper: Some(*upper) },
    };
    search.bounds.iter().zip(&search.start).enumerate().map(prior).collect()
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

/// Draws of the hyperparameters under these priors; each chain begins at the fitted ones.
///
/// # Errors
/// What the sampler gives.
pub fn sample(
    training: &Training,
    form: &Form,
    priors: Vec<Distribution>,
    fitted: &[f64],
    key: &StreamKey,
) -> Result<Sampled, SampleError> {
    let inside: Vec<f64> = (fitted.iter().zip(&priors))
        .map(|(value, prior)| {
            let (lower, upper) = prior.support();
            let margin = 1e-3 * (upper - lower);
            value.clamp(lower + margin, upper - margin)
        })
        .collect();
    let names = (0..priors.len()).map(|place| format!("hyperparameter {place}")).collect();
    let target = Hyperparameters { training, form: *form, names, priors };
    let settings = NutsSettings { warm_up: WARM_UP, draws: DRAWS, ..NutsSettings::default() };
    let chains = (0..CHAINS)
        .map(|chain| nuts::sample(&target, &settings, key, chain, Some(&inside)))
        .collect::<Result<Vec<_>, _>>()?;
    let of_parameter = |place: usize| -> Vec<Vec<f64>> { chains.iter().map(|chain| chain.parameter(place)).collect() };
    let values: Vec<Option<f64>> = (0..inside.len()).map(|place| r_hat(&of_parameter(place))).collect();
    let all: Vec<&[f64]> = chains.iter().flat_map(|chain| (0..chain.len()).map(|i| chain.draw(i))).collect();
    let draws = (0..KEPT.min(all.len())).map(|k| all[k * all.len() / KEPT.min(all.len())].to_vec()).collect();
    let largest = values.iter().try_fold(0.0, |most: f64, value| value.map(|value| most.max(value)));
    Ok(Sampled { draws, r_hat: largest })
}
