//! Model against measurements at given parameters: by sensor, by phase, against criteria, and in words.

mod block;
mod collected;
pub mod deviation;
mod form;
pub mod output;
pub mod readings;
mod readings_form;
mod resolve;
mod run;
pub mod stretch;
mod trend;
pub mod tuned;
pub mod view;
mod words;

pub use deviation::{KELVIN, deviation};
pub use output::{
    Deviation, FailedPhase, HeatBalance, Output, PhaseSummary, SensorSummary, Spec, StabilisationCheck, Trend,
    TunedSensor, TunedState, Verdict,
};
pub use readings::{Moment, Readings, Row, Table};
pub use run::{Compare, verdicts};
pub use tuned::Tuned;
pub use view::view;

use std::sync::Arc;

use serde_json::{Value, json};

use crate::document::Place;
use crate::job::JobError;
use crate::job::Runnable;
use crate::job::array::{Array, Arrays};
use crate::job::key_number::KeyNumber;
use crate::job::kind::JobKind;
use crate::job::ready::{Readiness, Shared};
use crate::study::blocked::blocked;
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::job::{Comparison, Forms, NamedJob};
use crate::study::resolve::scope::Scope;
use crate::study::resolve::settings::Offered;
use crate::study::resolved::Blocked;
use crate::study::resolved::Upstream;
use crate::study::{self, Pass};
use crate::thermal::Derivatives;
use form::CompareForm;

/// Share by which the error of the tuned state may differ with another seed, whose search for the most probable point begins
/// elsewhere.
const TUNED_TOLERANCE: f64 = 1e-4;

/// The kind `compare`.
#[derive(Clone, Copy, Debug)]
pub struct Kind;

impl JobKind for Kind {
    const NAME: &'static str = "compare";
    const ABOUT: &'static str = "Model against measurements.";
    type Form = CompareForm;
    type Spec = Spec;
    type Output = Output;

    fn resolve(form: &CompareForm, scope: &mut Scope, entry: &Entry, asked: &mut Asked) -> Option<JobSpec> {
        resolve::resolve(scope, entry, form, asked.forms, asked.offered)
    }

    fn complete(jobs: &mut Vec<NamedJob>, forms: &Forms, offered: &Offered, measured: Option<&Place>) {
        jobs.extend(resolve::implied(jobs, offered, measured));
        resolve::show_calibrations(jobs, forms);
    }

    fn document(output: &Output, _with_rows: bool) -> Result<Value, JobError> {
        Ok(view(output))
    }

    fn rows(output: &Output) -> Option<Box<dyn Iterator<Item = Value> + '_>> {
        Some(Box::new(output.rows.iter().map(|row| json!(row))))
    }

    fn arrays(output: &Output) -> Vec<(String, Array)> {
        output.rows.arrays()
    }

    fn fill(output: &mut Output, arrays: &Arrays) -> Result<(), String> {
        output.rows.fill(arrays)
    }

    fn without_rows(output: &Output) -> Option<Output> {
        Some(Output { rows: Readings::default(), ..output.clone() })
    }

    fn key_numbers(output: &Output) -> Vec<KeyNumber> {
        let delivered = |(of, deviation): (String, &Deviation), unit: &str| {
            (deviation.count > 0).then(|| KeyNumber::exact(of, "rmse", unit, deviation.rmse))
        };
        let tuned = |(of, deviation): (&str, &Deviation), unit: &str| {
            let tolerance = TUNED_TOLERANCE * deviation.rmse;
            (deviation.count > 0).then(|| KeyNumber::searched(of, "rmse", unit, deviation.rmse, tolerance))
        };
        let unit = output.sensors.first().map_or("", |sensor| sensor.unit.as_str());
        let whole = [("readings to be fitted", &output.train), ("readings held out", &output.held_out)];
        let mut numbers: Vec<KeyNumber> =
            whole.iter().filter_map(|(of, all)| delivered(((*of).to_owned(), all), unit)).collect();
        if let Some(own) = &output.tuned {
            let whole = [("readings fitted, tuned", &own.train), ("readings held out, tuned", &own.held_out)];
            numbers.extend(whole.into_iter().filter_map(|pair| tuned(pair, unit)));
        }
        for sensor in &output.sensors {
            let of = format!("{} of {}", sensor.sensor, sensor.measurement);
            numbers.extend(delivered((of.clone(), &sensor.train), &sensor.unit));
            numbers.extend(delivered((format!("{of}, held out"), &sensor.held_out), &sensor.unit));
        }
        numbers
    }

    fn refuses_external(_spec: &Spec, _derivatives: Derivatives) -> Option<String> {
        None
    }

    fn ready(spec: &Spec, shared: &Shared, _name: &str) -> Result<Readiness, JobError> {
        let nominal: Vec<f64> = shared.pass.model.parameters.iter().map(|parameter| parameter.nominal).collect();
        let shown = spec.calibration.clone().filter(|name| !shared.refused.contains(name));
        let spec = Spec { calibration: shown.clone(), ..spec.clone() };
        let (model, measurements) = (Arc::clone(&shared.model), Arc::clone(&shared.measurements));
        let make = move || Compare::new(spec.clone(), Arc::clone(&model), Arc::clone(&measurements), nominal.clone());
        let untuned: Arc<dyn Runnable> = Arc::new(make()?);
        let Some(name) = shown else { return Ok(Readiness::Ready(untuned)) };
        let from = vec![Upstream { file: shared.pass.file.clone(), job: name.clone() }];
        let prepare = move |results: &[Arc<Value>]| -> Result<Arc<dyn Runnable>, JobError> {
            let result = results.first().ok_or_else(|| JobError::Failed("a result is not there".to_owned()))?;
            Ok(Arc::new(make()?.with_tuned(Tuned::from_result(&name, result)?)))
        };
        Ok(Readiness::after(from, untuned, Box::new(prepare)))
    }
}

impl study::job::Spec for Spec {
    fn kind(&self) -> &'static str {
        Kind::NAME
    }

    fn comparison(&self) -> Option<Comparison<'_>> {
        Some(Comparison {
            data: &self.data,
            stabilisation_k_per_s: self.criteria.stabilisation_k_per_s,
            calibration: self.calibration.as_deref(),
        })
    }

    fn blocked(&self, pass: &Pass) -> Option<Blocked> {
        // A sensor without noise keeps a calibration from running, not the comparison that would show it.
        let is_refused = |name: &&String| pass.refused.iter().any(|refused| refused.job == **name);
        let calibration = self.calibration.as_ref().filter(|name| !is_refused(name))?;
        let runs = pass.jobs.iter().any(|other| other.name == *calibration && other.spec.resolved().is_some());
        let calibration_blocked = if runs { blocked(pass, calibration)? } else { Blocked::waits(String::new()) };
        Some(Blocked {
            reason: format!("it shows the tuned state of `{calibration}`, which does not run"),
            ..calibration_blocked
        })
    }
}
