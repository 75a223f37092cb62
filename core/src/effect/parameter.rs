//! The parameters of an effect at a place of a model: units, priors and scales in SI.

use crate::document::{Diagnostics, MapEntry, Sense};
use crate::expression::{Dimension, Unit};
use crate::random::Distribution;
use crate::thermal::Model;

use super::checked::{Effect, KNOT, Like};
use super::form::{ParameterForm, Sign};
use super::place::{Bound, TEMPERATURE_RANGE_K};

/// Share of the measured time, or of a run, at its beginning and at its end within which nothing changes at a time: what begins with the
/// record was there before it, and a start that is stated a little wrong would look like it.
const NO_CHANGE_WITHIN: f64 = 0.02;

/// A parameter of an effect at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectParameter {
    /// Its name in the effect, such as `conductance`; `knot_1`, `knot_2`, ... of a curve.
    pub name: String,
    /// Its name in the effect's file: `knot` of a curve's.
    pub written: String,
    /// Its unit.
    pub unit: Unit,
    /// Whether a value in its unit is a place on a scale or a difference.
    pub sense: Sense,
    /// Prior, SI.
    pub prior: Distribution,
    /// Nominal value, SI.
    pub nominal: f64,
    /// Which signs are physical.
    pub sign: Sign,
    /// Values at which an effect that is not smooth at 0 is tried, SI.
    pub probes: Vec<f64>,
    /// Scale of plausible amplitudes, SI.
    pub plausible: f64,
    /// How many times the catalogue's sizes these are, since the model's hardware is that much larger.
    pub enlarged: f64,
    /// Whether it is an amplitude: the effect vanishes while all are 0.
    pub amplitude: bool,
    /// What it is.
    pub description: String,
}

impl ParameterForm {
    /// A parameter whose unit has a zero of its own (degC) is a temperature; a difference else.
    pub(super) fn sense(&self) -> Sense {
        let offset = self.unit.as_ref().is_some_and(|written| written.unit.has_offset());
        if offset || self.unit_of.is_some() { Sense::Absolute } else { Sense::Difference }
    }
}

/// A distribution of a multiple of its variable; `factor` is above 0.
pub fn scaled(distribution: Distribution, factor: f64) -> Distribution {
    use Distribution::{Fixed, HalfNormal, LogNormal, LogUniform, Normal, Triangular, Uniform};
    let by = |value: f64| value * factor;
    match distribution {
        Fixed(value) => Fixed(by(value)),
        Uniform { lower, upper } => Uniform { lower: by(lower), upper: by(upper) },
        Normal { mean, sd, lower, upper } => {
            Normal { mean: by(mean), sd: by(sd), lower: lower.map(by), upper: upper.map(by) }
        }
        LogNormal { median, factor } => LogNormal { median: by(median), factor },
        LogUniform { lower, upper } => LogUniform { lower: by(lower), upper: by(upper) },
        HalfNormal { scale } => HalfNormal { scale: by(scale) },
        Triangular { lower, mode, upper } => Triangular { lower: by(lower), mode: by(mode), upper: by(upper) },
    }
}

/// A prior whose normal part is so many times as wide; its bounds, and what is no normal distribution, stay.
pub fn widened(distribution: Distribution, factor: f64) -> Distribution {
    match distribution {
        Distribution::Normal { mean, sd, lower, upper } => Distribution::Normal { mean, sd: sd * factor, lower, upper },
        Distribution::HalfNormal { scale } => Distribution::HalfNormal { scale: scale * factor },
        other => other,
    }
}

/// The SI unit of a dimension over others as people read it: `W/Pa`, not `m3/s`.
pub fn si_per(above: Dimension, below: &[Dimension]) -> Unit {
    let plain = Unit::si(below.iter().fold(above, |dimension, divisor| dimension.over(*divisor)));
    let mut above = above.to_string();
    let mut powers: Vec<(String, usize)> = Vec::new();
    for text in below.iter().map(Dimension::to_string).filter(|text| text != "1") {
        if text == above {
            above = "1".to_owned();
            continue;
        }
        match powers.iter_mut().find(|(symbol, _)| *symbol == text) {
            Some((_, power)) => *power += 1,
            None => powers.push((text, 1)),
        }
    }
    let raised = |(text, power): (String, usize)| match (text.chars().all(char::is_alphabetic), power) {
        (true, 1) => text,
        (true, power) => format!("{text}{power}"),
        // A name made of several, such as `W/m2`.
        (false, power) => vec![format!("({text})"); power].join(" "),
    };
    let parts: Vec<String> = powers.into_iter().map(raised).collect();
    let text = match parts.as_slice() {
        [] => above,
        [one] if !one.contains(' ') => format!("{above}/{one}"),
        several => format!("{above}/({})", several.join(" ")),
    };
    Unit::parse(&text).ok().filter(|unit| unit.dimension == plain.dimension && unit.factor == 1.0).unwrap_or(plain)
}

impl Effect {
    /// Index of an input of the effect.
    pub(super) fn input(&self, name: &str) -> Option<usize> {
        self.form.inputs.iter().position(|entry| entry.name == name)
    }

    /// The parameters where each input of the effect, in the order of its file, stands for one of `bound`.
    pub fn parameters(&self, model: &Model, bound: &[Bound]) -> Vec<EffectParameter> {
        let mut parameters = Vec::new();
        for entry in &self.form.parameters {
            let one = self.parameter(entry, model, bound);
            match &self.form.adds.value.curve {
                Some(curve) if entry.name == KNOT => {
                    let knots = (1..=curve.knots.value).map(|knot| format!("{KNOT}_{knot}"));
                    parameters.extend(knots.map(|name| EffectParameter { name, ..one.clone() }));
                }
                _ => parameters.push(one),
            }
        }
        parameters
    }

    fn parameter(&self, entry: &MapEntry<ParameterForm>, model: &Model, bound: &[Bound]) -> EffectParameter {
        let form = &entry.value;
        let find = |name: &str| self.input(name).and_then(|index| bound.get(index)).copied();
        let mut parameter = EffectParameter {
            name: entry.name.clone(),
            written: entry.name.clone(),
            unit: Unit::si(Dimension::NONE),
            sense: form.sense(),
            prior: Distribution::Fixed(0.0),
            nominal: 0.0,
            sign: form.sign,
            probes: Vec::new(),
            plausible: 0.0,
            enlarged: 1.0,
            amplitude: !form.shape,
            description: form.description.clone().unwrap_or_default(),
        };
        if form.unit_of.is_some() {
            let (dimension, [lower, upper]) = match self.like(form) {
                Some(Like::OwnTemperature) => (Some(Dimension::TEMPERATURE), TEMPERATURE_RANGE_K),
                Some(Like::Input(input)) => {
                    let Some(like) = bound.get(input) else { return parameter };
                    let [lower, upper] = like.range(model);
                    let edge = if like.is_clock(model) { NO_CHANGE_WITHIN * (upper - lower) } else { 0.0 };
                    (like.dimension(model), [lower + edge, upper - edge])
                }
                None => return parameter,
            };
            parameter.unit = Unit::si(dimension.unwrap_or(Dimension::NONE));
            parameter.prior = Distribution::Uniform { lower, upper };
            parameter.nominal = 0.5 * (lower + upper);
            parameter.plausible = upper - lower;
            return parameter;
        }
        let Some(written) = &form.unit else { return parameter };
        let stated_unit = &written.unit;
        // The file was checked: its numbers convert, and its prior is a distribution.
        let mut unheard = Diagnostics::new();
        let mut si = |amount: &crate::document::Amount| {
            amount.si(stated_unit.dimension, Some(stated_unit), form.sense(), &mut unheard).unwrap_or_default()
        };
        let nominal = form.nominal.as_ref().map(&mut si);
        let plausible = form.plausible.as_ref().map(&mut si);
        let probes: Vec<f64> = form.probes.iter().map(&mut si).collect();
        let prior = form.prior.as_ref().and_then(|prior| {
            prior.resolve(Some(stated_unit), stated_unit.dimension, form.sense(), &mut unheard)?.distribution().copied()
        });
        let prior = prior.unwrap_or(Distribution::Fixed(0.0));
        let mut below = Vec::new();
        let mut largest = 1.0;
        for input in form.per.iter().filter_map(|name| find(&name.value)) {
            below.push(input.dimension(model).unwrap_or(Dimension::NONE));
            largest *= input.largest(model);
        }
        parameter.enlarged = if self.embedded { enlarged(stated_unit.dimension, model) } else { 1.0 };
        let factor = parameter.enlarged / largest;
        parameter.unit = if form.per.is_empty() { stated_unit.clone() } else { si_per(stated_unit.dimension, &below) };
        parameter.prior = scaled(prior, factor);
        parameter.nominal = nominal.map_or_else(|| parameter.prior.quantile(0.5), |value| value * factor);
        parameter.probes = probes.into_iter().map(|value| value * factor).collect();
        parameter.plausible = plausible.map_or_else(|| spread(&parameter.prior), |value| value * factor);
        parameter
    }
}

/// Median of the nodes' heat capacities for which the catalogue's sizes are meant, J/K: an instrument's.
const MEANT_FOR_J_PER_K: f64 = 500.0;
/// The same of what meets at a node, W/K.
const MEANT_FOR_W_PER_K: f64 = 1.0;

/// From so many times an instrument's on the catalogue's sizes grow with the hardware: they are known to a factor of ten at best.
const CLEARLY_LARGER: f64 = 10.0;

/// How many times the catalogue's sizes are plausible in a model: as many as its nodes store or exchange more than an instrument's.
/// A satellite's panel or a house has leaks and parts in proportion; smaller hardware keeps the catalogue's, as small sizes are
/// plausible anywhere.
fn enlarged(dimension: Dimension, model: &Model) -> f64 {
    let of = |text: &str| Unit::parse(text).map(|unit| unit.dimension).ok();
    // What melts is a part of what stores heat: the catalogue's is that of 100 K of an instrument's node.
    let ratio = if ["J/K", "J"].into_iter().any(|stored| Some(dimension) == of(stored)) {
        model.size().capacity / MEANT_FOR_J_PER_K
    } else if ["W", "W/K", "W/K^1.25", "W/(K Pa)", "m2"].into_iter().any(|heat| Some(dimension) == of(heat)) {
        model.size().conductance / MEANT_FOR_W_PER_K
    } else {
        return 1.0;
    };
    if ratio >= CLEARLY_LARGER { ratio.min(1e9) } else { 1.0 }
}

/// A scale of a prior: half the distance between its 16 % and 84 % quantiles.
fn spread(prior: &Distribution) -> f64 {
    0.5 * (prior.quantile(0.84) - prior.quantile(0.16))
}
