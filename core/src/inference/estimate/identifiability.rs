//! What a fit says about its parameters: held at a bound, unseen by the data alone or in combination, acting only
//! through a product, quotient, sum or difference.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::inference::estimate::natural::NaturalObjective;
use crate::inference::estimate::optimise::{Bounds, Minimum, free_variables};
use crate::inference::estimate::point_estimate::End;
use crate::inference::target::LeastSquares;
use crate::math::sort::sort_by;

/// How two parameters act together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Combination {
    /// Only `a b` matters.
    Product,
    /// Only `a / b` matters.
    Quotient,
    /// Only `a + b` matters.
    Sum,
    /// Only `a - b` matters.
    Difference,
}

/// A share of a parameter in a direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// Place of the parameter.
    pub parameter: usize,
    /// Component of the unit vector, in prior standard deviations.
    pub weight: f64,
}

/// Something that a reader of the fit must know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Finding {
    /// A parameter is held at a bound of its prior.
    AtBound {
        /// Place of the parameter.
        parameter: usize,
        /// Which bound.
        end: End,
        /// Fall of the log posterior per prior standard deviation from the bound inwards.
        pull: f64,
    },
    /// The data say less about a direction than the prior does.
    FlatDirection {
        /// Information of the data along it, relative to the prior's: 0 for none, 1 for as much.
        information: f64,
        /// Parameters with a noticeable part in it, largest first.
        shares: Vec<Share>,
    },
    /// Two parameters act on the data only together.
    OnlyTogether {
        /// Place of one.
        first: usize,
        /// Place of the other.
        second: usize,
        /// How they act.
        combination: Combination,
    },
}

/// Information below which a direction is called flat.
const FLAT: f64 = 0.1;

/// The findings at a minimum; `elsewhere` (SI) is a second point at which a combination must show too.
pub(super) fn findings<T: LeastSquares>(
    target: &T,
    objective: &mut NaturalObjective<'_, T>,
    best: &Minimum,
    bounds: &Bounds,
    elsewhere: Option<&[f64]>,
) -> Vec<Finding> {
    let n = best.x.len();
    let free = free_variables(&best.x, &best.gradient, bounds);
    let parameters = objective.parameters(&best.x);
    // Spreads of the priors over the natural coordinates.
    let spreads: Vec<f64> = (0..n)
        .map(|i| {
            let (low, high) = (target.priors()[i].quantile(0.158_655_3), target.priors()[i].quantile(0.841_344_7));
            if objective.logarithmic()[i] {
                0.5 * (crate::math::functions::ln(high) - crate::math::functions::ln(low))
            } else {
                0.5 * (high - low)
            }
        })
        .collect();
    let mut findings = Vec::new();
    for i in (0..n).filter(|i| !free.contains(i)) {
        let end = if best.x[i] <= bounds.lower[i] { End::Lower } else { End::Upper };
        findings.push(Finding::AtBound { parameter: i, end, pull: best.gradient[i].abs() * spreads[i] });
    }
    let data = objective.data_rows();
    let scaled = DMatrix::from_fn(data, free.len(), |row, a| best.jacobian[row * n + free[a]] * spreads[free[a]]);
    // With an inferred noise the Jacobian leaves out what the offset says, so that nothing is concluded from it.
    if !best.penalised && scaled.iter().all(|v| v.is_finite()) && !free.is_empty() {
        // Singular values of the triangular factor keep the digits that the product of the Jacobian with itself loses.
        let (values, directions) = directions(scaled);
        let mut order: Vec<usize> = (0..values.len()).collect();
        sort_by(&mut order, |&a, &b| values[a].total_cmp(&values[b]));
        for e in order.into_iter().filter(|&e| values[e] * values[e] < FLAT) {
            let mut shares: Vec<Share> = free
                .iter()
                .enumerate()
                .map(|(a, &i)| Share { parameter: i, weight: directions[(e, a)] })
                .filter(|share| share.weight.abs() > 0.1)
                .collect();
            sort_by(&mut shares, |a, b| b.weight.abs().total_cmp(&a.weight.abs()));
            findings.push(Finding::FlatDirection { information: values[e] * values[e], shares });
        }
    }
    let mut pairs = combinations(target, &parameters);
    if let Some(second) = elsewhere {
        let there = combinations(target, second);
        pairs.retain(|pair| there.contains(pair));
    }
    findings.extend(pairs.into_iter().map(|(first, second, combination)| Finding::OnlyTogether {
        first,
        second,
        combination,
    }));
    findings
}

/// Singular values of a matrix of at least as many columns' worth of rows (padded with zeros), and the right singular
/// vectors as rows.
fn directions(matrix: DMatrix<f64>) -> (Vec<f64>, DMatrix<f64>) {
    let columns = matrix.ncols();
    let rows = matrix.nrows().max(columns);
    let factor = matrix.resize_vertically(rows, 0.0).qr().r();
    let svd = factor.svd(false, true);
    let vectors = svd.v_t.unwrap_or_else(|| DMatrix::identity(columns, columns));
    (svd.singular_values.iter().copied().collect(), vectors)
}

/// Pairs whose derivatives agree as those of a combination do, at parameters (SI).
fn combinations<T: LeastSquares>(target: &T, parameters: &[f64]) -> Vec<(usize, usize, Combination)> {
    let (n, rows) = (parameters.len(), target.residual_count());
    let (mut residuals, mut jacobian, mut offset) = (vec![0.0; rows], vec![0.0; rows * n], vec![0.0; n]);
    let mut trades = Vec::new();
    if target.jacobian(parameters, &mut target.workspace(), &mut residuals, &mut jacobian, &mut offset).is_err() {
        return trades;
    }
    for first in 0..n {
        for second in first + 1..n {
            let agree = |a: f64, b: f64| {
                let (mut apart, mut size) = (0.0, 0.0);
                for row in jacobian.chunks_exact(n) {
                    let (x, y) = (a * row[first], b * row[second]);
                    apart += (x - y) * (x - y);
                    size += x * x;
                }
                // Derivatives by the chain rule agree to rounding, those by iteration to the solver's tolerance.
                size > 0.0 && apart <= 1e-12 * size
            };
            let (a, b) = (parameters[first], parameters[second]);
            let combination = if agree(a, b) {
                Combination::Product
            } else if agree(a, -b) {
                Combination::Quotient
            } else if agree(1.0, 1.0) {
                Combination::Sum
            } else if agree(1.0, -1.0) {
                Combination::Difference
            } else {
                continue;
            };
            trades.push((first, second, combination));
        }
    }
    trades
}
