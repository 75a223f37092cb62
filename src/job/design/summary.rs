//! From replicates to candidates, the best of them, and what must be said.

use std::collections::BTreeMap;

use super::Design;
use super::block::PredictHead;
use super::block::{Purpose, State};
use super::forward_model::{Place, Whitening};
use super::information::whitened_rows;
use super::output::{
    Axis, Best, Candidate, Estimator, Limits, Observed, Output, Partial, Phase, Pick, Redundant, UsedSensor, Violation,
};
use super::run::SetFound;
use super::samples::REPLICATES;
use crate::document::counted;
use crate::inference::information::estimate::{Estimate, Replicate, Trust, difference};
use crate::inference::information::linear;
use crate::statistics::moments::correlation;

/// Largest share of samples without a solution.
pub(super) const FAILURE_LIMIT: f64 = 0.01;
/// Correlation from which two sensors tell the same.
const REDUNDANT: f64 = 0.98;
/// Share of outer samples with few effective inner samples above which it is said.
const FEW_LIMIT: f64 = 0.05;
/// A bias bound is worth a word above this and above three standard errors, nats.
const BIAS_WORTH_A_WORD: f64 = 0.02;

impl Design {
    /// Everything known before information: candidates with their limits and linear estimates.
    pub(super) fn begun(&self, heads: &[PredictHead]) -> Output {
        let spec = &self.spec;
        let candidates = spec.candidates.iter().zip(self.places()).zip(heads);
        let candidates = candidates.map(|((phase, place), head)| self.candidate(phase, place, head));
        let names = |range: std::ops::Range<usize>| -> Vec<String> {
            self.forward_model.unknowns()[range].iter().map(|unknown| unknown.name.clone()).collect()
        };
        Output {
            estimator: self.first_estimator().name().to_owned(),
            is_trusted: true,
            learn: names(0..spec.learn.len()),
            nuisance: names(spec.learn.len()..self.samples.unknowns),
            sensors: (spec.sensors.iter())
                .map(|sensor| UsedSensor {
                    name: sensor.name.clone(),
                    unit: self.model.quantities[sensor.quantity].unit.clone(),
                    sigma: sensor.sigma,
                })
                .collect(),
            axes: (spec.varied.iter())
                .map(|varied| Axis {
                    input: self.model.inputs[varied.input].name.clone(),
                    unit: self.model.inputs[varied.input].unit.clone(),
                    values: varied.values.clone(),
                })
                .collect(),
            is_grid: spec.is_grid,
            samples: [spec.outer, spec.inner, spec.draws],
            limits: [spec.red, spec.yellow],
            candidates: candidates.collect(),
            ..Output::default()
        }
    }

    /// A candidate with its limits and its linear estimate.
    pub(super) fn candidate(&self, phase: &Phase, place: &Place, head: &PredictHead) -> Candidate {
        let spec = &self.spec;
        let count = |number: u64| number as f64 / self.all_samples() as f64;
        let has_limits = self.forward_model.has_limits();
        let read: Vec<usize> = (0..self.forward_model.sensors()).collect();
        let conditions: BTreeMap<String, f64> = (spec.varied.iter())
            .map(|varied| (self.model.inputs[varied.input].name.clone(), phase.inputs[varied.input]))
            .collect();
        let shares: [Option<f64>; 2] = [0, 1].map(|k| has_limits[k].then(|| count(head.outside[k])));
        let most = (0..head.nodes.len()).filter(|&node| head.nodes[node] > 0).max_by_key(|&node| {
            // The first of several.
            (head.nodes[node], std::cmp::Reverse(node))
        });
        let node = most.map(|node| self.model.nodes[node].name.clone());
        let failed = count(head.failed);
        let not_tolerated = self.not_tolerated(shares);
        let because = self.refused(failed, shares, not_tolerated, node.as_deref());
        let whitening = Whitening::new(place, &spec.sensors, &read);
        let rows =
            (!head.changes.is_empty()).then(|| whitened_rows(&head.changes, self.samples.unknowns, &whitening, &read));
        Candidate {
            conditions,
            information_nats: None,
            se: None,
            bias_bound: None,
            linear_nats: rows.and_then(|rows| linear::information(&rows, self.samples.unknowns, spec.learn.len()).ok()),
            behind_best: None,
            violation: Violation { red: shares[0], yellow: shares[1], node, not_tolerated },
            allowed: because.is_none(),
            because,
            failed,
            effective_inner: None,
            few_effective: None,
            sees_nothing: false,
            is_found: false,
        }
    }

    /// The bound of an estimate's bias, where it is known: that of an approximation is not.
    fn bias_bound(estimator: Estimator, estimate: &Estimate) -> Option<f64> {
        estimator.tells_its_bias().then_some(estimate.bias_bound)
    }

    /// The limits that are violated with a larger probability than is tolerated.
    fn not_tolerated(&self, shares: [Option<f64>; 2]) -> Option<Limits> {
        let most = [(Limits::Red, self.spec.red), (Limits::Yellow, self.spec.yellow)];
        let is_over = |share: Option<f64>, most: Option<f64>| share.zip(most).is_some_and(|(share, most)| share > most);
        shares.into_iter().zip(most).find(|(share, (_, most))| is_over(*share, *most)).map(|(_, (limits, _))| limits)
    }

    /// Why a candidate is not allowed.
    fn refused(
        &self,
        failed: f64,
        [red, yellow]: [Option<f64>; 2],
        not_tolerated: Option<Limits>,
        node: Option<&str>,
    ) -> Option<String> {
        if failed > FAILURE_LIMIT {
            return Some(format!("no solution in {:.1} % of the samples", 100.0 * failed));
        }
        let limits = not_tolerated?;
        let (share, tolerated) = match limits {
            Limits::Red => (red?, self.spec.red?),
            Limits::Yellow => (yellow?, self.spec.yellow?),
        };
        let (colour, node) = (limits.colour(), node.map_or(String::new(), |node| format!(", most often {node}")));
        Some(format!(
            "outside the {colour} limits with probability {share:.3}, of which {tolerated} is tolerated{node}"
        ))
    }

    pub(super) fn has_solutions(&self, candidate: &Candidate) -> bool {
        candidate.failed <= FAILURE_LIMIT
    }

    /// Fills in the candidates' information and finds the best, where the estimates can be trusted.
    pub(super) fn judge(&self, state: &mut State) -> Option<usize> {
        let estimator = state.estimator;
        let State { output, replicates, .. } = state;
        output.estimator = estimator.name().to_owned();
        (output.best, output.picks, output.convergence) = (None, Vec::new(), Vec::new());
        for (candidate, candidate_replicates) in output.candidates.iter_mut().zip(replicates.iter()) {
            let Some(estimate) = Estimate::of(candidate_replicates) else {
                if candidate.allowed {
                    candidate.allowed = false;
                    candidate.because = Some("no sample has an estimate".to_owned());
                }
                continue;
            };
            candidate.information_nats = Some(estimate.value);
            candidate.se = Some(estimate.standard_error).filter(|error| error.is_finite());
            candidate.bias_bound = Self::bias_bound(estimator, &estimate);
            let of_samples = Some(estimate).filter(|_| estimator.tells_its_bias());
            candidate.sees_nothing =
                of_samples.is_none_or(|sampled| sampled.trust() > Trust::No) && estimate.is_within_noise();
            candidate.effective_inner = of_samples.map(|sampled| sampled.effective);
            candidate.few_effective = of_samples.map(|sampled| sampled.few);
            candidate.behind_best = None;
        }
        state.output.is_trusted = self.trust_in_candidates(state) > Trust::No;
        let State { output, replicates, .. } = state;
        if !output.is_trusted {
            return None;
        }
        let mut best: Option<(usize, f64)> = None;
        for (index, candidate) in output.candidates.iter().enumerate().filter(|(_, candidate)| candidate.allowed) {
            if let Some(value) = candidate.information_nats
                && best.is_none_or(|(_, most)| value > most)
            {
                best = Some((index, value));
            }
        }
        let (best, _) = best?;
        let bias = |candidate: &Candidate| candidate.bias_bound.unwrap_or(0.0);
        let own_bias = bias(&output.candidates[best]);
        let mut rivals = Vec::new();
        for (index, candidate) in output.candidates.iter_mut().enumerate() {
            let Some((behind, error)) = difference(&replicates[best], &replicates[index]) else { continue };
            candidate.behind_best = Some([behind, error]);
            let margin = 2.0 * error + bias(candidate).max(own_bias);
            // Without a random error nothing is said to be equal.
            if index != best && candidate.allowed && estimator != Estimator::Linear && behind <= margin {
                rivals.push(index);
            }
        }
        let candidate = &output.candidates[best];
        let estimate = Estimate::of(&replicates[best])?;
        output.best = Some(Best {
            candidate: best,
            conditions: candidate.conditions.clone(),
            information_nats: estimate.value,
            se: estimate.standard_error,
            bias_bound: Self::bias_bound(estimator, &estimate),
            rivals,
        });
        output.picks = vec![Self::pick(estimator, best, &estimate)];
        let parts = (0..).map(|power| 1_usize << power).take_while(|count| *count <= REPLICATES);
        let partial = |count: usize| {
            let estimate = Estimate::of(&replicates[best][..count])?;
            Some(Partial {
                samples: (count * self.samples.size) as u64,
                information_nats: estimate.value,
                se: Some(estimate.standard_error).filter(|error| error.is_finite()),
            })
        };
        output.convergence = parts.filter_map(partial).collect();
        Some(best)
    }

    /// Observability, correlations and redundant sensors at the best candidate.
    pub(super) fn describe_best(&self, output: &mut Output, place: Option<&Place>, predictions: &[f64]) {
        let (sensors, unknowns) = (self.forward_model.sensors(), self.samples.unknowns);
        if let Some(changes) =
            place.and_then(|place| self.forward_model.nominal_changes(place, &mut self.forward_model.room()))
        {
            output.observability = (self.forward_model.unknowns().iter().enumerate())
                .map(|(place, unknown)| Observed {
                    parameter: unknown.name.clone(),
                    learn: place < self.spec.learn.len(),
                    changes: (0..sensors).map(|sensor| changes[sensor * unknowns + place]).collect(),
                })
                .collect();
        }
        let rows: Vec<&[f64]> =
            predictions.chunks_exact(sensors).filter(|row| row.iter().all(|value| value.is_finite())).collect();
        let column = |sensor: usize| -> Vec<f64> { rows.iter().map(|row| row[sensor]).collect() };
        let columns: Vec<Vec<f64>> = (0..sensors).map(column).collect();
        let pair = |a: usize, b: usize| Some(correlation(&columns[a], &columns[b])).filter(|r| r.is_finite());
        output.correlations = (0..sensors).map(|a| (0..sensors).map(|b| pair(a, b)).collect()).collect();
        for b in 1..sensors {
            for a in 0..b {
                if let Some(correlation) = output.correlations[a][b].filter(|r| r.abs() >= REDUNDANT) {
                    let names = [a, b].map(|sensor| self.spec.sensors[sensor].name.clone());
                    output.redundant.push(Redundant { sensors: names, correlation });
                }
            }
        }
    }

    /// Adds the set that tells most to the greedy choice, which ends where no estimate of the sets can be trusted.
    pub(super) fn add_pick(&self, state: &mut State, sets: &[SetFound]) {
        let is_of_sensors = sets.first().is_some_and(|(set, _)| set.purpose == Purpose::Sensor);
        let replicates: Vec<&[Replicate]> = sets.iter().map(|(_, set_replicates)| set_replicates.as_slice()).collect();
        if self.trust_in(state.estimator, &replicates) == Trust::No {
            state.ended[usize::from(is_of_sensors)] = true;
            return;
        }
        let mut most: Option<(usize, bool, Estimate)> = None;
        for (set, replicates) in sets {
            let is_sensor = set.purpose == Purpose::Sensor;
            let added = if is_sensor { set.sensors.last() } else { set.phases.last() };
            if let (Some(&added), Some(estimate)) = (added, Estimate::of(replicates))
                && most.is_none_or(|(_, _, other)| estimate.value > other.value)
            {
                most = Some((added, is_sensor, estimate));
            }
        }
        let Some((position, is_sensor, estimate)) = most else {
            state.ended[usize::from(is_of_sensors)] = true;
            return;
        };
        let output = &mut state.output;
        let list = if is_sensor { &mut output.sensor_picks } else { &mut output.picks };
        list.push(Self::pick(state.estimator, position, &estimate));
    }

    fn pick(estimator: Estimator, position: usize, estimate: &Estimate) -> Pick {
        let bias_bound = Self::bias_bound(estimator, estimate);
        Pick { position, information_nats: estimate.value, se: estimate.standard_error, bias_bound }
    }

    /// Why no candidate is named, and what would help.
    fn distrust(&self, output: &Output) -> String {
        if self.spec.estimator == Estimator::Automatic {
            return format!(
                "No estimate can be trusted, so that no candidate is named: {}. The numbers are those of `{}`, an approximation of \
                 unknown error. More `draws` for `importance`, or more `inner` samples for `nested`, may help.",
                output.because, output.estimator
            );
        }
        let bias = output.candidates.iter().filter_map(|candidate| candidate.bias_bound).fold(0.0, f64::max);
        let least =
            output.candidates.iter().filter_map(|candidate| candidate.effective_inner).fold(f64::INFINITY, f64::min);
        format!(
            "The estimates by `{}` cannot be trusted, so that no candidate is named: the bias may be {bias:.2} nats and more, and \
             an inner average rests on as few as {least:.1} effective samples. Leave `estimator` out, and the one that fits is \
             chosen.",
            output.estimator
        )
    }

    /// What the reader must know.
    pub(super) fn tell(&self, output: &mut Output, state: &State) {
        let mut findings = Vec::new();
        let learn = output.learn.join(", ");
        if !output.is_trusted {
            findings.push(self.distrust(output));
        } else if !output.because.is_empty() && state.estimator != Estimator::Nested {
            findings.push(format!(
                "The estimator is `{}`, chosen by its diagnostics: the report says why.",
                output.estimator
            ));
        }
        for (ended, what) in state.ended.into_iter().zip(["phases", "sensors"]) {
            if ended {
                findings.push(format!(
                    "The choice of {what} ends early: by `{}` no estimate of the larger sets can be trusted.",
                    state.estimator.name()
                ));
            }
        }
        let usable: Vec<&Candidate> =
            output.candidates.iter().filter(|candidate| candidate.information_nats.is_some()).collect();
        let unseen = usable.iter().filter(|candidate| candidate.sees_nothing).count();
        if unseen > 0 && unseen == usable.len() {
            findings.push(format!("This experiment cannot see {learn}: no candidate tells more than noise would."));
        } else if unseen > 0 {
            findings.push(format!("{unseen} of {} cannot see {learn}.", counted(usable.len(), "candidate")));
        }
        for observed in output.observability.iter().filter(|observed| observed.learn) {
            let seen =
                observed.changes.iter().zip(&output.sensors).any(|(change, sensor)| change.abs() > 1e-6 * sensor.sigma);
            if !seen {
                findings.push(format!("No sensor of the best candidate moves with {}.", observed.parameter));
            }
        }
        match &output.best {
            None if !output.is_trusted => {}
            None => findings.push("No candidate keeps the limits and has solutions.".to_owned()),
            Some(best) if !best.rivals.is_empty() => findings.push(format!(
                "{} {} not told from the best with so many samples.",
                counted(best.rivals.len(), "other candidate"),
                if best.rivals.len() == 1 { "is" } else { "are" }
            )),
            Some(_) => {}
        }
        if let Some(best) = output.best.as_ref().filter(|_| self.spec.search > 0) {
            let found_count = output.candidates.iter().filter(|candidate| candidate.is_found).count();
            let what = if output.candidates[best.candidate].is_found {
                "and the best is one of them"
            } else {
                "and none of them tells more than the best of the grid"
            };
            findings.push(match found_count {
                0 => "Between the values of the grid nothing more is to be expected.".to_owned(),
                1 => format!("One further phase was tried between the values of the grid, {what}."),
                _ => format!("{found_count} further phases were tried between the values of the grid, {what}."),
            });
        }
        let forbidden = output.candidates.iter().filter(|candidate| !candidate.allowed).count();
        if forbidden > 0 && output.best.is_some() {
            findings.push(format!(
                "{forbidden} of {} {} not allowed.",
                counted(output.candidates.len(), "candidate"),
                if forbidden == 1 { "is" } else { "are" }
            ));
        }
        if let Some(best) = &output.best {
            if let Some(bias) = best.bias_bound.filter(|bias| *bias > BIAS_WORTH_A_WORD.max(3.0 * best.se)) {
                findings.push(format!(
                    "The bias of the best candidate may be {bias:.3} nats: more inner samples, or `importance`, would tell."
                ));
            }
            let few = output.candidates[best.candidate].few_effective.unwrap_or(0.0);
            if few > FEW_LIMIT {
                findings.push(format!(
                    "At the best candidate {:.0} % of the inner averages rest on fewer than 10 effective samples.",
                    100.0 * few
                ));
            }
        }
        for pair in &output.redundant {
            findings.push(format!(
                "{} and {} tell the same (correlation {:.3} over the prior): one of them adds little beside less noise.",
                pair.sensors[0], pair.sensors[1], pair.correlation
            ));
        }
        if !state.estimator.tells_its_bias() && output.is_trusted {
            findings.push(format!(
                "The estimator `{}` is an approximation for screening. The error of the approximation is not known, so that no bound \
                 of the bias stands beside the numbers; `nested` or `importance` at the candidates that matter would tell it.",
                output.estimator
            ));
        }
        if self.spec.pick > 1 && output.picks.len() > 1 {
            output.guarantee = if self.samples.unknowns == self.spec.learn.len() {
                "Given the parameters the phases are independent, so that the information of a set of phases is monotone and \
                 submodular: the greedy choice has at least 1 - 1/e (63 %) of the information of the best set of as many \
                 phases (Nemhauser, Wolsey & Fisher 1978; Krause & Guestrin 2005), up to the error of the estimates."
                    .to_owned()
            } else {
                "Phases share the unknowns that are integrated out, so that they are not independent given what is to be \
                 learnt: the information of a set of phases is monotone but need not be submodular, and the greedy choice has \
                 no guarantee."
                    .to_owned()
            };
        }
        output.findings = findings;
    }
}
