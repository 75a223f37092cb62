//! Jobs as a study sees them: kinds are given from outside, a study asks each for what it must know of a job.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use crate::document::declare::one_kind;
use crate::document::schema::choice;
use crate::document::{Diagnostics, Map, Node, Place, Schemas, Written};
use crate::math::sort::sort_by_key;
use crate::thermal::Derivatives;

use super::resolve::posterior_prior::Upstreams;
use super::resolve::scope::Scope;
use super::resolve::settings::Offered;
use super::resolved::{Blocked, Pass};

/// Kind of the jobs whose posterior may be a prior elsewhere.
pub const CALIBRATION: &str = "calibrate";

/// A kind of job.
pub trait Kind: Sync {
    /// The key in the pass file.
    fn name(&self) -> &'static str;
    /// What it is for, for the schema.
    fn about(&self) -> &'static str;
    /// JSON Schema of its settings.
    fn schema(&self, schemas: &mut Schemas) -> serde_json::Value;
    /// Reads its settings; `None` where something is wrong with them.
    fn read(&self, settings: &Node, diagnostics: &mut Diagnostics) -> Option<Box<dyn Form>>;
    /// Whether its jobs are resolved after the others of the pass, whose settings they use.
    fn is_after_others(&self) -> bool;
    /// Why a job does not run on a model that is asked outside; `derivatives` tells where slopes come from.
    /// `None` where it runs, or is of another kind.
    fn refuses_external(&self, spec: &JobSpec, derivatives: Derivatives) -> Option<String>;
    /// Called when all jobs of a pass are resolved: changes them, or adds some.
    fn complete(&self, jobs: &mut Vec<NamedJob>, forms: &Forms, offered: &Offered, measured: Option<&Place>);
}

/// Settings of a job as written.
pub trait Form: Any {
    /// Looks up the names and fills in the defaults; `None` where something is wrong, which is reported.
    fn resolve(&self, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec>;
}

/// What a job is to do, with everything looked up.
pub trait Spec: Any + Debug + Send + Sync {
    /// The kind, as in the pass file.
    fn kind(&self) -> &'static str;
    /// What it infers from measurements, where it does.
    fn inference(&self) -> Option<Inference<'_>> {
        None
    }
    /// What it compares with measurements, where it does.
    fn comparison(&self) -> Option<Comparison<'_>> {
        None
    }
    /// Why it does not run now, by what else the pass defines; `None` where nothing keeps it.
    fn blocked(&self, pass: &Pass) -> Option<Blocked>;
}

/// Parameters that are inferred from measurements.
#[derive(Clone, Copy, Debug)]
pub struct Inference<'s> {
    /// What the job does, as in a sentence: `calibrates`.
    pub verb: &'static str,
    /// Positions of the measurements.
    pub data: &'s [usize],
    /// Positions of the parameters.
    pub parameters: &'s [usize],
}

/// Measurements that are held against the model.
#[derive(Clone, Copy, Debug)]
pub struct Comparison<'s> {
    /// Positions of the measurements.
    pub data: &'s [usize],
    /// Drift below which a steady phase counts as stabilised, K/s.
    pub stabilisation_k_per_s: Option<f64>,
    /// The calibration whose tuned state is shown.
    pub calibration: Option<&'s str>,
}

/// What a job is to do, or why that is not known yet.
#[derive(Clone, Debug)]
pub enum JobSpec {
    /// Everything is looked up.
    Resolved(Arc<dyn Spec>),
    /// Waits for pinned data.
    Waiting {
        /// The kind.
        kind: &'static str,
        /// Measurements whose data are missing.
        measurements: Vec<String>,
        /// The command that brings them.
        command: String,
    },
    /// Builds on a job of another pass that waits.
    NotYet {
        /// The kind.
        kind: &'static str,
        /// Why, in a line.
        reason: String,
    },
}

impl JobSpec {
    /// Of settings with everything looked up.
    pub fn of(spec: impl Spec) -> Self {
        Self::Resolved(Arc::new(spec))
    }

    /// The kind, as in the pass file.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Resolved(spec) => spec.kind(),
            Self::Waiting { kind, .. } | Self::NotYet { kind, .. } => kind,
        }
    }

    /// The settings, where everything is looked up.
    pub fn resolved(&self) -> Option<&dyn Spec> {
        match self {
            Self::Resolved(spec) => Some(spec.as_ref()),
            Self::Waiting { .. } | Self::NotYet { .. } => None,
        }
    }

    /// The settings of one kind.
    pub fn get<T: Spec>(&self) -> Option<&T> {
        let spec: &dyn Any = self.resolved()?;
        spec.downcast_ref()
    }

    /// What it infers from measurements.
    pub fn inference(&self) -> Option<Inference<'_>> {
        self.resolved()?.inference()
    }

    /// What it compares with measurements.
    pub fn comparison(&self) -> Option<Comparison<'_>> {
        self.resolved()?.comparison()
    }
}

/// A job with its name.
#[derive(Clone, Debug)]
pub struct NamedJob {
    /// Name.
    pub name: String,
    /// Where the study asks for it.
    pub place: Place,
    /// What is to be done.
    pub spec: JobSpec,
}

/// Where a job is asked for.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Name of the job.
    pub name: String,
    /// Place of the name.
    pub name_place: Place,
    /// Place of the job.
    pub place: Place,
}

/// What is at hand when a job is resolved.
pub struct Asked<'a, 'u> {
    /// What jobs can name.
    pub offered: &'a Offered<'a>,
    /// All jobs of the pass as written.
    pub forms: &'a Forms,
    /// Those that are resolved already.
    pub jobs: &'a [NamedJob],
    /// The passes whose calibrations are used.
    pub upstreams: &'a mut Upstreams<'u>,
}

/// A job as written, its settings not read yet.
#[derive(Clone, Debug, PartialEq)]
pub struct JobNode(Node);

impl Written for JobNode {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        Node::read(node, diagnostics).map(Self)
    }

    fn schema(_: &mut Schemas) -> serde_json::Value {
        serde_json::json!({"$ref": format!("#/$defs/{DEFINITION}")})
    }

    fn expected() -> String {
        "a job: an object with one key, its kind".to_owned()
    }
}

/// Name of the definition of a job in the schema of a pass.
const DEFINITION: &str = "JobForm";

/// The kinds of job that a study may ask for.
#[derive(Clone, Default)]
pub struct Kinds(Vec<&'static dyn Kind>);

impl Kinds {
    /// From all of them, in the order in which they are listed.
    pub fn new(kinds: impl IntoIterator<Item = &'static dyn Kind>) -> Self {
        Self(kinds.into_iter().collect())
    }

    /// Defines a job in the schema of a pass.
    pub fn define(&self, schemas: &mut Schemas) {
        schemas.define(DEFINITION, |schemas| {
            let kinds = self.0.iter().map(|kind| (kind.name(), kind.about(), kind.schema(schemas))).collect();
            choice("A job.", kinds)
        });
    }

    /// Reads the settings of all jobs of a pass.
    pub(super) fn read(&self, jobs: &Map<JobNode>, diagnostics: &mut Diagnostics) -> Forms {
        let names: Vec<&str> = self.0.iter().map(|kind| kind.name()).collect();
        let mut forms = Vec::new();
        for job in jobs {
            let Some(entry) = one_kind(&job.value.0, &names, "a job", diagnostics) else { continue };
            let Some(&kind) = self.0.iter().find(|kind| kind.name() == entry.key) else { continue };
            let Some(form) = kind.read(&entry.node, diagnostics) else { continue };
            let (name, name_place, place) = (job.name.clone(), job.name_place.clone(), job.place.clone());
            forms.push(NamedForm { entry: Entry { name, name_place, place }, kind, form });
        }
        Forms(forms)
    }

    /// Resolves the jobs of a pass, in the order of the file.
    pub(super) fn resolve(
        &self,
        scope: &mut Scope,
        forms: &Forms,
        offered: &Offered,
        upstreams: &mut Upstreams,
    ) -> Vec<NamedJob> {
        let mut jobs: Vec<(usize, NamedJob)> = Vec::new();
        for is_after_others in [false, true] {
            let resolved_jobs: Vec<NamedJob> = jobs.iter().map(|(_, job)| job.clone()).collect();
            for (position, job_form) in forms.0.iter().enumerate() {
                if job_form.kind.is_after_others() == is_after_others {
                    let mut asked = Asked { offered, forms, jobs: &resolved_jobs, upstreams };
                    let spec = job_form.form.resolve(scope, &job_form.entry, &mut asked);
                    let Entry { name, name_place, .. } = &job_form.entry;
                    let named = |spec| NamedJob { name: name.clone(), place: name_place.clone(), spec };
                    jobs.extend(spec.map(|spec| (position, named(spec))));
                }
            }
        }
        sort_by_key(&mut jobs, |(position, _)| *position);
        jobs.into_iter().map(|(_, job)| job).collect()
    }

    /// Why a job does not run on a model that is asked outside.
    pub(super) fn refuses_external(&self, spec: &JobSpec, derivatives: Derivatives) -> Option<String> {
        self.0.iter().find_map(|kind| kind.refuses_external(spec, derivatives))
    }

    /// Completes the jobs of a pass; `measured` is the place of its measurements.
    pub(super) fn complete(
        &self,
        jobs: &mut Vec<NamedJob>,
        forms: &Forms,
        offered: &Offered,
        measured: Option<&Place>,
    ) {
        self.0.iter().for_each(|kind| kind.complete(jobs, forms, offered, measured));
    }
}

impl std::fmt::Debug for Kinds {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_list().entries(self.0.iter().map(|kind| kind.name())).finish()
    }
}

/// Jobs of a pass as written.
pub struct Forms(Vec<NamedForm>);

/// A job as written.
struct NamedForm {
    entry: Entry,
    kind: &'static dyn Kind,
    form: Box<dyn Form>,
}

impl Forms {
    /// Where each job is asked for.
    pub(super) fn entries(&self) -> impl Iterator<Item = &Entry> {
        self.0.iter().map(|job_form| &job_form.entry)
    }

    /// The kind of the job of this name.
    pub fn kind(&self, name: &str) -> Option<&'static str> {
        self.0.iter().find(|job_form| job_form.entry.name == name).map(|job_form| job_form.kind.name())
    }

    /// Names of the jobs of a kind.
    pub fn of_kind(&self, kind: &str) -> Vec<&str> {
        let forms_of_kind = self.0.iter().filter(|job_form| job_form.kind.name() == kind);
        forms_of_kind.map(|job_form| job_form.entry.name.as_str()).collect()
    }

    /// The settings of the job of this name, where they are of this type.
    pub fn get<T: Form>(&self, name: &str) -> Option<&T> {
        let form: &dyn Any = self.0.iter().find(|job_form| job_form.entry.name == name)?.form.as_ref();
        form.downcast_ref()
    }
}
