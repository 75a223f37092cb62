//! The verdict in sentences.

use crate::diagnosis::odds::medium::{is_pressure, is_vacuum};
use crate::diagnosis::odds::prior_scale::{IMPLAUSIBLE, WIDTHS};
use crate::diagnosis::output::{
    Amount, DiscriminatingExperiment, DiscriminatingStep, EffectResult, OneThing, OnlyInTransients, Output, RISES,
    Setting, StoryStep, Verdict,
};
use crate::diagnosis::screening::screen::AT_BOUNDS;
use crate::diagnosis::story::rises;
use crate::diagnosis::verdict::discriminating_experiment::is_worth_a_test;
use crate::diagnosis::verdict::findings::Findings;
use crate::diagnosis::verdict::small_effects::{IS_MODEL_ERROR, is_curve_of_few_phases};
use crate::diagnosis::verdict::tested::{self, FAR_BEYOND_K, Tested};
use crate::diagnosis::{PRIOR_OF, Problem, Refit};
use crate::document::{counted, p_stated, percent, upper};
use crate::effect::Effect;
use crate::expression::Unit;
use crate::expression::unit::CELSIUS_ZERO_K;
use crate::measurement::{Rows, calendar};
use crate::random::Distribution;
use crate::thermal::{Clock, Model};

/// The first parameter of a curve.
const FIRST_KNOT: &str = "knot_1";
/// Standard deviations between the mean and the most probable value from which both are stated.
const ELSEWHERE: f64 = 0.1;
/// Share of the model error that is allowed for below which what remains beside all steps is stated too.
const CLEARLY_LESS: f64 = 0.8;
/// Start temperatures that are stated of an effect.
const MOST_STARTS: usize = 3;
/// p at which a test is clear.
const CLEARLY: f64 = 1e-6;

/// The size of an effect, after a comma: its first parameter. Nothing for one that has none, and for a curve, of which the
/// first knot says nothing. The most probable value, which `bmv adopt` writes, stands beside a mean that lies elsewhere.
pub fn size(effect: &EffectResult) -> String {
    let first = effect.amplitudes.iter().next().filter(|(name, _)| *name != FIRST_KNOT);
    first.map_or_else(String::new, |(name, amount)| {
        let unit = if amount.unit == "1" { String::new() } else { format!(" {}", amount.unit) };
        if amount.at_bound {
            return format!(", {name} {}{unit}, at a bound", short(amount.value, 3));
        }
        let mean = with_error(amount.value, amount.sd);
        if (amount.most_probable - amount.value).abs() <= ELSEWHERE * amount.sd {
            return format!(", {name} {mean}{unit}");
        }
        format!(", {name} {mean}{unit} (most probable with all others {}{unit})", short(amount.most_probable, 4))
    })
}

/// When an effect sets in, after a comma: between two phases, at a time, or at a time into every run.
fn onset(effect: &EffectResult, problem: &Problem) -> String {
    let Some((clock, amount)) = timed(effect, problem) else { return String::new() };
    if clock == Clock::Elapsed {
        return format!(", from {} {} into every run on", with_error(amount.value, amount.sd), amount.unit);
    }
    let mut phases: Vec<(f64, &str)> = Vec::new();
    for measurement in &problem.measurements {
        let Rows::Steady(own) = &measurement.rows else { continue };
        let level = |row: usize| measurement.level(&problem.model, row, problem.model.clocks.get(clock)?);
        phases.extend(own.iter().enumerate().filter_map(|(row, phase)| Some((level(row)?, phase.name.as_str()))));
    }
    phases.sort_by(|a, b| a.0.total_cmp(&b.0));
    let after = phases.partition_point(|phase| phase.0 <= amount.most_probable);
    match (after.checked_sub(1).map(|before| phases[before].1), phases.get(after)) {
        (Some(before), Some((_, after))) => format!(", between the phases {before} and {after}"),
        _ => {
            // Stretches of a record are told in hours.
            let (scale, unit) = if amount.unit == "s" { (3600.0, "h") } else { (1.0, amount.unit.as_str()) };
            let when = with_error(amount.value / scale, amount.sd / scale);
            let since = effect.since.as_ref().map_or_else(String::new, |since| format!(" ({since})"));
            format!(", from {when} {unit}{since} on")
        }
    }
}

/// Date and time from which on an effect is there, where that is known.
pub(super) fn since(effect: &EffectResult, problem: &Problem) -> Option<String> {
    let (_, amount) = timed(effect, problem).filter(|(clock, _)| *clock == Clock::Date)?;
    calendar(&problem.model, &problem.measurements, amount.most_probable)
}

/// The parameter that says when an effect sets in, and by which clock.
fn timed<'e>(effect: &'e EffectResult, problem: &Problem) -> Option<(Clock, &'e Amount)> {
    let own = problem.catalogue.get(&effect.effect)?;
    let clock = Clock::ALL.into_iter().find(|&clock| own.depends_on(clock))?;
    let is_time = |name: &str| own.form.parameters.get(name).is_some_and(|form| form.value.unit_of.is_some());
    let (_, amount) = effect.amplitudes.iter().find(|(name, _)| is_time(name))?;
    Some((clock, amount))
}

/// That a prior is too narrow, and by how much.
fn too_narrow(effect: &EffectResult, problem: &Problem) -> String {
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
        let unit = if amount.unit == "1" { String::new() } else { format!(" {}", amount.unit) };
        format!(" wants to be {}{unit}", with_error(amount.value, amount.sd))
    });
    format!(
        "A prior is too narrow, or a number is wrong: `{name}`{wanted}{held} ({}); probability {}, log Bayes factor {:.1}. Check this before anything is added to the model.",
        effect.id,
        percent(effect.probability),
        effect.log_bayes_factor
    )
}

/// A sentence that goes on after a colon.
fn lower(sentence: &str) -> String {
    let mut letters = sentence.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// Probability below which it is not said that errors of the model may be what an effect explains.
const LEAST_MODEL_ERROR: f64 = 0.05;

/// What would read the same as an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Likeness {
    /// A gradient within its node.
    Gradient,
    /// A source or a store of heat.
    Source,
    /// What was peculiar to each of a few phases.
    Phases,
    /// Nothing in particular.
    None,
}

/// That errors of the model itself, or what else reads the same, may be what an effect explains.
pub fn or_model_error(effect: &EffectResult, likeness: Likeness) -> String {
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

/// That an effect is larger than thought.
fn surprising(effect: &EffectResult) -> String {
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
fn carried(effect: &EffectResult) -> String {
    let (Some([least, most]), Some(first)) = (effect.watts, effect.carries.first()) else { return String::new() };
    let node = &first.node;
    let range = |least: f64, most: f64| match (short(least, 2), short(most, 2)) {
        (least, most) if least == most => format!("{least} W"),
        (least, most) => format!("{least} to {most} W"),
    };
    if effect.amplitudes.contains_key(FIRST_KNOT) {
        // A curve's level trades for whatever else is constant there.
        let swing = short(most - least, 2);
        return format!(", heat that varies by {swing} W into {node} ({})", range(least, most));
    }
    if most <= 0.0 {
        return format!(", which takes {} from {node}", range(-most, -least));
    }
    format!(", which gives {node} {}", range(least, most))
}

/// Where the parts that an effect adds start, where that was inferred.
fn started(effect: &EffectResult) -> String {
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

/// A value and its spread, to two digits of the spread.
pub fn with_error(value: f64, sd: f64) -> String {
    let decimals = 1.0 - (crate::math::functions::ln(sd) / core::f64::consts::LN_10).floor();
    if sd > 0.0 && (0.0..=8.0).contains(&decimals) {
        let decimals = decimals as usize;
        return format!("{value:.decimals$} ± {sd:.decimals$}");
    }
    let largest = value.abs().max(sd);
    let power = (crate::math::functions::ln(largest) / core::f64::consts::LN_10).floor();
    // Far more digits than anybody reads, or nothing to divide by.
    if !(sd > 1e-6 * largest && largest < f64::INFINITY) || power == 0.0 {
        return format!("{} ± {}", short(value, 3), short(sd, 2));
    }
    // One power of ten for both.
    let unit = crate::math::functions::pow(10.0, power);
    format!("({})e{power}", with_error(value / unit, sd / unit))
}

/// A number to some significant digits.
pub fn short(value: f64, digits: usize) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 || !magnitude.is_finite() {
        // Not "-0".
        return format!("{}", value + 0.0);
    }
    let power = (crate::math::functions::ln(magnitude) / core::f64::consts::LN_10).floor();
    if !(-4.0..6.0).contains(&power) {
        return format!("{value:.*e}", digits - 1);
    }
    format!("{value:.*}", (digits as f64 - 1.0 - power).max(0.0) as usize)
}

/// The same without zeros at its end.
pub fn rounded(value: f64, digits: usize) -> String {
    let text = short(value, digits);
    text.parse::<f64>().map_or(text, |rounded| rounded.to_string())
}

/// How clear a misfit is, from the p-value of all tests together.
pub fn clearness(p: f64, false_alarm: f64) -> String {
    if p > false_alarm {
        return format!("the tests find no misfit in that ({})", p_stated(p));
    }
    format!("that is a misfit ({}, the probability of one as clear as this where nothing is missing)", p_stated(p))
}

/// That the effect which the fitted rows want most fails on the held-out ones.
fn fails_on_held_out(findings: &Findings<'_>) -> Option<String> {
    let step = findings.story.as_ref()?.steps.first()?;
    let most = step.additions.first()?;
    let [before, after] = [step.before, most.place].map(|place| findings.state.refits[place].rmse_held_out_k);
    let (before, after) = before.zip(after).filter(|(before, after)| rises([Some(*before), Some(*after)]))?;
    Some(format!(
        "What the fitted rows want most, {}, fails on the held-out rows: their error goes from {before:.2} to {after:.2} K.",
        findings.id(most.effect)
    ))
}

/// `a, b and c`.
fn joined(names: &[String]) -> String {
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => names.concat(),
    }
}

impl OnlyInTransients {
    /// That no steady phase can part the sets, and the step that does, in sentences.
    pub fn in_words(&self, model: &Model) -> String {
        format!("{}.", upper(&self.clause(model)))
    }

    /// The same in short.
    pub fn in_brief(&self, model: &Model) -> String {
        let none = "No steady phase can tell what stores heat apart";
        let Some(step) = &self.step else { return format!("{none}.") };
        let (what, time, probability) = (step.in_words(model), time(step.duration_s), percent(step.probability));
        let guess = if is_worth_a_test(step.probability) { "" } else { ", guessing with 50 %" };
        format!("{none}; {what}, watched for {time}, would with probability {probability}{guess}.")
    }

    /// The same at length, to follow a semicolon.
    pub fn clause(&self, model: &Model) -> String {
        let none = format!(
            "no steady phase can tell {} apart: they differ in what stores heat, which shows while temperatures change",
            joined(&self.between)
        );
        let Some(step) = &self.step else {
            return format!("{none}; a step of an input would, but none that can be set has a range");
        };
        let about = match (step.limits_ok, step.near_tested) {
            (false, _) => ", but red limits of a node are passed",
            (true, false) => ", but sensors would read far beyond all readings so far",
            (true, true) => "",
        };
        let beyond = if step.was_set { "" } else { ", farther than it was set so far" };
        let what = format!(
            "{}{beyond}, the other inputs as at the beginning of {}, watched for {} ({} time constants of {}, the slowest)",
            step.in_words(model),
            step.like,
            time(step.duration_s),
            rounded(step.duration_s / step.time_constant_s, 2),
            step.slowest,
        );
        let probability = percent(step.probability);
        match is_worth_a_test(step.probability) {
            true => format!("{none}; {what}, would with probability {probability}{about}"),
            false => format!(
                "{none}; no step within the stated ranges is worth a test by itself: the best, {what}, would with probability {probability}, guessing with 50 %{about}"
            ),
        }
    }
}

impl DiscriminatingStep {
    /// The step, as in `a step of P_heater from 0 to 10 W`.
    pub fn in_words(&self, model: &Model) -> String {
        let written = model.inputs.iter().find(|input| input.name == self.input).map(|input| input.unit.as_str());
        let unit = written.unwrap_or(self.from.unit.as_str());
        let parsed = Unit::parse(unit).ok();
        let shown =
            |setting: &Setting| rounded(parsed.as_ref().map_or(setting.value, |unit| unit.from_si(setting.value)), 3);
        let text = if unit == "1" { String::new() } else { format!(" {unit}") };
        format!("a step of {} from {} to {}{text}", self.input, shown(&self.from), shown(&self.to))
    }
}

/// A duration in the unit that suits it.
pub fn time(seconds: f64) -> String {
    match seconds {
        short_time if short_time < 120.0 => format!("{} s", rounded(short_time, 2)),
        middling if middling < 7200.0 => format!("{} min", rounded(middling / 60.0, 2)),
        long if long < 172_800.0 => format!("{} h", rounded(long / 3600.0, 2)),
        days => format!("{} d", rounded(days / 86_400.0, 2)),
    }
}

impl OneThing {
    /// That no phase parts the sets, in a sentence.
    pub fn in_words(&self) -> String {
        format!("{}.", upper(&self.clause()))
    }

    /// The same, to follow a semicolon.
    pub fn clause(&self) -> String {
        format!(
            "no steady phase within the stated ranges reliably tells {} apart: the best one does so with probability {}, a repeated one with {}, guessing with 50 %",
            joined(&self.sets),
            percent(self.probability),
            percent(self.repeat_probability)
        )
    }
}

/// A temperature difference, K: in hundredths, a smaller one to two digits.
fn kelvins(value: f64) -> String {
    if value < 0.095 { short(value, 2) } else { format!("{value:.2}") }
}

fn fall([before, after]: [Option<f64>; 2]) -> Option<String> {
    Some(format!("{} to {} K", kelvins(before?), kelvins(after?)))
}

/// What a step does to the errors, after a comma.
fn falls_to(step: &StoryStep) -> String {
    let held_out = fall(step.rmse_k.held_out).map_or_else(String::new, |fall| format!(", held out from {fall}"));
    fall(step.rmse_k.train).map_or_else(String::new, |fall| format!("; the error falls from {fall}{held_out}"))
}

/// Why a story ends; `is_outweighed` says whether what would be next is more probable than nothing.
pub fn ends(step: &StoryStep, is_outweighed: bool) -> Option<String> {
    if step.effect.is_some() {
        return None;
    }
    if let Some(next) = step.alternatives.first().filter(|_| is_outweighed) {
        return Some(format!(
            "No further step is taken: {next} would be more probable than nothing on the fitted rows, but the unseen rows are not predicted better with it."
        ));
    }
    let next = step.alternatives.first().map_or_else(String::new, |next| format!(" The next would be {next}."));
    Some(format!(
        "No further step is taken: with a probability of {} no effect is to be added.{next}",
        percent(step.probability)
    ))
}

/// What law the curve of an unknown function follows.
fn law(output: &Output, effect: &EffectResult, problem: &Problem) -> Option<String> {
    let is_curve = problem.catalogue.get(&effect.effect).is_some_and(Effect::is_unknown_function);
    if !is_curve {
        return None;
    }
    let is_law = |other: &&EffectResult| other.file.is_some() && other.group == effect.group;
    let Some((law, file)) = output.effects.iter().find(is_law).and_then(|law| Some((law, law.file.as_ref()?))) else {
        return Some(format!(
            "No simple law describes the curve of {} within its error: straight line, square, fourth power, exponential, saturation, step and first harmonic were fitted in its place as far as they fit its input.",
            effect.id
        ));
    };
    let sizes = law.amplitudes.iter().map(|(name, amount)| {
        let unit = if amount.unit == "1" { String::new() } else { format!(" {}", amount.unit) };
        format!("{name} {}{unit}", with_error(amount.value, amount.sd))
    });
    let form: Option<serde_json::Value> = serde_json::from_str(&file.text).ok();
    let equation =
        form.as_ref().and_then(|form| form["equation"].as_str()).map_or_else(String::new, |q| format!(", {q}"));
    let needless = match file.needless.as_slice() {
        [] => String::new(),
        ids => format!(
            " With it {} {} not needed: the straight pieces of the curve may be all that {} for.",
            joined(ids),
            if ids.len() == 1 { "is" } else { "are" },
            if ids.len() == 1 { "it stands" } else { "they stand" }
        ),
    };
    Some(format!(
        "A law describes the curve of {} within its error: {}{equation}, with {} (log Bayes factor {:.1} over the curve). `bmv adopt PASS {}` writes it as effects/{}.json and adopts it.{needless}",
        effect.id,
        file.law,
        joined(&sizes.collect::<Vec<_>>()),
        law.log_bayes_factor - effect.log_bayes_factor,
        law.id,
        file.name
    ))
}

/// How large the model error is: the one that is allowed for, which stands beside one or two effects, and what remains beside
/// all steps where that is clearly less.
fn model_error(output: &Output, chosen: &Refit) -> Option<String> {
    let sizes = output.noise.values().filter(|own| own.unit == "K");
    let of: Vec<(f64, f64, f64)> =
        sizes.filter_map(|own| Some((own.model_error?, own.sigma, own.counts_as?))).collect();
    let worst = of.iter().copied().reduce(|a, b| if b.0 > a.0 { b } else { a })?;
    let part = match output.misfit.rmse_k.held_out {
        Some(_) => " Held-out rows take part in the choice of the steps.",
        None => "",
    };
    let [sd, noise, counts_as] = [worst.0, worst.1, worst.2].map(|size| short(size, 2));
    let left = chosen.rmse_train_k.map(|rmse| (rmse * rmse - worst.1 * worst.1).max(0.0).sqrt());
    let alike = format!(
        "such errors are alike in readings that follow one another, so that each of these weighs as little as one with a noise of {counts_as} K.{part}"
    );
    Some(match left.filter(|left| *left < CLEARLY_LESS * worst.0) {
        Some(left) => format!(
            "The model is a little wrong everywhere: beside all that is found, a model error of {} K (standard deviation) remains, while the instruments' noise is {noise} K. Each step was weighed with the model error beside the most probable one or two effects, {sd} K: {alike}",
            short(left, 2)
        ),
        None => format!(
            "The model is a little wrong everywhere: beside what is found, a model error of {sd} K (standard deviation) remains, while the instruments' noise is {noise} K: {alike}"
        ),
    })
}

/// That a proposed phase goes far beyond all readings so far.
fn beyond_what_was_measured(experiment: &DiscriminatingExperiment, problem: &Problem) -> Option<String> {
    let tested = Tested::of(problem);
    let [low, high] = tested.temperatures_k?;
    let is_temperature = |name: &str| {
        let mut own = problem.measurements.iter().flat_map(|own| &own.sensors).filter(|sensor| sensor.name == name);
        own.any(|sensor| problem.model.quantities[sensor.quantity].is_temperature)
    };
    let predicted = experiment.predictions.iter().filter(|(sensor, _)| is_temperature(sensor));
    let predicted = predicted.flat_map(|(sensor, values)| values.iter().map(move |value| (sensor, *value)));
    let predicted = predicted.filter(|(_, value)| value.is_finite());
    let (sensor, value) = predicted.max_by(|a, b| tested.beyond_k(a.1).total_cmp(&tested.beyond_k(b.1)))?;
    (tested.beyond_k(value) > FAR_BEYOND_K).then(|| {
        format!(
            "There `{sensor}` would read {:.0} degC, while all readings so far lie between {:.0} and {:.0} degC: is the hardware made for that?",
            value - CELSIUS_ZERO_K,
            low - CELSIUS_ZERO_K,
            high - CELSIUS_ZERO_K
        )
    })
}

/// Probability from which an effect counts among those that may be missing.
const LIKELY: f64 = 0.01;
/// Effects that are said to need a gas.
const MOST_OF_GAS: usize = 3;

/// That effects which may be missing need a gas, where nothing tells whether there was any: how a study says that there was none.
pub fn of_gas(effects: &[EffectResult], problem: &Problem) -> Option<String> {
    let needs = |own: &&EffectResult| problem.catalogue.get(&own.effect).is_some_and(Effect::needs_gas);
    let has_pressure = problem.model.inputs.iter().any(is_pressure);
    let likely = effects.iter().filter(|own| own.probability >= LIKELY && !own.changes_nothing);
    let ids: Vec<String> = likely.filter(needs).map(|own| format!("`{}`", own.id)).take(MOST_OF_GAS).collect();
    (!ids.is_empty() && !has_pressure && !is_vacuum(problem)).then(|| {
        format!(
            "{} would take a gas. Was the test in vacuum? Then say so by an input of the model, which nothing has to use: \
             \"pressure\": {{\"unit\": \"Pa\", \"nominal\": 0.001}}.",
            ids.join(", ")
        )
    })
}

/// Inputs that the words on a proposed phase name.
const MOST_SETTINGS: usize = 4;
/// Share of the tested span by which a setting may lie outside it and count as tested.
const NEARLY_TESTED: f64 = 0.02;

/// That a proposed phase sets inputs to what no fitted data have: within the stated ranges, and perhaps beyond what the test can do.
pub fn beyond_what_was_set(experiment: &DiscriminatingExperiment, problem: &Problem) -> Option<String> {
    let mut outside: Vec<String> = Vec::new();
    for (index, input) in problem.model.inputs.iter().enumerate() {
        let Some(setting) = experiment.conditions.get(&input.name) else { continue };
        let Some([low, high]) = tested::input(&problem.measurements, index) else { continue };
        let near = NEARLY_TESTED * (high - low).abs();
        if (low - near..=high + near).contains(&setting.value) {
            continue;
        }
        let unit = Unit::parse(&input.unit).ok();
        let shown = |si: f64| short(unit.as_ref().map_or(si, |unit| unit.from_si(si)), 3);
        let text = if input.unit == "1" { String::new() } else { format!(" {}", input.unit) };
        let so_far = if low == high { shown(low) } else { format!("{} to {}", shown(low), shown(high)) };
        outside.push(format!("`{}` at {}{text} (so far {so_far}{text})", input.name, shown(setting.value)));
    }
    let more = outside.len().saturating_sub(MOST_SETTINGS);
    outside.truncate(MOST_SETTINGS);
    if more > 0 {
        outside.push(format!("{more} more"));
    }
    (!outside.is_empty()).then(|| {
        format!(
            "It sets what these data do not have: {}. What the test cannot set is kept out by a narrower `range` of that input in the model.",
            outside.join(", ")
        )
    })
}

/// The sentences: how wrong, what is missing, how sure, what it does to the error, what else it could be.
pub(crate) fn verdict(output: &Output, findings: &Findings<'_>, false_alarm: f64) -> Vec<String> {
    let mut words = Vec::new();
    let misfit = &output.misfit;
    let mut error = format!(
        "Tuned as far as its parameters allow, the model has a reduced chi-square of {:.2}",
        misfit.reduced_chi2
    );
    if let Some(train) = misfit.rmse_k.train {
        error.push_str(&format!(" and an RMSE of {} K on the fitted rows", kelvins(train)));
        if let Some(held_out) = misfit.rmse_k.held_out {
            error.push_str(&format!(", {} K on the held-out rows", kelvins(held_out)));
        }
    }
    if !findings.state.noise.is_empty() && findings.state.stated_family.is_none() {
        error.push_str(", by the noise that was estimated here (see noise)");
    }
    error.push_str(&format!("; {}.", clearness(misfit.family_wise_p, false_alarm)));
    words.push(error);
    if findings.shown_by_held_out && !output.selected.is_empty() {
        words.push(
            "The held-out rows show that something is missing: they are predicted far better with what follows."
                .to_owned(),
        );
    }
    if !findings.state.noise.is_empty() {
        words.push(
            "A calibration, `bmv compare` and `bmv history` take the noise as the pass states it or infer it beside the model as it is: their chi-square and RMSE are others."
                .to_owned(),
        );
    }
    words.extend(model_error(output, &findings.state.refits[findings.selected]));
    let selected: Vec<&EffectResult> =
        output.selected.iter().filter_map(|id| output.effects.iter().find(|effect| effect.id == *id)).collect();
    match output.verdict {
        Verdict::Adequate => {
            let unseen = &findings.state.screening.unseen;
            words.push(if unseen.len() >= findings.problem.candidates.len() {
                format!(
                    "These data would show none of {}, however large: they say nothing of what is missing.",
                    counted(output.looked_at[0], "effect")
                )
            } else {
                format!(
                    "Nothing is missing that these data could show: {} and {} were tried.",
                    counted(output.looked_at[0], "effect"),
                    counted(output.looked_at[1], "pair")
                )
            });
            if findings.doubted {
                words.push(format!(
                    "The tests find a misfit, but no effect is probable enough to explain it: that nothing is missing keeps a probability of {}. More data, or stated noise, would decide it.",
                    percent(output.probability_nothing)
                ));
            }
        }
        Verdict::Unexplained => {
            words.push(format!(
                "Something is missing, and none of {}, alone or in sets of up to {}, explains it: see the missing heat by node.",
                counted(output.looked_at[0], "effect"),
                findings.state.refits.iter().map(|refit| refit.effects.len()).max().unwrap_or(0)
            ));
            if findings.vetoed {
                words.push("What fits the fitted rows fails on the held-out ones.".to_owned());
            }
            words.extend(fails_on_held_out(findings));
        }
        Verdict::Identified | Verdict::Ambiguous => {
            // What invents nothing goes first.
            let is_prior = |effect: &&&EffectResult| effect.effect == PRIOR_OF;
            let likeness = |effect: &EffectResult| {
                let place = findings.problem.candidates.iter().position(|own| own.id == effect.id);
                match findings.problem.catalogue.get(&effect.effect).is_some_and(Effect::is_like_gradient) {
                    true => Likeness::Gradient,
                    false if place.is_some_and(|place| findings.is_source(place)) => Likeness::Source,
                    false if place.is_some_and(|place| is_curve_of_few_phases(findings.problem, place)) => {
                        Likeness::Phases
                    }
                    false => Likeness::None,
                }
            };
            for effect in selected.iter().filter(is_prior) {
                words.push(too_narrow(effect, findings.problem));
            }
            for effect in selected.iter().filter(|effect| !is_prior(effect)) {
                let is_settled = output.settled().iter().any(|settled| settled.id == effect.id);
                let head =
                    if output.verdict == Verdict::Identified || is_settled { "Missing" } else { "Perhaps missing" };
                let number = output.steps.iter().position(|step| step.effect.as_ref() == Some(&effect.id));
                let (head, errors) = match number {
                    Some(number) => (format!("Step {}, {}", number + 1, lower(head)), falls_to(&output.steps[number])),
                    None => (head.to_owned(), String::new()),
                };
                words.push(format!(
                    "{head}: {} ({}){}{}{}{}{errors}; probability {}, log Bayes factor {:.1}.{}{}",
                    effect.title,
                    effect.id,
                    size(effect),
                    onset(effect, findings.problem),
                    carried(effect),
                    started(effect),
                    percent(effect.probability),
                    effect.log_bayes_factor,
                    surprising(effect),
                    or_model_error(effect, likeness(effect))
                ));
            }
            let last = findings.story.as_ref().and_then(|story| story.steps.last());
            let is_outweighed =
                last.is_some_and(|last| last.additions.first().is_some_and(|next| next.probability > last.stays));
            words.extend(output.steps.last().and_then(|step| ends(step, is_outweighed)));
            for effect in &selected {
                words.extend(law(output, effect, findings.problem));
                words.extend(effect.hints.iter().map(|hint| format!("{}: {}", effect.id, lower(hint))));
            }
        }
    }
    if selected.len() > 1 {
        words.push(format!(
            "Of sets of several effects the most promising were fitted, not all: probabilities are among {}.",
            counted(output.looked_at[2], "set")
        ));
    }
    if !selected.is_empty() {
        let place = findings.selected;
        let (before, after) = (&findings.state.refits[0], &findings.state.refits[place]);
        let train = fall([before.rmse_train_k, after.rmse_train_k]);
        let held_out = fall([before.rmse_held_out_k, after.rmse_held_out_k]);
        if let Some(train) = train {
            let held_out = held_out.map_or_else(String::new, |fall| format!(", on the held-out rows from {fall}"));
            let with = if selected.len() == 1 { "With it" } else { "With them" };
            words.push(format!("{with} the RMSE on the fitted rows goes from {train}{held_out}."));
            if let (Some(before), Some(after)) = (before.rmse_held_out_k, after.rmse_held_out_k)
                && after > RISES * before
            {
                words.push(
                    "On the held-out rows the error rises: what was found need not hold beyond the rows that were fitted."
                        .to_owned(),
                );
            }
        }
    }
    let pressed = misfit.tests.iter().find(|test| test.name == AT_BOUNDS && test.p <= CLEARLY);
    if let Some(test) = pressed.filter(|_| output.verdict != Verdict::Adequate) {
        words.push(format!(
            "In the baseline model `{}` is pressed against an end of its prior ({}): is that prior wide enough?",
            test.at,
            p_stated(test.p)
        ));
    }
    let left = output.remaining_p.filter(|p| *p <= false_alarm && !findings.goes_first());
    if let Some(p) = left.filter(|_| !selected.is_empty()) {
        words.push(format!(
            "Tests still find something beside what is selected ({}): something smaller is missing too, or the noise is larger than stated.",
            p_stated(p)
        ));
    }
    if output.verdict == Verdict::Ambiguous {
        for (number, group) in findings.groups.iter().enumerate().filter(|(_, group)| group.len() > 1) {
            let ids: Vec<String> = group
                .iter()
                .map(|&effect| format!("{} ({})", findings.id(effect), percent(findings.probability(effect))))
                .collect();
            words.push(format!("These data cannot tell apart (group {}): {}.", number + 1, ids.join(", ")));
        }
        if findings.fewest_parameters {
            words.push(format!(
                "Tests still find something beside all of these ({}), so that the odds between them are too sure: the set with the fewest parameters is named first.",
                p_stated(output.remaining_p.unwrap_or(f64::NAN))
            ));
        }
        words.extend(of_gas(&output.effects, findings.problem));
        words.extend(output.one_thing.as_ref().map(OneThing::in_words));
        words.extend(output.only_in_transients.as_ref().map(|own| own.in_words(&findings.problem.model)));
        if let Some(experiment) = &output.discriminating_experiment {
            words.push(format!(
                "A steady phase at the conditions stated below would tell {} apart with probability {}; repeating the best old phase with {}.{}",
                joined(&experiment.between),
                percent(experiment.probability),
                percent(experiment.repeat_probability),
                if is_worth_a_test(experiment.probability) { "" } else { " Guessing does so with 50 %: it is not worth a test by itself." }
            ));
            words.extend(beyond_what_was_set(experiment, findings.problem));
            words.extend(beyond_what_was_measured(experiment, findings.problem));
        }
    }
    words
}
