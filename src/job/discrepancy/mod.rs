//! What a calibrated model leaves unexplained, sensor by sensor, as a function of the inputs (Kennedy & O'Hagan 2001,
//! J. R. Statist. Soc. B 63, 425): `reading = model(inputs, parameters) + discrepancy(inputs) + noise`.
//!
//! Modular: the discrepancy is fitted to the residuals of a calibration, whose posterior stays as it is. Its law is the simplest
//! that predicts readings left out about as well as the best: none, a constant, a residual law, a Gaussian process.
//!
//! Joint: parameters and hyperparameters are drawn together under the priors of a calibration of the pass; what the parameters
//! become is held against its posterior.
//!
//! Stages: `chains` (a chain a block, joint alone), `residuals` (draws of the posterior a block), `laws` (a sensor a block). The residuals are kept as linear functions
//! of the calibration's unknowns, so that a prediction with a draw of the posterior takes the discrepancy that belongs to it.

mod chosen;
mod expected;
mod form;
mod joint;
mod laws;
mod output;
pub mod residuals;
mod resolve;
mod run;

pub use expected::{Case, Rebuilt};
pub use output::{
    Check, Confounded, Curve, Hyperparameter, Joint, JointParameter, Law, LawScore, Output, PhaseResidual,
    SensorDiscrepancy, Spec,
};
pub use run::{Calibrated, Discrepancy};

use std::sync::Arc;

use serde_json::Value;

use crate::job::JobError;
use crate::job::Runnable;
use crate::job::calibrate::{self, Calibrate, Inputs};
use crate::job::key_number::KeyNumber;
use crate::job::kind::JobKind;
use crate::job::ready::{Readiness, Shared};
use crate::study::blocked::{blocked, draws_among};
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::resolve::scope::Scope;
use crate::study::resolved::Blocked;
use crate::study::{self, Pass};
use form::DiscrepancyForm;
use joint::Together;

/// The kind `discrepancy`.
#[derive(Clone, Copy, Debug)]
pub struct Kind;

impl JobKind for Kind {
    const NAME: &'static str = "discrepancy";
    const ABOUT: &'static str = "What the calibrated model leaves unexplained.";
    type Form = DiscrepancyForm;
    type Spec = Spec;
    type Output = Output;

    fn resolve(form: &DiscrepancyForm, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        resolve::resolve(scope, entry, form, asked)
    }

    fn key_numbers(output: &Output) -> Vec<KeyNumber> {
        output.joint.as_ref().map_or_else(Vec::new, |joint| joint.key_numbers.clone())
    }

    fn ready(spec: &Spec, shared: &Shared, name: &str) -> Result<Readiness, JobError> {
        let (spec, model, measurements) = (spec.clone(), Arc::clone(&shared.model), Arc::clone(&shared.measurements));
        let (from, seed, name) = (vec![spec.calibration.clone()], shared.pass.seed, name.to_owned());
        let together = if spec.is_joint { Some(calibration(&spec, shared)?) } else { None };
        let inputs = Inputs::of(shared);
        let make = move || -> Result<Discrepancy, JobError> {
            let job = Discrepancy::new(spec.clone(), Arc::clone(&model), Arc::clone(&measurements), seed, &name)?;
            let Some(calibration) = &together else { return Ok(job) };
            let calibration = Calibrate::new(calibration.clone(), inputs.clone(), seed, &spec.calibration.job)?;
            Ok(job.with_together(Together::new(&spec, calibration, &measurements)?))
        };
        let unprepared: Arc<dyn Runnable> = Arc::new(make()?);
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            let result = results.first().ok_or_else(|| JobError::Failed("a result is not there".to_owned()))?;
            let job = make()?;
            let calibrated = Calibrated::from_result(&job.spec.source, result)?;
            Ok(Arc::new(job.with_calibrated(calibrated)))
        };
        Ok(Readiness::after(from, unprepared, Box::new(prepare)))
    }
}

/// The settings of the calibration of the pass whose parameters are inferred together with the discrepancies.
fn calibration(spec: &Spec, shared: &Shared) -> Result<calibrate::Spec, JobError> {
    let named = shared.pass.jobs.iter().find(|named| named.name == spec.calibration.job);
    let own: Option<&calibrate::Spec> = named.and_then(|named| named.spec.get());
    let own = own.ok_or_else(|| JobError::Failed(format!("the calibration {} is not there", spec.source)))?;
    if let Some(draws) = draws_among(shared.pass, &own.parameters).first() {
        return Err(JobError::Failed(format!(
            "the mode `joint` takes priors that are distributions, and some of {} are the posterior of {}: take the mode `modular`",
            spec.source, draws.draws.source
        )));
    }
    Ok(own.clone())
}

impl study::job::Spec for Spec {
    fn kind(&self) -> &'static str {
        Kind::NAME
    }

    fn blocked(&self, pass: &Pass) -> Option<Blocked> {
        let own = if self.calibration.file == pass.file { blocked(pass, &self.calibration.job) } else { None };
        own.or_else(|| self.blocked.clone()).map(|blocked_job| blocked_job.after(&self.source))
    }
}
