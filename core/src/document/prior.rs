//! Priors as written, and in SI.

use super::{Amount, Diagnostic, Diagnostics, Place, Sense, Spanned, code, written_choice, written_struct};
use crate::expression::{Dimension, Unit};
use crate::random::Distribution;

written_choice! {
    /// What is known of a value; bare numbers are in the entry's unit.
    pub enum PriorForm: "a prior" {
        /// Equal density between two bounds.
        "uniform" => Uniform(Spanned<[Amount; 2]>),
        /// Normal, cut off at bounds where given.
        "normal" => Normal(Spanned<NormalForm>),
        /// Normal in the logarithm.
        "lognormal" => Lognormal(Spanned<LognormalForm>),
        /// Uniform in the logarithm, between two bounds above 0.
        "loguniform" => Loguniform(Spanned<[Amount; 2]>),
        /// Magnitude of a normal variable of mean 0, by that variable's standard deviation.
        "halfnormal" => Halfnormal(Amount),
        /// Triangular: lower bound, most probable value, upper bound.
        "triangular" => Triangular(Spanned<[Amount; 3]>),
        /// Known.
        "fixed" => Fixed(Amount),
        /// Draws of an earlier pass's calibration, with their correlations.
        "posterior" => Posterior(Spanned<PosteriorForm>),
        /// Draws from a file.
        "draws" => Draws(Spanned<DrawsForm>),
    }
}

written_struct! {
    /// A normal distribution.
    pub struct NormalForm: "an object {\"mean\": ..., \"sd\": ...}" {
        /// Mean before the cut.
        required mean: Amount,
        /// Standard deviation before the cut.
        required sd: Amount,
        /// Lower bound.
        optional lower: Amount,
        /// Upper bound.
        optional upper: Amount,
    }
}

written_struct! {
    /// A lognormal distribution.
    pub struct LognormalForm: "an object {\"median\": ..., \"factor\": ...}" {
        /// Median.
        required median: Amount,
        /// `exp` of the logarithm's standard deviation, above 1.
        required factor: Spanned<f64>,
    }
}

written_struct! {
    /// Where posterior draws come from.
    pub struct PosteriorForm: "an object {\"pass\": ..., \"job\": ...}" {
        /// The pass's file.
        required pass: Spanned<String>,
        /// The calibration in it.
        required job: Spanned<String>,
    }
}

written_struct! {
    /// A file of draws.
    pub struct DrawsForm: "an object {\"file\": ...}" {
        /// The file within the study.
        required file: Spanned<String>,
    }
}

/// A prior in SI.
#[derive(Clone, Debug, PartialEq)]
pub enum Prior {
    /// A distribution of its own.
    Distribution(Distribution),
    /// Draws of an earlier calibration.
    Posterior {
        /// The pass's file.
        pass: String,
        /// The calibration's name.
        job: String,
        /// Where it is asked for.
        place: Place,
    },
    /// Draws from a file.
    Draws {
        /// The file within the study.
        file: String,
        /// Where it is asked for.
        place: Place,
    },
}

impl Prior {
    /// The distribution, if it is one.
    pub fn distribution(&self) -> Option<&Distribution> {
        match self {
            Self::Distribution(distribution) => Some(distribution),
            Self::Posterior { .. } | Self::Draws { .. } => None,
        }
    }

    /// Where draws come from, in words; `None` for a distribution.
    pub fn draws_words(&self) -> Option<String> {
        match self {
            Self::Distribution(_) => None,
            Self::Posterior { pass, job, .. } => Some(format!("`{job}` of `{pass}`")),
            Self::Draws { file, .. } => Some(format!("`{file}`")),
        }
    }
}

impl PriorForm {
    /// Where its numbers stand.
    pub fn place(&self) -> &Place {
        match self {
            Self::Uniform(Spanned { place, .. })
            | Self::Normal(Spanned { place, .. })
            | Self::Lognormal(Spanned { place, .. })
            | Self::Loguniform(Spanned { place, .. })
            | Self::Triangular(Spanned { place, .. })
            | Self::Posterior(Spanned { place, .. })
            | Self::Draws(Spanned { place, .. })
            | Self::Halfnormal(Amount { place, .. })
            | Self::Fixed(Amount { place, .. }) => place,
        }
    }
}

/// Smallest and largest value with a density, SI.
pub fn support(distribution: &Distribution) -> [f64; 2] {
    match *distribution {
        Distribution::Fixed(value) => [value, value],
        Distribution::Uniform { lower, upper }
        | Distribution::LogUniform { lower, upper }
        | Distribution::Triangular { lower, upper, .. } => [lower, upper],
        Distribution::Normal { lower, upper, .. } => {
            [lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY)]
        }
        Distribution::LogNormal { .. } | Distribution::HalfNormal { .. } => [0.0, f64::INFINITY],
    }
}

/// Reports an impossible prior. Always `None`.
fn invalid<T>(place: &Place, message: String, expected: &str, diagnostics: &mut Diagnostics) -> Option<T> {
    diagnostics.push(Diagnostic::error(&code::INVALID_PRIOR, place, message).expected(expected));
    None
}

/// How the numbers of an entry are converted.
struct Conversion<'a> {
    entry_unit: Option<&'a Unit>,
    dimension: Dimension,
    sense: Sense,
}

impl Conversion<'_> {
    fn place(&self, amount: &Amount, diagnostics: &mut Diagnostics) -> Option<f64> {
        amount.si(self.dimension, self.entry_unit, self.sense, diagnostics)
    }

    fn width(&self, amount: &Amount, diagnostics: &mut Diagnostics) -> Option<f64> {
        let value = amount.si(self.dimension, self.entry_unit, Sense::Difference, diagnostics)?;
        if value > 0.0 {
            return Some(value);
        }
        let message = format!("a standard deviation of {} is not above 0", amount.value);
        invalid(&amount.place, message, "a number above 0", diagnostics)
    }

    /// Two bounds in order.
    fn bounds(&self, pair: &Spanned<[Amount; 2]>, diagnostics: &mut Diagnostics) -> Option<[f64; 2]> {
        let [low, high] = &pair.value;
        let (lower, upper) = (self.place(low, diagnostics), self.place(high, diagnostics));
        let (lower, upper) = (lower?, upper?);
        if lower < upper {
            return Some([lower, upper]);
        }
        let (message, help) = if lower == upper {
            (
                format!("the prior's bounds are both {}", low.value),
                format!("a known value is {{\"fixed\": {}}}", low.value),
            )
        } else {
            (
                format!("the prior's lower bound {} is above its upper bound {}", low.value, high.value),
                format!("write [{}, {}]", high.value, low.value),
            )
        };
        diagnostics
            .push(Diagnostic::error(&code::INVALID_PRIOR, &pair.place, message).expected("[lower, upper]").help(help));
        None
    }
}

impl PriorForm {
    /// The prior in SI. Bare numbers are in `entry_unit`, or SI; `sense` tells whether the value itself is a difference
    /// (a bias); widths always are.
    pub fn resolve(
        &self,
        entry_unit: Option<&Unit>,
        dimension: Dimension,
        sense: Sense,
        diagnostics: &mut Diagnostics,
    ) -> Option<Prior> {
        let conversion = Conversion { entry_unit, dimension, sense };
        let distribution = match self {
            Self::Uniform(pair) => {
                let [lower, upper] = conversion.bounds(pair, diagnostics)?;
                Distribution::Uniform { lower, upper }
            }
            Self::Loguniform(pair) => {
                let [lower, upper] = conversion.bounds(pair, diagnostics)?;
                if lower <= 0.0 {
                    let message = format!("a loguniform prior's lower bound {} is not above 0", pair.value[0].value);
                    return invalid(&pair.value[0].place, message, "a bound above 0", diagnostics);
                }
                Distribution::LogUniform { lower, upper }
            }
            Self::Normal(form) => normal(form, &conversion, diagnostics)?,
            Self::Lognormal(form) => {
                let median = conversion.place(&form.value.median, diagnostics)?;
                if median <= 0.0 {
                    let message = format!("a lognormal prior's median {} is not above 0", form.value.median.value);
                    return invalid(&form.value.median.place, message, "a median above 0", diagnostics);
                }
                let factor = &form.value.factor;
                if factor.value <= 1.0 {
                    let message = format!("a lognormal prior's factor {} is not above 1", factor.value);
                    return invalid(&factor.place, message, "exp of the logarithm's sd: above 1", diagnostics);
                }
                Distribution::LogNormal { median, factor: factor.value }
            }
            Self::Halfnormal(amount) => Distribution::HalfNormal { scale: conversion.width(amount, diagnostics)? },
            Self::Triangular(three) => {
                let [low, middle, high] = &three.value;
                let lower = conversion.place(low, diagnostics)?;
                let mode = conversion.place(middle, diagnostics)?;
                let upper = conversion.place(high, diagnostics)?;
                if !(lower <= mode && mode <= upper && lower < upper) {
                    let message =
                        format!("a triangular prior [{}, {}, {}] is not in order", low.value, middle.value, high.value);
                    return invalid(&three.place, message, "[lower, most probable, upper]", diagnostics);
                }
                Distribution::Triangular { lower, mode, upper }
            }
            Self::Fixed(amount) => Distribution::Fixed(conversion.place(amount, diagnostics)?),
            Self::Posterior(form) => {
                let PosteriorForm { pass, job } = &form.value;
                return Some(Prior::Posterior {
                    pass: pass.value.clone(),
                    job: job.value.clone(),
                    place: form.place.clone(),
                });
            }
            Self::Draws(form) => {
                return Some(Prior::Draws { file: form.value.file.value.clone(), place: form.place.clone() });
            }
        };
        Some(Prior::Distribution(distribution))
    }
}

fn normal(
    form: &Spanned<NormalForm>,
    conversion: &Conversion<'_>,
    diagnostics: &mut Diagnostics,
) -> Option<Distribution> {
    let mean = conversion.place(&form.value.mean, diagnostics);
    let sd = conversion.width(&form.value.sd, diagnostics);
    let mut bound = |amount: &Option<Amount>| match amount {
        None => Some(None),
        Some(amount) => conversion.place(amount, diagnostics).map(Some),
    };
    let (lower, upper) = (bound(&form.value.lower), bound(&form.value.upper));
    let (mean, sd, lower, upper) = (mean?, sd?, lower?, upper?);
    if let (Some(low), Some(high)) = (lower, upper)
        && low >= high
    {
        let message = "the normal prior's lower bound is not below its upper bound".to_owned();
        return invalid(&form.place, message, "\"lower\" below \"upper\"", diagnostics);
    }
    Some(Distribution::Normal { mean, sd, lower, upper })
}
