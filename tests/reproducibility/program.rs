//! The program itself on whole studies: any number of threads, masked CPU features, kills at any moment, two at once.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use bmv::random::StreamKey;
use serde_json::{Value, json};

/// glibc's own functions without the instructions that newer machines have; the names of 2.33 and later, then older.
const MASKED: &str = "glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512BW,-AVX512DQ,-AVX2,-AVX,-FMA,-FMA4,-BMI1,-BMI2,\
                      -LZCNT,-MOVBE,-POPCNT,-SSE4_1,-SSE4_2,-SSSE3,-ERMS,-XSAVEC,-AVX2_Usable,-AVX_Usable,-FMA_Usable,\
                      -AVX512F_Usable,-AVX_Fast_Unaligned_Load";

/// Studies in a folder of their own.
struct Studies(tempfile::TempDir);

impl Studies {
    /// The radiator with so many samples, and a block that cools with readings of it.
    fn new(samples: u64) -> Self {
        let studies = Self(tempfile::tempdir().unwrap());
        let radiator = studies.path().join("studies/radiator");
        fs::create_dir_all(&radiator).unwrap();
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/radiator");
        fs::copy(source.join("model.json"), radiator.join("model.json")).unwrap();
        fs::copy(source.join("pass-1.json"), radiator.join("pass-1.json")).unwrap();
        fs::create_dir(radiator.join("data")).unwrap();
        fs::copy(source.join("data/history.csv"), radiator.join("data/history.csv")).unwrap();
        studies.change_job(|job| job["samples"] = json!(samples));
        studies.change_pass(|pass| {
            pass["jobs"]["effects"]["sensitivity"]["samples"] = json!(128);
            // `reproducibility::jobs` runs the kinds of these two on any number of threads.
            for slow in ["goal", "coupon"] {
                pass["jobs"].as_object_mut().unwrap().remove(slow).unwrap();
            }
        });
        studies.write_cooling();
        studies
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// Changes the settings of the radiator's propagation.
    fn change_job(&self, change: impl FnOnce(&mut Value)) {
        self.change_pass(|pass| change(&mut pass["jobs"]["prior"]["propagate"]));
    }

    fn change_pass(&self, change: impl FnOnce(&mut Value)) {
        let file = self.path().join("studies/radiator/pass-1.json");
        let mut pass: Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
        change(&mut pass);
        fs::write(&file, pass.to_string()).unwrap();
    }

    /// A transient that needs the integrator, with a table of readings.
    fn write_cooling(&self) {
        let folder = self.path().join("studies/cooling");
        fs::create_dir_all(folder.join("data")).unwrap();
        let model = json!({
            "format": "bmv-network/1",
            "title": "A block that cools",
            "inputs": {"Q": {"unit": "W", "nominal": 0}},
            "parameters": {"G": {"unit": "W/K", "nominal": 0.2, "prior": {"uniform": [0.1, 0.3]}}},
            "nodes": {"block": {"capacity": 120}, "shell": {"capacity": 40}, "room": {"boundary": 293.15}},
            "conductors": {"leak": {"between": ["shell", "room"], "conductance": "G"},
                           "joint": {"between": ["block", "shell"], "conductance": "1.5 * G"}},
            "radiations": {"surface": {"between": ["shell", "room"], "exchange_area": 0.01}},
            "loads": {"heater": {"into": "block", "power": "Q"}}
        });
        let pass = json!({
            "format": "bmv-pass/1",
            "title": "Cooling",
            "parent": null,
            "model": "model.json",
            "seed": 3,
            "measurements": {"cooling": {"transient": {
                "file": "data/cooling.csv",
                "initial": {"temperatures": {"all": 330}},
                "sensors": {"block": {"measures": "block", "sigma": 0.2}}
            }}},
            "jobs": {"delivered": {"compare": {"data": ["cooling"]}}}
        });
        fs::write(folder.join("model.json"), model.to_string()).unwrap();
        fs::write(folder.join("pass-1.json"), pass.to_string()).unwrap();
        let mut table = String::from("time [s],Q [W],block [K]\n");
        for row in 0..60 {
            let heat = f64::from(row % 7);
            let reading = 293.0 + 1100.0 / f64::from(30 + row);
            writeln!(table, "{},{heat},{reading}", 20 * row).unwrap();
        }
        fs::write(folder.join("data/cooling.csv"), table).unwrap();
    }

    /// The program, with a cache named as given.
    fn bmv(&self, arguments: &[&str], cache: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bmv"));
        command.current_dir(self.path()).args(arguments).args(["--cache", cache]).env("NO_COLOR", "1");
        command
    }

    fn run(&self, arguments: &[&str], cache: &str) -> Output {
        finished(self.bmv(arguments, cache).output().unwrap())
    }

    /// Renders the reports into a folder of the given name with a cache of the same name; all files with their bytes.
    fn report(&self, name: &str, threads: &str, tunables: Option<&str>) -> BTreeMap<String, Vec<u8>> {
        let out = format!("{name}/reports");
        let cache = format!("{name}/cache");
        let mut command = self.bmv(&["report", "studies", "--out", &out, "--threads", threads], &cache);
        if let Some(tunables) = tunables {
            command.env("GLIBC_TUNABLES", tunables);
        }
        finished(command.output().unwrap());
        files(&self.path().join(out))
    }

    /// The stored result of the radiator's propagation.
    fn prior(&self, cache: &str) -> Vec<u8> {
        self.run(&["show", "studies/radiator/pass-1.json", "prior", "--json", "--run"], cache).stdout
    }
}

fn finished(output: Output) -> Output {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

/// Files below a folder with their bytes, by path.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    walkdir::WalkDir::new(folder)
        .into_iter()
        .map(Result::unwrap)
        .filter(|entry| entry.file_type().is_file())
        .map(|entry| {
            let name = entry.path().strip_prefix(folder).unwrap().to_str().unwrap().to_owned();
            (name, fs::read(entry.path()).unwrap())
        })
        .collect()
}

/// The same files with the same bytes; names the first that differs.
fn same(first: &BTreeMap<String, Vec<u8>>, second: &BTreeMap<String, Vec<u8>>, what: &str) {
    assert!(first.keys().eq(second.keys()), "{what}");
    for (name, bytes) in first {
        assert!(bytes == &second[name], "{what}: {name} differs");
    }
}

#[test]
#[ignore = "thorough"]
fn reports_have_the_same_bytes_for_any_threads_and_with_masked_cpu_features() {
    let studies = Studies::new(4000);
    let one = studies.report("one", "1", None);
    for file in ["radiator/pass-1/results.json", "radiator/pass-1/report.html", "cooling/pass-1/report.md"] {
        assert!(one.contains_key(file), "{file}: {:?}", one.keys());
    }
    same(&one, &studies.report("seven", "7", None), "7 threads");
    same(&one, &studies.report("masked", "2", Some(MASKED)), "masked CPU features");
}

#[test]
#[ignore = "thorough"]
fn ten_kills_at_random_moments_leave_no_trace_in_the_result() {
    let studies = Studies::new(1 << 18);
    studies.change_job(|job| job["sweep"] = json!({"A": [0.28, 0.30, 0.32]}));
    let mut moments = StreamKey::new(9, "kills", "moments").stream(0);
    let mut killed = 0;
    for _ in 0..10 {
        let mut process = studies
            .bmv(&["run", "studies/radiator", "--threads", "1"], "cache")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(20 + moments.below(180) as u64));
        process.kill().unwrap();
        killed += u32::from(!process.wait().unwrap().success());
    }
    assert!(killed >= 5, "{killed} of 10 were killed before their end");
    let whole = studies.prior("whole");
    assert!(!whole.is_empty());
    assert!(studies.prior("cache") == whole, "a killed and resumed run gave other bytes");
    studies.run(&["cache", "verify"], "cache");
    let statistics = studies.run(&["cache", "stat", "--json"], "cache").stdout;
    let statistics: Value = serde_json::from_slice(&statistics).unwrap();
    assert_eq!((&statistics["quarantined"], &statistics["conflicts"]), (&json!(0), &json!(0)));
}

#[test]
#[ignore = "thorough"]
fn two_programs_share_a_cache() {
    let studies = Studies::new(16_000);
    let mut processes: Vec<_> = (0..2)
        .map(|_| studies.bmv(&["run", "studies", "--threads", "2"], "cache").stderr(Stdio::null()).spawn().unwrap())
        .collect();
    for process in &mut processes {
        assert!(process.wait().unwrap().success());
    }
    studies.run(&["cache", "verify"], "cache");
    let statistics = studies.run(&["cache", "stat", "--json"], "cache").stdout;
    let statistics: Value = serde_json::from_slice(&statistics).unwrap();
    assert_eq!((&statistics["conflicts"], &statistics["leftovers"]), (&json!(0), &json!(0)), "{statistics}");
    assert!(studies.prior("cache") == studies.prior("alone"));
}

/// Distribution of the radiator's temperature at its nominal size.
fn temperatures(result: &[u8]) -> Value {
    let result: Value = serde_json::from_slice(result).unwrap();
    let temperature = result["quantities"]["radiator temperature"].clone();
    assert!(temperature["mean"].is_number(), "{temperature}");
    temperature
}

#[test]
#[ignore = "thorough"]
fn a_job_of_two_passes_sees_the_same_samples() {
    let studies = Studies::new(4096);
    let folder = studies.path().join("studies/radiator");
    let child = json!({
        "format": "bmv-pass/1",
        "title": "The same parameters, another limit",
        "parent": "pass-1.json",
        "requirements": {
            "radiator": {"quantity": "radiator temperature", "below": {"value": 40, "unit": "degC"}, "probability": 0.9}
        },
        "jobs": {"prior": {"propagate": {"samples": 4096, "sampling": "monte-carlo"}}}
    });
    fs::write(folder.join("pass-2.json"), child.to_string()).unwrap();
    studies.change_job(|job| job["sampling"] = json!("monte-carlo"));
    let first = studies.prior("cache");
    let second = studies.run(&["show", "studies/radiator/pass-2.json", "prior", "--json", "--run"], "cache").stdout;
    assert_ne!(first, second, "another requirement");
    assert_eq!(temperatures(&first), temperatures(&second), "the same random numbers");
    studies.change_pass(|pass| pass["seed"] = json!(2016));
    assert_ne!(temperatures(&studies.prior("cache")), temperatures(&first), "another seed");
}
