//! What the diagnosis does on cases whose truth is known, over drawn networks: false alarms where nothing is missing, and
//! how often what is missing is found. Prints the figures, and ends with status 1 where they miss what is asked for.
//!
//! `laboratory NULLS CASES FINER DATED SEED`: cases with nothing missing, with one or two effects or physics that the
//! catalogue lacks, with a truth that is finer than the believed model everywhere, and with what changes at a date.

use std::process::ExitCode;
use std::sync::Arc;

use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::measurement::Rows;
use bmv::twin::{
    FinerScore, InjectionRequest, Rate, Recipe, Score, TestKind, Trial, case, dated, drawn_case, finer, score, standard,
};
use rayon::prelude::*;

/// Largest upper end of the 95 % interval of false alarms.
const FALSE_ALARMS: f64 = 0.015;
/// Size of what is hidden, and the least share of separable cases that are to be found.
const FOUND: [(f64, f64); 3] = [(0.5, 0.60), (1.0, 0.90), (2.0, 0.97)];
/// The same of what changes at a date, and rows within which its date is to be found.
const FOUND_DATED: [(f64, f64); 3] = [(0.5, 0.85), (1.0, 1.0), (2.0, 1.0)];
const ROWS: f64 = 3.0;
/// The parameter that says when.
const DATE: &str = "date";
/// Least share of answers given 0.9 that are right, and of intervals of 95 % that hold the truth.
const RIGHT: f64 = 0.9;

/// Least share of finer truths that are right in the first step, and the largest of those that are wrong and sure.
const FIRST: f64 = 0.9;
const WRONG: f64 = 0.02;

fn trials(
    catalogue: &Arc<Catalogue>,
    cases: u64,
    seed: u64,
    recipe: impl Fn(u64) -> Recipe + Sync,
) -> Vec<(u64, Trial)> {
    let outcomes = (0..cases).into_par_iter().map(|number| drawn_case(catalogue, &recipe(number), seed, number));
    outcomes.filter_map(|own| Some((own.number, Trial { truth: own.truth?, answer: own.answer? }))).collect()
}

/// Nothing is missing; in every second case a transient with correlated noise that is not stated.
fn nothing(number: u64) -> Recipe {
    let correlated = number % 2 == 1;
    let request =
        InjectionRequest { effects: 0, size: None, correlated: Some(correlated), ..InjectionRequest::default() };
    Recipe { topology: None, test: correlated.then_some(TestKind::Steps), request, rivals: false, stated_noise: None }
}

fn only(trials: Vec<(u64, Trial)>) -> Vec<Trial> {
    trials.into_iter().map(|(_, trial)| trial).collect()
}

/// Writes to the other stream what a reader looks into: `bmv lab --finer --write` makes the case's files.
fn look_at(number: u64, trial: &Trial) {
    let is_missed = !trial.truth.effects.is_empty() && !trial.is_first();
    if is_missed || trial.is_surely_wrong() {
        let what = if trial.is_surely_wrong() { "wrong and sure" } else { "not first" };
        let (truth, answer) = (&trial.truth, &trial.answer);
        let sure: Vec<String> =
            answer.probabilities.iter().filter(|own| own.1 > 0.3).map(|(id, p)| format!("{id} {p:.2}")).collect();
        let rivals: usize = truth.rivals.iter().flatten().count();
        eprintln!(
            "case {number}, {what}: hidden {} ({rivals} rivals); {:?}, selected {}, first {}, likely {}",
            truth.ids().join(" + "),
            answer.verdict,
            answer.selected.join(" + "),
            answer.first_step.join(" or "),
            sure.join(", "),
        );
    }
}

/// Writes to the other stream what changes at a date and is missed though data can tell it.
fn look_at_dated(number: u64, trial: &Trial) {
    if trial.truth.is_separable() != Some(true) || trial.grouped() {
        return;
    }
    let (truth, answer) = (&trial.truth, &trial.answer);
    let nearest = truth.rivals.iter().flatten().next();
    let of_truth = truth.ids().iter().filter_map(|id| answer.probabilities.iter().find(|own| own.0 == *id)).next();
    eprintln!(
        "case {number}, missed: hidden {} of size {:?}; nearest rival {:?}; {:?}, selected {} (group {:?}), truth {of_truth:?}",
        truth.ids().join(" + "),
        truth.size,
        nearest.map(|rival| (rival.effects.join(" + "), rival.delta2)),
        answer.verdict,
        answer.selected.join(" + "),
        answer.groups,
    );
}

/// Rows between the date of a change that was selected and the true one. `None` where it was not selected.
fn rows_off(catalogue: &Arc<Catalogue>, seed: u64, number: u64, trial: &Trial) -> Option<f64> {
    let hidden = trial.truth.effects.first().filter(|hidden| trial.answer.selected.contains(&hidden.id))?;
    let truth = hidden.parameters.iter().find(|one| one.name == DATE)?.value;
    let stated = trial.answer.amplitudes.iter().find(|one| one.id == hidden.id && one.parameter == DATE)?;
    let drawn = case(catalogue, &dated(number), seed, number).ok()?;
    let spacing = match &drawn.problem.measurements.first()?.rows {
        Rows::Steady(_) => 1.0,
        Rows::Transient { inputs, .. } => {
            let times = &inputs.times_s;
            (times.last()? - times.first()?) / (times.len() - 1) as f64
        }
    };
    Some((0.5 * (stated.lower + stated.upper) - truth).abs() / spacing)
}

/// Prints, by size, how often what is hidden is grouped where data can tell it. Returns the shares.
fn by_size(score: &Score) -> Vec<(f64, Option<f64>)> {
    let mut shares = Vec::new();
    for own in &score.sizes {
        let what = format!("{} hidden, size {}", own.effects, own.size);
        line(&format!("{what}: grouped"), &own.all.grouped);
        line(&format!("{what}: grouped, separable"), &own.separable.grouped);
        if own.effects == 1 {
            shares.push((own.size, own.separable.grouped.share()));
        }
    }
    shares
}

fn is_found(shares: &[(f64, Option<f64>)], least: &[(f64, f64)]) -> bool {
    let of = |size: f64| least.iter().find(|own| own.0 == size).map(|own| own.1);
    shares.iter().all(|&(size, share)| of(size).zip(share).is_none_or(|(least, share)| share >= least))
}

fn line(what: &str, rate: &Rate) {
    let share = |value: f64| format!("{:.1}", 100.0 * value);
    println!("| {what} | {} | {} | {} to {} % |", rate.hits, rate.of, share(rate.lower), share(rate.upper));
}

fn main() -> ExitCode {
    let numbers: Option<Vec<u64>> = std::env::args().skip(1).map(|text| text.parse().ok()).collect();
    let Some([nulls, cases, finer_cases, dated_cases, seed]) = numbers.as_deref() else {
        eprintln!("usage: laboratory NULLS CASES FINER DATED SEED, as in: laboratory 2000 1000 400 200 1");
        return ExitCode::from(2);
    };
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let mut is_met = true;
    println!("| seed {seed} | cases | of | 95 % interval |\n|---|---|---|---|");
    if *nulls > 0 {
        let score = score(&only(trials(&catalogue, *nulls, *seed, nothing)));
        line("nothing missing: not `adequate`", &score.false_alarms);
        line("- noise as stated", &score.false_alarms_stated_noise);
        line("- correlated noise, not stated", &score.false_alarms_correlated);
        is_met &= score.false_alarms.upper <= FALSE_ALARMS;
    }
    if *cases > 0 {
        let score = score(&only(trials(&catalogue, *cases, *seed, standard)));
        is_met &= is_found(&by_size(&score), &FOUND);
        line("outside the catalogue: `unexplained`", &score.outside_unexplained);
        line("answers given 0.9 or more: right", &score.sure_and_right);
        line("intervals of 95 %: hold the truth", &score.coverage);
        let is_right = |rate: &Rate| rate.share().is_none_or(|share| share >= RIGHT);
        is_met &= is_right(&score.sure_and_right) && is_right(&score.coverage) && score.coverage.lower <= 0.95;
    }
    if *finer_cases > 0 {
        let trials = trials(&catalogue, *finer_cases, *seed, finer);
        eprintln!("{} of {finer_cases} cases could be drawn", trials.len());
        trials.iter().for_each(|(number, trial)| look_at(*number, trial));
        let score = FinerScore::of(&only(trials));
        line("a model wrong everywhere: right in the first step", &score.first);
        line("- something is said to be missing", &score.found);
        line("- nothing large hidden: no effect sure", &score.silent);
        line("- wrong and sure", &score.wrong);
        is_met &= score.first.share().is_none_or(|share| share >= FIRST);
        is_met &= score.wrong.share().is_none_or(|share| share <= WRONG);
    }
    if *dated_cases > 0 {
        println!("| what changes at a date | | | |");
        let trials = trials(&catalogue, *dated_cases, *seed, dated);
        trials.iter().for_each(|(number, trial)| look_at_dated(*number, trial));
        let rows: Vec<f64> =
            trials.iter().filter_map(|(number, trial)| rows_off(&catalogue, *seed, *number, trial)).collect();
        is_met &= is_found(&by_size(&score(&only(trials))), &FOUND_DATED);
        let near = Rate::of(rows.iter().map(|rows| *rows <= ROWS));
        line("selected: date within three rows", &near);
        is_met &= near.share().is_none_or(|share| share >= RIGHT);
    }
    if is_met { ExitCode::SUCCESS } else { ExitCode::from(1) }
}
