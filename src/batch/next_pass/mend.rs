//! Calibrations of the parent whose chains did not converge: the next pass has the settings that mend them, not those again.

use serde::Deserialize;

use crate::batch::{Executed, LoadedPass};
use crate::document::Diagnostics;
use crate::document::written::read_document;
use crate::job::calibrate::{Kind, Output, Remedy};
use crate::job::kind::JobKind;

use super::text::Item;

/// A calibration that is to be mended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mended {
    /// Its name.
    pub job: String,
    /// What is written there: `"sampler": "smc"`.
    pub settings: String,
}

/// The calibrations of a pass, as far as they have a result, that did not converge and that other settings mend.
pub fn to_mend(pass: &LoadedPass, executed: &Executed) -> Vec<Mended> {
    let calibrations = executed.results(pass).filter_map(|(position, finished)| {
        let node = &executed.plan.nodes()[position];
        let is_it = node.task.kind() == Kind::NAME;
        let output = is_it.then(|| Output::deserialize(&*finished.stored.value).ok()).flatten()?;
        match output.remedy()? {
            Remedy::Settings(settings) => Some(Mended { job: node.name.clone(), settings }),
            Remedy::Upstream(_) => None,
        }
    });
    calibrations.collect()
}

/// Writes the settings over those of the jobs; gives what was written.
pub(super) fn mend(jobs: &mut [(String, Item)], mended: &[Mended]) -> Vec<Mended> {
    let mut written = Vec::new();
    for one in mended {
        let text = format!("{{{}}}", one.settings);
        let fields = read_document("settings", text.as_bytes(), &mut Diagnostics::new());
        let Some(Item::Object(fields)) = fields.as_ref().map(Item::of_node) else { continue };
        let Some((_, Item::Object(kinds))) = jobs.iter_mut().find(|(name, _)| *name == one.job) else { continue };
        let Some((_, Item::Object(own))) = kinds.iter_mut().find(|(kind, _)| kind == Kind::NAME) else { continue };
        let is_sampler = fields.iter().any(|(name, _)| name == "sampler");
        // What is said of the old sampler is not said of another.
        own.retain(|(name, _)| {
            let of_sampler = matches!(name.as_str(), "acceptance" | "warmup" | "draws" | "chains");
            !(is_sampler && of_sampler || fields.iter().any(|(other, _)| other == name))
        });
        own.extend(fields);
        written.push(one.clone());
    }
    written
}
