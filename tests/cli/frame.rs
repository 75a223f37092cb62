//! The frame of the program: help, exit statuses, closed pipes, verbs that need no study.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use bmv::report::RenderedReport;
use bmv::runner::manifest::FileRecord;
use bmv::runner::{Cache, Key, Kind, Manifest};

fn bmv() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bmv"));
    command.env_remove("NO_COLOR");
    command
}

fn run(arguments: &[&str]) -> Output {
    bmv().args(arguments).output().expect("the program starts")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("ended by itself")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

fn display(path: &Path) -> &str {
    path.to_str().expect("a path of plain letters")
}

#[test]
fn help_names_every_verb_and_the_exit_statuses() {
    let output = run(&["--help"]);
    assert_eq!(code(&output), 0);
    let help = text(&output.stdout);
    for verb in [
        "run", "report", "compare", "adopt", "history", "show", "plan", "cache", "verify", "data", "schema", "explain",
        "init", "lab", "diff", "check",
    ] {
        assert!(help.contains(&format!("\n  {verb} ")), "{verb}: {help}");
        let output = run(&[verb, "--help"]);
        assert_eq!(code(&output), 0, "{verb}");
        let has_examples = text(&output.stdout).contains("\nExample");
        let is_daily = ["run", "report", "compare", "adopt", "history", "show", "plan", "init"].contains(&verb);
        assert!(has_examples || !is_daily, "{verb}: {}", text(&output.stdout));
    }
    let statuses = &help[help.find("Exit status:").expect("they are stated")..];
    assert!(statuses.contains("\n  130 interrupted"), "{help}");
    assert!(statuses.lines().all(|line| line.chars().count() <= 80), "{help}");
}

#[test]
fn shells_complete_every_verb() {
    for (shell, sign) in [("bash", "complete -F _bmv"), ("zsh", "#compdef bmv"), ("fish", "complete -c bmv")] {
        let output = run(&["completions", shell]);
        let script = text(&output.stdout);
        assert_eq!((code(&output), script.contains(sign)), (0, true), "{shell}");
        assert!(script.contains("watch") && script.contains("test-plan") && script.contains("allow-commands"));
    }
    assert_eq!(code(&run(&["completions", "tea"])), 2);
}

#[cfg(unix)]
#[test]
fn a_signal_before_any_job_runs_ends_with_130() {
    for signal in ["-INT", "-TERM"] {
        // A schema is longer than a pipe holds: the program stands still in the middle of its work.
        let mut child = bmv().args(["schema", "pass"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut first = [0];
        std::io::Read::read_exact(child.stdout.as_mut().unwrap(), &mut first).unwrap();
        assert_eq!(&first, b"{", "it writes");
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        let ended = child.wait().unwrap();
        assert_eq!(ended.code(), Some(130), "{signal}: {ended}");
    }
}

#[test]
fn wrong_arguments_end_with_two_and_say_so_on_standard_error() {
    for arguments in [&[][..], &["fly"], &["run", "--threads", "0"], &["show"], &["explain", "no-such-code"]] {
        let output = run(arguments);
        assert_eq!(code(&output), 2, "{arguments:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty(), "{arguments:?}");
    }
}

#[test]
fn explain_lists_and_explains_and_suggests() {
    let list = text(&run(&["explain"]).stdout);
    let first = list.split_whitespace().next().unwrap().to_owned();
    let output = run(&["explain", &first]);
    assert_eq!(code(&output), 0);
    assert!(text(&output.stdout).starts_with(&format!("{first}: ")));
    let near = text(&run(&["explain", &first[..first.len() - 1]]).stderr);
    assert!(near.contains(&format!("did you mean `{first}`?")), "{near}");
    use bmv::diagnosis::Verdict::{Adequate, Ambiguous, Identified, Unexplained};
    let verdicts = [Adequate, Identified, Ambiguous, Unexplained].map(bmv::diagnosis::Verdict::word);
    for word in verdicts.into_iter().chain(["group", "rivals", "Settled", "Pareto k"]) {
        let output = run(&["explain", word]);
        assert_eq!(code(&output), 0, "{word}");
        assert!(text(&output.stdout).lines().count() > 2, "{word}: meaning and what follows");
    }
    assert!(text(&run(&["explain", "ambigous"]).stderr).contains("did you mean `ambiguous`?"));
}

#[test]
fn errors_are_coloured_only_where_asked() {
    let plain = text(&run(&["explain", "x", "--color", "never"]).stderr);
    assert!(plain.starts_with("error: "), "{plain}");
    let coloured = text(&run(&["--color", "always", "explain", "x"]).stderr);
    assert!(coloured.starts_with("\u{1b}[1;31merror:"), "{coloured}");
    let piped = text(&run(&["explain", "x"]).stderr);
    assert_eq!(piped, plain, "no terminal, no colours");
}

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    for argument in ["explain", "--help"] {
        let mut child = bmv().arg(argument).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!((code(&output), text(&output.stderr)), (0, String::new()), "{argument}");
    }
}

#[test]
fn a_full_disk_under_standard_output_is_an_error_and_no_panic() {
    let Ok(full) = fs::File::options().write(true).open("/dev/full") else { return };
    for arguments in [&["explain"][..], &["--help"], &["--version"], &["plan", "--help"], &["schema", "model"]] {
        let full = full.try_clone().unwrap();
        let output = bmv().args(arguments).stdout(full).stderr(Stdio::piped()).output().unwrap();
        assert_eq!(code(&output), 3, "{arguments:?}");
        assert!(text(&output.stderr).starts_with("error: cannot write: "), "{}", text(&output.stderr));
    }
}

#[test]
fn cache_stat_and_verify_see_damage() {
    let folder = tempfile::tempdir().unwrap();
    let path = display(folder.path());
    assert_eq!(code(&run(&["cache", "stat", "--cache", &format!("{path}/none")])), 0);
    let (cache, name) = (Cache::new(folder.path()), Key::of(b"name"));
    cache.put(Kind::Result, &name, &name, b"{}").unwrap();
    let stat: serde_json::Value =
        serde_json::from_slice(&run(&["cache", "stat", "--json", "--cache", path]).stdout).unwrap();
    assert_eq!((&stat["results"], &stat["blocks"]), (&1.into(), &0.into()));
    let sound = run(&["cache", "verify", "--cache", path]);
    assert_eq!((code(&sound), text(&sound.stdout)), (0, "1 object sound, 0 damaged\n".to_owned()));
    fs::File::options().append(true).open(cache.path(&name)).unwrap().write_all(b"x").unwrap();
    let damaged = run(&["cache", "verify", "--cache", path]);
    assert_eq!(code(&damaged), 1);
    assert!(text(&damaged.stdout).starts_with(&format!("damaged: {name}\n")));
}

#[test]
fn verify_tells_what_changed_in_a_report() {
    let root = tempfile::tempdir().unwrap();
    let report = root.path().join("report");
    assert_eq!(code(&run(&["verify", display(&report)])), 2, "no manifest");
    let mut manifest = Manifest::new("bmv report");
    manifest.add_input("model.json", FileRecord::of(b"{}"));
    let results = "{\"pass\": \"pass-1.json\", \"jobs\": {}}\n".to_owned();
    let rendered = RenderedReport {
        markdown: "# Report".to_owned(),
        html: "<html></html>".to_owned(),
        figures: Vec::new(),
        data: Vec::new(),
        results_json: results,
        record_json: "{}\n".to_owned(),
        arrays: Vec::new(),
    };
    let rendered = rendered.sealed(manifest.origin_sha256().unwrap().as_str());
    bmv::report::write(&rendered, manifest, root.path(), Path::new("report")).unwrap();
    let intact = run(&["verify", display(&report)]);
    assert_eq!(
        (code(&intact), text(&intact.stdout)),
        (0, "input not here: model.json\n4 files unchanged; the report is as it was written\n".into())
    );
    fs::write(report.join("report.md"), "# Rep0rt").unwrap();
    fs::write(report.join("extra\u{1b}[2J.md"), "").unwrap();
    let altered = run(&["verify", display(&report)]);
    assert_eq!(code(&altered), 1);
    let said = text(&altered.stdout);
    assert!(said.starts_with("output changed: report.md\nextra: extra\\u{1b}[2J.md\n"), "{said}");
    let json: serde_json::Value = serde_json::from_slice(&run(&["verify", "--json", display(&report)]).stdout).unwrap();
    assert_eq!(json["changed"][0], "report.md");
}

#[test]
fn init_makes_a_study_and_replaces_nothing() {
    let root = tempfile::tempdir().unwrap();
    let study = root.path().join("new/study");
    let made = run(&["init", display(&study)]);
    assert_eq!(code(&made), 0, "{}", text(&made.stderr));
    for file in ["model.json", "pass-1.json"] {
        serde_json::from_slice::<serde_json::Value>(&fs::read(study.join(file)).unwrap()).unwrap();
    }
    fs::write(study.join("model.json"), "mine").unwrap();
    let again = run(&["init", display(&study)]);
    assert_eq!(code(&again), 2);
    assert_eq!(fs::read_to_string(study.join("model.json")).unwrap(), "mine");
}
