//! What a job kind answers: the form of its settings, how these are looked up, what runs, the result.

use std::any::Any;
use std::fmt;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::de::Error as _;
use serde::{Deserialize as _, Serialize};
use serde_json::Value;

use super::array::{Array, Arrays};
use super::key_number::KeyNumber;
use super::ready::{Readiness, Shared};
use super::{JobError, KINDS};
use crate::document::{Diagnostics, Node, Place, Schemas, Written};
use crate::study::Pass;
use crate::study::job::{self as study_job, Asked, Entry, Forms, JobSpec, Kinds, NamedJob, Spec};
use crate::study::resolve::scope::Scope;
use crate::study::resolve::settings::Offered;
use crate::thermal::Derivatives;

/// A job kind; the type that implements it holds nothing.
pub trait JobKind: Sync + 'static {
    /// The kind, as in the pass file.
    const NAME: &'static str;
    /// What it is for, for the schema of a pass.
    const ABOUT: &'static str;
    /// Whether its jobs are resolved after the others of the pass, whose settings they use.
    const IS_AFTER_OTHERS: bool = false;
    /// Settings as written.
    type Form: Written + 'static;
    /// Settings with everything looked up.
    type Spec: Spec;
    /// Result.
    type Output: Clone + fmt::Debug + Serialize + DeserializeOwned + JsonSchema + Send + Sync + 'static;

    /// Looks up the names and fills in the defaults; `None` where something is wrong, which is reported.
    fn resolve(form: &Self::Form, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec>;

    /// Why a job with these settings does not run on a model that is asked outside; `derivatives` tells where slopes would come
    /// from. `None` where it runs.
    fn refuses_external(_spec: &Self::Spec, _derivatives: Derivatives) -> Option<String> {
        Some(format!(
            "`{}` works on the equations of a network, and this model is asked outside; `propagate`, `sensitivity`, `goal`, \
             `design`, `compare`, `calibrate` and `predict` work with it",
            Self::NAME
        ))
    }

    /// Called when all jobs of a pass are resolved: changes them, or adds some.
    fn complete(_jobs: &mut Vec<NamedJob>, _forms: &Forms, _offered: &Offered, _measured: Option<&Place>) {}

    /// The job as it can run, or what it waits for.
    ///
    /// # Errors
    /// A definition of which no job can be made.
    fn ready(spec: &Self::Spec, shared: &Shared, name: &str) -> Result<Readiness, JobError>;

    /// The result for other programs, without what [`JobKind::rows`] gives; `with_rows` keeps what else is long.
    ///
    /// # Errors
    /// A result that cannot be written as JSON.
    fn document(output: &Self::Output, _with_rows: bool) -> Result<Value, JobError> {
        serde_json::to_value(output).map_err(|error| JobError::Failed(error.to_string()))
    }

    /// The single readings of the result, where it has some: `rows` of its document.
    fn rows(_output: &Self::Output) -> Option<Box<dyn Iterator<Item = Value> + '_>> {
        None
    }

    /// The arrays of the result, each with a name, whose numbers stand beside its JSON.
    fn arrays(_output: &Self::Output) -> Vec<(String, Array)> {
        Vec::new()
    }

    /// Puts numbers that stand beside its JSON into a result that was read from that.
    ///
    /// # Errors
    /// The hash of an array that is not among these.
    fn fill(_output: &mut Self::Output, _arrays: &Arrays) -> Result<(), String> {
        Ok(())
    }

    /// The result without its single readings, where it has some.
    fn without_rows(_output: &Self::Output) -> Option<Self::Output> {
        None
    }

    /// The numbers of the result that a baseline keeps, each with its Monte Carlo error where the result states it; names
    /// are unique. Of a kind without any the baseline keeps the hash of the result alone.
    fn key_numbers(_output: &Self::Output) -> Vec<KeyNumber> {
        Vec::new()
    }
}

/// A kind of the registry.
pub trait ErasedKind: study_job::Kind {
    /// JSON Schema of the result.
    fn output_schema(&self) -> Value;
    /// Reads a stored result.
    ///
    /// # Errors
    /// A result that does not have the form that this version writes, or lacks an array.
    fn output(&self, result: &Value, arrays: &Arrays) -> Result<Arc<dyn AnyOutput>, serde_json::Error>;
    /// See [`JobKind::ready`]; `None` where the settings are of another kind.
    ///
    /// # Errors
    /// A definition of which no job can be made.
    fn ready(&self, spec: &JobSpec, shared: &Shared, name: &str) -> Result<Option<Readiness>, JobError>;
}

impl<K: JobKind> study_job::Kind for K {
    fn name(&self) -> &'static str {
        K::NAME
    }

    fn about(&self) -> &'static str {
        K::ABOUT
    }

    fn schema(&self, schemas: &mut Schemas) -> Value {
        K::Form::schema(schemas)
    }

    fn read(&self, settings: &Node, diagnostics: &mut Diagnostics) -> Option<Box<dyn study_job::Form>> {
        K::Form::read(settings, diagnostics).map(|form| Box::new(FormOf::<K>(form)) as Box<dyn study_job::Form>)
    }

    fn is_after_others(&self) -> bool {
        K::IS_AFTER_OTHERS
    }

    fn refuses_external(&self, spec: &JobSpec, derivatives: Derivatives) -> Option<String> {
        K::refuses_external(spec.get::<K::Spec>()?, derivatives)
    }

    fn complete(&self, jobs: &mut Vec<NamedJob>, forms: &Forms, offered: &Offered, measured: Option<&Place>) {
        K::complete(jobs, forms, offered, measured);
    }
}

impl<K: JobKind> ErasedKind for K {
    fn output_schema(&self) -> Value {
        schemars::schema_for!(K::Output).to_value()
    }

    fn output(&self, result: &Value, arrays: &Arrays) -> Result<Arc<dyn AnyOutput>, serde_json::Error> {
        let mut read = K::Output::deserialize(result)?;
        K::fill(&mut read, arrays).map_err(|sha256| {
            serde_json::Error::custom(format_args!(
                "the array with the SHA-256 {sha256} is not there, or has another shape"
            ))
        })?;
        Ok(output::<K>(read))
    }

    fn ready(&self, spec: &JobSpec, shared: &Shared, name: &str) -> Result<Option<Readiness>, JobError> {
        spec.get::<K::Spec>().map(|spec| K::ready(spec, shared, name)).transpose()
    }
}

/// Settings as written that know their kind.
pub struct FormOf<K: JobKind>(pub K::Form);

impl<K: JobKind> study_job::Form for FormOf<K> {
    fn resolve(&self, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        K::resolve(&self.0, scope, entry, asked)
    }
}

/// A result of whichever kind.
pub trait AnyOutput: fmt::Debug + Send + Sync {
    /// The kind, as in the pass file.
    fn kind(&self) -> &'static str;
    /// The kind's `Output`.
    fn as_any(&self) -> &dyn Any;
    /// As it stands in `results.json`.
    ///
    /// # Errors
    /// A result that cannot be written as JSON.
    fn to_json(&self) -> Result<Value, serde_json::Error>;
    /// See [`JobKind::document`].
    ///
    /// # Errors
    /// A result that cannot be written as JSON.
    fn document(&self, with_rows: bool) -> Result<Value, JobError>;
    /// See [`JobKind::rows`].
    fn rows(&self) -> Option<Box<dyn Iterator<Item = Value> + '_>>;
    /// See [`JobKind::arrays`].
    fn arrays(&self) -> Vec<(String, Array)>;
    /// See [`JobKind::key_numbers`].
    fn key_numbers(&self) -> Vec<KeyNumber>;
    /// See [`JobKind::without_rows`].
    fn without_rows(&self) -> Option<Arc<dyn AnyOutput>>;
}

/// A result that knows its kind.
struct OutputOf<K: JobKind>(K::Output);

impl<K: JobKind> fmt::Debug for OutputOf<K> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

impl<K: JobKind> AnyOutput for OutputOf<K> {
    fn kind(&self) -> &'static str {
        K::NAME
    }

    fn as_any(&self) -> &dyn Any {
        &self.0
    }

    fn to_json(&self) -> Result<Value, serde_json::Error> {
        serde_json::to_value(&self.0)
    }

    fn document(&self, with_rows: bool) -> Result<Value, JobError> {
        K::document(&self.0, with_rows)
    }

    fn rows(&self) -> Option<Box<dyn Iterator<Item = Value> + '_>> {
        K::rows(&self.0)
    }

    fn arrays(&self) -> Vec<(String, Array)> {
        K::arrays(&self.0)
    }

    fn key_numbers(&self) -> Vec<KeyNumber> {
        K::key_numbers(&self.0)
    }

    fn without_rows(&self) -> Option<Arc<dyn AnyOutput>> {
        K::without_rows(&self.0).map(output::<K>)
    }
}

/// A result of a kind as one of whichever.
pub fn output<K: JobKind>(output: K::Output) -> Arc<dyn AnyOutput> {
    Arc::new(OutputOf::<K>(output))
}

/// The kind of this name.
pub fn find(name: &str) -> Option<&'static dyn ErasedKind> {
    KINDS.iter().copied().find(|kind| kind.name() == name)
}

/// The kinds as a study asks for them.
pub fn kinds() -> Kinds {
    Kinds::new(KINDS.iter().map(|&kind| kind as &dyn study_job::Kind))
}

/// Reads one pass with its parents, its model and its data.
///
/// # Errors
/// All that is wrong with the files; warnings stand among them.
pub fn load(pass: &std::path::Path) -> Result<Pass, Diagnostics> {
    crate::study::load(&kinds(), pass)
}
