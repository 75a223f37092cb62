//! `bmv init`.

use std::fs;
use std::path::PathBuf;

use clap::ValueEnum;

use super::output::print;
use super::status::{Failure, Status};

/// Arguments of `bmv init`.
#[derive(Debug, clap::Args)]
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
    fn files(self) -> [(&'static str, &'static str); 2] {
        match self {
            Self::Radiator => [
                ("model.json", include_str!("../../studies/radiator/model.json")),
                ("pass-1.json", include_str!("../../studies/radiator/pass-1.json")),
            ],
            Self::Tclab => [
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
        let shown = self.folder.display();
        let cannot = |error: std::io::Error| Failure::input(format!("cannot make the study `{shown}`: {error}"));
        fs::create_dir_all(&self.folder).map_err(cannot)?;
        for (name, _) in self.from.files() {
            if self.folder.join(name).exists() {
                return Err(Failure::input(format!("`{shown}` has a `{name}` already; name another folder")));
            }
        }
        for (name, text) in self.from.files() {
            let mut file = fs::File::create_new(self.folder.join(name)).map_err(cannot)?;
            std::io::Write::write_all(&mut file, text.as_bytes()).map_err(cannot)?;
        }
        let get = if self.from.has_pinned_data() { format!("bmv data get {shown}\n") } else { String::new() };
        print(&format!("made {shown}; now try\n{get}bmv run {shown}\nbmv report {shown}\n"))?;
        Ok(Status::Done)
    }
}
