//! The seal of a report: a last line in `report.md` and `report.html` from which its parts are held against one another.
//!
//! `<!-- bmv-seal/1 origin=HASH files=HASH text=HASH -->`, each a SHA-256: of the manifest without its outputs, of the
//! list of the other files with their hashes, and of all text before the line. A seal is no signature: who alters a
//! report can seal it again. It finds what was altered, or put together from two reports, without that.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use super::RenderedReport;
use super::archive::record::FILE_NAME as RECORD;
use crate::document::canonical::canonical;
use crate::document::hash::sha256_hex;
use crate::runner::manifest::{self, Manifest};
use crate::study::file;

const FORMAT: &str = "bmv-seal/1";
/// Files that carry the seal.
const SEALED: [&str; 2] = ["report.md", "report.html"];
/// The file of results.
const RESULTS: &str = "results.json";
/// Largest file of a report that is read, bytes.
const LARGEST: u64 = 1 << 30;

impl RenderedReport {
    /// The files of the report by their path in its folder.
    pub fn files(&self) -> BTreeMap<String, &[u8]> {
        let texts = [
            ("report.md", &self.markdown),
            ("report.html", &self.html),
            (RESULTS, &self.results_json),
            (RECORD, &self.record_json),
        ];
        let texts = texts.into_iter().map(|(name, text)| (name.to_owned(), text.as_bytes()));
        let plots = self.figures.iter().map(|(name, svg)| (format!("plots/{name}.svg"), svg.as_bytes()));
        let data = self.data.iter().map(|(name, csv)| (format!("plots/{name}.csv"), csv.as_bytes()));
        let arrays = self.arrays.iter().map(|(name, npy)| (array_path(name), npy.as_slice()));
        texts.chain(plots).chain(data).chain(arrays).collect()
    }

    /// The report with its seal; `origin` is the hash of where it comes from, [`Manifest::origin_sha256`].
    pub fn sealed(mut self, origin: &str) -> Self {
        let files = self.files().into_iter().map(|(name, bytes)| (name, sha256_hex(bytes)));
        let files = hash_of_list(files);
        for text in [&mut self.markdown, &mut self.html] {
            if !text.ends_with('\n') {
                text.push('\n');
            }
            let line = line([origin, &files, &sha256_hex(text.as_bytes())]);
            text.push_str(&line);
        }
        self
    }
}

/// The path of an array in a report's folder.
pub(super) fn array_path(name: &str) -> String {
    format!("results/{name}.npy")
}

/// The line of a seal.
fn line([origin, files, text]: [&str; 3]) -> String {
    format!("<!-- {FORMAT} origin={origin} files={files} text={text} -->\n")
}

/// Hash of the files that carry no seal.
fn hash_of_list(files: impl Iterator<Item = (String, String)>) -> String {
    let others = files.filter(|(name, _)| !SEALED.contains(&name.as_str()));
    sha256_hex(others.map(|(name, sha256)| format!("{sha256} {name}\n")).collect::<String>().as_bytes())
}

/// What a report's files say against one another and against its manifest: nothing, if it is as it was rendered.
///
/// # Errors
/// What the system says of a file that is there.
pub fn contradictions(manifest: &Manifest, folder: &Path) -> std::io::Result<Vec<String>> {
    let mut contradictions = Vec::new();
    for name in SEALED.into_iter().chain([RESULTS]) {
        if !manifest.outputs.contains_key(name) {
            contradictions.push(format!("{} lists no {name}", manifest::FILE_NAME));
        }
    }
    if manifest.inputs.is_empty() {
        contradictions.push(format!("{} lists no file of a study", manifest::FILE_NAME));
    }
    let origin = manifest.origin_sha256().map_err(std::io::Error::other)?;
    let files = manifest.outputs.iter().map(|(name, record)| (name.clone(), record.sha256.to_string()));
    let files = hash_of_list(files);
    for name in SEALED {
        let Some(text) = read(&folder.join(name))? else { continue };
        let sealed = text.strip_suffix('\n').unwrap_or(&text).rfind('\n').map(|end| text.split_at(end + 1));
        let Some((above, seal)) = sealed.filter(|(_, seal)| seal.starts_with(&format!("<!-- {FORMAT} "))) else {
            contradictions.push(format!("{name} has no seal: it was altered, or rendered by an earlier version"));
            continue;
        };
        let hash_above = sha256_hex(above.as_bytes());
        let whole = line([origin.as_str(), &files, &hash_above]);
        if seal != whole {
            let parts = seal.split(' ').zip(whole.split(' ')).filter(|(sealed_part, expected)| sealed_part != expected);
            let parts: Vec<&str> = parts.filter_map(|(_, expected)| meaning(expected)).collect();
            let parts = if parts.is_empty() { "another line".to_owned() } else { parts.join(", ") };
            contradictions.push(format!("the seal of {name} is that of {parts}"));
        }
    }
    if let Some(text) = read(&folder.join(RESULTS))? {
        contradictions.extend(results(manifest, &text));
    }
    Ok(contradictions)
}

/// Of what another part of a seal speaks.
fn meaning(part: &str) -> Option<&'static str> {
    match part.split_once('=')?.0 {
        "origin" => Some("other inputs, jobs or results"),
        "files" => Some("other figures or numbers behind them, another results.json or record.json"),
        "text" => Some("another text"),
        _ => None,
    }
}

/// What `results.json` says against the jobs of the manifest.
fn results(manifest: &Manifest, text: &str) -> Vec<String> {
    let whole: Value = match serde_json::from_str(text) {
        Ok(whole) => whole,
        Err(error) => return vec![format!("{RESULTS} is no JSON: {error}")],
    };
    // Other passes' jobs stand behind the history only.
    let pass = whole.get("pass").and_then(Value::as_str).unwrap_or_default();
    let mut pass_jobs: BTreeMap<&str, _> = manifest
        .jobs
        .iter()
        .filter_map(|(id, job)| {
            let (path, name) = id.rsplit_once(':')?;
            (path.rsplit('/').next() == Some(pass)).then_some((name, job))
        })
        .collect();
    let mut contradictions = Vec::new();
    for (name, job) in whole.get("jobs").and_then(Value::as_object).into_iter().flatten() {
        let Some(record) = pass_jobs.remove(name.as_str()) else {
            contradictions.push(format!("{} does not list the job `{name}` of {RESULTS}", manifest::FILE_NAME));
            continue;
        };
        let says = |field: &str| job.get(field).and_then(Value::as_str);
        if says("key") != Some(record.key.as_str()) || says("kind") != Some(&record.kind) {
            contradictions
                .push(format!("the job `{name}` has another key in {RESULTS} than in {}", manifest::FILE_NAME));
        }
        let output = job.get("output").and_then(|output| canonical(output).ok());
        if output.is_none_or(|text| sha256_hex(text.as_bytes()) != record.result_sha256.as_str()) {
            let file = manifest::FILE_NAME;
            contradictions.push(format!("the result of `{name}` in {RESULTS} has not the hash that {file} lists"));
        }
    }
    for (sha256, path) in whole.get("files").and_then(Value::as_object).into_iter().flatten() {
        let listed = path.as_str().and_then(|path| manifest.outputs.get(path));
        if listed.is_none_or(|record| record.sha256.as_str() != sha256) {
            contradictions
                .push(format!("{} does not list the array {sha256} at {path} of {RESULTS}", manifest::FILE_NAME));
        }
    }
    contradictions.extend(pass_jobs.into_keys().map(|name| format!("{RESULTS} lacks the job `{name}`")));
    contradictions
}

/// A file's text; nothing where that is missing or no regular file, which the verification tells by itself.
fn read(path: &Path) -> std::io::Result<Option<String>> {
    use std::io::ErrorKind as Kind;
    match file::read(path, LARGEST) {
        Ok(bytes) => Ok(Some(String::from_utf8_lossy(&bytes).into_owned())),
        Err(error) if matches!(error.kind(), Kind::NotFound | Kind::NotADirectory | Kind::InvalidData) => Ok(None),
        Err(error) => Err(error),
    }
}
