//! Runs on a cluster, with commands on the `PATH` that answer as Slurm's do. `tests/cluster/check.sh` has the real one.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

use super::studies::{code, text};

/// With the sweep of the pass: six environments and the given one, a block each.
const MODEL: &str = r#"{
  "format": "bmv-network/1", "title": "Plate",
  "parameters": {"G": {"unit": "W/K", "nominal": 0.5, "prior": {"uniform": [0.4, 0.6]}}},
  "inputs": {"Q": {"unit": "W", "nominal": 10}, "T_wall": {"unit": "degC", "nominal": 20}},
  "nodes": {"plate": {"capacity": 100}, "wall": {"boundary": "T_wall"}},
  "conductors": {"mount": {"between": ["plate", "wall"], "conductance": "G"}},
  "loads": {"heater": {"into": "plate", "power": "Q"}},
  "quantities": {"plate temperature": {"temperature": "plate"}}
}"#;
const PASS: &str = r#"{
  "format": "bmv-pass/1", "title": "Plate", "parent": null, "model": "model.json", "seed": 1,
  "requirements": {"plate": {"quantity": "plate temperature", "below": {"value": 41, "unit": "degC"}, "probability": 0.9}},
  "jobs": {"prior": {"propagate": {"samples": 64, "sweep": {"Q": {"from": 5, "to": 11, "steps": 6}}}}}
}"#;

/// Runs the tasks of an array at once, unless the file `never` is there; a task whose file `fails-N` is there is killed, once.
const SBATCH: &str = r#"#!/bin/sh
echo "$@" >> "$FAKE/submitted"
[ ! -e "$FAKE/refuses" ] || { echo "sbatch: error: QOSMaxSubmitJobPerUserLimit" >&2; exit 1; }
for word; do case $word in --array=0-*) last=${word#--array=0-} ;; --output=*) output=${word#--output=} ;; esac; script=$word; done
id=$(($(wc -l < "$FAKE/submitted") + 100))
echo $id
[ ! -e "$FAKE/never" ] || { touch "$FAKE/waiting"; exit 0; }
for index in $(seq 0 "${last%\%*}"); do
  if [ -e "$FAKE/fails-$index" ]; then rm "$FAKE/fails-$index"; continue; fi
  SLURM_ARRAY_TASK_ID=$index SLURMD_NODENAME=n$((index % 3)) sh "$script" > "$(echo "$output" | sed "s/%a/$index/")" 2>&1
done
exit 0
"#;
const SQUEUE: &str = r#"#!/bin/sh
[ ! -e "$FAKE/waiting" ] || case "$*" in *--array*) seq -f '%g|PD|(PartitionConfig)|' 0 2 ;; esac
"#;
const SCONTROL: &str =
    "#!/bin/sh\ncase \"$*\" in *config*) echo 'MaxArraySize = 40'; echo 'MaxJobCount = 10000' ;; esac\n";
const SINFO: &str = "#!/bin/sh\necho 0/6/0/6\n";
const SACCT: &str = "#!/bin/sh\ncase \"$*\" in *101*) echo '101_2|OUT_OF_MEMORY|0:125|n2' ;; esac\n";
const SCANCEL: &str = "#!/bin/sh\nrm -f \"$FAKE/waiting\"\necho \"$@\" >> \"$FAKE/cancelled\"\n";

struct Cluster {
    root: TempDir,
}

impl Cluster {
    fn new() -> Self {
        let root = tempfile::tempdir().unwrap();
        let write = |name: &str, content: &str| {
            let path = root.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, content).unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        };
        write("plate/model.json", MODEL);
        write("plate/pass-1.json", PASS);
        let commands = [
            ("sbatch", SBATCH),
            ("squeue", SQUEUE),
            ("scontrol", SCONTROL),
            ("sinfo", SINFO),
            ("sacct", SACCT),
            ("scancel", SCANCEL),
        ];
        for (name, script) in commands {
            write(&format!("bin/{name}"), script);
        }
        Self { root }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.root.path().join(name)
    }

    fn bmv(&self, arguments: &[&str]) -> Output {
        let path = format!("{}:{}", self.path("bin").display(), std::env::var("PATH").unwrap());
        Command::new(env!("CARGO_BIN_EXE_bmv"))
            .current_dir(self.root.path())
            .env("PATH", path)
            .env("FAKE", self.root.path())
            .args(arguments)
            .output()
            .expect("the program starts")
    }

    /// Runs on the cluster; its messages.
    fn run(&self, status: i32, cache: &str, more: &[&str]) -> String {
        self.run_of("plate", status, cache, more)
    }

    fn run_of(&self, what: &str, status: i32, cache: &str, more: &[&str]) -> String {
        let mut all = vec!["run", what, "--engine", "slurm", "--poll", "1", "--retry-delay", "0", "--cache", cache];
        all.extend(more);
        let output = self.bmv(&all);
        assert_eq!(code(&output), status, "{more:?}: {}", text(&output.stderr));
        text(&output.stderr)
    }

    fn result(&self, cache: &str) -> String {
        let output = self.bmv(&["show", "plate/pass-1.json", "--json", "--cache", cache]);
        assert_eq!(code(&output), 0, "{}", text(&output.stderr));
        text(&output.stdout)
    }

    fn submissions(&self) -> usize {
        fs::read_to_string(self.path("submitted")).map_or(0, |text| text.lines().count())
    }
}

#[test]
#[ignore = "thorough"]
fn any_number_of_shards_gives_the_bytes_of_this_machine() {
    let cluster = Cluster::new();
    // What the study's document says of passes that are not asked for concerns no shard.
    let other = PASS.replace(r#""parent": null"#, r#""parent": "pass-1.json""#);
    fs::write(cluster.path("plate/pass-2.json"), other).unwrap();
    let document = r#"{"format": "bmv-document/1", "title": "Plate", "number": "1", "issue": "1", "date": "2026-01-01",
      "counterparts": {"of": "a report", "items": [{"item": "Figure 1", "title": "prior", "pass": "pass-2.json", "section": "propagation"}]}}"#;
    fs::write(cluster.path("plate/document.json"), document).unwrap();
    assert_eq!(code(&cluster.bmv(&["run", "plate/pass-1.json", "--threads", "1", "--cache", "here"])), 0);
    let expected = cluster.result("here");
    for shards in ["1", "3"] {
        let said = cluster.run_of("plate/pass-1.json", 0, shards, &["--shards", shards]);
        assert!(said.contains("7 blocks in"), "{said}");
        assert_eq!(cluster.result(shards), expected, "{shards} shards");
    }
    // What is there is not submitted again.
    let before = cluster.submissions();
    cluster.run_of("plate/pass-1.json", 0, "1", &[]);
    assert_eq!(cluster.submissions(), before);
}

#[test]
#[ignore = "thorough"]
fn what_is_missing_after_a_failure_is_submitted_again_and_nothing_else() {
    let cluster = Cluster::new();
    fs::write(cluster.path("fails-2"), "").unwrap();
    // The controller has forgotten the task; the accounts of the cluster have not.
    let said = cluster.run(0, "cache", &["--shards", "7"]);
    assert!(said.contains("7 blocks in 7 shards") && said.contains("1 block in 1 shard"), "{said}");
    assert!(said.contains("shard 2 on n2: OUT_OF_MEMORY 0:125"), "{said}");
    assert_eq!(cluster.submissions(), 2);
}

#[test]
#[ignore = "thorough"]
fn a_run_that_was_left_is_shown_collected_and_cancelled() {
    let cluster = Cluster::new();
    fs::write(cluster.path("never"), "").unwrap();
    let said = cluster.run(0, "cache", &["--detach", "--shards", "3"]);
    let run = said.split("bmv attach ").nth(1).and_then(|rest| rest.get(..12)).expect("the run's key").to_owned();
    let shard = |index: &str| {
        let key = fs::read_dir(cluster.path("cache/runs")).unwrap().next().unwrap().unwrap().path();
        cluster.bmv(&["shard", "--run", &key.join("1").display().to_string(), "--index", index])
    };
    assert_eq!(code(&shard("0")), 0);
    assert_eq!(code(&shard("0")), 0, "a shard that runs twice finds its blocks");
    assert_eq!(code(&shard("3")), 64, "there is no such shard");
    let shown = text(&cluster.bmv(&["show", "plate/pass-1.json", "--cache", "cache"]).stderr);
    assert!(shown.contains("`prior`: 2 of 7 blocks"), "{shown}");
    // The first block is that of the given design: 10 W / G above 20 degC is at most 41 where G is 0.476 or more, 62 % of the prior.
    let said = shown.split_whitespace().collect::<Vec<_>>().join(" ");
    let share =
        said.split("so far `plate` is met in `nominal` with a probability of ").nth(1).and_then(|rest| rest.get(..6));
    let share: f64 = share.and_then(|share| share.parse().ok()).unwrap_or_else(|| panic!("{said}"));
    assert!((share - 0.619).abs() < 0.03 && said.contains("by 64 of 64 samples"), "{said}");
    let collected = cluster.bmv(&["collect", &run, "--cache", "cache"]);
    assert_eq!(code(&collected), 130);
    assert!(text(&collected.stderr).contains("2 of 7 blocks are there"), "{}", text(&collected.stderr));
    // What waits for ever is not waited for.
    let said = cluster.run(130, "cache", &["--pending-timeout", "0"]);
    assert!(said.contains("PartitionConfig") && said.contains("no longer waiting"), "{said}");
    assert_eq!(cluster.submissions(), 1, "an array that is under way is followed, not submitted again");
    let cancelled = cluster.bmv(&["cancel", &run, "--cache", "cache"]);
    assert!(text(&cancelled.stdout).starts_with("1 array cancelled"), "{}", text(&cancelled.stderr));
    fs::remove_file(cluster.path("never")).unwrap();
    let said = cluster.run(0, "cache", &[]);
    assert!(said.contains("5 blocks in 5 shards"), "only the rest: {said}");
}

#[test]
fn what_cannot_be_submitted_is_said_before() {
    let cluster = Cluster::new();
    let said = cluster.run(2, "cache", &["--shards", "41"]);
    assert!(said.contains("an array of 41 shards is too large: this cluster takes at most 40"), "{said}");
    let said = cluster.run(2, "a%b", &[]);
    assert!(said.contains("has the character '%'"), "{said}");
    fs::write(cluster.path("file"), "").unwrap();
    let said = cluster.run(3, "file/cache", &[]);
    assert!(said.contains("cannot make the folder") || said.contains("cannot write"), "{said}");
    cluster.run(2, "cache", &["--force"]);
    fs::write(cluster.path("plate/pass-2.json"), PASS.replace("model.json", "../model.json")).unwrap();
    let said = cluster.run(2, "cache", &[]);
    assert!(said.contains("../model.json"), "{said}");
    fs::remove_file(cluster.path("plate/pass-2.json")).unwrap();
    assert_eq!(cluster.submissions(), 0, "nothing was submitted so far");
    fs::write(cluster.path("refuses"), "").unwrap();
    let said = cluster.run(3, "cache", &[]);
    assert!(said.contains("Slurm: sbatch: sbatch: error: QOSMaxSubmitJobPerUserLimit"), "{said}");
}

#[test]
#[ignore = "thorough"]
fn a_definition_that_is_rejected_is_not_tried_again_and_a_torn_object_is_computed_again() {
    let cluster = Cluster::new();
    fs::write(cluster.path("never"), "").unwrap();
    cluster.run(0, "cache", &["--detach", "--shards", "1"]);
    let key = fs::read_dir(cluster.path("cache/runs")).unwrap().next().unwrap().unwrap().path();
    let shard = || cluster.bmv(&["shard", "--run", &key.join("1").display().to_string(), "--index", "0"]);
    // Editing the study does not matter to what was submitted.
    fs::write(cluster.path("plate/model.json"), "{").unwrap();
    assert_eq!(code(&shard()), 0);
    let object = first_object(&cluster.path("cache/objects"));
    let whole = fs::read(&object).unwrap();
    fs::write(&object, &whole[..whole.len() / 2]).unwrap();
    let again = shard();
    assert_eq!(code(&again), 0, "{}", text(&again.stderr));
    assert_eq!(fs::read(&object).unwrap(), whole);
    // Editing the copy does.
    let copy = key.join("study-0/model.json");
    fs::write(&copy, fs::read_to_string(&copy).unwrap().replace("0.4, 0.6", "0.4, 0.7")).unwrap();
    fs::remove_file(&object).unwrap();
    let rejected = shard();
    assert_eq!(code(&rejected), 65, "{}", text(&rejected.stderr));
    assert!(text(&rejected.stderr).contains("gives no job of the key"), "{}", text(&rejected.stderr));
}

fn first_object(folder: &Path) -> PathBuf {
    let files = walkdir::WalkDir::new(folder).sort_by_file_name().into_iter().flatten();
    files.map(walkdir::DirEntry::into_path).find(|path| path.is_file()).expect("an object")
}
