//! What the predictions of earlier programs were off by, and the margin that it asks for: mean difference, two standard deviations, the
//! margin that holds a share of the differences, its bounds at a stated confidence, and what margins by rule would have held. The kind of
//! study behind the 11 K of SMC-S-016 (Welch 2006 and its forerunners, as J. Stout, PhD thesis, MIT, 2015, section 1.3.2 tells of them).

mod form;
mod output;
mod resolve;
mod run;

pub use output::{Comparison, Group, Held, Output, Spec};
pub use run::MarginsFromHistory;

use std::sync::Arc;

use crate::job::JobError;
use crate::job::key_number::KeyNumber;
use crate::job::kind::JobKind;
use crate::job::ready::{Readiness, Shared};
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::resolve::scope::Scope;
use crate::study::resolved::Blocked;
use crate::study::{self, Pass};
use crate::thermal::Derivatives;
use form::HistoryForm;

/// The kind `margins-from-history`.
#[derive(Clone, Copy, Debug)]
pub struct Kind;

impl JobKind for Kind {
    const NAME: &'static str = "margins-from-history";
    const ABOUT: &'static str = "The margin that earlier programs' differences ask for.";
    type Form = HistoryForm;
    type Spec = Spec;
    type Output = Output;

    fn resolve(form: &HistoryForm, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        resolve::resolve(scope, entry, form, asked.offered).map(JobSpec::of)
    }

    fn key_numbers(output: &Output) -> Vec<KeyNumber> {
        let number = |group: &Group| {
            let of = group.class.clone().unwrap_or_else(|| "all".to_owned());
            Some(KeyNumber::exact(of, "margin", "K", group.margin_k?))
        };
        output.groups.iter().filter_map(number).collect()
    }

    fn refuses_external(_spec: &Spec, _derivatives: Derivatives) -> Option<String> {
        None
    }

    fn ready(spec: &Spec, _shared: &Shared, _name: &str) -> Result<Readiness, JobError> {
        Ok(Readiness::Ready(Arc::new(MarginsFromHistory::new(spec.clone()))))
    }
}

impl study::job::Spec for Spec {
    fn kind(&self) -> &'static str {
        Kind::NAME
    }

    fn blocked(&self, _pass: &Pass) -> Option<Blocked> {
        None
    }
}
