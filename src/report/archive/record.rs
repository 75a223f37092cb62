//! `record.json`: what a pass's report says in brief, for the pages over several passes. Format `bmv-record/1`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::document::hash::sha256_hex;
use crate::job::predict;
use crate::report::history::PassErrors;
use crate::report::known::{self, Known};
use crate::report::page::{Status, Text};
use crate::report::section::compliance::{Judged, judged};
use crate::report::section::design_values::{self, DesignValue};
use crate::report::section::{self};
use crate::report::view::PassReport;
use crate::study::StudyDocument;

/// The file's name in the folder of a pass's report.
pub const FILE_NAME: &str = "record.json";
const FORMAT: &str = "bmv-record/1";

/// A change of a parameter, or an effect, with its reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Change {
    /// The parameter or effect.
    pub what: String,
    /// Before, in words.
    pub before: String,
    /// After, in words.
    pub after: String,
    /// Why.
    pub because: String,
}

/// A model's file as a pass read it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModelFile {
    /// Path within the study.
    pub path: String,
    /// SHA-256 of its bytes, lower-case hex.
    pub sha256: String,
    /// Its entries, by section and name, with their texts, or hashes of long ones; none where there are too many.
    pub entries: BTreeMap<String, String>,
}

/// What a prediction takes of a calibration.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Flight {
    /// The prediction.
    pub job: String,
    /// Where its draws come from.
    pub source: String,
    /// Parameters with draws.
    pub parameters: Vec<String>,
}

/// A key statement of the first screen.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeyStatement {
    /// What it is about.
    pub label: String,
    /// Number or word.
    pub value: String,
    /// How it stands.
    pub status: Option<Status>,
}

/// A pass's report in brief.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// `bmv-record/1`.
    pub format: String,
    /// Name of the study.
    pub study: String,
    /// File of the pass.
    pub pass: String,
    /// Title of the pass.
    pub title: String,
    /// What came out, in plain words; empty where no result says it.
    pub outcome: String,
    /// Whether the report is that of a pass that closes the validation.
    pub closes: bool,
    /// What of the model was reconstructed.
    pub reconstructed: Option<String>,
    /// The study's document.
    pub document: Option<StudyDocument>,
    /// Key statements of the first screen.
    pub statements: Vec<KeyStatement>,
    /// The pass's error.
    pub errors: Option<PassErrors>,
    /// Hash of the readings of that error.
    pub readings_sha256: Option<String>,
    /// Parameters.
    pub parameters: Vec<Known>,
    /// Requirements.
    pub requirements: Vec<Judged>,
    /// The model's file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<ModelFile>,
    /// Nominal values and priors against the model's file.
    pub changes: Vec<Change>,
    /// Adopted effects.
    pub adopted: Vec<Change>,
    /// What predictions take of calibrations.
    pub flight: Vec<Flight>,
    /// Design values to which its approaches lead.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub design_values: Vec<DesignValue>,
}

/// Entries of a model's file that a record holds, and letters of one of them.
const MOST_ENTRIES: usize = 500;
const MOST_LETTERS: usize = 80;
/// How the hash of a longer one begins.
pub(super) const HASH: &str = "sha256:";

fn short_entries(entries: &[(String, String)]) -> BTreeMap<String, String> {
    let short = |text: &String| {
        if text.len() <= MOST_LETTERS { text.clone() } else { format!("{HASH}{}", sha256_hex(text.as_bytes())) }
    };
    let few = if entries.len() <= MOST_ENTRIES { entries } else { &[] };
    few.iter().map(|(name, text)| (name.clone(), short(text))).collect()
}

impl Record {
    /// The record of a report.
    pub fn of(report: &PassReport<'_>) -> Self {
        let errors = report.history.iter().flat_map(|history| &history.passes);
        let errors = errors.filter(|own| own.pass == report.pass_file).find(|own| own.is_measured()).cloned();
        let (outcome, statements) = section::in_brief(report);
        let flight = report.outputs::<predict::Kind>().flat_map(|(job, output)| {
            output.posterior.posterior_priors.iter().map(move |own| Flight {
                job: job.to_owned(),
                source: own.source.replace('`', ""),
                parameters: own.parameters.clone(),
            })
        });
        Self {
            format: FORMAT.to_owned(),
            study: report.study.clone(),
            pass: report.pass_file.clone(),
            title: report.title.clone(),
            outcome: outcome.as_ref().map(Text::in_plain_words).unwrap_or_default(),
            closes: report.closing.is_some(),
            reconstructed: report.reconstructed.clone(),
            document: report.document.clone(),
            statements: (statements.into_iter())
                .map(|own| KeyStatement { label: own.label, value: own.value, status: own.status })
                .collect(),
            readings_sha256: errors.as_ref().and_then(|own| own.readings_sha256.clone()),
            errors,
            parameters: known::parameters(report),
            requirements: judged(report),
            // That of the pass itself stands before those of its parents.
            model: report.files.iter().find(|own| own.role == "model").map(|own| ModelFile {
                path: own.path.clone(),
                sha256: own.sha256.clone(),
                entries: short_entries(&own.entries),
            }),
            changes: (report.changes.iter())
                .map(|own| Change {
                    what: own.what.clone(),
                    before: own.before.clone(),
                    after: own.after.clone(),
                    because: own.because.clone(),
                })
                .collect(),
            adopted: (report.adopted.iter())
                .map(|own| Change {
                    what: own.name.clone(),
                    before: String::new(),
                    after: format!("{}: {}", own.title, own.place.join(", ")),
                    because: own.because.clone(),
                })
                .collect(),
            flight: flight.collect(),
            design_values: design_values::of(report),
        }
    }

    /// The record as the text of its file.
    ///
    /// # Errors
    /// What JSON cannot hold.
    pub fn text(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// Reads a record.
    ///
    /// # Errors
    /// What is none of this format, in words.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        let record: Self = serde_json::from_slice(bytes).map_err(|error| error.to_string())?;
        if record.format == FORMAT {
            return Ok(record);
        }
        Err(format!("its format is `{}`, expected `{FORMAT}`", record.format))
    }

    /// The pass's error with the hash of its readings; `None` where nothing was measured.
    pub fn pass_errors(&self) -> Option<PassErrors> {
        let errors = self.errors.clone()?;
        Some(PassErrors { readings_sha256: self.readings_sha256.clone(), ..errors })
    }

    /// Whether the report is kept with the others.
    pub fn is_archived(&self) -> bool {
        self.document.as_ref().is_none_or(|document| document.not_archived(&self.pass).is_none())
    }
}
