//! `bmv data get`, `verify`.

use std::path::PathBuf;

use clap::Subcommand;

use super::options::PathsArgument;
use super::output::{escaped, print, print_json};
use super::pinned::{PinnedFile, pinned};
use super::status::{Failure, Status};
use crate::study::pinned::{Sources, search_folders};

/// Verbs below `bmv data`.
#[derive(Debug, Subcommand)]
pub(super) enum Data {
    /// Bring pinned measurements to their place and check their hash
    Get {
        #[command(flatten)]
        paths: PathsArgument,
        /// Folder that is searched for the hash, whatever the name [default: the one in BMV_DATA]
        #[arg(long, value_name = "DIR")]
        from: Option<PathBuf>,
        /// Fetch from addresses of this machine and its own networks too, such as an internal mirror
        #[arg(long)]
        internal: bool,
        /// Print one JSON document
        #[arg(long)]
        json: bool,
    },
    /// Check the hashes of pinned measurements; exit status 1 if one is absent or other
    Verify {
        #[command(flatten)]
        paths: PathsArgument,
        /// Print one JSON document
        #[arg(long)]
        json: bool,
    },
}

impl Data {
    pub(super) fn execute(self) -> Result<Status, Failure> {
        let (files, json) = match self {
            Self::Get { paths, from, internal, json } => {
                let folders = search_folders(from.as_deref(), std::env::var_os("BMV_DATA").as_deref());
                (pinned(&paths.paths, Some(&Sources { folders, internal }))?, json)
            }
            Self::Verify { paths, json } => (pinned(&paths.paths, None)?, json),
        };
        if json {
            print_json(&files)?;
        } else {
            for PinnedFile { file, state, .. } in &files {
                print(&format!("{}: {}\n", escaped(file), escaped(state)))?;
            }
        }
        Ok(if files.iter().all(|file| file.good) { Status::Done } else { Status::CheckFailed })
    }
}
