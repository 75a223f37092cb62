//! Archived results of a study, in `baseline/PASS/JOB.json`, against which the nightly check holds a fresh run.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::difference::{Difference, differences};
use super::error::RunnerError;

/// Where a job's archived result lies: names of jobs may hold any character, so those that file systems treat in their
/// own way are written as `%` and their code.
pub fn path(study: &Path, pass: &str, job: &str) -> PathBuf {
    let pass = pass.strip_suffix(".json").unwrap_or(pass);
    study.join("baseline").join(file_name(pass)).join(format!("{}.json", file_name(job)))
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

/// Compares a result with the archived one. Nothing if none is archived.
///
/// # Errors
/// [`RunnerError::File`] if it cannot be read, [`RunnerError::NotCanonical`] if it is no JSON.
pub fn compare(path: &Path, result: &Value) -> Result<Option<Vec<Difference>>, RunnerError> {
    if !path.exists() {
        return Ok(None);
    }
    let text = fs::read(path).map_err(RunnerError::file("read", path))?;
    let archived: Value = serde_json::from_slice(&text).map_err(|error| RunnerError::NotCanonical {
        what: format!("the archived result `{}`", path.display()),
        reason: error.to_string(),
    })?;
    Ok(Some(differences(&archived, result)))
}

/// Archives a result, indented so that it can be read and compared line by line.
///
/// # Errors
/// [`RunnerError::File`] if the system refuses.
pub fn archive(path: &Path, result: &Value) -> Result<(), RunnerError> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(RunnerError::file("make the folder", folder))?;
    }
    fs::write(path, format!("{result:#}\n")).map_err(RunnerError::file("write", path))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn what_was_archived_is_compared_exactly() {
        let study = tempfile::tempdir().unwrap();
        let path = path(study.path(), "pass-1.json", "before");
        assert!(path.ends_with("baseline/pass-1/before.json"));
        let result = json!({"mean": 0.1 + 0.2, "count": u64::MAX, "whole": 2});
        assert_eq!(compare(&path, &result).unwrap(), None);
        archive(&path, &result).unwrap();
        assert_eq!(compare(&path, &result).unwrap(), Some(Vec::new()));
        let drifted = json!({"mean": 0.3, "count": u64::MAX, "whole": 2});
        let found = compare(&path, &drifted).unwrap().unwrap();
        assert_eq!(found.len(), 1, "the last bit counts");
        assert_eq!(found[0].path, "mean");
    }

    #[test]
    fn names_stay_inside_the_folder() {
        let path = path(Path::new("study"), "pass-1.json", "../a/b:c");
        assert_eq!(path, Path::new("study/baseline/pass-1/%2E.%2Fa%2Fb%3Ac.json"));
    }

    #[test]
    fn a_torn_archive_is_an_error() {
        let study = tempfile::tempdir().unwrap();
        let path = study.path().join("x.json");
        fs::write(&path, "{\"mean\": ").unwrap();
        assert!(compare(&path, &json!({})).unwrap_err().to_string().starts_with("the archived result `"));
    }
}
