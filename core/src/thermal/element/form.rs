//! How an element is read from a model's file.

use crate::document::formula::Expected;
use crate::document::{Diagnostic, Diagnostics, Formulas, Place, Scalar, Spanned, code};
use crate::expression::{Dimension, ExprId};

use super::ElementKind;

/// The model into which elements are read.
pub trait Lookup {
    /// Index of a node; an unknown one is reported at `place`.
    fn find_node(&self, name: &str, place: &Place, diagnostics: &mut Diagnostics) -> Option<usize>;
    /// The graph with the model's names.
    fn formulas(&mut self) -> Formulas<'_>;
    /// Notes where the value `what` of an element stands, by the element's kind and name, for later messages.
    fn note(&mut self, kind: &'static str, name: &str, what: &'static str, place: &Place);
}

/// An element as written.
pub trait ElementForm {
    /// The element, with its nodes and expressions looked up; `None` where something is wrong, which is reported at its
    /// place. `name` is the element's, with its place.
    fn resolve(
        &self,
        name: &Spanned<String>,
        model: &mut dyn Lookup,
        diagnostics: &mut Diagnostics,
    ) -> Option<ElementKind>;
}

/// Reports an impossible constant.
pub(super) fn refuse(place: &Place, message: String, expected: &str, diagnostics: &mut Diagnostics) {
    diagnostics.push(Diagnostic::error(&code::OUT_OF_RANGE, place, message).expected(expected));
}

/// Two nodes that differ, and the expression between them.
pub(super) fn path(
    model: &mut dyn Lookup,
    between: &[Spanned<String>; 2],
    scalar: &Scalar,
    expected: Expected,
    diagnostics: &mut Diagnostics,
) -> Option<([usize; 2], ExprId)> {
    let [a, b] = between;
    let first = model.find_node(&a.value, &a.place, diagnostics);
    let second = model.find_node(&b.value, &b.place, diagnostics);
    let ends = [first?, second?];
    if ends[0] == ends[1] {
        diagnostics.push(
            Diagnostic::error(&code::SELF_LOOP, &b.place, format!("both ends are the node `{}`", a.value))
                .expected("two different nodes"),
        );
        return None;
    }
    let mut formulas = model.formulas();
    let locals = formulas.ends(ends);
    let id = formulas.scalar(scalar, expected, &locals, diagnostics)?;
    // A flow may be negative: it has a direction. A conductance or exchange area below 0 moves heat uphill.
    if expected.dimension != Dimension::POWER
        && let Some(value) = formulas.graph.constant(id).filter(|v| *v < 0.0)
    {
        let message = format!("{} of {value} {}", expected.what, expected.dimension);
        refuse(scalar.place(), message, "0 or more", diagnostics);
        return None;
    }
    Some((ends, id))
}
