//! From scalars as written to expressions in the model's graph, with errors that point into the string.

use super::{Diagnostic, Diagnostics, Place, Scalar, Sense, Spanned, code, suggest};
use crate::expression::infer::infer;
use crate::expression::{Dependence, Dimension, ExprId, Fault, Graph, Names, ParseError, Scope, Symbol, parse};

/// Reads expressions into a graph with the names of a model.
pub struct Formulas<'a> {
    /// The graph.
    pub graph: &'a mut Graph,
    /// The names that hold everywhere.
    pub names: &'a Names,
}

/// What an expression is for.
#[derive(Clone, Copy, Debug)]
pub struct Expected {
    /// The dimension of its value.
    pub dimension: Dimension,
    /// Whether a value with a unit is a place on a scale or a distance.
    pub sense: Sense,
    /// What it may depend on.
    pub allowed: Dependence,
    /// What it is, for messages: `a conductance`.
    pub what: &'static str,
}

impl Expected {
    /// Parameters, inputs and time: what is known before temperatures are.
    pub const GIVEN: Dependence = Dependence::PARAMETER.union(Dependence::INPUT).union(Dependence::TIME);

    /// An absolute value that may depend on anything of the model.
    pub const fn value(dimension: Dimension, what: &'static str) -> Self {
        Self { dimension, sense: Sense::Absolute, allowed: Self::GIVEN.union(Dependence::NODE), what }
    }

    /// The same, free of node temperatures.
    pub const fn given(self) -> Self {
        Self { allowed: Self::GIVEN, ..self }
    }

    /// A difference.
    pub const fn difference(self) -> Self {
        Self { sense: Sense::Difference, ..self }
    }
}

impl Formulas<'_> {
    /// Temperatures `Ta`, `Tb` and `Tm` of an element between two nodes.
    pub fn ends(&mut self, [a, b]: [usize; 2]) -> Vec<(&'static str, ExprId)> {
        let (ta, tb) = (self.node(a), self.node(b));
        let sum = self.graph.add(ta, tb);
        let half = self.graph.number(0.5);
        let mean = self.graph.multiply(half, sum);
        vec![("Ta", ta), ("Tb", tb), ("Tm", mean)]
    }

    /// Temperature of a node.
    pub fn node(&mut self, node: usize) -> ExprId {
        self.graph.symbol(Symbol::Node(u32::try_from(node).unwrap_or(u32::MAX)))
    }

    /// The expression of a scalar. `None` after an error.
    pub fn scalar(
        &mut self,
        scalar: &Scalar,
        expected: Expected,
        locals: &[(&str, ExprId)],
        diagnostics: &mut Diagnostics,
    ) -> Option<ExprId> {
        match scalar {
            Scalar::Amount(amount) => {
                let value = amount.si(expected.dimension, None, expected.sense, diagnostics)?;
                Some(self.graph.number(value))
            }
            Scalar::Expression(text) => self.text(text, expected, locals, diagnostics),
        }
    }

    /// The expression of a text. `None` after an error; a clash of units is a warning.
    pub fn text(
        &mut self,
        text: &Spanned<String>,
        expected: Expected,
        locals: &[(&str, ExprId)],
        diagnostics: &mut Diagnostics,
    ) -> Option<ExprId> {
        let id = self.parse(text, locals, diagnostics)?;
        let place = &text.place;
        if !self.graph.dependence(id).within(expected.allowed) {
            let message = format!("{} may depend on parameters, inputs and t only", expected.what);
            diagnostics.push(
                Diagnostic::error(&code::FORBIDDEN_DEPENDENCE, place, message)
                    .expected("an expression without temperatures of the network"),
            );
            return None;
        }
        let mut clashes = Vec::new();
        let names = self.names;
        // The mean of two temperatures has a factor 1/2, which inference takes for a number with a unit.
        let temperatures: Vec<_> = locals
            .iter()
            .filter(|(name, _)| ["Ta", "Tb", "Tm", "T"].contains(name))
            .map(|&(_, id)| (id, Dimension::TEMPERATURE))
            .collect();
        let inferred = infer(self.graph, id, &|symbol| names.dimension(symbol), &temperatures, &mut clashes);
        for clash in &clashes {
            diagnostics.push(Diagnostic::warning(&code::UNIT_CLASH, place, format!("the units clash: {clash}")));
        }
        if let Some(inferred) = inferred.filter(|d| *d != expected.dimension && clashes.is_empty()) {
            let message =
                format!("{} in {} is expected; the expression is in {inferred}", expected.what, expected.dimension);
            diagnostics.push(
                Diagnostic::warning(&code::UNIT_CLASH, place, message)
                    .expected(format!("something in {}", expected.dimension)),
            );
        }
        Some(id)
    }

    /// Parses a text without any check of its units.
    pub fn parse(
        &mut self,
        text: &Spanned<String>,
        locals: &[(&str, ExprId)],
        diagnostics: &mut Diagnostics,
    ) -> Option<ExprId> {
        let scope = Scope::with(self.names, locals.to_vec());
        match parse(&text.value, self.graph, &scope) {
            Ok(id) => Some(id),
            Err(error) => {
                report(&error, &text.place, &scope, diagnostics);
                None
            }
        }
    }
}

/// Reports an expression's error at its place in the string.
fn report(error: &ParseError, place: &Place, scope: &Scope<'_>, diagnostics: &mut Diagnostics) {
    let code = match error.fault {
        Fault::Syntax => &code::EXPRESSION_SYNTAX,
        Fault::UnknownName => &code::UNKNOWN_NAME,
        Fault::Arguments => &code::EXPRESSION_ARGUMENTS,
        Fault::Depth => &code::EXPRESSION_DEPTH,
        Fault::Undefined => &code::UNDEFINED_VALUE,
    };
    let mut diagnostic = Diagnostic::error(code, &place.inside_string(error.start, error.end), &error.message);
    diagnostic.expected.clone_from(&error.expected);
    diagnostic.help.clone_from(&error.help);
    if let (Some(name), None) = (&error.name, &error.help) {
        let functions = crate::expression::scope::RESERVED.iter().copied().filter(|r| r.len() > 2);
        let candidates: Vec<&str> = scope.all().chain(functions).collect();
        let near = diagnostics.nearest(name, candidates.iter().copied());
        diagnostic = match near {
            Some(near) => diagnostic.help(format!("did you mean `{near}`?")),
            None if scope.all().next().is_none() => diagnostic.help("the model has no parameters and inputs"),
            None => diagnostic.help(format!("known here are {}", suggest::listed(scope.all(), 12))),
        };
    }
    diagnostics.push(diagnostic);
}
