//! Runs on a cluster: options, and what `run`, `attach` and `collect` share.

use clap::{Args, ValueEnum};

use super::Context;
use super::execute::run_listened;
use super::options::{CacheOption, RunOptions};
use super::output::{print, tell};
use super::run::outcome;
use super::status::{Failure, Status};
use crate::batch::{self, Executed, Prepared};
use crate::runner::cluster::slurm::Slurm;
use crate::runner::cluster::{Driver, Mode, Options, RunFolder, RunRecord, Scheduler};
use crate::runner::{Cache, Listener, Settings};

/// Who computes the blocks of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum Engine {
    /// The threads of this machine
    #[default]
    Local,
    /// Arrays of shards on the cluster, through Slurm's commands
    Slurm,
}

/// How a run uses a cluster.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "On a cluster (--engine slurm)")]
pub(super) struct ClusterOptions {
    /// Shards of an array; a shard is a run of blocks [default: four a slot]
    #[arg(long, value_name = "N")]
    shards: Option<std::num::NonZeroUsize>,
    /// Most shards that run at a time
    #[arg(long, value_name = "N")]
    max_running: Option<std::num::NonZeroUsize>,
    /// Threads of a shard
    #[arg(long, short = 'c', value_name = "N", default_value = "1")]
    cpus_per_task: std::num::NonZeroUsize,
    /// Memory of a thread
    #[arg(long, value_name = "SIZE", default_value = "2G")]
    mem_per_cpu: String,
    /// Longest time of a shard
    #[arg(long, value_name = "TIME", default_value = "01:00:00")]
    time: String,
    /// Partition
    #[arg(long, value_name = "NAME")]
    partition: Option<String>,
    /// Account
    #[arg(long, value_name = "NAME")]
    account: Option<String>,
    /// Quality of service
    #[arg(long, value_name = "NAME")]
    qos: Option<String>,
    /// Features of nodes
    #[arg(long, value_name = "LIST")]
    constraint: Option<String>,
    /// Nodes that are not used
    #[arg(long, value_name = "NODE", value_delimiter = ',')]
    exclude: Vec<String>,
    /// Wait no longer than so many seconds for shards that will not start by themselves
    #[arg(long, value_name = "SECONDS")]
    pending_timeout: Option<u64>,
    /// Pause before a shard that failed is submitted again, doubled each time
    #[arg(long, value_name = "SECONDS", default_value_t = 30)]
    retry_delay: u64,
    /// Longest pause between two looks at the scheduler
    #[arg(long, value_name = "SECONDS", default_value_t = 30)]
    poll: u64,
    /// Submit and leave
    #[arg(long)]
    detach: bool,
    /// Submit and leave; a job of the cluster reduces what is there when the array has ended, and goes on
    #[arg(long)]
    finish_on_cluster: bool,
}

impl ClusterOptions {
    pub(super) fn mode(&self) -> Mode {
        if self.detach || self.finish_on_cluster { Mode::Detach } else { Mode::Wait }
    }

    /// The options, checked.
    pub(super) fn options(&self) -> Result<Options, Failure> {
        let named = [("partition", &self.partition), ("account", &self.account), ("qos", &self.qos)];
        for (name, value) in named {
            if value.as_ref().is_some_and(|value| value.is_empty() || value.starts_with('-')) {
                return Err(Failure::input(format!("--{name} needs a name")));
            }
        }
        Ok(Options {
            shards: self.shards.map(Into::into),
            max_running: self.max_running.map(Into::into),
            cpus_per_task: self.cpus_per_task.into(),
            mem_per_cpu: self.mem_per_cpu.clone(),
            time: self.time.clone(),
            partition: self.partition.clone(),
            account: self.account.clone(),
            qos: self.qos.clone(),
            constraint: self.constraint.clone(),
            exclude: self.exclude.clone(),
            pending_timeout_s: self.pending_timeout,
            retry_delay_s: self.retry_delay,
            poll_s: self.poll,
            finish_on_cluster: self.finish_on_cluster,
        })
    }
}

/// Which run.
#[derive(Args, Clone, Debug)]
pub(super) struct RunArgument {
    /// The run's key, or its beginning, as `bmv run` prints it
    #[arg(value_name = "RUN", required_unless_present = "run_folder")]
    key: Option<String>,
    /// Folder of the run
    #[arg(long = "run", value_name = "DIR", hide = true)]
    run_folder: Option<std::path::PathBuf>,
    #[command(flatten)]
    cache: CacheOption,
}

impl RunArgument {
    /// Its folder.
    pub(super) fn find(&self) -> Result<RunFolder, Failure> {
        match &self.run_folder {
            // Any submission of it names the run.
            Some(folder) => Ok(crate::runner::cluster::folder::Submission::at(&folder.join("1"))?.run),
            None => {
                let cache = self.cache.cache(&[]);
                Ok(RunFolder::find(&cache, self.key.as_deref().unwrap_or_default())?)
            }
        }
    }
}

/// How the program ends after a run; one that was to be left, and was, is done.
pub(super) fn status(executed: &Executed, is_left: bool) -> Status {
    match Status::of(executed) {
        Status::Interrupted if is_left => Status::Done,
        status => status,
    }
}

/// The scheduler of a run.
pub(super) fn scheduler(engine: &str) -> Result<Box<dyn Scheduler>, Failure> {
    match engine {
        "slurm" => Ok(Box::new(Slurm)),
        other => Err(Failure::input(format!("no engine is called `{other}`"))),
    }
}

/// Runs what is prepared on the cluster of Slurm.
pub(super) fn run(
    prepared: Prepared,
    options: &RunOptions,
    cluster: &ClusterOptions,
    context: &Context,
) -> Result<Executed, Failure> {
    if options.is_forced() {
        return Err(Failure::input(
            "--force compares what is computed anew with the cache, which the engine of this machine does: leave --engine slurm out",
        ));
    }
    let cache = options.cache.cache(prepared.passes());
    let access = context.reading.outside.access();
    let (folder, record) = batch::cluster::submit(&prepared, &cache, "slurm", cluster.options()?, access)?;
    follow(prepared, &folder, &record, cluster.mode(), options.settings(), context)
}

/// Goes on with a run that was left.
pub(super) fn resume(
    run: &RunArgument,
    mode: Mode,
    finish_on_cluster: bool,
    context: &Context,
) -> Result<Status, Failure> {
    let folder = run.find()?;
    let record = folder.record()?;
    let options = Options { finish_on_cluster, ..record.options };
    let record = RunRecord { options, ..record };
    let (prepared, is_same) = batch::cluster::resume(&folder, &record, &context.reading)?;
    if !is_same {
        tell("the study has changed since it was submitted; this is the run of what it was then");
    }
    let executed = follow(prepared, &folder, &record, mode, Settings::default(), context)?;
    print(&outcome(&executed, context.fold)?)?;
    Ok(status(&executed, mode == Mode::Detach))
}

/// Follows a run until it is done, or as far as its mode goes.
pub(super) fn follow(
    prepared: Prepared,
    folder: &RunFolder,
    record: &RunRecord,
    mode: Mode,
    settings: Settings,
    context: &Context,
) -> Result<Executed, Failure> {
    let scheduler = scheduler(&record.engine)?;
    let passes = batch::cluster::passes_of(&prepared, folder, record);
    let (_followed, other) = folder.follow();
    if let Some(other) = other {
        tell(&format!("another program follows this run already ({other}): harmless, and wasteful"));
    }
    let of_run = CacheOption { folder: Some(folder.cache.clone()) };
    let run = |prepared: Prepared, cache: &Cache, listener: &dyn Listener| -> Result<Executed, Failure> {
        context.interrupts.counted(|signals| {
            let driver = Driver::new(folder, record, scheduler.as_ref(), cache, listener, mode, passes, signals)?;
            Ok(prepared.run_elsewhere(settings, cache, listener, &driver)?)
        })
    };
    run_listened(prepared, &of_run, run)
}
