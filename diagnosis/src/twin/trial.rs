//! Trials: a truth is drawn, its test simulated, the diagnosis asked.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::answer::Answer;
use super::campaign::TestKind;
use super::case::{Recipe, case, read};
use super::draw::Draw;
use super::inject::{InjectError, InjectionRequest, inject};
use super::rivals::rivals;
use super::truth::Truth;
use crate::diagnosis::{Diagnosis, FitError, Problem, Settings};
use crate::effect::Catalogue;
use crate::random::StreamKey;

/// Asks the diagnosis, with its default settings; `seed` is that of its random numbers.
///
/// # Errors
/// As [`Diagnosis::run`].
pub fn ask(problem: &Problem, seed: u64) -> Result<Answer, FitError> {
    let key = StreamKey::new(seed, "laboratory", "diagnose");
    Ok(Answer::from(&Diagnosis::new(problem.clone(), Settings::default(), key).run()?))
}

/// What is hidden in case `number` of a laboratory over one's own model: nothing in every fifth, else one effect, of 0.5,
/// 1 or 2 standard deviations in turn where no amplitude is given.
pub fn own_request(number: u64, effect: Option<&str>, amplitude: Option<f64>) -> InjectionRequest {
    const SIZES: [f64; 3] = [0.5, 1.0, 2.0];
    let (round, place) = (number / 5, number % 5);
    if place == 4 {
        return InjectionRequest {
            effects: 0,
            size: None,
            correlated: Some(round % 2 == 1),
            ..InjectionRequest::default()
        };
    }
    let size = SIZES[((4 * round + place) % 3) as usize];
    InjectionRequest {
        only: effect.map(str::to_owned),
        amplitude,
        size: amplitude.is_none().then_some(size),
        ..InjectionRequest::default()
    }
}

/// The recipe of case `number` of the laboratory over drawn networks. Of twenty cases four hide nothing (half with
/// correlated noise, all in transients), twelve one effect of 0.5, 1 or 2 standard deviations, two two effects of 2, two
/// physics that the catalogue lacks, of 1 and 2.
pub fn standard(number: u64) -> Recipe {
    let place = number % 20;
    let round = number / 20;
    let one = |size: f64| InjectionRequest { size: Some(size), ..InjectionRequest::default() };
    let null = |correlated: bool| InjectionRequest {
        effects: 0,
        size: None,
        correlated: Some(correlated),
        ..InjectionRequest::default()
    };
    let (request, test) = match place {
        0 | 1 => (null(false), None),
        2 | 3 => (null(true), Some(TestKind::Steps)),
        4..=15 => (one([0.5, 1.0, 2.0][(place % 3) as usize]), None),
        16 | 17 => (InjectionRequest { effects: 2, ..one(2.0) }, None),
        _ => {
            (InjectionRequest { outside: true, ..one(if (round + place).is_multiple_of(2) { 1.0 } else { 2.0 }) }, None)
        }
    };
    Recipe { topology: None, test, request, rivals: true, stated_noise: None }
}

/// The recipe of case `number` of the laboratory over truths that are finer than the believed model, which is then wrong by
/// one to three standard deviations everywhere: nothing else hidden in every tenth case; else one effect, all of it three to
/// six times as large. The stated noise is right, half or twice as large, in turn. Every eighth case is a transient.
pub fn finer(number: u64) -> Recipe {
    let error = [1.0, 2.0, 3.0][(number % 3) as usize];
    let times = [3.0, 4.0, 6.0][(number / 3 % 3) as usize];
    let is_null = number % 10 == 9;
    let request = InjectionRequest {
        effects: usize::from(!is_null),
        size: (!is_null).then_some(times * error),
        finer: Some(error),
        correlated: Some(false),
        ..InjectionRequest::default()
    };
    let stated_noise = Some([1.0, 0.5, 2.0][(number / 9 % 3) as usize]);
    // Transients take a hundred times as long.
    let test = Some(if number % 8 == 7 { TestKind::Steps } else { TestKind::Steady });
    Recipe { topology: None, test, request, rivals: true, stated_noise }
}

/// The recipe of case `number` of the laboratory over changes at a date: heat, a conductance and a sensor in turn, by 0.5, 1 and
/// 2 standard deviations. Every fourth case is a transient.
pub fn dated(number: u64) -> Recipe {
    let effect = ["dated-load", "dated-conductance", "dated-bias"][(number % 3) as usize];
    let request = InjectionRequest {
        only: Some(effect.to_owned()),
        size: Some([0.5, 1.0, 2.0][(number / 3 % 3) as usize]),
        correlated: Some(false),
        ..InjectionRequest::default()
    };
    let test = Some(if number % 4 == 3 { TestKind::Steps } else { TestKind::Steady });
    Recipe { topology: None, test, request, rivals: true, stated_noise: None }
}

/// A problem with readings of its own simulated from a truth that is drawn; `template` has the test's phases, inputs and
/// sensors. The same for the same seed and number.
///
/// # Errors
/// [`InjectError`] where nothing that is asked for can be hidden.
pub fn simulate(
    template: &Problem,
    request: &InjectionRequest,
    seed: u64,
    number: u64,
) -> Result<(Problem, Truth), InjectError> {
    let mut problem = template.clone();
    let mut hidden = inject(template, request, &mut Draw::new(seed, "truth", number))?;
    hidden.truth.rivals = Some(rivals(template, &hidden)?);
    let key = StreamKey::new(seed, "laboratory", "noise");
    read(&mut problem, &hidden.clean, &hidden.truth, &key, number);
    Ok((problem, hidden.truth))
}

/// What became of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Number of the case.
    pub number: u64,
    /// What was hidden; `None` where nothing could be, with the reason.
    pub truth: Option<Truth>,
    /// What was said of it.
    pub answer: Option<Answer>,
    /// Why there is no truth or no answer.
    pub reason: Option<String>,
}

/// Runs case `number` of the laboratory over drawn networks.
pub fn drawn_case(catalogue: &Arc<Catalogue>, recipe: &Recipe, seed: u64, number: u64) -> Outcome {
    match case(catalogue, recipe, seed, number) {
        Err(error) => Outcome { number, truth: None, answer: None, reason: Some(error.to_string()) },
        // Of a truth that is finer than the model, its parameters may be wrong as well: as in a study, their priors are in question.
        Ok(case) if case.truth.finer.is_some() => {
            asked(&case.problem.with_priors_in_question(usize::MAX), case.truth, seed, number)
        }
        Ok(case) => asked(&case.problem, case.truth, seed, number),
    }
}

/// Asks the diagnosis of a problem whose truth is known.
fn asked(problem: &Problem, truth: Truth, seed: u64, number: u64) -> Outcome {
    let (answer, reason) = match ask(problem, seed) {
        Ok(answer) => (Some(answer), None),
        Err(error) => (None, Some(format!("the diagnosis failed: {error}"))),
    };
    Outcome { number, truth: Some(truth), answer, reason }
}

/// Runs case `number` over one's own model.
pub fn own_case(template: &Problem, request: &InjectionRequest, seed: u64, number: u64) -> Outcome {
    match simulate(template, request, seed, number) {
        Err(error) => Outcome { number, truth: None, answer: None, reason: Some(error.to_string()) },
        Ok((problem, truth)) => asked(&problem, truth, seed, number),
    }
}
