//! Verbs on studies: what an engineer reads, and the exit statuses.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

/// A plate on a wall, measured in two phases; the second is held out. The model's conductance is 0.5 W/K, so 10 W
/// give 20 K above the wall; the readings are 3 K above that.
const MODEL: &str = r#"{
  "format": "bmv-network/1", "title": "Plate", "description": "A plate on a wall.",
  "parameters": {"G": {"unit": "W/K", "nominal": 0.5, "prior": {"uniform": [0.4, 0.6]}, "description": "mount", "source": "made up"}},
  "inputs": {"Q": {"unit": "W", "nominal": 10}, "T_wall": {"unit": "degC", "nominal": 20}},
  "nodes": {"plate": {"capacity": 100}, "wall": {"boundary": "T_wall"}},
  "conductors": {"mount": {"between": ["plate", "wall"], "conductance": "G"}},
  "loads": {"heater": {"into": "plate", "power": "Q"}},
  "quantities": {"plate temperature": {"temperature": "plate"}}
}"#;

const PASS: &str = r#"{
  "format": "bmv-pass/1", "title": "Plate, pass 1", "description": "", "parent": null, "model": "model.json", "seed": 1,
  "requirements": {"plate": {"quantity": "plate temperature", "below": {"value": 41, "unit": "degC"}, "probability": 0.9}},
  "measurements": {"balance": {"steady": {
    "file": "data/balance.csv",
    "columns": {"Q": {"header": "Q", "unit": "W"}, "T_wall": {"header": "wall", "unit": "degC"}, "plate": {"header": "plate", "unit": "degC"}},
    "sensors": {"plate": {"measures": "plate", "sigma": {"value": 0.5, "unit": "K"}}},
    "held_out": {"phases": ["P2"]}
  }}},
  "jobs": {
    "prior": {"propagate": {"samples": 64}},
    "delivered": {"compare": {"data": ["balance"]}}
  }
}"#;

pub fn bmv(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bmv"));
    command.current_dir(folder).env_remove("BMV_DATA").args(arguments).output().expect("the program starts")
}

pub fn code(output: &Output) -> i32 {
    output.status.code().expect("ended by itself")
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// Standard output of a command that succeeds.
pub fn printed(folder: &Path, arguments: &[&str]) -> String {
    let output = bmv(folder, arguments);
    assert_eq!(code(&output), 0, "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// A folder with the study `plate`.
pub fn plate() -> TempDir {
    let root = tempfile::tempdir().unwrap();
    let study = root.path().join("plate");
    fs::create_dir_all(study.join("data")).unwrap();
    fs::write(study.join("model.json"), MODEL).unwrap();
    fs::write(study.join("pass-1.json"), PASS).unwrap();
    fs::write(study.join("data/balance.csv"), "phase,Q,wall,plate\nP1,10,20,43\nP2,5,20,33\n").unwrap();
    root
}

#[test]
fn run_says_what_came_out_and_where_to_look() {
    let root = plate();
    insta::assert_snapshot!(printed(root.path(), &["run", "plate"]), @r#"
    plate/pass-1.json
      prior: P(plate) = 0.609, required 0.900: not met
      delivered: RMSE 3.00 K as delivered; RMSE on held-out readings 3.00 K as delivered; 2 of 2 criteria kept as delivered (Each reading within 3 K of the model)
        as delivered, plate: the model is too cold; measured minus predicted is +3.00 K on average, RMSE 3.00 K (3.00 K on the readings for fitting, 3.00 K on those held out), at worst +3.00 K in phase P2.
      look at it: bmv show plate/pass-1.json, or bmv report plate/pass-1.json
    "#);
}

#[test]
fn run_has_a_line_for_a_pass_of_which_nothing_ran() {
    let root = plate();
    printed(root.path(), &["run", "plate"]);
    let whole = printed(root.path(), &["run", "plate"]);
    assert!(whole.contains("P(plate) = 0.609"), "nothing ran, and what is known is shown: {whole}");
    fs::write(root.path().join("plate/pass-2.json"), PASS.replace("\"samples\": 64", "\"samples\": 128")).unwrap();
    let said = printed(root.path(), &["run", "plate"]);
    let line = "plate/pass-1.json: unchanged, 2 jobs in the cache (bmv show plate/pass-1.json)\n";
    assert!(said.starts_with(line) && said.matches("P(plate)").count() == 1, "{said}");
    assert!(said.contains("\nplate/pass-2.json\n  prior: P(plate)"), "{said}");
}

#[test]
fn a_comparison_says_of_which_sensors_little_was_asked() {
    let root = plate();
    let said = |sensor: &str| {
        let pass = PASS.replace(r#", "sigma": {"value": 0.5, "unit": "K"}}"#, sensor);
        assert_ne!(pass, PASS);
        fs::write(root.path().join("plate/pass-1.json"), pass).unwrap();
        printed(root.path(), &["compare", "plate/pass-1.json"]).split_whitespace().collect::<Vec<&str>>().join(" ")
    };
    let nowhere = "The comparison finds no place where the model fails.";
    let unstated = said("}");
    assert!(
        unstated.contains(
            "No deviation exceeds a limit that is stated; the largest RMSE is 3.0 K (`plate`). Of `plate` that means no reading \
             more than 3 K from its prediction: their noise"
        ) && !unstated.contains(nowhere),
        "{unstated}"
    );
    let stated = said(r#", "sigma": {"value": 5, "unit": "K"}}"#);
    assert!(stated.contains(nowhere) && !stated.contains("that means"), "{stated}");
}

#[test]
fn plan_names_inputs_that_the_model_does_not_use() {
    let root = plate();
    let said = |model: &str| {
        fs::write(root.path().join("plate/model.json"), model).unwrap();
        let output = bmv(root.path(), &["plan", "plate"]);
        assert_eq!(code(&output), 0);
        text(&output.stderr)
    };
    assert!(!said(MODEL).contains("no sensor reading depends"), "all are used");
    let with_fan = MODEL.replace(r#""inputs": {"#, r#""inputs": {"fan": {"unit": "1", "nominal": 0}, "#);
    let unused = said(&with_fan);
    let note = "note: plate/pass-1.json: no sensor reading depends on `fan` in this model; a diagnosis looks there too for what is missing\n";
    assert!(unused.contains(note), "{unused}");
}

#[test]
fn sensors_that_fail_alike_are_one_sentence_after_the_worst() {
    let root = plate();
    let names = ["plate", "a", "b", "c", "d", "e"];
    // Of 43 and 33 degC predicted 40 and 30; `d` errs less than half as much, `e` the other way.
    let errors = [3.0, 2.5, 2.0, 2.8, 1.2, -2.9];
    let list = |of: &dyn Fn(&str) -> String| names.map(of).join(", ");
    let columns = list(&|name| format!(r#""{name}": {{"header": "{name}", "unit": "degC"}}"#));
    let sensors = list(&|name| format!(r#""{name}": {{"measures": "plate", "sigma": {{"value": 0.5, "unit": "K"}}}}"#));
    let pass = PASS
        .replace(r#""plate": {"header": "plate", "unit": "degC"}"#, &columns)
        .replace(r#""plate": {"measures": "plate", "sigma": {"value": 0.5, "unit": "K"}}"#, &sensors);
    fs::write(root.path().join("plate/pass-1.json"), pass).unwrap();
    let row = |base: f64| errors.map(|error| (base + error).to_string()).join(",");
    let rows = format!("phase,Q,wall,{}\nP1,10,20,{}\nP2,5,20,{}\n", names.join(","), row(40.0), row(30.0));
    fs::write(root.path().join("plate/data/balance.csv"), rows).unwrap();
    let said =
        printed(root.path(), &["compare", "plate/pass-1.json"]).split_whitespace().collect::<Vec<&str>>().join(" ");
    let alike = "`c`, `a` and `b` fail like `plate`: the model is too cold; measured minus predicted is +2.00 to +2.80 K on \
                 average, RMSE 2.00 to 2.80 K.";
    assert!(
        said.contains(&format!("in phase P2. - {alike} - e: the model is too hot;")) && said.contains("- d: the model"),
        "{said}"
    );
    assert!(!said.contains("- a:") && !said.contains("- c:"), "{said}");
}

#[test]
fn compare_reads_from_the_verdict_to_the_heat_balance() {
    let root = plate();
    insta::assert_snapshot!(printed(root.path(), &["compare", "plate/pass-1.json"]), @r#"
    Model against measurements
    ==========================

    Parameters: nominal, the model as delivered. Deviations are measured minus predicted: positive where
    the model is too low.

    Where the model fails, worst first:

    - plate: the model is too cold; measured minus predicted is +3.00 K on average, RMSE 3.00 K (3.00 K
      on the readings for fitting, 3.00 K on those held out), at worst +3.00 K in phase P2.

    Deviations by sensor. An RMSE above the 95 % range that the sensor's noise alone would give is
    marked as a failure, one below it as worth a look.
    Sensor  Readings  Number   Mean   Standard  RMSE        RMSE of  Largest  Within  Unit
                                     deviation          noise alone              3 K
    ------  --------  ------  -----  ---------  -----  ------------  -------  ------  ----
    plate   for fits       1  +3.00       0.00  3.00!  0.02 to 1.12     3.00   100 %  K
    plate   held out       1  +3.00       0.00  3.00!  0.02 to 1.12     3.00   100 %  K
    (! not kept)

    Deviations by phase or stretch of time, over all sensors, K.
    Phase  Readings   Mean   Standard  RMSE  Worst sensor     At
                            deviation                      worst
    -----  --------  -----  ---------  ----  ------------  -----
    P1     for fits  +3.00       0.00  3.00  plate         +3.00
    P2     held out  +3.00       0.00  3.00  plate         +3.00

    Criteria: Each reading within 3 K of the model. Source: MIL-HDBK-340, 8.7.3: larger deviations need
    an explanation or a change of the model; stabilisation by SMC-S-016 (2014): less than 1 K in 5 h
    (only an excerpt could be opened)
    Criterion                              Value  Limit  Outcome
    -------------------------------------  -----  -----  -------
    share of readings within 3 K            1.00   1.00  kept
    share of held-out readings within 3 K   1.00   1.00  kept

    Heat balance of the model.
    Phase  Sources      into  Stored  Imbalance
               [W]  wall [W]     [W]        [W]
    -----  -------  --------  ------  ---------
    P1        10.0      10.0       0          0
    P2        5.00      5.00       0          0
    "#);
    let with_rows = printed(root.path(), &["compare", "plate", "--rows", "all"]);
    assert!(with_rows.contains("Readings\n========\n"), "{with_rows}");
}

#[test]
fn show_prints_one_job_or_all_with_the_summary() {
    let root = plate();
    let one = printed(root.path(), &["show", "plate/pass-1.json", "prior", "--run"]);
    assert!(one.starts_with("Propagation of uncertainty\n") && !one.contains("Model against measurements"), "{one}");
    let all = printed(root.path(), &["show", "plate", "--run"]);
    assert!(all.starts_with("Summary\n=======\n") && all.contains("Model against measurements"), "{all}");
    assert!(all.lines().all(|line| line.chars().count() <= 100 && !line.contains('\u{1b}')), "{all}");
    let coloured = printed(root.path(), &["show", "plate", "--color", "always"]);
    assert!(coloured.contains("\u{1b}[1mSummary\u{1b}[0m"), "{coloured}");
    let wrong = bmv(root.path(), &["show", "plate", "later"]);
    assert_eq!(code(&wrong), 2);
    let said = text(&wrong.stderr);
    assert!(said.contains("`plate/pass-1.json` has no job `later`; its jobs are `prior`, `delivered`"), "{said}");
}

#[test]
fn report_prints_where_it_is_and_verify_sees_a_change() {
    let root = plate();
    assert_eq!(printed(root.path(), &["report", "plate"]), "reports/plate/pass-1/report.html\n");
    assert!(root.path().join("reports/plate/pass-1/report.html").is_file());
    let intact = printed(root.path(), &["verify", "reports/plate/pass-1"]);
    assert!(intact.ends_with("the report is as it was written\n"), "{intact}");
    fs::write(root.path().join("plate/data/balance.csv"), "phase,Q,wall,plate\n").unwrap();
    assert_eq!(code(&bmv(root.path(), &["verify", "reports/plate/pass-1"])), 1);
}

#[test]
fn plan_names_what_is_cached() {
    let root = plate();
    let before = printed(root.path(), &["plan", "plate"]);
    assert!(before.ends_with("2 of 2 jobs to run; how long they take is not known yet\n"), "{before}");
    printed(root.path(), &["run", "plate", "--job", "compare"]);
    let after = printed(root.path(), &["plan", "plate"]);
    assert!(after.contains("1 of 2 jobs to run"), "{after}");
    printed(root.path(), &["run", "plate"]);
    assert!(printed(root.path(), &["plan", "plate"]).ends_with("\n0 of 2 jobs to run\n"));
    let why = printed(root.path(), &["cache", "why", "plate/pass-1.json:prior", "plate"]);
    assert!(serde_json::from_str::<serde_json::Value>(&why).is_ok(), "{why}");
}

#[test]
fn diff_names_the_changed_setting() {
    let root = plate();
    fs::write(root.path().join("plate/pass-2.json"), PASS.replace("\"samples\": 64", "\"samples\": 128")).unwrap();
    let said = printed(root.path(), &["diff", "plate/pass-1.json", "plate/pass-2.json", "--run"]);
    let row =
        said.lines().find(|line| line.starts_with("jobs.prior.propagate.samples")).unwrap_or_else(|| panic!("{said}"));
    let cells: Vec<&str> = row.split_whitespace().collect();
    assert_eq!(cells[1..3], ["64", "128"], "{said}");
    assert!(cells[3].starts_with("plate/pass-2.json:"), "{said}");
    assert!(said.contains("The same in both: delivered."), "{said}");
    // With an effect the model is no longer the one that was delivered.
    let adopted = PASS.replace("\"parent\": null", "\"parent\": \"pass-1.json\", \"adopt\": {\"leak\": {\"effect\": {\"heat-load\": {\"where\": \"plate\", \"parameters\": {\"power\": {\"nominal\": 1, \"unit\": \"W\", \"prior\": {\"uniform\": [0, 2]}}}}}, \"because\": \"a test\"}}");
    fs::write(root.path().join("plate/pass-3.json"), adopted).unwrap();
    let said = printed(root.path(), &["diff", "plate/pass-1.json", "plate/pass-3.json", "--run"]);
    let joined = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(joined.contains("RMSE untuned, readings for fitting"), "{said}");
    let states = "Untuned: the model as delivered before, with adopted effects at their nominal sizes after.";
    assert!(joined.contains(states), "{said}");
    let several = bmv(root.path(), &["compare", "plate"]);
    assert_eq!(code(&several), 2);
    assert!(text(&several.stderr).contains("name one: plate/pass-1.json, plate/pass-2.json"));
}

#[test]
fn wrong_files_end_with_two_before_anything_runs() {
    let root = plate();
    let pass = root.path().join("plate/pass-1.json");
    for (text_of_pass, expected) in [
        ("{{{".to_owned(), "json-syntax"),
        ("[".repeat(100_000), "json-depth"),
        (PASS.replace("\"parent\": null", "\"parent\": \"pass-1.json\""), "parent-cycle"),
        (PASS.replace("model.json", "../model.json"), "path-refused"),
        (PASS.replace("\"prior\"", "\"pri\\u001bor\""), "invalid-name"),
    ] {
        fs::write(&pass, text_of_pass).unwrap();
        for verb in ["run", "show", "plan", "report"] {
            let output = bmv(root.path(), &[verb, "plate"]);
            let said = text(&output.stderr);
            assert_eq!(code(&output), 2, "{verb}: {said}");
            assert!(said.contains(expected) && !said.contains('\u{1b}') && output.stdout.is_empty(), "{verb}: {said}");
        }
    }
    assert!(!root.path().join("reports").exists());
}

#[test]
fn the_studies_that_init_makes_are_ready_or_say_how_to_bring_their_data() {
    let root = tempfile::tempdir().unwrap();
    let made = printed(root.path(), &["init", "new"]);
    assert_eq!(made, "made new; now try\nbmv run new\nbmv report new\n");
    // Its files are those of the case study, whose results the committed reports hold.
    let planned = printed(root.path(), &["plan", "new"]);
    for job in ["prior", "effects", "goal", "margins", "coupon"] {
        assert!(planned.contains(&format!("new/pass-1.json:{job} ")), "{planned}");
    }
    let made = printed(root.path(), &["init", "bench", "--from", "tclab"]);
    assert_eq!(made, "made bench; now try\nbmv data get bench\nbmv run bench\nbmv report bench\n");
    assert_eq!(code(&bmv(root.path(), &["data", "verify", "bench"])), 1);
    let waiting = bmv(root.path(), &["compare", "bench"]);
    assert_eq!(code(&waiting), 2, "there is nothing to compare with");
    assert!(text(&waiting.stderr).contains("bring them with `bmv data get bench`"));
    assert_eq!(code(&bmv(root.path(), &["run", "bench"])), 0, "a run goes on without the job that waits");
}
