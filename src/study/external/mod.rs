//! Models that are not networks: a program or a server gives outputs for parameters and inputs. What the study says of them,
//! with everything looked up; who runs them is lent from outside.

mod command;
mod form;
mod resolve;
mod umbridge;

use std::sync::Arc;

use serde_json::{Value, json};

use crate::document::canonical;
use crate::document::hash::sha256_hex;
use crate::expression::Unit;
use crate::thermal::{Derivatives, Evaluator};

pub use command::{Command, Input, Place, Program, Separator, Table, Template};
pub use form::{CommandForm, UmBridgeForm};
pub use resolve::{Asked, Sources, command, umbridge};
pub use umbridge::UmBridge;

/// A parameter or input that is given to a model outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Given {
    /// Name.
    pub name: String,
    /// Unit in which its number is given; `None`: SI.
    pub unit: Option<Unit>,
}

/// An output of a model outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Name.
    pub name: String,
    /// Unit as written.
    pub unit: Unit,
}

/// How calls are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calls {
    /// How long one may take, s.
    pub timeout_s: f64,
    /// How often one that failed is tried again.
    pub retries: u64,
    /// How many at a time; `None`: as many as the run has threads.
    pub at_once: Option<u64>,
}

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub enum How {
    /// A program.
    Command(Command),
    /// A server.
    UmBridge(UmBridge),
}

/// A model outside the program.
#[derive(Clone, Debug, PartialEq)]
pub struct External {
    /// Where the study says so: file, line and column.
    pub place: String,
    /// All parameters, then all inputs, in the model's order.
    pub given: Vec<Given>,
    /// How many of these are parameters.
    pub parameters: usize,
    /// Its outputs.
    pub outputs: Vec<Output>,
    /// Whether numbers are exchanged in SI units.
    pub is_si: bool,
    /// Steps of finite differences by what is given, SI.
    pub steps: Vec<f64>,
    /// Where slopes come from.
    pub derivatives: Derivatives,
    /// How calls are made.
    pub calls: Calls,
    /// What is asked.
    pub how: How,
}

/// Lends what asks models outside.
pub trait Lender {
    /// Who asks this one.
    fn lend(&self, external: &Arc<External>) -> Arc<dyn Evaluator>;
}

impl External {
    /// What of it decides what it answers: how it is asked, and for what.
    pub fn answered_by(&self) -> Value {
        let given: Vec<Value> =
            self.given.iter().map(|given| json!([given.name, given.unit.as_ref().map(|unit| &unit.text)])).collect();
        let outputs: Vec<Value> = self.outputs.iter().map(|output| json!([output.name, output.unit.text])).collect();
        json!({
            "how": match &self.how {
                How::Command(command) => command.identity(),
                How::UmBridge(model) => model.identity(),
            },
            "given": given,
            "outputs": outputs,
            "units": if self.is_si { "si" } else { "as-written" },
        })
    }

    /// What of it decides a result. How many calls are made at a time, and at which address a server is, does not.
    pub fn identity(&self) -> Value {
        let mut identity = self.answered_by();
        if let Some(fields) = identity.as_object_mut() {
            fields.insert("steps".to_owned(), json!(self.steps));
            fields.insert("timeout_s".to_owned(), json!(self.calls.timeout_s));
            fields.insert("retries".to_owned(), json!(self.calls.retries));
            if self.derivatives == Derivatives::Served {
                fields.insert("derivatives".to_owned(), json!("served"));
            }
        }
        identity
    }

    /// The change in SI of an output (by its place) whose number changes by so much.
    pub fn slope_of_output(&self, place: usize, change: f64) -> f64 {
        match self.outputs.get(place) {
            Some(output) if !self.is_si => output.unit.difference_to_si(change),
            _ => change,
        }
    }

    /// The slope by a value in SI of what has this slope by the number that is given for it (by its place).
    pub fn slope_by_given(&self, place: usize, slope: f64) -> f64 {
        match self.given.get(place).and_then(|given| given.unit.as_ref()) {
            Some(unit) if !self.is_si => unit.difference_from_si(slope),
            _ => slope,
        }
    }

    /// What it is, for people.
    pub fn description(&self) -> String {
        let names: Vec<String> = self.given.iter().map(|given| given.name.clone()).collect();
        match &self.how {
            How::Command(command) => {
                let version = command.version.as_ref().map_or_else(String::new, |text| format!(", version {text}"));
                format!("the command `{}`{version}", command.shown(&names))
            }
            How::UmBridge(model) => {
                format!("the model `{}` of a UM-Bridge server, version {}", model.name, model.version)
            }
        }
    }

    /// SHA-256 of [`External::identity`], which a user's list of allowed commands names.
    pub fn fingerprint(&self) -> String {
        let identity = self.identity();
        // Numbers of a file that was read are finite, so there is always a canonical text.
        sha256_hex(canonical::canonical(&identity).unwrap_or_else(|_| identity.to_string()).as_bytes())
    }

    /// The number that is given for a value in SI.
    pub fn shown(&self, place: usize, si: f64) -> f64 {
        match self.given.get(place).and_then(|given| given.unit.as_ref()) {
            Some(unit) if !self.is_si => unit.from_si(si),
            _ => si,
        }
    }

    /// The value in SI of a number that was given back.
    pub fn to_si(&self, place: usize, number: f64) -> f64 {
        match self.outputs.get(place) {
            Some(output) if !self.is_si => output.unit.to_si(number),
            _ => number,
        }
    }
}
