//! What of a model decides a result, as JSON for a job's key: names, values and expressions, but no titles,
//! descriptions or sources.
//!
//! Expressions are written as the list of the terms that the model uses, numbered in the order in which they are
//! first needed, so that shared subexpressions stay shared and the text does not grow.

use std::collections::HashMap;

use serde_json::{Value, json};

use crate::expression::{ExprId, Graph, Term};

use super::model::{Model, NodeKind, QuantityValue};

/// The terms used so far, numbered.
struct Terms<'m> {
    graph: &'m Graph,
    numbers: HashMap<ExprId, usize>,
    written: Vec<Value>,
}

impl Terms<'_> {
    /// Number of an expression, written down with what it needs if it is new.
    fn number(&mut self, root: ExprId) -> Value {
        let mut stack = vec![(root, false)];
        while let Some((id, ready)) = stack.pop() {
            if self.numbers.contains_key(&id) {
                continue;
            }
            let arguments = match self.graph.term(id) {
                Term::Number(_) | Term::Symbol(_) => vec![],
                Term::Unary(_, a) | Term::Interpolate(_, a) | Term::Slope(_, a) => vec![a],
                Term::Binary(_, a, b) => vec![a, b],
            };
            if !ready && !arguments.is_empty() {
                stack.push((id, true));
                stack.extend(arguments.into_iter().rev().map(|a| (a, false)));
                continue;
            }
            let at = |a: ExprId| self.numbers.get(&a).copied().unwrap_or_default();
            let term = match self.graph.term(id) {
                Term::Number(bits) => number(f64::from_bits(bits)),
                Term::Symbol(symbol) => json!(symbol),
                Term::Unary(function, a) => json!([function, at(a)]),
                Term::Binary(function, a, b) => json!([function, at(a), at(b)]),
                Term::Interpolate(table, a) => json!(["interpolate", table, at(a)]),
                Term::Slope(table, a) => json!(["slope", table, at(a)]),
            };
            self.numbers.insert(id, self.written.len());
            self.written.push(term);
        }
        json!(self.numbers.get(&root).copied().unwrap_or_default())
    }
}

/// A number; one that is not finite, which JSON does not have, by its name.
fn number(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { json!(value.to_string()) }
}

impl Model {
    /// What of the model decides a result. The parameters' nominal values are included: they are what a job uses
    /// where nothing else is stated.
    pub fn identity(&self) -> Value {
        let mut terms = Terms { graph: &self.graph, numbers: HashMap::new(), written: Vec::new() };
        let nodes: Vec<Value> = self
            .nodes
            .iter()
            .map(|node| match node.kind {
                NodeKind::Diffusion { capacity } => json!({"name": node.name, "capacity": terms.number(capacity)}),
                NodeKind::Arithmetic => json!({"name": node.name}),
                NodeKind::Boundary { temperature } => {
                    json!({"name": node.name, "boundary": terms.number(temperature)})
                }
            })
            .collect();
        let elements: Vec<Value> =
            self.elements.iter().map(|element| element.identity(&mut |id| terms.number(id))).collect();
        let quantities: Vec<Value> = self
            .quantities
            .iter()
            .map(|quantity| {
                let how = match quantity.value {
                    QuantityValue::Instant(_) => "instant",
                    QuantityValue::Maximum(_) => "maximum",
                    QuantityValue::Minimum(_) => "minimum",
                    QuantityValue::TimeMean(_) => "mean",
                };
                json!({
                    "name": quantity.name,
                    "unit": quantity.unit,
                    "over": how,
                    "value": terms.number(quantity.value.expression()),
                })
            })
            .collect();
        let tables: Vec<Value> = self.graph.tables().iter().map(|t| json!({"x": t.x, "y": t.y})).collect();
        let mut identity = json!({
            "parameters": self.parameters.iter().map(|p| json!({"name": p.name, "nominal": p.nominal})).collect::<Vec<_>>(),
            "inputs": self.inputs.iter().map(|i| json!({"name": i.name, "nominal": i.nominal})).collect::<Vec<_>>(),
            "nodes": nodes,
            "elements": elements,
            "quantities": quantities,
            "tables": tables,
            "terms": terms.written,
        });
        if let Some(external) = &self.external {
            identity["external"] = external.identity.clone();
        }
        identity
    }
}
