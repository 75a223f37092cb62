//! The house: rooms use only rooms before them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Rooms in order; those of one row may not use one another.
const ROWS: &[&[&str]] = &[
    &["watch"],
    &["math"],
    &["random", "expression"],
    &["statistics"],
    &["document"],
    &["thermal"],
    &["effect"],
    &["measurement"],
    &["inference"],
    &["diagnosis"],
    &["twin"],
    &["study"],
    &["job"],
    &["runner"],
    &["report"],
    &["batch"],
    &["import"],
    &["cli"],
];

fn row(room: &str) -> Option<usize> {
    ROWS.iter().position(|rooms| rooms.contains(&room))
}

/// Every source file of the rooms with its room and its text.
fn sources() -> Vec<(PathBuf, String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    for folder in ["core/src", "diagnosis/src", "src"].map(|folder| root.join(folder)) {
        for entry in walkdir::WalkDir::new(&folder).sort_by_file_name().into_iter().flatten() {
            let path = entry.path();
            if path.extension().is_none_or(|e| e != "rs") {
                continue;
            }
            let below = path.strip_prefix(&folder).expect("below the folder");
            let room = below.components().next().expect("a name").as_os_str().to_string_lossy().into_owned();
            let text = std::fs::read_to_string(path).expect("readable");
            found.push((path.strip_prefix(root).expect("below the root").to_owned(), room, text));
        }
    }
    found
}

#[test]
fn rooms_use_only_rooms_before_them() {
    let mut wrong = Vec::new();
    let mut seen = 0;
    for (relative, own, text) in sources() {
        let Some(own_row) = row(&own) else { continue };
        for (number, line) in text.lines().enumerate() {
            for part in line.split("crate::").skip(1) {
                let used: String = part.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
                let Some(used_row) = row(&used) else { continue };
                seen += 1;
                if used != own && used_row >= own_row {
                    wrong.push(format!("{}:{}: {own} uses {used}", relative.display(), number + 1));
                }
            }
        }
    }
    assert!(seen > 200, "the test reads the sources (saw {seen} uses)");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Paths that a text uses of its own crate: groups of `use` taken apart, `super` and `self` resolved.
fn used_paths(module: &[String], text: &str) -> Vec<Vec<String>> {
    let program: String = text.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join(" ");
    let mut paths = Vec::new();
    for start in ["crate::", "super::"] {
        for (at, _) in program.match_indices(start) {
            let is_word = program[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':');
            if !is_word {
                take_apart(&[], &program[at..], &mut paths);
            }
        }
    }
    let resolve = |path: Vec<String>| -> Vec<String> {
        let ups = path.iter().take_while(|part| *part == "super").count();
        let rest = path.iter().skip(if ups > 0 { ups } else { 1 }).cloned();
        let base = if ups > 0 { &module[..module.len().saturating_sub(ups)] } else { &[] };
        base.iter().cloned().chain(rest).collect()
    };
    paths.into_iter().map(resolve).collect()
}

/// One path, or those of a group in braces, at the start of a text.
fn take_apart(before: &[String], text: &str, paths: &mut Vec<Vec<String>>) {
    let mut path = before.to_vec();
    let mut rest = text.trim_start();
    loop {
        if let Some(group) = rest.strip_prefix('{') {
            let (mut depth, mut from) = (0, 0);
            for (at, c) in group.char_indices() {
                match c {
                    '{' => depth += 1,
                    '}' if depth > 0 => depth -= 1,
                    ',' | '}' if depth == 0 => {
                        take_apart(&path, &group[from..at], paths);
                        from = at + 1;
                        if c == '}' {
                            return;
                        }
                    }
                    _ => {}
                }
            }
            return;
        }
        let word: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        if word.is_empty() {
            break;
        }
        rest = &rest[word.len()..];
        path.push(word);
        match rest.strip_prefix("::") {
            Some(further) => rest = further,
            None => break,
        }
    }
    paths.push(path);
}

#[test]
fn folders_of_a_room_use_one_another_without_cycles() {
    let files: Vec<(Vec<String>, String)> = (sources().into_iter())
        .map(|(path, _, text)| {
            let parts: Vec<String> =
                path.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
            let below = parts.iter().position(|part| part == "src").expect("below src") + 1;
            let mut module: Vec<String> = parts[below..].to_vec();
            let last = module.pop().expect("a file");
            if last != "mod.rs" {
                module.push(last.trim_end_matches(".rs").to_owned());
            }
            (module, text)
        })
        .collect();
    let folders: BTreeSet<[String; 2]> = (files.iter())
        .filter(|(module, _)| module.len() > 2)
        .map(|(module, _)| [module[0].clone(), module[1].clone()])
        .collect();
    let folder = |path: &[String]| {
        let own = [path.first()?.clone(), path.get(1)?.clone()];
        folders.contains(&own).then_some(own)
    };
    let mut uses: BTreeMap<[String; 2], BTreeSet<[String; 2]>> = BTreeMap::new();
    for (module, text) in &files {
        let Some(own) = folder(module) else { continue };
        let used = used_paths(module, text).into_iter().filter_map(|path| folder(&path));
        uses.entry(own.clone()).or_default().extend(used.filter(|used| used[0] == own[0] && *used != own));
    }
    assert!(uses.values().map(BTreeSet::len).sum::<usize>() > 10, "the test reads the sources: {uses:?}");
    // What uses nothing that is left is taken away, until nothing is left but cycles.
    while let Some(free) = uses.iter().find(|(_, used)| used.iter().all(|own| !uses.contains_key(own))) {
        let free = free.0.clone();
        uses.remove(&free);
    }
    assert!(uses.is_empty(), "these use one another, or what does: {uses:?}");
}

#[test]
fn nalgebra_stays_without_its_cpu_dependent_kernels() {
    let lock = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.lock")).expect("lock file");
    let nalgebra = lock.split("[[package]]").find(|package| package.contains("\nname = \"nalgebra\"\n"));
    let dependencies = nalgebra.expect("nalgebra is used");
    assert!(!dependencies.contains("matrixmultiply"), "nalgebra's `std` feature picks kernels by CPU");
}

#[test]
fn the_large_crates_are_compiled_once() {
    // Their own tests are switched off in `Cargo.toml`: one in a source file would never run.
    let has_tests = |text: &str| text.contains("#[test]") || text.contains("#[cfg(test)]");
    let wrong: Vec<_> = sources().into_iter().filter(|(_, _, text)| has_tests(text)).map(|(path, ..)| path).collect();
    assert!(wrong.is_empty(), "tests of these belong below tests/rooms: {wrong:?}");
    // A test below `tests/rooms` lies at the path of the file that it names.
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let rooms = root.join("tests/rooms");
    let mut seen = 0;
    for entry in walkdir::WalkDir::new(&rooms).into_iter().flatten().filter(|entry| entry.file_type().is_file()) {
        let text = std::fs::read_to_string(entry.path()).expect("readable");
        seen += usize::from(has_tests(&text));
        let Some(named) = text.strip_prefix("//! Tests of `").and_then(|rest| rest.split('`').next()) else { continue };
        let module = |path: &str| path.trim_end_matches(".rs").trim_end_matches("/mod").to_owned();
        let own = entry.path().strip_prefix(&rooms).expect("below").to_string_lossy();
        let named = named.trim_start_matches("core/").trim_start_matches("diagnosis/src/").trim_start_matches("src/");
        assert_eq!(module(named), module(&own), "{}", entry.path().display());
    }
    assert!(seen > 100, "the test knows a test when it reads one (saw {seen} files)");
}

/// Files of the core that share their work among threads: likelihoods of several transients, and what the screening spends its time in.
const COMPUTE_IN_PARALLEL: &[&str] =
    &["inference/likelihood/mod.rs", "inference/null_maximum.rs", "math/scalar_products.rs"];

#[test]
fn threads_are_started_by_the_runner_the_search_of_effects_and_its_kernels() {
    let users: Vec<String> = (sources().into_iter())
        .filter(|(_, _, text)| text.contains("rayon"))
        .map(|(path, room, _)| format!("{room}: {}", path.display()))
        .filter(|user| !user.starts_with("runner: ") && !user.starts_with("diagnosis: "))
        .filter(|user| !COMPUTE_IN_PARALLEL.iter().any(|file| user.ends_with(file)))
        .collect();
    assert!(users.is_empty(), "{users:?}");
}

#[test]
fn files_are_touched_by_studies_the_runner_reports_batches_and_the_command_line() {
    let users: Vec<String> = (sources().into_iter())
        .filter(|(_, room, _)| !["study", "runner", "report", "batch", "cli"].contains(&room.as_str()))
        .filter(|(_, _, text)| text.contains("std::fs") || text.contains("File::open"))
        .map(|(path, _, _)| path.display().to_string())
        .collect();
    assert!(users.is_empty(), "{users:?}");
}

/// Job kinds with the section of the report on each.
const KINDS: &[(&str, &str)] = &[
    ("propagate", "propagation"),
    ("sensitivity", "sensitivity"),
    ("goal", "goal"),
    ("design", "design"),
    ("calibrate", "calibration"),
    ("compare", "comparison"),
    ("diagnose", "diagnosis"),
    ("discrepancy", "discrepancy"),
    ("predict", "prediction"),
    ("conventional", "sizing"),
    ("test_plan", "test_plan"),
    ("correlate", "margins"),
    ("margins_from_history", "margins_from_history"),
    ("surrogate", "surrogate"),
];

/// Files that name a kind's module without being its section, with the reason.
const NAMED_ELSEWHERE: &[(&str, &[&str], &str)] = &[
    ("report/section/summary", &["*"], "the first screen weighs the results of all kinds against one another"),
    (
        "report/section/validation.rs",
        &["calibrate", "compare", "predict", "propagate"],
        "a claim rests on the model's test, and on chains that converged",
    ),
    ("report/section/network/marked.rs", &["diagnose"], "draws what is missing where it is missing"),
    ("report/ladder.rs", &["compare"], "a comparison tells how the states of a model stand"),
    ("report/section/prediction", &["propagate"], "a prediction is two propagations"),
    ("report/section/sizing.rs", &["propagate"], "sizes by rule stand beside the probabilistic one"),
    (
        "report/section/figures",
        &["compare", "predict", "propagate"],
        "a study's figures draw test, prediction and fit in one",
    ),
    ("report/section/design_values.rs", &["conventional", "predict", "propagate"], "each way leads to a design value"),
    ("report/section/margins", &["compare", "conventional", "predict", "propagate"], "margins are judged side by side"),
    ("report/section/record", &["compare", "discrepancy"], "the record puts their results together"),
    ("report/section/compliance.rs", &["predict", "propagate"], "requirements are judged by either"),
    ("report/known.rs", &["calibrate"], "what is known of a parameter is had by it"),
    ("report/archive/record.rs", &["predict"], "what flies is what a prediction takes"),
    ("report/section/calibration.rs", &["compare"], "what tuning achieved is measured by a comparison"),
    ("report/view.rs", &["compare"], "whether rows of a comparison are steady phases"),
    ("report/history.rs", &["calibrate", "compare", "diagnose"], "these tell the error of a pass"),
    ("cli/compare.rs", &["compare"], "the verb for this kind"),
    ("cli/diagnose.rs", &["diagnose"], "the verb for this kind"),
    ("cli/adopt.rs", &["diagnose"], "adopts what a diagnosis found"),
    ("cli/test_plan.rs", &["test_plan"], "the verb for this kind"),
    ("cli/export.rs", &["calibrate"], "the verb for the draws of this kind"),
    ("batch/export", &["calibrate"], "completes the draws of a calibration by what they predict"),
    ("batch/next_pass", &["calibrate", "diagnose"], "writes the pass that adopts what a diagnosis found and judges it"),
];

/// The words of a text.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

/// The kinds whose modules a text names: `job::KIND`, or among others in `job::{...}`; the diagnosis is a room too.
fn kinds_named(text: &str) -> Vec<&'static str> {
    let mut named = Vec::new();
    for rest in text.split("job::").skip(1) {
        let list = match rest.strip_prefix('{') {
            Some(list) => list.split(';').next().unwrap_or_default(),
            None => words(rest).next().unwrap_or_default(),
        };
        named.extend(KINDS.iter().map(|(kind, _)| *kind).filter(|kind| words(list).any(|word| word == *kind)));
    }
    named.extend(text.contains("crate::diagnosis::").then_some("diagnose"));
    named.sort_unstable();
    named.dedup();
    named
}

#[test]
fn a_job_kind_is_named_in_its_section_and_in_the_registry_alone() {
    let (mut wrong, mut seen, mut used) = (Vec::new(), 0, vec![false; NAMED_ELSEWHERE.len()]);
    for (path, room, text) in sources() {
        if !["report", "batch", "cli"].contains(&room.as_str()) {
            continue;
        }
        let path = path.display().to_string();
        let path = path.trim_start_matches("src/");
        for kind in kinds_named(&text) {
            seen += 1;
            let is_section = KINDS.iter().any(|(own, section)| {
                let file = format!("report/section/{section}");
                *own == kind && path.strip_prefix(&file).is_some_and(|rest| rest.starts_with(['.', '/']))
            });
            let is_elsewhere = NAMED_ELSEWHERE.iter().zip(&mut used).any(|((file, kinds, _), used)| {
                let is_it = path.starts_with(file) && kinds.iter().any(|own| *own == kind || *own == "*");
                *used |= is_it;
                is_it
            });
            if !is_section && !is_elsewhere {
                wrong.push(format!("{path} names the kind {kind}"));
            }
        }
        let arms = KINDS.iter().map(|(kind, _)| format!("\"{kind}\" =>")).filter(|arm| text.contains(arm));
        wrong.extend(arms.map(|arm| format!("{path} matches {arm}")));
    }
    assert!(seen > 25, "the test reads the sources (saw {seen} uses)");
    let unused = NAMED_ELSEWHERE.iter().zip(&used).filter(|(_, used)| !**used);
    wrong.extend(unused.map(|((file, ..), _)| format!("{file} needs no exception any more")));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Element kinds: type, and the file of its physics and its form.
const ELEMENTS: &[(&str, &str)] = &[
    ("Conductor", "conductor.rs"),
    ("Radiation", "radiation.rs"),
    ("Load", "load.rs"),
    ("Flow", "flow.rs"),
    ("Cooler", "cooler.rs"),
    ("Heater", "heater.rs"),
    ("SurfaceCooler", "surface_cooler.rs"),
];

/// Folders and files that make elements of some kind, or change those of one, with the reason.
const MAKE_ELEMENTS: &[(&str, &str)] = &[
    ("core/src/thermal/element/mod.rs", "the list of kinds"),
    ("core/src/effect/apply/", "an effect adds paths and loads, cuts a conductor, changes a cooler"),
    ("diagnosis/src/twin/", "draws networks, and hides what the model lacks"),
    ("diagnosis/src/diagnosis/heat/sources.rs", "asks what heat a load in a node would have to bring"),
];

#[test]
fn an_element_kind_is_named_in_its_own_files_and_where_elements_are_made() {
    let (mut wrong, mut own) = (Vec::new(), 0);
    for (path, _, text) in sources() {
        let path = path.display().to_string();
        for (kind, file) in ELEMENTS {
            let name = format!("ElementKind::{kind}");
            if !text.contains(&name) {
                continue;
            }
            let is_own = path == format!("core/src/thermal/element/{file}");
            own += usize::from(is_own);
            if !is_own && !MAKE_ELEMENTS.iter().any(|(other, _)| path.starts_with(other)) {
                wrong.push(format!("{path} names {name}"));
            }
        }
        let forms = (ELEMENTS.iter()).filter(|(kind, file)| {
            let form = format!("{kind}Form");
            let is_named = text.contains(&form) && words(&text).any(|word| word == form);
            is_named && !["mod.rs", file].iter().any(|own| path == format!("core/src/thermal/element/{own}"))
        });
        wrong.extend(forms.map(|(kind, _)| format!("{path} names the form of {kind}")));
        // A pattern over several kinds is a decision that a new kind would miss.
        let arms = ELEMENTS.iter().filter(|(kind, _)| text.contains(&format!("ElementKind::{kind}(_) |")));
        wrong.extend(arms.map(|(kind, _)| format!("{path} decides by the kind {kind}")));
    }
    assert_eq!(own, ELEMENTS.len(), "each kind is resolved in its own file");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Paths of Rust files in backticks; those with a placeholder, as `NAME`, are patterns.
fn paths_named(line: &str) -> impl Iterator<Item = &str> {
    let is_path = |word: &&str| {
        let is_plain = word.chars().all(|c| c.is_ascii_alphanumeric() || "_/.-".contains(c));
        is_plain && word.ends_with(".rs") && !word.contains("NAME") && !word.contains("KIND")
    };
    line.split('`').skip(1).step_by(2).filter(is_path)
}

#[test]
fn files_that_texts_name_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let is_known = |entry: &walkdir::DirEntry| {
        entry.depth() == 0 || !["target", ".git", ".bmv"].iter().any(|name| entry.file_name() == *name)
    };
    let files: Vec<PathBuf> = (walkdir::WalkDir::new(root).sort_by_file_name().into_iter().filter_entry(is_known))
        .flatten()
        .filter(|entry| entry.file_type().is_file())
        .map(walkdir::DirEntry::into_path)
        .collect();
    let names: BTreeSet<&std::ffi::OsStr> = files.iter().filter_map(|file| file.file_name()).collect();
    let folders = ["", "core/src", "diagnosis/src", "src", "diagnosis/src/diagnosis"].map(|folder| root.join(folder));
    let (mut wrong, mut seen) = (Vec::new(), 0);
    for file in &files {
        let relative = file.strip_prefix(root).expect("below the root");
        let is_rust = file.extension().is_some_and(|e| e == "rs");
        let is_text = file.extension().is_some_and(|e| e == "md")
            && (relative.starts_with("docs") || relative.parent() == Some(Path::new("")));
        if !is_rust && !is_text {
            continue;
        }
        let text = std::fs::read_to_string(file).expect("readable");
        for (number, line) in text.lines().enumerate() {
            if is_rust && !line.trim_start().starts_with("//") {
                continue;
            }
            for path in paths_named(line) {
                seen += 1;
                // A name alone is that of any file.
                let is_there = if path.contains('/') {
                    let own = file.parent().map(|folder| folder.join(path));
                    folders.iter().map(|folder| folder.join(path)).chain(own).any(|path| path.is_file())
                } else {
                    names.contains(std::ffi::OsStr::new(path))
                };
                if !is_there {
                    wrong.push(format!("{}:{}: `{path}` is not there", relative.display(), number + 1));
                }
            }
        }
    }
    assert!(seen > 80, "the test reads the texts (saw {seen} paths)");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
