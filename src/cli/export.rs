//! `bmv export`.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::execute::execute;
use super::options::{CachedRunOptions, RunOptions};
use super::output::{escaped, print, shown, tell};
use super::status::{Failure, Status};
use super::{Context, select};
use crate::batch::export::{self, Choice};
use crate::job::calibrate::LeftOut;

/// The kind of the jobs.
const KIND: &str = "calibrate";

/// Arguments of `bmv export`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "A netCDF file holds the groups of ArviZ' InferenceData: az.from_netcdf(FILE) reads it, and az.summary, az.loo, \
                  az.compare and az.plot_ppc take it as it is. All numbers are in SI units. The same study gives the same bytes."
)]
pub(super) struct Export {
    /// Pass file
    pass: PathBuf,
    /// Name of a job of kind `calibrate` [default: the first]
    #[arg(long, value_name = "NAME")]
    job: Option<String>,
    /// File (of npy and csv: folder) to write, which must not be there yet
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// How it is written [default: nc]
    #[arg(long, value_enum, default_value_t = Written::Nc, hide_default_value = true)]
    format: Written,
    /// What an entry of the log likelihood stands for [default: reading]
    #[arg(long, value_enum, default_value_t = By::Reading, hide_default_value = true)]
    by: By,
    /// Predicted readings and log likelihoods of every Nth draw of each chain alone [default: 1]
    #[arg(long, value_name = "N")]
    thin: Option<NonZeroUsize>,
    #[command(flatten)]
    options: CachedRunOptions,
}

/// A format's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Written {
    /// netCDF-4, as ArviZ reads it
    Nc,
    /// A folder of NPY files with index.json
    Npy,
    /// A folder of CSV files
    Csv,
}

/// What the log likelihood is stated by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum By {
    /// Every reading
    Reading,
    /// Every steady phase with all its readings
    Phase,
}

impl Export {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let path = select::one_pass(&self.pass)?;
        let wanted = select::job_of_kind(&path, KIND, self.job.as_deref(), context.coloured)?;
        refuse_existing(&self.out)?;
        let options: RunOptions = self.options.into();
        let run = |options: &RunOptions| {
            execute(std::slice::from_ref(&self.pass), options, context, |kind, name| kind == KIND && name == wanted)
        };
        let mut executed = run(&options)?;
        let mut status = Status::of_wanted(&executed);
        if !matches!(status, Status::Done | Status::NotConverged) {
            return Ok(status);
        }
        let cache = options.cache.cache(&executed.passes);
        let has_draws = |executed: &crate::batch::Executed| -> Result<bool, Failure> {
            let Some(pass) = executed.passes.first() else { return Ok(false) };
            Ok(export::calibration(executed, pass, &wanted, &cache)?.is_some())
        };
        if !has_draws(&executed)? {
            tell(&format!("the cache has the result of `{}` without its draws: it is sampled again", escaped(&wanted)));
            executed = run(&options.clone().forced())?;
            status = Status::of_wanted(&executed);
            if !matches!(status, Status::Done | Status::NotConverged) {
                return Ok(status);
            }
        }
        for pass in &executed.passes {
            let Some(calibration) = export::calibration(&executed, pass, &wanted, &cache)? else {
                return Err(Failure::job(
                    "the draws cannot be kept: the cache cannot be written; name one with --cache DIR",
                ));
            };
            let choice = Choice {
                left_out: match self.by {
                    By::Reading => LeftOut::Reading,
                    By::Phase => LeftOut::Phase,
                },
                thin: self.thin.map_or(1, NonZeroUsize::get),
            };
            let Some(dataset) = calibration.dataset(choice, &options.settings(), &context.interrupts)? else {
                return Ok(Status::Interrupted);
            };
            let format = match self.format {
                Written::Nc => export::Format::NetCdf,
                Written::Npy => export::Format::Npy,
                Written::Csv => export::Format::Csv,
            };
            export::write(&dataset, format, &self.out)?;
            print(&format!("{}\n", shown(&self.out)))?;
            if status == Status::NotConverged {
                tell(&format!("warning: the sampler of `{}` did not converge", escaped(&wanted)));
            }
        }
        Ok(status)
    }
}

/// Refuses what is there before anything runs.
fn refuse_existing(out: &Path) -> Result<(), Failure> {
    match out.symlink_metadata() {
        Ok(_) => Err(Failure::input(format!("`{}` is there already: name another --out", shown(out)))),
        Err(_) => Ok(()),
    }
}
