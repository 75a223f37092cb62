//! From fits to the verdict.

use crate::diagnosis::engine::{Diagnosis, Remainder, State, TIMES_THE_STEPS};
use crate::diagnosis::fits::held_out::{self, Predicted};
use crate::diagnosis::fits::refit::Begin;
use crate::diagnosis::heat;
use crate::diagnosis::heat::sources::NoHeat;
use crate::diagnosis::noise::overstated;
use crate::diagnosis::odds::posterior_odds::{
    RIVALS_WITHIN, STANDS, best, nothing_stands, odds_with_held_out, posterior_odds, veto,
};
use crate::diagnosis::output::{HeldOutTest, Output, Verdict};
use crate::diagnosis::story::course::Story;
use crate::diagnosis::story::sets::explains_half;
use crate::diagnosis::verdict::discriminating_experiment;
use crate::diagnosis::verdict::findings::{Findings, free, is_small_error};
use crate::diagnosis::verdict::results::{detectable, misfit, models, noise, unseen};
use crate::diagnosis::verdict::small_effects::IS_MODEL_ERROR;
use crate::diagnosis::verdict::{collinear, few_readings, still, trend, words};
use crate::diagnosis::{Problem, Refit};
use crate::document::counted;
use crate::document::suggest::listed;
use crate::math::functions::ln;
use crate::math::sort::{sort_by, sort_by_key};
use crate::math::special::chi_square_sf;
use crate::measurement::Doubt;
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Probability of a set below which the held-out rows are not asked.
const LEAST_TESTED: f64 = 1e-3;
/// Sets named at most that gave way to another one.
const NAMED: usize = 2;
/// Sets at most whose remainders are screened as they might stand in another's place.
const MOST_SCREENED: usize = 20;
/// p-value of the remaining sum of squares below which a set does not bring the model near the noise.
const FAR_FROM_NOISE: f64 = 1e-3;
/// Reduced chi-square, beside the model error that is allowed for, above which a set does not bring the model near it.
const FAR_FROM_MODEL_ERROR: f64 = 2.0;

/// Probability of something that no effect describes from which on that is the verdict.
const RATHER_ELSE: f64 = 0.5;

/// Probability of nothing, with what the held-out rows say, below which these show what tests of the fitted rows do not find: one in
/// twenty, as a test has it.
const SHOWN_BY_HELD_OUT: f64 = 0.05;

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
        let missing = finds.then(|| heat::missing_heat(&problem, baseline));
        let (missing, no_heat) = match missing {
            Some(Ok(missing)) => (Some(missing), None),
            Some(Err(why)) => (None, Some(why)),
            None => (None, None),
        };
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
        let uncompared =
            |why: NoHeat| format!("heat of unknown origin could not be compared with the effects: {}", why.in_words());
        warnings.extend(no_heat.map(uncompared));
        let of_blocks = || self.log_likelihoods_of_blocks(state);
        let story = state.is_misspecified().then(|| Story { of_blocks: of_blocks(), ..self.story(state) });
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
            too_far: None,
            shown_by_held_out,
            fewest_parameters: false,
            model_errors: BTreeMap::new(),
            lumped_nodes: BTreeMap::new(),
            shared: BTreeMap::new(),
            storage_alternatives: Vec::new(),
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
        let known: RefCell<BTreeMap<usize, Option<Tested>>> = RefCell::default();
        let tested_of = |place: usize| {
            let test = || held_out::test_with_prediction(&problem, baseline, &state.refits[place], stated);
            known.borrow_mut().entry(place).or_insert_with(test).clone()
        };
        let test_of = |place: usize| tested_of(place).map(|(test, _)| test);
        if finds && !findings.doubted {
            verdict = Verdict::Unexplained;
            if stated && findings.story.is_none() {
                let outdone = self.outdone(&mut findings, tested_of);
                warnings.extend(gave_way(&findings, &outdone));
                for [set, _] in outdone {
                    findings.weights.leave_out(set);
                }
            }
            held_out_test = best(&findings.weights).and_then(test_of);
            let is_vetoed = |place: usize| test_of(place).is_some_and(|test| test.veto);
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
                    held_out_test = test_of(place);
                }
            }
            let tested = best(&findings.weights);
            findings.select(self.settings().false_alarm);
            findings.storage_alternatives = findings.storage_alternatives();
            if tested != Some(findings.selected) {
                held_out_test = test_of(findings.selected);
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
            let is_far = !chosen.effects.is_empty() && self.is_far_from_noise(&findings);
            let explains = !chosen.effects.is_empty() && !self.leaves_too_much(&findings, is_far);
            if explains {
                findings.add_nearly_as_good();
                findings.add_storage_alternatives();
                // What is far from the noise is not settled.
                verdict = if is_far { Verdict::Ambiguous } else { findings.judge() };
            } else {
                // The test was that of a set which is not adopted.
                held_out_test = None;
                let is_too_far = !chosen.effects.is_empty() && findings.weights.unexplained <= RATHER_ELSE;
                findings.too_far = is_too_far.then_some(findings.selected);
                findings.selected = 0;
                findings.groups.clear();
                findings.storage_alternatives.clear();
                findings.rivals.clear();
                findings.model_errors.clear();
                findings.lumped_nodes.clear();
            }
        }
        if state.is_misspecified() && findings.selected == 0 {
            // A misfit is certain: what a model error takes up is unexplained unless it is smaller than the noise.
            verdict = if is_small_error(state) { Verdict::Adequate } else { Verdict::Unexplained };
        }
        if verdict == Verdict::Unexplained {
            // What leaves too much explains nothing, however probable it is among what was fitted.
            let effects = state.refits.iter().flat_map(|refit| &refit.effects);
            findings.model_errors = effects.map(|&effect| (effect, IS_MODEL_ERROR)).collect();
        }
        if findings.selected > 0 && self.end_where_open(&mut findings) {
            let selected = findings.selected;
            held_out_test = test_of(selected);
            // What it leaves is stated.
            self.leaves_nothing(&mut findings, selected);
        }
        let selected: Vec<String> =
            findings.in_order().into_iter().map(|effect| findings.id(effect).to_owned()).collect();
        warnings.extend(trend::warnings(&problem, &state.refits[findings.selected].effects));
        warnings.extend(collinear::warnings(&problem, &state.refits[findings.selected].effects));
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
        let misfit = misfit(&problem, state);
        let is_definite =
            misfit.family_wise_p <= self.settings().false_alarm || findings.too_far.is_some() || findings.vetoed;
        let effects = self.effects(&findings);
        let mut output = Output {
            verdict,
            words: Vec::new(),
            probability_nothing: nothing,
            probability_unexplained: findings.weights.unexplained,
            only_small_errors: verdict == Verdict::Unexplained && !is_definite,
            misfit,
            kinds: findings.kinds(&effects, &selected),
            effects,
            models: models(&findings),
            selected,
            steps: findings.steps_of_story(),
            unseen: unseen(&findings),
            detectable: detectable(&findings),
            noise: noise(&problem, state),
            discriminating_experiment: discrimination.experiment,
            one_thing: discrimination.one_thing,
            only_in_transients: discrimination.only_in_transients,
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
            doubts: [self.doubts_of(&state.left_out), self.doubts_of_excursions(&state.excursions), doubts(&problem)]
                .concat(),
            warnings,
        };
        output.words = words::verdict(&output, &findings, self.settings().false_alarm);
        output
    }

    /// Where the held-out rows reject a set with its thresholds in the likeliest gaps, and not in others, which the fitted rows leave
    /// open, the likeliest of these counts.
    fn moved(&self, state: &State, problem: &Problem, stated: bool) -> State {
        let mut moved = state.clone();
        let weights = posterior_odds(problem, &state.refits, None);
        let is_refused = |refit: &Refit| {
            let tested = held_out::test_with_prediction(problem, &state.refits[0], refit, stated);
            tested.is_some_and(|(test, predicted)| {
                test.veto || stated && predicted.is_some_and(|predicted| predicted.is_rejected())
            })
        };
        for (refit, weight) in moved.refits.iter_mut().zip(&weights.sets).skip(1) {
            if *weight < LEAST_TESTED || !problem.has_thresholds(&refit.effects) || !is_refused(refit) {
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
            let is_open = |other: &Refit| other.log_evidence + ln(RIVALS_WITHIN) >= highest && !is_refused(other);
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

    /// Sets that the held-out rows reject but do not veto, each with another one that they accept, beside which tests find nothing,
    /// and with which it is less probable; the most probable first. Both are probable by the fitted rows alone. What at most
    /// [`MOST_SCREENED`] sets leave is screened for it.
    fn outdone(&self, findings: &mut Findings<'_>, tested_of: impl Fn(usize) -> Option<Tested>) -> Vec<[usize; 2]> {
        let test_of = |place: usize| {
            let (test, predicted) = tested_of(place)?;
            predicted.filter(|_| !test.veto)
        };
        let mut weights = findings.weights.clone();
        let count = weights.sets.len();
        let mut asked = vec![false; count];
        let mut found = Vec::new();
        let mut screened = 0;
        loop {
            let mut probable: Vec<usize> = (1..count).filter(|&place| weights.sets[place] >= LEAST_TESTED).collect();
            sort_by(&mut probable, |&a, &b| weights.sets[b].total_cmp(&weights.sets[a]));
            let Some(&place) = probable.iter().find(|&&place| !asked[place]) else { return found };
            asked[place] = true;
            let Some(own) = test_of(place).filter(Predicted::is_rejected) else { continue };
            let mut is_left_nothing = |other: usize| {
                let is_known = findings.remaining(other).is_some();
                screened += usize::from(!is_known);
                (is_known || screened <= MOST_SCREENED) && self.leaves_nothing(findings, other)
            };
            let is_better = |&other: &usize| {
                let log_odds = ln(weights.sets[place] / weights.sets[other]);
                other != place
                    && test_of(other).is_some_and(|other| own.is_outdone_by(&other, log_odds))
                    && is_left_nothing(other)
            };
            if let Some(other) = probable.into_iter().find(is_better) {
                found.push([place, other]);
                weights.leave_out(place);
            }
        }
    }

    /// Whether tests find something beside the selected set, or it predicts held-out rows worse than the stated noise allows; not
    /// where a model error is allowed for, which both would be.
    fn finds_beside(&self, findings: &Findings<'_>, held_out: Option<&HeldOutTest>, stated: bool) -> bool {
        let is_clear = |p: f64| p <= self.settings().false_alarm;
        let fails = stated && held_out.and_then(|test| test.p).is_some_and(is_clear);
        !findings.state.is_misspecified() && (fails || findings.remaining_now().is_some_and(is_clear))
    }

    /// Whether the selected set leaves the model far from the noise while tests go on finding something.
    fn is_far_from_noise(&self, findings: &Findings<'_>) -> bool {
        let chosen = &findings.state.refits[findings.selected];
        let found = findings.remaining_now().is_some_and(|p| p <= self.settings().false_alarm);
        let freedom = chosen.residuals.len() as f64 - free(chosen) as f64;
        let far = match findings.state.is_misspecified() {
            true => findings.reduced_chi_square(findings.selected) > FAR_FROM_MODEL_ERROR,
            false => chi_square_sf(chosen.chi_square, freedom.max(1.0)) < FAR_FROM_NOISE,
        };
        found && far
    }

    /// Whether that is too much for an explanation. Where the model is a little wrong everywhere, a set that explains half of the errors on
    /// fitted and on unseen rows is one, whatever remains.
    fn leaves_too_much(&self, findings: &Findings<'_>, is_far: bool) -> bool {
        let is_explanation = findings.state.is_misspecified() && explains_half(findings.state, 0, findings.selected);
        is_far && !is_explanation || findings.weights.unexplained > RATHER_ELSE
    }
}

/// What the held-out rows say of a set, and what it predicts of them.
type Tested = (HeldOutTest, Option<Predicted>);

/// What is said of sets that the held-out rows reject and of those to which they give way: one sentence for each of the latter.
fn gave_way(findings: &Findings<'_>, outdone: &[[usize; 2]]) -> Vec<String> {
    let named = |place: usize| named(findings, &findings.state.refits[place].effects);
    let mut accepted: Vec<usize> = Vec::new();
    for &[_, by] in outdone {
        if !accepted.contains(&by) {
            accepted.push(by);
        }
    }
    let said = |by: usize| {
        let rejected: Vec<String> =
            outdone.iter().filter(|[_, other]| *other == by).map(|&[set, _]| named(set)).collect();
        format!(
            "the held-out rows accept `{}` and reject {}; the held-out rows took part in the choice",
            named(by),
            listed(rejected.iter().map(String::as_str), NAMED)
        )
    };
    accepted.into_iter().map(said).collect()
}

fn named(findings: &Findings<'_>, effects: &[usize]) -> String {
    let ids: Vec<&str> = effects.iter().map(|&effect| findings.id(effect)).collect();
    ids.join(" + ")
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

/// What is doubtful about the data; starts first, since all that follows shows them.
fn doubts(problem: &Problem) -> Vec<Doubt> {
    let mut doubts: Vec<Doubt> = problem.measurements.iter().flat_map(|own| own.doubts.iter().cloned()).collect();
    sort_by_key(&mut doubts, |doubt| !doubt.is_of_start());
    doubts
}
