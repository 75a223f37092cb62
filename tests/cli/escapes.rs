//! Nothing of a study's files steers the terminal, whichever verb prints it.

use std::path::Path;

use super::studies::bmv;

/// Clears the screen, rings, ends strings, turns the direction of writing, begins a sequence in one byte.
const WILD: &str = "x\u{1b}[2J\u{7}\u{202e}\u{9b}8m";

fn study(folder: &Path) {
    let wild = serde_json::to_string(WILD).expect("JSON");
    let model = format!(
        r#"{{"format": "bmv-network/1", "title": {wild}, "inputs": {{"Q": {{"unit": "W", "nominal": 10, "description": {wild}}}}},
 "parameters": {{"G": {{"unit": "W/K", "nominal": 0.5, "prior": {{"uniform": [0.4, 0.6]}}, "description": {wild}, "source": {wild}}}}},
 "nodes": {{"plate": {{"capacity": 100}}, "wall": {{"boundary": 290}}}},
 "conductors": {{"mount": {{"between": ["plate", "wall"], "conductance": "G"}}}},
 "loads": {{"heater": {{"into": "plate", "power": "Q"}}}}}}"#
    );
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": {wild}, "description": {wild}, "parent": null,
 "measurements": {{"m": {{"steady": {{"file": "data/m.csv", "sensors": {{"plate": {{"measures": "plate", "sigma": 0.5}}}}}}}}}},
 "jobs": {{"delivered": {{"compare": {{}}}}, "tuned": {{"calibrate": {{"warmup": 50, "draws": 50}}}}}}}}"#
    );
    std::fs::create_dir_all(folder.join("data")).expect("made");
    std::fs::write(folder.join("model.json"), model).expect("written");
    std::fs::write(folder.join("pass-1.json"), pass).expect("written");
    std::fs::write(
        folder.join("data/m.csv"),
        format!("phase,Q [W],plate [K],{WILD}\nP\u{1b}[1m1,10,311,\nP2,5,301,\n"),
    )
    .expect("written");
}

/// The characters of an output that must not be there; colours of the program's own aside.
fn steering(output: &[u8]) -> Vec<char> {
    let text = String::from_utf8_lossy(output);
    text.chars()
        .filter(|&c| (c.is_control() && c != '\n') || matches!(c, '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}'))
        .collect()
}

#[test]
fn no_verb_passes_on_what_steers_a_terminal() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join("a\u{1b}[31mb\u{202e}c");
    study(&folder);
    let shown = folder.display().to_string();
    for arguments in [
        &["plan", &shown][..],
        &["plan", &shown, "--json"],
        &["run", &shown],
        &["compare", &shown, "--rows", "all"],
        &["compare", &shown, "--json"],
        &["show", &shown],
        &["history", &shown],
        &["history", &shown, "--json"],
        &["report", &shown],
        &["show", &shown, "no\u{1b}[2Jjob"],
    ] {
        let output = bmv(root.path(), arguments);
        for (what, bytes) in [("stdout", &output.stdout), ("stderr", &output.stderr)] {
            let text = String::from_utf8_lossy(bytes);
            assert!(steering(bytes).is_empty(), "{arguments:?} {what}: {text:?}");
        }
    }
    let written = walk(root.path());
    for extension in ["md", "html", "svg", "jsonl"] {
        let files: Vec<_> =
            written.iter().filter(|path| path.extension().is_some_and(|own| own == extension)).collect();
        assert!(!files.is_empty(), "{extension}: {written:?}");
        for path in files {
            let bytes = std::fs::read(path).expect("readable");
            // Tabs part the values that a page tells.
            let steering: Vec<char> =
                steering(&bytes).into_iter().filter(|c| extension != "html" || *c != '\t').collect();
            assert!(steering.is_empty(), "{}: {steering:?}", path.display());
        }
    }
}

#[test]
fn no_diagnostic_passes_on_what_steers_a_terminal() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join("a\u{1b}[31mb\u{202e}c");
    let wild = serde_json::to_string(WILD).expect("JSON");
    for (file, text) in [
        ("data/m.csv", format!("phase,Q [{WILD}],pla{WILD}te [K]\nP1,10,{WILD}\n")),
        (
            "pass-1.json",
            format!(
                r#"{{"format": "bmv-pass/1", {wild}: {wild}, "model": {wild}, "jobs": {{{wild}: {{{wild}: 1}}}}}}"#
            ),
        ),
        ("model.json", format!(r#"{{"format": {wild}, "parameters": {{{wild}: {{"nominal": {wild}}}}}}}"#)),
        ("model.json", format!("{{\"format\": {WILD}")),
    ] {
        study(&folder);
        std::fs::write(folder.join(file), text).expect("written");
        let output = bmv(root.path(), &["plan", &folder.display().to_string()]);
        assert_eq!(output.status.code(), Some(2), "{file}");
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(steering(&output.stderr).is_empty(), "{file}: {text:?}");
        assert!(text.contains("error[") && text.contains("\\u{"), "{file}: {text:?}");
    }
}

fn walk(folder: &Path) -> Vec<std::path::PathBuf> {
    walkdir::WalkDir::new(folder)
        .into_iter()
        .flatten()
        .map(walkdir::DirEntry::into_path)
        .filter(|path| path.is_file())
        .collect()
}
