//! Settings of `design` as written.

use serde_json::json;

use crate::document::written::wrong_type;
use crate::document::{
    Amount, Diagnostics, Map, Node, Schemas, Spanned, Value, Written, written_struct, written_words,
};
use crate::study::pass::measurement::SensorForm;
use crate::study::pass::variable::SweepForm;

written_struct! {
    /// Settings of `design`.
    pub struct DesignForm: "settings of `design`" {
        /// Parameters to learn; all whose prior is not fixed where they are left out.
        optional learn: Vec<Spanned<String>>,
        /// Uncertain parameters that are integrated out; all others whose prior is not fixed where they are left out. What
        /// is neither stays at its nominal value.
        optional nuisance: Vec<Spanned<String>>,
        /// Candidate phases: a grid over inputs, or a list of phases. Bare numbers are in the input's own unit.
        required conditions: Spanned<ConditionsForm>,
        /// The environment in which the other inputs are; nominal values where it is left out.
        optional environment: Spanned<String>,
        /// Constant values of further inputs over those of the environment.
        default(Map::default()) inputs: Map<Amount>,
        /// Sensors of the pass's measurements by name, or an object of sensors; all of the pass where they are left out.
        optional sensors: Spanned<SensorsForm>,
        /// How many of the sensors are wanted: they are chosen one after the other at the best candidate.
        optional choose_sensors: Spanned<u64>,
        /// How the expected information is estimated, `automatic` where it is left out: the first of `nested`, `importance` and
        /// `laplace` that can be trusted by its own diagnostics.
        optional estimator: EstimatorForm,
        /// Further phases that are sought between the values of the grid, where more may be learnt (Bayesian optimisation); none
        /// where it is left out.
        optional search: Spanned<u64>,
        /// Outer samples, 4096 where it is left out; a power of two.
        optional outer: Spanned<u64>,
        /// Inner samples, 1024 where it is left out; a power of two of at most half of `outer`.
        optional inner: Spanned<u64>,
        /// Draws of an inner integral by importance sampling, 32 where it is left out; a power of two.
        optional draws: Spanned<u64>,
        /// Largest probabilities with which nodes may lie outside their limits; red 0.01 where it is left out.
        optional limits: LimitsForm,
        /// How many phases the experiment has, 1 where it is left out: they are chosen one after the other.
        optional pick: Spanned<u64>,
    }
}

written_struct! {
    /// Largest probabilities with which a node may lie outside its limits.
    pub struct LimitsForm: "limits {\"red\": ..., \"yellow\": ...}" {
        /// Of red limits.
        optional red: Spanned<f64>,
        /// Of yellow limits; not bounded where it is left out.
        optional yellow: Spanned<f64>,
    }
}

written_words! {
    /// How expected information is estimated.
    pub enum EstimatorForm: "an estimator" {
        /// The first of the next three that can be trusted by its own diagnostics.
        "automatic" => Automatic,
        /// Nested Monte Carlo.
        "nested" => Nested,
        /// Importance sampling round Laplace approximations.
        "importance" => Importance,
        /// Laplace approximations.
        "laplace" => Laplace,
        /// Linear model, normal priors.
        "linear" => Linear,
    }
}

/// Candidate phases.
#[derive(Clone, Debug, PartialEq)]
pub enum ConditionsForm {
    /// A grid over inputs.
    Grid(Map<SweepForm>),
    /// One by one.
    Phases(Vec<Spanned<Map<Amount>>>),
}

impl Written for ConditionsForm {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match &node.value {
            Value::Object(_) => Map::read(node, diagnostics).map(Self::Grid),
            Value::Array(_) => Vec::read(node, diagnostics).map(Self::Phases),
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        json!({"anyOf": [Map::<SweepForm>::schema(schemas), Vec::<Map<Amount>>::schema(schemas)]})
    }
    fn expected() -> String {
        "{\"W\": {\"from\": ..., \"to\": ..., \"steps\": ...}}, or a list of phases [{\"W\": ...}]".to_owned()
    }
}

/// Sensors of an experiment.
#[derive(Clone, Debug, PartialEq)]
pub enum SensorsForm {
    /// Of the pass's measurements, by name.
    Names(Vec<Spanned<String>>),
    /// Of the job's own.
    Own(Map<SensorForm>),
}

impl Written for SensorsForm {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match &node.value {
            Value::Array(_) => Vec::read(node, diagnostics).map(Self::Names),
            Value::Object(_) => Map::read(node, diagnostics).map(Self::Own),
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        json!({"anyOf": [Vec::<String>::schema(schemas), Map::<SensorForm>::schema(schemas)]})
    }
    fn expected() -> String {
        "names of sensors, or {\"NAME\": {\"measures\": ..., \"sigma\": ...}}".to_owned()
    }
}
