//! The model as written.

use crate::document::{Amount, Diagnostics, Map, PriorForm, Scalar, Spanned, WrittenUnit, written_struct};
use crate::thermal::element::*;

use super::group::GroupForm;
use super::quantity::QuantityOrName;
use super::resolve::ResolvedModel;
use super::surrogate::SurrogateForm;
use super::tabulated::TabulatedForm;
use crate::study::external::{CommandForm, UmBridgeForm};

/// The format's name in the file.
pub const FORMAT: &str = "bmv-network/1";

/// Declares the model's form with a field for each kind of element, and how all elements are resolved.
macro_rules! model_form {
    ($( $(#[doc = $doc:literal])* $field:ident: $kind:ident, $form:ident in $module:ident, )*) => {
        written_struct! {
            /// A thermal network, or an algebraic model without nodes.
            pub struct ModelForm: "a model" {
                /// `bmv-network/1`.
                required format: Spanned<String>,
                /// Title, for people.
                default(String::new()) title: String,
                /// Description, for the report.
                optional description: String,
                /// Where the model comes from.
                optional source: String,
                /// Set where numbers were reconstructed instead of taken from the source that the study follows: what and how.
                /// The report shows it wherever it shows results.
                optional reconstructed: String,
                /// Environments and dissipations: what a test sets or a mission brings.
                default(Map::default()) inputs: Map<InputForm>,
                /// What is uncertain.
                default(Map::default()) parameters: Map<ParameterForm>,
                /// Piecewise linear functions for `interp(table, x)`.
                default(Map::default()) tables: Map<TableForm>,
                /// The nodes of the network.
                default(Map::default()) nodes: Map<NodeForm>,
                $( $(#[doc = $doc])* default(Map::default()) $field: Map<$form>, )*
                /// Conductors and radiations that stand in CSV tables, beside those above.
                optional tabulated: Spanned<TabulatedForm>,
                /// A program that answers for the model, in place of nodes and elements.
                optional command: Spanned<CommandForm>,
                /// A server of the UM-Bridge protocol that answers for the model, in place of nodes and elements.
                optional umbridge: Spanned<UmBridgeForm>,
                /// A Gaussian process in place of that program or server, where it takes long to answer.
                optional surrogate: Spanned<SurrogateForm>,
                /// Members that share physics.
                default(Map::default()) groups: Map<GroupForm>,
                /// What is asked of the model.
                default(Map::default()) quantities: Map<QuantityOrName>,
            }
        }

        impl ModelForm {
            /// Resolves all elements into the model, in the order of the fields.
            pub(super) fn resolve_elements(&self, model: &mut ResolvedModel, diagnostics: &mut Diagnostics) {
                $( model.resolve_elements(&self.$field, diagnostics); )*
            }
        }
    };
}

bmv_core::element_kinds!(model_form);

written_struct! {
    /// An input: a boundary temperature, a dissipation, an environment.
    pub struct InputForm: "an input" {
        /// The unit of the entry's bare numbers, and of the input in reports.
        optional unit: WrittenUnit,
        /// Value where nothing else is said.
        required nominal: Amount,
        /// Range in use; the data's minimum and maximum where it is left out.
        optional range: Spanned<[Amount; 2]>,
        /// Whether a test can set it.
        default(true) settable: bool,
        /// Whether every test sets it, so that a measurement that does not say its value is wrong.
        default(false) test_sets: bool,
        /// Standard deviation of the input's own error.
        optional sigma: Amount,
        /// A constant error of the input, fitted.
        optional bias: BiasForm,
        /// Description, for the report.
        optional description: String,
        /// Where the value comes from.
        optional source: String,
    }
}

written_struct! {
    /// A constant error with its prior.
    pub struct BiasForm: "a bias, {\"prior\": ...}" {
        /// Its prior, in the entry's unit (differences).
        required prior: PriorForm,
    }
}

written_struct! {
    /// A parameter with its prior.
    pub struct ParameterForm: "a parameter" {
        /// The unit of the entry's bare numbers, and of the parameter in reports.
        optional unit: WrittenUnit,
        /// Value as delivered.
        required nominal: Amount,
        /// What is known of it; fixed at the nominal value where it is left out.
        optional prior: PriorForm,
        /// Description, for the report.
        optional description: String,
        /// Where value and prior come from.
        optional source: String,
    }
}

written_struct! {
    /// A piecewise linear function, constant outside.
    pub struct TableForm: "a table" {
        /// Abscissae, strictly increasing, SI.
        required x: Spanned<Vec<f64>>,
        /// Ordinates, as many, SI.
        required y: Spanned<Vec<f64>>,
        /// Description, for the report.
        optional description: String,
        /// Where it comes from.
        optional source: String,
    }
}

written_struct! {
    /// A node: with `boundary` of given temperature, with `capacity` storing heat, with neither arithmetic.
    pub struct NodeForm: "a node" {
        /// Temperature, K; may depend on parameters, inputs and time.
        optional boundary: Scalar,
        /// Heat capacity, J/K; may depend on `T`.
        optional capacity: Scalar,
        /// Surface area, m2.
        optional area: Amount,
        /// Name or number in another tool.
        optional alias: String,
        /// Temperature limits.
        optional limits: LimitsForm,
        /// Description, for the report.
        optional description: String,
        /// Where the values come from.
        optional source: String,
    }
}

written_struct! {
    /// Temperature limits, [lower, upper].
    pub struct LimitsForm: "temperature limits" {
        /// Caution limits.
        optional yellow: Spanned<[Amount; 2]>,
        /// Limits that must not be exceeded.
        optional red: Spanned<[Amount; 2]>,
    }
}
