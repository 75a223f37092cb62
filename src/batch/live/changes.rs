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
struct Looked {
    /// Files that were read, or would be if they were there, wherever they lie below the folder.
    read: BTreeSet<PathBuf>,
    /// Whether all other files count too, but hidden ones and those below `target`: it is not known what would be read.
    all: bool,
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
pub(super) struct Watched {
    folder: PathBuf,
    seen: Mutex<(Looked, Stamp)>,
}

impl Watched {
    /// The files below a folder, before it is known which of them are read.
    pub(super) fn new(folder: &Path) -> Self {
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
    pub(super) fn widen(&self) {
        let read = self.with(|(looked, _)| looked.read.clone());
        self.look(Looked { read, all: true });
    }

    /// What was looked at before stays as it was seen, so that no change is lost.
    fn look(&self, looked: Looked) {
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
    pub(super) fn has_changed(&self) -> bool {
        self.with(|(looked, stamp)| looked.stamp(&self.folder) != *stamp)
    }

    /// The files that are others now, which begins the next round.
    pub(super) fn renew(&self) -> Vec<String> {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A study's folder with a model, a pass, data in folders that are hidden or of a build, and notes that nothing reads.
    fn study() -> tempfile::TempDir {
        let root = tempfile::tempdir().expect("a folder");
        for folder in ["target", ".logger", "effects"] {
            std::fs::create_dir(root.path().join(folder)).expect("made");
        }
        for name in ["model.json", "pass-1.json", "target/a.csv", ".logger/b.csv", "notes.txt"] {
            std::fs::write(root.path().join(name), "1").expect("written");
        }
        root
    }

    #[test]
    fn what_is_read_is_seen_wherever_it_lies_and_nothing_else() {
        let root = study();
        let write = |name: &str, text: &str| std::fs::write(root.path().join(name), text).expect("written");
        let watched = Watched::new(root.path());
        assert!(!watched.has_changed());
        write("target/a.csv", "12");
        assert!(!watched.has_changed(), "before anything is read");
        let read = ["model.json", "pass-1.json", "target/a.csv", ".logger/b.csv", "data/late.csv"];
        watched.look(Looked { read: read.map(PathBuf::from).into(), all: false });
        assert!(!watched.has_changed());
        for unread in ["notes.txt", "other.json", "target/other.csv", "effects/notes.md", "pass-1.json~"] {
            write(unread, "changed");
            assert!(!watched.has_changed(), "{unread} is not read");
        }
        std::fs::create_dir(root.path().join("data")).expect("made");
        for seen in ["target/a.csv", ".logger/b.csv", "data/late.csv", "pass-2.json", "effects/own.json", "model.json"]
        {
            write(seen, "changed");
            assert_eq!(watched.renew(), [seen]);
            assert!(!watched.has_changed());
        }
        std::fs::remove_file(root.path().join("target/a.csv")).expect("removed");
        assert_eq!(watched.renew(), ["target/a.csv"]);
    }

    #[test]
    fn a_change_while_the_files_are_read_is_not_lost() {
        let root = study();
        let watched = Watched::new(root.path());
        std::fs::write(root.path().join("model.json"), "changed").expect("written");
        watched.look(Looked { read: [PathBuf::from("model.json")].into(), all: false });
        assert_eq!(watched.renew(), ["model.json"]);
        std::fs::write(root.path().join("notes.txt"), "changed").expect("written");
        watched.widen();
        assert!(!watched.has_changed());
        std::fs::write(root.path().join("notes.txt"), "changed again").expect("written");
        assert_eq!(watched.renew(), ["notes.txt"], "what is wrong may be cured by any file");
    }
}
