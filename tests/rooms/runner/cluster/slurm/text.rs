//! Tests of `src/runner/cluster/slurm/text.rs`.

use bmv::runner::cluster::scheduler::{Ending, Limits, Task};
use bmv::runner::cluster::slurm::text::*;

#[test]
fn limits_are_found_by_name() {
    let config = "Configuration data as of 2026-11-25T10:00:00\nMaxArraySize            = 1001\n\
                  MaxDBDMsgs              = 20012\nMaxJobCount             = 10000\nMaxJobId                = 67043328\n";
    let expected = Limits { array: Some(1001), jobs: Some(10000), processors: None, keeps_accounts: None };
    assert_eq!(limits(config), expected);
    let keeps = |kind: &str| limits(&format!("AccountingStorageType   = {kind}\n")).keeps_accounts;
    assert_eq!(
        ["accounting_storage/slurmdbd", "accounting_storage/none", "(null)"].map(keeps),
        [Some(true), Some(false), Some(false)]
    );
    assert_eq!(limits("slurm_load_ctl_conf error"), Limits::default());
}

#[test]
fn accounts_tell_how_tasks_ended_and_nothing_of_those_that_have_not() {
    // The form that the manual of sacct describes: an id with the task's index, then what was asked for.
    let lines = "17_0|COMPLETED|0:0|n1\n17_1|OUT_OF_MEMORY|0:125|n2\n17_2|RUNNING|0:0|n3\n17_[3-5]|PENDING|0:0|None assigned\n\
                 170_6|FAILED|1:0|n1\n17_7|CANCELLED by 0|0:0|None assigned\nslurm_persist_conn_open: failed\n";
    let found = accounts(lines, "17");
    let brief: Vec<(usize, &str, Option<&str>)> =
        found.iter().map(|own| (own.index, own.state.as_str(), own.node.as_deref())).collect();
    assert_eq!(brief, [(0, "COMPLETED", Some("n1")), (1, "OUT_OF_MEMORY", Some("n2")), (7, "CANCELLED by 0", None)]);
    assert!(found[2].is_cancelled() && found[1].code == "0:125");
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
    assert_eq!(tasks(text), [task(3, Some("BeginTime"), None), task(1, None, Some("n2")), task(0, None, Some("n1"))]);
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
