//! Propagations: settings with their defaults, names looked up.

use super::form::{PropagateForm, SamplingForm};
use super::{Sampling, Spec};
use crate::study::resolve::design_variable::sweep;
use crate::study::resolve::scope::Scope;
use crate::study::resolve::settings::{
    Offered, environments, failure_limit, push_new, quantities, requirements, samples,
};

/// Resolves the settings of a propagation.
pub fn resolve(scope: &mut Scope, form: &PropagateForm, offered: &Offered) -> Option<Spec> {
    let before = scope.diagnostics.errors();
    let environments = environments(scope, form.environments.as_ref(), offered);
    let requirements = requirements(scope, form.requirements.as_ref(), offered);
    let mut quantities = quantities(scope, form.quantities.as_ref(), &requirements, offered);
    let mut joint = Vec::new();
    for pair in &form.joint {
        let (x, y) = (scope.quantity(&pair[0]), scope.quantity(&pair[1]));
        if let (Some(x), Some(y)) = (x, y) {
            push_new(&mut quantities, x);
            push_new(&mut quantities, y);
            let position = |index: usize| quantities.iter().position(|other| *other == index).unwrap_or(0);
            joint.push([position(x), position(y)]);
        }
    }
    let sampling = match form.sampling {
        None | Some(SamplingForm::Sobol) => Sampling::Sobol,
        Some(SamplingForm::LatinHypercube) => Sampling::LatinHypercube,
        Some(SamplingForm::MonteCarlo) => Sampling::MonteCarlo,
    };
    let samples = samples(scope, form.samples.as_ref(), sampling == Sampling::Sobol);
    let failure_limit = failure_limit(scope, form.failure_limit.as_ref());
    let sweep = form.sweep.as_ref().and_then(|form| sweep(scope, form));
    let spec = Spec { quantities, samples, sampling, environments, sweep, joint, requirements, failure_limit };
    (scope.diagnostics.errors() == before).then_some(spec)
}
