//! Reports as an archive: what their manifests certify, where they lie, and what `verify` finds.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use super::studies::{bmv, code, plate, printed, text};

const REPORT: &str = "reports/plate/pass-1";

/// All files below a folder by their path in it.
pub(super) fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let entries = walkdir::WalkDir::new(folder).into_iter().map(|entry| entry.expect("listed"));
    let files = entries.filter(|entry| entry.file_type().is_file());
    let content = |path: &Path| (path.strip_prefix(folder).unwrap().to_owned(), fs::read(path).unwrap());
    files.map(|entry| content(entry.path())).collect()
}

pub(super) fn sha256(bytes: &[u8]) -> String {
    bmv::runner::Key::of(bytes).to_string()
}

fn manifest(root: &Path) -> Value {
    serde_json::from_slice(&fs::read(root.join(REPORT).join("manifest.json")).unwrap()).unwrap()
}

#[test]
fn the_manifest_has_the_bytes_that_were_loaded() {
    let root = plate();
    let study = root.path().join("plate");
    fs::create_dir(study.join("rules")).unwrap();
    let rule = r#"{"format": "bmv-rule/1", "title": "ours", "margin": {"temperature": 7}, "source": "house rule"}"#;
    fs::write(study.join("rules/ours.json"), rule).unwrap();
    let pass = fs::read_to_string(study.join("pass-1.json")).unwrap();
    fs::write(study.join("pass-1.json"), pass.replace("\"samples\": 64", "\"samples\": 60000")).unwrap();
    let before = files(&study);
    let mut child = Command::new(env!("CARGO_BIN_EXE_bmv"))
        .current_dir(root.path())
        .args(["report", "plate"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap()).lines();
    // The study is loaded when its first job starts; whatever is written from then on is not what was run.
    assert!(said.any(|line| line.unwrap().contains(": started (")));
    for name in before.keys() {
        let mut changed = before[name].clone();
        changed.push(b'\n');
        fs::write(study.join(name), changed).unwrap();
    }
    said.for_each(drop);
    assert!(child.wait().unwrap().success());
    let inputs = manifest(root.path())["inputs"].as_object().unwrap().clone();
    let listed = inputs.iter().map(|(name, record)| (name.as_str(), record["sha256"].as_str().unwrap().to_owned()));
    let loaded = before.iter().map(|(name, bytes)| (name.to_str().unwrap(), sha256(bytes)));
    let loaded: BTreeMap<String, String> = loaded.map(|(name, hash)| (format!("plate/{name}"), hash)).collect();
    assert_eq!(listed.map(|(name, hash)| (name.to_owned(), hash)).collect::<BTreeMap<_, _>>(), loaded);
    let altered = bmv(root.path(), &["verify", REPORT]);
    assert_eq!(code(&altered), 1);
    let said = text(&altered.stdout);
    assert!(said.contains("input changed: plate/model.json\n") && said.contains("its inputs are others now"), "{said}");
}

#[test]
#[ignore = "thorough"]
fn a_report_is_the_same_however_the_study_is_named_and_wherever_from() {
    let root = plate();
    let (study, other) = (root.path().join("plate"), root.path().join("other"));
    fs::create_dir(&other).unwrap();
    let pinned =
        format!(r#""pinned": {{"sha256": "{}"}}, "columns": {{"Q": {{"header": "Q", "unit": "W"}}"#, "0".repeat(64));
    let pass = fs::read_to_string(study.join("pass-1.json")).unwrap();
    // A measurement that is not here: the report says how to bring it.
    let pass = pass.replace(r#""measurements": {"#, &format!(r#""measurements": {{"missing": {{"steady": {{"file": "data/missing.csv", {pinned}}}, "sensors": {{"plate": {{"measures": "plate", "sigma": {{"value": 0.5, "unit": "K"}}}}}}}}}}, "#));
    let pass = pass.replace(r#""delivered": {"#, r#""later": {"compare": {"data": ["missing"]}}, "delivered": {"#);
    fs::write(study.join("pass-1.json"), pass).unwrap();
    let absolute = study.display().to_string();
    let ways: [(&Path, &[&str], &str); 8] = [
        (root.path(), &["plate"], REPORT),
        (root.path(), &["./plate/"], REPORT),
        (root.path(), &["plate/../plate/./pass-1.json"], REPORT),
        (root.path(), &[&absolute, "plate"], REPORT),
        (&other, &["../plate"], "../reports/plate/pass-1"),
        (&study, &[], "../reports/plate/pass-1"),
        (&study, &["./pass-1.json"], "../reports/plate/pass-1"),
        (&study.join("data"), &[], "../../reports/plate/pass-1"),
    ];
    let mut first = None;
    for (from, paths, report) in ways {
        let _ = fs::remove_dir_all(root.path().join("reports"));
        let arguments: Vec<&str> = ["report"].into_iter().chain(paths.iter().copied()).collect();
        assert_eq!(printed(from, &arguments), format!("{report}/report.html\n"), "{paths:?}");
        let written = files(&root.path().join(REPORT));
        assert!(first.get_or_insert_with(|| written.clone()) == &written, "{paths:?} from {}", from.display());
        for verifier in [root.path(), &study, &other] {
            let said = printed(verifier, &["verify", &root.path().join(REPORT).display().to_string()]);
            assert!(said.ends_with("the report is as it was written\n") && !said.contains("not here"), "{said}");
        }
        // One cache, wherever from.
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 4, "{paths:?}: plate, other, reports, .bmv");
        assert!(printed(from, &[&["plan"], paths].concat()).contains("\n0 of 2 jobs to run"), "{paths:?}");
    }
    let report = String::from_utf8(first.unwrap()[Path::new("report.md")].clone()).unwrap();
    assert!(report.contains("bmv report plate/pass-1.json") && report.contains("bmv data get plate\\`"), "{report}");
    // What is named explicitly wins.
    let out = other.join("out");
    printed(&study, &["report", "--out", "../other/out", "--cache", "../other/cache"]);
    assert!(out.join("plate/pass-1/report.html").is_file() && other.join("cache/objects").is_dir());
    assert_eq!(files(&out.join("plate/pass-1")), files(&root.path().join(REPORT)));
}

#[test]
fn two_studies_of_one_name_do_not_replace_each_others_reports() {
    let (root, second) = (plate(), plate());
    fs::create_dir_all(root.path().join(".git")).unwrap();
    fs::create_dir_all(root.path().join("b")).unwrap();
    fs::rename(second.path().join("plate"), root.path().join("b/plate")).unwrap();
    let both = bmv(root.path(), &["report", "plate", "b"]);
    assert_eq!(code(&both), 2);
    let said = text(&both.stderr);
    assert!(
        said.contains("`b/plate/pass-1.json` and `plate/pass-1.json` would both lie in `reports/plate/pass-1`"),
        "{said}"
    );
    assert!(said.contains("--out") && !root.path().join("reports").exists(), "{said}");
    printed(root.path(), &["report", "plate"]);
    let before = files(&root.path().join(REPORT));
    let other = bmv(root.path(), &["report", "b/plate"]);
    assert_eq!(code(&other), 2);
    let said = text(&other.stderr);
    assert!(said.contains("holds the report of `plate/pass-1.json`, a study of the same name"), "{said}");
    assert_eq!(files(&root.path().join(REPORT)), before);
    printed(root.path(), &["report", "b/plate", "--out", "reports/b"]);
    assert!(root.path().join("reports/b/plate/pass-1/report.md").is_file());
    printed(root.path(), &["report", "plate"]);
}

/// A report, altered by `alter`, which gets its folder and manifest; what `verify` says of it.
fn forged(alter: impl Fn(&Path, &mut Value)) -> (i32, String) {
    let root = plate();
    printed(root.path(), &["report", "plate"]);
    let mut listed = manifest(root.path());
    alter(&root.path().join(REPORT), &mut listed);
    fs::write(root.path().join(REPORT).join("manifest.json"), listed.to_string()).unwrap();
    let output = bmv(root.path(), &["verify", REPORT]);
    (code(&output), text(&output.stdout))
}

/// Replaces a text in a file of a report and corrects the manifest's record of that file.
fn replace(folder: &Path, manifest: &mut Value, file: &str, from: &str, to: &str) {
    let before = fs::read_to_string(folder.join(file)).unwrap();
    let after = before.replace(from, to);
    assert_ne!(before, after, "{file} has {from}");
    fs::write(folder.join(file), &after).unwrap();
    manifest["outputs"][file] = serde_json::json!({"bytes": after.len(), "sha256": sha256(after.as_bytes())});
}

#[test]
#[ignore = "thorough"]
fn verify_holds_the_files_of_a_report_against_one_another() {
    assert_eq!(forged(|_, _| {}).0, 0);
    let zero = "0".repeat(64);
    let key = "plate/pass-1.json:prior";
    type Alter<'a> = &'a dyn Fn(&Path, &mut Value);
    let zeroed: Alter = &|_, manifest| {
        for (_, job) in manifest["jobs"].as_object_mut().unwrap() {
            job["result_sha256"] = zero.as_str().into();
        }
    };
    let other_input: Alter = &|_, manifest| manifest["inputs"]["plate/model.json"]["sha256"] = zero.as_str().into();
    let no_files: Alter = &|folder, manifest| {
        for list in ["inputs", "jobs", "outputs"] {
            manifest[list] = serde_json::json!({});
        }
        for file in files(folder).keys() {
            fs::remove_file(folder.join(file)).unwrap();
        }
    };
    let html: Alter = &|folder, manifest| replace(folder, manifest, "report.html", "not met", "met");
    let results: Alter = &|folder, manifest| replace(folder, manifest, "results.json", "0.609375", "0.909375");
    let plot: Alter = &|folder, manifest| replace(folder, manifest, "plots/network.svg", "plate", "plane");
    let unsealed: Alter = &|folder, manifest| replace(folder, manifest, "report.md", "bmv-seal/1", "bmv-note/1");
    let no_job: Alter = &|_, manifest| drop(manifest["jobs"].as_object_mut().unwrap().remove(key));
    let cases: [(Alter, &str); 8] = [
        (zeroed, "the result of `prior` in results.json has not the hash that manifest.json lists"),
        (zeroed, "the seal of report.html is that of other inputs, jobs or results"),
        (other_input, "the seal of report.md is that of other inputs, jobs or results"),
        (no_files, "manifest.json lists no report.html"),
        (html, "the seal of report.html is that of another text"),
        (
            results,
            "the seal of report.md is that of other figures or numbers behind them, another results.json or record.json",
        ),
        (
            plot,
            "the seal of report.html is that of other figures or numbers behind them, another results.json or record.json",
        ),
        (unsealed, "report.md has no seal"),
    ];
    for (alter, part) in cases {
        let (status, said) = forged(alter);
        assert_eq!(status, 1, "{part}: {said}");
        assert!(said.contains(&format!("contradiction: {part}")), "{part}: {said}");
    }
    let (status, said) = forged(no_job);
    assert!(status == 1 && said.contains("manifest.json does not list the job `prior`"), "{said}");
}

#[cfg(unix)]
#[test]
fn archives_and_next_passes_are_not_written_through_links() {
    use bmv::document::{Place, Source, Span};
    let (root, outside) = (plate(), tempfile::tempdir().unwrap());
    let study = root.path().join("plate");
    let foreign = outside.path().join("prior.json");
    fs::write(&foreign, "foreign").unwrap();
    fs::create_dir_all(study.join("baseline")).unwrap();
    std::os::unix::fs::symlink(outside.path(), study.join("baseline/pass-1")).unwrap();
    let archived = bmv(root.path(), &["check", "plate", "--renew", "--because", "x"]);
    assert_eq!(code(&archived), 3);
    assert!(text(&archived.stderr).contains("is a link, and nothing is written through links"));

    std::os::unix::fs::symlink(&foreign, study.join("pass-2.json")).unwrap();
    let pass = fs::read_to_string(study.join("pass-1.json")).unwrap();
    let place = Place::in_text(&Source::new("bmv adopt", ""), Span::default());
    for replaces in [true, false] {
        let refused = bmv::batch::next_pass::write(&pass, &[], &study.join("pass-2.json"), replaces, &place);
        assert!(refused.is_err());
    }
    assert_eq!(fs::read(&foreign).unwrap(), b"foreign");
    assert_eq!(fs::read_dir(outside.path()).unwrap().count(), 1);
    fs::remove_file(study.join("pass-2.json")).unwrap();
    bmv::batch::next_pass::write(&pass, &[], &study.join("pass-2.json"), false, &place).unwrap();
    bmv::batch::next_pass::write(&pass, &[], &study.join("pass-2.json"), true, &place).unwrap();
    assert!(bmv::batch::next_pass::write(&pass, &[], &study.join("pass-2.json"), false, &place).is_err());
}

#[cfg(unix)]
#[test]
fn a_cache_that_cannot_be_written_does_not_stop_a_report() {
    let root = plate();
    fs::write(root.path().join("cache"), "a file where the folder should be").unwrap();
    let output = bmv(root.path(), &["report", "plate", "--cache", "cache"]);
    let said = text(&output.stderr);
    assert_eq!(code(&output), 0, "{said}");
    assert_eq!(said.matches("warning: not all results are kept in the cache").count(), 1, "{said}");
    assert!(printed(root.path(), &["verify", REPORT]).ends_with("the report is as it was written\n"));
}

/// A browser's part is played by a script: that it was asked for what is wanted, and what is said where it fails.
#[cfg(unix)]
#[test]
fn reports_are_printed_by_a_browser() {
    use std::os::unix::fs::PermissionsExt;
    let root = plate();
    let script = |body: &str| {
        let place = root.path().join("browser");
        fs::write(&place, format!("#!/bin/sh\n{body}\n")).unwrap();
        fs::set_permissions(&place, fs::Permissions::from_mode(0o755)).unwrap();
        place
    };
    let run = |browser: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bmv"));
        command.current_dir(root.path()).env("BMV_BROWSER", browser);
        command.args(["report", "plate", "--pdf", "for review"]).output().unwrap()
    };
    let wanted = r#"for a in "$@"; do case "$a" in --print-to-pdf=*) to="${a#*=}";; file://*) page="$a";; esac; done
printf '%%PDF-1.7 %s' "$page" > "$to""#;
    let output = run(&script(wanted));
    assert!(output.status.success(), "{output:?}");
    let printed = fs::read_to_string(root.path().join("for review/plate-pass-1.pdf")).unwrap();
    assert!(printed.starts_with("%PDF-1.7 file:///") && printed.ends_with("/reports/plate/pass-1/report.html"));
    assert!(String::from_utf8_lossy(&output.stdout).contains("plate-pass-1.pdf"));
    let output = run(&script("echo no display >&2; exit 3"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.code() == Some(2) && said.contains("printed no PDF") && said.contains("no display"),
        "{said}"
    );
    let output = run(Path::new("/nowhere/browser"));
    assert_eq!(output.status.code(), Some(2), "{output:?}");
}
