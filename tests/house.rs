//! The house: rooms use only rooms before them.

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
    &["inference"],
    &["diagnosis"],
    &["study"],
    &["job"],
    &["runner"],
    &["report"],
    &["cli"],
];

fn row(room: &str) -> Option<usize> {
    ROWS.iter().position(|rooms| rooms.contains(&room))
}

/// Every source file of the rooms with its room and its text.
fn sources() -> Vec<(PathBuf, String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    for folder in ["core/src", "src"].map(|folder| root.join(folder)) {
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

#[test]
fn nalgebra_stays_without_its_cpu_dependent_kernels() {
    let lock = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.lock")).expect("lock file");
    assert!(!lock.contains("name = \"matrixmultiply\""), "nalgebra's `std` feature picks kernels by CPU");
}

/// The text before a file's tests.
fn program(text: &str) -> &str {
    text.split("#[cfg(test)]\nmod ").next().unwrap_or(text)
}

#[test]
fn threads_are_started_by_the_runner_and_by_the_screening_of_effects() {
    let users: Vec<String> = (sources().into_iter())
        .filter(|(_, _, text)| program(text).contains("rayon"))
        .map(|(path, room, _)| format!("{room}: {}", path.display()))
        .filter(|user| !user.starts_with("runner: ") && !user.contains("diagnosis/linearisation/signature/"))
        .collect();
    assert!(users.is_empty(), "{users:?}");
}

#[test]
fn files_are_touched_by_studies_the_runner_reports_and_the_command_line() {
    let users: Vec<String> = (sources().into_iter())
        .filter(|(_, room, _)| !["study", "runner", "report", "cli"].contains(&room.as_str()))
        .filter(|(_, _, text)| program(text).contains("std::fs") || program(text).contains("File::open"))
        .map(|(path, _, _)| path.display().to_string())
        .collect();
    assert!(users.is_empty(), "{users:?}");
}
