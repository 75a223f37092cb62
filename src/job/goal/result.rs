//! All that was found, to the result.

use super::Goal;
use super::cell::{Outcome, Role};
use super::output::{Knowledge, Level, Output, Target, Truths};
use super::run::DESIGN_RATIOS;
use super::run::RATIOS;
use super::run::State;
use crate::job::propagate::Probability;
use crate::job::propagate::reached::crossing;
use crate::math::sort::sort_by;
use crate::statistics::Interval;

/// Confidence of intervals.
const CONFIDENCE: f64 = 0.95;

impl Goal {
    /// The design value at which the curve of a role reaches the required probability.
    fn design_value(&self, outcomes: &[Outcome], role: Role) -> Option<f64> {
        let [from, to] = self.design_range()?;
        let mut points: Vec<(f64, f64)> = outcomes
            .iter()
            .filter(|outcome| outcome.cell.role == role)
            .filter_map(|outcome| Some((outcome.cell.design?, outcome.probability().value)))
            .collect();
        sort_by(&mut points, |a, b| if from < to { a.0.total_cmp(&b.0) } else { b.0.total_cmp(&a.0) });
        let samples = outcomes.iter().find(|outcome| outcome.cell.role == role)?.cell.samples;
        crossing(&points, self.required, samples)
    }

    /// Probability by the given design with some knowledge.
    fn level_probability(&self, state: &State, set: usize, ratio: f64) -> Option<Probability> {
        let role = Role::Level { set, ratio };
        state.outcomes.iter().find(|outcome| outcome.cell.role == role).map(Outcome::probability)
    }

    fn sds(&self, parameters: &[usize], ratio: f64) -> Vec<f64> {
        parameters.iter().map(|&index| ratio * self.priors[index].sd()).collect()
    }

    fn names(&self, parameters: &[usize]) -> Vec<String> {
        parameters.iter().map(|&index| self.model.parameters[index].name.clone()).collect()
    }

    /// The result.
    pub(super) fn output(&self, state: &State) -> Output {
        let sharpened = self.sharpened(&state.prior);
        let knowledge = (1..=sharpened.len())
            .map(|set| {
                let parameters = &sharpened[..set];
                let level = |ratio: f64| {
                    let is_design_sought = self.spec.design.is_some() && DESIGN_RATIOS.contains(&ratio);
                    Some(Level {
                        ratio,
                        sds: self.sds(parameters, ratio),
                        probability: self.level_probability(state, set, ratio)?,
                        design_value: self.design_value(&state.outcomes, Role::Curve { set, ratio }),
                        is_design_sought,
                    })
                };
                Knowledge {
                    parameters: self.names(parameters),
                    levels: RATIOS.iter().filter_map(|&r| level(r)).collect(),
                }
            })
            .collect();
        let target = state.target.and_then(|(set, [ratio, _])| {
            let parameters = &sharpened[..set];
            Some(Target {
                parameters: self.names(parameters),
                units: parameters.iter().map(|&index| self.model.parameters[index].unit.clone()).collect(),
                ratio,
                variance_ratio: ratio * ratio,
                sds: self.sds(parameters, ratio),
                probability: self.level_probability(state, set, ratio)?,
            })
        });
        let (failed, solves) = self.counts(state);
        let design = self.spec.design.as_ref();
        let design_nominal = design.map(|design| match design.variable {
            crate::study::variable::Variable::Parameter(index) => self.nominal[index],
            crate::study::variable::Variable::Input(index) => {
                self.spec.environments.first().map_or(0.0, |environment| environment.inputs[index])
            }
        });
        let mut output = Output {
            samples: self.spec.samples,
            required: self.required,
            design_variable: design.map(|design| design.name.clone()),
            design_unit: design.map(|design| design.unit.clone()).unwrap_or_default(),
            design_nominal,
            design_range: self.design_range(),
            probability: state.prior.probability,
            requirements: state.prior.requirements.clone(),
            driving: state.prior.driving.clone(),
            leading: state.prior.leading.iter().map(|(_, leading)| leading.clone()).collect(),
            prior_design_value: self.design_value(&state.outcomes, Role::Curve { set: 0, ratio: 1.0 }),
            knowledge,
            target,
            truths: self.averages(state, &sharpened),
            tolerable_discrepancy: state.prior.tolerable,
            discrepancy: self
                .spec
                .discrepancy
                .iter()
                .map(|discrepancy| (self.model.quantities[discrepancy.quantity].name.clone(), discrepancy.sd))
                .collect(),
            failed,
            solves,
            advice: super::Advice { next: super::Next::Validation, reasons: Vec::new() },
        };
        output.advice = super::advice::advice(&output);
        output
    }

    /// What the experiment would lead to, over truths.
    fn averages(&self, state: &State, sharpened: &[usize]) -> Option<Truths> {
        let (set, ratio) = self.experiment(state)?;
        let of = |outcome: &&Outcome| matches!(outcome.cell.role, Role::Truth { .. });
        let truths: Vec<&Outcome> = state.outcomes.iter().filter(of).collect();
        let count = truths.len() as u64;
        let reaching = truths.iter().filter(|outcome| outcome.probability().value >= self.required).count() as u64;
        let interval = Interval::wilson(reaching, count, CONFIDENCE);
        let mut design_values: Vec<f64> = (0..truths.len())
            .filter_map(|index| self.design_value(&state.outcomes, Role::TruthCurve { index }))
            .collect();
        sort_by(&mut design_values, f64::total_cmp);
        let is_complete = !design_values.is_empty() && design_values.len() == truths.len();
        let mean_design_value = is_complete.then(|| design_values.iter().sum::<f64>() / design_values.len() as f64);
        Some(Truths {
            parameters: self.names(&sharpened[..set]),
            ratio,
            count,
            reaching: Probability {
                value: reaching as f64 / count.max(1) as f64,
                lower: interval.lower,
                upper: interval.upper,
            },
            design_values,
            mean_design_value,
        })
    }
}
