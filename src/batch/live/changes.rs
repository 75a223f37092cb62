//! Which files of a study changed: their sizes and times of modification, looked at again and again.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Folders deeper than this hold no files of a study.
const DEEPEST: usize = 6;
/// Files that are looked at.
const MOST_FILES: usize = 20_000;

/// The files of a folder with their sizes and times; hidden ones are left out, links are not followed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stamp(BTreeMap<PathBuf, (u64, Option<SystemTime>)>);

impl Stamp {
    /// The files below a folder as they are now.
    pub fn of(folder: &Path) -> Self {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let visible = |entry: &walkdir::DirEntry| {
            let name = entry.file_name().to_string_lossy();
            entry.depth() == 0 || !(name.starts_with('.') || name == "target")
        };
        let walk = walkdir::WalkDir::new(folder).max_depth(DEEPEST).into_iter().filter_entry(visible).flatten();
        let files = walk.filter(|entry| entry.file_type().is_file()).filter_map(|entry| {
            let about = entry.metadata().ok()?;
            let path = entry.path().strip_prefix(folder).unwrap_or(entry.path()).to_owned();
            Some((path, (about.len(), about.modified().ok())))
        });
        Self(files.take(MOST_FILES).collect())
    }

    /// The files that are not the same in both.
    pub fn differences(&self, other: &Self) -> Vec<String> {
        let all = self.0.keys().chain(other.0.keys().filter(|path| !self.0.contains_key(*path)));
        all.filter(|path| self.0.get(*path) != other.0.get(*path)).map(|path| path.display().to_string()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Stamp;

    #[test]
    fn what_is_written_made_or_removed_is_seen_and_what_is_hidden_is_not() {
        let root = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| std::fs::write(root.path().join(name), text).expect("written");
        std::fs::create_dir(root.path().join("data")).expect("made");
        std::fs::create_dir(root.path().join(".bmv")).expect("made");
        write("model.json", "{}");
        write("data/a.csv", "1");
        let before = Stamp::of(root.path());
        assert_eq!(before.differences(&Stamp::default()).len(), 2);
        write(".bmv/object", "x");
        assert_eq!(Stamp::of(root.path()), before);
        write("data/a.csv", "12");
        write("pass-2.json", "{}");
        std::fs::remove_file(root.path().join("model.json")).expect("removed");
        let mut changed = before.differences(&Stamp::of(root.path()));
        changed.sort();
        assert_eq!(changed, ["data/a.csv", "model.json", "pass-2.json"]);
    }
}
