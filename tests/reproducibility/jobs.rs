//! Jobs that choose their next blocks by what came out of the ones before: any number of threads, the same bytes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bmv::job::design::{self, Design};
use bmv::job::discrepancy::{self, Calibrated, Discrepancy};
use bmv::job::goal::{self, Goal};
use bmv::job::test_plan::{self, Chosen, TestPlan};
use bmv::job::{JobError, Runnable};
use bmv::runner::{Cache, Plan};
use bmv::study::Pass;

use super::toy::{node, run};

fn radiator() -> Pass {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/radiator/pass-1.json");
    let Ok(pass) = bmv::job::load(&file) else { panic!("the radiator loads") };
    pass
}

/// Everything that a job leaves in the cache.
fn stored(job: &dyn Fn() -> Result<Arc<dyn Runnable>, JobError>, threads: usize) -> BTreeMap<PathBuf, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let plan = Plan::new(vec![node("job", job().unwrap())]).unwrap();
    assert_eq!(run(&plan, &Cache::new(folder.path()), threads).failures(), 0);
    let files = walkdir::WalkDir::new(folder.path().join("objects")).into_iter().flatten();
    let files = files.filter(|entry| entry.file_type().is_file());
    let files = files.map(|entry| {
        let name = entry.path().strip_prefix(folder.path()).unwrap().to_path_buf();
        (name, std::fs::read(entry.path()).unwrap())
    });
    files.collect()
}

fn same(blocks: usize, job: &dyn Fn() -> Result<Arc<dyn Runnable>, JobError>) {
    let one = stored(job, 1);
    assert!(one.len() > blocks, "{}", one.len());
    for threads in [2, 7] {
        assert!(one == stored(job, threads), "{threads} threads");
    }
}

#[test]
#[ignore = "thorough"]
fn a_design_with_its_search_and_its_greedy_choice() {
    let pass = radiator();
    let spec = pass.jobs.iter().find_map(|job| job.spec.get::<bmv::job::design::Spec>().cloned());
    let spec = design::Spec { outer: 256, inner: 16, draws: 16, search: 5, pick: 2, ..spec.unwrap() };
    // 20 candidates twice, 5 phases of the search, 25 pairs.
    same(65, &|| {
        let job = Design::new(spec.clone(), Arc::new(pass.model.clone()), pass.priors.clone(), 7, "design")?;
        Ok(Arc::new(job))
    });
}

#[test]
fn a_goal() {
    let pass = radiator();
    let spec = pass.jobs.iter().find_map(|job| job.spec.get::<bmv::job::goal::Spec>().cloned());
    let spec = goal::Spec { samples: 256, ..spec.unwrap() };
    same(16, &|| Ok(Arc::new(Goal::new(spec.clone(), Arc::new(pass.model.clone()), pass.priors.clone(), 7, "goal")?)));
}

/// After a calibration of the solar monitor whose draws are made up.
#[test]
#[ignore = "thorough"]
fn a_discrepancy() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/sxm/pass-5.json");
    let Ok(pass) = bmv::job::load(&file) else { panic!("the solar monitor loads") };
    let spec = pass.jobs.iter().find_map(|job| job.spec.get::<discrepancy::Spec>().cloned()).unwrap();
    let draws: Vec<[f64; 3]> = (0..24)
        .map(|draw| {
            [0.38 + 0.002 * f64::from(draw % 3), 0.25 + 0.001 * f64::from(draw % 4), 0.35 + 0.001 * f64::from(draw % 5)]
        })
        .collect();
    let result = serde_json::json!({
        "converged": true, "order": ["Gh", "Gsub", "Gb"], "tuned": [["Gpre", 0.08]], "draws": {"values": draws},
    });
    let calibrated = Calibrated::from_result("made up", &result).unwrap();
    let (model, measurements) = (Arc::new(pass.model.clone()), Arc::new(pass.measurements.clone()));
    let spec = discrepancy::Spec { sensors: vec!["bracket".into(), "sdd".into()], ..spec };
    // The mean and 24 draws in one block, two sensors.
    same(3, &|| {
        let job = Discrepancy::new(spec.clone(), Arc::clone(&model), Arc::clone(&measurements), 7, "unexplained")?;
        Ok(Arc::new(job.with_calibrated(calibrated.clone())))
    });
}

/// Of the solar monitor, after the design in its committed report.
#[test]
fn a_test_plan() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let Ok(pass) = bmv::job::load(&root.join("studies/sxm/pass-1.json")) else { panic!("the solar monitor loads") };
    let spec = pass.jobs.iter().find_map(|job| job.spec.get::<test_plan::Spec>().cloned()).unwrap();
    let results = std::fs::read_to_string(root.join("reports/sxm/pass-1/results.json")).unwrap();
    let results: serde_json::Value = serde_json::from_str(&results).unwrap();
    let chosen = Chosen::from_result(&results["jobs"]["chamber"]["output"]).unwrap();
    let spec = test_plan::Spec { samples: 64, transients: 8, ..spec };
    // Three phases.
    same(3, &|| {
        let job = TestPlan::new(spec.clone(), Arc::new(pass.model.clone()), pass.priors.clone(), 7, "plan")?;
        Ok(Arc::new(job.with_chosen(chosen.clone())))
    });
}
