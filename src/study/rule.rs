//! Margin rules, a JSON file each: those that come with the program, and a study's own under `rules/`.
//!
//! To add one to the program: a file in `src/study/rules` and a line in the list below.

use crate::document::{
    Amount, Diagnostic, Diagnostics, EvidenceForm, Sense, code, source_text, written_choice, written_struct,
};
use serde::{Deserialize, Serialize};

use crate::expression::Dimension;

use super::folder::Folder;
use super::inherit::unnamed_file_diagnostic;

/// The format's name in the file.
const FORMAT: &str = "bmv-rule/1";

/// Folder of a study's own rules.
pub const FOLDER: &str = "rules";

/// Rules that come with the program, in the order in which they are shown.
pub const EMBEDDED: &[(&str, &str)] = &[
    ("none", include_str!("rules/none.json")),
    ("nasa-gsfc-5k", include_str!("rules/nasa-gsfc-5k.json")),
    ("military-11k", include_str!("rules/military-11k.json")),
    ("military-17k", include_str!("rules/military-17k.json")),
    ("heat-load-25", include_str!("rules/heat-load-25.json")),
];

/// What a rule adds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Margin {
    /// The limit is moved towards the prediction by so many kelvins.
    TemperatureK(f64),
    /// The heat loads are multiplied by 1 + this share.
    HeatLoad(f64),
}

/// A margin rule, from a data file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Rule {
    /// Name.
    pub name: String,
    /// What it adds.
    pub margin: Margin,
    /// Title, for people.
    pub title: String,
    /// Where it comes from.
    pub source: String,
}

written_struct! {
    /// A margin rule.
    pub struct RuleForm: "a margin rule" {
        /// `bmv-rule/1`.
        required format: String,
        /// Title, for people.
        required title: String,
        /// What it adds.
        required margin: MarginForm,
        /// Where it comes from.
        required source: String,
        /// How far the source was itself read.
        optional evidence: EvidenceForm,
    }
}

written_choice! {
    /// What a rule adds.
    pub enum MarginForm: "a margin" {
        /// The limit moves towards the prediction by this difference of temperature.
        "temperature" => Temperature(Amount),
        /// Heat loads grow by this share.
        "heat_load" => HeatLoad(Amount),
    }
}

impl RuleForm {
    /// The rule under a name.
    pub fn resolve(&self, name: &str, diagnostics: &mut Diagnostics) -> Option<Rule> {
        let (amount, dimension) = match &self.margin {
            MarginForm::Temperature(amount) => (amount, Dimension::TEMPERATURE),
            MarginForm::HeatLoad(amount) => (amount, Dimension::NONE),
        };
        let value = amount.si(dimension, None, Sense::Difference, diagnostics)?;
        if value < 0.0 {
            let message = format!("a margin of {value} is negative");
            diagnostics.push(Diagnostic::error(&code::RULE_FILE, &amount.place, message).expected("a margin from 0"));
            return None;
        }
        let margin = match &self.margin {
            MarginForm::Temperature(_) => Margin::TemperatureK(value),
            MarginForm::HeatLoad(_) => Margin::HeatLoad(value),
        };
        let source = source_text(&self.source, self.evidence);
        Some(Rule { name: name.to_owned(), margin, title: self.title.clone(), source })
    }
}

/// The rules that come with the program, then the study's own, which replace those of the same name. Beside each of
/// the study's own stands its JSON, which is part of the study's definition.
pub fn load(folder: Option<&Folder>, diagnostics: &mut Diagnostics) -> Vec<(Rule, Option<serde_json::Value>)> {
    let mut rules: Vec<(Rule, Option<serde_json::Value>)> = Vec::new();
    for (name, text) in EMBEDDED {
        let read = crate::document::read_file::<RuleForm>(name, text.as_bytes(), FORMAT, diagnostics);
        rules.extend(read.and_then(|(form, _)| form.resolve(name, diagnostics)).map(|rule| (rule, None)));
    }
    let Some(folder) = folder else { return rules };
    for name in folder.json_names(FOLDER) {
        let file = format!("{FOLDER}/{name}.json");
        let bytes = match folder.read(&file) {
            Ok(bytes) => bytes,
            Err(error) => {
                diagnostics.push(unnamed_file_diagnostic(folder, &file, &error));
                continue;
            }
        };
        let read = crate::document::read_file::<RuleForm>(&folder.shown_name(&file), &bytes, FORMAT, diagnostics);
        let Some((form, node)) = read else { continue };
        let Some(rule) = form.resolve(&name, diagnostics) else { continue };
        rules.retain(|(other, _)| other.name != name);
        rules.push((rule, Some(node.to_json())));
    }
    rules
}
