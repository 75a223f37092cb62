//! The draws of a calibration for other programs: read back from the cache, completed by what they predict, written as
//! netCDF, NPY or CSV. Which job is exported and where to is the caller's.

pub mod csv;
mod netcdf;
pub mod npy;

use std::path::Path;
use std::sync::Arc;

use serde_json::Value;

use super::archive::study_name;
use super::{BatchError, Executed, LoadedPass};
use crate::job::calibrate::{Calibrate, Drawn, LeftOut, POSTERIOR, PRIOR, Replicates, Thinned};
use crate::job::dataset::{Attribute, Dataset};
use crate::job::{Job, JobError, Runnable};
use crate::runner::cache::Lookup;
use crate::runner::engine::pool;
use crate::runner::interrupt::Interrupts;
use crate::runner::replay::{Replayed, replay};
use crate::runner::stored::Stored;
use crate::runner::{Cache, Key, Kind, Settings};
use crate::study::file::{self, Existing};
use crate::thermal::External;

/// Draws whose readings are predicted together.
const BLOCK: usize = 64;
/// Most bytes of predicted readings and log likelihoods.
const MOST_BYTES: u64 = 1 << 30;

/// How arrays are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// One netCDF-4 file with a group for each group.
    NetCdf,
    /// A folder with an NPY file an array, and `index.json`.
    Npy,
    /// A folder with a CSV file a group.
    Csv,
}

/// What of a calibration is exported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// What an entry of the log likelihood stands for.
    pub left_out: LeftOut,
    /// Every so many draws of each chain have predicted readings and log likelihoods.
    pub thin: usize,
}

/// A finished calibration, as its pass has it.
pub struct Calibration<'e> {
    job: Arc<dyn Runnable>,
    key: &'e Key,
    pass: &'e LoadedPass,
    name: &'e str,
    stages: Vec<Replayed>,
}

/// The calibration of this name, with its draws from the cache; `None` where these are not there, though the result may
/// be, as after a pruning of the cache.
///
/// # Errors
/// A job without a result; stored draws of another form.
pub fn calibration<'e>(
    executed: &'e Executed,
    pass: &'e LoadedPass,
    name: &'e str,
    cache: &Cache,
) -> Result<Option<Calibration<'e>>, BatchError> {
    let plan = &executed.plan;
    let found = executed.results(pass).find(|(position, _)| plan.nodes()[*position].name == name);
    let Some((position, finished)) = found else {
        return Err(BatchError::job(format!("`{name}` has no result")));
    };
    let node = &plan.nodes()[position];
    // Where the job itself was in the cache, nothing asked for those that it builds upon.
    let upstream = plan.upstream(position).iter().map(|&other| {
        let finished = executed.summary.finished(&plan.nodes()[other].id);
        let known = finished.map(|finished| Arc::clone(&finished.stored.value));
        known.or_else(|| match cache.get(Kind::Result, &plan.keys()[other]) {
            Lookup::Found(bytes) => Stored::from_bytes(&bytes, &plan.nodes()[other].id).ok().map(|stored| stored.value),
            Lookup::Absent | Lookup::Damaged => None,
        })
    });
    let Some(upstream) = upstream.collect::<Option<Vec<Arc<Value>>>>() else { return Ok(None) };
    let failed = |error: JobError| BatchError::job(error.to_string());
    let job = node.task.prepare(&upstream).map_err(failed)?;
    let stages = replay(job.as_ref(), &finished.key, cache).map_err(failed)?;
    Ok(stages.map(|stages| Calibration { job, key: &finished.key, pass, name, stages }))
}

impl Calibration<'_> {
    /// The calibration's arrays. `None` where the run was asked to stop.
    ///
    /// # Errors
    /// A job of another kind; more predicted readings than are kept in memory, with what to choose instead.
    pub fn dataset(
        self,
        choice: Choice,
        settings: &Settings,
        interrupts: &Interrupts,
    ) -> Result<Option<Dataset>, BatchError> {
        let failed = |error: JobError| BatchError::job(error.to_string());
        let Some(job) = self.job.as_any().downcast_ref::<Calibrate>() else {
            return Err(BatchError::input(format!("`{}` is no calibration", self.name)));
        };
        let drawn = job.drawn(self.stages).map_err(failed)?;
        let thinned = Thinned(choice.thin);
        let draws = thinned.draws(&drawn);
        let needed = job.replicated_bytes(draws.len());
        if needed > MOST_BYTES {
            return Err(BatchError::input(format!(
                "what {} draws predict has {}, more than the {} that are exported: take every {}th draw with --thin {}",
                draws.len(),
                super::memory::bytes_text(needed),
                super::memory::bytes_text(MOST_BYTES),
                choice.thin as u64 * needed.div_ceil(MOST_BYTES),
                choice.thin as u64 * needed.div_ceil(MOST_BYTES),
            )));
        }
        let before: Vec<(u64, Vec<f64>)> = (0..).zip(drawn.prior.iter().cloned()).collect();
        let replicates = |of: &str, draws: &[(u64, Vec<f64>)]| replicates(job, &drawn, of, draws, settings, interrupts);
        let (Some(posterior), Some(prior)) = (replicates(POSTERIOR, &draws)?, replicates(PRIOR, &before)?) else {
            return Ok(None);
        };
        if let Some(reason) = Job::external(job).and_then(External::broken) {
            return Err(BatchError::job(reason));
        }
        let mut dataset = job.inference_data(&drawn, thinned, choice.left_out, &posterior, &prior).map_err(failed)?;
        let text = |text: &str| Attribute::Text(text.to_owned());
        dataset.attributes = vec![
            ("inference_library", text("bmv")),
            ("inference_library_version", text(env!("CARGO_PKG_VERSION"))),
            ("study", Attribute::Text(study_name(&self.pass.study))),
            ("pass", text(&self.pass.file)),
            ("job", text(self.name)),
            ("job_key", text(self.key.as_str())),
            ("algorithm_version", Attribute::Whole(self.job.algorithm_version().into())),
            ("seed", Attribute::Text(self.pass.pass.seed.to_string())),
            ("units", text("SI")),
        ];
        Ok(Some(dataset))
    }
}

/// What draws predict, in their order. `None` where the run was asked to stop.
fn replicates(
    job: &Calibrate,
    drawn: &Drawn,
    of: &str,
    draws: &[(u64, Vec<f64>)],
    settings: &Settings,
    interrupts: &Interrupts,
) -> Result<Option<Replicates>, BatchError> {
    let blocks: Vec<&[(u64, Vec<f64>)]> = draws.chunks(BLOCK).collect();
    let of_blocks =
        interrupts.during(|stop| pool::map(settings, stop, &blocks, |block| job.replicates(drawn, of, block)))?;
    let Some(of_blocks) = of_blocks else { return Ok(None) };
    let mut all = Replicates::default();
    for block in of_blocks {
        all.readings.extend(block.readings);
        all.log_likelihoods.extend(block.log_likelihoods);
    }
    Ok(Some(all))
}

/// Writes arrays to a file, or to files of a folder. What is there is left as it is.
///
/// # Errors
/// Something that is there already; what a format cannot hold; a refusal of the system.
pub fn write(dataset: &Dataset, format: Format, out: &Path) -> Result<(), BatchError> {
    let files = match format {
        Format::NetCdf => vec![(None, netcdf::bytes(dataset)?)],
        Format::Npy => in_folder(npy::files(dataset)?),
        Format::Csv => in_folder(csv::files(dataset)),
    };
    let refused = |path: &Path, error: std::io::Error| match error.kind() {
        std::io::ErrorKind::AlreadyExists => {
            BatchError::input(format!("`{}` is there already: name another --out", path.display()))
        }
        _ => BatchError::job(format!("cannot write `{}`: {error}", path.display())),
    };
    if format != Format::NetCdf && !file::is_free(out).map_err(|error| refused(out, error))? {
        return Err(refused(out, std::io::ErrorKind::AlreadyExists.into()));
    }
    for (name, bytes) in files {
        let (base, relative) = match &name {
            Some(name) => (out, Path::new(name)),
            None => (out.parent().unwrap_or(Path::new("")), Path::new(out.file_name().unwrap_or(out.as_os_str()))),
        };
        file::write(base, relative, &bytes, Existing::Keep).map_err(|error| refused(&base.join(relative), error))?;
    }
    Ok(())
}

/// Files of a folder, by their names in it.
fn in_folder(files: Vec<(String, Vec<u8>)>) -> Vec<(Option<String>, Vec<u8>)> {
    files.into_iter().map(|(name, bytes)| (Some(name), bytes)).collect()
}
