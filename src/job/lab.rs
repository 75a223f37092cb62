//! The laboratory: effects are hidden in one's own model or in drawn networks, the test is simulated, the diagnosis is
//! asked. A block is a case.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{Done, Job, JobError, Parts, Step};
use crate::diagnosis::{FitError, Problem};
use crate::document::suggest;
use crate::effect::Catalogue;
use crate::math::sort::sort_by;
use crate::twin::{Outcome, Rate, Score, Trial, Truth, drawn_case, own_case, own_request, score, standard};
use crate::watch;

/// What the laboratory is to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spec {
    /// Name of an effect or id of a candidate to hide; drawn without.
    pub effect: Option<String>,
    /// Its amplitude, SI; 0.5, 1 and 2 standard deviations are left by the refit without.
    pub amplitude: Option<f64>,
    /// Number of cases.
    pub cases: u64,
    /// Seed.
    pub seed: u64,
}

/// A row of the table: an effect at a size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The effect, several joined by ` + `, `outside the catalogue`, or `nothing`.
    pub effect: String,
    /// The size asked for, standard deviations; `None` where the amplitude was given or has no size.
    pub size: Option<f64>,
    /// Mean of the sizes that there were.
    pub mean_size: f64,
    /// Cases that no other effect explains.
    pub separable: Rate,
    /// Cases in which something was found to be missing; `None` without a diagnosis.
    pub found: Option<Rate>,
    /// Cases in which exactly the truth was selected.
    pub named: Option<Rate>,
    /// Cases in which the truth was selected or in a small group with what was.
    pub grouped: Option<Rate>,
}

/// What the laboratory found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Output {
    /// What was asked.
    pub spec: Spec,
    /// By effect and size.
    pub rows: Vec<Row>,
    /// The score of all answers; `None` without a diagnosis.
    pub score: Option<Score>,
    /// Why cases have no truth or no answer, and how many.
    pub reasons: BTreeMap<String, u64>,
    /// Every case.
    pub cases: Vec<Outcome>,
}

/// Where effects are hidden.
#[derive(Debug)]
enum Ground {
    /// In one's own model and test.
    Own(Arc<Problem>),
    /// In networks and tests that are drawn.
    Drawn(Arc<Catalogue>),
}

/// A laboratory, ready to run.
#[derive(Debug)]
pub struct Lab {
    spec: Spec,
    ground: Ground,
}

impl Lab {
    /// Prepares the laboratory over a problem, whose readings say only where there are any.
    ///
    /// # Errors
    /// An effect that has no place in the problem.
    pub fn new(spec: Spec, problem: Arc<Problem>) -> Result<Self, JobError> {
        if let Some(effect) = &spec.effect {
            let is_candidate =
                problem.candidates.iter().any(|candidate| candidate.id == *effect || candidate.effect == *effect);
            if !is_candidate {
                let ids =
                    problem.candidates.iter().flat_map(|candidate| [candidate.id.as_str(), candidate.effect.as_str()]);
                let near =
                    suggest::nearest(effect, ids).map_or(String::new(), |near| format!("; the nearest is `{near}`"));
                return Err(JobError::Failed(format!("`{effect}` is no effect with a place in this model{near}")));
            }
        }
        // What stops every case is stated before the first.
        let failed = |error: FitError| JobError::Failed(error.to_string());
        problem.hypothesis(&[], 1.0).and_then(|baseline| baseline.likelihood(&problem)).map_err(failed)?;
        let hidden = spec.effect.as_ref().zip(spec.amplitude);
        if let Some((effect, amplitude)) = hidden {
            let name = effect.split(':').next().unwrap_or(effect);
            let form = problem.catalogue.get(name).map(|effect| &effect.form.parameters);
            let first = form.and_then(|form| form.iter().find(|entry| !entry.value.shape));
            if let Some(entry) = first.filter(|entry| !entry.value.sign.allows(amplitude)) {
                let (parameter_name, word) = (&entry.name, entry.value.sign.word());
                return Err(JobError::Failed(format!("`{parameter_name}` of `{name}` is {word}; {amplitude} is not")));
            }
        }
        Ok(Self { spec, ground: Ground::Own(problem) })
    }

    /// The standard laboratory over drawn networks; `spec` has neither effect nor amplitude.
    pub fn drawn(spec: Spec, catalogue: Arc<Catalogue>) -> Self {
        Self { spec, ground: Ground::Drawn(catalogue) }
    }
}

const STAGE: &str = "cases";

impl Job for Lab {
    type State = ();
    type Input = u64;
    type Partial = Outcome;
    type Output = Output;

    fn kind(&self) -> &'static str {
        "lab"
    }

    fn algorithm_version(&self) -> u32 {
        10
    }

    fn identity(&self) -> Value {
        let effects = |catalogue: &Catalogue| -> Vec<Value> {
            catalogue.effects().iter().map(|effect| json!({"name": effect.name, "file": effect.json})).collect()
        };
        match &self.ground {
            Ground::Drawn(catalogue) => json!({"spec": self.spec, "effects": effects(catalogue)}),
            Ground::Own(problem) => json!({
                "spec": self.spec,
                "model": problem.model.identity(),
                "priors": problem.priors,
                "parameters": problem.parameters,
                "input_errors": problem.input_errors,
                "measurements": problem.measurements.iter().map(|data| data.identity()).collect::<Vec<_>>(),
                "candidates": problem.candidates.iter().map(|candidate| candidate.id.as_str()).collect::<Vec<_>>(),
                "effects": effects(&problem.catalogue),
            }),
        }
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        Ok(Step::Blocks { stage: STAGE.to_owned(), state: (), inputs: (0..self.spec.cases).collect() })
    }

    fn block(&self, (): &(), number: u64, _parts: &dyn Parts) -> Result<Outcome, JobError> {
        let seed = self.spec.seed;
        // How far a fit of a case has come says nothing of the case.
        Ok(watch::with_share(&watch::Share::default(), || match &self.ground {
            Ground::Drawn(catalogue) => drawn_case(catalogue, &standard(number), seed, number),
            Ground::Own(problem) => {
                let request = own_request(number, self.spec.effect.as_deref(), self.spec.amplitude);
                own_case(problem, &request, seed, number)
            }
        }))
    }

    fn is_last(&self, (): &()) -> bool {
        true
    }

    fn reduce(&self, (): (), blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let cases: Vec<Outcome> = blocks.into_iter().map(|(_, case)| case).collect();
        let mut reasons = BTreeMap::new();
        for reason in cases.iter().filter_map(|case| case.reason.clone()) {
            *reasons.entry(reason).or_insert(0) += 1;
        }
        let trials = trials(cases.iter());
        let score = (!trials.is_empty()).then(|| score(&trials));
        let output = Output { spec: self.spec.clone(), rows: rows(&cases), score, reasons, cases };
        Ok(Step::Done(Box::new(output)))
    }
}

fn trials<'a>(cases: impl Iterator<Item = &'a Outcome>) -> Vec<Trial> {
    let trial = |case: &Outcome| Some(Trial { truth: case.truth.clone()?, answer: case.answer.clone()? });
    cases.filter_map(trial).collect()
}

/// What a case is called in the table.
fn kind(truth: &Truth) -> String {
    if truth.outside.is_some() {
        return "outside the catalogue".to_owned();
    }
    let names: Vec<&str> = truth.effects.iter().map(|effect| effect.effect.as_str()).collect();
    if names.is_empty() { "nothing".to_owned() } else { names.join(" + ") }
}

/// The table: by name, sizes ascending.
fn rows(cases: &[Outcome]) -> Vec<Row> {
    let of = |case: &Outcome| case.truth.as_ref().map(|truth| (kind(truth), truth.asked));
    let mut kinds: Vec<(String, Option<f64>)> = cases.iter().filter_map(of).collect();
    sort_by(&mut kinds, |a, b| {
        let sizes = a.1.unwrap_or(f64::INFINITY).total_cmp(&b.1.unwrap_or(f64::INFINITY));
        a.0.cmp(&b.0).then(sizes)
    });
    kinds.dedup();
    let row = |kind: (String, Option<f64>)| {
        let kind_cases: Vec<&Outcome> = cases.iter().filter(|case| of(case).as_ref() == Some(&kind)).collect();
        let truths: Vec<&Truth> = kind_cases.iter().filter_map(|case| case.truth.as_ref()).collect();
        let trials = trials(kind_cases.iter().copied());
        let rate = |right: fn(&Trial) -> bool| (!trials.is_empty()).then(|| Rate::of(trials.iter().map(right)));
        Row {
            mean_size: truths.iter().map(|truth| truth.size).sum::<f64>() / truths.len().max(1) as f64,
            separable: Rate::of(truths.iter().map(|truth| truth.is_separable() == Some(true))),
            found: rate(Trial::found),
            named: rate(Trial::named),
            grouped: rate(Trial::grouped),
            effect: kind.0,
            size: kind.1,
        }
    };
    kinds.into_iter().map(row).collect()
}
