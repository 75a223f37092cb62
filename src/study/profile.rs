//! Criteria profiles, a JSON file each: those that come with the program, a study's own under `criteria/`, and those
//! that a pass states.
//!
//! To add one to the program: a file in `src/study/criteria` and a line in the list below.

use crate::document::{
    Amount, Diagnostic, Diagnostics, EvidenceForm, MapEntry, Sense, Spanned, code, source_text, written_struct,
};
use serde::{Deserialize, Serialize};

use crate::expression::Dimension;

use super::folder::Folder;
use super::inherit::unnamed_file_diagnostic;

/// The format's name in the file.
const FORMAT: &str = "bmv-criteria/1";

/// Folder of a study's own profiles.
pub const FOLDER: &str = "criteria";

/// The profile where a job names none.
pub const DEFAULT: &str = "smc-3k";

/// Profiles that come with the program.
pub const EMBEDDED: &[(&str, &str)] = &[
    ("smc-3k", include_str!("criteria/smc-3k.json")),
    ("ecss", include_str!("criteria/ecss.json")),
    ("gsfc-5k", include_str!("criteria/gsfc-5k.json")),
    ("precision-1k", include_str!("criteria/precision-1k.json")),
];

/// What a profile demands; `None` where it demands nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Criteria {
    /// Name of the profile.
    pub name: String,
    /// Title, for people.
    pub title: String,
    /// Largest deviation of one reading, K.
    pub each_k: Option<f64>,
    /// Largest magnitude of the mean deviation, K.
    pub mean_k: Option<f64>,
    /// Largest standard deviation, K.
    pub sd_k: Option<f64>,
    /// Share of readings that must keep `each_k`.
    pub share: Option<f64>,
    /// Drift below which a steady phase counts as stabilised, K/s.
    pub stabilisation_k_per_s: Option<f64>,
    /// Where it comes from.
    pub source: String,
}

written_struct! {
    /// What measured minus predicted must keep.
    pub struct ProfileForm: "a criteria profile" {
        /// `bmv-criteria/1`; needed in a file, not in a pass.
        optional format: String,
        /// Title, for people.
        required title: String,
        /// Largest deviation of one reading, a difference of temperature.
        optional each: Amount,
        /// Largest magnitude of the mean deviation.
        optional mean: Amount,
        /// Largest standard deviation.
        optional sd: Amount,
        /// Share of the readings that must keep `each`, above 0 and at most 1; all where it is left out.
        optional share: Spanned<f64>,
        /// Drift below which a steady phase counts as stabilised, such as `{"value": 0.2, "unit": "K/h"}`.
        optional stabilisation: Amount,
        /// Where it comes from.
        required source: String,
        /// How far the source was itself read.
        optional evidence: EvidenceForm,
    }
}

impl ProfileForm {
    /// The profile under a name.
    pub fn resolve(&self, name: &str, diagnostics: &mut Diagnostics) -> Option<Criteria> {
        let before = diagnostics.errors();
        let temperature = Dimension::TEMPERATURE;
        let each_k = limit(self.each.as_ref(), temperature, diagnostics);
        let mean_k = limit(self.mean.as_ref(), temperature, diagnostics);
        let sd_k = limit(self.sd.as_ref(), temperature, diagnostics);
        let rate = temperature.over(Dimension::TIME);
        let stabilisation_k_per_s = limit(self.stabilisation.as_ref(), rate, diagnostics);
        let share = self.share.as_ref().map(|share| {
            if !(share.value > 0.0 && share.value <= 1.0) {
                let message = format!("a share of {} of the readings", share.value);
                diagnostics
                    .push(Diagnostic::error(&code::RULE_FILE, &share.place, message).expected("above 0 and at most 1"));
            }
            share.value
        });
        if diagnostics.errors() > before {
            return None;
        }
        let source = source_text(&self.source, self.evidence);
        let (name, title) = (name.to_owned(), self.title.clone());
        Some(Criteria { name, title, each_k, mean_k, sd_k, share, stabilisation_k_per_s, source })
    }
}

fn limit(amount: Option<&Amount>, dimension: Dimension, diagnostics: &mut Diagnostics) -> Option<f64> {
    let amount = amount?;
    let value = amount.si(dimension, None, Sense::Difference, diagnostics)?;
    if value <= 0.0 {
        let message = format!("a limit of {} leaves nothing", amount.value);
        diagnostics.push(Diagnostic::error(&code::RULE_FILE, &amount.place, message).expected("a limit above 0"));
        return None;
    }
    Some(value)
}

/// The profiles that come with the program, the study's own, and the pass's own; later ones replace those of the same
/// name. Beside each of the study's own files stands its JSON, which is part of the study's definition.
pub fn load<'a>(
    folder: Option<&Folder>,
    own: impl IntoIterator<Item = &'a MapEntry<ProfileForm>>,
    diagnostics: &mut Diagnostics,
) -> Vec<(Criteria, Option<serde_json::Value>)> {
    let mut profiles: Vec<(Criteria, Option<serde_json::Value>)> = Vec::new();
    for (name, text) in EMBEDDED {
        let read = crate::document::read_file::<ProfileForm>(name, text.as_bytes(), FORMAT, diagnostics);
        profiles.extend(read.and_then(|(form, _)| form.resolve(name, diagnostics)).map(|profile| (profile, None)));
    }
    let mut put = |profile: Criteria, json: Option<serde_json::Value>| {
        profiles.retain(|(other, _)| other.name != profile.name);
        profiles.push((profile, json));
    };
    if let Some(folder) = folder {
        for name in folder.json_names(FOLDER) {
            let file = format!("{FOLDER}/{name}.json");
            let bytes = match folder.read(&file) {
                Ok(bytes) => bytes,
                Err(error) => {
                    diagnostics.push(unnamed_file_diagnostic(folder, &file, &error));
                    continue;
                }
            };
            let shown = folder.shown_name(&file);
            let read = crate::document::read_file::<ProfileForm>(&shown, &bytes, FORMAT, diagnostics);
            let Some((form, node)) = read else { continue };
            if let Some(profile) = form.resolve(&name, diagnostics) {
                put(profile, Some(node.to_json()));
            }
        }
    }
    for entry in own {
        if let Some(profile) = entry.value.resolve(&entry.name, diagnostics) {
            put(profile, None);
        }
    }
    profiles
}
