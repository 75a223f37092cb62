//! A surrogate of a model that is asked outside: settings, and what it makes of the model. Its error is made of parameters like any
//! others, standard normal numbers: each output is the surrogate's mean, and a sum of them with weights that depend on the point
//! ([`crate::inference::gaussian_process::emulator`]).

use std::ops::Range;
use std::sync::Arc;

use crate::document::prior::Prior;
use crate::document::{Diagnostic, Diagnostics, Place, Spanned, code, written_struct};
use crate::expression::{Dimension, ExprId, Symbol, Unit};
use crate::inference::surrogate::Answers;
use crate::random::Distribution;
use crate::thermal::{self, Derivatives, Parameter};

use super::resolve::{ResolvedModel, Scale};

/// Rounds where nothing is said, and most of them.
const ROUNDS: u64 = 3;
const MOST_ROUNDS: u64 = 20;
/// Runs of a round, as a part of the first ones, where nothing is said; and the fewest.
const PART: u64 = 6;
const FEWEST_MORE: u64 = 4;
/// Fewest runs, and most of them with those of all rounds: the cost of a process grows with their third power.
const FEWEST_RUNS: u64 = 10;
const MOST_RUNS: u64 = 1000;
/// Share of the readings' noise where nothing is said.
const SHARE: f64 = 0.2;
/// Anchors of an output's error where nothing is said, and most of them.
const ANCHORS: u64 = 4;
const MOST_ANCHORS: u64 = 16;
/// Behind the name of an output, the name of the parameters that are its error.
const ERROR: &str = "surrogate_error";

written_struct! {
    /// A Gaussian process in place of a model that takes long to answer, through runs of the model itself.
    pub struct SurrogateForm: "a surrogate" {
        /// Runs within the priors and the inputs' ranges.
        required runs: Spanned<u64>,
        /// Rounds of further runs, where readings or requirements need them, at most; 3 where it is left out.
        optional rounds: Spanned<u64>,
        /// Runs of a round; a sixth of `runs` where it is left out.
        optional more: Spanned<u64>,
        /// Share of the readings' noise at which the surrogate's error is small enough, 0.2 where it is left out.
        optional share: Spanned<f64>,
        /// Points at which the error of an output is a parameter of its own, at most; 4 where it is left out. Between them the error
        /// follows as the process says.
        optional anchors: Spanned<u64>,
    }
}

/// A surrogate with its settings.
#[derive(Clone, Debug)]
pub struct Surrogate {
    /// Where the model asks for it.
    pub place: Place,
    /// Runs within the priors and the inputs' ranges.
    pub runs: u64,
    /// Most rounds of further runs.
    pub rounds: u64,
    /// Runs of a round.
    pub more: u64,
    /// Share of the readings' noise at which the surrogate's error is small enough.
    pub share: f64,
    /// Most anchors of an output's error.
    pub anchors: usize,
    /// The model that it stands for.
    pub truth: thermal::External,
    /// What of that decides what it answers.
    pub answered_by: serde_json::Value,
    /// Names of the outputs, and their SI units.
    pub outputs: Vec<(String, String)>,
    /// What answers in the model's place.
    pub answers: Arc<Answers>,
}

impl Surrogate {
    /// Places of the parameters that are the rests of the outputs' errors, among all parameters; `first` is that of the first error.
    pub fn rests(&self, first: usize) -> impl Iterator<Item = usize> + use<> {
        let (parts, outputs) = (self.anchors + 1, self.outputs.len());
        (0..outputs).map(move |output| first + output * parts + parts - 1)
    }

    /// What of it decides a result.
    pub fn identity(&self) -> serde_json::Value {
        serde_json::json!({
            "runs": self.runs,
            "rounds": self.rounds,
            "more": self.more,
            "share": self.share,
            "anchors": self.anchors,
            "of": self.truth.identity,
        })
    }
}

/// Checks the settings; `None` where something is wrong.
fn settings(form: &SurrogateForm, diagnostics: &mut Diagnostics) -> Option<[u64; 4]> {
    let before = diagnostics.errors();
    let mut check = |written: &Spanned<u64>, least: u64, most: u64, what: &str| {
        if !(least..=most).contains(&written.value) {
            let message = format!("{} {what}", written.value);
            let diagnostic = Diagnostic::error(&code::EXTERNAL_MODEL, &written.place, message);
            diagnostics.push(diagnostic.expected(format!("an integer from {least} to {most}")));
        }
    };
    check(&form.runs, FEWEST_RUNS, MOST_RUNS, "runs");
    if let Some(rounds) = &form.rounds {
        check(rounds, 0, MOST_ROUNDS, "rounds");
    }
    if let Some(more) = &form.more {
        check(more, 1, MOST_RUNS, "runs of a round");
    }
    if let Some(anchors) = &form.anchors {
        check(anchors, 0, MOST_ANCHORS, "anchors of an output's error");
    }
    if let Some(share) = form.share.as_ref().filter(|share| !(share.value > 0.0 && share.value <= 1.0)) {
        let message = format!("a share of {} of the noise", share.value);
        let diagnostic = Diagnostic::error(&code::EXTERNAL_MODEL, &share.place, message);
        diagnostics.push(diagnostic.expected("a number above 0, at most 1"));
    }
    let runs = form.runs.value;
    let rounds = form.rounds.as_ref().map_or(ROUNDS, |rounds| rounds.value);
    let more = form.more.as_ref().map_or((runs / PART).max(FEWEST_MORE), |more| more.value);
    if diagnostics.errors() == before && runs + rounds * more > MOST_RUNS {
        let message = format!("{runs} runs and {rounds} rounds of {more} are {} in all", runs + rounds * more);
        let diagnostic = Diagnostic::error(&code::EXTERNAL_MODEL, &form.runs.place, message);
        diagnostics.push(diagnostic.expected(format!("at most {MOST_RUNS} runs in all")));
    }
    let anchors = form.anchors.as_ref().map_or(ANCHORS, |anchors| anchors.value);
    (diagnostics.errors() == before).then_some([runs, rounds, more, anchors])
}

/// Puts a surrogate in the place of what is asked outside, with what of that decides its answers; `outputs` are names and SI units. Gives the expression of each
/// output.
pub(super) fn resolve(
    form: &Spanned<SurrogateForm>,
    (truth, answered_by): (thermal::External, serde_json::Value),
    outputs: &[(String, String)],
    model: &mut ResolvedModel,
    diagnostics: &mut Diagnostics,
) -> Option<Vec<ExprId>> {
    let [runs, rounds, more, anchors] = settings(&form.value, diagnostics)?;
    let anchors = usize::try_from(anchors).unwrap_or(usize::MAX);
    let errors = errors(model, outputs, anchors);
    let mut steps = truth.steps.clone();
    let own = errors.start.min(steps.len());
    // Outputs are linear in their errors.
    steps.splice(own..own, errors.clone().map(|_| 1.0));
    let answers = Arc::new(Answers::with_anchors(anchors));
    let surrogate = Surrogate {
        place: form.place.clone(),
        runs,
        rounds,
        more,
        share: form.value.share.as_ref().map_or(SHARE, |share| share.value),
        anchors,
        truth,
        answered_by,
        outputs: outputs.to_vec(),
        answers: Arc::clone(&answers),
    };
    let number = |place: usize| u32::try_from(place).unwrap_or(u32::MAX);
    let graph = &mut model.model.graph;
    let parts = anchors + 1;
    let expression = |place: usize| {
        let first = place * (parts + 1);
        let mut value = graph.symbol(Symbol::Output(number(first)));
        for part in 0..parts {
            let size = graph.symbol(Symbol::Output(number(first + 1 + part)));
            let error = graph.symbol(Symbol::Parameter(number(errors.start + place * parts + part)));
            let apart = graph.multiply(size, error);
            value = graph.add(value, apart);
        }
        value
    };
    let expressions = (0..outputs.len()).map(expression).collect();
    model.model.external = Some(thermal::External {
        outputs: outputs.len() * (parts + 1),
        description: format!("a surrogate (Gaussian process) of {}", surrogate.truth.description),
        identity: serde_json::json!({"surrogate": surrogate.identity()}),
        steps,
        // The slopes of a process are as simple as the process.
        derivatives: Derivatives::Served,
        errors,
        evaluator: Some(answers),
    });
    model.surrogate = Some(Arc::new(surrogate));
    Some(expressions)
}

/// Adds the parameters that are the outputs' errors: of each output one an anchor, then the rest.
fn errors(model: &mut ResolvedModel, outputs: &[(String, String)], anchors: usize) -> Range<usize> {
    let first = model.model.parameters.len();
    let standard = Distribution::Normal { mean: 0.0, sd: 1.0, lower: None, upper: None };
    let parts = |(name, _): &(String, String)| {
        let of_anchor = |number: usize| {
            (format!("{name}.{ERROR}_{number}"), format!("error of the surrogate of `{name}` at its anchor {number}"))
        };
        let rest =
            (format!("{name}.{ERROR}"), format!("error of the surrogate of `{name}` beside that of its anchors"));
        (1..=anchors).map(of_anchor).chain(std::iter::once(rest)).collect::<Vec<_>>()
    };
    for (name, what) in outputs.iter().flat_map(parts) {
        let number = u32::try_from(model.model.parameters.len()).unwrap_or(u32::MAX);
        model.names.dimensions.insert(Symbol::Parameter(number), Dimension::NONE);
        model.model.parameters.push(Parameter {
            name,
            unit: "1".to_owned(),
            nominal: 0.0,
            description: format!("{what}, in its standard deviations"),
            source: "runs of the model that were left out".to_owned(),
        });
        model.priors.push(Prior::Distribution(standard));
        model.parameter_scales.push(Scale { unit: Unit::parse("1").ok() });
    }
    first..model.model.parameters.len()
}
