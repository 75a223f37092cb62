//! Margins from history as a job of no block: a few sums over the rows of a file.

use serde_json::{Value, json};

use super::output::{Comparison, Group, Held, Output, Spec};
use crate::document::counted;
use crate::job::{Done, Job, JobError, Parts, Step};
use crate::math::functions::sqrt;
use crate::math::special::student_t_quantile;
use crate::statistics::quantile::sorted;
use crate::statistics::tolerance::{fewest_for_order_statistic, howe_factor, order_statistic, symmetric_normal_margin};
use crate::statistics::{Interval, Moments};

/// Share of Student's t below which a mean difference is no bias: 1 % on both sides together.
const BIAS: f64 = 0.995;
/// Bins of a histogram.
const BINS: usize = 15;
/// Share of the differences of one program from which on it is said to dominate.
const DOMINATES: f64 = 0.5;

/// Margins from history, ready to run.
#[derive(Debug)]
pub struct MarginsFromHistory {
    spec: Spec,
}

impl MarginsFromHistory {
    /// Prepares the job.
    pub fn new(spec: Spec) -> Self {
        Self { spec }
    }

    fn group(&self, class: Option<&str>) -> Option<Group> {
        let settings = &self.spec;
        let rows: Vec<&Comparison> =
            settings.comparisons.iter().filter(|row| class.is_none_or(|class| row.class == class)).collect();
        let differences: Vec<f64> = rows.iter().map(|row| row.difference_k).collect();
        let in_order = sorted(&differences);
        let (first, last) = (*in_order.first()?, *in_order.last()?);
        let mut programs: Vec<&str> = rows.iter().map(|row| row.program.as_str()).collect();
        programs.sort_unstable();
        programs.dedup();
        let programs = settings.has_programs.then_some(programs.len());
        let moments = Moments::of(&differences);
        let (mean, sd) = (moments.mean(), (differences.len() > 1).then(|| moments.sd()));
        let bound = |count: usize| {
            let factor = howe_factor(count, settings.capture, settings.confidence)?;
            Some(mean.abs() + factor * sd?)
        };
        let magnitudes = sorted(&differences.iter().map(|difference| difference.abs()).collect::<Vec<_>>());
        let within = |margin: f64| magnitudes.partition_point(|magnitude| *magnitude <= margin) as u64;
        let count = differences.len();
        let margin = sd.map(|sd| symmetric_normal_margin(mean, sd, settings.capture));
        let held = |(rule, margin_k): &(String, f64)| {
            let inside = within(*margin_k);
            let Interval { lower, upper } = Interval::clopper_pearson(inside, count as u64, settings.confidence);
            Held { rule: rule.clone(), margin_k: *margin_k, inside, interval: [lower, upper] }
        };
        let largest = first.abs().max(last.abs());
        // About 0, so that hot and cold sides are seen.
        let width = if largest > 0.0 { 2.0 * largest / BINS as f64 } else { 1.0 };
        let edge = |bin: usize| (bin as f64 - 0.5 * BINS as f64) * width;
        let mut counts = vec![0; BINS];
        for difference in &differences {
            let bin = ((difference / width + 0.5 * BINS as f64) as usize).min(BINS - 1);
            counts[bin] += 1;
        }
        Some(Group {
            class: class.map(str::to_owned),
            comparisons: count as u64,
            programs: programs.map(|programs| programs as u64),
            mean_k: mean,
            sd_k: sd,
            range_k: [first, last],
            margin_k: margin,
            bound_k: bound(count),
            bound_by_program_k: programs.and_then(bound),
            distribution_free_k: order_statistic(count, settings.capture, settings.confidence)
                .and_then(|rank| magnitudes.get(rank - 1).copied()),
            within_margin: margin.map(|margin| within(margin) as f64 / count as f64),
            rules: settings.rules.iter().map(held).collect(),
            edges_k: (0..=BINS).map(edge).collect(),
            counts,
        })
    }

    /// Whether the mean difference of a group is not 0 by Student's t at 1 %: over the means of its programs where these are known, since
    /// differences of one are not independent.
    fn is_biased(&self, group: &Group) -> bool {
        let is_own = |row: &&Comparison| group.class.as_ref().is_none_or(|class| row.class == *class);
        let rows: Vec<&Comparison> = self.spec.comparisons.iter().filter(is_own).collect();
        let mut values: Vec<f64> = rows.iter().map(|row| row.difference_k).collect();
        if self.spec.has_programs {
            let mut programs: Vec<&str> = rows.iter().map(|row| row.program.as_str()).collect();
            programs.sort_unstable();
            programs.dedup();
            let mean = |program: &&str| {
                let own: Vec<f64> =
                    rows.iter().filter(|row| row.program == *program).map(|row| row.difference_k).collect();
                Moments::of(&own).mean()
            };
            values = programs.iter().map(mean).collect();
        }
        if values.len() < 3 {
            return false;
        }
        let moments = Moments::of(&values);
        let error = moments.sd() / sqrt(values.len() as f64);
        moments.mean().abs() > student_t_quantile(BIAS, values.len() as f64 - 1.0) * error
    }

    fn findings(&self, groups: &[Group]) -> Vec<String> {
        let mut findings = Vec::new();
        for group in groups {
            let name = group.class.as_ref().map_or_else(|| "all rows".to_owned(), |class| format!("class `{class}`"));
            if group.sd_k.is_none() {
                findings.push(format!("{name}: one comparison has no scatter, so that it gives no margin"));
            }
            // A mean that is not 0 is a bias: a margin hides it, a correction removes it.
            if self.is_biased(group) {
                let way = if group.mean_k > 0.0 { "hotter" } else { "colder" };
                findings.push(format!(
                    "{name}: measured is {way} than predicted on average (Student's t at 1 %); a correction of the predictions would \
                     need a smaller margin"
                ));
            }
        }
        if !self.spec.has_programs {
            findings.push(
                "the file does not say which program a row is of (`program`): bounds take the rows as independent"
                    .to_owned(),
            );
        }
        let mut programs: Vec<&str> = Vec::new();
        for row in &self.spec.comparisons {
            if self.spec.has_programs && !programs.contains(&row.program.as_str()) {
                programs.push(&row.program);
            }
        }
        for program in programs {
            let own = self.spec.comparisons.iter().filter(|row| row.program == program).count();
            if own as f64 > DOMINATES * self.spec.comparisons.len() as f64 {
                findings.push(format!(
                    "`{program}` has {} of {}: the margins are mostly its own",
                    own,
                    counted(self.spec.comparisons.len(), "comparison")
                ));
            }
        }
        findings
    }
}

impl Job for MarginsFromHistory {
    type State = ();
    type Input = ();
    type Partial = ();
    type Output = Output;

    fn kind(&self) -> &'static str {
        "margins-from-history"
    }

    fn algorithm_version(&self) -> u32 {
        1
    }

    fn identity(&self) -> Value {
        let settings = &self.spec;
        let rules: Vec<Value> =
            settings.rules.iter().map(|(rule, margin)| json!({"rule": rule, "margin_k": margin})).collect();
        json!({
            "file": settings.file,
            "sha256": settings.sha256,
            "rows": settings.comparisons.len(),
            "capture": settings.capture,
            "confidence": settings.confidence,
            "rules": rules,
        })
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        let mut classes: Vec<Option<&str>> = vec![None];
        for row in &self.spec.comparisons {
            if !row.class.is_empty() && !classes.contains(&Some(row.class.as_str())) {
                classes.push(Some(&row.class));
            }
        }
        let groups: Vec<Group> = classes.into_iter().filter_map(|class| self.group(class)).collect();
        Ok(Step::Done(Box::new(Output {
            file: self.spec.file.clone(),
            capture: self.spec.capture,
            confidence: self.spec.confidence,
            fewest_distribution_free: fewest_for_order_statistic(self.spec.capture, self.spec.confidence),
            findings: self.findings(&groups),
            groups,
        })))
    }

    fn block(&self, _state: &(), _input: (), _parts: &dyn Parts) -> Result<(), JobError> {
        Ok(())
    }

    fn reduce(&self, _state: (), _blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        self.begin()
    }
}
