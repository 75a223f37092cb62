//! A pass as written: `pass-N.json`, format `bmv-pass/1`.

pub mod adopt;
pub mod figure;
pub mod measurement;
pub mod uncertain;
pub mod variable;

use crate::document::{Amount, Map, Spanned, written_struct};

use adopt::Adopted;
use figure::FigureForm;
use measurement::MeasurementForm;
use variable::RangeForm;

use super::job::JobNode;
use super::model::{PriorForm, QuantityOrName};
use super::profile::ProfileForm;

/// The format's name in the file.
pub const FORMAT: &str = "bmv-pass/1";

written_struct! {
    /// A pass of a study: what changes against its parent, what was measured, which jobs run.
    pub struct PassForm: "a pass" {
        /// `bmv-pass/1`.
        required format: String,
        /// Title, for people.
        optional title: String,
        /// Description, for the report.
        optional description: String,
        /// The pass whose entries are inherited by name; `null` for the first.
        optional parent: Spanned<String>,
        /// The model's file within the study; `model.json` where no pass says otherwise.
        optional model: Spanned<String>,
        /// Seed of all random numbers, an integer from 0 to 2^53 - 1; 1 where no pass says otherwise.
        optional seed: Spanned<u64>,
        /// Changes of the model's parameters: only the fields given are replaced.
        default(Map::default()) parameters: Map<ParameterChangeForm>,
        /// Effects that are added to the model.
        default(Map::default()) adopt: Map<Adopted>,
        /// What the system must satisfy.
        default(Map::default()) requirements: Map<RequirementForm>,
        /// Named sets of input values; inputs without one keep their nominal value.
        default(Map::default()) environments: Map<Map<Amount>>,
        /// What was measured.
        default(Map::default()) measurements: Map<MeasurementForm>,
        /// What is computed; not inherited.
        default(Map::default()) jobs: Map<JobNode>,
        /// Quantities beside those of the model.
        default(Map::default()) quantities: Map<QuantityOrName>,
        /// Criteria profiles of the study's own, for `compare`.
        default(Map::default()) criteria: Map<ProfileForm>,
        /// Ranges of design variables (parameters or inputs), for jobs that name them.
        default(Map::default()) design: Map<RangeForm>,
        /// The pass closes the validation: its report ends with the record of the whole. Not inherited.
        optional closing: ClosingForm,
        /// Figures of the study's own, for the report; no job depends on them. Not inherited.
        default(Map::default()) figures: Map<FigureForm>,
    }
}

written_struct! {
    /// What people add to the record of a validation.
    pub struct ClosingForm: "what closes a validation" {
        /// Where the model holds and where it does not, a sentence each.
        required domain: Vec<String>,
        /// What became of each discrepancy or anomaly, by its name.
        default(Map::default()) dispositions: Map<String>,
        /// What is left to do, a sentence each.
        default(Vec::new()) left: Vec<String>,
    }
}

written_struct! {
    /// A change of a parameter of the model; its unit stays the model's.
    pub struct ParameterChangeForm: "a change of a parameter" {
        /// New nominal value; a bare number is in the parameter's unit.
        optional nominal: Amount,
        /// New prior, in the parameter's unit.
        optional prior: PriorForm,
        /// New description.
        optional description: String,
        /// New source.
        optional source: String,
        /// Why; required where the nominal value or the prior changes.
        optional because: Spanned<String>,
    }
}

written_struct! {
    /// A limit on a quantity, with the probability with which it must be met.
    pub struct RequirementForm: "a requirement" {
        /// The quantity; a node's name means its temperature.
        required quantity: Spanned<String>,
        /// The quantity must be at most this.
        optional below: Amount,
        /// The quantity must be at least this.
        optional above: Amount,
        /// Required probability, above 0 and at most 1.
        required probability: Spanned<f64>,
        /// Description, for the report.
        optional description: String,
        /// Where it comes from.
        optional source: String,
    }
}
