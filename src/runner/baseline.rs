//! Archived results of a study, in `baseline/PASS/JOB.json`, against which the nightly check holds a fresh run.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::difference::{Difference, differences};
use super::error::RunnerError;
use crate::study::file::{self, Existing};

/// Largest archived result that is read, bytes.
const LARGEST: u64 = 1 << 30;

/// Where a job's archived result lies in the study's folder: names of jobs may hold any character, so those that file systems treat in their
/// own way are written as `%` and their code.
pub fn path(pass: &str, job: &str) -> PathBuf {
    let pass = pass.strip_suffix(".json").unwrap_or(pass);
    Path::new("baseline").join(file_name(pass)).join(format!("{}.json", file_name(job)))
}

fn file_name(name: &str) -> String {
    let mut out = String::new();
    for (position, character) in name.chars().enumerate() {
        let is_plain = character.is_alphanumeric() || matches!(character, '-' | '_' | ' ' | '+');
        if is_plain || (character == '.' && position > 0) {
            out.push(character);
        } else {
            out.push_str(&format!("%{:02X}", u32::from(character)));
        }
    }
    out
}

/// Compares a result with the one archived at a path. Nothing if none is archived.
///
/// # Errors
/// [`RunnerError::File`] if it cannot be read, [`RunnerError::NotCanonical`] if it is no JSON.
pub fn compare(path: &Path, result: &Value) -> Result<Option<Vec<Difference>>, RunnerError> {
    let text = match file::read(path, LARGEST) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        read => read.map_err(RunnerError::file("read", path))?,
    };
    let archived: Value = serde_json::from_slice(&text).map_err(|error| RunnerError::NotCanonical {
        what: format!("the archived result `{}`", path.display()),
        reason: error.to_string(),
    })?;
    Ok(Some(differences(&archived, result)))
}

/// Archives a result at its path in the study's folder, indented so that it can be read and compared line by line.
///
/// # Errors
/// [`RunnerError::File`] if the system refuses, or a link is in the way.
pub fn archive(study: &Path, path: &Path, result: &Value) -> Result<(), RunnerError> {
    let text = format!("{result:#}\n");
    file::write(study, path, text.as_bytes(), Existing::Replace).map_err(RunnerError::file("write", study.join(path)))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use serde_json::json;

    use super::*;

    #[test]
    fn what_was_archived_is_compared_exactly() {
        let study = tempfile::tempdir().unwrap();
        let inside = path("pass-1.json", "before");
        assert_eq!(inside, Path::new("baseline/pass-1/before.json"));
        let path = study.path().join(&inside);
        let result = json!({"mean": 0.1 + 0.2, "count": u64::MAX, "whole": 2});
        assert_eq!(compare(&path, &result).unwrap(), None);
        archive(study.path(), &inside, &result).unwrap();
        assert_eq!(compare(&path, &result).unwrap(), Some(Vec::new()));
        let drifted = json!({"mean": 0.3, "count": u64::MAX, "whole": 2});
        let differences = compare(&path, &drifted).unwrap().unwrap();
        assert_eq!(differences.len(), 1, "the last bit counts");
        assert_eq!(differences[0].path, "mean");
    }

    #[test]
    fn names_stay_inside_the_folder() {
        let path = path("pass-1.json", "../a/b:c");
        assert_eq!(path, Path::new("baseline/pass-1/%2E.%2Fa%2Fb%3Ac.json"));
    }

    #[cfg(unix)]
    #[test]
    fn an_archive_does_not_lead_out_and_is_not_waited_for() {
        let (study, outside) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let foreign = outside.path().join("before.json");
        fs::write(&foreign, "foreign").unwrap();
        fs::create_dir(study.path().join("baseline")).unwrap();
        std::os::unix::fs::symlink(outside.path(), study.path().join("baseline/pass-1")).unwrap();
        fs::create_dir(study.path().join("baseline/pass-2")).unwrap();
        std::os::unix::fs::symlink(&foreign, study.path().join("baseline/pass-2/before.json")).unwrap();
        for pass in ["pass-1.json", "pass-2.json"] {
            let error = archive(study.path(), &path(pass, "before"), &json!({})).unwrap_err().to_string();
            assert!(error.contains("is a link, and nothing is written through links"), "{error}");
        }
        assert_eq!(fs::read(&foreign).unwrap(), b"foreign");
        let pipe = study.path().join("pipe.json");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        assert!(compare(&pipe, &json!({})).unwrap_err().to_string().contains("is no regular file"));
    }

    #[test]
    fn a_torn_archive_is_an_error() {
        let study = tempfile::tempdir().unwrap();
        let path = study.path().join("x.json");
        fs::write(&path, "{\"mean\": ").unwrap();
        assert!(compare(&path, &json!({})).unwrap_err().to_string().starts_with("the archived result `"));
    }
}
