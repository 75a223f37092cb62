//! The verdict in sentences.

use crate::diagnosis::odds::medium::{is_pressure, is_vacuum, may_be_vacuum};
use crate::diagnosis::output::{
    DiscriminatingExperiment, EffectResult, GroupKind, OneThing, Output, RISES, StoryStep, Verdict,
};
use crate::diagnosis::screening::screen::AT_BOUNDS;
use crate::diagnosis::story::rules::{falls, rises};
use crate::diagnosis::story::step::Addition;
use crate::diagnosis::verdict::discriminating_experiment::is_worth_a_test;
use crate::diagnosis::verdict::effect_words::{
    Likeness, asked_for, carried, level, onset, or_model_error, size, started, surprising, timed, too_narrow,
};
use crate::diagnosis::verdict::experiment_words::{beyond_what_was_measured, beyond_what_was_set};
use crate::diagnosis::verdict::far_from_priors;
use crate::diagnosis::verdict::findings::{Findings, SetAside};
use crate::diagnosis::verdict::lumped_nodes::lumped_k;
use crate::diagnosis::verdict::numbers::{joined, kelvins, kelvins_before_and_after, short, stated_amount, with_error};
use crate::diagnosis::verdict::one_kind::laws;
use crate::diagnosis::verdict::precedence;
use crate::diagnosis::verdict::small_effects::is_curve_of_few_phases;
use crate::diagnosis::{PRIOR_OF, Problem, Refit};
use crate::document::{counted, p_stated, percent};
use crate::effect::Effect;

/// Share of the model error that is allowed for below which what remains beside all steps is stated too.
const CLEARLY_LESS: f64 = 0.8;
/// Share of the instruments' noise below which a model error cannot be seen.
const HIDDEN: f64 = 0.1;

/// p at which a test is clear.
const CLEARLY: f64 = 1e-6;

/// A sentence that goes on after a colon.
fn lower(sentence: &str) -> String {
    let mut letters = sentence.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// How clear a misfit is, from the p-value of all tests together.
pub fn clearness(p: f64, false_alarm: f64) -> String {
    if p > false_alarm {
        return format!("the tests find no misfit in that ({})", p_stated(p));
    }
    format!("that is a misfit ({}, the probability of one as clear as this where nothing is missing)", p_stated(p))
}

/// The most probable effect of the first step, if no step adds it, and the errors on the held-out rows without it and with it.
fn most_wanted<'a>(findings: &'a Findings<'_>) -> Option<(&'a Addition, [Option<f64>; 2])> {
    let story = findings.story.as_ref()?;
    let step = story.steps.first().filter(|step| findings.state.refits[step.before].effects.is_empty())?;
    let log = |one: &Addition| story.logs[one.place];
    let most = step.additions.iter().max_by(|a, b| log(a).total_cmp(&log(b)))?;
    let is_added = findings.state.refits[findings.selected].effects.contains(&most.effect);
    let errors = || [step.before, most.place].map(|place| findings.state.refits[place].rmse_held_out_k);
    (!is_added).then(|| (most, errors()))
}

/// That the effect which the fitted rows want most fails on the held-out ones.
fn fails_on_held_out(findings: &Findings<'_>) -> Option<String> {
    let (most, errors) = most_wanted(findings).filter(|(_, errors)| rises(*errors))?;
    Some(format!(
        "What the fitted rows want most, {}, fails on the held-out rows: their error goes from {}.",
        findings.id(most.effect),
        fall(errors)?
    ))
}

/// That the effect which the fitted rows want most gains nothing on the held-out ones.
fn gains_nothing_on_held_out(findings: &Findings<'_>) -> Option<String> {
    let (most, errors) = most_wanted(findings).filter(|(_, errors)| !rises(*errors) && !falls(*errors))?;
    let from_to = fall(errors)?;
    findings.is_refused(most.effect).then(|| {
        format!(
            "What the fitted rows want most, {}, hardly changes the error on the held-out rows, from {from_to}: it may only follow errors of the model.",
            findings.id(most.effect)
        )
    })
}

/// That the threshold of a selected effect lies where the readings stay, by no control of a logged heat.
fn holding(findings: &Findings<'_>, effect: &EffectResult) -> &'static str {
    let place = findings.problem.candidates.iter().position(|own| own.id == effect.id);
    let chosen = &findings.state.refits[findings.selected];
    match place.and_then(|place| findings.problem.held_level(chosen, place)) {
        Some(held) if held.controlled.is_empty() => {
            " Its threshold lies where the readings stay: whatever keeps them there reads the same, such as a heater, a path that opens, melting, or a state that is steady."
        }
        _ => "",
    }
}

/// What the laws of a group are together, how probable that is, and what the readings do not tell of it.
fn in_words(kind: &GroupKind, laws: &str) -> String {
    let GroupKind { what, open, probability, .. } = kind;
    format!(" {what} ({}), {open} the readings do not tell ({laws}); proposed:", percent(*probability))
}

/// That the most probable set leaves too much to be an explanation.
fn too_far(findings: &Findings<'_>) -> Option<String> {
    let place = findings.too_far?;
    let ids: Vec<String> =
        findings.state.refits[place].effects.iter().map(|&effect| findings.id(effect).to_owned()).collect();
    let beside = if findings.state.is_misspecified() { ", beside the model error that is allowed for" } else { "" };
    Some(format!(
        "What comes nearest, {}, is no explanation, however probable among what was fitted: tests still find something beside it, and its reduced chi-square is {:.1}{beside}.",
        joined(&ids),
        findings.reduced_chi_square(place)
    ))
}

fn fall([before, after]: [Option<f64>; 2]) -> Option<String> {
    let [before, after] = kelvins_before_and_after([before?, after?]);
    Some(format!("{before} to {after} K"))
}

/// What a step does to the errors, after a comma.
pub fn falls_to(step: &StoryStep) -> String {
    let beside = if step.beside_later { "beside the later steps " } else { "" };
    let held_out = fall(step.rmse_k.held_out).map_or_else(String::new, |fall| format!(", held out from {fall}"));
    let goes =
        if matches!(step.rmse_k.train, [Some(before), Some(after)] if after > before) { "goes" } else { "falls" };
    fall(step.rmse_k.train).map_or_else(String::new, |fall| format!("; {beside}the error {goes} from {fall}{held_out}"))
}

/// What speaks against a next step that is more probable than nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// The unseen rows.
    Unseen,
    /// The fitted rows.
    Fitted,
}

/// Why a story ends; `against` says what speaks against that which would be next, where it is more probable than nothing.
pub fn ends(step: &StoryStep, against: Option<Against>) -> Option<String> {
    if step.effect.is_some() {
        return None;
    }
    if let (Some(next), Some(against)) = (step.alternatives.first(), against) {
        return Some(match against {
            Against::Unseen => format!(
                "No further step is taken: {next} would be more probable than nothing on the fitted rows, but the unseen rows are not predicted clearly better with it."
            ),
            Against::Fitted => format!(
                "No further step is taken: {next} would predict the unseen rows better, but the fitted rows speak against it."
            ),
        });
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
        let (times, unit) = stated_amount(amount);
        format!("{name} {}{unit}", with_error(times * amount.value, times * amount.sd))
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
    let [sd, counts_as] = [worst.0, worst.2].map(|size| short(size, 2));
    let noises = |other: fn(f64, f64) -> f64| of.iter().map(|own| own.1).reduce(other).map(|size| short(size, 2));
    let noise = match (noises(f64::min)?, noises(f64::max)?) {
        (least, most) if least == most => format!("{least} K"),
        (least, most) => format!("{least} to {most} K"),
    };
    let left = chosen.rmse_train_k.map(|rmse| (rmse * rmse - worst.1 * worst.1).max(0.0).sqrt());
    let alike = format!(
        "Such errors last over many readings, so that each reading counts as an independent one with an error of {counts_as} K: that is a weight, not the noise of an instrument.{part}"
    );
    Some(match left.filter(|left| *left < CLEARLY_LESS * worst.0) {
        Some(left) if left < HIDDEN * worst.1 => format!(
            "Each step was weighed with the model error beside the most probable one or two effects, {sd} K; beside all that is found none remains that an instrument's noise of {} K would not hide. {alike}",
            short(worst.1, 2)
        ),
        Some(left) => format!(
            "The model is a little wrong everywhere: beside all that is found, a model error of {} K (standard deviation) remains, while the instruments' noise is {noise}. Each step was weighed with the model error beside the most probable one or two effects, {sd} K. {alike}",
            short(left, 2)
        ),
        None => format!(
            "The model is a little wrong everywhere: beside the most probable one or two effects, a model error of {sd} K (standard deviation) remains, while the instruments' noise is {noise}. {alike}"
        ),
    })
}

/// Probability of all sets of the steps' effects and their rivals below which a more probable set is named.
const LITTLE_IN_STEPS: f64 = 0.1;

/// The most probable of all sets that were fitted, where steps that add one effect at a time lead elsewhere.
fn more_probable(findings: &Findings<'_>) -> Option<String> {
    let weights = &findings.weights.sets;
    let is_of_steps = |place: usize| {
        let of_a_step = |effect: &usize| findings.groups.iter().any(|group| group.contains(effect));
        findings.state.refits[place].effects.iter().all(of_a_step)
    };
    // What fails on the held-out rows by itself, or holds a temperature, has a sentence of its own.
    let steps = findings.story.iter().flat_map(|story| &story.steps);
    let failing: Vec<usize> = steps.flat_map(|step| &step.failing).copied().collect();
    let is_left_out = |place: usize, refit: &Refit| {
        refit.effects.iter().any(|effect| failing.contains(effect))
            || findings.story.as_ref().is_some_and(|story| !story.logs[place].is_finite())
    };
    let weight = |(place, refit): (usize, &Refit)| if is_left_out(place, refit) { 0.0 } else { weights[place] };
    let weights: Vec<f64> = findings.state.refits.iter().enumerate().map(weight).collect();
    let is_probable = |&place: &usize| weights[place] >= LITTLE_IN_STEPS && !findings.groups.is_empty();
    let best = off_the_steps(&weights, is_of_steps).filter(is_probable)?;
    let refit = &findings.state.refits[best];
    let ids: Vec<&str> = refit.effects.iter().map(|&effect| findings.id(effect)).collect();
    let error = |rmse: Option<f64>, rows: &str| rmse.map(|rmse| format!("{} K on the {rows} rows", kelvins(rmse)));
    let errors: Vec<String> =
        [error(refit.rmse_train_k, "fitted"), error(refit.rmse_held_out_k, "held-out")].into_iter().flatten().collect();
    Some(format!(
        "Steps add one effect at a time. Another of the sets that were fitted is more probable than all that they lead to: {} ({}), with an RMSE of {}.",
        ids.join(" + "),
        percent(weights[best]),
        errors.join(", ")
    ))
}

/// The place of the most probable set, where it is more probable than all of the steps' sets and they have little. The first is
/// the baseline model, which no step leads to.
pub fn off_the_steps(weights: &[f64], is_of_steps: impl Fn(usize) -> bool) -> Option<usize> {
    let best = (1..weights.len()).reduce(|a, b| if weights[b] > weights[a] { b } else { a })?;
    let of_steps: f64 = (1..weights.len()).filter(|&place| is_of_steps(place)).map(|place| weights[place]).sum();
    (!is_of_steps(best) && of_steps <= LITTLE_IN_STEPS.min(weights[best])).then_some(best)
}

/// Probability from which an effect counts among those that may be missing.
const LIKELY: f64 = 0.01;

/// Effects that are said to need a gas.
const MOST_OF_GAS: usize = 3;

/// That effects which may be missing need a gas or a liquid, where nothing tells whether there was any and the model may be that of a
/// test in vacuum: how a study says that it was.
pub fn of_gas(effects: &[EffectResult], problem: &Problem) -> Option<String> {
    let needs = |own: &&EffectResult| problem.catalogue.get(&own.effect).is_some_and(Effect::needs_gas);
    let has_pressure = problem.model.inputs.iter().any(is_pressure);
    let likely = effects.iter().filter(|own| own.probability >= LIKELY && !own.changes_nothing);
    let ids: Vec<String> = likely.filter(needs).map(|own| format!("`{}`", own.id)).take(MOST_OF_GAS).collect();
    (!ids.is_empty() && !has_pressure && !is_vacuum(problem) && may_be_vacuum(&problem.model)).then(|| {
        format!(
            "{} can only be there if a gas or a liquid was about the hardware, of which the study says nothing. If the test was in vacuum, \
             an input of the model, which nothing has to use, says so: \"pressure\": {{\"unit\": \"Pa\", \"nominal\": 0.001}}; \
             otherwise nothing is to be done.",
            ids.join(", ")
        )
    })
}

/// That none of the effects that were tried explains the misfit; `is_definite` says whether tests find something beside small errors.
pub fn unexplained(tried: &str, is_definite: bool) -> String {
    if is_definite {
        return format!("Something is missing, and {tried} explains it: see the missing heat by node.");
    }
    format!(
        "The model errs by more than the instruments' noise, and {tried} explains that; the tests find nothing definite, so that small errors everywhere may be all there is."
    )
}

/// What would read the same as a selected effect.
fn likeness<'a>(findings: &'a Findings<'_>, effect: &EffectResult) -> Likeness<'a> {
    let problem = findings.problem;
    if problem.catalogue.get(&effect.effect).is_some_and(Effect::is_like_gradient) {
        return Likeness::Gradient;
    }
    let Some(place) = problem.candidates.iter().position(|own| own.id == effect.id) else { return Likeness::None };
    match findings.outweighed_by(place) {
        Some(SetAside::Failing) => return Likeness::Failing,
        Some(SetAside::Holding { effect, level_k }) => return Likeness::Holding(findings.id(effect), level_k),
        None => {}
    }
    if findings.is_source(place) {
        Likeness::Source
    } else if is_curve_of_few_phases(problem, place) {
        Likeness::Phases
    } else if findings.is_lumped_nodes_alone(place) {
        Likeness::LumpedNodes(lumped_k(problem))
    } else {
        Likeness::None
    }
}

/// The sentences: how wrong, what is missing, how sure, what it does to the error, what else it could be.
pub(crate) fn verdict(output: &Output, findings: &Findings<'_>, false_alarm: f64) -> Vec<String> {
    let mut words = Vec::new();
    let misfit = &output.misfit;
    let mut error = format!(
        "Tuned as far as its parameters allow, the model has a reduced chi-square of {}",
        if misfit.reduced_chi2 < 100.0 { format!("{:.2}", misfit.reduced_chi2) } else { short(misfit.reduced_chi2, 3) }
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
                let but = match misfit.family_wise_p <= false_alarm {
                    true => "The tests find a misfit, but no effect is probable enough to explain it",
                    false => "No effect is probable enough to be named",
                };
                words.push(format!(
                    "{but}: that nothing is missing keeps a probability of {}. More data, or stated noise, would decide it.",
                    percent(output.probability_nothing)
                ));
            }
        }
        Verdict::Unexplained => {
            let largest = findings.state.refits.iter().map(|refit| refit.effects.len()).max().unwrap_or(0);
            let effects = counted(output.looked_at[0], "effect");
            let tried = match largest {
                0 | 1 => format!("none of {effects}"),
                _ => format!("none of {effects}, alone or in sets of up to {largest},"),
            };
            let far = too_far(findings);
            words.push(unexplained(&tried, !output.only_small_errors));
            words.extend(far);
            if findings.vetoed {
                words.push("What fits the fitted rows fails on the held-out ones.".to_owned());
            }
            words.extend(fails_on_held_out(findings));
            words.extend(gains_nothing_on_held_out(findings));
        }
        Verdict::Identified | Verdict::Ambiguous => {
            // What invents nothing goes first.
            let is_prior = |effect: &&&EffectResult| effect.effect == PRIOR_OF;
            for effect in selected.iter().filter(is_prior) {
                words.push(too_narrow(effect, findings.problem));
            }
            for effect in selected.iter().filter(|effect| !is_prior(effect)) {
                let kind = output.kind_of(effect);
                let is_sure = output.verdict == Verdict::Identified || output.is_settled(effect);
                let head = if is_sure { "Missing" } else { "Perhaps missing" };
                let number = output.steps.iter().position(|step| step.effect.as_ref() == Some(&effect.id));
                let (head, errors) = match number {
                    Some(number) => (format!("Step {}, {}", number + 1, lower(head)), falls_to(&output.steps[number])),
                    None => (head.to_owned(), String::new()),
                };
                let is_own = |group: &Vec<usize>| group.first().is_some_and(|&first| findings.id(first) == effect.id);
                let group = findings.groups.iter().position(is_own);
                let members = group
                    .map(|group| findings.laws_of_group(group, &output.effects, &output.selected))
                    .unwrap_or_default();
                let together = kind.map_or_else(String::new, |kind| in_words(kind, &laws(&members)));
                let own = if kind.is_some() { "probability of the proposed one" } else { "probability" };
                words.push(format!(
                    "{head}:{together} {} ({}){}{}{}{}{}{errors}; {own} {}, log Bayes factor {:.1}.{}{}{}{}{}",
                    effect.title,
                    effect.id,
                    size(effect, timed(effect, findings.problem).map(|(_, amount)| amount)),
                    level(effect),
                    onset(effect, findings.problem),
                    carried(effect),
                    started(effect),
                    percent(effect.probability),
                    effect.log_bayes_factor,
                    asked_for(effect),
                    surprising(effect),
                    holding(findings, effect),
                    or_model_error(effect, likeness(findings, effect)),
                    precedence::in_words(output, effect)
                ));
            }
            words.extend(fails_on_held_out(findings));
            let against = findings.story.as_ref().and_then(|story| {
                let last = story.steps.last()?;
                let next = last.additions.first().filter(|next| next.probability > last.stays)?;
                let gain = story.gain(findings.state, last.before, next.place);
                Some(if gain.is_against_fitted() { Against::Fitted } else { Against::Unseen })
            });
            words.extend(findings.open_end().or_else(|| output.steps.last().and_then(|step| ends(step, against))));
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
            "In the baseline model `{}` is pressed against {} ({}): is that prior wide enough?",
            test.at,
            far_from_priors::end_of_prior(findings.problem, &findings.state.refits[0], &test.at),
            p_stated(test.p)
        ));
    }
    if output.verdict != Verdict::Adequate {
        // What the baseline model drags there may have hidden what is missing.
        let fits = [findings.selected, 0].map(|place| &findings.state.refits[place]);
        words.extend(fits.into_iter().find_map(|fit| far_from_priors::in_words(findings.problem, fit)));
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
        words.extend(findings.story.as_ref().and_then(|_| more_probable(findings)));
        if findings.fewest_parameters {
            words.push(format!(
                "Tests still find something beside all of these ({}), so that the odds between them are too sure: the set with the fewest parameters is named first.",
                p_stated(output.remaining_p.unwrap_or(f64::NAN))
            ));
        }
        words.extend(of_gas(&output.effects, findings.problem));
        words.extend(output.one_thing.as_ref().map(OneThing::in_words));
        words.extend(output.only_in_transients.as_ref().map(|own| own.in_words(&findings.problem.model)));
        let experiment = output.discriminating_experiment.as_ref();
        words.extend(experiment.map(DiscriminatingExperiment::in_words));
        if let Some(experiment) = experiment.filter(|own| is_worth_a_test(own.probability)) {
            words.extend(beyond_what_was_set(experiment, findings.problem));
            words.extend(beyond_what_was_measured(experiment, findings.problem));
        }
    }
    if !findings.state.noise.is_empty() {
        words.push(
            "A calibration, `bmv compare` and `bmv history` take the noise as the pass states it or infer it beside the model as it is: their chi-square and RMSE differ from those stated here."
                .to_owned(),
        );
    }
    words
}
