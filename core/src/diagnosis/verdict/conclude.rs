//! From fits to the verdict.

use crate::measurement::total_sd;
use std::collections::BTreeMap;

use crate::diagnosis::engine::{Diagnosis, Remainder, SensorNoise, State, TIMES_THE_STEPS};
use crate::diagnosis::fits::held_out;
use crate::diagnosis::fits::refit::{Amplitude, Begin};
use crate::diagnosis::heat;
use crate::diagnosis::heat::effect_heat_flow::effect_heat_flow;
use crate::diagnosis::hypothesis::InferredStart;
use crate::diagnosis::noise::overstated;
use crate::diagnosis::odds::narrow_prior::{SEPARATE, TITLE};
use crate::diagnosis::odds::posterior_odds::{
    LEAST_RIVAL, MOST_RIVALS, RIVALS_WITHIN, STANDS, SURE, SetProbabilities, best, held, nothing_stands,
    odds_with_held_out, posterior_odds, veto,
};
use crate::diagnosis::output::{
    Amount, Detectable, EffectHeat, EffectResult, HeldOutTest, Misfit, ModelResult, NoiseResult, Output, Rmse,
    RmseChange, StartResult, StoryStep, Test, Unseen, Verdict,
};
use crate::diagnosis::problem::{FittedReading, is_idle};
use crate::diagnosis::story::{Step, Story};
use crate::diagnosis::verdict::discriminating_experiment;
use crate::diagnosis::verdict::hints::hints;
use crate::diagnosis::verdict::small_effects::IS_MODEL_ERROR;
use crate::diagnosis::verdict::{few_readings, still, trend, words};
use crate::diagnosis::{Problem, Refit};
use crate::document::counted;
use crate::math::functions::ln;
use crate::math::special::chi_square_sf;
use crate::measurement::unknown::start_name;
use crate::measurement::{Doubt, Rows};
use crate::random::Distribution;

/// Parameters of an effect as a result states them.
pub(super) fn amounts(amplitudes: &[Amplitude]) -> BTreeMap<String, Amount> {
    let one = |amplitude: &Amplitude| {
        let at_bound = amplitude.at_bound;
        let (value, sd) = if at_bound { (amplitude.mode, 0.0) } else { (amplitude.mean, amplitude.sd) };
        let amount = Amount { value, sd, most_probable: amplitude.mode, unit: amplitude.unit.clone(), at_bound };
        (amplitude.name.clone(), amount)
    };
    amplitudes.iter().map(one).collect()
}

/// The smallest and the largest heat into the node to which an effect gives most, W.
pub(super) fn watts(carries: &[EffectHeat]) -> Option<[f64; 2]> {
    let node = &carries.first()?.node;
    let into = carries.iter().filter(|one| one.node == *node).map(|one| one.watts);
    into.fold(None, |range: Option<[f64; 2]>, watts| {
        let [least, most] = range.unwrap_or([watts; 2]);
        Some([least.min(watts), most.max(watts)])
    })
}

/// Sets and effects that are written out.
const MOST_WRITTEN: usize = 60;
/// Probability of a set below which the held-out rows are not asked.
const LEAST_TESTED: f64 = 1e-3;
/// Probability of an effect below which the heat that it would carry is not stated.
const LEAST_STATED: f64 = 1e-3;
/// Length of the change of all predictions, in standard deviations of the noise, below which an effect changes nothing.
const MOVES_NOTHING: f64 = 0.01;
/// p-value of the remaining sum of squares below which a set does not bring the model near the noise.
const FAR_FROM_NOISE: f64 = 1e-3;
/// Reduced chi-square, beside the model error that is allowed for, above which a set does not bring the model near it.
const FAR_FROM_MODEL_ERROR: f64 = 2.0;

/// Probability of nothing, with what the held-out rows say, below which these show what tests of the fitted rows do not find: one in
/// twenty, as a test has it.
const SHOWN_BY_HELD_OUT: f64 = 0.05;

/// The sets, weighed, and which of them is said.
pub(crate) struct Findings<'a> {
    pub problem: &'a Problem,
    pub state: &'a State,
    pub weights: SetProbabilities,
    /// The steps that lead to the selected set, where the model is taken to be a little wrong everywhere.
    pub story: Option<Story>,
    /// Position of the selected fit; that of the baseline model where nothing is selected.
    pub selected: usize,
    /// Members of each group: positions of effects, the selected one first.
    pub groups: Vec<Vec<usize>>,
    /// Fits that are rivals of the selected one, itself first.
    pub rivals: Vec<usize>,
    /// What sets leave that were not screened before.
    pub late: Vec<Remainder>,
    /// Whether nothing stands although tests find something.
    pub doubted: bool,
    /// Whether the held-out rows speak against a set that fits the others.
    pub vetoed: bool,
    /// Whether the held-out rows show what the tests of the fitted rows do not.
    pub shown_by_held_out: bool,
    /// Whether the selected set goes before a more probable one since odds are doubted.
    pub fewest_parameters: bool,
    /// Probabilities that errors of the model itself are what effects explain, where they are not 0.
    pub model_errors: BTreeMap<usize, f64>,
    /// Probability that lumped nodes are what an effect explains.
    pub lumped_nodes: BTreeMap<usize, f64>,
    /// Probabilities of effects beside which others explain nearly as much.
    pub shared: BTreeMap<usize, f64>,
}

impl Findings<'_> {
    pub fn id(&self, effect: usize) -> &str {
        &self.problem.candidates[effect].id
    }

    /// The sets before and after the step of a story at which an effect was added, or was most probable.
    pub(super) fn step_of(&self, effect: usize) -> Option<(usize, usize)> {
        let steps = &self.story.as_ref()?.steps;
        let of = |step: &Step| {
            let chance = step.additions.iter().find(|one| one.effect == effect)?;
            Some((step.chosen == Some(chance.place), chance.probability, (step.before, chance.place)))
        };
        let best = steps.iter().filter_map(of).reduce(|a, b| if (b.0, b.1) > (a.0, a.1) { b } else { a });
        best.map(|(_, _, places)| places)
    }

    /// The steps of the story to the selected set.
    fn steps_of_story(&self) -> Vec<StoryStep> {
        let Some(story) = &self.story else { return Vec::new() };
        let refits = &self.state.refits;
        let result = |step: &Step| {
            let place = step.chosen.unwrap_or(step.before);
            let (before, after) = (&refits[step.before], &refits[place]);
            let added = step.additions.iter().find(|one| step.chosen == Some(one.place));
            let others = step.additions.iter().filter(|one| step.chosen != Some(one.place));
            let likely = others.filter(|one| one.probability >= LEAST_RIVAL).take(MOST_RIVALS);
            let group = self.groups.iter().find(|group| added.is_some_and(|one| group[0] == one.effect));
            let mut alternatives: Vec<usize> = likely.map(|one| one.effect).collect();
            let others = group.iter().flat_map(|group| &group[1..]);
            let others: Vec<usize> = others.copied().filter(|effect| !alternatives.contains(effect)).collect();
            alternatives.extend(others);
            StoryStep {
                effect: added.map(|one| self.id(one.effect).to_owned()),
                probability: added.map_or(step.stays, |one| {
                    self.probability(one.effect).min(self.unless_model_error(one.effect, one.probability))
                }),
                rmse_k: RmseChange {
                    train: [before.rmse_train_k, after.rmse_train_k],
                    held_out: [before.rmse_held_out_k, after.rmse_held_out_k],
                },
                alternatives: alternatives.into_iter().map(|effect| self.id(effect).to_owned()).collect(),
            }
        };
        story.steps.iter().map(result).collect()
    }

    /// Effects of the selected set: in the order of the story or, without one, that first without which most is lost.
    fn in_order(&self) -> Vec<usize> {
        let refits = &self.state.refits;
        let own = &refits[self.selected].effects;
        if self.story.is_some() && self.selected > 0 {
            return self.groups.iter().filter_map(|group| group.first()).copied().collect();
        }
        let without = |effect: usize| {
            let rest: Vec<usize> = own.iter().copied().filter(|&other| other != effect).collect();
            let rest = refits.iter().find(|refit| refit.effects == rest);
            rest.map_or(f64::NEG_INFINITY, |rest| rest.log_evidence)
        };
        let mut order: Vec<(f64, usize)> = own.iter().map(|&effect| (without(effect), effect)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        order.into_iter().map(|(_, effect)| effect).collect()
    }

    /// Probability that an effect is missing.
    pub fn probability(&self, effect: usize) -> f64 {
        let shared = self.shared.get(&effect).copied();
        self.unless_model_error(effect, shared.unwrap_or_else(|| self.probability_as_weighed(effect)))
    }

    /// A probability of an effect, less what it has of being none.
    fn unless_model_error(&self, effect: usize, probability: f64) -> f64 {
        (1.0 - self.model_error(effect)) * probability
    }

    /// Probability that errors of the model are what an effect explains.
    fn model_error(&self, effect: usize) -> f64 {
        let of = |probabilities: &BTreeMap<usize, f64>| probabilities.get(&effect).copied().unwrap_or(0.0);
        of(&self.model_errors).max(of(&self.lumped_nodes))
    }

    /// Whether an effect is so small that errors of the model may well be what it explains.
    pub(super) fn is_small(&self, effect: usize) -> bool {
        self.model_errors.get(&effect).is_some_and(|probability| *probability >= IS_MODEL_ERROR)
    }

    /// The same as if models had no errors of their own.
    pub(super) fn probability_as_weighed(&self, effect: usize) -> f64 {
        if let Some(story) = &self.story {
            let chances = story.steps.iter().flat_map(|step| &step.additions).filter(|one| one.effect == effect);
            return chances.map(|one| one.probability).fold(0.0, f64::max);
        }
        let with =
            self.state.refits.iter().zip(&self.weights.sets).filter(|(refit, _)| refit.effects.contains(&effect));
        with.map(|(_, weight)| weight).sum()
    }
}

impl Diagnosis {
    /// The verdict on what was found.
    pub fn conclude(&self, state: &State) -> Output {
        self.at(state).concluded(state)
    }

    fn concluded(&self, state: &State) -> Output {
        let problem = self.with_noise(&state.noise, &state.most_steps);
        let family = state.stated_family.as_ref().unwrap_or(&state.screening.family);
        let finds = family.p <= self.settings().false_alarm || state.is_misspecified();
        let stated = problem.noise_freedom.is_none();
        // Where noise is estimated, tests of few fitted rows take part of what is missing for noise.
        let by_held_out = (!finds && !stated).then(|| odds_with_held_out(&problem, &state.refits));
        let by_held_out = by_held_out.filter(|weights| weights.sets[0] < SHOWN_BY_HELD_OUT);
        let finds = finds || by_held_out.is_some();
        let moved = finds.then(|| self.moved(state, &problem, stated));
        let state = moved.as_ref().unwrap_or(state);
        let baseline = &state.refits[0];
        let missing = finds.then(|| heat::missing_heat(&problem, baseline)).flatten();
        // A model error that is allowed for is what something else would be.
        let something_else = missing.as_ref().filter(|_| !state.is_misspecified()).map(|missing| missing.log_evidence);
        let shown_by_held_out = by_held_out.is_some();
        let weights = by_held_out.unwrap_or_else(|| posterior_odds(&problem, &state.refits, something_else));
        let mut warnings = state.warnings.clone();
        warnings.extend(few_readings::warnings(&problem, free(baseline)));
        warnings.extend(given_up(state));
        if finds {
            warnings.extend(still::warnings(&problem, baseline));
        }
        if finds && missing.is_none() {
            warnings.push("heat of unknown origin could not be compared with the effects: the network is too large, or it has no solution with \
                 such heat"
                    .to_owned());
        }
        let story = state.is_misspecified().then(|| self.story(state));
        let mut findings = Findings {
            problem: &problem,
            state,
            weights,
            story,
            selected: 0,
            groups: Vec::new(),
            rivals: Vec::new(),
            late: Vec::new(),
            doubted: false,
            vetoed: false,
            shown_by_held_out,
            fewest_parameters: false,
            model_errors: BTreeMap::new(),
            lumped_nodes: BTreeMap::new(),
            shared: BTreeMap::new(),
        };
        let nothing = match findings.story.as_ref().and_then(|story| story.steps.first()) {
            Some(first) => first.stays,
            None => findings.weights.sets[0],
        };
        // Where all noise is stated, the p is what it says.
        findings.doubted = match state.is_misspecified() {
            true => nothing >= STANDS,
            false => finds && !state.noise.is_empty() && nothing_stands(nothing, state.screening.family.p),
        };
        let mut verdict = Verdict::Adequate;
        let mut held_out_test = None;
        let missing = missing.filter(|_| !findings.doubted);
        if finds && !findings.doubted {
            verdict = Verdict::Unexplained;
            held_out_test = best(&findings.weights)
                .and_then(|place| held_out::test(&problem, baseline, &state.refits[place], stated));
            let is_vetoed = |place: usize| {
                held_out::test(&problem, baseline, &state.refits[place], stated).is_some_and(|test| test.veto)
            };
            // A story takes no step that the held-out rows speak against.
            let vetoed = veto(&findings.weights, LEAST_TESTED, |place| findings.story.is_none() && is_vetoed(place));
            findings.weights = vetoed.with.clone();
            for &place in &vetoed.sets {
                let effects = named(&findings, &state.refits[place].effects);
                warnings.push(format!("the held-out rows speak against {effects}"));
            }
            findings.vetoed = !vetoed.sets.is_empty();
            if findings.vetoed {
                let place = best(&vetoed.without).unwrap_or(0);
                if place > 0 && self.leaves_nothing(&mut findings, place) {
                    findings.weights = vetoed.without;
                    held_out_test = held_out::test(&problem, baseline, &state.refits[place], stated);
                }
            }
            let tested = best(&findings.weights);
            findings.select(self.settings().false_alarm);
            if tested != Some(findings.selected) {
                held_out_test = held_out::test(&problem, baseline, &state.refits[findings.selected], stated);
            }
            findings.model_errors = findings.model_errors(self.finds_beside(&findings, held_out_test.as_ref(), stated));
            if !state.is_misspecified() {
                for (effect, probability) in self.errors_everywhere(&findings) {
                    let known = findings.model_errors.entry(effect).or_insert(0.0);
                    *known = known.max(probability);
                }
            }
            findings.lumped_nodes = findings.lumped_nodes();
            let chosen = &state.refits[findings.selected];
            let explains = !chosen.effects.is_empty() && !self.leaves_too_much(&findings);
            if explains {
                findings.add_nearly_as_good();
                verdict = findings.judge();
            } else {
                // The test was that of a set which is not adopted.
                held_out_test = None;
                findings.selected = 0;
                findings.groups.clear();
                findings.rivals.clear();
                findings.model_errors.clear();
                findings.lumped_nodes.clear();
            }
        }
        if state.is_misspecified() && findings.selected == 0 {
            // A misfit is certain: what a model error takes up is unexplained unless it is smaller than the noise.
            verdict = if is_small_error(state) { Verdict::Adequate } else { Verdict::Unexplained };
        }
        let selected: Vec<String> =
            findings.in_order().into_iter().map(|effect| findings.id(effect).to_owned()).collect();
        warnings.extend(trend::warnings(&problem, &state.refits[findings.selected].effects));
        let chosen = &state.refits[findings.selected];
        // It is about the data themselves.
        let overstated = (!state.is_misspecified())
            .then(|| overstated::warning(self.problem(), &problem, chosen, free(chosen)))
            .flatten();
        if let Some(overstated) = overstated {
            warnings.insert(0, overstated);
        }
        let discrimination = if verdict == Verdict::Ambiguous {
            discriminating_experiment::experiment(&findings)
        } else {
            discriminating_experiment::Discrimination::default()
        };
        let remaining_p = if findings.selected > 0 { findings.remaining_now() } else { None };
        let (heat, goes_with) = missing.map_or_else(Default::default, |missing| (missing.heat, missing.goes_with));
        let mut output = Output {
            verdict,
            words: Vec::new(),
            probability_nothing: nothing,
            probability_unexplained: findings.weights.unexplained,
            misfit: misfit(&problem, state),
            effects: self.effects(&findings),
            models: models(&findings),
            selected,
            steps: findings.steps_of_story(),
            unseen: unseen(&findings),
            detectable: detectable(&findings),
            noise: noise(&problem, state),
            discriminating_experiment: discrimination.experiment,
            one_thing: discrimination.one_thing,
            heat,
            goes_with,
            held_out_test,
            remaining_p,
            looked_at: [
                problem.candidates.len() as u64,
                state.screening.pairs_screened,
                state.refits.len().saturating_sub(1) as u64,
            ],
            posterior_priors: Vec::new(),
            converged: None,
            doubts: [self.doubts_of(&state.left_out), doubts(&problem)].concat(),
            warnings,
        };
        output.words = words::verdict(&output, &findings, self.settings().false_alarm);
        output
    }

    /// Where the held-out rows veto a set with its thresholds in the likeliest gaps, and not in others, which the fitted rows leave
    /// open, the likeliest of these counts.
    fn moved(&self, state: &State, problem: &Problem, stated: bool) -> State {
        let mut moved = state.clone();
        let weights = posterior_odds(problem, &state.refits, None);
        let is_vetoed =
            |refit: &Refit| held_out::test(problem, &state.refits[0], refit, stated).is_some_and(|test| test.veto);
        for (refit, weight) in moved.refits.iter_mut().zip(&weights.sets).skip(1) {
            if *weight < LEAST_TESTED || !problem.has_thresholds(&refit.effects) || !is_vetoed(refit) {
                continue;
            }
            let begin = Begin {
                starts: vec![refit.by_name()],
                scale: 1.0,
                widths: refit.widths(),
                is_near: true,
                ..Begin::default()
            };
            let all = match problem.refits_over_gaps(&refit.effects, &begin, self.key()) {
                Ok(all) => all,
                Err(why) => {
                    let effects: Vec<&str> =
                        refit.effects.iter().map(|&own| problem.candidates[own].id.as_str()).collect();
                    moved.warnings.push(format!("other gaps for the threshold of {}: {why}", effects.join(" + ")));
                    continue;
                }
            };
            let highest = all.iter().map(|one| one.log_evidence).fold(f64::NEG_INFINITY, f64::max);
            let is_open = |other: &Refit| other.log_evidence + ln(RIVALS_WITHIN) >= highest && !is_vetoed(other);
            let better = |a: Refit, b: Refit| if b.log_evidence > a.log_evidence { b } else { a };
            let Some(other) = all.into_iter().filter(is_open).reduce(better) else { continue };
            let ids: Vec<&str> = refit.effects.iter().map(|&effect| problem.candidates[effect].id.as_str()).collect();
            moved.warnings.push(format!("{} {}", held_out::SAYS_MOVED, ids.join(" + ")));
            *refit = other;
        }
        moved
    }

    /// Whether tests find nothing beside a set; what it leaves is screened where that was not done.
    fn leaves_nothing(&self, findings: &mut Findings<'_>, place: usize) -> bool {
        let refit = &findings.state.refits[place];
        let known = findings.remaining(place);
        let p = known.or_else(|| Some(self.screen_beside(findings.problem, refit).ok()?.family.p));
        let Some(p) = p else { return false };
        if known.is_none() {
            findings.late.push(Remainder { effects: refit.effects.clone(), p, leads: Vec::new() });
        }
        p > self.settings().false_alarm
    }

    /// Whether tests find something beside the selected set, or it predicts held-out rows worse than the stated noise allows; not
    /// where a model error is allowed for, which both would be.
    fn finds_beside(&self, findings: &Findings<'_>, held_out: Option<&HeldOutTest>, stated: bool) -> bool {
        let is_clear = |p: f64| p <= self.settings().false_alarm;
        let fails = stated && held_out.and_then(|test| test.p).is_some_and(is_clear);
        !findings.state.is_misspecified() && (fails || findings.remaining_now().is_some_and(is_clear))
    }

    /// Whether the selected set leaves the model far from the noise while tests go on finding something.
    fn leaves_too_much(&self, findings: &Findings<'_>) -> bool {
        let chosen = &findings.state.refits[findings.selected];
        let found = findings.remaining_now().is_some_and(|p| p <= self.settings().false_alarm);
        let freedom = chosen.residuals.len() as f64 - free(chosen) as f64;
        let far = match findings.state.is_misspecified() {
            true => chosen.chi_square > FAR_FROM_MODEL_ERROR * freedom.max(1.0),
            false => chi_square_sf(chosen.chi_square, freedom.max(1.0)) < FAR_FROM_NOISE,
        };
        let rather_else = findings.weights.unexplained > 0.5;
        (found && far) || rather_else
    }

    /// All fitted effects, most probable first.
    fn effects(&self, findings: &Findings<'_>) -> Vec<EffectResult> {
        let state = findings.state;
        let mut seen: Vec<usize> = state.refits.iter().flat_map(|refit| refit.effects.iter().copied()).collect();
        seen.sort_unstable();
        seen.dedup();
        let mut ranked: Vec<(f64, f64, usize)> = seen
            .into_iter()
            .map(|effect| {
                let alone = state.refits.iter().find(|refit| refit.effects == [effect]);
                (findings.probability(effect), alone.map_or(f64::NEG_INFINITY, |refit| refit.log_evidence), effect)
            })
            .collect();
        // What is selected in its order, then what else is probable.
        let steps = findings.in_order();
        let step = |effect: usize| steps.iter().position(|&one| one == effect).unwrap_or(steps.len());
        ranked.sort_by(|a, b| {
            step(a.2).cmp(&step(b.2)).then(b.0.total_cmp(&a.0)).then(b.1.total_cmp(&a.1)).then(a.2.cmp(&b.2))
        });
        let most = ranked.into_iter().take(MOST_WRITTEN);
        let mut results: Vec<EffectResult> =
            most.map(|(probability, _, effect)| self.effect(findings, effect, probability)).collect();
        for law in self.laws(findings, &results) {
            let is_curve =
                |result: &EffectResult| law.confused_with.contains(&result.effect) && result.group == law.group;
            let curve = results.iter().position(is_curve).map_or(results.len(), |position| position + 1);
            results.insert(curve, law);
        }
        results
    }

    fn effect(&self, findings: &Findings<'_>, effect: usize, probability: f64) -> EffectResult {
        let (problem, state) = (findings.problem, findings.state);
        let candidate = &problem.candidates[effect];
        let file = problem.catalogue.get(&candidate.effect);
        // Its best set: the selected one where it belongs to it, else the most probable.
        let with = |place: &usize| state.refits[*place].effects.contains(&effect);
        let better = |a: usize, b: usize| if findings.weights.sets[b] > findings.weights.sets[a] { b } else { a };
        let own = Some(findings.selected).filter(with).or_else(|| (0..state.refits.len()).filter(with).reduce(better));
        let own = own.unwrap_or(0);
        let step = findings.step_of(effect);
        let after = step.map_or(own, |(_, place)| place);
        let refit = &state.refits[after];
        let rest: Vec<usize> = refit.effects.iter().copied().filter(|&other| other != effect).collect();
        let without = || state.refits.iter().position(|other| other.effects == rest);
        let without = step.map(|(before, _)| before).or_else(without).unwrap_or(0);
        let before = &state.refits[without];
        let log_bayes_factor = findings.log_bayes_factor(without, after);
        let position = refit.effects.iter().position(|&other| other == effect);
        let amplitudes = position.map(|position| amounts(&refit.amplitudes[position])).unwrap_or_default();
        let group = findings.groups.iter().position(|group| group.contains(&effect)).map(|group| group as u64 + 1);
        let scales = group.and_then(|_| self.at_scales(findings, refit, log_bayes_factor));
        let is_stated = probability >= LEAST_STATED || group.is_some();
        let carries = if is_stated { effect_heat_flow(problem, refit, effect) } else { Vec::new() };
        let watts = watts(&carries);
        let hints = if is_stated { hints(problem, refit, effect) } else { Vec::new() };
        let starts = position.map(|position| starts(problem, refit, position)).unwrap_or_default();
        EffectResult {
            hints,
            starts,
            file: None,
            id: candidate.id.clone(),
            effect: candidate.effect.clone(),
            title: file.map_or_else(|| TITLE.to_owned(), |file| file.form.title.clone()),
            place: candidate.place.clone(),
            where_kind: candidate.where_kind.to_owned(),
            input: candidate.input.clone(),
            probability,
            model_error: findings.model_error(effect),
            log_bayes_factor,
            log_bayes_factor_scales: scales,
            changes_nothing: changes_nothing(before, refit),
            group,
            amplitudes,
            rmse_k: RmseChange {
                train: [before.rmse_train_k, refit.rmse_train_k],
                held_out: [before.rmse_held_out_k, refit.rmse_held_out_k],
            },
            watts,
            prior_width: position.map_or(1.0, |position| refit.widths[position]),
            within_model: position.is_some_and(|position| refit.within_model[position]),
            carries,
            confused_with: file
                .map(|file| file.form.confused_with.iter().map(|name| name.value.clone()).collect())
                .unwrap_or_default(),
            separate: file
                .map_or_else(|| Some(SEPARATE.to_owned()), |file| file.form.separate.clone())
                .unwrap_or_default(),
        }
    }

    /// Log Bayes factors with the amplitudes' priors at half and at double scale.
    fn at_scales(&self, findings: &Findings<'_>, refit: &Refit, log_bayes_factor: f64) -> Option<[f64; 2]> {
        let at = |scale: f64| {
            let begin = Begin { starts: vec![refit.by_name()], scale, is_near: true, ..Begin::default() };
            let found = findings.problem.refit(&refit.effects, &begin, self.key()).ok()?;
            Some(log_bayes_factor + found.log_evidence - refit.log_evidence).filter(|value| value.is_finite())
        };
        Some([at(0.5)?, at(2.0)?])
    }
}

/// Number of parameters that are not held at a bound.
fn free(refit: &Refit) -> usize {
    refit.held.iter().zip(&refit.names).filter(|(held, name)| !**held && !is_idle(name)).count()
}

fn named(findings: &Findings<'_>, effects: &[usize]) -> String {
    let ids: Vec<&str> = effects.iter().map(|&effect| findings.id(effect)).collect();
    ids.join(" + ")
}

impl Findings<'_> {
    /// Log Bayes factor of a fit over another; where a model error is allowed for, each with the one that is most likely beside
    /// it: with that of the best set the baseline model would seem far less probable than it is, and later steps hardly more.
    fn log_bayes_factor(&self, before: usize, after: usize) -> f64 {
        let own = |place: usize| self.story.as_ref()?.log_evidences.get(place).copied().filter(|log| log.is_finite());
        let refits = &self.state.refits;
        match (own(before), own(after)) {
            (Some(before), Some(after)) => after - before,
            _ => refits[after].log_evidence - refits[before].log_evidence,
        }
    }

    /// Whether the selected set goes before a more probable one.
    pub fn goes_first(&self) -> bool {
        self.story.is_none() && best(&self.weights).is_some_and(|place| self.selected != 0 && place != self.selected)
    }

    /// The family-wise p of what a set leaves, where that was tested.
    pub(super) fn remaining(&self, place: usize) -> Option<f64> {
        let effects = &self.state.refits[place].effects;
        let mut known = self.state.remainders.iter().chain(&self.late);
        known.find(|remainder| remainder.effects == *effects).map(|remainder| remainder.p)
    }

    /// The same of the selected set, or of the most probable one where the selected one goes before it.
    pub fn remaining_now(&self) -> Option<f64> {
        self.remaining(self.selected).or_else(|| self.remaining(best(&self.weights)?))
    }

    fn judge(&self) -> Verdict {
        if self.story.is_some() {
            let first = self.groups.iter().filter_map(|group| group.first());
            let sure = self.groups.iter().all(|group| group.len() == 1)
                && first.into_iter().all(|&effect| self.probability(effect) >= SURE);
            // A model that is wrong by more than the noise may be so in the steps as well.
            return if sure && is_small_error(self.state) { Verdict::Identified } else { Verdict::Ambiguous };
        }
        let alone = self.rivals.len() == 1;
        let sure = held(&self.state.refits, &self.weights, &self.groups) >= SURE;
        let own = &self.state.refits[self.selected].effects;
        let all_large = own.iter().all(|&effect| self.model_error(effect) < IS_MODEL_ERROR);
        if alone && sure && all_large { Verdict::Identified } else { Verdict::Ambiguous }
    }
}

/// The start temperatures of the nodes that a member of a set adds, where they were inferred.
fn starts(problem: &Problem, refit: &Refit, member: usize) -> Vec<StartResult> {
    let Ok(hypothesis) = problem.hypothesis_of_widths(&refit.effects, &refit.widths) else { return Vec::new() };
    let one = |start: &InferredStart| {
        let measurement = &hypothesis.measurements[start.measurement].name;
        let node = &hypothesis.model.nodes[start.node].name;
        let unknown = start_name(measurement, node);
        let place = refit.names.iter().position(|name| *name == unknown)?;
        let Distribution::Normal { mean, sd, lower: Some(lower), upper: Some(upper) } = start.prior else {
            return None;
        };
        Some(StartResult {
            measurement: measurement.clone(),
            node: node.clone(),
            most_probable_k: refit.unknowns[place],
            prior_k: [mean, sd],
            bounds_k: [lower, upper],
        })
    };
    hypothesis.starts.iter().filter(|start| start.effect == member).filter_map(one).collect()
}

/// What is said of fits in which transients were given up.
fn given_up(state: &State) -> Option<String> {
    let points: u64 = state.refits.iter().map(|refit| refit.given_up).sum();
    let sets = state.refits.iter().filter(|refit| refit.given_up > 0).count();
    (points > 0).then(|| {
        format!(
            "fits of {} of effects left out {} at which a transient took more than {TIMES_THE_STEPS} times the steps of the \
             baseline model",
            counted(sets, "set"),
            counted(points, "point")
        )
    })
}

/// Whether two fits predict the same, to less than any table shows.
fn changes_nothing(before: &Refit, after: &Refit) -> bool {
    let moved = before.residuals.iter().zip(&after.residuals).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
    before.residuals.len() == after.residuals.len() && moved.sqrt() < MOVES_NOTHING
}

/// Whether the model errors that are allowed for are smaller than the noise of their sensors.
fn is_small_error(state: &State) -> bool {
    state.noise.iter().all(|one| one.model_error.is_none_or(|error| error.sd <= one.noise.total()))
}

/// What is doubtful about the data; starts first, since all that follows shows them.
fn doubts(problem: &Problem) -> Vec<Doubt> {
    let mut doubts: Vec<Doubt> = problem.measurements.iter().flat_map(|own| own.doubts.iter().cloned()).collect();
    doubts.sort_by_key(|doubt| !doubt.is_of_start());
    doubts
}

/// Sum of squares of the baseline model's errors in standard deviations of the instruments' noise, where a model error is
/// allowed for beside it.
fn by_noise_alone(problem: &Problem, state: &State) -> Option<f64> {
    let of = |(reading, error): (FittedReading, &f64)| {
        let same = |own: &&SensorNoise| own.measurement == reading.measurement && own.sensor == reading.sensor;
        let own = state.noise.iter().find(same).filter(|own| own.model_error.is_some())?;
        Some((error / own.noise.total()) * (error / own.noise.total()))
    };
    problem.fitted_readings().into_iter().zip(&state.refits[0].errors).map(of).sum()
}

fn misfit(problem: &Problem, state: &State) -> Misfit {
    let baseline = &state.refits[0];
    // As in a calibration: a parameter at a bound counts too, so that both tell one figure where their noise is one.
    let unknowns = baseline.names.iter().filter(|name| !is_idle(name)).count();
    let freedom = (baseline.residuals.len() as f64 - unknowns as f64).max(1.0);
    let family = state.stated_family.as_ref().unwrap_or(&state.screening.family);
    let tests = family.tests.iter();
    Misfit {
        reduced_chi2: by_noise_alone(problem, state).unwrap_or(baseline.chi_square) / freedom,
        family_wise_p: family.p,
        rmse_k: Rmse { train: baseline.rmse_train_k, held_out: baseline.rmse_held_out_k },
        tests: tests.map(|test| Test { name: test.name.clone(), at: test.at.clone(), p: test.p }).collect(),
    }
}

/// The most probable sets; whatever their number, nothing and those that lead to the selected one are among them.
fn models(findings: &Findings<'_>) -> Vec<ModelResult> {
    let story = findings.story.iter().flat_map(|story| story.sets.iter().copied());
    let always: Vec<usize> = [0, findings.selected].into_iter().chain(story).collect();
    let refits = &findings.state.refits;
    let mut order: Vec<usize> = (0..refits.len()).collect();
    order.sort_by(|&a, &b| findings.weights.sets[b].total_cmp(&findings.weights.sets[a]).then(a.cmp(&b)));
    let result = |place: usize| {
        let refit = &refits[place];
        ModelResult {
            effects: refit.effects.iter().map(|&effect| findings.id(effect).to_owned()).collect(),
            log_evidence: refit.log_evidence,
            probability: findings.weights.sets[place],
            chi_square: refit.chi_square,
            rmse_k: Rmse { train: refit.rmse_train_k, held_out: refit.rmse_held_out_k },
        }
    };
    let ranked = order.into_iter().enumerate();
    let written = ranked.filter(|(rank, place)| *rank < MOST_WRITTEN || always.contains(place));
    written.map(|(_, place)| result(place)).collect()
}

fn unseen(findings: &Findings<'_>) -> Vec<Unseen> {
    let unseen_effect = |effect: usize, why: String| Unseen { id: findings.id(effect).to_owned(), why };
    let mut list: Vec<Unseen> =
        findings.state.screening.unseen.iter().map(|(effect, why)| unseen_effect(*effect, why.clone())).collect();
    // What no set was fitted with is not judged either.
    let is_fitted = |effect: &usize| findings.state.refits.iter().any(|refit| refit.effects.contains(effect));
    for (effect, why) in findings.state.failed.iter().filter(|(effect, _)| !is_fitted(effect)) {
        let id = findings.id(*effect);
        if !list.iter().any(|known| known.id == id) {
            list.push(unseen_effect(*effect, format!("it cannot be fitted: {why}")));
        }
    }
    list
}

fn detectable(findings: &Findings<'_>) -> BTreeMap<String, Detectable> {
    let list = findings.state.screening.detectable.iter();
    list.map(|(effect, value, unit)| {
        (findings.id(*effect).to_owned(), Detectable { value: *value, unit: unit.clone() })
    })
    .collect()
}

fn noise(problem: &Problem, state: &State) -> BTreeMap<String, NoiseResult> {
    let mut results = BTreeMap::new();
    for (index, measurement) in problem.measurements.iter().enumerate() {
        for (place, sensor) in measurement.sensors.iter().enumerate() {
            let part = |value: &Option<crate::measurement::Uncertain>| value.as_ref().map(|v| v.nominal());
            let (sigma, white) = (part(&sensor.sigma).unwrap_or(0.0), part(&sensor.white).unwrap_or(0.0));
            let total = total_sd(sigma, white);
            let time = part(&sensor.correlation_time_s).filter(|_| matches!(measurement.rows, Rows::Transient { .. }));
            let share = if time.is_some() && total > 0.0 { sigma * sigma / (total * total) } else { 0.0 };
            let own = state.noise.iter().find(|one| one.measurement == index && one.sensor == place);
            let estimated = own.is_some();
            let error = own.and_then(|one| one.model_error);
            results.insert(
                sensor.name.clone(),
                NoiseResult {
                    sigma: own.filter(|_| error.is_some()).map_or(total, |one| one.noise.total()),
                    model_error: error.map(|error| error.sd),
                    counts_as: error.map(|_| total),
                    correlation_time_s: time,
                    correlated_share: share,
                    unit: problem.model.quantities[sensor.quantity].unit.clone(),
                    estimated,
                },
            );
        }
    }
    results
}
