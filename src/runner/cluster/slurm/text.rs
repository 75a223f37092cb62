//! What Slurm's commands print, read. Samples are of version 22.05; fields are found by name or by a separator of ours, so
//! that columns that other versions add do no harm.

use crate::runner::cluster::scheduler::{Ending, Limits, Task};

/// Format of a line of `squeue` about a task.
pub(super) const TASK_FORMAT: &str = "%K|%t|%r|%N";
/// Format of a line of `squeue` about a job: its id, name, comment.
pub(super) const JOB_FORMAT: &str = "%F|%j|%k";

/// `scontrol show config`: the largest array and the number of jobs.
pub(super) fn limits(config: &str) -> Limits {
    let value = |name: &str| {
        let line = config.lines().find(|line| line.split('=').next().is_some_and(|key| key.trim() == name))?;
        line.split_once('=')?.1.split_whitespace().next()?.parse::<usize>().ok()
    };
    // The setting is one more than the largest index, so as many tasks as it says have indices from 0.
    Limits { array: value("MaxArraySize"), jobs: value("MaxJobCount"), processors: None }
}

/// `sinfo --format=%C`: processors allocated, idle, other, total, a line a partition. Those that are down are no slots.
pub(super) fn processors(info: &str) -> Option<usize> {
    let of_line = |line: &str| {
        let mut counts = line.trim().split('/').map(|count| count.parse::<usize>().ok());
        Some(counts.next()?? + counts.next()??)
    };
    let counts: Vec<usize> = info.lines().filter_map(of_line).collect();
    (!counts.is_empty()).then(|| counts.iter().sum())
}

/// `sbatch --parsable`: the job's id, with the cluster's name behind it where there are several.
pub(super) fn submitted(text: &str) -> Option<String> {
    // Sites print greetings; the id stands on the last line.
    let id = text.lines().rev().find(|line| !line.trim().is_empty())?.split(';').next()?.trim();
    (!id.is_empty() && id.bytes().all(|byte| byte.is_ascii_digit())).then(|| id.to_owned())
}

/// `squeue` about tasks. A line that is none of a task is passed over.
pub(super) fn tasks(text: &str) -> Vec<Task> {
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
pub(super) fn found(text: &str, name: &str, comment: &str) -> Option<String> {
    text.lines().find_map(|line| {
        let mut fields = line.trim().splitn(3, '|');
        let (id, own_name, own_comment) = (fields.next()?, fields.next()?, fields.next()?);
        (own_name == name && own_comment == comment).then(|| id.to_owned())
    })
}

/// `scontrol -o show job`: how tasks ended, a line a task; those that have not ended are left out.
pub(super) fn endings(text: &str) -> Vec<Ending> {
    let of_line = |line: &str| {
        let value = |name: &str| {
            line.split_whitespace().find_map(|word| word.strip_prefix(name)?.strip_prefix('=')).map(str::to_owned)
        };
        let state = value("JobState")?;
        let has_ended = !["PENDING", "RUNNING", "COMPLETING", "SUSPENDED", "CONFIGURING", "REQUEUED"]
            .iter()
            .any(|open| state.starts_with(open));
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

/// A list of indices: `3-7,9`, perhaps with the number that may run at a time (`%2`).
fn indices(text: &str) -> Vec<usize> {
    let list = text.split('%').next().unwrap_or_default();
    let of_part = |part: &str| -> Option<std::ops::RangeInclusive<usize>> {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        Some(first.parse().ok()?..=last.parse().ok()?)
    };
    list.split(',').filter_map(of_part).flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_found_by_name() {
        let config = "Configuration data as of 2026-11-25T10:00:00\nMaxArraySize            = 1001\n\
                      MaxDBDMsgs              = 20012\nMaxJobCount             = 10000\nMaxJobId                = 67043328\n";
        assert_eq!(limits(config), Limits { array: Some(1001), jobs: Some(10000), processors: None });
        assert_eq!(limits("slurm_load_ctl_conf error"), Limits::default());
    }

    #[test]
    fn processors_that_are_down_do_not_count() {
        assert_eq!(processors("2/2/2/6\n"), Some(4));
        assert_eq!(processors("0/6/0/6\n4/0/0/4\n"), Some(10));
        assert_eq!(processors(""), None);
    }

    #[test]
    fn an_id_is_read_below_greetings_and_before_the_cluster_s_name() {
        assert_eq!(submitted("17\n"), Some("17".to_owned()));
        assert_eq!(submitted("Welcome to the cluster\n17;alpha\n"), Some("17".to_owned()));
        assert_eq!(submitted("sbatch: error: x\n"), None);
        assert_eq!(submitted(""), None);
    }

    #[test]
    fn tasks_have_an_index_a_reason_and_a_node() {
        let text = "3|PD|(BeginTime)|\n1|R|None|n2\n0|CG|None|n1\nN/A|R|None|n3\nslurm_load_jobs error\n";
        let task = |index, waits: Option<&str>, node: Option<&str>| Task {
            index,
            waits: waits.map(str::to_owned),
            node: node.map(str::to_owned),
        };
        assert_eq!(
            tasks(text),
            [task(3, Some("BeginTime"), None), task(1, None, Some("n2")), task(0, None, Some("n1"))]
        );
    }

    #[test]
    fn a_job_is_found_by_name_and_comment() {
        let text = "12|other|bmv:a:1\n17|bmv-a|bmv:a:1\n18|bmv-a|bmv:a:2\n";
        assert_eq!(found(text, "bmv-a", "bmv:a:2"), Some("18".to_owned()));
        assert_eq!(found(text, "bmv-a", "bmv:a:3"), None);
    }

    #[test]
    fn endings_are_those_of_tasks_that_have_ended() {
        let text = "JobId=18 ArrayJobId=17 ArrayTaskId=1 JobName=bmv-a JobState=FAILED Reason=NonZeroExitCode ExitCode=3:0 \
                    NodeList=n2 BatchHost=n2 Comment=bmv:a:1\n\
                    JobId=19 ArrayJobId=17 ArrayTaskId=2 JobName=bmv-a JobState=RUNNING ExitCode=0:0 NodeList=n1 BatchHost=n1\n\
                    JobId=17 ArrayJobId=17 ArrayTaskId=4-5,9%2 JobState=CANCELLED Reason=None ExitCode=0:0 NodeList=(null)\n";
        let ending = |index, state: &str, code: &str, node: Option<&str>| Ending {
            index,
            state: state.into(),
            code: code.into(),
            node: node.map(str::to_owned),
        };
        let cancelled = |index| ending(index, "CANCELLED", "0:0", None);
        let expected = [ending(1, "FAILED", "3:0", Some("n2")), cancelled(4), cancelled(5), cancelled(9)];
        assert_eq!(endings(text), expected);
        assert!(cancelled(4).is_cancelled());
    }
}
