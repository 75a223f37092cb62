//! The end of the steps that are stated: before a further one that does not say where something is missing.
//!
//! What such a step gains is as likely to be missing elsewhere, or errors of the model. All steps take part in the verdict and in the
//! probabilities of the others; the diagnosis of the next pass, which has the steps before it, asks again.

use crate::diagnosis::engine::Diagnosis;
use crate::diagnosis::odds::posterior_odds::{LEAST_RIVAL, RIVALS_WITHIN};
use crate::diagnosis::story::course::Story;
use crate::diagnosis::story::rules::{AskedOfUnseen, pays_by};
use crate::diagnosis::story::step::{Addition, Step};
use crate::diagnosis::verdict::findings::Findings;
use crate::diagnosis::verdict::numbers::joined;
use crate::diagnosis::verdict::one_kind::are_one_thing;
use crate::document::percent;
use crate::math::sort::sort_by;

/// Least probability, among all that may be added at a step and nothing, that something is missing where its effect acts: odds below 3
/// are not worth more than a bare mention (Kass & Raftery 1995, J. Am. Stat. Assoc. 90, 773).
const SAYS_WHERE: f64 = 0.75;
/// Most effects that are named as what may be next.
const MOST_NEXT: usize = 3;

/// Whether a further step says where something is missing, by the probability that it is there.
fn says_where(probability: f64) -> bool {
    probability >= SAYS_WHERE
}

impl Diagnosis {
    /// Ends the steps of findings before the first further one of which the place is open, and selects the set to which they lead; so
    /// whether it did.
    pub(super) fn end_where_open(&self, findings: &mut Findings<'_>) -> bool {
        let Some(story) = findings.story.as_ref().filter(|story| story.end() == findings.selected) else {
            return false;
        };
        let is_open = |(number, step): (usize, &Step)| {
            let chosen = step.additions.iter().find(|one| step.chosen == Some(one.place));
            number > 0 && chosen.is_some_and(|chosen| !says_where(findings.share_of_thing(step, chosen)))
        };
        let Some(number) = story.steps.iter().enumerate().position(is_open) else { return false };
        let cut = self.cut(findings.state, story, number);
        let end = cut.end();
        let selected = &findings.state.refits[end].effects;
        let is_left = |group: &&Vec<usize>| group.first().is_some_and(|first| selected.contains(first));
        let kept = findings.groups.iter().take_while(is_left).count();
        findings.groups.truncate(kept);
        // What stood beside a step that is left out has the probability of the step that is next.
        findings.shared.retain(|&(group, _), _| group < kept);
        findings.storage_alternatives.retain(|own| own.group < kept);
        findings.rivals = rivals(&cut, findings.groups.last());
        findings.story = Some(cut);
        findings.selected = end;
        true
    }
}

/// The sets of the last group at the step of its effect, its own first.
fn rivals(story: &Story, group: Option<&Vec<usize>>) -> Vec<usize> {
    let Some((step, group)) = story.steps.iter().rev().find(|step| step.chosen.is_some()).zip(group) else {
        return Vec::new();
    };
    let place = |effect: &usize| Some(step.additions.iter().find(|one| one.effect == *effect)?.place);
    group.iter().filter_map(place).collect()
}

impl Findings<'_> {
    /// Probability, among all that may be added at a step and nothing, of an effect and of all that is one thing with it.
    fn share_of_thing(&self, step: &Step, own: &Addition) -> f64 {
        let candidates = &self.problem.candidates;
        let is_it = |one: &&Addition| {
            one.effect == own.effect || are_one_thing(&candidates[own.effect], &candidates[one.effect], self.problem)
        };
        step.additions.iter().filter(is_it).map(|one| one.probability).sum()
    }

    /// What may be next where the steps end open, in a sentence; `None` where they do not.
    pub(super) fn open_end(&self) -> Option<String> {
        let story = self.story.as_ref().filter(|story| story.is_open)?;
        let last = story.steps.last()?;
        let pays = |one: &&Addition| {
            let gain = story.gain(self.state, last.before, one.place);
            pays_by(gain, false, AskedOfUnseen::FallUnlessClear)
        };
        let paying = last.additions.iter().filter(pays).map(|one| (self.probability_at_step(one), one.effect));
        let mut paying: Vec<(f64, usize)> = paying.collect();
        sort_by(&mut paying, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let least = paying.first().map_or(0.0, |first| (first.0 / RIVALS_WITHIN).max(LEAST_RIVAL));
        let likely = paying.into_iter().filter(|one| one.0 >= least).take(MOST_NEXT);
        let next: Vec<String> =
            likely.map(|(probability, effect)| format!("{} ({})", self.id(effect), percent(probability))).collect();
        match next.as_slice() {
            [] => None,
            [one] => Some(format!("No further step is taken: whether {one} or something else is missing is open.")),
            several => {
                let likeliest = joined(several);
                Some(format!("No further step is taken: where more is missing is open; the likeliest are {likeliest}."))
            }
        }
    }
}
