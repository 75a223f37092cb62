//! Draws that stand in for priors: which calibration or file gives them, for which parameters, and the data behind them.

use std::collections::HashSet;
use std::sync::Arc;

use crate::document::{Diagnostic, Place, Prior, Sense, Spanned, code, counted, suggest};
use crate::inference::likelihood::rows::used_rows;
use crate::math::functions::{exp, ln};
use crate::random::Distribution;
use crate::statistics::moments::Moments;
use crate::study::blocked::blocked;
use crate::study::inherit::{folder_diagnostic_at, plain_name};
use crate::study::job::{CALIBRATION, Inference, JobSpec};
use crate::study::posterior_prior::PosteriorPrior;
use crate::study::reader::Reader;
use crate::study::resolved::{DataBehind, Pass, PosteriorReference, Upstream};
use crate::study::table::Cells;

use super::data::{self, Wanted};
use super::scope::{Scope, unit_of};

/// Most passes that hand their posteriors on, one to the next.
const MOST_HANDED_ON: usize = 50;

/// The passes whose calibrations a pass uses.
pub struct Upstreams<'a> {
    reader: &'a Reader,
    /// Files of the passes that are being read, each because the one before uses it; the last is the pass itself.
    chain: &'a [String],
    /// The passes that were read.
    pub passes: Vec<Arc<Pass>>,
}

impl<'a> Upstreams<'a> {
    /// None yet, of the last pass of the chain.
    pub fn new(reader: &'a Reader, chain: &'a [String]) -> Self {
        Self { reader, chain, passes: Vec::new() }
    }

    /// A pass of the study by its file; reported where it cannot be used.
    pub fn pass(&mut self, scope: &mut Scope, file: &str, place: &Place) -> Option<Arc<Pass>> {
        let file = plain_name(file);
        if let Some(loaded) = self.passes.iter().find(|pass| pass.file == file) {
            return Some(Arc::clone(loaded));
        }
        if let Some(position) = self.chain.iter().position(|chain_file| *chain_file == file) {
            let way = self.chain[position..].join(" -> ");
            let message = if position + 1 == self.chain.len() {
                format!("`{file}` cannot take its own posterior as a prior")
            } else {
                format!("the posteriors run in a circle: {way} -> {file}")
            };
            scope.error(&code::POSTERIOR, place, message, "an earlier pass");
            return None;
        }
        if let Err(error) = self.reader.tree(scope.folder, &file) {
            scope.diagnostics.push(folder_diagnostic_at(&error, place));
            return None;
        }
        let loaded = if self.chain.len() > MOST_HANDED_ON {
            None
        } else {
            Some(self.reader.load_in_chain(&scope.folder.shown().join(&file), self.chain))
        };
        match loaded {
            // A pass may have been read before, as a shorter chain.
            Some(Ok(pass)) if pass.handed_on_depth < MOST_HANDED_ON => {
                self.passes.push(Arc::clone(&pass));
                Some(pass)
            }
            Some(Ok(_)) | None => {
                let message = format!("more than {MOST_HANDED_ON} passes hand their posteriors on, one to the next");
                let help = "calibrate on all data at once, from the original priors";
                scope.diagnostics.push(Diagnostic::error(&code::TOO_LONG_CHAIN, place, message).help(help));
                None
            }
            Some(Err(diagnostics)) => {
                scope.error(&code::POSTERIOR, place, format!("`{file}` has errors of its own"), "");
                scope.diagnostics.extend(&diagnostics);
                None
            }
        }
    }

    /// How many passes hand their posteriors on, one to the next, up to the one that is being read.
    pub fn depth(&self) -> usize {
        self.passes.iter().map(|pass| pass.handed_on_depth + 1).max().unwrap_or(0)
    }
}

/// The settings of a calibration of a pass; reported where there is none. `None` within where it waits for data.
pub fn calibration<'p>(scope: &mut Scope, pass: &'p Pass, job: &str, place: &Place) -> Option<Option<Inference<'p>>> {
    match pass.jobs.iter().find(|named_job| named_job.name == job).map(|named_job| &named_job.spec) {
        Some(JobSpec::Resolved(spec)) if spec.kind() == CALIBRATION => Some(spec.inference()),
        Some(other) if other.kind() == CALIBRATION => Some(None),
        Some(other) => {
            let message = format!("`{job}` of `{}` is a `{}` job", pass.file, other.kind());
            scope.error(&code::POSTERIOR, place, message, "a `calibrate` job");
            None
        }
        None => {
            let calibrations = pass.jobs.iter().filter(|named_job| named_job.spec.kind() == CALIBRATION);
            let job_names: Vec<&str> = calibrations.map(|named_job| named_job.name.as_str()).collect();
            scope.unknown(&code::POSTERIOR, &format!("calibration of `{}`", pass.file), job, place, &job_names);
            None
        }
    }
}

/// The readings behind a calibration: its own, and those behind its priors, each measurement of a calibration once.
pub fn behind(pass: &Pass, job: &str, spec: Inference<'_>) -> Vec<DataBehind> {
    let calibration = Upstream { file: pass.file.clone(), job: job.to_owned() };
    let fitted_data = spec.data.iter().map(|&index| DataBehind {
        calibration: calibration.clone(),
        measurement: pass.measurements[index].name.clone(),
        rows: Arc::new(used_rows(&pass.measurements[index])),
    });
    let handed = pass
        .posterior_priors
        .iter()
        .filter(|reference| reference.draws.parameters.iter().any(|p| spec.parameters.contains(p)));
    let mut seen = HashSet::new();
    fitted_data
        .chain(handed.flat_map(|reference| reference.behind.clone()))
        .filter(|data_behind| seen.insert((data_behind.calibration.clone(), data_behind.measurement.clone())))
        .collect()
}

/// The draws of a calibration, no parameter chosen yet.
pub fn of_calibration(pass: &Pass, job: &str, place: &Place, spec: Option<Inference<'_>>) -> PosteriorReference {
    PosteriorReference {
        draws: PosteriorPrior {
            source: format!("`{job}` of `{}`", pass.file),
            parameters: Vec::new(),
            names: Vec::new(),
            sha256: None,
            draws: Vec::new(),
            effective: 0.0,
            converged: true,
        },
        from: Some(Upstream { file: pass.file.clone(), job: job.to_owned() }),
        blocked: blocked(pass, job),
        behind: spec.map_or_else(Vec::new, |spec| behind(pass, job, spec)),
        place: place.clone(),
    }
}

/// Looks up all draws that stand in for priors; `priors` gets the original priors in their place.
pub fn resolve(scope: &mut Scope, upstreams: &mut Upstreams, priors: &mut [Distribution]) -> Vec<PosteriorReference> {
    let mut references: Vec<PosteriorReference> = Vec::new();
    let mut files: Vec<(String, Place, Vec<usize>)> = Vec::new();
    for index in 0..priors.len() {
        match scope.resolved.priors[index].clone() {
            Prior::Distribution(_) => {}
            Prior::Posterior { pass, job, place } => {
                posterior(scope, upstreams, priors, &mut references, index, (&pass, &job, &place));
            }
            Prior::Draws { file, place } => match files.iter_mut().find(|(listed_file, ..)| *listed_file == file) {
                Some((_, _, parameters)) => parameters.push(index),
                None => files.push((file, place, vec![index])),
            },
        }
    }
    for (file, place, parameters) in files {
        references.extend(from_file(scope, priors, file, place, parameters));
    }
    references
}

fn posterior(
    scope: &mut Scope,
    upstreams: &mut Upstreams,
    priors: &mut [Distribution],
    found: &mut Vec<PosteriorReference>,
    index: usize,
    (file, job, place): (&str, &str, &Place),
) {
    let Some(pass) = upstreams.pass(scope, file, place) else { return };
    let Some(spec) = calibration(scope, &pass, job, place) else { return };
    let name = scope.resolved.model.parameters[index].name.clone();
    let position = pass.model.parameters.iter().position(|parameter| parameter.name == name);
    let inferred = |position: &usize| spec.is_none_or(|spec| spec.parameters.contains(position));
    let Some(position) = position.filter(inferred) else {
        let message = format!("`{job}` of `{}` did not infer `{name}`", pass.file);
        let all = spec.map(|spec| spec.parameters).unwrap_or_default();
        let inferred_names: Vec<&str> =
            all.iter().map(|&inferred_index| pass.model.parameters[inferred_index].name.as_str()).collect();
        let expected = format!("it inferred {}", suggest::listed(inferred_names.iter().copied(), 12));
        let help = format!("give `{name}` a distribution, or name a calibration that inferred it");
        scope.diagnostics.push(Diagnostic::error(&code::POSTERIOR, place, message).expected(expected).help(help));
        return;
    };
    let dimension = unit_of(&pass.model.parameters[position].unit).dimension;
    if scope.resolved.parameter_scales[index]
        .dimension()
        .is_some_and(|declared_dimension| declared_dimension != dimension)
    {
        let message = format!("`{name}` of `{}` is in {dimension}", pass.file);
        scope.error(&code::POSTERIOR, place, message, "a parameter of the same kind");
        return;
    }
    priors[index] = pass.priors[position];
    let upstream = Upstream { file: pass.file.clone(), job: job.to_owned() };
    let matching = match found.iter().position(|reference| reference.from.as_ref() == Some(&upstream)) {
        Some(reference_index) => &mut found[reference_index],
        None => {
            found.push(of_calibration(&pass, job, place, spec));
            let last = found.len() - 1;
            &mut found[last]
        }
    };
    matching.draws.parameters.push(index);
    matching.draws.names.push(name);
}

fn from_file(
    scope: &mut Scope,
    priors: &mut [Distribution],
    file: String,
    place: Place,
    parameters: Vec<usize>,
) -> Option<PosteriorReference> {
    let data = data::data(scope, &Spanned { value: file.clone(), place: place.clone() }, b',', None).ok()??;
    let names: Vec<String> = parameters.iter().map(|&p| scope.resolved.model.parameters[p].name.clone()).collect();
    let wanted: Vec<Wanted> = (parameters.iter().zip(&names))
        .map(|(&parameter, name)| Wanted {
            name,
            place: &place,
            dimension: scope.resolved.parameter_scales[parameter].dimension(),
            sense: Sense::Absolute,
            cells: Cells::Numbers,
            required: true,
        })
        .collect();
    let columns = data::numbers(scope, &data, &wanted).ok()?;
    let count = columns.first().map_or(0, Vec::len);
    if count < 2 {
        scope.error(&code::DRAWS_FILE, &place, format!("`{file}` has {}", counted(count, "draw")), "two draws or more");
        return None;
    }
    for (&parameter, column) in parameters.iter().zip(&columns) {
        priors[parameter] = scale_of(column);
    }
    Some(PosteriorReference {
        draws: PosteriorPrior {
            source: format!("`{file}`"),
            parameters,
            names,
            sha256: Some(data.sha256),
            draws: (0..count).map(|row| columns.iter().map(|column| column[row]).collect()).collect(),
            effective: count as f64,
            converged: true,
        },
        from: None,
        blocked: None,
        behind: Vec::new(),
        place,
    })
}

/// The prior by which the scores of draws from a file are taken, whose own is not known: normal or lognormal, in which
/// they are less skewed.
fn scale_of(draws: &[f64]) -> Distribution {
    let moments = Moments::of(draws);
    let plain = Distribution::Normal { mean: moments.mean(), sd: moments.sd(), lower: None, upper: None };
    if draws.iter().any(|draw| *draw <= 0.0) {
        return plain;
    }
    let logarithms: Vec<f64> = draws.iter().map(|draw| ln(*draw)).collect();
    let moments = Moments::of(&logarithms);
    if skewness(&logarithms).abs() < skewness(draws).abs() {
        Distribution::LogNormal { median: exp(moments.mean()), factor: exp(moments.sd()) }
    } else {
        plain
    }
}

fn skewness(values: &[f64]) -> f64 {
    let moments = Moments::of(values);
    let cubes = values.iter().map(|value| {
        let deviation = (value - moments.mean()) / moments.sd();
        deviation * deviation * deviation
    });
    cubes.sum::<f64>() / values.len() as f64
}
