//! Diagnosis: what physics is missing, how surely, what it does to the error, what else it could be.

mod brief;
mod detectable;
mod figures;
mod heat;
mod words;

use crate::diagnosis::Verdict;
use crate::diagnosis::output::{Amount, DiscriminatingExperiment, EffectResult, Output, RmseChange};
use crate::diagnosis::verdict::discriminating_experiment::is_worth_a_test;
use crate::diagnosis::verdict::experiment_words::repeated;
use crate::diagnosis::verdict::numbers::kelvins_before_and_after;
use crate::document::{counted, p_stated, p_value};
use crate::job::diagnose::Kind;
use crate::math::sort::sort_by;
use crate::measurement::Sensor;
use crate::report::number::{NONE, Shown, as_given, fixed, percent, significant, stated, with_error, with_unit};
use crate::report::page::{Block, Cell, Column, Section, Status, Table, Text, Tone};
use crate::report::view::PassReport;

use super::Entry;
pub(super) use words::{led_by_group, near_miss, one_of, proposed_first, since_s, since_start_s, size, unexplained};

/// Warnings that are printed.
const MOST_WARNINGS: usize = 2;
/// Effects in the table.
const MOST_EFFECTS: usize = 10;
/// Effects that stand in the table however improbable they are.
const LEAST_EFFECTS: usize = 3;
/// Probability below which an effect needs no line of its own.
const WORTH_A_LINE: f64 = 1e-3;
/// Sensors that the table of a discriminating experiment names.
const MOST_SENSORS: usize = 4;

/// The section, and its kind's results in brief.
pub(super) const SECTION: Entry = Entry::of_kind(build, &brief::Diagnosis);

/// The section on diagnoses; not without one.
pub(super) fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    let jobs = report.outputs::<Kind>().count();
    for (name, output) in report.outputs::<Kind>() {
        if jobs > 1 {
            blocks.push(Block::Heading(format!("Job {name}")));
        }
        let tone = if output.verdict == Verdict::Adequate { Tone::Note } else { Tone::Verdict };
        blocks.extend(before_the_verdict(output));
        blocks.push(Block::callout(tone, verdict(output)));
        blocks.push(Block::List(output.words.iter().map(|word| Text::with_names(word)).collect()));
        blocks.extend(warnings(output));
        blocks.extend(effects(output));
        blocks.extend(heat::carried(output));
        blocks.extend(figures::figures(name, output));
        blocks.extend(heat::missing(output));
        blocks.extend(heat::goes_with(report, output));
        blocks.extend(experiment(report, output));
        blocks.extend(tests(output));
        blocks.extend(noise(output));
        blocks.extend(detectable::table(output));
        blocks.push(Block::paragraph(method(output)));
    }
    (!blocks.is_empty()).then(|| Section { id: "diagnosis", title: "What is missing".into(), blocks })
}

fn change(values: [Option<f64>; 2]) -> String {
    match values {
        [Some(before), Some(after)] if before.is_finite() && after.is_finite() => {
            kelvins_before_and_after([before, after]).join(" \u{2192} ")
        }
        _ => NONE.to_owned(),
    }
}

/// What must be checked before the verdict is believed.
fn before_the_verdict(output: &Output) -> impl Iterator<Item = Block> {
    output.before_the_verdict().into_iter().map(|line| Block::callout(Tone::Warning, Text::with_names(&line)))
}

/// The verdict and what it means, in a line.
pub(super) fn verdict(output: &Output) -> Text {
    let meaning = match output.verdict {
        Verdict::Adequate => match near_miss(output) {
            Some(near) => {
                let text = Text::default().strong(output.verdict.word());
                return text.plain(": no effect is needed by the level of the tests, but ").joined(Some(near));
            }
            None => ": nothing is missing that these data could show.",
        },
        Verdict::Identified => ": one set of effects explains the misfit, and no rival comes near it.",
        Verdict::Ambiguous if is_partly_settled(output) => return partly_settled(output),
        Verdict::Ambiguous if output.is_without_rival() => {
            ": effects explain the misfit that have no rivals, but these data do not settle that they are there."
        }
        Verdict::Ambiguous => ": several sets of effects explain the misfit, and these data do not settle which.",
        Verdict::Unexplained => {
            return Text::default().strong(output.verdict.word()).plain(format!(": {}", unexplained(output)));
        }
    };
    Text::default().strong(output.verdict.word()).plain(meaning)
}

/// What is missing for sure of one selected effect: itself, or what all laws of its group are together.
fn settled(output: &Output, own: &EffectResult) -> Option<Text> {
    if output.settled().iter().any(|one| one.id == own.id) {
        return Some(Text::default().code(&own.id));
    }
    let kind = output.settled_kind_of(own)?;
    Some(Text::with_names(&kind.what).plain(format!(", {} is open", kind.open)))
}

/// Whether some of what is missing is settled, and not all of it down to its law.
fn is_partly_settled(output: &Output) -> bool {
    let selected = || output.selected.iter().filter_map(|id| output.effect(id));
    output.settled().len() < output.selected.len() && selected().any(|own| settled(output, own).is_some())
}

/// What of a verdict is settled, and that the rest is not.
fn partly_settled(output: &Output) -> Text {
    let selected = output.selected.iter().filter_map(|id| output.effect(id));
    let (mut text, mut count, mut is_open) =
        (Text::default().strong(output.verdict.word()).plain(": missing is "), 0, false);
    for own in selected {
        match settled(output, own) {
            Some(what) => {
                text = text.plain(if count == 0 { "" } else { "; and " }).joined(Some(what));
                count += 1;
            }
            None => is_open = true,
        }
    }
    text.plain(if is_open { "; what else is missing these data do not settle." } else { "." })
}

/// The first of the warnings, and how many more there are.
fn warnings(output: &Output) -> Vec<Block> {
    let mut texts: Vec<Text> = output.warnings.iter().take(MOST_WARNINGS).map(|text| Text::with_names(text)).collect();
    let more = output.warnings.len().saturating_sub(MOST_WARNINGS);
    if let Some(last) = texts.pop() {
        let more = if more > 0 { format!(" ({more} more: bmv diagnose --json lists them.)") } else { String::new() };
        texts.push(last.plain(more));
    }
    texts.into_iter().map(|text| Block::callout(Tone::Warning, text)).collect()
}

/// A probability as a percentage, honest at both ends.
pub(crate) fn chance(probability: f64) -> String {
    match probability {
        p if p < WORTH_A_LINE => "< 0.1\u{A0}%".to_owned(),
        p if p > 1.0 - WORTH_A_LINE => "> 99.9\u{A0}%".to_owned(),
        p => percent(p, 1),
    }
}

/// Areas below it are stated in cm², m².
const SMALL_AREA: f64 = 0.01;

/// A parameter as fitted, to the digits that its spread leaves sense in.
pub(crate) fn amount(amount: &Amount) -> String {
    // Areas of a few square centimetres are read as such.
    let is_small_area = amount.unit == "m2" && amount.value.abs() < SMALL_AREA && amount.sd < SMALL_AREA;
    let (factor, unit) = if is_small_area {
        (1e4, "cm\u{00B2}".to_owned())
    } else {
        stated(&amount.unit, amount.value.abs().max(amount.sd))
    };
    let (value, sd) = (factor * amount.value, factor * amount.sd);
    if amount.at_bound {
        return format!("{}, at a bound", with_unit(&significant(value, 3), &unit));
    }
    let is_nothing = value.abs() < 0.01 * sd;
    with_unit(&with_error(if is_nothing { 0.0 } else { value }, sd), &unit)
}

fn amplitudes(effect: &EffectResult) -> String {
    let is_open = |value: &Amount| value.sd > 3.0 * value.value.abs();
    let one = |(position, (name, value)): (usize, (&String, &Amount))| match position {
        0 => format!("{name} {}", amount(value)),
        _ if is_open(value) => format!("{name} open"),
        _ => format!("{name} {}", amount(value)),
    };
    if words::is_harmonic(effect) {
        return size(effect).map_or_else(String::new, |(name, size)| format!("{name} {size}"));
    }
    let is_setting = |own: &(&String, &Amount)| words::is_onset(own.0) || own.1.level.is_some();
    let (settings, sizes): (Vec<_>, Vec<_>) = effect.amplitudes.iter().partition(is_setting);
    // A size with the value at which it acts, or the time from which on it does, is one thing.
    let setting = settings.first().filter(|own| !sizes.is_empty() && !is_open(own.1));
    let setting = setting.map(|(name, value)| words::level(name, value).unwrap_or_else(|| words::onset(name, value)));
    let most = if setting.is_some() { 1 } else { 2 };
    let shown: Vec<String> = sizes.into_iter().chain(settings).enumerate().take(most).map(one).collect();
    let more = effect.amplitudes.len().saturating_sub(most + usize::from(setting.is_some()));
    let text = format!("{}{}", shown.join("; "), setting.unwrap_or_default());
    if more > 0 { format!("{text}; {more} more") } else { text }
}

/// Where an effect acts, and what it goes with.
fn place(effect: &EffectResult) -> Text {
    let mut text = Text::default();
    for (position, name) in effect.place.iter().enumerate() {
        text = text.plain(if position == 0 { "" } else { ", " }).code(name);
    }
    match &effect.input {
        Some(input) => text.plain(" with ").code(input),
        None => text,
    }
}

fn effects(output: &Output) -> Option<Block> {
    let is_selected = |effect: &EffectResult| output.selected.contains(&effect.id);
    let mut shown: Vec<&EffectResult> = Vec::new();
    // A fit that goes back to the model without the effect says only that it is not that.
    let (idle, others): (Vec<&EffectResult>, Vec<&EffectResult>) =
        output.effects.iter().partition(|effect| effect.changes_nothing && !is_selected(effect));
    for (position, &effect) in others.iter().enumerate() {
        let is_worth = effect.probability >= WORTH_A_LINE && position < MOST_EFFECTS;
        if position < LEAST_EFFECTS || is_worth || is_selected(effect) {
            shown.push(effect);
        }
    }
    let more = others.len() - shown.len();
    // A group of one has no rival.
    let in_group = |group: u64| others.iter().filter(|effect| effect.group == Some(group)).count();
    let group_of = |effect: &EffectResult| effect.group.filter(|group| in_group(*group) > 1);
    let has_rivals = shown.iter().any(|effect| group_of(effect).is_some());
    let rows = shown.into_iter().map(|effect| {
        let RmseChange { train, held_out } = effect.rmse_k;
        let rivals = group_of(effect).map_or_else(|| NONE.to_owned(), |group| format!("group {group}"));
        let mut row = vec![
            Cell { text: Text::default().code(&effect.effect), status: is_selected(effect).then_some(Status::Ok) },
            Cell { text: place(effect), status: None },
            chance(effect.probability).into(),
            fixed(effect.log_bayes_factor, 1).into(),
        ];
        row.extend(has_rivals.then(|| Cell::from(rivals)));
        row.extend([amplitudes(effect).into(), change(train).into(), change(held_out).into()]);
        row
    });
    let rows: Vec<Vec<Cell>> = rows.collect();
    let what = match output.verdict {
        Verdict::Adequate => Text::new("The effects that come nearest to what the noise leaves; none is needed."),
        Verdict::Unexplained if others.iter().any(|own| own.probability > output.probability_unexplained) => Text::new(
            "The effects that come nearest. None of them explains the misfit: half of each probability is given to \
             what no effect describes, and the rest compares them with one another.",
        ),
        Verdict::Unexplained => Text::new("The effects that come nearest; none of them explains the misfit."),
        _ => {
            let order = if output.steps.is_empty() {
                "the selected ones first, then by probability"
            } else {
                "the steps first"
            };
            let mut text = Text::new(format!("Effects that would explain the misfit, {order}; selected: "));
            for (position, id) in output.selected.iter().enumerate() {
                text = text.plain(if position == 0 { "" } else { ", " }).code(id);
            }
            text.plain(".")
        }
    };
    let mut left_out = match more {
        0 => String::new(),
        1 => " 1 more was fitted and is less probable: bmv diagnose --json lists it.".to_owned(),
        more => format!(" {more} more were fitted and are less probable: bmv diagnose --json lists them."),
    };
    match idle.len() {
        0 => {}
        1 => left_out.push_str(" Of 1 more the best size is one that changes nothing."),
        idle => left_out.push_str(&format!(" Of {idle} more the best size is one that changes nothing.")),
    }
    let meaning = if output.steps.is_empty() {
        "The probability counts every set that an effect belongs to; size and errors are those of its best set, before and \
         after it."
    } else {
        "The probability is that among all that may be added at the step, and nothing; size and errors are those of the step."
    };
    let alike = if has_rivals { " Effects of one group are rivals: these data cannot tell them apart." } else { "" };
    let caption = what.plain(format!(" {meaning}{alike}{left_out}"));
    let mut columns = vec![
        Column::text("Effect"),
        Column::text("Where"),
        Column::number("Probability", ""),
        Column::number("Log Bayes factor", ""),
    ];
    columns.extend(has_rivals.then(|| Column::text("Rivals")));
    columns.extend([Column::text("Size"), Column::number("RMSE, fitted", "K"), Column::number("RMSE, held out", "K")]);
    (!rows.is_empty()).then_some(Block::Table(Table { caption, columns, rows }))
}

fn experiment(report: &PassReport<'_>, output: &Output) -> Option<Block> {
    let experiment = output.discriminating_experiment.as_ref().filter(|own| is_worth_a_test(own.probability))?;
    let shown = |name: &str, unit: &str| {
        let input = report.model.inputs.iter().find(|input| input.name == name);
        input.map_or_else(|| Shown::quantity(unit, unit == "K"), |input| Shown::written(&input.unit))
    };
    let mut rows: Vec<Vec<Cell>> = experiment
        .conditions
        .iter()
        .map(|(name, setting)| {
            let shown = shown(name, &setting.unit);
            let value = with_unit(&as_given(round_to(shown.value(setting.value), 4)), &shown.unit);
            vec!["set".into(), Cell::code(name), value.into()]
        })
        .collect();
    let spread = |values: &[f64]| {
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        most - values.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let mut sensors: Vec<(&String, &Vec<f64>)> = experiment.predictions.iter().collect();
    sort_by(&mut sensors, |a, b| spread(b.1).total_cmp(&spread(a.1)));
    for (sensor, values) in sensors.into_iter().take(MOST_SENSORS) {
        let read: Vec<String> = values.iter().map(|value| Shown::celsius().number(*value)).collect();
        let read = with_unit(&read.join(" | "), "\u{B0}C");
        rows.push(vec!["then reads".into(), Cell::code(sensor), read.into()]);
    }
    let limits = if experiment.limits_ok { "" } else { " The red limits of a node are passed there." };
    let beyond = extrapolation(report, experiment).unwrap_or_default();
    let several = if experiment.predictions.is_empty() { "" } else { " Readings in the order of the rivals." };
    let again = repeated(experiment.repeat_probability);
    let again = again.map_or_else(String::new, |p| format!("; repeating the best old phase: {}", chance(p)));
    Some(Block::Table(Table {
        caption: format!(
            "A phase that would tell {} apart, with probability {}{again}.{several}{limits}{beyond}",
            experiment.between.join(" | "),
            chance(experiment.probability),
        )
        .into(),
        columns: vec![Column::text(""), Column::text("Input or sensor"), Column::text("Value")],
        rows,
    }))
}

/// Share of the measured span of temperatures by which a prediction may leave it before it counts as extrapolated.
const BEYOND: f64 = 0.1;

/// What must be said of a proposed phase in which the rivals predict temperatures far from all that were measured.
fn extrapolation(report: &PassReport<'_>, experiment: &DiscriminatingExperiment) -> Option<String> {
    let is_temperature =
        |sensor: &Sensor| report.model.quantities.get(sensor.quantity).is_some_and(|own| own.is_temperature);
    let readings = report.measurements.iter().flat_map(|own| {
        let sensors = own.sensors.iter().cycle();
        own.readings
            .iter()
            .zip(sensors)
            .filter(|(_, sensor)| is_temperature(sensor))
            .filter_map(|(reading, _)| *reading)
    });
    let [low, high] = range(readings)?;
    let [least, most] = range(experiment.predictions.values().flatten().copied())?;
    let allowed = BEYOND * (high - low);
    let shown = Shown::celsius();
    (most > high + allowed || least < low - allowed).then(|| {
        format!(
            " Extrapolated: measured were {} to {}; see first whether the hardware bears what is predicted.",
            shown.number(low),
            shown.text(high)
        )
    })
}

/// Least and largest of numbers.
fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |known: Option<[f64; 2]>, value| {
        Some(known.map_or([value; 2], |[low, high]| [low.min(value), high.max(value)]))
    })
}

/// A number rounded to so many significant digits.
fn round_to(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

fn tests(output: &Output) -> Option<Block> {
    let rows: Vec<Vec<Cell>> = output
        .misfit
        .tests
        .iter()
        .map(|test| {
            let at = if test.at.is_empty() { NONE.into() } else { Cell::code(&test.at) };
            vec![test.name.clone().into(), at, p_value(test.p).into()]
        })
        .collect();
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: format!("Tests of the tuned baseline model; together {}.", p_stated(output.misfit.family_wise_p))
                .into(),
            columns: vec![Column::text("Test"), Column::text("Worst at"), Column::number("p", "")],
            rows,
        })
    })
}

fn noise(output: &Output) -> Option<Block> {
    let estimated: Vec<_> = output.noise.iter().filter(|(_, noise)| noise.estimated).collect();
    let with_model_error = estimated.iter().any(|(_, noise)| noise.model_error.is_some());
    let shown = |value: Option<f64>| value.map_or_else(|| NONE.to_owned(), |value| significant(value, 3));
    let times = estimated.iter().filter_map(|(_, noise)| noise.correlation_time_s);
    let time = Shown::time(times.fold(0.0, f64::max));
    let sizes: Vec<f64> = estimated.iter().map(|(_, noise)| noise.counts_as.unwrap_or(noise.sigma)).collect();
    let rows: Vec<Vec<Cell>> = estimated
        .into_iter()
        .map(|(sensor, noise)| {
            let mut row = vec![Cell::code(sensor), significant(noise.sigma, 3).into()];
            if with_model_error {
                row.extend([shown(noise.model_error).into(), shown(noise.counts_as).into()]);
            } else {
                row.push(
                    noise
                        .correlation_time_s
                        .map_or_else(|| "white".to_owned(), |own| significant(time.value(own), 3))
                        .into(),
                );
                row.push(percent(noise.correlated_share, 0).into());
            }
            row
        })
        .collect();
    let (caption, columns) = if with_model_error {
        (
            "Noise of the instruments and model error, as estimated beside what was found. A model error lasts over many \
             readings, so that each reading counts as an independent one with the error of the last column.",
            [Column::number("Model error", "K"), Column::number("Weight as of an error of", "K")],
        )
    } else {
        (
            "Noise of the sensors as estimated from what the best pair of effects leaves, where the pass does not state all of it.",
            [Column::number("Correlation time", time.unit), Column::number("Correlated share", "")],
        )
    };
    let columns = [Column::text("Sensor"), Column::number("Standard deviation", "K")].into_iter().chain(columns);
    let table = Table { caption: caption.into(), columns: columns.collect(), rows };
    (!table.rows.is_empty()).then(|| Block::Table(table.cut(&sizes)))
}

fn method(output: &Output) -> String {
    let [effects, pairs, sets] = output.looked_at;
    let weighed = if output.unseen.len() as u64 == effects {
        // Then the probabilities are those stated beforehand, or nothing.
        "no probability is stated where none can be seen".to_owned()
    } else {
        let (nothing, unexplained) = (chance(output.probability_nothing), chance(output.probability_unexplained));
        format!(
            "probability that nothing is missing {nothing}, that something is missing which no set explains {unexplained}"
        )
    };
    let mut text = format!(
        "{} at their places and {} were screened, {} fitted; {weighed}. {} cannot be seen with these data.",
        counted(effects, "effect"),
        counted(pairs, "pair"),
        counted(sets, "set"),
        counted(output.unseen.len(), "effect")
    );
    for posterior_prior in &output.posterior_priors {
        text.push_str(&format!(
            " The prior of {} is the posterior of {}, as a normal distribution of its {}.",
            posterior_prior.parameters.join(", "),
            posterior_prior.source.replace('`', ""),
            counted(posterior_prior.draws, "draw")
        ));
    }
    if let Some(p) = output.remaining_p {
        text.push_str(&format!(" What the selected set leaves: {}.", p_stated(p)));
    }
    if let Some(test) = &output.held_out_test {
        let way = if test.gain < 0.0 { "rises" } else { "falls" };
        let by = significant(test.gain.abs(), 3);
        text.push_str(&match test.se {
            Some(se) => format!(
                " Held-out rows, in {}: squared error {way} by {by} \u{00B1} {} a block in units of the noise.",
                counted(test.blocks, "block"),
                significant(se, 2)
            ),
            None => format!(
                " Held-out rows, in one block, which has no standard error: squared error {way} by {by} in units of the noise."
            ),
        });
    }
    text
}
