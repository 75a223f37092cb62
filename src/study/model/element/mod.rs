//! Elements of the network as written, a kind a file: the form, and how it becomes an element. A new kind is a file
//! here and an entry in the list below.

use crate::document::formula::Expected;
use crate::document::{Diagnostic, Diagnostics, Map, Place, Scalar, Spanned, code};
use crate::expression::{Dimension, ExprId};
use crate::thermal::element::{Element, ElementKind};

use super::form::ModelForm;
use super::name;
use super::resolve::ResolvedModel;

/// An element as written.
trait ElementForm {
    /// The element, with its nodes and expressions looked up; `None` where something is wrong, which is reported at its
    /// place. `name` is the element's, with its place.
    fn resolve(
        &self,
        name: &Spanned<String>,
        model: &mut ResolvedModel,
        diagnostics: &mut Diagnostics,
    ) -> Option<ElementKind>;
}

/// Hands the kinds to another macro: the field of the model's form with its documentation, the form and its module.
macro_rules! element_kinds {
    ($use_them:ident) => {
        $use_them! {
            /// Linear conductors: heat a to b = conductance (Ta - Tb).
            conductors: ConductorForm in conductor,
            /// Radiative exchange: heat a to b = sigma exchange_area (Ta^4 - Tb^4).
            radiations: RadiationForm in radiation,
            /// Heat into nodes.
            loads: LoadForm in load,
            /// Any heat flow between two nodes.
            flows: FlowForm in flow,
            /// Thermoelectric coolers.
            coolers: CoolerForm in cooler,
            /// Controlled heaters.
            heaters: HeaterForm in heater,
        }
    };
}
pub(super) use element_kinds;

/// Declares the modules and forms of the kinds, and how all elements are resolved.
macro_rules! forms {
    ($( $(#[doc = $doc:literal])* $field:ident: $form:ident in $module:ident, )*) => {
        $( mod $module; pub use $module::$form; )*

        /// Resolves all elements into the model, in the order of the form.
        pub(super) fn resolve_all(form: &ModelForm, model: &mut ResolvedModel, diagnostics: &mut Diagnostics) {
            $( resolve(&form.$field, model, diagnostics); )*
        }
    };
}

element_kinds!(forms);

fn resolve<T: ElementForm>(forms: &Map<T>, model: &mut ResolvedModel, diagnostics: &mut Diagnostics) {
    name::check_labels(forms, diagnostics);
    for entry in forms {
        let name = Spanned { value: entry.name.clone(), place: entry.name_place.clone() };
        if let Some(kind) = entry.value.resolve(&name, model, diagnostics) {
            model.model.elements.push(Element { name: name.value, kind });
        }
    }
}

/// Reports an impossible constant.
fn refuse(place: &Place, message: String, expected: &str, diagnostics: &mut Diagnostics) {
    diagnostics.push(Diagnostic::error(&code::OUT_OF_RANGE, place, message).expected(expected));
}

impl ResolvedModel {
    /// Two nodes that differ, and the expression between them.
    fn path(
        &mut self,
        between: &[Spanned<String>; 2],
        scalar: &Scalar,
        expected: Expected,
        diagnostics: &mut Diagnostics,
    ) -> Option<([usize; 2], ExprId)> {
        let [a, b] = between;
        let first = self.find_node(&a.value, &a.place, diagnostics);
        let second = self.find_node(&b.value, &b.place, diagnostics);
        let ends = [first?, second?];
        if ends[0] == ends[1] {
            diagnostics.push(
                Diagnostic::error(&code::SELF_LOOP, &b.place, format!("both ends are the node `{}`", a.value))
                    .expected("two different nodes"),
            );
            return None;
        }
        let mut formulas = self.formulas();
        let locals = formulas.ends(ends);
        let id = formulas.scalar(scalar, expected, &locals, diagnostics)?;
        // A flow may be negative: it has a direction. A conductance or exchange area below 0 moves heat uphill.
        if expected.dimension != Dimension::POWER
            && let Some(value) = self.model.graph.constant(id).filter(|v| *v < 0.0)
        {
            refuse(
                scalar.place(),
                format!("{} of {value} {}", expected.what, expected.dimension),
                "0 or more",
                diagnostics,
            );
            return None;
        }
        Some((ends, id))
    }
}
