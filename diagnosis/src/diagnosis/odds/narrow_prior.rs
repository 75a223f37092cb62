//! Priors that may be too narrow: beside the catalogue's effects, every inferred parameter may have a value that its prior
//! makes improbable or rules out.
//!
//! Such a candidate adds no element. It puts a prior that is `TIMES` times as wide, without the written bounds, in the place
//! of the parameter's own, and so pays for the freedom in its evidence as any effect does. Where it explains what an
//! effect would explain, nothing new has to be invented.

use std::sync::Arc;

use crate::diagnosis::Problem;
use crate::diagnosis::problem::is_idle;
use crate::effect::{Candidate, Site};
use crate::expression::Unit;
use crate::math::functions::pow;
use crate::random::Distribution;

/// Name of this kind of candidate, where that of an effect stands.
pub const PRIOR_OF: &str = "prior-of";
/// What it is.
pub(crate) const TITLE: &str = "Prior that is too narrow for its parameter";
/// What tells it from an effect.
pub(crate) const SEPARATE: &str =
    "ask where the prior comes from; measure the parameter by itself, on a coupon or in a test of the part alone";
/// Widths of the prior in a standard deviation of the wider one.
const TIMES: f64 = 3.0;
/// Shares of a prior beyond which it says that a value is not possible.
const HARDLY: f64 = 1e-6;
/// Lower bound of what cannot be below 0, in its median: a conductance of exactly 0 takes nodes apart.
pub const LEAST: f64 = 1e-6;

/// A prior `factor` times as wide as the one that stands for a prior that is too narrow. What the prior itself holds above 0 stays
/// there, and a share stays below 1. `None` for what is known.
pub fn wider(prior: &Distribution, unit: &str, factor: f64) -> Option<Distribution> {
    let times = TIMES * factor;
    let [low, median, high] = [0.16, 0.5, 0.84].map(|share| prior.quantile(share));
    Some(match *prior {
        Distribution::Fixed(_) => return None,
        Distribution::HalfNormal { scale } => Distribution::HalfNormal { scale: times * scale },
        Distribution::LogNormal { median, factor } => Distribution::LogNormal { median, factor: pow(factor, times) },
        Distribution::LogUniform { .. } => Distribution::LogNormal { median, factor: pow((high / low).sqrt(), times) },
        Distribution::Uniform { .. } | Distribution::Triangular { .. } | Distribution::Normal { .. } => {
            let [least, most] = [HARDLY, 1.0 - HARDLY].map(|share| prior.quantile(share));
            let is_share = least >= 0.0
                && most <= 1.0
                && Unit::parse(unit).is_ok_and(|unit| unit.dimension.is_none() && unit.factor == 1.0);
            Distribution::Normal {
                mean: median,
                sd: 0.5 * times * (high - low),
                lower: (least >= 0.0).then_some(LEAST * median),
                upper: is_share.then_some(1.0),
            }
        }
    })
}

/// Whether a candidate is a prior that may be too narrow.
pub(crate) fn is_prior(candidate: &Candidate) -> bool {
    matches!(candidate.site, Site::Parameter(_))
}

impl Problem {
    /// The same with the priors of the inferred parameters below `before` among what may be wrong.
    pub fn with_priors_in_question(mut self, before: usize) -> Self {
        let is_asked = |&&index: &&usize| {
            index < before && !self.priors[index].is_fixed() && !is_idle(&self.model.parameters[index].name)
        };
        let one = |&index: &usize| {
            let name = self.model.parameters[index].name.clone();
            Candidate {
                id: format!("{PRIOR_OF}:{name}"),
                effect: PRIOR_OF.to_owned(),
                where_kind: "parameter",
                place: vec![name],
                input: None,
                site: Site::Parameter(index),
                bound: Vec::new(),
                steady: true,
                transient: true,
            }
        };
        let own: Vec<Candidate> = self.parameters.iter().filter(is_asked).map(one).collect();
        Arc::make_mut(&mut self.candidates).extend(own);
        self
    }

    /// The wider prior of a parameter, `factor` times as wide as usual.
    pub(crate) fn wider_prior(&self, parameter: usize, factor: f64) -> Option<Distribution> {
        wider(self.priors.get(parameter)?, &self.model.parameters.get(parameter)?.unit, factor)
    }
}
