//! Slurm, through its commands: `sbatch`, `squeue`, `scontrol`, `sinfo`, `scancel`; and `sacct`, which answers where there is a
//! database. None is needed.

pub mod text;

use std::fs;
use std::process::Command;
use std::time::Duration;

use super::options::Options;
use super::scheduler::{Ending, Limits, Request, Scheduler, SchedulerError, Task, Variables, Wait};
use crate::runner::external::process::{self, End};

/// A command that takes longer is given up.
const PATIENCE: Duration = Duration::from_secs(60);

/// What `squeue` says of a job that it has forgotten, or never knew.
const UNKNOWN_JOB: &str = "Invalid job id";
/// What commands say when the controller is away.
const AWAY: [&str; 4] = ["Unable to contact slurm controller", "Connection refused", "Socket timed out", "Zero Bytes"];
/// Reasons to wait that will not pass by themselves.
const LASTING: [&str; 12] = [
    "PartitionConfig",
    "PartitionNodeLimit",
    "PartitionTimeLimit",
    "PartitionDown",
    "PartitionInactive",
    "BadConstraints",
    "DependencyNeverSatisfied",
    "JobHeldUser",
    "JobHeldAdmin",
    "InvalidAccount",
    "InvalidQOS",
    "ReqNodeNotAvail",
];

/// The Slurm whose commands are on the `PATH`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slurm;

/// Runs a command of Slurm's, and gives what it prints.
fn ask(program: &str, arguments: &[String]) -> Result<String, SchedulerError> {
    let cannot = |why: String| SchedulerError::Unreachable(format!("{program}: {why}"));
    let folder = tempfile::tempdir().map_err(|error| cannot(error.to_string()))?;
    let (output, errors) = (folder.path().join("output"), folder.path().join("errors"));
    let mut command = Command::new(program);
    // Messages are read, so they must be those of every place.
    command.args(arguments).env("LC_ALL", "C");
    let end = process::run(command, &output, &errors, PATIENCE, &|| false).map_err(|error| {
        let is_missing = error.kind() == std::io::ErrorKind::NotFound;
        let why = if is_missing {
            "it is not on the PATH: is this a machine of the cluster?".to_owned()
        } else {
            error.to_string()
        };
        SchedulerError::Refused(format!("{program}: {why}"))
    })?;
    let text =
        |path| fs::read(path).map_or_else(|_| String::new(), |bytes| String::from_utf8_lossy(&bytes).into_owned());
    match end {
        End::Exited(status) if status.success() => Ok(text(&output)),
        End::Exited(status) => {
            let said = format!("{}{}", text(&errors), text(&output));
            let said = if said.trim().is_empty() { status.to_string() } else { said.trim().to_owned() };
            let is_away = AWAY.iter().any(|away| said.contains(away));
            Err(if is_away { cannot(said) } else { SchedulerError::Refused(format!("{program}: {said}")) })
        }
        End::TimedOut => Err(cannot(format!("no answer in {} s", PATIENCE.as_secs()))),
        End::WroteTooMuch | End::Left => Err(cannot("it prints too much".to_owned())),
    }
}

fn words(arguments: &[&str]) -> Vec<String> {
    arguments.iter().map(|&word| word.to_owned()).collect()
}

/// The arguments of `sbatch`.
pub fn submission(request: &Request<'_>) -> Vec<String> {
    let options = request.options;
    let mut arguments = words(&["--parsable", "--ntasks=1", "--requeue", "--open-mode=append", "--export=NONE"]);
    let mut give = |name: &str, value: &str| arguments.push(format!("--{name}={value}"));
    give("job-name", request.name);
    give("comment", request.comment);
    if let Some(tasks) = request.tasks {
        let at_once = options.max_running.map_or_else(String::new, |most| format!("%{most}"));
        give("array", &format!("0-{}{at_once}", tasks.saturating_sub(1)));
    }
    give("cpus-per-task", &options.cpus_per_task.to_string());
    give("mem-per-cpu", &options.mem_per_cpu);
    give("time", &options.time);
    give("chdir", &request.folder.display().to_string());
    let file = if request.tasks.is_some() { "%a.out" } else { "collect.out" };
    give("output", &request.log.join(file).display().to_string());
    // A minute before its time is over the program is told, so that it keeps what it has.
    give("signal", "B:TERM@60");
    if let Some(after) = request.after {
        give("dependency", &format!("afterany:{after}"));
    }
    let passed = [
        ("partition", &options.partition),
        ("account", &options.account),
        ("qos", &options.qos),
        ("constraint", &options.constraint),
    ];
    for (name, value) in passed {
        if let Some(value) = value {
            give(name, value);
        }
    }
    let excluded: Vec<&str> = options.exclude.iter().chain(request.exclude).map(String::as_str).collect();
    if !excluded.is_empty() {
        give("exclude", &excluded.join(","));
    }
    arguments.push(request.script.display().to_string());
    arguments
}

impl Scheduler for Slurm {
    fn name(&self) -> &'static str {
        "Slurm"
    }

    fn variables(&self) -> Variables {
        Variables { index: "SLURM_ARRAY_TASK_ID", node: "SLURMD_NODENAME", restart: "SLURM_RESTART_COUNT" }
    }

    fn limits(&self, options: &Options) -> Result<Limits, SchedulerError> {
        let limits = text::limits(&ask("scontrol", &words(&["show", "config"]))?);
        let mut arguments = words(&["--noheader", "--format=%C"]);
        arguments.extend(options.partition.iter().map(|partition| format!("--partition={partition}")));
        Ok(Limits { processors: text::processors(&ask("sinfo", &arguments)?), ..limits })
    }

    fn find(&self, name: &str, comment: &str) -> Result<Option<String>, SchedulerError> {
        let format = format!("--format={}", text::JOB_FORMAT);
        let lines = ask("squeue", &words(&["--me", "--noheader", &format!("--name={name}"), &format]))?;
        Ok(text::found(&lines, name, comment))
    }

    fn submit(&self, request: &Request<'_>) -> Result<String, SchedulerError> {
        let answer = ask("sbatch", &submission(request))?;
        text::submitted(&answer)
            .ok_or_else(|| SchedulerError::Refused(format!("sbatch gave no job id: {}", answer.trim())))
    }

    fn tasks(&self, job: &str, name: &str) -> Result<Vec<Task>, SchedulerError> {
        let format = format!("--format={}", text::TASK_FORMAT);
        // The name too: a controller that lost its state counts from 1 again.
        let arguments = words(&["--noheader", "--array", &format!("--jobs={job}"), &format!("--name={name}"), &format]);
        match ask("squeue", &arguments) {
            Ok(lines) => Ok(text::tasks(&lines)),
            Err(SchedulerError::Refused(said)) if said.contains(UNKNOWN_JOB) => Ok(Vec::new()),
            // What is not understood says nothing of the tasks.
            Err(error) => Err(SchedulerError::Unreachable(error.to_string())),
        }
    }

    fn wait(&self, reason: &str) -> Wait {
        match reason {
            "BeginTime" => Wait::Delay,
            _ if LASTING.iter().any(|lasting| reason.starts_with(lasting)) => Wait::Lasting,
            // Limits of an account or of a quality of service pass where others' jobs end, or never.
            _ if reason.starts_with("Assoc") || reason.starts_with("QOS") => Wait::Lasting,
            _ => Wait::Turn,
        }
    }

    fn endings(&self, job: &str) -> Vec<Ending> {
        let shown = ask("scontrol", &words(&["-o", "show", "job", job]));
        let mut endings = shown.map_or_else(|_| Vec::new(), |lines| text::endings(&lines));
        // The controller forgets within minutes; the database, where there is one, does not.
        let format = format!("--format={}", text::ACCOUNT_FORMAT);
        let accounts = words(&["--noheader", "--parsable2", "--allocations", "--array", "--jobs", job, &format]);
        for ending in ask("sacct", &accounts).map_or_else(|_| Vec::new(), |lines| text::accounts(&lines, job)) {
            if !endings.iter().any(|known| known.index == ending.index) {
                endings.push(ending);
            }
        }
        endings
    }

    fn hasten(&self, job: &str, index: usize) {
        // It starts by itself too, later.
        let _ = ask("scontrol", &words(&["update", &format!("JobId={job}_{index}"), "StartTime=now"]));
    }

    fn cancel(&self, job: &str) -> Result<(), SchedulerError> {
        ask("scancel", &words(&[job])).map(|_| ())
    }
}
