//! Which files of a study changed: sizes and times of modification of those that its passes read, looked at again and again.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use crate::batch::LoadedPass;
use crate::study::{Pass, discover};

/// Folders deeper than this hold no files of a study that cannot be read.
const DEEPEST: usize = 6;
/// Files that are looked at.
const MOST_FILES: usize = 20_000;
/// Folder of a study's own effects: another file there is another effect.
const EFFECTS: &str = "effects";

/// Size and time of a file; nothing of one that is not there.
pub(super) type About = Option<(u64, Option<SystemTime>)>;

/// Files by their path within a study's folder.
pub(super) type Stamp = BTreeMap<PathBuf, About>;

fn about(path: &Path) -> About {
    let about = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
    Some((about.len(), about.modified().ok()))
}

/// What is looked at.
#[derive(Clone, Debug, Default)]
pub struct Looked {
    /// Files that were read, or would be if they were there, wherever they lie below the folder.
    pub read: BTreeSet<PathBuf>,
    /// Whether all other files count too, but hidden ones and those below `target`: it is not known what would be read.
    pub all: bool,
}

impl Looked {
    /// The files as they are now.
    fn stamp(&self, folder: &Path) -> Stamp {
        let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let mut stamp: Stamp = self.read.iter().map(|path| (path.clone(), about(&here.join(path)))).collect();
        let mut add = |path: &Path| {
            let relative = path.strip_prefix(here).unwrap_or(path).to_owned();
            stamp.entry(relative).or_insert_with(|| about(path));
        };
        discover::passes(here).iter().for_each(|pass| add(pass));
        let visible = |entry: &walkdir::DirEntry| {
            let name = entry.file_name().to_string_lossy();
            entry.depth() == 0 || !(name.starts_with('.') || name == "target")
        };
        let files = |folder: &Path, deepest: usize| {
            let walk = walkdir::WalkDir::new(folder).max_depth(deepest).into_iter().filter_entry(visible).flatten();
            walk.filter(|entry| entry.file_type().is_file()).take(MOST_FILES)
        };
        let is_effect = |path: &Path| path.extension().is_some_and(|ending| ending == "json");
        files(&here.join(EFFECTS), 1).filter(|entry| is_effect(entry.path())).for_each(|entry| add(entry.path()));
        if self.all {
            files(here, DEEPEST).for_each(|entry| add(entry.path()));
        }
        stamp
    }
}

/// The files of a study that is followed, and how they were when its round began.
pub struct Watched {
    folder: PathBuf,
    seen: Mutex<(Looked, Stamp)>,
}

impl Watched {
    /// The files below a folder, before it is known which of them are read.
    pub fn new(folder: &Path) -> Self {
        let looked = Looked { read: BTreeSet::new(), all: true };
        let stamp = looked.stamp(folder);
        Self { folder: folder.to_owned(), seen: Mutex::new((looked, stamp)) }
    }

    fn with<T>(&self, then: impl FnOnce(&mut (Looked, Stamp)) -> T) -> T {
        then(&mut self.seen.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Looks from now on at what these passes read and at what they lack, beside new passes and effects.
    pub(super) fn narrow(&self, passes: &[LoadedPass]) {
        let mut read = BTreeSet::new();
        passes.iter().for_each(|pass| note(&pass.pass, &mut read));
        self.look(Looked { read, all: false });
    }

    /// Looks at all files again: what is wrong may be cured by one that nobody read.
    pub fn widen(&self) {
        let read = self.with(|(looked, _)| looked.read.clone());
        self.look(Looked { read, all: true });
    }

    /// What was looked at before stays as it was seen, so that no change is lost.
    pub fn look(&self, looked: Looked) {
        let now = looked.stamp(&self.folder);
        self.with(|(own, stamp)| {
            let kept = now.into_iter().map(|(path, about)| {
                let before = stamp.get(&path).copied();
                (path, before.unwrap_or(about))
            });
            *stamp = kept.collect();
            *own = looked;
        });
    }

    /// Whether a file is another than when the round began.
    pub fn has_changed(&self) -> bool {
        self.with(|(looked, stamp)| looked.stamp(&self.folder) != *stamp)
    }

    /// The files that are others now, which begins the next round.
    pub fn renew(&self) -> Vec<String> {
        self.with(|(looked, stamp)| {
            let now = looked.stamp(&self.folder);
            let before = std::mem::replace(stamp, now);
            let all: BTreeSet<&PathBuf> = before.keys().chain(stamp.keys()).collect();
            let differ = |path: &&&PathBuf| before.get(**path) != stamp.get(**path);
            all.iter().filter(differ).map(|path| path.display().to_string()).collect()
        })
    }

    /// The files as they are now, to see whether one is still being written.
    pub(super) fn now(&self) -> Stamp {
        self.with(|(looked, _)| looked.stamp(&self.folder))
    }
}

/// Adds what a pass and those whose posteriors it uses read or lack.
fn note(pass: &Pass, read: &mut BTreeSet<PathBuf>) {
    read.extend(pass.files.keys().map(PathBuf::from));
    read.extend(pass.missing.iter().map(|pinned| PathBuf::from(&pinned.file)));
    pass.upstream.iter().for_each(|upstream| note(upstream, read));
}
