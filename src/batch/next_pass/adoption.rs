//! Adopting: the next pass is chosen, made and written in one go, whoever asks for it.

use std::path::{Path, PathBuf};

use crate::diagnosis::Output;
use crate::document::Diagnostics;
use crate::study::Pass;

use super::file::{destination, one, twin, write};
use super::{Asked, NextPass, next_pass};

/// What became of an adoption.
#[derive(Debug)]
pub enum Adoption<'f> {
    /// The next pass was written to this file.
    Written(PathBuf, NextPass<'f>),
    /// This file is already what would have been written.
    There(PathBuf),
}

/// Writes the pass that adopts what was asked for, or what the diagnosis selected: into `out`, or into the next free
/// `pass-N.json` unless a pass of the study has adopted the same. `job` is the diagnosis's name in the pass; `forced` lets
/// through what it does not support, and replaces the file `out`.
///
/// # Errors
/// As [`next_pass`]; a file that cannot be written, or must not be.
pub fn adopt_into<'f>(
    pass: &Pass,
    job: &str,
    diagnosis: &'f Output,
    asked: &Asked,
    out: Option<&Path>,
    forced: bool,
) -> Result<Adoption<'f>, Diagnostics> {
    let path = destination(pass, out, &asked.command()).map_err(|wrong| one(*wrong))?;
    let next = next_pass(pass, job, diagnosis, asked, forced, &path)?;
    if out.is_none() {
        let ids: Vec<&str> = next.adopted.iter().map(|(_, finding)| finding.id.as_str()).collect();
        let applies_to = asked.acting.names(pass, asked)?;
        if let Some(twin) = twin(pass, &ids, applies_to.as_deref()) {
            return Ok(Adoption::There(twin));
        }
    }
    write(&next.text, &next.files, &path, forced && out.is_some(), &asked.command())?;
    Ok(Adoption::Written(path, next))
}
