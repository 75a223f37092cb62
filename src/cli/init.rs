//! `bmv init`.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::output::{print, shown};
use super::status::{Failure, Status};
use crate::study::file::{self, Existing};

/// Arguments of `bmv init`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
                  bmv init my-study\n  \
                  bmv init my-board --from tclab")]
pub(super) struct Init {
    /// Folder of the new study; it is made
    folder: PathBuf,
    /// Example to begin with
    #[arg(long, value_name = "EXAMPLE", default_value = "radiator")]
    from: Example,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Example {
    /// How large must a radiator be? No measurements
    Radiator,
    /// A two-heater board with a measured transient, pinned by its hash
    Tclab,
}

impl Example {
    /// Names and contents of its files.
    fn files(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Radiator => &[
                ("model.json", include_str!("../../studies/radiator/model.json")),
                ("pass-1.json", include_str!("../../studies/radiator/pass-1.json")),
                ("data/history.csv", include_str!("../../studies/radiator/data/history.csv")),
            ],
            Self::Tclab => &[
                ("model.json", include_str!("../../studies/tclab/model.json")),
                ("pass-1.json", include_str!("../../studies/tclab/pass-1.json")),
            ],
        }
    }

    fn has_pinned_data(self) -> bool {
        matches!(self, Self::Tclab)
    }
}

impl Init {
    pub(super) fn execute(self) -> Result<Status, Failure> {
        let folder = shown(&self.folder);
        let cannot = |error: std::io::Error| Failure::input(format!("cannot make the study `{folder}`: {error}"));
        for (name, _) in self.from.files() {
            if self.folder.join(name).symlink_metadata().is_ok() {
                return Err(Failure::input(format!("`{folder}` has a `{name}` already; name another folder")));
            }
        }
        for (name, text) in self.from.files() {
            file::write(&self.folder, Path::new(name), text.as_bytes(), Existing::Keep).map_err(cannot)?;
        }
        let get = if self.from.has_pinned_data() { format!("bmv data get {folder}\n") } else { String::new() };
        print(&format!("made {folder}; now try\n{get}bmv run {folder}\nbmv report {folder}\n"))?;
        Ok(Status::Done)
    }
}
