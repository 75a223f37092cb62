//! What cannot be in the baseline model: conductances, exchange areas and heat capacities below 0, and nodes that nothing
//! leads to.
//!
//! Most constants are refused where they are read. Expressions are tried at all values that are known before anything is solved:
//! nominal ones, environments, measured inputs (errors), and one by one the ends of priors and ranges (warnings). What
//! depends on temperatures is tried at those of the boundaries. Effects that a diagnosis tries are no part of this: there
//! either sign tells something.

use crate::document::{Diagnostic, Place, code};
use crate::expression::{ExprId, Symbol};
use crate::math::sort::sort_by;
use crate::measurement::{Measurement, Rows};
use crate::random::Distribution;
use crate::study::pass::PassForm;
use crate::study::requirement::Environment;
use crate::thermal::element::SignConstraint;
use crate::thermal::{Model, NodeKind};

use super::scope::Scope;

/// Where a prior has no end, this quantile and its counterpart stand for the ends.
const TAIL: f64 = 1e-3;
/// Where no boundary has a temperature, K.
const ROOM_K: f64 = 293.15;
/// Most evaluations for measured inputs: of a very long record the first rows are tried.
const MOST_EVALUATIONS: usize = 1_000_000;

/// A value that has a sign, of a node or element.
struct Signed {
    /// `conductor`, `node`, ...
    kind: &'static str,
    name: String,
    constraint: SignConstraint,
}

/// Checks the model with all that the pass adds to it.
pub(super) fn check(
    scope: &mut Scope,
    form: &PassForm,
    priors: &[Distribution],
    environments: &[Environment],
    measurements: &[Measurement],
) {
    if scope.diagnostics.has_errors() {
        // Values may be missing.
        return;
    }
    let mut findings = unconnected(scope, form);
    let tried = Tried::new(&scope.resolved.model, priors, environments, measurements);
    let mut left = MOST_EVALUATIONS;
    for signed in signed(&scope.resolved.model) {
        let Some((fault, is_error)) = tried.fault(&signed, &mut left) else { continue };
        let place = place(scope, form, signed.kind, &signed.name, signed.constraint.what);
        let (name, kind, what, unit) = (&signed.name, signed.kind, signed.constraint.what, signed.constraint.unit);
        let message = format!("the {what} of the {kind} `{name}` is {} {unit} {}", fault.value, fault.at);
        let expected = if signed.constraint.above_zero { "above 0" } else { "0 or more" };
        findings.push(if is_error {
            Diagnostic::error(&code::OUT_OF_RANGE, &place, message).expected(expected)
        } else {
            Diagnostic::warning(&code::POSSIBLY_NEGATIVE, &place, message).expected(expected)
        });
    }
    findings.into_iter().for_each(|diagnostic| scope.diagnostics.push(diagnostic));
}

/// All values with a sign.
fn signed(model: &Model) -> Vec<Signed> {
    let of_nodes = model.nodes.iter().filter_map(|node| {
        let constraint = match node.kind {
            NodeKind::Diffusion { capacity } => {
                SignConstraint { what: "heat capacity", unit: "J/K", value: capacity, above_zero: true }
            }
            NodeKind::Boundary { temperature } => {
                SignConstraint { what: "temperature", unit: "K", value: temperature, above_zero: false }
            }
            NodeKind::Arithmetic => return None,
        };
        Some(Signed { kind: "node", name: node.name.clone(), constraint })
    });
    let of_elements = model.elements.iter().flat_map(|element| {
        let of = |constraint| Signed { kind: element.physics().kind(), name: element.name.clone(), constraint };
        element.physics().sign_constraints().into_iter().map(of)
    });
    of_nodes.chain(of_elements).collect()
}

/// Where a value stands in the files; of an adopted effect the entry of the pass.
fn place(scope: &Scope, form: &PassForm, kind: &'static str, name: &str, what: &'static str) -> Place {
    let below = |entry: &str| name.strip_prefix(entry).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
    let adopted = || form.adopt.iter().find(|entry| below(&entry.name)).map(|entry| entry.name_place.clone());
    let noted_place = scope.resolved.places.find(kind, name, what).cloned();
    noted_place.or_else(adopted).unwrap_or_else(|| scope.resolved.places.file.clone())
}

/// Nodes whose temperature nothing determines, each as an error.
fn unconnected(scope: &Scope, form: &PassForm) -> Vec<Diagnostic> {
    let model = &scope.resolved.model;
    let (mut joined, mut heated) = (vec![false; model.nodes.len()], vec![false; model.nodes.len()]);
    for element in &model.elements {
        let physics = element.physics();
        physics.joined().iter().for_each(|&node| joined[node] = true);
        physics.heated().into_iter().for_each(|node| heated[node] = true);
    }
    let lost = model.nodes.iter().enumerate().filter(|(index, node)| match node.kind {
        // A given temperature needs no balance.
        NodeKind::Boundary { .. } => false,
        NodeKind::Diffusion { .. } | NodeKind::Arithmetic => !joined[*index] && !heated[*index],
    });
    lost.map(|(_, node)| {
        let message = format!("nothing leads to the node `{}`: its temperature is undetermined", node.name);
        Diagnostic::error(&code::UNCONNECTED, &place(scope, form, "node", &node.name, ""), message)
            .expected("a conductor, radiation, flow or cooler to another node")
            .help("connect the node, or leave it out")
    })
    .collect()
}

/// A value with the wrong sign.
struct Fault {
    value: f64,
    /// Where it has it: `at the nominal values`.
    at: String,
}

/// The values at which expressions are tried.
struct Tried<'a> {
    model: &'a Model,
    priors: &'a [Distribution],
    environments: &'a [Environment],
    measurements: &'a [Measurement],
    parameters: Vec<f64>,
    inputs: Vec<f64>,
    /// Temperatures that all nodes are given together, K.
    temperatures: Vec<f64>,
}

impl<'a> Tried<'a> {
    fn new(
        model: &'a Model,
        priors: &'a [Distribution],
        environments: &'a [Environment],
        measurements: &'a [Measurement],
    ) -> Self {
        let mut tried = Self {
            model,
            priors,
            environments,
            measurements,
            parameters: model.parameters.iter().map(|parameter| parameter.nominal).collect(),
            inputs: model.inputs.iter().map(|input| input.nominal).collect(),
            temperatures: Vec::new(),
        };
        let boundaries = model.nodes.iter().filter_map(|node| match node.kind {
            NodeKind::Boundary { temperature } => Some(tried.value(temperature, &tried.parameters, &tried.inputs, 0.0)),
            NodeKind::Diffusion { .. } | NodeKind::Arithmetic => None,
        });
        let mut temperatures: Vec<f64> =
            boundaries.filter(|temperature_k| temperature_k.is_finite() && *temperature_k > 0.0).collect();
        sort_by(&mut temperatures, f64::total_cmp);
        temperatures.dedup();
        tried.temperatures = match temperatures.as_slice() {
            [] => vec![ROOM_K],
            [one] => vec![*one],
            [lowest, .., highest] => vec![*lowest, *highest],
        };
        tried
    }

    fn value(&self, value: ExprId, parameters: &[f64], inputs: &[f64], temperature_k: f64) -> f64 {
        let of = |values: &[f64], index: u32| values.get(index as usize).copied().unwrap_or(f64::NAN);
        self.model.graph.evaluate(value, &|symbol| match symbol {
            Symbol::Parameter(index) => of(parameters, index),
            Symbol::Input(index) => of(inputs, index),
            Symbol::Node(_) => temperature_k,
            Symbol::Time | Symbol::Mode(_) | Symbol::Local(_) | Symbol::Output(_) => 0.0,
        })
    }

    /// The value at the first of the temperatures, and that temperature, where its sign is wrong at all of them: a law of
    /// temperature that fails at one end only need not meet it.
    fn wrong(&self, signed: &Signed, parameters: &[f64], inputs: &[f64], depends: bool) -> Option<(f64, f64)> {
        let temperatures = if depends { self.temperatures.as_slice() } else { &self.temperatures[..1] };
        let mut tried = temperatures.iter().map(|temperature_k| {
            (*temperature_k, self.value(signed.constraint.value, parameters, inputs, *temperature_k))
        });
        let first = tried.next().filter(|(_, value)| signed.constraint.is_broken_by(*value))?;
        tried.all(|(_, value)| signed.constraint.is_broken_by(value)).then_some(first)
    }

    /// The first fault of a value, and whether it is an error.
    fn fault(&self, signed: &Signed, left: &mut usize) -> Option<(Fault, bool)> {
        let symbols = self.model.graph.symbols(signed.constraint.value);
        let depends = symbols.iter().any(|symbol| matches!(symbol, Symbol::Node(_)));
        let with = |at: &str, (temperature_k, value): (f64, f64), is_certain: bool| {
            let hot = if depends { format!(" and {temperature_k} K") } else { String::new() };
            (Fault { value, at: format!("{at}{hot}") }, is_certain)
        };
        if let Some(wrong) = self.wrong(signed, &self.parameters, &self.inputs, depends) {
            return Some(with("at the nominal values", wrong, true));
        }
        if symbols.iter().any(|symbol| matches!(symbol, Symbol::Input(_)))
            && let Some((at, wrong)) = self.in_states(signed, depends, left)
        {
            return Some(with(&at, wrong, true));
        }
        symbols.iter().find_map(|symbol| {
            let (name, ends) = match *symbol {
                Symbol::Parameter(index) => {
                    let prior = self.priors.get(index as usize).filter(|prior| !prior.is_fixed())?;
                    (&self.model.parameters.get(index as usize)?.name, ends(prior))
                }
                Symbol::Input(index) => {
                    let input = self.model.inputs.get(index as usize)?;
                    (&input.name, input.range?)
                }
                Symbol::Time | Symbol::Node(_) | Symbol::Mode(_) | Symbol::Local(_) | Symbol::Output(_) => return None,
            };
            ends.into_iter().find_map(|end| {
                let (mut parameters, mut inputs) = (self.parameters.clone(), self.inputs.clone());
                match *symbol {
                    Symbol::Parameter(index) => parameters[index as usize] = end,
                    Symbol::Input(index) => inputs[index as usize] = end,
                    Symbol::Time | Symbol::Node(_) | Symbol::Mode(_) | Symbol::Local(_) | Symbol::Output(_) => {}
                }
                // The end itself of a prior above 0 never occurs.
                let wrong = self.wrong(signed, &parameters, &inputs, depends).filter(|(_, value)| *value < 0.0)?;
                Some(with(&format!("where `{name}` is {end} (SI), which it may be"), wrong, false))
            })
        })
    }

    /// The first environment, phase or row whose inputs give the wrong sign.
    fn in_states(&self, signed: &Signed, depends: bool, left: &mut usize) -> Option<(String, (f64, f64))> {
        let mut wrong = |inputs: &[f64]| {
            *left = left.checked_sub(1)?;
            self.wrong(signed, &self.parameters, inputs, depends)
        };
        for environment in self.environments {
            if let Some(wrong_value) = wrong(&environment.inputs) {
                return Some((format!("in the environment `{}`", environment.name), wrong_value));
            }
        }
        for measurement in self.measurements {
            match &measurement.rows {
                Rows::Steady(phases) => {
                    for phase in phases.iter().filter(|phase| phase.ignored.is_none()) {
                        if let Some(wrong_value) = wrong(&phase.inputs) {
                            return Some((
                                format!("in the phase `{}` of `{}`", phase.name, measurement.name),
                                wrong_value,
                            ));
                        }
                    }
                }
                Rows::Transient { inputs, .. } => {
                    let mut row = inputs.base.clone();
                    for (position, time_s) in inputs.times_s.iter().enumerate() {
                        for column in &inputs.columns {
                            row[column.input] = column.values[position];
                        }
                        if let Some(wrong_value) = wrong(&row) {
                            return Some((format!("at {time_s} s of `{}`", measurement.name), wrong_value));
                        }
                    }
                }
            }
        }
        None
    }
}

/// The ends of a prior.
fn ends(prior: &Distribution) -> [f64; 2] {
    let (lower, upper) = prior.support();
    let end = |bound: f64, share: f64| if bound.is_finite() { bound } else { prior.quantile(share) };
    [end(lower, TAIL), end(upper, 1.0 - TAIL)]
}
