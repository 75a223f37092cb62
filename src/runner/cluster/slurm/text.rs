//! What Slurm's commands print, read. Samples are of version 22.05; fields are found by name or by a separator of ours, so
//! that columns that other versions add do no harm.

use crate::runner::cluster::scheduler::{Ending, Limits, Task};

/// Format of a line of `squeue` about a task.
pub(super) const TASK_FORMAT: &str = "%K|%t|%r|%N";
/// Format of a line of `sacct` about a task.
pub(super) const ACCOUNT_FORMAT: &str = "JobID,State,ExitCode,NodeList";
/// Format of a line of `squeue` about a job: its id, name, comment.
pub(super) const JOB_FORMAT: &str = "%F|%j|%k";

/// `scontrol show config`: the largest array and the number of jobs.
pub fn limits(config: &str) -> Limits {
    let value = |name: &str| text_value(config, name)?.parse::<usize>().ok();
    // The setting is one more than the largest index, so as many tasks as it says have indices from 0.
    let accounts = text_value(config, "AccountingStorageType");
    Limits {
        array: value("MaxArraySize"),
        jobs: value("MaxJobCount"),
        processors: None,
        keeps_accounts: accounts.map(|kind| !kind.ends_with("none") && kind != "(null)"),
    }
}

/// The first word of a setting.
fn text_value<'c>(config: &'c str, name: &str) -> Option<&'c str> {
    let line = config.lines().find(|line| line.split('=').next().is_some_and(|key| key.trim() == name))?;
    line.split_once('=')?.1.split_whitespace().next()
}

/// `sinfo --format=%C`: processors allocated, idle, other, total, a line a partition. Those that are down are no slots.
pub fn processors(info: &str) -> Option<usize> {
    let of_line = |line: &str| {
        let mut counts = line.trim().split('/').map(|count| count.parse::<usize>().ok());
        Some(counts.next()?? + counts.next()??)
    };
    let counts: Vec<usize> = info.lines().filter_map(of_line).collect();
    (!counts.is_empty()).then(|| counts.iter().sum())
}

/// `sbatch --parsable`: the job's id, with the cluster's name behind it where there are several.
pub fn submitted(text: &str) -> Option<String> {
    // Sites print greetings; the id stands on the last line.
    let id = text.lines().rev().find(|line| !line.trim().is_empty())?.split(';').next()?.trim();
    (!id.is_empty() && id.bytes().all(|byte| byte.is_ascii_digit())).then(|| id.to_owned())
}

/// `squeue` about tasks. A line that is none of a task is passed over.
pub fn tasks(text: &str) -> Vec<Task> {
    let of_line = |line: &str| {
        let mut fields = line.trim().split('|');
        let index = fields.next()?.parse().ok()?;
        let (state, reason, node) = (fields.next()?, fields.next()?, fields.next().unwrap_or_default());
        let waits = (state == "PD").then(|| reason.trim_matches(['(', ')']).to_owned());
        Some(Task { index, waits, node: (!node.is_empty()).then(|| node.to_owned()) })
    };
    text.lines().filter_map(of_line).collect()
}

/// `squeue` about jobs: the id of the one of this name and comment.
pub fn found(text: &str, name: &str, comment: &str) -> Option<String> {
    text.lines().find_map(|line| {
        let mut fields = line.trim().splitn(3, '|');
        let (id, own_name, own_comment) = (fields.next()?, fields.next()?, fields.next()?);
        (own_name == name && own_comment == comment).then(|| id.to_owned())
    })
}

/// `scontrol -o show job`: how tasks ended, a line a task; those that have not ended are left out.
pub fn endings(text: &str) -> Vec<Ending> {
    let of_line = |line: &str| {
        let value = |name: &str| {
            line.split_whitespace().find_map(|word| word.strip_prefix(name)?.strip_prefix('=')).map(str::to_owned)
        };
        let state = value("JobState")?;
        let has_ended = has_ended(&state);
        let node = value("BatchHost").or_else(|| value("NodeList")).filter(|node| node != "(null)" && !node.is_empty());
        let code = value("ExitCode").unwrap_or_default();
        // Tasks that never started share a line: 3-7,9.
        let indices = indices(&value("ArrayTaskId")?);
        has_ended.then(|| {
            indices.into_iter().map(move |index| Ending {
                index,
                state: state.clone(),
                code: code.clone(),
                node: node.clone(),
            })
        })
    };
    text.lines().filter_map(of_line).flatten().collect()
}

/// `sacct --parsable2 --array`: how tasks of an array ended, a line a task.
pub fn accounts(text: &str, job: &str) -> Vec<Ending> {
    let of_line = |line: &str| {
        let mut fields = line.trim().split('|');
        let (id, state) = (fields.next()?, fields.next()?);
        let index = id.strip_prefix(job)?.strip_prefix('_')?.parse().ok()?;
        let code = fields.next().unwrap_or_default().to_owned();
        let node = fields.next().filter(|node| !node.is_empty() && *node != "None assigned").map(str::to_owned);
        has_ended(state).then(|| Ending { index, state: state.to_owned(), code, node })
    };
    text.lines().filter_map(of_line).collect()
}

/// Whether a task in this state will not run any more.
fn has_ended(state: &str) -> bool {
    let open = ["PENDING", "RUNNING", "COMPLETING", "SUSPENDED", "CONFIGURING", "REQUEUED", "RESIZING"];
    !open.iter().any(|open| state.starts_with(open))
}

/// A list of indices: `3-7,9`, perhaps with the number that may run at a time (`%2`).
fn indices(text: &str) -> Vec<usize> {
    let list = text.split('%').next().unwrap_or_default();
    let of_part = |part: &str| -> Option<std::ops::RangeInclusive<usize>> {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        Some(first.parse().ok()?..=last.parse().ok()?)
    };
    list.split(',').filter_map(of_part).flatten().collect()
}
