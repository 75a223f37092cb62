//! Why the leading effect of a group goes first although another one of the group is more probable.

use crate::diagnosis::odds::narrow_prior::is_prior;
use crate::diagnosis::odds::posterior_odds::best;
use crate::diagnosis::output::{EffectResult, Output, Precedence};
use crate::diagnosis::story::course::Story;
use crate::diagnosis::story::plainness::Plainness;
use crate::diagnosis::story::rules::{AskedOfUnseen, pays_by};
use crate::diagnosis::story::sets::why_plainer;
use crate::diagnosis::verdict::findings::Findings;
use crate::document::percent;

impl Precedence {
    /// The reason, to go on with after a colon or `because`.
    pub fn reason(self) -> &'static str {
        match self {
            Self::ModelError => {
                "the readings want it more, but a larger share of its probability is given to errors of the model"
            }
            Self::HeldOut => "held-out readings speak against the other",
            Self::Fitted => "the fitted readings speak against the other",
            Self::Law => "a law goes before an unknown function that does not clearly explain more",
            Self::Group => "what acts on a whole group goes before a single place that does not clearly explain more",
            Self::Size => "the other would have to be a hundred times as large as is plausible",
            Self::Control => "the other follows a heat that a control makes, which follows whatever is missing",
            Self::Logged => "heat that was logged explains nearly as much as the other, which goes by the clock",
            Self::ChangeByHeat => {
                "heat in proportion to a logged power or irradiance explains nearly as much as the other, in which that changes a conductance or a load"
            }
            Self::Inputs => "the other takes several inputs and hardly explains more",
            Self::Set => "all that is selected is more probable than what was fitted with the other in its place",
            Self::OtherStep => "the other is that probable only beside other effects",
            Self::Prior => "a prior that may be too narrow is checked before anything is added",
            Self::FewestParameters => "tests still find something beside both, and its set has the fewest parameters",
            Self::BestSet => "its set is the most probable one, the other is that probable over several sets together",
        }
    }
}

/// Whether an effect, the first of each pair, is the more probable one by the readings, while errors of the model take more of it.
pub fn is_by_model_error(weighed: [f64; 2], model_error: [f64; 2]) -> bool {
    weighed[0] >= weighed[1] && model_error[0] > model_error[1]
}

/// That others of its group are more probable than an effect, and why it goes first all the same; nothing where none is.
pub fn in_words(output: &Output, effect: &EffectResult) -> String {
    let rivals = output.more_probable(effect);
    let Some(first) = rivals.first() else { return String::new() };
    let (others, are) = match rivals.len() {
        1 => (String::new(), "is"),
        count => (format!(" and {} more of its group", count - 1), "are"),
    };
    let reason = effect.precedence.map_or_else(String::new, |own| format!(": {}", own.reason()));
    format!(
        " It goes first although {} ({}){others} {are} more probable{reason}.",
        first.id,
        percent(first.probability)
    )
}

impl Findings<'_> {
    /// Why the effect that leads a group goes before a more probable one; `None` where it leads none, none is, or no rule says why.
    pub(super) fn precedence(&self, effect: usize) -> Option<Precedence> {
        let group = self.groups.iter().find(|group| group.first() == Some(&effect))?;
        let selected = &self.state.refits[self.selected].effects;
        let others = group[1..].iter().copied().filter(|other| !selected.contains(other));
        let more_probable = |a: usize, b: usize| if self.probability(b) > self.probability(a) { b } else { a };
        let other = others.reduce(more_probable)?;
        if self.probability(other) <= self.probability(effect) {
            return None;
        }
        let both = [effect, other];
        if is_by_model_error(both.map(|one| self.probability_as_weighed(one)), both.map(|one| self.model_error(one))) {
            // That the readings want it more may be since the other stands behind what is plainer.
            return self.plainer(effect, other).or(Some(Precedence::ModelError));
        }
        match &self.story {
            Some(story) => self.precedence_in_story(story, effect, other),
            None => self.precedence_of_set(effect, other),
        }
    }

    /// Why an effect goes before another, which is more probable by itself, as the plainer one at its step; `None` where it does not, or
    /// explains too little.
    fn plainer(&self, effect: usize, other: usize) -> Option<Precedence> {
        let (story, step) = (self.story.as_ref()?, self.story_step_of(effect)?);
        let of = |effect: usize| Some(step.additions.iter().find(|one| one.effect == effect)?.place);
        let sets = [of(effect)?, of(other)?];
        if story.logs[sets[1]] <= story.logs[sets[0]] {
            return None;
        }
        let why = |sets: [usize; 2]| why_plainer(self.problem, self.state, &story.drivers, step.before, sets);
        // By way of a third one the reason is that by which this goes before the other.
        let by_way = || step.additions.iter().find_map(|one| why([sets[0], one.place]).and(why([one.place, sets[1]])));
        let why = why(sets).or_else(by_way)?;
        Some(match why {
            Plainness::FreeOfControl => Precedence::Control,
            Plainness::Logged => Precedence::Logged,
            Plainness::ChangeByHeat => Precedence::ChangeByHeat,
            Plainness::FewerInputs => Precedence::Inputs,
        })
    }

    /// Whether an effect acts on a group, and another one at a single place that is not elsewhere.
    fn is_whole(&self, effect: usize, other: usize) -> bool {
        let [own, other] = [effect, other].map(|effect| &self.problem.candidates[effect]);
        own.is_group() && !other.is_group() && !own.is_elsewhere_than(other)
    }

    fn precedence_of_set(&self, effect: usize, other: usize) -> Option<Precedence> {
        let is_prior = |effect: usize| is_prior(&self.problem.candidates[effect]);
        if is_prior(effect) && !is_prior(other) {
            return Some(Precedence::Prior);
        }
        if self.is_whole(effect, other) {
            return Some(Precedence::Group);
        }
        if self.fewest_parameters {
            return Some(Precedence::FewestParameters);
        }
        (best(&self.weights) == Some(self.selected)).then_some(Precedence::BestSet)
    }

    fn precedence_in_story(&self, story: &Story, effect: usize, other: usize) -> Option<Precedence> {
        let refits = &self.state.refits;
        let step = self.story_step_of(effect)?;
        let of = |effect: usize| step.additions.iter().find(|one| one.effect == effect);
        let (own, rival) = (of(effect)?, of(other));
        if let Some(rival) = rival.filter(|rival| rival.probability > own.probability) {
            let [before, after] = [step.before, rival.place].map(|place| &refits[place]);
            let gain = story.gain(self.state, step.before, rival.place);
            let is_first = before.effects.is_empty();
            if gain.log_odds > 0.0 && !pays_by(gain, is_first, AskedOfUnseen::FallUnlessClear) {
                let by_fitted = !is_first && gain.is_against_fitted();
                return Some(if by_fitted { Precedence::Fitted } else { Precedence::HeldOut });
            }
            let is_curve = |effect: usize| self.problem.is_unknown_function(effect);
            if is_curve(other) && !is_curve(effect) {
                return Some(Precedence::Law);
            }
            let laws = step.additions.iter().filter(|one| !is_curve(one.effect));
            let leading = laws.reduce(|a, b| if story.logs[b.place] > story.logs[a.place] { b } else { a });
            // A whole surface goes before places elsewhere too, unless the most probable law is there.
            if self.is_whole(effect, other) || leading.is_some_and(|law| self.is_whole(effect, law.effect)) {
                return Some(Precedence::Group);
            }
            if after.is_implausible(other) && !refits[own.place].is_implausible(effect) {
                return Some(Precedence::Size);
            }
        }
        if let Some(why) = self.plainer(effect, other) {
            return Some(why);
        }
        // Where another effect would have been first, the steps lead to a less probable set.
        let in_its_place = |place: &usize| {
            let effects = &refits[*place].effects;
            effects.contains(&other) && !effects.contains(&effect)
        };
        let sets = (0..refits.len()).filter(in_its_place).map(|place| story.logs[place]);
        if sets.reduce(f64::max).is_some_and(|most| most < story.logs[self.selected]) {
            return Some(Precedence::Set);
        }
        let here = rival.map_or(0.0, |rival| rival.probability);
        (self.probability_as_weighed(other) > here).then_some(Precedence::OtherStep)
    }
}
