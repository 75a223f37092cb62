//! Blocks of all job kinds with numbers that JSON has not: what a stage gives is what the next one reads.

use std::fs;
use std::sync::Arc;

use bmv::job::ready::{Readiness, ready};
use bmv::job::{JobError, Next, NoParts, Runnable};
use ciborium::Value as Tree;
use serde_json::Value;

const MODEL: &str = r#"{
  "format": "bmv-network/1", "title": "Plate", "description": "A plate on a wall.",
  "parameters": {
    "G": {"unit": "W/K", "nominal": 0.5, "prior": {"uniform": [0.4, 0.6]}, "description": "mount", "source": "made up"},
    "E": {"unit": "1", "nominal": 0.9, "prior": {"uniform": [0.8, 1]}, "description": "efficiency", "source": "made up"},
    "A": {"unit": "1", "nominal": 2, "prior": {"fixed": 2}, "description": "a size", "source": "made up"}},
  "inputs": {"Q": {"unit": "W", "nominal": 10, "range": [0, 20]}, "T_wall": {"unit": "degC", "nominal": 20}},
  "nodes": {"plate": {"capacity": 100}, "lid": {"capacity": 20}, "wall": {"boundary": "T_wall"}},
  "conductors": {"mount": {"between": ["plate", "wall"], "conductance": "G * A"},
    "rim": {"between": ["plate", "lid"], "conductance": 0.2}, "edge": {"between": ["lid", "wall"], "conductance": 0.05}},
  "loads": {"heater": {"into": "plate", "power": "E * Q"}},
  "quantities": {"plate temperature": {"temperature": "plate"}, "lid temperature": {"temperature": "lid"}}
}"#;

const PASS: &str = r#"{
  "format": "bmv-pass/1", "title": "Plate, pass 1", "description": "", "parent": null, "model": "model.json", "seed": 1,
  "requirements": {"plate": {"quantity": "plate temperature", "below": {"value": 31, "unit": "degC"}, "probability": 0.9}},
  "measurements": {"balance": {"steady": {
    "file": "balance.csv",
    "columns": {"Q": {"header": "Q", "unit": "W"}, "plate": {"header": "plate", "unit": "degC"}, "lid": {"header": "lid", "unit": "degC"}},
    "sensors": {"plate": {"measures": "plate", "sigma": {"value": 0.2, "unit": "K"}}, "lid": {"measures": "lid", "sigma": {"value": 0.2, "unit": "K"}}}
  }}},
  "jobs": {
    "prior": {"propagate": {"samples": 64, "sweep": {"A": {"from": 1, "to": 3, "steps": 3}}}},
    "effects": {"sensitivity": {"samples": 64, "scrambles": 4, "precision": 0.001, "methods": ["local", "morris", "sobol", "derivative"], "trajectories": 8}},
    "goal": {"goal": {"samples": 1024, "design_variable": {"A": {"from": 1, "to": 3}}}},
    "margins": {"conventional": {"design_variable": {"A": {"from": 0.5, "to": 5}}, "rules": ["none", "nasa-gsfc-5k"]}},
    "test": {"design": {"conditions": {"Q": [5, 10, 20]}, "outer": 256, "inner": 64, "search": 1, "pick": 2}},
    "fit": {"calibrate": {"data": ["balance"], "chains": 2, "warmup": 100, "draws": 50}},
    "islands": {"calibrate": {"data": ["balance"], "sampler": "smc", "chains": 2, "draws": 64}},
    "delivered": {"compare": {"data": ["balance"]}},
    "missing": {"diagnose": {"data": ["balance"]}}
  }
}"#;

fn jobs() -> Vec<(String, Arc<dyn Runnable>)> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("model.json"), MODEL).unwrap();
    fs::write(folder.path().join("pass-1.json"), PASS).unwrap();
    let rows = "phase,Q,plate,lid\nP1,5,24.1,23.2\nP2,10,28.5,26.6\nP3,15,32.2,30.1\nP4,20,36.8,33.1\n";
    fs::write(folder.path().join("balance.csv"), rows).unwrap();
    let pass = match bmv::job::load(&folder.path().join("pass-1.json")) {
        Ok(pass) => pass,
        Err(diagnostics) => panic!("{}", diagnostics.render(false, 20)),
    };
    let own = ready(&pass).into_iter().map(|(name, readiness)| match readiness {
        Readiness::Ready(job) => (name, job),
        // The comparison waits for the calibration; alone it is one of the delivered state.
        _ => {
            let named = pass.jobs.iter().find(|job| job.name == name).expect("a job");
            match bmv::job::delivered(&pass, named) {
                Some(Readiness::Ready(job)) => (name, job),
                _ => panic!("{name} is not ready"),
            }
        }
    });
    own.collect()
}

fn poison(tree: &mut Tree, value: f64) {
    match tree {
        Tree::Float(own) => *own = value,
        Tree::Array(items) => items.iter_mut().for_each(|item| poison(item, value)),
        Tree::Map(entries) => entries.iter_mut().for_each(|(_, item)| poison(item, value)),
        _ => {}
    }
}

/// A block with every number replaced.
fn poisoned(bytes: &[u8], value: f64) -> Vec<u8> {
    if bytes.is_empty() {
        return Vec::new();
    }
    let mut rest = bytes;
    let mut tree: Tree = ciborium::from_reader(&mut rest).expect("a block is CBOR, then numbers");
    assert_eq!(rest.len() % 8, 0);
    poison(&mut tree, value);
    let mut out = Vec::new();
    ciborium::into_writer(&tree, &mut out).unwrap();
    out.extend((0..rest.len() / 8).flat_map(|_| value.to_le_bytes()));
    out
}

#[test]
#[ignore = "thorough"]
fn every_stage_of_every_job_kind_reads_what_the_one_before_may_give() {
    let mut stages = 0;
    for (name, job) in jobs() {
        let mut next = job.begin().unwrap();
        while let Next::Stage(stage) = next {
            let block = |index| job.block(&stage, index, &NoParts).unwrap();
            let outputs: Vec<Vec<u8>> = (0..stage.inputs.len()).map(block).collect();
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let bad: Vec<Vec<u8>> = outputs.iter().map(|output| poisoned(output, value)).collect();
                // Nothing sensible can come of it, but it is read, and what is written next is read back in debug builds.
                let unreadable = match job.reduce(&stage, bad.clone()) {
                    Err(JobError::Failed(reason)) => reason.contains("read back"),
                    Err(JobError::Unreadable { .. }) => true,
                    Ok(_) => false,
                };
                let name = format!("{name}, stage {}, {value}", stage.name);
                assert!(!unreadable, "{name}: {:?}", job.reduce(&stage, bad));
                stages += 1;
            }
            next = job.reduce(&stage, outputs).unwrap();
        }
        let Next::Done(result) = next else { unreachable!() };
        assert!(matches!(result.json, Value::Object(_)), "{name}");
    }
    assert!(stages > 40, "{stages}");
}
