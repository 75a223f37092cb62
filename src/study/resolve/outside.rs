//! Jobs that do not run on a model that is asked outside: everything else does.

use crate::document::{Diagnostic, code};
use crate::study::job::{Kinds, NamedJob};
use crate::study::resolved::Refused;

use super::scope::Scope;

/// The jobs that need what a model that is asked outside does not have.
pub(super) fn refused(scope: &Scope, kinds: &Kinds, jobs: &[NamedJob]) -> Vec<Refused> {
    let Some(derivatives) = scope.resolved.derivatives() else { return Vec::new() };
    let noisy = scope.resolved.input_errors.iter().position(|error| error.sigma.is_some());
    let noisy = noisy.and_then(|input| scope.resolved.model.inputs.get(input));
    let reason = |job: &NamedJob| {
        let refused = kinds.refuses_external(&job.spec, derivatives);
        refused.or_else(|| {
            job.spec.inference()?;
            Some(format!(
                "the known error (`sigma`) of the input `{}` enters by exact derivatives, and this model is asked outside: leave \
                 it out, or infer a constant error with `bias`",
                noisy?.name
            ))
        })
    };
    let refused = jobs.iter().filter_map(|job| {
        let message = format!("job `{}` does not run: {}", job.name, reason(job)?);
        let diagnostic = Diagnostic::error(&code::JOB_REFUSED, &job.place, message);
        Some(Refused { job: job.name.clone(), diagnostic })
    });
    refused.collect()
}
