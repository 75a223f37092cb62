//! An adopted effect as a pass file has it: place, inputs, parameters with the catalogue's priors, and the reason in
//! words.

use std::fmt::Write as _;

use crate::diagnosis::output::{Amount, EffectResult, RmseChange};
use crate::diagnosis::verdict::numbers::kelvins_before_and_after;
use crate::diagnosis::{Output, wider};
use crate::document::prior::support;
use crate::document::{Sense, suggest};
use crate::effect::parameter::widened;
use crate::effect::{Bound, Effect, EffectParameter};
use crate::expression::Unit;
use crate::math::sort::sort_by_key;
use crate::random::Distribution;
use crate::thermal::Model;

use super::text::Item;
use crate::study::resolve::adopt::in_celsius;
use crate::study::resolve::belongs_to;
use crate::study::resolved::Pass;

/// Rivals that a reason names.
const MOST_RIVALS: usize = 6;

/// Fields of a prior in the order in which they are written.
const PRIOR_FIELDS: &[&str] = &["mean", "sd", "lower", "upper", "median", "factor"];

/// What the effect's inputs stand for, in the order of its file. `None` where the finding's names are not the model's.
pub fn bound(effect: &Effect, finding: &EffectResult, model: &Model) -> Option<Vec<Bound>> {
    let inputs: Vec<_> = effect.form.inputs.iter().filter(|entry| entry.value.clock().is_none()).collect();
    let find = |position: usize, name: &str| {
        let input = model.inputs.iter().position(|input| input.name == name).map(Bound::Input);
        let node = model.nodes.iter().position(|node| node.name == name).map(Bound::Node);
        input.into_iter().chain(node).find(|&bound| inputs[position].value.fits(model, bound))
    };
    let mut named = match (&finding.input, inputs.len()) {
        (None, 0) => Vec::new(),
        // A node that a sensor's reading depends on is part of the sensor's place.
        (None, 1) => vec![find(0, finding.place.get(1)?)?],
        (Some(input), count) => split(input, count, &find)?,
        (None, _) => return None,
    }
    .into_iter();
    let all = effect.form.inputs.iter();
    all.map(|entry| match entry.value.clock() {
        Some(clock) => model.clocks.get(clock).map(Bound::Input),
        None => named.next(),
    })
    .collect()
}

/// Names joined by `*`, a name for each input; a node's name may hold the sign itself.
fn split(text: &str, count: usize, find: &dyn Fn(usize, &str) -> Option<Bound>) -> Option<Vec<Bound>> {
    fn rest(
        text: &str,
        at: usize,
        count: usize,
        find: &dyn Fn(usize, &str) -> Option<Bound>,
        so_far: &mut Vec<Bound>,
    ) -> bool {
        if at + 1 >= count {
            return find(at, text).map(|bound| so_far.push(bound)).is_some();
        }
        text.match_indices('*').any(|(place, _)| {
            let Some(bound) = find(at, &text[..place]) else { return false };
            so_far.push(bound);
            let fits = rest(&text[place + 1..], at + 1, count, find, so_far);
            if !fits {
                so_far.pop();
            }
            fits
        })
    }
    let mut bound = Vec::new();
    (count > 0 && rest(text, 0, count, find, &mut bound)).then_some(bound)
}

/// Entries of an object.
pub type Fields = Vec<(String, Item)>;

/// A parameter at the value that the diagnosis fitted: the nominal value of the entry, and the number of its reason.
#[derive(Clone, Debug)]
pub struct Fitted {
    name: String,
    /// In the entry's unit, to four digits.
    value: f64,
    /// Standard deviation in the same unit.
    sd: f64,
    unit: String,
}

impl Fitted {
    fn in_words(&self) -> String {
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        let value = crate::document::canonical::float(self.value).unwrap_or_default();
        let sd = Some(self.sd).filter(|sd| *sd > 0.0);
        let sd = sd.map_or(String::new(), |sd| format!("; standard deviation {}{unit}", significant(sd, 2)));
        format!("; {} {value}{unit} (most probable{sd})", self.name.replace('_', " "))
    }
}

/// What stands under `effect`, and the values that were fitted.
pub fn usage(effect: &Effect, finding: &EffectResult, bound: &[Bound], model: &Model) -> (Item, Vec<Fitted>) {
    let mut fields = vec![("where".to_owned(), place(finding))];
    let is_in_place = finding.input.is_none();
    if !bound.is_empty() && !is_in_place {
        let names = effect.form.inputs.iter().zip(bound).filter(|(entry, _)| entry.value.clock().is_none());
        let inputs = names.map(|(entry, bound)| (entry.name.clone(), Item::text(bound.name(model)))).collect();
        fields.push(("inputs".to_owned(), Item::Object(inputs)));
    }
    if let Some(reference_k) = finding.reference_k {
        let amount = [("value", Item::number(in_celsius(reference_k))), ("unit", Item::text("degC"))];
        fields.push(("reference".to_owned(), Item::Object(amount.map(|(name, item)| (name.to_owned(), item)).into())));
    }
    let mut parameters: Vec<(String, Item)> = Vec::new();
    let mut fitted_amplitudes = Vec::new();
    for parameter in effect.parameters(model, bound) {
        let unit = unit(effect, &parameter, bound, model);
        let fitted = finding.amplitudes.get(&parameter.name).and_then(|amplitude| fitted(&parameter, amplitude, &unit));
        // A curve's knots are described together; each has a size of its own.
        let is_knot = parameter.name != parameter.written;
        if !parameters.iter().any(|(name, _)| *name == parameter.written) {
            let nominal = fitted.as_ref().filter(|_| !is_knot);
            let item = self::parameter(effect, &parameter, finding, nominal, &unit);
            parameters.push((parameter.written.clone(), item));
        }
        if let Some(fitted) = fitted {
            if is_knot {
                parameters.push((parameter.name, Item::one("nominal", Item::number(fitted.value))));
            }
            fitted_amplitudes.push(fitted);
        }
    }
    if !parameters.is_empty() {
        fields.push(("parameters".to_owned(), Item::Object(parameters)));
    }
    (Item::one(&effect.name, Item::Object(fields)), fitted_amplitudes)
}

/// The priors of the start temperatures of the nodes that an effect adds, by measurement. Parts of a measurement, and members
/// of a group, have one that holds them all.
pub fn starts(finding: &EffectResult, pass: &Pass) -> Option<Item> {
    let unit = Unit::parse("degC").ok()?;
    let mut entries = Vec::new();
    let mut written: Vec<&str> = Vec::new();
    for measurement in &pass.measurements {
        if !written.iter().any(|whole| belongs_to(&measurement.name, whole)) {
            written.push(&measurement.name);
        }
    }
    for name in written {
        let own: Vec<_> = finding.starts.iter().filter(|start| belongs_to(&start.measurement, name)).collect();
        if own.is_empty() {
            continue;
        }
        let mean = own.iter().map(|start| start.prior_k[0]).sum::<f64>() / own.len() as f64;
        let sd = own.iter().map(|start| start.prior_k[1]).fold(0.0, f64::max);
        let lower = own.iter().map(|start| start.bounds_k[0]).fold(f64::INFINITY, f64::min);
        let upper = own.iter().map(|start| start.bounds_k[1]).fold(0.0, f64::max);
        let prior = Distribution::Normal { mean, sd, lower: Some(lower), upper: Some(upper) };
        // The bounds are kept by rounding of the nominal value as well.
        let found = own.iter().map(|start| start.most_probable_k).sum::<f64>() / own.len() as f64;
        let found = rounded(in_unit(found, &unit, Sense::Absolute));
        let is_allowed = prior.log_density(unit.to_si(found)).is_finite();
        let mut start = vec![
            ("prior".to_owned(), distribution(&prior, &unit, Sense::Absolute)),
            ("unit".to_owned(), Item::text("degC")),
        ];
        start.extend(is_allowed.then(|| ("nominal".to_owned(), Item::number(found))));
        entries.push((name.to_owned(), Item::Object(start)));
    }
    (!entries.is_empty()).then_some(Item::Object(entries))
}

fn place(finding: &EffectResult) -> Item {
    match (finding.where_kind.as_str(), finding.place.as_slice()) {
        ("group", [name]) => Item::one("group", Item::text(name)),
        (_, [name]) => Item::text(name),
        (_, names) => Item::List(names.iter().map(|name| Item::text(name)).collect()),
    }
}

/// Unit, nominal value and prior. The nominal value is the one that the diagnosis fitted, else the catalogue's where it
/// states one: at the prior's median, the model as delivered with the effect would be nobody's model.
fn parameter(
    effect: &Effect,
    parameter: &EffectParameter,
    finding: &EffectResult,
    fitted: Option<&Fitted>,
    unit: &Unit,
) -> Item {
    let mut fields = Vec::new();
    let fitted = fitted.map(|fitted| Item::number(fitted.value));
    let form = effect.form.parameters.get(&parameter.written).map(|entry| &entry.value);
    let catalogue_field = |field: &str| effect.json.pointer(&format!("/parameters/{}/{field}", parameter.written));
    // What the diagnosis took for the amplitude's prior; the catalogue's would pull it back.
    let width = Some(finding.prior_width).filter(|width| parameter.amplitude && *width != 1.0);
    let prior = width.map_or(parameter.prior, |width| widened(parameter.prior, width));
    fields.push(("unit".to_owned(), Item::text(&unit.text)));
    if let (Some(_), Some(in_file)) = (stated_unit(effect, parameter), catalogue_field("prior")) {
        let nominal = fitted.or_else(|| catalogue_field("nominal").map(catalogued));
        fields.extend(nominal.map(|nominal| ("nominal".to_owned(), nominal)));
        let is_other = width.is_some() || parameter.enlarged != 1.0;
        let wide = is_other.then(|| distribution(&prior, unit, parameter.sense));
        fields.push(("prior".to_owned(), wide.unwrap_or_else(|| catalogued(in_file))));
        return Item::Object(fields);
    }
    let stated = || form.is_some_and(|form| form.nominal.is_some());
    let catalogued = || Item::number(rounded(in_unit(parameter.nominal, unit, parameter.sense)));
    let nominal = fitted.or_else(|| stated().then(catalogued));
    fields.extend(nominal.map(|nominal| ("nominal".to_owned(), nominal)));
    fields.push(("prior".to_owned(), distribution(&prior, unit, parameter.sense)));
    Item::Object(fields)
}

/// The unit that the catalogue states for a parameter, where nothing of the model's inputs enters it.
fn stated_unit<'e>(effect: &'e Effect, parameter: &EffectParameter) -> Option<&'e Unit> {
    let form = effect.form.parameters.get(&parameter.written).map(|entry| &entry.value);
    form.filter(|form| form.per.is_empty()).and_then(|form| form.unit.as_ref()).map(|written| &written.unit)
}

/// The unit of a parameter's entry: as the catalogue states it with its prior, else as it follows from what the effect's
/// inputs stand for.
fn unit(effect: &Effect, parameter: &EffectParameter, bound: &[Bound], model: &Model) -> Unit {
    let has_prior = effect.json.pointer(&format!("/parameters/{}/prior", parameter.written)).is_some();
    let stated = stated_unit(effect, parameter).filter(|_| has_prior).cloned();
    stated.unwrap_or_else(|| bound_unit(effect, parameter, bound, model))
}

/// What the diagnosis fitted, in a unit and to four digits; nothing where it is 0, which is no effect, or lies outside
/// the prior.
fn fitted(parameter: &EffectParameter, amplitude: &Amount, unit: &Unit) -> Option<Fitted> {
    let amplitude_unit =
        Unit::parse(&amplitude.unit).ok().filter(|parsed_unit| parsed_unit.dimension == unit.dimension)?;
    let value = amplitude.most_probable;
    let si = match parameter.sense {
        Sense::Absolute => amplitude_unit.to_si(value),
        Sense::Difference => amplitude_unit.difference_to_si(value),
    };
    let short: f64 = format!("{:.3e}", in_unit(si, unit, parameter.sense)).parse().ok()?;
    let back = match parameter.sense {
        Sense::Absolute => unit.to_si(short),
        Sense::Difference => unit.difference_to_si(short),
    };
    let [lower, upper] = support(&parameter.prior);
    let sd = unit.difference_from_si(amplitude_unit.difference_to_si(amplitude.sd));
    let is_usable = short != 0.0 && !parameter.prior.is_fixed() && lower <= back && back <= upper;
    is_usable.then(|| Fitted { name: parameter.name.clone(), value: short, sd, unit: unit.text.clone() })
}

/// Nominal value and prior of a parameter whose own prior is too narrow; the former is the one that the diagnosis fitted, which
/// is given beside them.
pub fn wider_prior(finding: &EffectResult, pass: &Pass, name: &str) -> Option<(Fields, Option<Fitted>)> {
    let index = pass.model.parameters.iter().position(|declared| declared.name == name)?;
    let model_parameter = &pass.model.parameters[index];
    let unit = Unit::parse(&model_parameter.unit).ok()?;
    let prior = wider(pass.priors.get(index)?, &model_parameter.unit, finding.prior_width)?;
    let mut fields = Vec::new();
    let fitted = finding.amplitudes.iter().next().and_then(|(name, amplitude)| {
        let value = format!("{:.3e}", amplitude.most_probable).parse().ok()?;
        Some(Fitted { name: name.clone(), value, sd: amplitude.sd, unit: model_parameter.unit.clone() })
    });
    fields.extend(fitted.iter().map(|fitted| ("nominal".to_owned(), Item::number(fitted.value))));
    fields.push(("prior".to_owned(), distribution(&prior, &unit, Sense::Absolute)));
    Some((fields, fitted))
}

/// A value of the catalogue, as its file has it.
fn catalogued(value: &serde_json::Value) -> Item {
    use serde_json::Value;
    match value {
        Value::Array(items) => Item::List(items.iter().map(catalogued).collect()),
        Value::Object(fields) => {
            let mut fields: Vec<_> = fields.iter().map(|(name, value)| (name.clone(), catalogued(value))).collect();
            sort_by_key(&mut fields, |(name, _)| PRIOR_FIELDS.iter().position(|field| field == name));
            Item::Object(fields)
        }
        Value::String(text) => Item::text(text),
        Value::Number(number) => Item::number(number.as_f64().unwrap_or(f64::NAN)),
        other => Item::Raw(other.to_string()),
    }
}

/// The unit of a parameter that has an input's, or is divided by those of inputs: as they write it.
fn bound_unit(effect: &Effect, parameter: &EffectParameter, bound: &[Bound], model: &Model) -> Unit {
    let of = |input: &str| -> Option<Unit> {
        let position = effect.form.inputs.iter().position(|entry| entry.name == input)?;
        match *bound.get(position)? {
            Bound::Node(_) => None,
            Bound::Input(index) => Unit::parse(&model.inputs[index].unit).ok(),
        }
    };
    let form = effect.form.parameters.get(&parameter.written).map(|entry| &entry.value);
    let composed = form.and_then(|form| {
        if let Some(like) = &form.unit_of {
            return of(&like.value);
        }
        let mut below: Vec<(String, usize)> = Vec::new();
        for input in &form.per {
            let unit = of(&input.value)?;
            let text = unit.difference_text();
            match below.iter_mut().find(|(unit_below, _)| unit_below == text) {
                Some((_, power)) => *power += 1,
                None => below.push((text.to_owned(), 1)),
            }
        }
        let simple = |text: &str| text.chars().all(char::is_alphabetic);
        let below: Vec<String> = (below.iter().filter(|(text, _)| text != "1"))
            .map(|(text, power)| match (simple(text), power) {
                (true, 1) => text.clone(),
                (true, power) => format!("{text}{power}"),
                (false, power) => vec![format!("({text})"); *power].join(" "),
            })
            .collect();
        let own_unit = &form.unit.as_ref()?.unit.text;
        let text = match below.as_slice() {
            [] => own_unit.clone(),
            [one] if !one.contains(' ') => format!("{own_unit}/{one}"),
            several => format!("{own_unit}/({})", several.join(" ")),
        };
        Unit::parse(&text).ok()
    });
    composed.filter(|unit| unit.dimension == parameter.unit.dimension).unwrap_or(Unit::si(parameter.unit.dimension))
}

/// A value of a unit.
fn in_unit(si: f64, unit: &Unit, sense: Sense) -> f64 {
    match sense {
        Sense::Absolute => unit.from_si(si),
        Sense::Difference => unit.difference_from_si(si),
    }
}

/// To six significant digits, which an engineer can still read.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// A prior in a unit.
fn distribution(prior: &Distribution, unit: &Unit, sense: Sense) -> Item {
    let place = |si: f64| in_unit(si, unit, sense);
    let width = |si: f64| Item::number(rounded(unit.difference_from_si(si)));
    let single = |si: f64| Item::number(rounded(place(si)));
    let list = |values: &[f64]| {
        let exact: Vec<f64> = values.iter().map(|&si| place(si)).collect();
        let short: Vec<f64> = exact.iter().map(|&value| rounded(value)).collect();
        // Bounds that are closer than six digits tell are written in full.
        let kept = |from: &f64, to: &f64| to - from > 0.999 * (exact[exact.len() - 1] - exact[0]);
        let is_kept = exact.len() < 2 || kept(&short[0], &short[short.len() - 1]);
        Item::List((if is_kept { short } else { exact }).into_iter().map(Item::number).collect())
    };
    match *prior {
        Distribution::Fixed(value) => Item::one("fixed", single(value)),
        Distribution::Uniform { lower, upper } => Item::one("uniform", list(&[lower, upper])),
        Distribution::LogUniform { lower, upper } => Item::one("loguniform", list(&[lower, upper])),
        Distribution::Triangular { lower, mode, upper } => Item::one("triangular", list(&[lower, mode, upper])),
        Distribution::HalfNormal { scale } => Item::one("halfnormal", width(scale)),
        Distribution::LogNormal { median, factor } => Item::one(
            "lognormal",
            Item::Object(vec![("median".to_owned(), single(median)), ("factor".to_owned(), Item::number(factor))]),
        ),
        Distribution::Normal { mean, sd, lower, upper } => {
            let mut fields = vec![("mean".to_owned(), single(mean)), ("sd".to_owned(), width(sd))];
            fields.extend(lower.map(|lower| ("lower".to_owned(), single(lower))));
            fields.extend(upper.map(|upper| ("upper".to_owned(), single(upper))));
            Item::one("normal", Item::Object(fields))
        }
    }
}

/// Why an effect is adopted, from the diagnosis; sizes are the nominal values of its entry.
pub fn because(finding: &EffectResult, fitted: &[Fitted], diagnosis: &Output, job: &str, pass: &str) -> String {
    let mut text = String::new();
    let verdict = diagnosis.verdict.word();
    if diagnosis.supports(finding) {
        let _ = write!(text, "diagnosis `{job}` of {pass}: {verdict}");
    } else {
        let selected = match diagnosis.selected.as_slice() {
            [] => "no effect".to_owned(),
            ids => suggest::listed(ids.iter().map(String::as_str), MOST_RIVALS),
        };
        let _ = write!(
            text,
            "adopted against diagnosis `{job}` of {pass}, whose verdict is `{verdict}` and which selected {selected}"
        );
    }
    let _ = write!(text, "; probability {}", probability_text(finding.probability));
    let _ = write!(text, ", log Bayes factor {:.1}", finding.log_bayes_factor);
    for (name, amplitude) in &finding.amplitudes {
        let fitted_amplitude = fitted.iter().find(|fitted| fitted.name == *name);
        text.push_str(&fitted_amplitude.map_or_else(|| amplitude_text(name, amplitude), Fitted::in_words));
    }
    text.push_str(&rmse_text(&finding.rmse_k));
    let rivals: Vec<&str> = diagnosis.confused_with(finding).map(|other| other.id.as_str()).collect();
    if !rivals.is_empty() {
        let _ = write!(text, "; these data cannot tell it from {}", suggest::listed(rivals, MOST_RIVALS));
    }
    text
}

/// The job that supports an effect, with the probability and the standard deviations of sizes that it states.
pub fn evidence(finding: &EffectResult, fitted: &[Fitted], job: &str, pass: &str) -> Item {
    let mut fields = vec![("pass".to_owned(), Item::text(pass)), ("job".to_owned(), Item::text(job))];
    // Of what is nearly certain the digits that tell by how much it is not.
    let doubt = 1.0 - finding.probability;
    let probability = if doubt < 0.01 { 1.0 - to_digits(doubt, 2) } else { to_digits(finding.probability, 3) };
    fields.push(("probability".to_owned(), Item::number(probability)));
    let with_error = fitted.iter().filter(|fitted| fitted.sd > 0.0);
    let sd: Fields = with_error.map(|fitted| (fitted.name.clone(), Item::number(to_digits(fitted.sd, 2)))).collect();
    if !sd.is_empty() {
        fields.push(("sd".to_owned(), Item::Object(sd)));
    }
    Item::Object(fields)
}

/// Three decimals; what is that near 1 says by how much it is not.
pub fn probability_text(value: f64) -> String {
    if value > 0.9995 { "above 0.999".to_owned() } else { format!("{value:.3}") }
}

/// A size that is no nominal value, such as 0.
fn amplitude_text(name: &str, amplitude: &Amount) -> String {
    let unit = if amplitude.unit == "1" { String::new() } else { format!(" {}", amplitude.unit) };
    format!("; {} {}{unit}", name.replace('_', " "), significant(amplitude.most_probable, 4))
}

fn significant(value: f64, digits: usize) -> String {
    crate::document::canonical::float(to_digits(value, digits)).unwrap_or_default()
}

fn to_digits(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value)
}

/// `; RMSE 0.71 K -> 0.26 K, on held-out readings 0.83 K -> 0.27 K`, as far as it is known.
fn rmse_text(rmse: &RmseChange) -> String {
    let pair = |pair: [Option<f64>; 2]| match pair {
        [Some(before), Some(after)] => {
            let [before, after] = kelvins_before_and_after([before, after]);
            Some(format!("{before} K -> {after} K"))
        }
        _ => None,
    };
    match (pair(rmse.train), pair(rmse.held_out)) {
        (Some(train), Some(held_out)) => format!("; RMSE {train}, on held-out readings {held_out}"),
        (Some(train), None) => format!("; RMSE {train}"),
        (None, Some(held_out)) => format!("; RMSE on held-out readings {held_out}"),
        (None, None) => String::new(),
    }
}
