//! Where a next pass is written, and writing it: beside its parent, never over what is there unless that is said.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use crate::diagnosis::PRIOR_OF;
use crate::diagnosis::output::EffectFile;
use crate::document::{Diagnostic, Diagnostics, Place, code};
use crate::job::load;
use crate::study::Pass;
use crate::study::discover::{number, passes};
use crate::study::file::{self, Existing};

/// The file of the next pass: `out`, or the first free `pass-N.json` behind the pass's own number.
///
/// # Errors
/// An `out` outside the pass's folder, without `.json`, or one of the files that the next pass builds upon.
pub fn destination(pass: &Pass, out: Option<&Path>, place: &Place) -> Result<PathBuf, Box<Diagnostic>> {
    let Some(out) = out else {
        let pass_number = number(Path::new(&pass.file)).unwrap_or(0);
        let mut paths = (pass_number.saturating_add(1)..).map(|number| pass.folder.join(format!("pass-{number}.json")));
        // A folder has fewer files than there are numbers.
        return Ok(paths.find(|path| path.symlink_metadata().is_err()).unwrap_or_else(|| pass.folder.join(&pass.file)));
    };
    let wrong = |message: String, expected: String| {
        Err(Box::new(Diagnostic::error(&code::ADOPT_FILE, place, message).expected(expected)))
    };
    let shown = out.display();
    let name = out
        .file_name()
        .and_then(|name| name.to_str())
        .filter(|name| name.ends_with(".json") && crate::document::name::is_label(name));
    let inside = pass.folder.join(name.unwrap_or("pass-2.json"));
    let Some(name) = name else {
        return wrong(format!("`{shown}` is no name of a pass"), format!("such as `{}`", inside.display()));
    };
    let whole = |folder: &Path| {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        folder.canonicalize().ok()
    };
    let folder = out.parent().and_then(whole);
    if folder.is_none() || folder != whole(&pass.folder) {
        let message =
            format!("`{shown}` does not lie in the folder of `{}`, which it would name as its parent", pass.file);
        return wrong(message, format!("such as `{}`", inside.display()));
    }
    if name == pass.file || name == pass.model_file || pass.parents.iter().any(|parent| parent == name) {
        return wrong(format!("the next pass builds upon `{name}`"), "another file".to_owned());
    }
    Ok(out.to_owned())
}

/// The pass of the same folder that is already what would be written: a child of this one with the same effects, which act
/// where these would if that is asked for.
pub fn twin(pass: &Pass, ids: &[&str], applies_to: Option<&[String]>) -> Option<PathBuf> {
    let mut wanted: Vec<&str> = ids.to_vec();
    wanted.sort_unstable();
    let is_twin = |other: &Pass| {
        let before = |id: &str| pass.adopted.iter().any(|adopted| adopted.id == id);
        let effects = other.adopted.iter().map(|adopted| adopted.id.clone()).filter(|id| !before(id));
        let changed = |index: &usize| other.priors.get(*index) != pass.priors.get(*index);
        let priors = (0..pass.priors.len()).filter(changed);
        let priors = priors.map(|index| format!("{PRIOR_OF}:{}", pass.model.parameters[index].name));
        let mut added: Vec<String> = effects.chain(priors).collect();
        added.sort_unstable();
        let own = other.adopted.iter().filter(|adopted| !before(&adopted.id) && !adopted.is_of_readings);
        let acts_alike = own.map(|adopted| &adopted.applies_to).all(|names| applies_to.is_none_or(|own| own == names));
        other.parents.first() == Some(&pass.file) && added == wanted && acts_alike
    };
    passes(&pass.folder).into_iter().find(|path| load(path).is_ok_and(|other| is_twin(&other)))
}

/// Writes the effects that a pass needs into the study, and the text of the pass, after it has been loaded from a file
/// beside and found right. Where it is not, the effects are removed again.
///
/// # Errors
/// What is wrong with it; a file that is there, unless `replace`; a refusal of the system.
pub fn write(
    text: &str,
    effects: &[&EffectFile],
    path: &Path,
    replace: bool,
    place: &Place,
) -> Result<(), Diagnostics> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut files = Vec::new();
    let mut write_effects = || -> Result<(), Diagnostics> {
        for effect in effects {
            let name = Path::new("effects").join(format!("{}.json", effect.name));
            file::write(folder, &name, effect.text.as_bytes(), Existing::Keep).map_err(|error| {
                let message = format!("`{}` cannot be written: {error}", folder.join(&name).display());
                one(Diagnostic::error(&code::ADOPT_FILE, place, message))
            })?;
            files.push(folder.join(&name));
        }
        Ok(())
    };
    let written = write_effects().and_then(|()| write_pass(text, path, replace, place));
    if written.is_err() {
        // What cannot be removed is an effect that no pass uses.
        files.iter().for_each(|file| drop(std::fs::remove_file(file)));
    }
    written
}

fn write_pass(text: &str, path: &Path, replace: bool, place: &Place) -> Result<(), Diagnostics> {
    let refused = |error: std::io::Error| {
        let shown = path.display();
        let diagnostic = if error.kind() == std::io::ErrorKind::AlreadyExists {
            Diagnostic::error(&code::ADOPT_FILE, place, format!("`{shown}` is there already"))
                .expected("a file that is not there")
                .help("--force with --out replaces it")
        } else {
            Diagnostic::error(&code::ADOPT_FILE, place, format!("`{shown}` cannot be written: {error}"))
        };
        one(diagnostic)
    };
    if !replace && path.symlink_metadata().is_ok() {
        return Err(refused(std::io::ErrorKind::AlreadyExists.into()));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut tried = tempfile::Builder::new().prefix(".adopt-").suffix(".json").tempfile_in(folder).map_err(refused)?;
    tried.write_all(text.as_bytes()).and_then(|()| tried.flush()).map_err(refused)?;
    load(tried.path())?;
    let existing = if replace { Existing::Replace } else { Existing::Keep };
    file::write(folder, Path::new(path.file_name().unwrap_or_default()), text.as_bytes(), existing).map_err(refused)
}

/// A collection of one finding.
pub(super) fn one(diagnostic: Diagnostic) -> Diagnostics {
    let mut diagnostics = Diagnostics::new();
    diagnostics.push(diagnostic);
    diagnostics
}
