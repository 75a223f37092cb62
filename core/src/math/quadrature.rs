//! Gauss-Legendre and Gauss-Hermite rules, nodes by Newton's method on the orthogonal polynomials' recurrences.

use super::functions::{cos, exp, sqrt};

/// Nodes and weights of a quadrature rule, nodes ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    /// Nodes.
    pub nodes: Vec<f64>,
    /// Weights.
    pub weights: Vec<f64>,
}

impl Rule {
    /// `sum of weight * f(node)`, in order.
    pub fn apply(&self, mut f: impl FnMut(f64) -> f64) -> f64 {
        self.nodes.iter().zip(&self.weights).map(|(&x, &w)| w * f(x)).sum()
    }

    /// The integral of f over `lower..upper` by a rule for (-1, 1).
    pub fn integrate(&self, lower: f64, upper: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
        let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower));
        half * self.apply(|x| f(middle + half * x))
    }
}

/// Gauss-Legendre rule with `points` nodes in (-1, 1) for the weight 1; exact for polynomials of degree `2 points - 1`.
pub fn gauss_legendre(points: usize) -> Rule {
    let n = points as f64;
    let mut rule = Rule { nodes: vec![0.0; points], weights: vec![0.0; points] };
    for k in 0..points.div_ceil(2) {
        let mut x = cos(std::f64::consts::PI * (k as f64 + 0.75) / (n + 0.5));
        if 2 * k + 1 == points {
            x = 0.0;
        }
        for _ in 0..10 {
            let (value, slope) = legendre(points, x);
            let step = value / slope;
            x -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        let (_, slope) = legendre(points, x);
        let weight = 2.0 / ((1.0 - x * x) * slope * slope);
        (rule.nodes[points - 1 - k], rule.nodes[k]) = (x, -x);
        (rule.weights[points - 1 - k], rule.weights[k]) = (weight, weight);
    }
    rule
}

/// Legendre polynomial of the given degree and its derivative, inside (-1, 1).
fn legendre(degree: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (0.0, 1.0);
    for k in 0..degree {
        let j = k as f64;
        (before, value) = (value, ((2.0 * j + 1.0) * x * value - j * before) / (j + 1.0));
    }
    (value, degree as f64 * (x * value - before) / (x * x - 1.0))
}

/// Gauss-Hermite rule for the standard normal density: the sum approximates the mean of f over a standard normal variable
/// and is exact for polynomials of degree `2 points - 1`. For up to 200 points.
pub fn gauss_hermite(points: usize) -> Rule {
    // Deflated Newton from outside (as in Ralston & Rabinowitz 1978): roots already found are divided out.
    let mut roots: Vec<f64> = Vec::with_capacity(points);
    let mut x = 2.0 * sqrt(points as f64);
    for _ in 0..points.div_ceil(2) {
        for _ in 0..200 {
            let (value, slope) = hermite(points, x);
            let deflation: f64 = roots.iter().map(|r| 1.0 / (x - r) + 1.0 / (x + r)).sum();
            let step = value / (slope - value * deflation);
            x -= step;
            if step.abs() < 1e-15 * x.abs().max(1.0) {
                break;
            }
        }
        roots.push(x);
        x *= 0.999;
    }
    if points % 2 == 1
        && let Some(middle) = roots.last_mut()
    {
        *middle = 0.0;
    }
    let weight = |x: f64| {
        let (_, slope) = hermite(points, x);
        exp(-0.5 * x * x) / (slope * slope)
    };
    let mut nodes: Vec<f64> = roots.iter().map(|r| -r).collect();
    nodes.extend(roots.iter().rev().skip(points % 2));
    let mut weights: Vec<f64> = nodes.iter().map(|&x| weight(x)).collect();
    let total: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= total);
    Rule { nodes, weights }
}

/// Normalised Hermite polynomial (for the normal density) times `exp(-x^2 / 4)`, which never overflows, and a multiple of
/// the polynomial's derivative in the same scale.
fn hermite(degree: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (0.0, exp(-0.25 * x * x));
    for k in 0..degree {
        let j = k as f64;
        (before, value) = (value, (x * value - sqrt(j) * before) / sqrt(j + 1.0));
    }
    (value, sqrt(degree as f64) * before)
}
