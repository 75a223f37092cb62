//! The error of a study's passes, one after another: as delivered and tuned, on the readings for fitting and on those
//! held out. Everything is taken from results of comparisons and calibrations.

use serde::{Deserialize, Serialize};

use crate::document::hash::sha256_hex_of;
use crate::job::calibrate;
use crate::job::compare::{self, Deviation};
use crate::study::Pass;
use crate::study::job::CALIBRATION;

use super::ladder::{Standing, standings};

/// A number of the readings for fitting and of those held out; `None` where there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Split {
    /// Of the readings for fitting.
    pub train: Option<f64>,
    /// Of those held out.
    pub held_out: Option<f64>,
}

/// A number of the model as delivered and as tuned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct States {
    /// At the nominal parameters of the pass's model.
    pub delivered: Split,
    /// At those of the pass's calibration.
    pub tuned: Split,
}

/// Numbers of readings in kelvin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Readings {
    /// For fitting.
    pub train: u64,
    /// Held out.
    pub held_out: u64,
}

/// Whether a field is left out.
fn is_false(value: &bool) -> bool {
    !value
}

/// A pass of a study.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PassErrors {
    /// Its file.
    pub pass: String,
    /// Its title.
    pub title: String,
    /// Its parent's file.
    pub parent: Option<String>,
    /// Ids of all effects that its model adopts.
    pub adopted: Vec<String>,
    /// Ids of those that its parent's does not.
    pub added: Vec<String>,
    /// Root mean square of measured minus predicted over sensors in kelvin, K.
    pub rmse_k: States,
    /// Whether the tuned error is that of the fit with which a diagnosis begins: the pass calibrates nothing.
    #[serde(default, skip_serializing_if = "is_false")]
    pub is_tuned_by_diagnosis: bool,
    /// Mean of the same, K.
    pub mean_k: States,
    /// Share of readings within the limit for one reading.
    pub within_limit: States,
    /// That limit, K, where the criteria have one.
    pub limit_k: Option<f64>,
    /// Name of the criteria.
    pub criteria: Option<String>,
    /// Sum of squares of the whitened residuals at the most probable point over the degrees of freedom.
    pub reduced_chi2: Option<f64>,
    /// Natural logarithm of the calibration's evidence.
    pub log_evidence: Option<f64>,
    /// Its standard error.
    pub log_evidence_sd: Option<f64>,
    /// Whether value and error are to be trusted.
    pub log_evidence_is_trusted: Option<bool>,
    /// Whether the calibration's sampler converged.
    pub converged: Option<bool>,
    /// What mends it where it did not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
    /// Probability that noise alone leaves so large a misfit as the calibration does.
    #[serde(skip)]
    pub p_value: Option<f64>,
    /// Numbers of readings.
    pub readings: Readings,
    /// Hash of the readings themselves; two passes' errors are held against one another only where they have the same.
    #[serde(skip)]
    pub readings_sha256: Option<String>,
    /// The model as delivered and, where it was tuned, tuned, against the criteria.
    #[serde(skip)]
    pub standings: Vec<Standing>,
    /// The comparison, if the pass has a result of one.
    pub comparison: Option<String>,
    /// The calibration, likewise.
    pub calibration: Option<String>,
    /// Kinds of jobs that the pass would need for its error to be stated, and does not have.
    pub missing: Vec<String>,
}

/// Of a comparison and a calibration, which a pass with measurements does not have.
fn missing(pass: &Pass) -> Vec<String> {
    let has = |kind: &str| pass.jobs.iter().any(|job| job.spec.kind() == kind);
    let is_measured = !pass.measurements.is_empty();
    ["compare", "calibrate"].into_iter().filter(|kind| is_measured && !has(kind)).map(str::to_owned).collect()
}

impl PassErrors {
    /// What its state at nominal parameters is: the model as it was delivered, or with effects that it has adopted.
    pub fn untuned_in_words(&self) -> String {
        match self.adopted.as_slice() {
            [] => "as delivered".to_owned(),
            ids => format!("with {} at nominal size", ids.join(", ")),
        }
    }

    /// What its tuned state is.
    pub fn tuned_in_words(&self) -> String {
        let by = if self.is_tuned_by_diagnosis { " by the diagnosis" } else { "" };
        match self.adopted.as_slice() {
            [] => format!("tuned only{by}"),
            ids => format!("tuned{by} with {}", ids.join(", ")),
        }
    }

    /// A pass with the results by which it is judged, each with its job's name; `parent` is the pass before it.
    pub fn new(
        pass: &Pass,
        parent: Option<&Pass>,
        comparison: Option<(&str, &compare::Output)>,
        calibration: Option<(&str, &calibrate::Output)>,
        diagnosis: Option<&crate::diagnosis::Output>,
    ) -> Self {
        let adopted: Vec<String> = pass.adopted.iter().map(|effect| effect.id.clone()).collect();
        let before: Vec<&String> = parent.iter().flat_map(|parent| &parent.adopted).map(|effect| &effect.id).collect();
        let mut errors = Self {
            pass: pass.file.clone(),
            title: pass.title.clone(),
            parent: pass.parents.first().cloned(),
            added: adopted.iter().filter(|id| !before.contains(id)).cloned().collect(),
            adopted,
            missing: missing(pass),
            ..Self::default()
        };
        if let Some((name, output)) = comparison {
            errors.compared(output);
            errors.comparison = Some(name.to_owned());
        }
        if let Some((name, output)) = calibration {
            errors.reduced_chi2 = output.reduced_chi_square();
            errors.log_evidence = output.log_evidence.value;
            errors.log_evidence_sd = output.log_evidence.sd;
            errors.log_evidence_is_trusted = output.log_evidence.value.map(|_| output.log_evidence.is_trusted());
            errors.converged = Some(output.converged);
            errors.p_value = output.p_value;
            errors.remedy = output.remedy().map(|remedy| remedy.in_words(name));
            errors.calibration = Some(name.to_owned());
        }
        let tuned = diagnosis.map(|output| output.misfit.rmse_k).filter(|_| errors.rmse_k.tuned == Split::default());
        if let Some(tuned) = tuned {
            errors.rmse_k.tuned = Split { train: tuned.train, held_out: tuned.held_out };
            errors.is_tuned_by_diagnosis = true;
            errors.missing.retain(|kind| kind != CALIBRATION);
        }
        errors
    }

    fn compared(&mut self, output: &compare::Output) {
        self.criteria = Some(output.criteria.name.clone());
        // Statistics over several sensors are of those in kelvin, where there are any.
        if !output.sensors.iter().any(|sensor| sensor.unit == "K") {
            return;
        }
        self.limit_k = output.criteria.each_k;
        self.readings_sha256 = Some(readings_sha256(output));
        self.standings = standings(output);
        self.readings = Readings { train: output.train.count, held_out: output.held_out.count };
        let nothing = Deviation::default();
        let tuned = output.tuned.as_ref().map_or([&nothing, &nothing], |tuned| [&tuned.train, &tuned.held_out]);
        let states = |pick: fn(&Deviation) -> f64| {
            let of = |deviation: &Deviation| (deviation.count > 0).then(|| pick(deviation));
            let split = |[train, held_out]: [&Deviation; 2]| Split { train: of(train), held_out: of(held_out) };
            States { delivered: split([&output.train, &output.held_out]), tuned: split(tuned) }
        };
        self.rmse_k = states(|deviation| deviation.rmse);
        self.mean_k = states(|deviation| deviation.mean);
        if self.limit_k.is_some() {
            self.within_limit = states(|deviation| deviation.within_limit);
        }
    }

    /// Whether both errors are of the same readings, so that the one may be held against the other.
    pub fn has_readings_of(&self, other: &Self) -> bool {
        self.readings == other.readings && self.readings_sha256 == other.readings_sha256
    }

    /// Whether there is an error to be stated.
    pub fn is_measured(&self) -> bool {
        let is_stated = |split: &Split| split.train.is_some() || split.held_out.is_some();
        is_stated(&self.rmse_k.delivered) || is_stated(&self.rmse_k.tuned)
    }
}

/// Hash of what was read, where and when, and of what is held out; not of what was predicted.
fn readings_sha256(output: &compare::Output) -> String {
    sha256_hex_of(output.rows.iter().map(|row| {
        let mut bytes = Vec::new();
        for name in [row.measurement, row.phase.unwrap_or(""), row.sensor] {
            bytes.extend_from_slice(name.as_bytes());
            bytes.push(0);
        }
        bytes.extend_from_slice(&row.time_s.map_or(u64::MAX, f64::to_bits).to_le_bytes());
        bytes.extend_from_slice(&row.measured.to_bits().to_le_bytes());
        bytes.push(u8::from(row.held_out));
        bytes
    }))
}

/// The passes of a study, each after its parents.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct History {
    /// The passes.
    pub passes: Vec<PassErrors>,
}

impl History {
    /// The passes whose error is known.
    pub fn measured(&self) -> Vec<&PassErrors> {
        self.passes.iter().filter(|pass| pass.is_measured()).collect()
    }

    /// The nearest ancestor of a pass whose error is known.
    pub fn before(&self, pass: &PassErrors) -> Option<&PassErrors> {
        let mut parent = pass.parent.as_deref();
        // As many steps as there are passes: a circle ends too.
        for _ in &self.passes {
            let earlier = self.passes.iter().find(|other| Some(other.pass.as_str()) == parent)?;
            if earlier.is_measured() {
                return Some(earlier);
            }
            parent = earlier.parent.as_deref();
        }
        None
    }
}
