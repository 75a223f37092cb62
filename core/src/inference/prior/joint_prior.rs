//! Draws of several parameters together as a prior that has a density: a multivariate normal distribution of their
//! scores (`score`), held against the draws that it stands for.
//!
//! `z = m + L u` with `u` standard normal, `m` and `L L'` mean and covariance of the draws' scores. The fit is judged by
//! what a user of the density would notice: quantiles of each parameter, and the distribution of the squared Mahalanobis
//! distance `|L^-1 (z - m)|^2`, which is chi-square with as many degrees of freedom as there are parameters (Mardia, Kent
//! & Bibby 1979, section 3.5) and shows what no single parameter does: curved and split posteriors.

use thiserror::Error;

use crate::inference::prior::score::Score;
use crate::inference::prior::transform::TransformError;
use crate::math::cholesky;
use crate::math::functions::ln;
use crate::math::special::{chi_square_cdf, normal_density, normal_quantile};
use crate::random::Distribution;
use crate::statistics::quantile::{quantile_sorted, sorted};

/// Effective draws for each parameter, at least: a covariance from fewer has no meaning.
const LEAST_EFFECTIVE: f64 = 20.0;
/// Probabilities at which quantiles are compared.
const SHARES: [f64; 5] = [0.025, 0.16, 0.5, 0.84, 0.975];
/// Deviations of a quantile, in standard deviations, from which on a warning is given and the density refused, above what
/// sampling explains: with half a standard deviation a 95 % interval is wrong by a quarter of its half width.
const QUANTILE: [f64; 2] = [0.15, 0.5];
/// The same of the distribution function of the Mahalanobis distance.
const DISTANCE: [f64; 2] = [0.05, 0.15];
/// Standard errors that sampling explains.
const ERRORS: f64 = 3.0;
/// The Kolmogorov-Smirnov distance over the root of the number of draws that chance exceeds once in a hundred.
const KOLMOGOROV: f64 = 1.63;

/// The prior of a whitened coordinate.
pub const STANDARD: Distribution = Distribution::Normal { mean: 0.0, sd: 1.0, lower: None, upper: None };

/// Why draws have no density.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum JointPriorError {
    /// A prior without a score.
    #[error(transparent)]
    Transform(#[from] TransformError),
    /// Too few draws.
    #[error(
        "{effective:.0} effective draws of {parameters} parameters are too few for a covariance; give at least {least:.0}"
    )]
    TooFew {
        /// Effective number of draws.
        effective: f64,
        /// Number of parameters.
        parameters: usize,
        /// What is needed.
        least: f64,
    },
    /// Draws that do not vary, or only together.
    #[error("the draws of `{parameter}` do not vary, or follow from those of the parameters before it")]
    Degenerate {
        /// The parameter.
        parameter: String,
    },
    /// Draws that are not normal in their scores.
    #[error(
        "a normal distribution of the scores does not describe these draws: {what}. Calibrate on all data at once from the \
         original priors instead"
    )]
    NotNormal {
        /// What deviates most, in words.
        what: String,
    },
}

/// How well the density describes the draws.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Fit {
    /// Largest deviation of a quantile (2.5, 16, 50, 84, 97.5 %) of each parameter's score, in standard deviations.
    pub quantile_deviation: Vec<f64>,
    /// Largest difference between the distribution function of the squared Mahalanobis distance and the chi-square one.
    pub distance_deviation: f64,
    /// What the reader must know; empty where the fit is good.
    pub doubts: Vec<String>,
}

/// A prior of several unknowns together.
#[derive(Clone, Debug, PartialEq)]
pub struct JointPrior {
    /// Places of the unknowns.
    places: Vec<usize>,
    scores: Vec<Score>,
    mean: Vec<f64>,
    factor: Vec<f64>,
    fit: Fit,
}

impl JointPrior {
    /// From draws (each the values, SI, of the unknowns at `places`), of which `effective` are independent; `base` are the
    /// priors by which the scores are taken, `names` are for messages.
    ///
    /// # Errors
    /// [`JointPriorError`] where no density describes the draws.
    pub fn new(
        places: &[usize],
        names: &[&str],
        base: &[Distribution],
        draws: &[Vec<f64>],
        effective: f64,
    ) -> Result<Self, JointPriorError> {
        let n = places.len();
        let least = LEAST_EFFECTIVE * (n as f64 + 1.0);
        if !(effective >= least) || draws.len() < 2 {
            return Err(JointPriorError::TooFew { effective, parameters: n, least });
        }
        let scores = (0..n)
            .map(|i| Score::new(&base[i], draws.iter().map(|draw| draw[i])))
            .collect::<Result<Vec<Score>, _>>()?;
        let z: Vec<Vec<f64>> =
            scores.iter().enumerate().map(|(i, s)| draws.iter().map(|d| s.of(d[i])).collect()).collect();
        let count = draws.len() as f64;
        let mean: Vec<f64> = z.iter().map(|column| column.iter().sum::<f64>() / count).collect();
        let mut factor = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                let sum: f64 = z[i].iter().zip(&z[j]).map(|(a, b)| (a - mean[i]) * (b - mean[j])).sum();
                factor[i * n + j] = sum / (count - 1.0);
            }
        }
        let variances: Vec<f64> = (0..n).map(|i| factor[i * n + i]).collect();
        let degenerate = |i: usize| JointPriorError::Degenerate { parameter: names[i].to_owned() };
        // What rounding leaves of a variance that is none.
        if let Some(i) = (0..n).find(|&i| !(variances[i] > 1e-20 * (1.0 + mean[i] * mean[i]))) {
            return Err(degenerate(i));
        }
        cholesky::factor(&mut factor, n).map_err(|error| degenerate(error.index))?;
        // What rounding leaves of a variance that is none.
        if let Some(i) = (0..n).find(|&i| !(factor[i * n + i] > 1e-6 * variances[i].sqrt())) {
            return Err(degenerate(i));
        }
        let fit = judge(names, &z, &mean, &variances, &factor, effective.min(count))?;
        Ok(Self { places: places.to_vec(), scores, mean, factor, fit })
    }

    /// Places of the unknowns.
    pub fn places(&self) -> &[usize] {
        &self.places
    }

    /// How well the draws are described.
    pub fn fit(&self) -> &Fit {
        &self.fit
    }

    /// The unknowns (SI) and the slopes of each by its score, at whitened coordinates `u`.
    pub fn at(&self, whitened: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut z = vec![0.0; whitened.len()];
        cholesky::multiply(&self.factor, whitened, &mut z);
        let scored = self.scores.iter().zip(z.iter().zip(&self.mean)).map(|(score, (z, mean))| score.at(z + mean));
        scored.map(|scored| (scored.value, scored.slope)).unzip()
    }

    /// The whitened coordinates of unknowns (SI).
    pub fn whitened(&self, unknowns: &[f64]) -> Vec<f64> {
        let scores = self.scores.iter().zip(unknowns);
        let mut z: Vec<f64> = scores.zip(&self.mean).map(|((score, value), mean)| score.of(*value) - mean).collect();
        cholesky::solve_lower(&self.factor, &mut z);
        z
    }

    /// Turns derivatives by the unknowns into derivatives by the whitened coordinates, in place: `g_u = L' (slope g_x)`.
    #[inline]
    pub fn pull_back(&self, slopes: &[f64], derivatives: &mut [f64]) {
        let n = slopes.len();
        for (derivative, slope) in derivatives.iter_mut().zip(slopes) {
            *derivative *= slope;
        }
        for j in 0..n {
            let mut sum = 0.0;
            for i in j..n {
                sum += self.factor[i * n + j] * derivatives[i];
            }
            derivatives[j] = sum;
        }
    }

    /// Derivatives of the unknowns by the whitened coordinates (`n x n`, row after row), given the slopes.
    pub fn derivatives(&self, slopes: &[f64]) -> Vec<f64> {
        let n = slopes.len();
        let entry = |i: usize, j: usize| if j <= i { slopes[i] * self.factor[i * n + j] } else { 0.0 };
        (0..n).flat_map(|i| (0..n).map(move |j| entry(i, j))).collect()
    }

    /// Logarithm of the determinant of those derivatives.
    pub fn log_slope(&self, slopes: &[f64]) -> f64 {
        let n = slopes.len();
        slopes.iter().map(|slope| ln(slope.abs())).sum::<f64>() + 0.5 * cholesky::log_determinant(&self.factor, n)
    }
}

/// The unknowns (SI) at coordinates of which some are whitened by these joint priors, and each prior's slopes there.
pub fn unknowns_at(joint: &[JointPrior], coordinates: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
    let mut unknowns = coordinates.to_vec();
    let mut all = Vec::with_capacity(joint.len());
    for prior in joint {
        let whitened: Vec<f64> = prior.places.iter().map(|&place| coordinates[place]).collect();
        let (values, slopes) = prior.at(&whitened);
        for (&place, value) in prior.places.iter().zip(values) {
            unknowns[place] = value;
        }
        all.push(slopes);
    }
    (unknowns, all)
}

/// Turns derivatives by the unknowns into derivatives by such coordinates, in place.
pub fn pull_back(joint: &[JointPrior], slopes: &[Vec<f64>], derivatives: &mut [f64]) {
    for (prior, slopes) in joint.iter().zip(slopes) {
        let mut part: Vec<f64> = prior.places.iter().map(|&place| derivatives[place]).collect();
        prior.pull_back(slopes, &mut part);
        for (&place, value) in prior.places.iter().zip(part) {
            derivatives[place] = value;
        }
    }
}

/// Holds the normal distribution against the scores of the draws.
fn judge(
    names: &[&str],
    z: &[Vec<f64>],
    mean: &[f64],
    variances: &[f64],
    factor: &[f64],
    effective: f64,
) -> Result<Fit, JointPriorError> {
    let n = z.len();
    let mut fit = Fit { quantile_deviation: Vec::new(), distance_deviation: 0.0, doubts: Vec::new() };
    let mut refused = None;
    for (i, column) in z.iter().enumerate() {
        let column = sorted(column);
        let mut largest: f64 = 0.0;
        // By how much what sampling explains is exceeded, with the words for it.
        let mut worst: Option<(f64, String)> = None;
        for share in SHARES {
            let normal = normal_quantile(share);
            let deviation = (quantile_sorted(&column, share) - mean[i]) / variances[i].sqrt() - normal;
            let error = (share * (1.0 - share) / effective).sqrt() / normal_density(normal);
            let excess = deviation.abs() - ERRORS * error;
            largest = largest.max(deviation.abs());
            if worst.as_ref().is_none_or(|(most, _)| excess > *most) {
                let percent = 100.0 * share;
                let text =
                    format!("the {percent} % quantile of `{}` is off by {deviation:.2} standard deviations", names[i]);
                worst = Some((excess, text));
            }
        }
        fit.quantile_deviation.push(largest);
        if let Some((excess, text)) = worst {
            note(excess, QUANTILE, text, &mut fit.doubts, &mut refused);
        }
    }
    let count = z.first().map_or(0, Vec::len);
    let distances: Vec<f64> = (0..count)
        .map(|k| {
            let mut u: Vec<f64> = (0..n).map(|i| z[i][k] - mean[i]).collect();
            cholesky::solve_lower(factor, &mut u);
            u.iter().map(|u| u * u).sum()
        })
        .collect();
    for (rank, distance) in sorted(&distances).iter().enumerate() {
        let expected = chi_square_cdf(*distance, n as f64);
        let (below, above) = (rank as f64 / count as f64, (rank + 1) as f64 / count as f64);
        fit.distance_deviation = fit.distance_deviation.max((expected - below).abs()).max((expected - above).abs());
    }
    let text = format!(
        "the squared distances of the draws from their mean are not chi-square (largest difference of the distribution \
         functions {:.2})",
        fit.distance_deviation
    );
    let excess = fit.distance_deviation - KOLMOGOROV / effective.sqrt();
    note(excess, DISTANCE, text, &mut fit.doubts, &mut refused);
    match refused {
        Some(what) => Err(JointPriorError::NotNormal { what }),
        None => Ok(fit),
    }
}

fn note(
    excess: f64,
    [doubtful, wrong]: [f64; 2],
    text: String,
    doubts: &mut Vec<String>,
    refused: &mut Option<String>,
) {
    if !(excess <= wrong) {
        refused.get_or_insert(text);
    } else if excess > doubtful {
        doubts.push(text);
    }
}
