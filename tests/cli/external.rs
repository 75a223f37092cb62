//! Models that are asked outside: a radiator whose steady state has a closed form, as a network, as a command (a script of the
//! shell and `awk`) and as a server of the UM-Bridge protocol.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Instant;

use serde_json::{Value, json};
use tempfile::TempDir;

use super::studies::{bmv, code, text};

/// `sigma (eps A) T^4 = Q + sigma (eps A) T_sink^4`, as the network of one arithmetic node solves it.
const NODES: &str = r#""nodes": {"sink": {"boundary": "T_sink"}, "plate": {}},
 "radiations": {"face": {"between": ["plate", "sink"], "exchange_area": "eps * A"}},
 "loads": {"board": {"into": "plate", "power": "Q"}}, "quantities": {"plate": "plate"}"#;

/// The same by the closed form.
const SCRIPT: &str = r#"#!/bin/sh
. ./values
awk -v eps="$eps" -v A="$A" -v Q="$Q" -v Ts="$T_sink" 'BEGIN {
  s = 5.670374419e-8 * eps * A
  printf "{\"plate\": %.17g}\n", sqrt(sqrt(Q / s + Ts * Ts * Ts * Ts)) }' > out.json
"#;

const COMMAND: &str = r#""command": {"run": ["sim/plate.sh"],
   "input": {"templates": [{"file": "sim/values.in", "as": "values"}]},
   "outputs": {"plate": {"unit": "K", "from": {"json": {"file": "out.json", "pointer": "/plate"}}}}}"#;

const JOBS: &str = r#""prior": {"propagate": {"samples": 64}}, "effects": {"sensitivity": {"samples": 16, "scrambles": 2, "trajectories": 4}},
  "delivered": {"compare": {}}"#;

fn model(answer: &str) -> String {
    format!(
        r#"{{"format": "bmv-network/1",
 "inputs": {{"T_sink": {{"unit": "K", "nominal": 120}}, "Q": {{"unit": "W", "nominal": 20}}}},
 "parameters": {{"eps": {{"unit": "1", "nominal": 0.8, "prior": {{"uniform": [0.6, 0.95]}}}},
                "A": {{"unit": "m2", "nominal": 0.1, "prior": {{"normal": {{"mean": 0.1, "sd": 0.002}}}}}}}},
 {answer}}}"#
    )
}

fn pass(jobs: &str) -> String {
    format!(
        r#"{{"format": "bmv-pass/1", "title": "Plate", "parent": null, "model": "model.json", "seed": 3,
 "requirements": {{"plate": {{"quantity": "plate", "below": {{"value": 10, "unit": "degC"}}, "probability": 0.9}}}},
 "measurements": {{"balance": {{"steady": {{"file": "balance.csv",
   "sensors": {{"plate": {{"measures": "plate", "sigma": {{"value": 0.5, "unit": "K"}}}}}}}}}}}},
 "jobs": {{{jobs}}}}}"#
    )
}

/// A study whose model is this.
fn study(answer: &str, jobs: &str) -> TempDir {
    let root = tempfile::tempdir().expect("a folder");
    let study = root.path().join("m");
    fs::create_dir_all(study.join("sim")).expect("made");
    let write = |name: &str, text: &str| fs::write(study.join(name), text).expect("written");
    write("model.json", &model(answer));
    write("pass-1.json", &pass(jobs));
    write("balance.csv", "phase,T_sink [K],Q [W],plate [K]\nP1,120,20,259.4\nP2,100,10,217.2\nP3,140,30,287.9\n");
    write("sim/values.in", "eps={{eps}}\nA={{A}}\nQ={{ Q }}\nT_sink={{T_sink}}\n");
    script(&root, SCRIPT);
    root
}

/// Replaces the program.
fn script(root: &TempDir, text: &str) {
    use std::os::unix::fs::PermissionsExt;
    let place = root.path().join("m/sim/plate.sh");
    fs::write(&place, text).expect("written");
    fs::set_permissions(&place, fs::Permissions::from_mode(0o755)).expect("executable");
}

fn at(root: &TempDir, arguments: &[&str]) -> Output {
    let mut all = arguments.to_vec();
    all.extend(["--color", "never"]);
    bmv(root.path(), &all)
}

fn results(root: &TempDir, arguments: &[&str]) -> Value {
    let output = at(root, arguments);
    // Short chains need not have converged.
    assert!(matches!(code(&output), 0 | 4), "{}{}", text(&output.stdout), text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// What a run of one job says where it fails.
fn failure(root: &TempDir, arguments: &[&str]) -> String {
    let output = at(root, arguments);
    assert_ne!(code(&output), 0, "{}", text(&output.stdout));
    // Lines are folded.
    let said = text(&output.stdout) + &text(&output.stderr);
    said.split_whitespace().collect::<Vec<_>>().join(" ")
}

const ALLOWED: &str = "--allow-commands";

/// The largest difference of two results' numbers, relative to their size; texts are not compared.
fn apart(a: &Value, b: &Value) -> f64 {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap_or(0.0), b.as_f64().unwrap_or(0.0));
            (a - b).abs() / a.abs().max(b.abs()).max(1e-3)
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).map(|(a, b)| apart(a, b)).fold(0.0, f64::max)
        }
        (Value::Object(a), Value::Object(b)) if a.len() == b.len() => {
            a.iter().map(|(key, a)| b.get(key).map_or(f64::INFINITY, |b| apart(a, b))).fold(0.0, f64::max)
        }
        (Value::String(_), Value::String(_)) => 0.0,
        (a, b) => {
            if a == b {
                0.0
            } else {
                f64::INFINITY
            }
        }
    }
}

/// A result of a job.
fn result(root: &TempDir, job: &str, flags: &[&str]) -> Value {
    let mut arguments = vec!["show", "m/pass-1.json", job, "--json", "--run"];
    arguments.extend(flags);
    results(root, &arguments)
}

#[test]
#[ignore = "thorough"]
fn a_command_gives_what_the_network_gives() {
    let (network, command) = (study(NODES, JOBS), study(COMMAND, JOBS));
    let methods = JOBS.replace(r#"{"samples": 16"#, r#"{"methods": ["morris", "sobol"], "samples": 16"#);
    fs::write(network.path().join("m/pass-1.json"), pass(&methods)).expect("written");
    for job in ["prior", "effects", "delivered"] {
        let (a, b) = (result(&network, job, &[]), result(&command, job, &[ALLOWED]));
        // The network closes to 1e-9 W of 20 W and 1e-13 of its terms, the script prints 17 digits; indices are differences of
        // such numbers, of about a hundredth of them. Heat balances are the network's alone.
        let (mut a, mut b) = (a, b);
        for document in [&mut a, &mut b] {
            if let Some(fields) = document.as_object_mut() {
                fields.remove("heat");
            }
        }
        assert!(apart(&a, &b) < 1e-7, "{job}: {}\n{a}\n{b}", apart(&a, &b));
    }
    // Cached results need no permission, and no thread count changes them.
    let cached = result(&command, "prior", &[]);
    let again = result(&command, "prior", &["--cache", "other", "--threads", "1", ALLOWED]);
    assert_eq!(cached, again);
}

#[test]
fn nothing_runs_that_is_not_allowed_and_the_message_tells_how_to() {
    let root = study(COMMAND, r#""prior": {"propagate": {"samples": 64}}"#);
    let ran = root.path().join("ran");
    script(&root, &SCRIPT.replace("awk", &format!("touch {}; awk", ran.display())));
    let said = failure(&root, &["run", "m"]);
    assert!(said.contains("model.json:5:13: the model is a command"), "{said}");
    assert!(
        said.contains("it would run `sim/plate.sh` in an empty folder, with parameters and inputs in `values`"),
        "{said}"
    );
    assert!(said.contains("give --allow-commands"), "{said}");
    assert!(!ran.exists());
    // The line for the user's list allows it.
    let line = said.split("put the line `").nth(1).and_then(|rest| rest.split('`').next()).expect("a line").to_owned();
    let settings = root.path().join("settings/bmv");
    fs::create_dir_all(&settings).expect("made");
    fs::write(settings.join("allowed-commands"), format!("{line} plate\n")).expect("written");
    let run = |root: &TempDir| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bmv"));
        command.current_dir(root.path()).args(["run", "m"]).env("XDG_CONFIG_HOME", root.path().join("settings"));
        code(&command.output().expect("the program starts"))
    };
    script(&root, SCRIPT);
    assert_ne!(run(&root), 0, "another program needs another line");
    let said = failure(&root, &["run", "m"]);
    let line = said.split("put the line `").nth(1).and_then(|rest| rest.split('`').next()).expect("a line").to_owned();
    fs::write(settings.join("allowed-commands"), format!("# mine\n{line} plate\n")).expect("written");
    assert_eq!(run(&root), 0);
}

#[test]
#[ignore = "thorough"]
fn a_call_that_fails_is_data_and_says_why() {
    let root = study(
        &COMMAND.replace(r#""outputs""#, r#""timeout": 0.5, "outputs""#).replace(r#""K", "from""#, r#""degC", "from""#),
        r#""prior": {"propagate": {"samples": 4}}"#,
    );
    let failing = [
        ("echo garbage > out.json", "`out.json`: it is no JSON"),
        ("echo '{\"plate\": NaN}' > out.json", "`out.json`: NaN is not JSON (line 1): print a number"),
        ("echo '{\"plate\": \"warm\"}' > out.json", "`/plate` is \"warm\", which is no number"),
        ("echo '{\"plate\": -400}' > out.json", "an output is below absolute zero: `plate` is -400 degC"),
        ("echo '{\"other\": 3}' > out.json", "there is nothing at `/plate`"),
        ("true", "`out.json`: the program did not write it"),
        ("echo no licence >&2; exit 3", "the program did not succeed: exit status: 3; it said last: no licence"),
        ("kill -TERM $$; sleep 1", "the program was ended from outside (SIGTERM), so nothing is known of its point"),
        ("sleep 60 & sleep 61", "the program took longer than its timeout: it was ended after 0.5 s"),
        ("while :; do cat sim/plate.sh /bin/sh; done", "the program"),
    ];
    for (number, (line, reason)) in failing.into_iter().enumerate() {
        script(&root, &format!("#!/bin/sh\n# {number}\n{line}\n"));
        let begun = Instant::now();
        let said = failure(&root, &["run", "m", ALLOWED]);
        assert!(said.contains(reason), "{line}: {said}");
        assert!(begun.elapsed().as_secs() < 40, "{line}");
    }
    // Only some points fail: these are counted, with their parameters.
    let failing = SCRIPT.replace("awk -v", "case \"$eps\" in 0.6*) exit 4;; esac\nawk -v");
    script(&root, &failing);
    fs::write(
        root.path().join("m/pass-1.json"),
        pass(r#""prior": {"propagate": {"samples": 64, "failure_limit": 0.5}}"#),
    )
    .expect("written");
    let prior = result(&root, "prior", &[ALLOWED]);
    // A uniform prior from 0.6 to 0.95 has two sevenths of 64 Sobol points below 0.7: 18 or 19.
    let failed = prior["failed"].as_u64().expect("a number");
    assert!((18..=19).contains(&failed), "{failed}");
    // What the timeout ended has left nothing behind.
    let left = Command::new("sh").args(["-c", "ps -eo args | grep -c '^sleep 6[01]$'"]).output().expect("ps");
    assert_eq!(text(&left.stdout).trim(), "0");
}

#[test]
fn the_key_follows_program_files_and_version_and_not_their_dates() {
    let root = study(COMMAND, r#""prior": {"propagate": {"samples": 4}}"#);
    let key = |root: &TempDir| results(root, &["plan", "m", "--json"])[0]["key"].clone();
    let first = key(&root);
    assert!(first.is_string(), "{first}");
    script(&root, SCRIPT);
    assert_eq!(key(&root), first, "written anew with the same bytes");
    script(&root, &format!("{SCRIPT}\n"));
    let second = key(&root);
    assert_ne!(second, first);
    fs::write(root.path().join("m/sim/values.in"), "eps={{eps}}\nA={{A}}\nQ={{Q}}\nT_sink={{T_sink}} \n")
        .expect("written");
    let third = key(&root);
    assert_ne!(third, second);
    let with = |more: &str| {
        let command =
            COMMAND.replace(r#""run": ["sim/plate.sh"]"#, &format!(r#""run": ["sh", "sim/plate.sh"], {more}"#));
        fs::write(root.path().join("m/model.json"), model(&command)).expect("written");
        key(&root)
    };
    let versions = [
        with(r#""files": ["sim/plate.sh"], "version": "1""#),
        with(r#""files": ["sim/plate.sh"], "version": "2""#),
        with(r#""files": ["sim/plate.sh", "balance.csv"], "version": "2""#),
    ];
    assert!(versions[0] != versions[1] && versions[1] != versions[2] && versions[0] != third, "{versions:?}");
    // How many calls are made at a time is no part of it.
    assert_eq!(with(r#""files": ["sim/plate.sh", "balance.csv"], "version": "2", "at_once": 1"#), versions[2]);
}

#[test]
fn what_lies_outside_or_needs_a_network_is_refused_at_its_place() {
    let root = study(COMMAND, JOBS);
    let said = |answer: &str, jobs: &str| {
        fs::write(root.path().join("m/model.json"), model(answer)).expect("written");
        fs::write(root.path().join("m/pass-1.json"), pass(jobs)).expect("written");
        failure(&root, &["run", "m", ALLOWED])
    };
    let run = |program: &str| COMMAND.replace(r#"["sim/plate.sh"]"#, program);
    for (answer, reason) in [
        (run(r#"["../plate.sh"]"#), "the path `../plate.sh` leaves the study's folder"),
        (run(r#"["sim/nothing.sh"]"#), "the file `sim/nothing.sh` does not exist in the study's folder"),
        (run(r#"["/bin/sh", "x"]"#), "`/bin/sh` is no file of the study, and no `version` stands for it"),
        (run(r#"["sim/plate.sh", "{{epsilon}}"]"#), "unknown parameter or input `epsilon`"),
        (COMMAND.replace("out.json", "../out.json"), "the path `../out.json` leaves the folder in which the program runs"),
        (format!("{COMMAND}, {NODES}"), "a model that is asked outside has no nodes and elements of its own"),
        (
            r#""umbridge": {"url": "https://example.org", "name": "forward", "version": "1", "outputs": {"plate": {"unit": "K"}}}"#.to_owned(),
            "`https://example.org` is no address that can be asked",
        ),
        (
            r#""umbridge": {"url": "http://192.0.2.1:4242", "name": "forward", "version": "1", "outputs": {"plate": {"unit": "K"}}}"#.to_owned(),
            "`192.0.2.1` is not this machine, and models are asked on this machine alone: give --allow-remote-models",
        ),
        (
            r#""umbridge": {"url": "http://127.0.0.1:9", "name": "forward", "version": "1", "outputs": {"plate": {"unit": "K"}}}"#.to_owned(),
            "nothing answers at http://127.0.0.1:9",
        ),
    ] {
        let found = said(&answer, r#""prior": {"propagate": {"samples": 4}}"#);
        assert!(found.contains(reason), "{answer}\n{found}");
    }
    for (jobs, reason) in [
        (r#""x": {"diagnose": {}}"#, "pass-1.json:5:11"),
        (r#""x": {"diagnose": {}}"#, "`diagnose` works on the equations of a network, and this model is asked outside"),
        (r#""x": {"calibrate": {"sampler": "nuts"}}"#, "the sampler `nuts` follows derivatives"),
        (
            r#""x": {"design": {"conditions": {"Q": [10, 20]}, "sensors": ["plate"], "estimator": "linear"}}"#,
            "the estimator `linear` needs derivatives",
        ),
        (
            r#""x": {"sensitivity": {"methods": ["local"]}}"#,
            "give it `steps` of differences for all uncertain parameters",
        ),
    ] {
        let found = said(COMMAND, jobs);
        assert!(found.contains(reason), "{jobs}\n{found}");
    }
}

/// A served network, which ends with the test.
struct Server(Child, String);

impl Server {
    fn start(folder: &Path, port: &str) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_bmv"))
            .current_dir(folder)
            .args(["serve-model", "m/pass-1.json", "--port", port])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        let mut line = String::new();
        BufReader::new(process.stdout.take().expect("piped")).read_line(&mut line).expect("read");
        let url = line.trim().split(" at ").nth(1).unwrap_or_else(|| panic!("{line}")).to_owned();
        Self(process, url)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
#[ignore = "thorough"]
fn a_served_network_is_a_model_of_another_pass() {
    const CALIBRATION: &str =
        r#", "fit": {"calibrate": {"parameters": ["eps"], "sampler": "smc", "chains": 2, "draws": 32}}"#;
    const CHOICES: &str = r#", "phases": {"design": {"conditions": {"Q": [5, 20]}, "sensors": ["plate"], "learn": ["eps"], "nuisance": [],
        "estimator": "nested", "outer": 256, "inner": 4}},
      "linear": {"design": {"conditions": {"Q": [5, 20]}, "sensors": ["plate"], "estimator": "linear", "outer": 256, "inner": 4}},
      "goal": {"goal": {"parameters": ["eps"], "samples": 1024}}"#;
    let network = study(NODES, &format!("{JOBS}{CALIBRATION}{CHOICES}"));
    let server = Server::start(network.path(), "0");
    let served = |url: &str| {
        format!(
            r#""umbridge": {{"url": "{url}", "name": "forward", "version": "plate 1", "outputs": {{"plate": {{"unit": "K"}}}},
   "retries": 0, "steps": {{"eps": 1e-4, "A": 1e-5}}}}"#
        )
    };
    let client = study(&served(&server.1), &format!("{JOBS}{CALIBRATION}{CHOICES}"));
    // Prior and delivered state: the same solves, only where they start differs. The comparison also shows the tuned state, for
    // which the search climbs by differences.
    for (job, tolerance) in [("prior", 1e-9), ("delivered", 1e-6)] {
        let (mut a, mut b) = (result(&network, job, &[]), result(&client, job, &[]));
        for document in [&mut a, &mut b] {
            document.as_object_mut().expect("an object").remove("heat");
        }
        assert!(apart(&a, &b) < tolerance, "{job}: {}", apart(&a, &b));
    }
    // The choice of an experiment: nested Monte Carlo reads values alone, the linear estimate central differences.
    for (job, tolerance) in [("phases", 1e-7), ("linear", 1e-5), ("goal", 1e-9)] {
        let (a, b) = (result(&network, job, &[]), result(&client, job, &[]));
        assert!(apart(&a, &b) < tolerance, "{job}: {}\n{a}\n{b}", apart(&a, &b));
    }
    // With stated steps all methods run; central differences of 1e-4 of 0.8 have an error of their square, and of the
    // solution over the step.
    let (exact, differences) = (result(&network, "effects", &[]), result(&client, "effects", &[]));
    let local = |document: &Value| document["local"].clone();
    assert!(apart(&local(&exact), &local(&differences)) < 1e-6, "{}\n{}", local(&exact), local(&differences));
    // The estimate climbs by differences; the islands draw the same numbers and move by values alone.
    let (a, b) = (result(&network, "fit", &[]), result(&client, "fit", &[]));
    let of = |document: &Value, field: &str| {
        document["parameters"]["eps"][field].as_f64().unwrap_or_else(|| panic!("{document}"))
    };
    let sd = of(&a, "sd");
    assert!((of(&a, "map") - of(&b, "map")).abs() < 1e-3 * sd, "{} {}", of(&a, "map"), of(&b, "map"));
    assert!((of(&a, "mean") - of(&b, "mean")).abs() < 0.3 * sd, "{} {}", of(&a, "mean"), of(&b, "mean"));
}

#[test]
#[ignore = "thorough"]
fn derivatives_that_a_server_offers_are_used_where_the_study_says_so() {
    const FIT: &str = r#""fit": {"calibrate": {"parameters": ["eps"], "sampler": "nuts", "chains": 2, "warmup": 50, "draws": 50}},
      "linear": {"design": {"conditions": {"Q": [5, 20]}, "sensors": ["plate"], "estimator": "linear", "outer": 256, "inner": 4}},
      "effects": {"sensitivity": {"methods": ["local", "derivative"], "samples": 16}}"#;
    let network = study(NODES, FIT);
    let server = Server::start(network.path(), "0");
    // The unit of one output and of one input is another one than the server's, whose numbers are in SI units.
    let served = |more: &str| {
        format!(
            r#""umbridge": {{"url": "{}", "name": "forward", "version": "plate 1", "outputs": {{"plate": {{"unit": "degC"}}}},
   "units": "si", "retries": 0{more}}}"#,
            server.1
        )
    };
    let client = study(&served(r#", "derivatives": "served""#), FIT);
    // Both differentiate the same equations: by the implicit function theorem here and there.
    for (job, tolerance) in [("linear", 1e-8), ("effects", 1e-8)] {
        let (a, b) = (result(&network, job, &[]), result(&client, job, &[]));
        assert!(apart(&a, &b) < tolerance, "{job}: {}\n{a}\n{b}", apart(&a, &b));
    }
    let (a, b) = (result(&network, "fit", &[]), result(&client, "fit", &[]));
    let of = |document: &Value, field: &str| {
        document["parameters"]["eps"][field].as_f64().unwrap_or_else(|| panic!("{document}"))
    };
    let sd = of(&a, "sd");
    // A hundred draws each: the error of a mean is some 0.14 standard deviations, of a difference 0.2, of which two are allowed.
    assert!((of(&a, "map") - of(&b, "map")).abs() < 1e-6 * sd, "{} {}", of(&a, "map"), of(&b, "map"));
    assert!((of(&a, "mean") - of(&b, "mean")).abs() < 0.4 * sd, "{} {}", of(&a, "mean"), of(&b, "mean"));
    // Differences with stated steps do for trajectories too.
    let stated = study(&served(r#", "steps": {"eps": 1e-4, "A": 1e-5}"#), FIT);
    let c = result(&stated, "fit", &[]);
    assert!((of(&a, "mean") - of(&c, "mean")).abs() < 0.4 * sd, "{} {}", of(&a, "mean"), of(&c, "mean"));
    let said = |answer: &str| {
        fs::write(stated.path().join("m/model.json"), model(answer)).expect("written");
        failure(&stated, &["run", "m", ALLOWED])
    };
    let both = said(&served(r#", "derivatives": "served", "steps": {"eps": 1e-4}"#));
    assert!(both.contains("steps of differences beside derivatives that are served"), "{both}");
    // A served model that is itself asked outside offers none.
    let outside = study(&served(""), r#""prior": {"propagate": {"samples": 4}}"#);
    let again = Server::start(outside.path(), "0");
    let none = said(&served(r#", "derivatives": "served""#).replace(&server.1, &again.1));
    assert!(none.contains("offers neither Gradient nor ApplyJacobian"), "{none}");
}

#[test]
fn runs_behind_a_surrogate_are_those_of_every_pass_with_the_same_inputs() {
    let root = study(
        &format!(r#"{COMMAND}, "surrogate": {{"runs": 12, "rounds": 0}}"#),
        r#""prior": {"propagate": {"samples": 64}}"#,
    );
    let ran = root.path().join("ran");
    script(&root, &SCRIPT.replace("awk", &format!("echo run >> {}; awk", ran.display())));
    let count = || fs::read_to_string(&ran).map_or(0, |text| text.lines().count());
    let surrogate = result(&root, "surrogate", &[ALLOWED]);
    assert_eq!((count(), surrogate["runs"].clone()), (12, json!(12)));
    // Another noise is another surrogate, through the same runs.
    let precise = pass(r#""prior": {"propagate": {"samples": 64}}"#).replace(r#"{"value": 0.5,"#, r#"{"value": 0.3,"#);
    fs::write(root.path().join("m/pass-1.json"), precise).expect("written");
    let again = result(&root, "surrogate", &[ALLOWED]);
    assert_eq!(again["runs"], json!(12));
    assert_ne!(again["readings"], surrogate["readings"]);
    assert_eq!(count(), 12);
}

#[test]
#[ignore = "thorough"]
fn a_surrogate_gives_the_posterior_of_the_model_within_the_error_that_it_states() {
    const FIT: &str = r#""fit": {"calibrate": {"parameters": ["eps"], "sampler": "smc", "chains": 4, "draws": 128}}"#;
    const PRIOR: &str = r#""prior": {"propagate": {"samples": 1024}}"#;
    let network = study(NODES, &format!("{FIT}, {PRIOR}"));
    let server = Server::start(network.path(), "0");
    let served = |surrogate: &str| {
        format!(
            r#""umbridge": {{"url": "{}", "name": "forward", "version": "plate 1", "outputs": {{"plate": {{"unit": "K"}}}},
   "retries": 0}}, "surrogate": {surrogate}"#,
            server.1
        )
    };
    let client = study(&served(r#"{"runs": 24, "rounds": 2, "more": 6}"#), &format!("{FIT}, {PRIOR}"));
    let surrogate = result(&client, "surrogate", &[]);
    let plate = &surrogate["outputs"][0];
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{surrogate}"));
    let error = number(&plate["error"]);
    // A smooth function of four coordinates: below half of the noise of 0.5 K, of a spread of some 20 K.
    assert!(error > 0.0 && error < 0.25 && number(&plate["share"]) < 0.01, "{plate}");
    let reading = &surrogate["readings"][0];
    assert!(number(&reading["error"]) < 0.2 * number(&reading["noise"]), "{reading}");
    assert_eq!(
        (surrogate["failed"].clone(), surrogate["coordinates"].clone()),
        (json!(0), json!(["eps", "A", "T_sink", "Q"]))
    );
    // The same numbers are drawn: what is apart is the surrogate's error, and by it the particles' ways.
    let of = |document: &Value, field: &str| number(&document["parameters"]["eps"][field]);
    let (a, b) = (result(&network, "fit", &[]), result(&client, "fit", &[]));
    let sd = of(&a, "sd");
    assert!((of(&a, "mean") - of(&b, "mean")).abs() < 0.3 * sd, "{} {}", of(&a, "mean"), of(&b, "mean"));
    assert!((of(&b, "sd") / sd - 1.0).abs() < 0.3, "{sd} {}", of(&b, "sd"));
    assert!(b["parameters"]["plate.surrogate_error"]["sd"].is_number(), "its error is among what is inferred: {b}");
    // The prior's mean is that of the model but for the surrogate's error and that of 1024 Sobol points.
    let mean = |document: &Value| number(&document["quantities"]["plate"]["mean"]);
    let (a, b) = (result(&network, "prior", &[]), result(&client, "prior", &[]));
    assert!((mean(&a) - mean(&b)).abs() < error + 0.02, "{} {}", mean(&a), mean(&b));
    // Its runs are kept: with the server gone other jobs ask it all the same.
    drop(server);
    fs::write(client.path().join("m/pass-1.json"), pass(r#""more": {"propagate": {"samples": 64}}"#)).expect("written");
    assert_eq!(result(&client, "more", &[])["failed"], json!(0));
}

#[test]
fn a_surrogate_that_is_worse_than_the_readings_is_reported_and_one_that_cannot_be_is_refused() {
    let with = |surrogate: &str| format!(r#"{COMMAND}, "surrogate": {surrogate}"#);
    let root = study(&with(r#"{"runs": 12, "rounds": 0}"#), r#""prior": {"propagate": {"samples": 64}}"#);
    let precise = pass(r#""prior": {"propagate": {"samples": 64}}"#).replace(r#"{"value": 0.5,"#, r#"{"value": 0.02,"#);
    fs::write(root.path().join("m/pass-1.json"), precise).expect("written");
    let surrogate = result(&root, "surrogate", &[ALLOWED]);
    let findings = surrogate["findings"].to_string();
    assert!(findings.contains("exceeds the noise of `plate` of `balance`"), "{findings}");
    let shown = text(&at(&root, &["show", "m/pass-1.json"]).stdout);
    let shown = shown.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(shown.contains("All results rest on a surrogate") && shown.contains("exceeds the noise"), "{shown}");
    for (answer, reason) in [
        (with(r#"{"runs": 5}"#), "5 runs"),
        (
            with(r#"{"runs": 11}"#),
            "11 runs are too few for a surrogate over 4 parameters and inputs: `runs` from 12 on",
        ),
        (with(r#"{"runs": 900, "rounds": 20, "more": 50}"#), "at most 1000 runs in all"),
        (format!(r#"{NODES}, "surrogate": {{"runs": 40}}"#), "a surrogate stands for a model that is asked outside"),
    ] {
        fs::write(root.path().join("m/model.json"), model(&answer)).expect("written");
        let said = failure(&root, &["run", "m", ALLOWED]);
        assert!(said.contains(reason), "{answer}\n{said}");
    }
}

#[test]
#[ignore = "thorough"]
fn a_server_that_is_gone_fails_the_job_and_nothing_of_it_is_kept() {
    let network = study(NODES, JOBS);
    let server = Server::start(network.path(), "0");
    let port = server.1.rsplit(':').next().expect("a port").to_owned();
    let answer = format!(
        r#""umbridge": {{"url": "{}", "name": "forward", "version": "plate 1", "outputs": {{"plate": {{"unit": "K"}}}}, "retries": 0}}"#,
        server.1
    );
    let client = study(&answer, r#""prior": {"propagate": {"samples": 262144, "failure_limit": 1}}"#);
    let run = Command::new(env!("CARGO_BIN_EXE_bmv"))
        .current_dir(client.path())
        .args(["run", "m"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    std::thread::sleep(std::time::Duration::from_millis(1500));
    drop(server);
    let output = run.wait_with_output().expect("it ends");
    let said = text(&output.stderr) + &text(&output.stdout);
    assert_eq!(code(&output), 3, "{said}");
    assert!(said.split_whitespace().collect::<Vec<_>>().join(" ").contains("is gone"), "{said}");
    // At the same address the rest runs, and gives what it would have given.
    fs::write(
        client.path().join("m/pass-1.json"),
        pass(r#""prior": {"propagate": {"samples": 256, "failure_limit": 0}}"#),
    )
    .expect("written");
    let _server = Server::start(network.path(), &port);
    assert_eq!(result(&client, "prior", &[])["failed"], json!(0));
}

#[test]
fn exit_codes_of_which_there_is_none_are_refused_at_their_place() {
    let none = COMMAND.replacen("\"outputs\"", "\"exit_codes\": [], \"outputs\"", 1);
    let output = at(&study(&none, JOBS), &["plan", "m"]);
    let said = text(&output.stderr);
    assert_eq!(code(&output), 2, "{said}");
    assert!(said.contains("with no exit code at all no call succeeds") && said.contains("m/model.json:"), "{said}");
}
