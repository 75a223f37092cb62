//! Tests of `src/runner/cluster/slurm/mod.rs`.

mod text;

use bmv::runner::cluster::Scheduler;
use std::path::Path;

use bmv::runner::cluster::options::Options;
use bmv::runner::cluster::scheduler::{Request, Wait};
use bmv::runner::cluster::slurm::*;

#[test]
fn a_submission_states_all_that_sites_differ_in() {
    let options = Options {
        max_running: Some(8),
        cpus_per_task: 4,
        partition: Some("main".into()),
        exclude: vec!["n9".into()],
        ..Options::default()
    };
    let request = Request {
        name: "bmv-0123456789ab",
        comment: "bmv:0123:1",
        tasks: Some(40),
        folder: Path::new("/shared/runs/0123/1"),
        log: Path::new("/shared/runs/0123/1/log"),
        script: Path::new("/shared/runs/0123/1/shard.sh"),
        exclude: &["n2".to_owned()],
        after: None,
        options: &options,
    };
    let line = submission(&request).join(" ");
    for part in [
        "--parsable",
        "--array=0-39%8",
        "--cpus-per-task=4",
        "--mem-per-cpu=2G",
        "--time=01:00:00",
        "--requeue",
        "--open-mode=append",
        "--export=NONE",
        "--chdir=/shared/runs/0123/1",
        "--output=/shared/runs/0123/1/log/%a.out",
        "--signal=B:TERM@60",
        "--partition=main",
        "--exclude=n9,n2",
    ] {
        assert!(line.split(' ').any(|word| word == part), "{part} in {line}");
    }
    assert!(line.ends_with("/shard.sh") && !line.contains("--account"), "{line}");
}

#[test]
fn reasons_that_do_not_pass_alone_are_known() {
    let of = |reason: &str| Slurm.wait(reason);
    assert_eq!([of("Resources"), of("Priority"), of("BeginTime")], [Wait::Turn, Wait::Turn, Wait::Delay]);
    assert_eq!([of("PartitionConfig"), of("AssocMaxJobsLimit")], [Wait::Lasting; 2]);
}
