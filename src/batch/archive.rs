//! A pass's report with everything that an archive needs: the files that it is made of, the jobs behind it, their hashes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::executed::is_judge;
use super::history::history;
use super::inputs::input_files;
use super::view::view_in;
use super::{BatchError, Executed, LoadedPass};
use crate::report::assemble::Surroundings;
use crate::report::terminal::escaped;
use crate::report::view::Siblings;
use crate::report::{self, FileHash, RenderedReport};
use crate::runner::manifest::FileRecord;
use crate::runner::{ENGINE_VERSION, Key, Manifest};
use crate::study::discover::passes;
use crate::study::project::whole;
use crate::study::{self, Content, Pass};

/// Folder of the reports in a project.
const REPORTS: &str = "reports";

/// Where a pass's report goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Target {
    /// The folder that was named, or that of the project.
    base: PathBuf,
    /// The report's folder below it.
    relative: PathBuf,
}

impl Target {
    /// The folder of a pass's report: below `out` where that is named, else below `reports` of the study's project.
    fn new(pass: &LoadedPass, out: Option<&Path>) -> Self {
        let study_and_pass = Path::new(&study_name(&pass.study)).join(pass.file.trim_end_matches(".json"));
        match out {
            Some(out) => Self { base: out.to_owned(), relative: study_and_pass },
            None => Self { base: pass.project.folder(), relative: Path::new(REPORTS).join(study_and_pass) },
        }
    }

    /// The folder of all reports: the base, and the folder below it.
    pub(super) fn reports(&self) -> (PathBuf, PathBuf) {
        let above = self.relative.parent().and_then(Path::parent).unwrap_or(Path::new(""));
        (self.base.clone(), above.to_owned())
    }

    /// The report's folder.
    pub fn folder(&self) -> PathBuf {
        self.base.join(&self.relative)
    }

    /// Name of the report as a PDF: of its study and pass.
    pub fn printed(&self) -> String {
        let mut names = self.relative.iter().rev().map(|name| name.to_string_lossy());
        let (pass, study) = (names.next().unwrap_or_default(), names.next().unwrap_or_default());
        format!("{study}-{pass}.pdf")
    }
}

/// Where the reports of passes go, in their order.
///
/// # Errors
/// Two studies whose reports would lie in one folder; a folder that holds the report of another study.
pub fn targets(passes: &[LoadedPass], out: Option<&Path>) -> Result<Vec<Target>, BatchError> {
    let mut taken: BTreeMap<PathBuf, &LoadedPass> = BTreeMap::new();
    let mut targets = Vec::new();
    for pass in passes {
        let target = Target::new(pass, out);
        let folder = target.folder();
        let shown = escaped(&folder.display().to_string());
        if let Some(other) = taken.insert(whole(&target.base).join(&target.relative), pass) {
            return Err(BatchError::input(format!(
                "the reports of `{}` and `{}` would both lie in `{shown}`: the studies have one name; report each by \
                 itself, with its own --out DIR",
                escaped(&other.shown),
                escaped(&pass.shown)
            )));
        }
        let pass_path = pass.project.path_of(&pass.study, &pass.file);
        // What is no manifest says of no study that the folder is its own.
        if let Some(earlier) = Manifest::read(&folder).ok().filter(|earlier| !earlier.inputs.contains_key(&pass_path)) {
            let of = earlier.command.strip_prefix(COMMAND).unwrap_or(&earlier.command).trim().to_owned();
            return Err(BatchError::input(format!(
                "`{shown}` holds the report of `{}`, a study of the same name: name another folder with --out DIR; or, \
                 if that study has become `{}`, delete the old report first",
                escaped(&of),
                escaped(&pass_path)
            )));
        }
        targets.push(target);
    }
    Ok(targets)
}

/// The command that makes reports.
const COMMAND: &str = "bmv report";

/// Renders the report of a pass into its folder. A pass of whose jobs none has a result, because its data are not here,
/// gets no report; then `false`. Neither the report nor its manifest depend on how the study's path was spelled.
///
/// # Errors
/// A result that cannot be rendered, a file that cannot be written, a study that changed while it was read.
pub fn render(pass: &LoadedPass, executed: &Executed, target: &Target) -> Result<bool, BatchError> {
    let Some((rendered, manifest)) = rendered(pass, executed)? else { return Ok(false) };
    report::write(&rendered, manifest, &target.base, &target.relative)
        .map_err(|error| BatchError::job(format!("{}: {error}", escaped(&pass.shown))))?;
    Ok(true)
}

/// The report of a pass with the manifest of what it was made of, which does not list the report's own files yet; `None` as
/// [`render`] gives `false`.
///
/// # Errors
/// As [`render`], nothing being written.
pub(super) fn rendered(
    pass: &LoadedPass,
    executed: &Executed,
) -> Result<Option<(RenderedReport, Manifest)>, BatchError> {
    let failed = |error: String| BatchError::job(format!("{}: {error}", escaped(&pass.shown)));
    if executed.results(pass).next().is_none() && !pass.not_run.is_empty() {
        return Ok(None);
    }
    let path_of = |file: &str| pass.project.path_of(&pass.study, file);
    let command = format!("{COMMAND} {}", path_of(&pass.file));
    let mut manifest = Manifest::new(&command);
    let mut files = Vec::new();
    let lineage = lineage(pass, executed);
    let written: Vec<&Pass> = lineage.iter().map(|loaded| loaded.pass.as_ref()).collect();
    for (role, path, content) in input_files(&written).map_err(failed)? {
        let sha256 = Key::try_from(content.sha256.clone()).map_err(failed)?;
        manifest.add_input(path_of(&path), FileRecord { bytes: content.bytes, sha256 });
        let entries = if role == "model" { entries(&pass.study.join(&path), &content) } else { Vec::new() };
        files.push(FileHash { path, sha256: content.sha256, role: role.to_owned(), entries });
    }
    let id = |of: &LoadedPass, name: &str| format!("{}:{name}", path_of(&of.file));
    for (position, job) in executed.results(pass) {
        let node = &executed.plan.nodes()[position];
        manifest.add_job(id(pass, &node.name), node, job);
    }
    for parent in lineage.iter().filter(|other| other.file != pass.file) {
        for (position, job) in executed.results(parent) {
            let node = &executed.plan.nodes()[position];
            if is_judge(&parent.pass, &node.name) {
                manifest.add_job(id(parent, &node.name), node, job);
            }
        }
    }
    let engine_version = ENGINE_VERSION.to_string();
    let history = Some(history(&lineage, executed)?);
    let origin_sha256 = manifest.origin_sha256()?.to_string();
    let surroundings = Surroundings {
        files,
        engine_version,
        command,
        history,
        siblings: Some(siblings(pass)),
        origin_sha256: Some(origin_sha256.clone()),
        ..Surroundings::default()
    };
    let mut view = view_in(pass, executed, surroundings)?;
    let from_here = study::command(&pass.pass.folder);
    let study = path_of("");
    let from_project = study::command(Path::new(study.trim_end_matches('/')));
    for warning in &mut view.warnings {
        *warning = warning.replace(&format!("`{from_here}`"), &format!("`{from_project}`"));
    }
    let rendered = report::render(&view).map_err(|error| failed(error.to_string()))?;
    Ok(Some((rendered.sealed(&origin_sha256), manifest)))
}

/// The entries of a model's file by section and name, for what tells two versions apart; none of one that has changed since it
/// was read, or is no JSON.
fn entries(path: &Path, content: &Content) -> Vec<(String, String)> {
    let bytes = std::fs::read(path).ok().filter(|bytes| Content::of(bytes) == *content);
    let parsed = bytes.and_then(|bytes| serde_json::from_slice::<serde_json::Value>(&bytes).ok());
    let sections = parsed.as_ref().and_then(serde_json::Value::as_object).into_iter().flatten();
    let of = |(section, value): (&String, &serde_json::Value)| match value.as_object() {
        Some(named) => named.iter().map(|(name, own)| (format!("{section}: {name}"), own.to_string())).collect(),
        None => vec![(section.clone(), value.to_string())],
    };
    sections.flat_map(of).collect()
}

/// Neighbours to which the report of a pass links and whose reports do not lie beside it.
pub fn missing_neighbours(pass: &LoadedPass, target: &Target) -> Vec<String> {
    let Siblings { previous, next } = siblings(pass);
    let is_missing = |name: &String| !target.folder().with_file_name(name).join("report.html").is_file();
    previous.into_iter().chain(next).filter(is_missing).collect()
}

/// The passes beside one in its study, those left out whose reports are kept elsewhere.
fn siblings(pass: &LoadedPass) -> Siblings {
    let is_left_out = |file: &str| pass.pass.document.as_ref().is_some_and(|own| own.not_archived(file).is_some());
    let files = passes(&pass.study).into_iter().filter_map(|path| Some(path.file_name()?.to_str()?.to_owned()));
    let files: Vec<String> = files.filter(|file| *file == pass.file || !is_left_out(file)).collect();
    let own = files.iter().position(|file| *file == pass.file);
    let name = |place: Option<usize>| {
        let file = place.and_then(|place| files.get(place))?;
        Some(file.trim_end_matches(".json").to_owned())
    };
    Siblings { previous: name(own.and_then(|own| own.checked_sub(1))), next: name(own.map(|own| own + 1)) }
}

/// A pass with those of its parents that were loaded.
fn lineage<'e>(pass: &'e LoadedPass, executed: &'e Executed) -> Vec<&'e LoadedPass> {
    let all = || executed.passes.iter().chain(&executed.parents);
    let find = |file: &String| all().find(|other| other.study == pass.study && other.file == *file);
    pass.pass.parents.iter().rev().filter_map(find).chain([pass]).collect()
}

/// A study's name: that of its folder.
pub(super) fn study_name(folder: &Path) -> String {
    whole(folder).file_name().map_or_else(|| "study".to_owned(), |name| name.to_string_lossy().into_owned())
}
