//! A model of a server that speaks the UM-Bridge protocol (Seelinger et al. 2023, J. Open Source Software 8, 4748).

use serde_json::{Value, json};

/// A model of a server.
#[derive(Clone, Debug, PartialEq)]
pub struct UmBridge {
    /// Host and port, as in `127.0.0.1:4242`.
    pub host: String,
    /// What stands before `/Evaluate` in its paths; empty, or beginning with `/`.
    pub path: String,
    /// The model's name there.
    pub name: String,
    /// What stands for the model in the keys of jobs.
    pub version: String,
    /// Places among what is given, by vector.
    pub inputs: Vec<Vec<usize>>,
    /// Vector and place of each output.
    pub outputs: Vec<[usize; 2]>,
    /// Its configuration.
    pub config: Value,
}

impl UmBridge {
    /// What of it decides a result.
    pub(super) fn identity(&self) -> Value {
        json!({
            "name": self.name,
            "version": self.version,
            "inputs": self.inputs,
            "outputs": self.outputs,
            "config": self.config,
        })
    }
}
