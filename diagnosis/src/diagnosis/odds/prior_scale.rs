//! How wide the priors of effects' amplitudes are.
//!
//! What the catalogue says of plausible amplitudes may be wrong by orders of magnitude: it knows how large the hardware is on the
//! whole, but not at the place that it is asked about. So the prior of each effect is a mixture of widths, narrower and
//! wider than the catalogue's (contamination: Berger & Berliner 1986, Ann. Statist. 14, 461), of which the component counts
//! that explains most. Without wider ones the tails of a normal prior outvote any data; without narrower ones an effect is
//! the less credible the smaller a part of its plausible range the data need, though small leaks are as common as large ones.

use crate::diagnosis::Hypothesis;
use crate::inference::estimate::point_estimate::PointEstimate;
use crate::math::cholesky;
use crate::math::functions::ln;
use crate::math::lanes::dot;
use crate::random::Distribution;

/// A width, in that of the catalogue, and its odds beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Width {
    /// Factor of the priors' standard deviations.
    pub factor: f64,
    /// Odds against the catalogue's own width.
    pub odds: f64,
}

impl Width {
    /// Logarithm of the odds. A sensor's fault that is larger than plausible is the square less probable: hardware is of any size,
    /// instruments are much alike.
    pub fn log_odds(&self, of_sensors: bool) -> f64 {
        if of_sensors { 2.0 * ln(self.odds) } else { ln(self.odds) }
    }
}

/// The catalogue's width and wider ones, which are fitted where they pay.
pub const WIDTHS: [Width; 4] = [
    Width { factor: 1.0, odds: 1.0 },
    Width { factor: 10.0, odds: 0.1 },
    Width { factor: 100.0, odds: 0.01 },
    Width { factor: 1000.0, odds: 0.001 },
];
/// The first of them that is implausible, unless the effect carries no more heat than the model.
pub const IMPLAUSIBLE: usize = 2;
/// Narrower ones. They pay where the data see far less than the catalogue's width, so that they hardly move the fit.
const NARROWER: [Width; 2] = [Width { factor: 0.1, odds: 0.3 }, Width { factor: 0.01, odds: 0.09 }];

/// The amplitudes with a normal prior that no bound holds, at a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Amplitudes {
    /// Which effect of the set each belongs to.
    pub effects: Vec<usize>,
    /// Distance from the prior's centre, in the prior's standard deviations.
    pub away: Vec<f64>,
    /// Cholesky factor of their covariance, in the same units; `None` where there is none.
    pub factor: Option<Vec<f64>>,
}

impl Amplitudes {
    /// Of a hypothesis at its most probable point; `is_amplitude` says of each effect's parameters which are. A bound that
    /// holds an amplitude says nothing of its width.
    pub fn at(hypothesis: &Hypothesis, found: &PointEstimate, is_amplitude: &[Vec<bool>]) -> Self {
        let (mut effects, mut away, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for (effect, (range, flags)) in hypothesis.amplitudes.iter().zip(is_amplitude).enumerate() {
            for (index, _) in range.clone().zip(flags).filter(|(_, flag)| **flag) {
                let (centre, sd) = match hypothesis.priors[index] {
                    Distribution::Normal { mean, sd, .. } => (mean, sd),
                    Distribution::HalfNormal { scale } => (0.0, scale),
                    _ => continue,
                };
                let place = hypothesis.parameters.iter().position(|&inferred| inferred == index);
                let Some(place) = place.filter(|&place| found.held[place].is_none() && sd > 0.0) else { continue };
                effects.push(effect);
                away.push((found.parameters[place] - centre) / sd);
                places.push((place, sd));
            }
        }
        let width = found.parameters.len();
        let covariance = |&(i, a): &(usize, f64), &(j, b): &(usize, f64)| found.covariance[i * width + j] / (a * b);
        let mut factor: Vec<f64> =
            places.iter().flat_map(|own| places.iter().map(move |other| covariance(own, other))).collect();
        let factor = cholesky::factor(&mut factor, places.len()).is_ok().then_some(factor);
        Self { effects, away, factor }
    }

    /// By how much the log evidence rises where each effect's priors are so many times as wide: exact for normal data and
    /// priors. With the distance `m` from the priors' centres and the covariance `C = L L'` at the fit, in the priors' standard
    /// deviations, and `D = 1 / factor^2 - 1`, it is `-sum ln factor - ln det(I + L' D L) / 2 - m' (C + D^-1)^-1 m / 2`: the ratio
    /// of two normal integrals, whose exponents differ by the quadratic form of `D` alone.
    pub fn gain(&self, factors: &[f64]) -> f64 {
        let Some(factor) = &self.factor else { return f64::NEG_INFINITY };
        let n = self.away.len();
        let own: Vec<f64> = self.effects.iter().map(|&effect| factors[effect]).collect();
        let change: Vec<f64> = own.iter().map(|factor| 1.0 / (factor * factor) - 1.0).collect();
        let entry = |row: usize, column: usize| if row >= column { factor[row * n + column] } else { 0.0 };
        let form = |i: usize, j: usize| (0..n).map(|k| entry(k, i) * change[k] * entry(k, j)).sum::<f64>();
        let mut inner: Vec<f64> =
            (0..n * n).map(|at| form(at / n, at % n) + if at / n == at % n { 1.0 } else { 0.0 }).collect();
        if cholesky::factor(&mut inner, n).is_err() {
            return f64::NEG_INFINITY;
        }
        let moved: Vec<f64> = change.iter().zip(&self.away).map(|(change, away)| change * away).collect();
        let mut reduced: Vec<f64> = (0..n).map(|i| (0..n).map(|k| entry(k, i) * moved[k]).sum()).collect();
        cholesky::solve_lower(&inner, &mut reduced);
        let square = dot(&moved, &self.away) - dot(&reduced, &reduced);
        -own.iter().map(|factor| ln(*factor)).sum::<f64>() - 0.5 * (cholesky::log_determinant(&inner, n) + square)
    }

    /// The next widths, as positions in [`WIDTHS`], of those effects for which a wider prior raises the log evidence by more than
    /// `least`.
    pub fn wider(&self, places: &[usize], least: f64) -> Vec<usize> {
        let mut factors = vec![1.0; places.len()];
        let (mut next, mut known) = (places.to_vec(), least);
        for (effect, &place) in places.iter().enumerate() {
            let Some(to) = WIDTHS.get(place + 1).filter(|_| self.effects.contains(&effect)) else { continue };
            let from = WIDTHS[place];
            factors[effect] = to.factor / from.factor;
            let gain = self.gain(&factors) + ln(to.odds / from.odds);
            if gain > known {
                (next[effect], known) = (place + 1, gain);
            } else {
                factors[effect] = 1.0;
            }
        }
        next
    }

    /// The widths before these, as positions in [`WIDTHS`], of those effects for which a narrower prior raises the log evidence: a fit
    /// that began far out was given more than it needs.
    pub fn less_wide(&self, places: &[usize]) -> Vec<usize> {
        let mut factors = vec![1.0; places.len()];
        let (mut next, mut known) = (places.to_vec(), 0.0);
        for (effect, &place) in places.iter().enumerate() {
            let Some(to) = place.checked_sub(1).filter(|_| self.effects.contains(&effect)) else { continue };
            factors[effect] = WIDTHS[to].factor / WIDTHS[place].factor;
            let gain = self.gain(&factors) + ln(WIDTHS[to].odds / WIDTHS[place].odds);
            if gain > known {
                (next[effect], known) = (to, gain);
            } else {
                factors[effect] = 1.0;
            }
        }
        next
    }

    /// By how much narrower priors raise the log evidence, of effects with the catalogue's own width.
    pub fn narrower(&self, places: &[usize]) -> f64 {
        let mut factors = vec![1.0; places.len()];
        let mut known = 0.0;
        let mut odds = vec![0.0; places.len()];
        for width in NARROWER {
            for effect in (0..places.len()).filter(|&effect| places[effect] == 0 && self.effects.contains(&effect)) {
                let before = (factors[effect], odds[effect]);
                (factors[effect], odds[effect]) = (width.factor, ln(width.odds));
                let gain = self.gain(&factors) + odds.iter().sum::<f64>();
                if gain > known {
                    known = gain;
                } else {
                    (factors[effect], odds[effect]) = before;
                }
            }
        }
        known
    }
}
