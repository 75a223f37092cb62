//! Whether one effect, or small ones everywhere, explain a misfit.
//!
//! A model that is a little wrong everywhere leaves errors that are sums of many small effects, and one large effect fits such
//! a sum better than noise allows by chance. So an effect of the selected set is weighed beside a random sum of all kinds of
//! effects at all places, as association studies weigh one gene beside the small contributions of all others (the mixed
//! model of Kang et al. 2008, Genetics 178, 1709; its likelihood by one eigendecomposition: Lippert et al. 2011, Nature Methods
//! 8, 833). With the whitened residuals `y` of the set without the effect, `g` what it changes of them, and `K` the mean of
//! `k k'` over the directions `k` of other effects, all of length 1 and orthogonal to the free parameters,
//!
//! `y ~ N(0, I + t K)` without it, `y ~ N(0, I + t K + g g')` with it,
//!
//! each with its most likely `t >= 0`.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, SymmetricEigen};

use crate::diagnosis::engine::Diagnosis;
use crate::diagnosis::linearisation::linear::Linear;
use crate::diagnosis::linearisation::signature;
use crate::diagnosis::odds::prior_odds::PriorOdds;
use crate::diagnosis::screening::score::SMALLEST_SHARE;
use crate::diagnosis::verdict::findings::Findings;
use crate::diagnosis::verdict::small_effects::IS_MODEL_ERROR;
use crate::diagnosis::{FitError, PRIOR_OF, Refit};
use crate::effect::Effect;
use crate::inference::estimate::natural::NaturalObjective;
use crate::inference::likelihood::Likelihood;
use crate::math::dense::dot_of_columns as dot;
use crate::math::functions::{exp, ln, sqrt};
use crate::math::scalar_products::{orthonormal, products, products_of_all, project_out, remainders};

/// Effects of which the random sum is made.
const MOST_OTHERS: usize = 300;
/// Sizes `t` that are tried beside 0, on a logarithmic scale.
const SIZES: usize = 40;
const SMALLEST: f64 = 1e-1;
const LARGEST: f64 = 1e8;
/// Effective dimensions of the random sum below which it is no sum of many: what few directions hold may be one effect.
const LEAST_DIMENSIONS: f64 = 4.0;
/// A column whose remainder is shorter than this share of it depends on the others.
const DEPENDENT: f64 = 1e-9;
/// Share of the largest eigenvalue below which one is 0.
const NO_EIGENVALUE: f64 = 1e-10;

/// Errors of the kinds of the catalogue, everywhere and small.
pub struct Everywhere {
    /// The directions `k`, of length 1.
    columns: Vec<Vec<f64>>,
    /// Eigenvalues of `K`.
    values: Vec<f64>,
    /// Its eigenvectors, one after the other, as coefficients of the directions: written out by rows they would take as much memory
    /// as these, and far more time.
    vectors: Vec<f64>,
}

/// A column in the eigenvectors, and the square of what is left of it.
struct Seen {
    along: Vec<f64>,
    rest: f64,
}

impl Everywhere {
    /// Of directions of one length, column by column, that are orthogonal to the free parameters.
    pub fn new(columns: Vec<Vec<f64>>) -> Self {
        let count = columns.len();
        if count == 0 {
            // A study may name curves alone; the decomposition knows no empty matrix.
            return Self { columns, values: Vec::new(), vectors: Vec::new() };
        }
        let products = products_of_all(&columns);
        let gram = DMatrix::from_fn(count, count, |i, k| products[i.max(k)][i.min(k)] / count as f64);
        let eigen = SymmetricEigen::new(gram);
        let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
        let (mut values, mut vectors) = (Vec::new(), Vec::new());
        for (place, &value) in
            eigen.eigenvalues.iter().enumerate().filter(|(_, value)| **value > NO_EIGENVALUE * largest)
        {
            let scale = 1.0 / sqrt(value * count as f64);
            values.push(value);
            vectors.extend((0..count).map(|k| scale * eigen.eigenvectors[(k, place)]));
        }
        Self { columns, values, vectors }
    }

    /// Effective number of dimensions: as many equal eigenvalues have the same mean square for their sum.
    pub fn dimensions(&self) -> f64 {
        let sum: f64 = self.values.iter().sum();
        let squares: f64 = self.values.iter().map(|value| value * value).sum();
        if squares > 0.0 { sum * sum / squares } else { 0.0 }
    }

    fn seen(&self, column: &[f64]) -> Seen {
        let products = products(&self.columns, column);
        let along: Vec<f64> =
            self.vectors.chunks_exact(products.len().max(1)).map(|vector| dot(vector, &products)).collect();
        let rest = (dot(column, column) - dot(&along, &along)).max(0.0);
        Seen { along, rest }
    }

    /// `a' (I + t K)^-1 b`, where `rest` is the product of what is left of both.
    fn product(&self, size: f64, a: &[f64], b: &[f64], rest: f64) -> f64 {
        let one = |((a, b), value): ((&f64, &f64), &f64)| a * b / (1.0 + size * value);
        a.iter().zip(b).zip(&self.values).map(one).sum::<f64>() + rest
    }

    /// Log likelihoods of the residuals `y` with small effects everywhere of a size `t` alone, and with the change `g` beside
    /// them (determinant and inverse of a change of rank 1); the same constant is left out of both.
    pub fn log_likelihoods(&self, y: &[f64], g: &[f64]) -> impl Fn(f64) -> (f64, f64) {
        let (seen_y, seen_g) = (self.seen(y), self.seen(g));
        let crossed = dot(y, g) - dot(&seen_y.along, &seen_g.along);
        move |size: f64| {
            let volume: f64 = self.values.iter().map(|value| ln(1.0 + size * value)).sum();
            let square = self.product(size, &seen_y.along, &seen_y.along, seen_y.rest);
            let length = self.product(size, &seen_g.along, &seen_g.along, seen_g.rest);
            let common = self.product(size, &seen_y.along, &seen_g.along, crossed);
            let alone = -0.5 * (volume + square);
            (alone, alone - 0.5 * ln(1.0 + length) + 0.5 * common * common / (1.0 + length))
        }
    }

    /// By how much the most likely sum of both raises the log likelihood of the residuals over that of small effects
    /// everywhere alone.
    pub fn log_bayes_factor(&self, y: &[f64], g: &[f64]) -> f64 {
        let ratio = ln(LARGEST / SMALLEST) / (SIZES - 1) as f64;
        let sizes = std::iter::once(0.0).chain((0..SIZES).map(|k| SMALLEST * exp(ratio * k as f64)));
        let [mut without, mut with] = [f64::NEG_INFINITY; 2];
        for (alone, both) in sizes.map(self.log_likelihoods(y, g)) {
            without = without.max(alone);
            with = with.max(both);
        }
        with - without
    }
}

impl Diagnosis {
    /// Probability that small effects everywhere are what each effect of the selected set explains, at most [`IS_MODEL_ERROR`]:
    /// nothing beforehand speaks for either but the effect's own odds. Effects are weighed one by one, the strongest first,
    /// each beside those before it; those of sets that were not fitted are left out.
    pub(super) fn errors_everywhere(&self, findings: &Findings) -> BTreeMap<usize, f64> {
        let refits = &findings.state.refits;
        let chosen = &refits[findings.selected].effects;
        let odds = PriorOdds::new(findings.problem);
        let mut probabilities = BTreeMap::new();
        let Ok(others) = self.others(findings) else { return probabilities };
        // A prior that is too narrow is no error of the model's parts.
        let is_prior = |effect: &&usize| findings.problem.candidates[**effect].effect == PRIOR_OF;
        let mut before: Vec<usize> = chosen.iter().filter(is_prior).copied().collect();
        while before.len() < chosen.len() {
            let Some(without) = refits.iter().find(|refit| refit.effects == before) else { break };
            let Ok(beside) = self.beside(findings, without, &others) else { break };
            if beside.everywhere.dimensions() < LEAST_DIMENSIONS {
                break;
            }
            let with = |effect: usize| {
                let mut effects = before.clone();
                effects.push(effect);
                effects.sort_unstable();
                refits.iter().find(|refit| refit.effects == effects)
            };
            let next = chosen.iter().filter(|effect| !before.contains(effect));
            let weighed = next.filter_map(|&effect| Some((effect, beside.log_bayes_factor(with(effect)?))));
            let Some((effect, log)) = weighed.reduce(|a, b| if b.1 > a.1 { b } else { a }) else { break };
            let log_odds = log + odds.of(findings.problem, &[effect]);
            probabilities.insert(effect, (1.0 / (1.0 + exp(log_odds))).min(IS_MODEL_ERROR));
            before.push(effect);
            before.sort_unstable();
        }
        probabilities
    }

    /// Errors everywhere beside a fitted set.
    fn beside(&self, findings: &Findings, without: &Refit, others: &[Vec<f64>]) -> Result<Beside, FitError> {
        let problem = findings.problem.with(without)?;
        let likelihood = self.likelihood(&problem)?;
        let linear = signature::linearise(&likelihood, &without.unknowns)?;
        let parameters = linear.parameters();
        // What is pressed against a bound is not free.
        let is_free = |k: &usize| linear.lower[*k] < 0.0 && linear.upper[*k] > 0.0;
        let of_parameter = |k: usize| (0..linear.rows).map(|row| linear.jacobian[row * parameters + k]).collect();
        let free: Vec<Vec<f64>> = (0..parameters).filter(is_free).map(of_parameter).collect();
        let columns: Vec<&[f64]> = free.iter().map(Vec::as_slice).collect();
        let (basis, _) = orthonormal(&columns, Vec::new(), DEPENDENT);
        let everywhere = Everywhere::new(remainders(others, &basis, linear.rows, SMALLEST_SHARE));
        Ok(Beside { everywhere, basis, linear, likelihood, unknowns: without.unknowns.clone() })
    }

    /// Directions of the effects of which the random sum is made, at the baseline fit: laws at single places, evenly over the
    /// list, one direction of each.
    fn others(&self, findings: &Findings) -> Result<Vec<Vec<f64>>, FitError> {
        let problem = findings.problem;
        let is_law = |&place: &usize| {
            let candidate = &problem.candidates[place];
            let is_timed = problem.catalogue.get(&candidate.effect).is_some_and(Effect::depends_on_time);
            !(self.is_unknown_function(place) || is_timed || candidate.is_group() || candidate.effect == PRIOR_OF)
        };
        let laws: Vec<usize> = (0..problem.candidates.len()).filter(is_law).collect();
        let step = laws.len().div_ceil(MOST_OTHERS).max(1);
        let chosen: Vec<usize> = laws.into_iter().step_by(step).collect();
        let baseline = &findings.state.refits[0];
        let (readings, likelihood) = (baseline.residuals.len(), self.likelihood(problem)?);
        let mut others: Vec<Vec<f64>> = Vec::new();
        let mut last = None;
        signature::for_each_direction(problem, &likelihood, &baseline.unknowns, &chosen, &mut |directions| {
            for direction in directions {
                if last.replace(direction.candidate) != Some(direction.candidate) {
                    others.push(direction.column(0)[..readings].to_vec());
                }
            }
        })?;
        Ok(others)
    }
}

/// Errors everywhere, orthogonal to the free parameters of a set.
struct Beside {
    everywhere: Everywhere,
    /// Orthonormal columns of these.
    basis: Vec<f64>,
    /// The set at its fit.
    linear: Linear,
    likelihood: Likelihood,
    unknowns: Vec<f64>,
}

impl Beside {
    /// Log Bayes factor of the effect by which a fitted set is larger. Its refit moved the parameters, which costs in the rows of
    /// their priors what it gains in those of the readings.
    fn log_bayes_factor(&self, with: &Refit) -> f64 {
        let (linear, parameters) = (&self.linear, self.linear.parameters());
        let Ok(objective) = NaturalObjective::new(&self.likelihood) else { return 0.0 };
        let known = with.by_name();
        let names = self.likelihood.unknowns().names.iter().zip(&self.unknowns);
        let moved: Vec<f64> = names.map(|(name, own)| known.get(name).copied().unwrap_or(*own)).collect();
        let (from, to) = (objective.coordinates(&self.unknowns), objective.coordinates(&moved));
        let mut y = linear.residuals.clone();
        let mut g: Vec<f64> = y.iter().zip(&with.residuals).map(|(before, after)| before - after).collect();
        g.truncate(linear.readings);
        g.extend((linear.readings..linear.rows).map(|row| {
            let slopes = &linear.jacobian[row * parameters..(row + 1) * parameters];
            slopes.iter().zip(from.iter().zip(&to)).map(|(slope, (from, to))| slope * (to - from)).sum::<f64>()
        }));
        project_out(&mut y, &self.basis);
        project_out(&mut g, &self.basis);
        self.everywhere.log_bayes_factor(&y, &g)
    }
}
