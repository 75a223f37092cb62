//! A small complete study in a temporary folder, for the tests of passes.

use std::path::PathBuf;

/// Two nodes on a plate, radiating to a shroud.
pub const MODEL: &str = r#"{"format": "bmv-network/1", "title": "Two nodes",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20, "range": [-40, 60]}, "Q": {"unit": "W", "nominal": 5}, "T_s": {"unit": "K", "nominal": 90}},
 "parameters": {"G": {"unit": "W/K", "nominal": 0.8, "prior": {"uniform": [0.4, 1.2]}},
                "A": {"unit": "m2", "nominal": 0.04}},
 "nodes": {"plate": {"boundary": "T_if"}, "shroud": {"boundary": "T_s"}, "box": {"capacity": 900}, "panel": {"capacity": 300}},
 "conductors": {"bolts": {"between": ["box", "plate"], "conductance": "G"}, "strap": {"between": ["box", "panel"], "conductance": 0.3}},
 "radiations": {"panel": {"between": ["panel", "shroud"], "exchange_area": "0.85 * A"}},
 "loads": {"board": {"into": "box", "power": "Q"}},
 "quantities": {"leak": {"heat": "bolts"}}}
"#;

/// A pass with a steady measurement, a requirement and a job of each kind that runs.
pub const PASS: &str = r#"{"format": "bmv-pass/1", "title": "First", "parent": null, "model": "model.json", "seed": 7,
 "parameters": {"G": {"prior": {"uniform": [0.2, 1.4]}, "because": "torque not recorded"}},
 "requirements": {"cold": {"quantity": "panel", "below": {"value": -30, "unit": "degC"}, "probability": 0.99}},
 "environments": {"hot": {"T_if": {"value": 40, "unit": "degC"}}},
 "measurements": {"balance": {"steady": {"file": "data/balance.csv",
   "sensors": {"box": {"measures": "box", "sigma": {"value": 0.25, "unit": "K"}}, "panel": {"measures": "panel"}},
   "held_out": {"phases": ["P2"]}, "ignore": {"P3": "not stabilised"}, "inputs": {"T_s": 90}}}},
 "design": {"A": {"from": 0.01, "to": 0.1}},
 "jobs": {"spread": {"propagate": {"samples": 1024}}, "match": {"compare": {}}, "size": {"conventional": {}},
          "tuned": {"calibrate": {"data": ["balance"]}}}}
"#;

/// Three phases.
pub const BALANCE: &str = "phase,T_if [degC],Q [W],box [degC],panel [degC],note\n\
P1,20,5,24.5,-20.25,\nP2,0,5,5.5,,vented\nP3,40,8,47,1,\n";

/// A transient measurement in place of the steady one.
pub const TRANSIENT: &str = r#"{"transient": {"file": "data/run.csv", "initial": {"temperatures": {"all": {"value": 20, "unit": "degC"}}},
   "hold": ["Q"], "sensors": {"box": {"measures": "box"}},
   "held_out": {"intervals": [{"from": {"value": 2, "unit": "min"}}]}, "inputs": {"T_if": {"value": 20, "unit": "degC"}, "T_s": 90}}}"#;

/// Four instants.
pub const RUN: &str = "time [s],Q [W],box [degC]\n0,5,20\n60,5,21\n120,0,21.5\n180,0,\n";

/// A study in a temporary folder.
pub struct Study {
    root: tempfile::TempDir,
}

impl Study {
    /// The complete study.
    pub fn new() -> Self {
        let study = Self { root: tempfile::tempdir().expect("a folder") };
        study
            .put("model.json", MODEL)
            .put("pass-1.json", PASS)
            .put("data/balance.csv", BALANCE)
            .put("data/run.csv", RUN);
        study
    }

    /// A folder without files.
    pub fn empty() -> Self {
        Self { root: tempfile::tempdir().expect("a folder") }
    }

    /// The study with its one measurement a transient.
    pub fn transient() -> Self {
        let study = Self::new();
        study.put("pass-1.json", transient_pass());
        study
    }

    /// Writes a file.
    pub fn put(&self, name: &str, text: impl AsRef<[u8]>) -> &Self {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().expect("a parent")).expect("made");
        std::fs::write(path, text).expect("written");
        self
    }

    /// Replaces a text that stands once in a file.
    pub fn edit(&self, name: &str, from: &str, to: &str) -> &Self {
        let text = std::fs::read_to_string(self.path(name)).expect("readable");
        assert_eq!(text.matches(from).count(), 1, "`{from}` stands once in {name}");
        self.put(name, text.replace(from, to))
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.root.path().join(name)
    }

    /// The first pass, which must load.
    pub fn load(&self) -> bmv::study::Pass {
        match bmv::job::load(&self.path("pass-1.json")) {
            Ok(pass) => pass,
            Err(diagnostics) => panic!("{}", diagnostics.render(false, 20)),
        }
    }

    /// What is said of a pass, with the folder called `study`.
    pub fn said(&self, pass: &str) -> String {
        let diagnostics = match bmv::job::load(&self.path(pass)) {
            Ok(pass) => pass.warnings,
            Err(diagnostics) => diagnostics,
        };
        let root = self.root.path().display().to_string();
        diagnostics.render(false, 20).replace(&root, "study").trim_end().to_owned()
    }
}

/// [`PASS`] with [`TRANSIENT`] for its measurement.
pub fn transient_pass() -> String {
    let start = PASS.find("{\"steady\"").expect("there");
    let end = PASS.find(",\n \"design\"").expect("there");
    format!("{}{TRANSIENT}}}{}", &PASS[..start], &PASS[end..])
}
