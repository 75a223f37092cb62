//! What a fitted effect amounts to where it acts as something that the model has already: the same law at another size. A load
//! taken back twice over is a sign error, one that is 4.19 times what was written a wrong unit, and a second path beside
//! an equal one may be a wrong number.
//!
//! Laws are compared, not data: heats, capacities, boundaries and readings with and without the effect are evaluated at a
//! few states of the inputs and temperatures, and are of one law where their ratio (or difference) is the same at all.

use crate::diagnosis::odds::narrow_prior::is_prior;
use crate::diagnosis::{Problem, Refit};
use crate::effect::Site;
use crate::expression::unit::CELSIUS_ZERO_K;
use crate::expression::{ExprId, Symbol, Unit};
use crate::math::functions::ln;
use crate::thermal::{Model, NodeKind};

/// States at which laws are compared.
const STATES: usize = 6;
/// Relative difference below which two ratios are the same.
const SAME: f64 = 1e-9;
/// Standard deviations within which a size is a known one.
const WITHIN: f64 = 2.0;
/// Relative difference that a fit to a model in error may have in any case.
const NEAR: f64 = 0.005;
/// Relative standard deviation above which a size could be any.
const UNSURE: f64 = 0.02;

/// Factors between units that are taken for one another, with what they are.
const UNITS: [(f64, &str); 10] = [
    (1000.0, "a thousand: kW for W, kJ for J, mm for m"),
    (100.0, "a hundred: a percentage, or cm for m"),
    (4.1868, "cal for J"),
    (3.280_84, "ft for m"),
    (39.3701, "in for m"),
    (1.8, "degF for degC"),
    (3.412_14, "BTU/h for W"),
    (10.7639, "ft2 for m2"),
    (3600.0, "hours for seconds"),
    (60.0, "minutes for seconds"),
];

/// What an effect is beside something that the model has.
struct Likeness {
    /// What that is, such as `laser power`.
    of: String,
    /// How many times its size it has with the effect.
    times: f64,
    /// Standard deviation of that.
    sd: f64,
    /// Whether the effect stands beside it as a further element.
    is_beside: bool,
}

/// What is to be checked before an effect of a fitted set is believed.
pub(crate) fn hints(problem: &Problem, refit: &Refit, effect: usize) -> Vec<String> {
    let Some(spread) = spread(refit, effect) else { return Vec::new() };
    let (likenesses, offsets) = compared(problem, refit, effect, spread).unwrap_or_default();
    likenesses.iter().filter_map(likeness_words).chain(offsets.iter().filter_map(offset_words)).collect()
}

/// Relative standard deviation of an effect's only amplitude.
fn spread(refit: &Refit, effect: usize) -> Option<f64> {
    let position = refit.effects.iter().position(|&own| own == effect)?;
    let [only] = refit.amplitudes[position].as_slice() else { return None };
    (only.mode != 0.0 && !only.at_bound).then(|| (only.sd / only.mode).abs())
}

fn likeness_words(own: &Likeness) -> Option<String> {
    let Likeness { of, times, sd, is_beside } = own;
    let size = format!("`{of}` at {} times its value", with_sd(*times, *sd));
    let beside = if *is_beside { "It acts as" } else { "With it the model has" };
    // A load that is taken away twice over points the other way.
    if (times + 1.0).abs() <= (WITHIN * sd).max(NEAR) && *sd <= 5.0 * UNSURE {
        return Some(format!(
            "{beside} {size}: this is the size of a sign error. Check the sign in the model or the file first."
        ));
    }
    if *times > 0.0 && sd / times <= UNSURE {
        let (size_ln, sd_ln) = (ln(*times), sd / times);
        let known = UNITS.iter().find(|(factor, _)| (size_ln.abs() - ln(*factor)).abs() <= (WITHIN * sd_ln).max(NEAR));
        if let Some((_, what)) = known {
            let way = if size_ln < 0.0 { ", the other way round" } else { "" };
            return Some(format!(
                "{beside} {size}: this is the size of a wrong unit ({what}{way}). Check the model or the file first."
            ));
        }
    }
    is_beside.then(|| format!("{beside} {size}: the same law at the same place. Check that number first."))
}

fn offset_words(own: &(String, f64, f64)) -> Option<String> {
    let (of, offset, sd) = own;
    ((offset.abs() - CELSIUS_ZERO_K).abs() <= (WITHIN * sd).max(0.5)).then(|| {
        format!("It shifts `{of}` by {offset:+.2} K: this is the size of degC taken for K. Check the model or the file first.")
    })
}

/// A number to two digits of its standard deviation.
fn with_sd(value: f64, sd: f64) -> String {
    let digits = if sd > 0.0 { (2.0 - (ln(sd) / core::f64::consts::LN_10).ceil()).clamp(0.0, 6.0) as usize } else { 3 };
    format!("{value:.digits$} \u{B1} {sd:.digits$}")
}

/// What the effect makes other than it was: likenesses, and shifts of temperatures with their standard deviations.
type Compared = (Vec<Likeness>, Vec<(String, f64, f64)>);

fn compared(problem: &Problem, refit: &Refit, effect: usize, spread: f64) -> Option<Compared> {
    let candidate = &problem.candidates[effect];
    let rest: Vec<usize> = refit.effects.iter().copied().filter(|&other| other != effect).collect();
    let known = refit.by_name();
    if let (true, Site::Parameter(index)) = (is_prior(candidate), &candidate.site) {
        let own = &problem.model.parameters[*index];
        let times = known.get(&own.name)? / own.nominal;
        let unit = Unit::parse(&own.unit).ok()?;
        // Of a temperature the zero is a matter of the unit.
        let is_scale = !unit.has_offset() && times.is_finite();
        let one = Likeness { of: own.name.clone(), times, sd: spread * times.abs(), is_beside: false };
        return Some((if is_scale { vec![one] } else { Vec::new() }, Vec::new()));
    }
    let without = problem.hypothesis(&rest, 1.0).ok()?;
    let all: Vec<usize> = rest.iter().copied().chain([effect]).collect();
    let mut with = problem.hypothesis(&all, 1.0).ok()?;
    let mut before = Laws::new(without.model, &known);
    let added = with.model.elements.len().saturating_sub(before.model.elements.len());
    let mut likenesses = Vec::new();
    let mut offsets = Vec::new();
    let changes = std::mem::take(&mut with.measurements);
    let mut after = Laws::new(with.model, &known);
    let first = before.model.elements.len();
    for element in 0..first {
        let (old, new) = (before.heats(element), after.heats(element));
        if let Some(times) = ratio(&new, &old).filter(|times| *times != 1.0) {
            likenesses.push(after.likeness(element, times, (times - 1.0).abs() * spread, false));
        }
    }
    for element in first..first + added {
        let new = after.heats(element);
        for known in 0..first {
            let old = before.heats(known);
            if let Some(times) = ratio(&new, &old) {
                likenesses.push(before.likeness(known, 1.0 + times, times.abs() * spread, true));
            }
        }
    }
    for node in 0..before.model.nodes.len() {
        match (before.model.nodes[node].kind, after.model.nodes[node].kind) {
            (NodeKind::Diffusion { capacity: old }, NodeKind::Diffusion { capacity: new }) => {
                let (old, new) = (before.values(old), after.values(new));
                if let Some(times) = ratio(&[(node, new)], &[(node, old)]).filter(|times| *times != 1.0) {
                    let of = format!("capacity of {}", before.model.nodes[node].name);
                    likenesses.push(Likeness { of, times, sd: (times - 1.0).abs() * spread, is_beside: false });
                }
            }
            (NodeKind::Boundary { temperature: old }, NodeKind::Boundary { temperature: new }) => {
                let (old, new) = (before.values(old), after.values(new));
                if let Some(shift) = difference(&new, &old).filter(|shift| *shift != 0.0) {
                    offsets.push((before.model.nodes[node].name.clone(), shift, shift.abs() * spread));
                }
            }
            _ => {}
        }
    }
    if let Site::Sensors(sensors) = &candidate.site {
        for sensor in sensors {
            let own = changes.iter().flat_map(|own| &own.sensors).find(|own| own.name == sensor.name)?;
            let old = without.measurements.iter().flat_map(|own| &own.sensors).find(|own| own.name == sensor.name)?;
            let old = before.values(before.model.quantities[old.quantity].value.expression());
            let new = after.values(after.model.quantities[own.quantity].value.expression());
            if let Some(shift) = difference(&new, &old).filter(|shift| *shift != 0.0) {
                offsets.push((sensor.name.clone(), shift, shift.abs() * spread));
            }
            // A gain turns about 0 degC.
            let above = |values: &[f64]| vec![(0, values.iter().map(|value| value - CELSIUS_ZERO_K).collect())];
            if let Some(times) = ratio(&above(&new), &above(&old)).filter(|times| *times != 1.0) {
                let of = format!("reading of {} in degC", sensor.name);
                likenesses.push(Likeness { of, times, sd: (times - 1.0).abs() * spread, is_beside: false });
            }
        }
    }
    Some((likenesses, offsets))
}

/// A model whose expressions are evaluated at a few states.
struct Laws {
    model: Model,
    parameters: Vec<f64>,
}

impl Laws {
    fn new(model: Model, known: &std::collections::BTreeMap<String, f64>) -> Self {
        let value = |own: &crate::thermal::Parameter| known.get(&own.name).copied().unwrap_or(own.nominal);
        let parameters = model.parameters.iter().map(value).collect();
        Self { model, parameters }
    }

    /// Of a heat that an element gives each node, the values at the states.
    fn heats(&mut self, element: usize) -> Vec<(usize, Vec<f64>)> {
        let Model { graph, elements, .. } = &mut self.model;
        let heats = elements[element].contribution(graph, &mut Vec::new(), false).heat;
        heats.into_iter().map(|(node, heat)| (node, self.values(heat))).collect()
    }

    /// An expression at every state: inputs spread over their ranges, nodes over 200 K, so that two laws are equal at all
    /// only where they are one.
    fn values(&self, expression: ExprId) -> Vec<f64> {
        let share = |state: usize, index: u32, step: f64| {
            let at = 0.137 + step * (state as f64 + 1.0) + 0.381 * f64::from(index);
            at - at.floor()
        };
        let at = |state: usize| {
            self.model.graph.evaluate(expression, &|symbol| match symbol {
                Symbol::Parameter(index) => self.parameters.get(index as usize).copied().unwrap_or(f64::NAN),
                Symbol::Input(index) => {
                    let [lower, upper] = crate::effect::Bound::Input(index as usize).range(&self.model);
                    lower + share(state, index, 0.271) * (upper - lower)
                }
                Symbol::Node(index) => 200.0 + 200.0 * share(state, index, 0.619),
                Symbol::Time => 1000.0 * (state as f64 + 1.0),
                Symbol::Mode(_) => 1.0,
                Symbol::Local(_) | Symbol::Output(_) => f64::NAN,
            })
        };
        (0..STATES).map(at).collect()
    }

    fn likeness(&self, element: usize, times: f64, sd: f64, is_beside: bool) -> Likeness {
        Likeness { of: self.model.elements[element].name.clone(), times, sd, is_beside }
    }
}

/// The ratio of two laws that are one but for it; `None` where they are not, or do nothing.
fn ratio(new: &[(usize, Vec<f64>)], old: &[(usize, Vec<f64>)]) -> Option<f64> {
    let mut found: Option<f64> = None;
    if new.len() != old.len() {
        return None;
    }
    for (node, new) in new {
        let (_, old) = old.iter().find(|(own, _)| own == node)?;
        for (new, old) in new.iter().zip(old) {
            let own = new / old;
            if !own.is_finite() {
                return None;
            }
            match found {
                Some(known) if (own - known).abs() > SAME * known.abs().max(1.0) => return None,
                Some(_) => {}
                None => found = Some(own),
            }
        }
    }
    found.filter(|times| *times != 0.0)
}

/// The difference of two temperatures that is the same at all states.
fn difference(new: &[f64], old: &[f64]) -> Option<f64> {
    let first = new.first()? - old.first()?;
    let is_same = new.iter().zip(old).all(|(new, old)| ((new - old) - first).abs() <= SAME * new.abs());
    is_same.then_some(first)
}
