//! An adopted effect as written.

use crate::document::{Amount, Map, NameOr, OneOrMany, Spanned, WrittenUnit, written_struct};

use super::uncertain::UncertainForm;
use crate::study::model::PriorForm;

written_struct! {
    /// An effect that is added to the model.
    pub struct Adopted: "an adopted effect" {
        /// The effect: an object with one key, its name in the catalogue.
        required effect: Map<EffectUse>,
        /// Why it is adopted.
        required because: Spanned<String>,
        /// The job that supports it.
        optional evidence: Evidence,
        /// Measurements and environments that have it; all where it is left out.
        optional applies_to: Vec<Spanned<String>>,
        /// Start temperature of the nodes that it adds, by transient measurement; where it is left out, that of their host.
        default(Map::default()) starts: Map<UncertainForm>,
    }
}

written_struct! {
    /// Where an effect acts and with which parameters.
    pub struct EffectUse: "an effect's use" {
        /// Names of what it acts on (for a pair two nodes), or `{"group": NAME}`.
        optional place as "where": OneOrMany<NameOr<GroupForm>>,
        /// The model's input for each of the effect's inputs.
        default(Map::default()) inputs: Map<Spanned<String>>,
        /// Reference temperature of a law that changes something with temperature; 20 degC where it is left out.
        optional reference: Amount,
        /// The effect's parameters; those left out are the catalogue's.
        default(Map::default()) parameters: Map<EffectParameter>,
    }
}

impl EffectUse {
    /// The names of what it acts on, without groups.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.place.iter().flat_map(|OneOrMany(places)| places).filter_map(|place| match place {
            NameOr::Name(name) => Some(name.value.as_str()),
            NameOr::Other(GroupForm { .. }) => None,
        })
    }
}

written_struct! {
    /// A group of the model.
    pub struct GroupForm: "a group" {
        /// Its name.
        required group: Spanned<String>,
    }
}

written_struct! {
    /// A parameter of an effect.
    pub struct EffectParameter: "a parameter of an effect" {
        /// Its unit.
        optional unit: WrittenUnit,
        /// Nominal value; a bare number is in the unit.
        optional nominal: Amount,
        /// Prior, in the unit.
        optional prior: PriorForm,
        /// Description, for the report.
        optional description: String,
    }
}

written_struct! {
    /// A job's result.
    pub struct Evidence: "a job's result" {
        /// The pass's file.
        required pass: Spanned<String>,
        /// The job's name.
        required job: Spanned<String>,
        /// Probability that the effect is there, as that job stated it.
        optional probability: Spanned<f64>,
        /// Standard deviations of the sizes that it stated, by the effect's parameters, in the units of these.
        default(Map::default()) sd: Map<f64>,
    }
}
