//! Results against their baselines: with the same seed bit for bit, with another seed within Monte Carlo error.
//!
//! With another seed every key number that has an error in both is a comparison. All comparisons of all jobs together are one
//! family: the probability of any alarm where nothing changed is at most [`LEVEL`].

use std::path::PathBuf;

use serde::Serialize;

use super::{BatchError, Executed, Loaded, LoadedPass};
use crate::job::key_number::KeyNumber;
use crate::job::kind;
use crate::runner::baseline::{self, Baseline};
use crate::runner::{ENGINE_VERSION, Finished};
use crate::statistics::monte_carlo::{Comparison, holm};

/// Probability of an alarm where nothing changed, of all comparisons of a check together.
pub const LEVEL: f64 = 0.01;
/// Probability with which a change of the detectable size is found.
pub const POWER: f64 = 0.9;
/// The statistic whose detectable change is stated for people; that of all stands in the document.
const OF_INTEREST: &str = "mean";

/// What a check found.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Regression {
    /// The other seed, where one was used.
    pub other_seed: Option<u64>,
    /// Family-wise level of the comparisons with another seed.
    pub level: f64,
    /// Power behind the detectable changes.
    pub power: f64,
    /// Comparisons of numbers with another seed.
    pub comparisons: usize,
    /// Jobs, in the order of the passes.
    pub jobs: Vec<JobCheck>,
    /// Jobs that were not run, in words; nothing is said of them.
    pub skipped: Vec<String>,
    /// Files among the baselines that are of no job.
    pub orphans: Vec<PathBuf>,
}

/// What a check found of a job.
#[derive(Clone, Debug, Serialize)]
pub struct JobCheck {
    /// Id of the job, pass included.
    pub job: String,
    /// Kind.
    pub kind: String,
    /// File of its baseline.
    pub baseline: PathBuf,
    /// Verdict.
    pub verdict: Verdict,
    /// Why the baseline was last renewed, and by which version of the program.
    pub renewed: Option<String>,
    /// What decided the result and is another than it was for the baseline.
    pub changed: Vec<String>,
    /// Numbers: those that moved (same seed), or all (other seed).
    pub numbers: Vec<NumberCheck>,
}

/// The verdict on a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// There is no baseline.
    Missing,
    /// The same seed gave the same bits.
    Same,
    /// The same seed gave other bits.
    Drifted,
    /// Another seed gave the same numbers within their errors.
    Agrees,
    /// Another seed gave at least one other number.
    Differs,
    /// Another seed was used, and the result has no number with a Monte Carlo error.
    NotComparable,
}

impl Verdict {
    /// Whether the check failed.
    pub fn is_alarm(self) -> bool {
        matches!(self, Self::Missing | Self::Drifted | Self::Differs)
    }
}

/// A number beside its baseline.
#[derive(Clone, Debug, Serialize)]
pub struct NumberCheck {
    /// What it is of.
    pub of: String,
    /// Which number of it.
    pub statistic: String,
    /// Unit.
    pub unit: String,
    /// Value in the baseline; `null` where it has none.
    pub before: Option<f64>,
    /// Value now; `null` where there is none any more.
    pub after: Option<f64>,
    /// Standard error of the difference of two independent runs.
    pub standard_error: Option<f64>,
    /// Difference by its standard error.
    pub standard_errors: Option<f64>,
    /// Probability of a difference of at least this size by another seed alone; `null` with the same seed.
    pub p: Option<f64>,
    /// Whether that is too small at the family-wise level.
    pub differs: bool,
    /// The smallest change that a check of this family finds with the stated power, in the unit.
    pub detectable: Option<f64>,
    /// The same by the value in the baseline, per cent; `null` for a value of 0.
    pub detectable_percent: Option<f64>,
    #[serde(skip)]
    comparison: Option<Comparison>,
}

impl NumberCheck {
    /// The number in the baseline beside the one now.
    fn new(before: Option<&KeyNumber>, after: Option<&KeyNumber>) -> Option<Self> {
        let known = before.or(after)?;
        let comparison = before.zip(after).and_then(|(before, after)| {
            Some(Comparison::of((before.value, before.error?), (after.value, after.error?)))
        });
        let scale = comparison.map(|comparison| comparison.error.standard_error).filter(|error| *error > 0.0);
        Some(Self {
            of: known.of.clone(),
            statistic: known.statistic.clone(),
            unit: known.unit.clone(),
            before: before.map(|number| number.value),
            after: after.map(|number| number.value),
            standard_error: comparison.map(|comparison| comparison.error.standard_error),
            standard_errors: comparison.zip(scale).map(|(comparison, scale)| comparison.difference / scale),
            p: None,
            differs: false,
            detectable: None,
            detectable_percent: None,
            comparison,
        })
    }

    /// Difference to the baseline.
    pub fn difference(&self) -> Option<f64> {
        Some(self.after? - self.before?)
    }

    /// Whether its detectable change is stated for people.
    pub fn is_of_interest(&self) -> bool {
        self.statistic == OF_INTEREST
    }
}

impl Regression {
    /// Whether nothing at all was held against a baseline.
    pub fn is_empty(&self) -> bool {
        self.jobs.iter().all(|job| matches!(job.verdict, Verdict::Missing | Verdict::NotComparable))
    }

    /// Whether the check failed.
    pub fn is_alarm(&self) -> bool {
        self.jobs.iter().any(|job| job.verdict.is_alarm()) || !self.orphans.is_empty()
    }

    /// How many jobs have a verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.jobs.iter().filter(|job| job.verdict == verdict).count()
    }
}

/// What a job of a run is now, as it would be written down.
fn present(
    executed: &Executed,
    position: usize,
    finished: &Finished,
    because: &str,
    date: Option<&str>,
) -> Result<Baseline, BatchError> {
    let node = &executed.plan.nodes()[position];
    let (name, result) = (node.task.kind(), &finished.stored);
    let unreadable = |reason: String| BatchError::job(format!("the result of job `{}`: {reason}", node.id));
    let kind = kind::find(name).ok_or_else(|| unreadable(format!("there is no kind `{name}`")))?;
    let output = kind.output(&result.value, &result.arrays).map_err(|error| unreadable(error.to_string()))?;
    let versions = (name, node.task.algorithm_version(), ENGINE_VERSION);
    let numbers = output.key_numbers().into_iter().filter(|number| number.value.is_finite()).collect();
    Ok(Baseline::new(because, date, versions, (node.seed, &finished.key), &result.sha256, numbers))
}

/// Holds the results of a run against their baselines; `other_seed` is the seed of the run where it is not that of the
/// passes.
///
/// # Errors
/// A baseline that is damaged, or of the same seed as the other one.
pub fn check(executed: &Executed, other_seed: Option<u64>) -> Result<Regression, BatchError> {
    let mut regression = Regression { other_seed, level: LEVEL, power: POWER, ..Regression::default() };
    for pass in &executed.passes {
        regression.skipped.extend(pass.not_run.iter().map(|reason| format!("{}: {reason}", pass.shown)));
        regression.orphans.extend(orphans(pass)?);
        for (position, finished) in executed.results(pass) {
            let now = present(executed, position, finished, "", None)?;
            let node = &executed.plan.nodes()[position];
            let path = pass.study.join(baseline::path(&pass.file, &node.name));
            let mut job = JobCheck {
                job: node.id.clone(),
                kind: now.kind.clone(),
                verdict: Verdict::Missing,
                renewed: None,
                changed: Vec::new(),
                numbers: Vec::new(),
                baseline: path,
            };
            if let Some(before) = Baseline::read(&job.baseline)? {
                job.renewed = Some(format!("{} (bmv {})", before.because, before.program));
                if other_seed.is_some_and(|seed| seed == before.seed) {
                    let seed = before.seed;
                    return Err(BatchError::input(format!("`{}` was made with the seed {seed} too", node.id)));
                }
                let (verdict, numbers) = match other_seed {
                    None => same_seed(&before, &now),
                    Some(_) => (Verdict::NotComparable, paired(&before, &now)),
                };
                job.verdict = verdict;
                job.numbers = numbers;
                job.changed = changed(&before, &now, other_seed.is_some());
            }
            regression.jobs.push(job);
        }
    }
    if other_seed.is_some() {
        judge(&mut regression);
    }
    Ok(regression)
}

/// Whether any of the passes has a baseline, or what lies in the place of one.
///
/// # Errors
/// [`BatchError`] if the system refuses.
pub fn has_baselines(loaded: &Loaded) -> Result<bool, BatchError> {
    for pass in &loaded.passes {
        if !baseline::files(&pass.study, &pass.file)?.is_empty() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Files among the baselines of a pass that are of none of its jobs.
fn orphans(pass: &LoadedPass) -> Result<Vec<PathBuf>, BatchError> {
    let known: Vec<PathBuf> =
        pass.pass.jobs.iter().map(|job| pass.study.join(baseline::path(&pass.file, &job.name))).collect();
    let mut files = baseline::files(&pass.study, &pass.file)?;
    files.retain(|file| !known.contains(file));
    Ok(files)
}

/// What decided two results and differs, beside the seed where it is meant to.
fn changed(before: &Baseline, now: &Baseline, with_other_seed: bool) -> Vec<String> {
    let mut changed = Vec::new();
    if before.kind != now.kind {
        changed.push(format!("the kind, {} -> {}", before.kind, now.kind));
    } else if before.algorithm_version != now.algorithm_version {
        changed.push(format!("the algorithm's version, {} -> {}", before.algorithm_version, now.algorithm_version));
    }
    if before.engine_version != now.engine_version {
        changed.push(format!("the engine's version, {} -> {}", before.engine_version, now.engine_version));
    }
    if !with_other_seed && before.seed != now.seed {
        changed.push(format!("the seed, {} -> {}", before.seed, now.seed));
    }
    // The key holds the seed.
    if !with_other_seed && changed.is_empty() && before.key != now.key {
        changed.push("the definition, the model, the data, or a job behind it".to_owned());
    }
    changed
}

/// Verdict on a result with the same seed, and the numbers that are not the same to the last bit.
fn same_seed(before: &Baseline, now: &Baseline) -> (Verdict, Vec<NumberCheck>) {
    if before.sha256 == now.sha256 {
        // What is derived from the same result is another only where the program derives it otherwise.
        return (Verdict::Same, Vec::new());
    }
    let mut numbers = paired(before, now);
    numbers.retain(|number| number.before.map(f64::to_bits) != number.after.map(f64::to_bits));
    (Verdict::Drifted, numbers)
}

/// The numbers of both, those of the baseline first.
fn paired(before: &Baseline, now: &Baseline) -> Vec<NumberCheck> {
    let find = |numbers: &'_ [KeyNumber], wanted: &KeyNumber| -> Option<usize> {
        numbers.iter().position(|number| (&number.of, &number.statistic) == (&wanted.of, &wanted.statistic))
    };
    let of_both = before.numbers.iter().filter_map(|number| {
        NumberCheck::new(Some(number), find(&now.numbers, number).map(|index| &now.numbers[index]))
    });
    let new = now.numbers.iter().filter(|number| find(&before.numbers, number).is_none());
    of_both.chain(new.filter_map(|number| NumberCheck::new(None, Some(number)))).collect()
}

/// Tests all comparisons of a check as one family.
fn judge(regression: &mut Regression) {
    let p: Vec<f64> = (regression.jobs.iter())
        .flat_map(|job| job.numbers.iter().filter_map(|number| number.comparison))
        .map(|comparison| comparison.p)
        .collect();
    let mut rejected = holm(&p, LEVEL).into_iter();
    regression.comparisons = p.len();
    let share = LEVEL / p.len().max(1) as f64;
    for job in &mut regression.jobs {
        for number in &mut job.numbers {
            let Some(comparison) = number.comparison else { continue };
            number.p = Some(comparison.p);
            number.differs = rejected.next().unwrap_or(false);
            let detectable = comparison.error.detectable(share, POWER);
            number.detectable = Some(detectable);
            let value = number.before.map_or(0.0, f64::abs);
            number.detectable_percent = (value > 0.0).then(|| 100.0 * detectable / value);
        }
        if job.verdict == Verdict::NotComparable && job.numbers.iter().any(|number| number.comparison.is_some()) {
            let differs = job.numbers.iter().any(|number| number.differs);
            job.verdict = if differs { Verdict::Differs } else { Verdict::Agrees };
        }
    }
}

/// A baseline that was to be renewed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Renewed {
    /// Id of the job.
    pub job: String,
    /// Its file.
    pub baseline: PathBuf,
    /// Whether it was written: one of the same result stays, with its reason.
    pub is_written: bool,
}

/// Renews the baselines of all results of a run that are not those of their baselines, and writes down why.
///
/// # Errors
/// A result that cannot be read; a refusal of the system.
pub fn renew(executed: &Executed, because: &str, date: Option<&str>) -> Result<Vec<Renewed>, BatchError> {
    let mut renewed = Vec::new();
    for pass in &executed.passes {
        for (position, finished) in executed.results(pass) {
            let now = present(executed, position, finished, because, date)?;
            let node = &executed.plan.nodes()[position];
            let inside = baseline::path(&pass.file, &node.name);
            let path = pass.study.join(&inside);
            // What is damaged, or of another version's form, is what a renewal is for.
            let before = Baseline::read(&path).ok().flatten();
            let is_written = !before.is_some_and(|before| before.is_of_same(&now));
            if is_written {
                now.write(&pass.study, &inside)?;
            }
            renewed.push(Renewed { job: node.id.clone(), baseline: path, is_written });
        }
    }
    Ok(renewed)
}
