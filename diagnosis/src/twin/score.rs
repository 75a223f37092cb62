//! How well answers do: rates over cases, with exact binomial intervals (Clopper & Pearson 1934) of 95 %.

use serde::{Deserialize, Serialize};

use super::answer::Answer;
use super::truth::{NoiseTruth, Truth};
use crate::diagnosis::Verdict;
use crate::math::functions::ln;
use crate::statistics::interval::Interval;

/// A case and what was said of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// What is true.
    pub truth: Truth,
    /// What was said.
    pub answer: Answer,
}

/// How often something was so.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rate {
    /// Cases in which it was.
    pub hits: u64,
    /// All cases.
    pub of: u64,
    /// Lower end of the 95 % interval of its probability.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

impl Rate {
    /// The rate of a list of outcomes.
    pub fn of(outcomes: impl IntoIterator<Item = bool>) -> Self {
        let (mut hits, mut of) = (0, 0);
        for hit in outcomes {
            of += 1;
            hits += u64::from(hit);
        }
        let interval = Interval::clopper_pearson(hits, of, 0.95);
        Self { hits, of, lower: interval.lower, upper: interval.upper }
    }

    /// The share; `None` without cases.
    pub fn share(&self) -> Option<f64> {
        (self.of > 0).then(|| self.hits as f64 / self.of as f64)
    }
}

/// How cases of a kind fare.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detection {
    /// Something was found to be missing.
    pub found: Rate,
    /// The truth is what was selected, and nothing else.
    pub named: Rate,
    /// Each true effect was selected, or is in a group of three at most with one that was.
    pub grouped: Rate,
}

/// Detection at a size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BySize {
    /// The size asked for, in standard deviations.
    pub size: f64,
    /// Number of effects.
    pub effects: usize,
    /// All cases.
    pub all: Detection,
    /// Those in which no rival explains the truth.
    pub separable: Detection,
}

/// Detection of an effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ByEffect {
    /// The effect; `"nothing"` where nothing was hidden.
    pub effect: String,
    /// The size asked for, or the one that the stated amplitude has where `asked` is false.
    pub size: Option<f64>,
    /// How its cases fare.
    pub detection: Detection,
}

/// A bin of stated probabilities.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bin {
    /// Lower end of the bin.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
    /// Mean of the stated probabilities in it.
    pub stated: f64,
    /// How often what they were stated of is true.
    pub true_rate: Rate,
}

/// How trials fare whose truth is finer than the believed model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FinerScore {
    /// One effect is hidden: it, or what the model error hides from it, is first in the story or selected.
    pub first: Rate,
    /// One effect is hidden: something is said to be missing.
    pub found: Rate,
    /// Nothing large is hidden: no effect is `identified` and none given more than 0.9.
    pub silent: Rate,
    /// An effect that is not hidden is given more than 0.9, or `identified`.
    pub wrong: Rate,
}

impl FinerScore {
    /// The score of trials.
    pub fn of(trials: &[Trial]) -> Self {
        let hidden = || trials.iter().filter(|trial| !trial.truth.effects.is_empty());
        let nothing = trials.iter().filter(|trial| trial.truth.effects.is_empty());
        Self {
            first: Rate::of(hidden().map(Trial::is_first)),
            found: Rate::of(hidden().map(Trial::found)),
            silent: Rate::of(nothing.map(|trial| !trial.is_surely_wrong())),
            wrong: Rate::of(trials.iter().map(Trial::is_surely_wrong)),
        }
    }
}

/// Probabilities above this one are taken for an answer.
const SURE: f64 = 0.9;

/// The score of a list of trials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Cases.
    pub cases: u64,
    /// Something is said to be missing where nothing is: with the noise that is stated.
    pub false_alarms_stated_noise: Rate,
    /// The same, with correlated noise that is not stated.
    pub false_alarms_correlated: Rate,
    /// The same, of both.
    pub false_alarms: Rate,
    /// Detection by size and number of effects.
    pub sizes: Vec<BySize>,
    /// Detection by effect and size, of cases with one effect.
    pub effects: Vec<ByEffect>,
    /// Physics outside the catalogue that is said to be unexplained.
    pub outside_unexplained: Rate,
    /// Physics outside the catalogue that is said to be unexplained, or given to what stands for it.
    pub outside_right: Rate,
    /// Physics outside the catalogue that is given, as identified, to an effect that does not stand for it.
    pub outside_misnamed: Rate,
    /// Number of effects in the group of what was selected first, and how often.
    pub group_sizes: Vec<(usize, u64)>,
    /// Amplitude intervals of rightly selected effects that hold the true value; their confidence is 95 %.
    pub coverage: Rate,
    /// Stated probabilities of effects against how often they are true.
    pub reliability: Vec<Bin>,
    /// Answers whose best set is given 0.9 or more, and that are right.
    pub sure_and_right: Rate,
    /// Mean logarithm of the probability that was stated of the truth, at least 1e-6; `None` without cases.
    pub log_score: Option<f64>,
}

/// Largest group that counts as an answer.
pub const SMALL_GROUP: usize = 3;
/// Ends of the bins of stated probabilities.
const BINS: [f64; 9] = [0.0, 0.01, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0];
/// Least probability that the logarithmic score knows.
const LEAST_PROBABILITY: f64 = 1e-6;

impl Trial {
    /// Whether something is said to be missing.
    pub fn found(&self) -> bool {
        self.answer.verdict != Verdict::Adequate
    }

    /// Whether the effects selected are the true ones.
    pub fn named(&self) -> bool {
        let mut selected: Vec<&str> = self.answer.selected.iter().map(String::as_str).collect();
        let mut truth = self.truth.ids();
        selected.sort_unstable();
        truth.sort_unstable();
        !truth.is_empty() && self.found() && selected == truth
    }

    /// Whether each true effect was selected or shares a small group with one that was.
    pub fn grouped(&self) -> bool {
        let stands = |id: &&str| {
            let group = self.answer.group_of(id);
            let selected = |member: &&str| self.answer.selected.iter().any(|effect| effect == member);
            self.answer.selected.iter().any(|effect| effect == id)
                || (group.len() <= SMALL_GROUP && group.iter().any(selected))
        };
        let ids = self.truth.ids();
        !ids.is_empty() && self.found() && ids.iter().all(stands)
    }

    /// Whether an effect is a hidden one, or explains the same within the model error.
    fn stands_for_truth(&self, id: &str) -> bool {
        let rivals = self.truth.rivals.iter().flatten().flat_map(|rival| &rival.effects);
        self.truth.effects.iter().map(|effect| &effect.id).chain(rivals).any(|effect| effect == id)
    }

    /// Whether the first step, or without steps what is selected with its groups, has what stands for the truth.
    pub fn is_first(&self) -> bool {
        let steps = self.answer.first_step.iter().map(String::as_str);
        let groups = self.answer.selected.iter().flat_map(|id| self.answer.group_of(id));
        let selected = self.answer.selected.iter().map(String::as_str).chain(groups);
        let mut first: Box<dyn Iterator<Item = &str>> =
            if self.answer.first_step.is_empty() { Box::new(selected) } else { Box::new(steps) };
        self.found() && first.any(|id| self.stands_for_truth(id))
    }

    /// Whether an effect that does not stand for the truth is given more than 0.9, or identified.
    pub fn is_surely_wrong(&self) -> bool {
        let sure = self.answer.probabilities.iter().filter(|(_, probability)| *probability > SURE).map(|(id, _)| id);
        let identified = self.answer.selected.iter().filter(|_| self.answer.verdict == Verdict::Identified);
        sure.chain(identified).any(|id| !self.stands_for_truth(id))
    }

    /// The stated probability of the truth: of its set, of nothing, or of something unexplained.
    pub fn stated_of_truth(&self) -> f64 {
        if self.truth.outside.is_some() || (self.truth.effects.is_empty() && self.truth.finer.is_some()) {
            return self.answer.unexplained;
        }
        self.answer.probability_of(&self.truth.ids())
    }
}

fn detection<'a>(trials: impl Iterator<Item = &'a Trial> + Clone) -> Detection {
    Detection {
        found: Rate::of(trials.clone().map(Trial::found)),
        named: Rate::of(trials.clone().map(Trial::named)),
        grouped: Rate::of(trials.map(Trial::grouped)),
    }
}

/// Scores trials; their order is of no account but for the last digits of means.
pub fn score(trials: &[Trial]) -> Score {
    let nulls = || trials.iter().filter(|trial| trial.truth.is_null());
    let as_stated = |trial: &&Trial| trial.truth.noise == NoiseTruth::AsStated;
    let outside = || trials.iter().filter(|trial| trial.truth.outside.is_some());
    let stands = |trial: &Trial| {
        let names = trial.truth.outside.as_ref().map(super::truth::Outside::stands_for).unwrap_or_default();
        trial.found() && !trial.answer.selected.is_empty() && trial.answer.selected.iter().all(|id| names.contains(id))
    };
    let unexplained = |trial: &Trial| trial.answer.verdict == Verdict::Unexplained;
    Score {
        cases: trials.len() as u64,
        false_alarms_stated_noise: Rate::of(nulls().filter(as_stated).map(Trial::found)),
        false_alarms_correlated: Rate::of(nulls().filter(|trial| !as_stated(trial)).map(Trial::found)),
        false_alarms: Rate::of(nulls().map(Trial::found)),
        sizes: sizes(trials),
        effects: effects(trials),
        outside_unexplained: Rate::of(outside().map(unexplained)),
        outside_right: Rate::of(outside().map(|trial| unexplained(trial) || stands(trial))),
        outside_misnamed: Rate::of(
            outside().map(|trial| trial.answer.verdict == Verdict::Identified && !stands(trial)),
        ),
        group_sizes: group_sizes(trials),
        coverage: Rate::of(trials.iter().flat_map(covered)),
        reliability: reliability(trials),
        sure_and_right: sure(trials),
        log_score: log_score(trials),
    }
}

/// Sizes asked for, each once, ascending.
fn asked<'a>(trials: impl Iterator<Item = &'a Trial>) -> Vec<f64> {
    let mut sizes: Vec<f64> = trials.filter_map(|trial| trial.truth.asked).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.dedup();
    sizes
}

fn sizes(trials: &[Trial]) -> Vec<BySize> {
    let mut list = Vec::new();
    for effects in 1..=2 {
        let with_effects = || trials.iter().filter(move |trial| trial.truth.effects.len() == effects);
        for size in asked(with_effects()) {
            let here = with_effects().filter(|trial| trial.truth.asked == Some(size));
            let separable = here.clone().filter(|trial| trial.truth.is_separable() == Some(true));
            list.push(BySize { size, effects, all: detection(here), separable: detection(separable) });
        }
    }
    list
}

fn effects(trials: &[Trial]) -> Vec<ByEffect> {
    let mut names: Vec<&str> = (trials.iter().filter(|trial| trial.truth.effects.len() == 1))
        .map(|trial| trial.truth.effects[0].effect.as_str())
        .collect();
    names.sort_unstable();
    names.dedup();
    let mut list = Vec::new();
    for name in names {
        let of_effect = || {
            let alone = trials.iter().filter(|trial| trial.truth.effects.len() == 1);
            alone.filter(|trial| trial.truth.effects[0].effect == name)
        };
        for size in asked(of_effect()) {
            let detection = detection(of_effect().filter(|trial| trial.truth.asked == Some(size)));
            list.push(ByEffect { effect: name.to_owned(), size: Some(size), detection });
        }
        if of_effect().any(|trial| trial.truth.asked.is_none()) {
            let detection = detection(of_effect().filter(|trial| trial.truth.asked.is_none()));
            list.push(ByEffect { effect: name.to_owned(), size: None, detection });
        }
    }
    list
}

fn group_sizes(trials: &[Trial]) -> Vec<(usize, u64)> {
    let mut sizes: Vec<(usize, u64)> = Vec::new();
    for trial in trials.iter().filter(|trial| trial.found()) {
        let Some(first) = trial.answer.selected.first() else { continue };
        let size = trial.answer.group_of(first).len();
        match sizes.iter_mut().find(|(group_size, _)| *group_size == size) {
            Some((_, count)) => *count += 1,
            None => sizes.push((size, 1)),
        }
    }
    sizes.sort_unstable();
    sizes
}

/// For each amplitude of a rightly selected effect whether its interval holds the truth.
fn covered(trial: &Trial) -> Vec<bool> {
    let mut outcomes = Vec::new();
    for effect in trial.truth.effects.iter().filter(|effect| trial.answer.selected.contains(&effect.id)) {
        for value in effect.parameters.iter().filter(|parameter| parameter.amplitude) {
            let is_same =
                |stated: &&super::answer::StatedAmplitude| stated.id == effect.id && stated.parameter == value.name;
            if let Some(stated) = trial.answer.amplitudes.iter().find(is_same) {
                outcomes.push(stated.lower <= value.value && value.value <= stated.upper);
            }
        }
    }
    outcomes
}

fn reliability(trials: &[Trial]) -> Vec<Bin> {
    let stated: Vec<(f64, bool)> = trials
        .iter()
        .flat_map(|trial| {
            let truth = trial.truth.ids();
            let pairs = trial.answer.probabilities.iter();
            pairs.map(|(id, p)| (*p, truth.contains(&id.as_str()))).collect::<Vec<_>>()
        })
        .collect();
    let mut bins = Vec::new();
    for ends in BINS.windows(2) {
        let last = ends[1] == 1.0;
        let inside: Vec<&(f64, bool)> =
            stated.iter().filter(|(p, _)| ends[0] <= *p && (*p < ends[1] || last)).collect();
        if !inside.is_empty() {
            let mean = inside.iter().map(|(p, _)| p).sum::<f64>() / inside.len() as f64;
            let true_rate = Rate::of(inside.iter().map(|(_, hit)| *hit));
            bins.push(Bin { lower: ends[0], upper: ends[1], stated: mean, true_rate });
        }
    }
    bins
}

fn sure(trials: &[Trial]) -> Rate {
    let right = |trial: &Trial| {
        let truth = trial.truth.ids();
        let best = trial.answer.models.iter().max_by(|a, b| a.probability.total_cmp(&b.probability));
        let nothing = trial.answer.nothing;
        match best {
            Some(best) if best.probability >= 0.9 && best.probability >= nothing => {
                let mut stated: Vec<&str> = best.effects.iter().map(String::as_str).collect();
                let mut truth = truth;
                stated.sort_unstable();
                truth.sort_unstable();
                let whole = trial.truth.outside.is_none() && trial.truth.finer.is_none();
                Some(stated == truth && whole)
            }
            _ if nothing >= 0.9 => Some(trial.truth.is_null()),
            _ => None,
        }
    };
    Rate::of(trials.iter().filter_map(right))
}

fn log_score(trials: &[Trial]) -> Option<f64> {
    let logs: Vec<f64> = trials.iter().map(|trial| ln(trial.stated_of_truth().max(LEAST_PROBABILITY))).collect();
    (!logs.is_empty()).then(|| logs.iter().sum::<f64>() / logs.len() as f64)
}
