//! An effect in words: its size, when it sets in, what it carries, what else may be it.

use crate::diagnosis::Problem;
use crate::diagnosis::odds::prior_scale::{IMPLAUSIBLE, WIDTHS};
use crate::diagnosis::output::{Amount, EffectResult};
use crate::diagnosis::verdict::numbers::{degrees, short, stated, stated_amount, with_error};
use crate::diagnosis::verdict::small_effects::IS_MODEL_ERROR;
use crate::document::percent;
use crate::document::time::unit_of_time;
use crate::effect::candidate::GROUP;
use crate::expression::Unit;
use crate::expression::unit::CELSIUS_ZERO_K;
use crate::math::sort::sort_by;
use crate::measurement::{Rows, calendar};
use crate::random::Distribution;
use crate::thermal::Clock;

/// The first parameter of a curve.
const FIRST_KNOT: &str = "knot_1";

/// Standard deviations between the mean and the most probable value from which both are stated.
const ELSEWHERE: f64 = 0.1;

/// Start temperatures that are stated of an effect.
const MOST_STARTS: usize = 3;

/// The size of an effect, after a comma: its first parameter but that of its onset, and but one that says at which value of
/// something else it acts. Nothing for one that has none, and for a curve,
/// of which the first knot says nothing. The most probable value, which `bmv adopt` writes, stands beside a mean that lies elsewhere.
pub fn size(effect: &EffectResult, onset: Option<&Amount>) -> String {
    let is_onset = |amount: &Amount| onset.is_some_and(|onset| std::ptr::eq(onset, amount));
    let is_size = |amount: &Amount| !is_onset(amount) && amount.level.is_none();
    let first = effect.amplitudes.iter().find(|(_, amount)| is_size(amount)).filter(|(name, _)| *name != FIRST_KNOT);
    first.map_or_else(String::new, |(name, amount)| {
        let (times, unit) = stated_amount(amount);
        if amount.at_bound {
            return format!(", {name} {}{unit}, at a bound", short(times * amount.value, 3));
        }
        let mean = with_error(times * amount.value, times * amount.sd);
        if (amount.most_probable - amount.value).abs() <= ELSEWHERE * amount.sd {
            return format!(", {name} {mean}{unit}");
        }
        format!(
            ", {name} {mean}{unit} (most probable with all others {}{unit})",
            short(times * amount.most_probable, 4)
        )
    })
}

/// The reference temperature of a law of temperature, and at which value of an input or a node an effect acts, after a comma.
pub fn level(effect: &EffectResult) -> String {
    let one = |(name, amount): (&String, &Amount)| {
        let level = amount.level.as_ref()?;
        let (value, unit) = match level.is_temperature {
            true => (amount.value - CELSIUS_ZERO_K, " degC".to_owned()),
            false => (amount.value, stated(&amount.unit, 1.0).1),
        };
        let value = if amount.at_bound { short(value, 3) } else { with_error(value, amount.sd) };
        let at_bound = if amount.at_bound { " (at a bound)" } else { "" };
        Some(format!(", {name} at `{}` = {value}{unit}{at_bound}", level.of))
    };
    // A whole number of degrees.
    let celsius = |reference_k: f64| (reference_k - CELSIUS_ZERO_K).round();
    let reference = effect.reference_k.map(|own| format!(" (reference temperature {} degC)", celsius(own)));
    reference.into_iter().chain(effect.amplitudes.iter().filter_map(one)).collect()
}

/// When an effect sets in, after a comma: between two phases, at a time, or so long after every start.
pub(super) fn onset(effect: &EffectResult, problem: &Problem) -> String {
    let Some((clock, amount)) = timed(effect, problem) else { return String::new() };
    if clock == Clock::Elapsed {
        return format!(", from {} after each start on", instant(amount.value, amount));
    }
    let (mut phases, mut runs): (Vec<(f64, &str)>, Vec<Run<'_>>) = Default::default();
    for measurement in &problem.measurements {
        let level = |row: usize| measurement.level(&problem.model, row, problem.model.clocks.get(clock)?);
        match &measurement.rows {
            Rows::Steady(own) => {
                let levels = own.iter().enumerate().filter_map(|(row, phase)| Some((level(row)?, phase.name.as_str())));
                phases.extend(levels);
            }
            Rows::Transient { inputs, .. } => {
                let ends = level(0).zip(measurement.len().checked_sub(1).and_then(level));
                let begins_s = inputs.times_s.first().copied().unwrap_or(0.0);
                runs.extend(ends.map(|(from, to)| Run { name: &measurement.name, from, to, begins_s }));
            }
        }
    }
    if phases.is_empty()
        && let Some(words) = in_runs(amount, runs)
    {
        return words;
    }
    sort_by(&mut phases, |a, b| a.0.total_cmp(&b.0));
    let after = phases.partition_point(|phase| phase.0 <= amount.most_probable);
    match (after.checked_sub(1).map(|before| phases[before].1), phases.get(after)) {
        (Some(before), Some((_, after))) => format!(", between the phases {before} and {after}"),
        _ => {
            let when = instant(amount.value, amount);
            let since = effect.since.as_ref().map_or_else(String::new, |since| format!(" ({since})"));
            format!(", from {when}{since} on")
        }
    }
}

/// A transient on the clock of dates.
#[derive(Clone, Debug, PartialEq)]
pub struct Run<'a> {
    /// Its name.
    pub name: &'a str,
    /// The date of its first row, s.
    pub from: f64,
    /// The date of its last row, s.
    pub to: f64,
    /// The time of its first row as its file states it, s.
    pub begins_s: f64,
}

/// Share of a run's length by which a date may lie beside its end and be between two runs.
const BESIDE: f64 = 0.005;

/// Share of all runs' time from which on a standard deviation says hardly anything of a date. Where nothing is known it is 0.29.
const IS_OPEN: f64 = 0.2;

/// Whether the readings hardly tell when a change sets in.
fn is_open(amount: &Amount, runs: &[Run<'_>]) -> bool {
    let first = runs.iter().map(|run| run.from).reduce(f64::min);
    let last = runs.iter().map(|run| run.to).reduce(f64::max);
    first.zip(last).is_some_and(|(first, last)| amount.sd >= IS_OPEN * (last - first) && last > first)
}

/// When a change at a date sets in, where several transients follow one another: in which of them and at which of its times, or
/// between which. `None` where there are less than two, unless the readings leave the date open.
pub fn in_runs(amount: &Amount, mut runs: Vec<Run<'_>>) -> Option<String> {
    sort_by(&mut runs, |a, b| a.from.total_cmp(&b.from));
    let date = amount.most_probable;
    let is_open = is_open(amount, &runs);
    let is_between = |pair: &[Run<'_>]| {
        let least = |run: &Run<'_>| BESIDE * (run.to - run.from);
        let beside = |run: &Run<'_>| match is_open {
            true => least(run),
            false => amount.sd.max(least(run)).min(0.5 * (run.to - run.from)),
        };
        pair[0].to - beside(&pair[0]) <= date && date <= pair[1].from + beside(&pair[1])
    };
    if let Some(pair) = runs.windows(2).find(|pair| is_between(pair)) {
        return Some(format!(", between `{}` and `{}`", pair[0].name, pair[1].name));
    }
    let is_alone = runs.len() < 2;
    if is_alone && !is_open {
        return None;
    }
    let run = runs.iter().rfind(|run| run.from <= date)?;
    let of_run = if is_alone { String::new() } else { format!(" of `{}`", run.name) };
    let within = |date: f64| if is_alone { date } else { date - run.from + run.begins_s };
    if is_open {
        let most_probable = within(date);
        let (length, unit) = unit_of_time(most_probable);
        let value = short(most_probable / length, 2);
        return Some(format!(", from a date that is open, most probably {value} {unit}{of_run}"));
    }
    Some(format!(", from {}{of_run} on", instant(within(amount.value), amount)))
}

/// A time with its error, in the unit that suits it; of no time in the unit that it has.
fn instant(value: f64, amount: &Amount) -> String {
    let (length, unit) = if amount.unit == "s" { unit_of_time(value) } else { (1.0, amount.unit.as_str()) };
    format!("{} {unit}", with_error(value / length, amount.sd / length))
}

/// Date and time from which on an effect is there, where that is known.
pub(super) fn since(effect: &EffectResult, problem: &Problem) -> Option<String> {
    let (_, amount) = timed(effect, problem).filter(|(clock, _)| *clock == Clock::Date)?;
    calendar(&problem.model, &problem.measurements, amount.most_probable)
}

/// The parameter that says when an effect sets in, and by which clock.
pub(super) fn timed<'e>(effect: &'e EffectResult, problem: &Problem) -> Option<(Clock, &'e Amount)> {
    let own = problem.catalogue.get(&effect.effect)?;
    let clock = Clock::ALL.into_iter().find(|&clock| own.depends_on(clock))?;
    let is_time = |name: &str| own.form.parameters.get(name).is_some_and(|form| form.value.unit_of.is_some());
    let (_, amount) = effect.amplitudes.iter().find(|(name, _)| is_time(name))?;
    Some((clock, amount))
}

/// That a prior is too narrow, and by how much.
pub(super) fn too_narrow(effect: &EffectResult, problem: &Problem) -> String {
    let name = effect.place.first().map_or("", String::as_str);
    let own = problem.model.parameters.iter().zip(&problem.priors).find(|(own, _)| own.name == name);
    let held = own.map_or_else(String::new, |(own, prior)| {
        let unit = Unit::parse(&own.unit).ok();
        let shown = |si: f64| short(unit.as_ref().map_or(si, |unit| unit.from_si(si)), 3);
        let (lower, upper) = prior.support();
        let ends = match prior {
            Distribution::Normal { .. } | Distribution::LogNormal { .. } | Distribution::HalfNormal { .. } => {
                format!("{} to {} (95 %)", shown(prior.quantile(0.025)), shown(prior.quantile(0.975)))
            }
            _ => format!("{} to {}", shown(lower), shown(upper)),
        };
        let text = if own.unit == "1" { String::new() } else { format!(" {}", own.unit) };
        format!(", and its prior says {ends}{text}")
    });
    let wanted = effect.amplitudes.values().next().map_or_else(String::new, |amount| {
        let (times, unit) = stated_amount(amount);
        format!(" wants to be {}{unit}", with_error(times * amount.value, times * amount.sd))
    });
    format!(
        "A prior is too narrow, or a number is wrong: `{name}`{wanted}{held} ({}); probability {}, log Bayes factor {:.1}. Check this before anything is added to the model.",
        effect.id,
        percent(effect.probability),
        effect.log_bayes_factor
    )
}

/// Probability below which it is not said that errors of the model may be what an effect explains.
const LEAST_MODEL_ERROR: f64 = 0.05;

/// What would read the same as an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Likeness<'a> {
    /// A gradient within its node.
    Gradient,
    /// A source or a store of heat.
    Source,
    /// What was peculiar to each of a few phases.
    Phases,
    /// Errors of lumped nodes, of this size in K.
    LumpedNodes(f64),
    /// What the fitted rows want more and the held-out rows contradict.
    Failing,
    /// An effect that explains more by holding a temperature, K, where the readings dwell.
    Holding(&'a str, f64),
    /// Nothing in particular.
    None,
}

/// That errors of the model itself, or what else reads the same, may be what an effect explains.
pub fn or_model_error(effect: &EffectResult, likeness: Likeness<'_>) -> String {
    if effect.model_error >= IS_MODEL_ERROR {
        // What is said of its size is why, where it is implausible.
        let is_implausible = effect.prior_width >= WIDTHS[IMPLAUSIBLE].factor && !effect.within_model;
        let words = match (likeness, is_implausible) {
            (Likeness::Gradient, _) => {
                "A gradient within the node would read the same: divide the node to see. Half of the probability is given to that."
            }
            (Likeness::Source, _) => {
                "These surroundings are warmer than every boundary: a part that stores or makes heat would read the same. Half of the probability is given to that."
            }
            (Likeness::Phases, _) => {
                "There are hardly more phases than the curve has values: what was peculiar to each phase would read the same. Half of the probability is given to that."
            }
            (Likeness::Failing, _) => {
                "The fitted rows want more what fails on the held-out ones: something that neither of them describes may be missing, and half of the probability is given to that."
            }
            (Likeness::Holding(other, level_k), _) => {
                return format!(
                    " `{other}` would be more probable, but only because its threshold is at {} degC, where a control of the logged heat holds the \
                     readings: there it lowers the error whatever is missing. Half of the probability is given to something that neither of \
                     the two describes.",
                    degrees(level_k)
                );
            }
            (Likeness::LumpedNodes(size_k), _) => {
                return format!(
                    " Errors of {} K, such as lumped nodes have where temperatures vary as here, make a third of what it explains or more: half of the probability is given to them.",
                    short(size_k, 1)
                );
            }
            (Likeness::None, true) => {
                "Errors of the model itself may be all that it stands for: half of the probability is given to them."
            }
            (Likeness::None, false) => {
                "It explains less than what else is missing: errors of the model itself may be all that it stands for, so that half of the probability is given to them."
            }
        };
        return format!(" {words}");
    }
    if effect.model_error < LEAST_MODEL_ERROR {
        return String::new();
    }
    format!(" Errors of the model itself explain as much with probability {}.", percent(effect.model_error))
}

/// That the held-out rows alone ask for an effect.
pub fn asked_for(effect: &EffectResult) -> &'static str {
    let falls = matches!(effect.rmse_k.held_out, [Some(before), Some(after)] if after < before);
    if effect.log_bayes_factor < 0.0 && falls {
        " The fitted rows do not ask for it: the held-out rows alone do, and are no test of it any more."
    } else {
        ""
    }
}

/// That an effect is larger than thought.
pub(super) fn surprising(effect: &EffectResult) -> String {
    if effect.prior_width <= 1.0 {
        return String::new();
    }
    if effect.within_model {
        return " It is larger than the catalogue's usual sizes, but carries no more heat than the model moves."
            .to_owned();
    }
    format!(
        " It is larger than what the catalogue takes for plausible, whose prior had to be {} times as wide: can it be so large here?",
        effect.prior_width
    )
}

/// The heat that an effect moves, where it moves any.
pub fn carried(effect: &EffectResult) -> String {
    let (Some([least, most]), Some(first)) = (effect.watts, effect.carries.first()) else { return String::new() };
    let node = &first.node;
    let (size, unit) = match f64::max(least.abs(), most.abs()) {
        largest if largest >= 1e6 => (1e6, "MW"),
        largest if largest >= 1e3 => (1e3, "kW"),
        _ => (1.0, "W"),
    };
    let range = |least: f64, most: f64| match (short(least / size, 2), short(most / size, 2)) {
        (least, most) if least == most => format!("{least} {unit}"),
        (least, most) => format!("{least} to {most} {unit}"),
    };
    let is_over_time = effect.carries.iter().any(|own| own.phase.is_none());
    let means = if is_over_time { " (means over twelfths of each transient)" } else { "" };
    if effect.amplitudes.contains_key(FIRST_KNOT) {
        // A curve's level trades for whatever else is constant there.
        let swing = short((most - least) / size, 2);
        return format!(", heat that varies by {swing} {unit} into {node} ({}){means}", range(least, most));
    }
    // Every node of a group has its share.
    let [nor_from, nor_to] = match effect.where_kind == GROUP {
        true => [" and from no other node more", " and no other node more"],
        false => [""; 2],
    };
    if most <= 0.0 {
        return format!(", which takes {} from {node}{nor_from}{means}", range(-most, -least));
    }
    format!(", which gives {node} {}{nor_to}{means}", range(least, most))
}

/// Where the parts that an effect adds start, where that was inferred.
pub(super) fn started(effect: &EffectResult) -> String {
    let mut starts: Vec<String> = Vec::new();
    for start in effect.starts.iter().take(MOST_STARTS) {
        starts.push(format!("{:.1} degC in `{}`", start.most_probable_k - CELSIUS_ZERO_K, start.measurement));
    }
    match effect.starts.len() {
        0 => String::new(),
        all if all > MOST_STARTS => format!(", and starts at {} (and {} more)", starts.join(", "), all - MOST_STARTS),
        _ => format!(", and starts at {}", starts.join(", ")),
    }
}
