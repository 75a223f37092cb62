//! The house: rooms use only rooms before them.

use std::path::Path;

/// Rooms in order; those of one row may not use one another.
const ROWS: &[&[&str]] = &[
    &["watch"],
    &["math"],
    &["random", "expression"],
    &["statistics"],
    &["document"],
    &["thermal"],
    &["effect"],
    &["inference", "surrogate"],
    &["diagnosis"],
    &["job"],
    &["study"],
    &["runner"],
    &["report"],
    &["cli"],
];

fn row(room: &str) -> Option<usize> {
    ROWS.iter().position(|rooms| rooms.contains(&room))
}

#[test]
fn rooms_use_only_rooms_before_them() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut wrong = Vec::new();
    let mut seen = 0;
    for entry in walkdir::WalkDir::new(&src).sort_by_file_name().into_iter().flatten() {
        let path = entry.path();
        if path.extension().is_none_or(|e| e != "rs") {
            continue;
        }
        let relative = path.strip_prefix(&src).expect("below src");
        let own = relative.components().next().expect("a name").as_os_str().to_string_lossy().into_owned();
        let Some(own_row) = row(&own) else { continue };
        let text = std::fs::read_to_string(path).expect("readable");
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
    assert!(seen > 20, "the test reads the sources (saw {seen} uses)");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn nalgebra_stays_without_its_cpu_dependent_kernels() {
    let lock = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.lock")).expect("lock file");
    assert!(!lock.contains("name = \"matrixmultiply\""), "nalgebra's `std` feature picks kernels by CPU");
}
