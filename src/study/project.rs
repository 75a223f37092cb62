//! The project of a study: the folder in which its cache and its reports lie, wherever the program is called from.

use std::path::{Path, PathBuf};

use super::discover::passes;

/// Folder of the cache and the event logs in a project.
const OWN: &str = ".bmv";
/// Folder of studies in a project.
const STUDIES: &str = "studies";

/// A project.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Project {
    /// Its folder, links resolved.
    pub root: PathBuf,
}

impl Project {
    /// The project of a study's folder: the nearest folder from it upwards that holds `.git`, or the `studies` in which
    /// the study lies; else the nearest one above it that holds `.bmv`; else the one in which the study lies. A home
    /// folder, and one in which everybody may write, hold a project only by their `studies`.
    pub fn of(study: &Path) -> Self {
        let study = whole(study);
        let above = || study.ancestors().skip(1);
        let holds = |folder: &Path, name: &str| folder.join(name).exists() && !is_common(folder);
        let by_git = study.ancestors().find(|folder| holds(folder, ".git"));
        let by_studies = above().find(|folder| is_called_studies(folder)).and_then(Path::parent);
        let nearest = match (by_git, by_studies) {
            (Some(git), Some(studies)) if git.starts_with(studies) => Some(git),
            (git, studies) => studies.or(git),
        };
        let root = nearest.or_else(|| above().find(|folder| holds(folder, OWN)));
        Self { root: root.or_else(|| study.parent()).unwrap_or(&study).to_owned() }
    }

    /// The project in which the program is called: that of the study in which it is; else the working folder itself where
    /// it holds `studies`, and else as for a study in it.
    pub fn here() -> Self {
        let here = whole(Path::new(""));
        if here.join(STUDIES).is_dir() {
            return Self { root: here };
        }
        Self::of(enclosing_study(&here).unwrap_or(&here.join("study")))
    }

    /// Its folder as seen from the working folder where it lies above or below that, else from the root of the file
    /// system.
    pub fn folder(&self) -> PathBuf {
        let here = whole(Path::new(""));
        if let Ok(below) = self.root.strip_prefix(&here) {
            return below.to_owned();
        }
        match here.strip_prefix(&self.root) {
            Ok(below) => below.components().map(|_| "..").collect(),
            Err(_) => self.root.clone(),
        }
    }

    /// Folder of the cache.
    pub fn cache(&self) -> PathBuf {
        self.folder().join(OWN).join("cache")
    }

    /// Folder of the event logs.
    pub fn events(&self) -> PathBuf {
        self.folder().join(OWN).join("events")
    }

    /// Path of a study's file from the project's folder, with `/`: the same however the study was named.
    pub fn path_of(&self, study: &Path, file: &str) -> String {
        let study = whole(study);
        // A study lies in its project.
        let below = study.strip_prefix(&self.root).unwrap_or(&study);
        let parts = below.components().map(|part| part.as_os_str().to_string_lossy().into_owned());
        parts.chain([file.to_owned()]).collect::<Vec<_>>().join("/")
    }
}

/// Where a path lies, seen from the working folder, that is not there and would be if the program were called in the
/// project's folder: as paths stand in what was printed there.
pub fn from_project(path: &Path) -> Option<PathBuf> {
    if path.is_absolute() || path.exists() {
        return None;
    }
    let in_project = Project::here().folder().join(path);
    in_project.exists().then_some(in_project)
}

/// That nothing is at a path, and where it lies where it is in the project.
pub fn missing(path: &Path) -> String {
    let hint = from_project(path).map(|in_project| format!("; from here it is `{}`", in_project.display()));
    format!("`{}` does not exist{}", path.display(), hint.unwrap_or_default())
}

/// What a verb works on where no path is given: `studies` of the working folder; else the study in which that is; else
/// all below it where it is, or lies in, a folder `studies`.
pub fn default_path() -> PathBuf {
    let here = whole(Path::new(""));
    if here.join(STUDIES).is_dir() {
        return STUDIES.into();
    }
    if let Some(study) = enclosing_study(&here) {
        let up = here.strip_prefix(study).map_or(0, |below| below.components().count());
        return if up == 0 { ".".into() } else { (0..up).map(|_| "..").collect() };
    }
    if here.ancestors().any(is_called_studies) { ".".into() } else { STUDIES.into() }
}

fn is_called_studies(folder: &Path) -> bool {
    folder.file_name().is_some_and(|name| name == STUDIES)
}

/// The nearest folder from here upwards that is a study.
fn enclosing_study(here: &Path) -> Option<&Path> {
    let mut upwards = here.ancestors().take_while(|folder| *folder == here || !is_common(folder));
    upwards.find(|folder| !passes(folder).is_empty())
}

/// A path with links resolved; of what is not there, as far as the system can tell.
pub fn whole(path: &Path) -> PathBuf {
    let shown = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    let resolved = shown.canonicalize().or_else(|_| std::path::absolute(shown));
    resolved.unwrap_or_else(|_| shown.to_owned())
}

/// Whether what lies in a folder need not belong together: a home folder, or one in which everybody may write.
fn is_common(folder: &Path) -> bool {
    let is_home = std::env::home_dir().is_some_and(|home| whole(&home) == folder);
    is_home || folder.parent().is_none() || is_open_to_all(folder)
}

#[cfg(unix)]
fn is_open_to_all(folder: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    folder.metadata().is_ok_and(|data| data.permissions().mode() & 0o002 != 0)
}

#[cfg(not(unix))]
fn is_open_to_all(_folder: &Path) -> bool {
    false
}
