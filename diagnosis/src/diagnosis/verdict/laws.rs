//! From an unknown function to physics: laws that describe the curve of a selected effect within its error.
//!
//! Each law is fitted to the data in the curve's place. Laws go before curves at the odds that [`prior_odds`] gives them,
//! so that a law describes the curve where its log evidence lags by no more than that.
//!
//! [`prior_odds`]: crate::diagnosis::odds::prior_odds

use std::sync::Arc;

use rayon::prelude::*;

use crate::diagnosis::engine::Diagnosis;
use crate::diagnosis::fits::effect_heat_flow::effect_heat_flow;
use crate::diagnosis::fits::refit::Begin;
use crate::diagnosis::odds::prior_odds::{CURVE_COST, PriorOdds};
use crate::diagnosis::output::{EffectFile, EffectResult};
use crate::diagnosis::verdict::findings::Findings;
use crate::diagnosis::verdict::results::{parameters, watts};
use crate::diagnosis::{Problem, Refit};
use crate::document::Diagnostics;
use crate::effect::law::{LawFile, SCALE, laws};
use crate::effect::{Bound, Candidate};
use crate::watch;

/// Values of a law's `scale` from which its fit begins.
const SCALES: [f64; 3] = [0.15, 0.5, 2.0];

/// A law fitted in the place of a curve.
struct Fitted {
    law: LawFile,
    problem: Problem,
    candidate: usize,
    refit: Refit,
}

impl Diagnosis {
    /// For each curve of the selected set the law that describes it best, if one does: as an effect of the curve's group,
    /// with its file. `results` are those of all effects.
    pub(super) fn laws(&self, findings: &Findings<'_>, results: &[EffectResult]) -> Vec<EffectResult> {
        let refit = &findings.state.refits[findings.selected];
        let curves = refit.effects.iter().filter(|&&effect| self.is_unknown_function(effect));
        let one = |&effect: &usize| {
            let curve = results.iter().find(|result| result.id == findings.id(effect))?;
            let tried = self.fitted_laws(findings.problem, refit, effect);
            let evidence = |refit: &Refit| findings.problem.log_evidence_of_own_noise(refit);
            let better = |a: Fitted, b: Fitted| if evidence(&b.refit) > evidence(&a.refit) { b } else { a };
            let best = tried.into_iter().reduce(better)?;
            let describes = evidence(&best.refit) + CURVE_COST >= evidence(refit);
            describes.then(|| {
                let needless = self.needless(findings, &best);
                result(&best, curve, refit, needless)
            })
        };
        curves.filter_map(one).collect()
    }

    /// Ids of small effects of the selected set that the law makes needless: errors of a curve's straight pieces follow the
    /// inputs, as effects do.
    fn needless(&self, findings: &Findings<'_>, best: &Fitted) -> Vec<String> {
        let (kept, small): (Vec<usize>, Vec<usize>) =
            best.refit.effects.iter().partition(|&&effect| !findings.is_small(effect));
        let begin =
            Begin { starts: vec![best.refit.by_name()], scale: 1.0, widths: best.refit.widths(), ..Begin::default() };
        let alone = if small.is_empty() { None } else { best.problem.refit(&kept, &begin, self.key()).ok() };
        let Some(alone) = alone else { return Vec::new() };
        let odds = PriorOdds::new(&best.problem);
        let weight = |refit: &Refit| refit.log_evidence + odds.of(&best.problem, &refit.effects);
        if weight(&alone) < weight(&best.refit) {
            return Vec::new();
        }
        small.into_iter().map(|effect| findings.id(effect).to_owned()).collect()
    }

    /// All laws in the place of a curve of a set.
    fn fitted_laws(&self, problem: &Problem, curve_refit: &Refit, curve: usize) -> Vec<Fitted> {
        let candidate = &problem.candidates[curve];
        let Some(effect) = problem.catalogue.get(&candidate.effect) else { return Vec::new() };
        let position = effect
            .form
            .adds
            .value
            .curve
            .as_ref()
            .and_then(|form| effect.form.inputs.iter().position(|entry| entry.name == form.of.value));
        let of: Option<Bound> = position.and_then(|position| candidate.bound.get(position)).copied();
        let of_angle = of.is_some_and(|of| of.is_angle(&problem.model));
        let fit = |law: LawFile| {
            let mut catalogue = (*problem.catalogue).clone();
            catalogue.read(&law.name, &law.name, law.text.as_bytes(), &mut Diagnostics::new())?;
            let id = candidate.id.replacen(&candidate.effect, &law.name, 1);
            let mut with_law = Problem { catalogue: Arc::new(catalogue), ..problem.clone() };
            let of_law = Candidate { id: id.clone(), effect: law.name.clone(), ..candidate.clone() };
            Arc::make_mut(&mut with_law.candidates).push(of_law);
            let position = problem.candidates.len();
            let effects: Vec<usize> =
                curve_refit.effects.iter().map(|&own| if own == curve { position } else { own }).collect();
            let scale = format!("{id}.{SCALE}");
            let starts = SCALES.iter().map(|&value| {
                let mut start = curve_refit.by_name();
                start.insert(scale.clone(), value);
                start
            });
            let starts = starts.take(if law.has_scale { SCALES.len() } else { 1 }).collect();
            let begin = Begin { starts, scale: 1.0, widths: curve_refit.widths(), ..Begin::default() };
            let refit = with_law.refit(&effects, &begin, self.key()).ok()?;
            let is_usable = refit.log_evidence.is_finite() && !refit.does_nothing(position);
            is_usable.then_some(Fitted { law, problem: with_law, candidate: position, refit })
        };
        // How far a law's fit has come says nothing of the block in which its thread waits.
        let quietly = |law| watch::with_share(&watch::Share::default(), || fit(law));
        laws(effect, of_angle, &candidate.id).into_par_iter().filter_map(quietly).collect()
    }
}

/// The law as an effect beside its curve.
fn result(best: &Fitted, curve: &EffectResult, curve_refit: &Refit, needless: Vec<String>) -> EffectResult {
    let (problem, refit) = (&best.problem, &best.refit);
    let candidate = &problem.candidates[best.candidate];
    let effect = problem.catalogue.get(&candidate.effect);
    let position = refit.effects.iter().position(|&own| own == best.candidate);
    let carries = effect_heat_flow(problem, refit, best.candidate);
    EffectResult {
        id: candidate.id.clone(),
        effect: candidate.effect.clone(),
        title: effect.map_or_else(String::new, |effect| effect.form.title.clone()),
        model_error: 0.0,
        log_bayes_factor: curve.log_bayes_factor + refit.log_evidence - curve_refit.log_evidence,
        log_bayes_factor_scales: None,
        amplitudes: position
            .map(|position| parameters(problem, candidate, &refit.amplitudes[position]))
            .unwrap_or_default(),
        rmse_k: crate::diagnosis::output::RmseChange {
            train: [curve.rmse_k.train[0], refit.rmse_train_k],
            held_out: [curve.rmse_k.held_out[0], refit.rmse_held_out_k],
        },
        watts: watts(&carries),
        prior_width: position.map_or(1.0, |position| refit.widths[position]),
        within_model: position.is_some_and(|position| refit.within_model[position]),
        carries,
        confused_with: vec![curve.effect.clone()],
        hints: Vec::new(),
        starts: Vec::new(),
        file: Some(EffectFile {
            name: best.law.name.clone(),
            law: best.law.law.to_owned(),
            text: best.law.text.clone(),
            needless,
        }),
        ..curve.clone()
    }
}
