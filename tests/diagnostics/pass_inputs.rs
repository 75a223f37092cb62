//! What a measurement says of the inputs, and starts that its first readings contradict.

use bmv::measurement::{Initial, Rows, Uncertain};
use bmv::random::Distribution;

use crate::diagnostics::pass_study::Study;

/// A steady study that does not say what the shroud's temperature was.
fn silent() -> Study {
    let study = Study::new();
    study.edit("pass-1.json", r#", "inputs": {"T_s": 90}"#, "");
    study
}

/// A steady study whose file has a column of every input.
fn with_shroud() -> Study {
    let study = silent();
    study.put(
        "data/balance.csv",
        "phase,T_if [degC],Q [W],T_s [K],box [degC],panel [degC]\nP1,20,5,90,24.5,-20.25\nP2,0,5,90,5.5,\nP3,40,8,90,47,1\n",
    );
    study
}

#[test]
fn an_input_without_a_value_is_reported() {
    let said = silent().said("pass-1.json");
    assert!(
        said.starts_with(
            "warning[input-missing]: `balance` does not say what `T_s` (90 K) was: the nominal value stands for it"
        ),
        "{said}"
    );
    assert!(said.contains("\"inputs\": {\"T_s\": {\"value\": 90, \"unit\": \"K\"}}"), "{said}");
    assert_eq!(silent().load().measurements[0].doubts.len(), 1);
    assert_eq!(with_shroud().said("pass-1.json"), "");
    let declared = silent();
    declared.edit("pass-1.json", r#""held_out""#, r#""inputs": {"T_s": {"value": 80, "unit": "K"}}, "held_out""#);
    assert_eq!(declared.said("pass-1.json"), "");
    let Rows::Steady(phases) = &declared.load().measurements[0].rows else { panic!("steady") };
    assert!(phases.iter().all(|phase| phase.inputs[2] == 80.0));
    // The same value, said or not, makes the same model, but the results repeat what was not said.
    let [silent, said] = [silent(), with_shroud()].map(|study| study.load().measurements[0].identity());
    assert_ne!(silent["doubts"], said["doubts"]);
}

#[test]
fn an_input_of_a_part_that_the_test_does_not_touch_needs_no_value() {
    let study = with_shroud();
    study.edit("model.json", r#""T_s": {"#, r#""T_cell": {"unit": "K", "nominal": 77, "test_sets": true}, "T_s": {"#);
    study.edit(
        "model.json",
        r#""shroud": {"boundary": "T_s"}"#,
        r#""shroud": {"boundary": "T_s"}, "cell": {"boundary": "T_cell"}, "coupon": {}"#,
    );
    study.edit("model.json", r#""strap""#, r#""post": {"between": ["coupon", "cell"], "conductance": 1}, "strap""#);
    assert_eq!(study.said("pass-1.json"), "");
    // Through a boundary nothing passes, through a balance it does.
    study.edit("model.json", r#""strap""#, r#""foot": {"between": ["coupon", "plate"], "conductance": 1}, "strap""#);
    assert_eq!(study.said("pass-1.json"), "");
    study.edit("model.json", r#""strap""#, r#""hook": {"between": ["coupon", "box"], "conductance": 1}, "strap""#);
    assert!(study.said("pass-1.json").contains("does not say what `T_cell` was"));
}

#[test]
fn an_input_that_every_test_sets_must_be_said() {
    let study = silent();
    study.edit("model.json", r#""nominal": 90"#, r#""nominal": 90, "test_sets": true"#);
    let said = study.said("pass-1.json");
    assert!(
        said.starts_with("error[input-missing]: `balance` does not say what `T_s` was, which every test sets"),
        "{said}"
    );
    let study = with_shroud();
    study.edit("model.json", r#""nominal": 90"#, r#""nominal": 90, "test_sets": true"#);
    assert_eq!(study.said("pass-1.json"), "");
}

#[test]
fn an_input_of_some_windows_is_reported_of_the_others() {
    let study = Study::new();
    let windows = r#""windows": {"P1": {"file": "data/run.csv", "to": 60, "inputs": {"T_if": {"value": 20, "unit": "degC"}}},
        "P2": {"file": "data/run.csv"}},"#;
    study.edit("pass-1.json", r#""file": "data/balance.csv","#, windows);
    study.edit("pass-1.json", r#", "panel": {"measures": "panel"}"#, "");
    study.edit("pass-1.json", r#", "ignore": {"P3": "not stabilised"}"#, "");
    let said = study.said("pass-1.json");
    assert!(said.contains("`balance` does not say what `T_if` (20 degC in `P2`) was"), "{said}");
    assert!(!said.contains("T_s"), "{said}");
    study.edit(
        "pass-1.json",
        r#""P2": {"file": "data/run.csv"}"#,
        r#""P2": {"file": "data/run.csv", "inputs": {"T_if": 250, "Q": 1}}"#,
    );
    assert!(study.said("pass-1.json").contains("`Q` has a column and a constant value"));
}

#[test]
fn an_input_far_outside_its_range_is_an_error_at_its_cell() {
    let study = with_shroud();
    study.edit("data/balance.csv", "P2,0,", "P2,400,");
    let said = study.said("pass-1.json");
    let expected = "error[input-range]: `T_if` is 400 degC here: far outside its range, -40 degC to 60 degC";
    assert!(said.starts_with(expected) && said.contains("study/data/balance.csv:3:4"), "{said}");
}

#[test]
fn an_input_modestly_outside_its_range_is_a_warning_at_its_cell() {
    // A thousandth of the range's width is the offset of a meter.
    let study = with_shroud();
    study.edit("data/balance.csv", "P2,0,", "P2,60.05,");
    assert!(!study.said("pass-1.json").contains("`T_if`"), "{}", study.said("pass-1.json"));
    let study = with_shroud();
    study.edit("data/balance.csv", "P2,0,", "P2,150,");
    let said = study.said("pass-1.json");
    assert!(
        said.starts_with("warning[input-range]: `T_if` is 150 degC here: outside its range, -40 degC to 60 degC"),
        "{said}"
    );
    assert!(said.contains("study/data/balance.csv:3:4"), "{said}");
    // One width of 100 K beyond the end of 60 degC is the most.
    study.edit("data/balance.csv", "P2,150,", "P2,160.5,");
    assert!(study.said("pass-1.json").starts_with("error[input-range]: `T_if` is 160.5 degC here: far outside"));
    // What is ignored drives nothing, and an input without a range has none to leave.
    let study = with_shroud();
    study.edit("data/balance.csv", "P3,40,8,90", "P3,4000,8,9000");
    assert_eq!(study.said("pass-1.json"), "");
    // A constant is held to the same.
    let study = Study::new();
    study.edit("model.json", r#""nominal": 90"#, r#""nominal": 90, "range": [70, 80]"#);
    let said = study.said("pass-1.json");
    assert!(said.contains("warning[input-range]: `T_s` is 90 K here") && said.contains("pass-1.json:7:"), "{said}");
}

#[test]
fn a_reading_below_absolute_zero_is_an_error_at_its_cell() {
    for (unit, cell) in [("degC", "-300"), ("K", "-20.25"), ("K", "0")] {
        let study = with_shroud();
        study.edit("data/balance.csv", "panel [degC]", &format!("panel [{unit}]"));
        study.edit("data/balance.csv", "90,24.5,-20.25", &format!("90,24.5,{cell}"));
        let said = study.said("pass-1.json");
        assert!(said.starts_with("error[table-cell]: `panel` is "), "{said}");
        assert!(said.contains("K here, not above absolute zero") && said.contains("balance.csv:2:17"), "{said}");
    }
    // A phase that is left out is not read.
    let study = with_shroud();
    study.edit("data/balance.csv", "P3,40,8,90,47,1", "P3,40,8,90,47,-999");
    assert_eq!(study.said("pass-1.json"), "");
}

/// A transient whose start and file are given; the panel has no sensor.
fn transient(initial: &str, run: &str) -> Study {
    let study = Study::transient();
    let start = r#""initial": {"temperatures": {"all": {"value": 20, "unit": "degC"}}}"#;
    study.edit("pass-1.json", start, &format!(r#""initial": {initial}"#));
    study.edit(
        "pass-1.json",
        r#"{"measures": "box"}"#,
        r#"{"measures": "box", "sigma": {"value": 0.1, "unit": "K"}, "bias": {"value": 0, "unit": "K"}}"#,
    );
    study.put("data/run.csv", run);
    study
}

const FAR: &str = "time [s],Q [W],box [degC]\n0,5,32\n60,5,31\n120,0,30.5\n180,0,30\n";

#[test]
fn a_start_apart_from_the_first_readings_is_reported() {
    let start = r#"{"temperatures": {"all": {"value": 20, "unit": "degC"}}}"#;
    let said = transient(start, FAR).said("pass-1.json");
    assert!(said.starts_with("warning[start-apart]: the first readings of `balance` lie apart from its start temperatures: `box` 12 K above"), "{said}");
    assert!(said.contains("\"initial\": {\"measured\": {}}"), "{said}");
    // Within five standard deviations it is noise.
    assert_eq!(transient(start, "time [s],Q [W],box [degC]\n0,5,20.4\n60,5,22\n120,0,23\n").said("pass-1.json"), "");
    // A fitted start is held against its prior.
    let fitted = |lower: f64| {
        format!(r#"{{"temperatures": {{"all": {{"prior": {{"uniform": [{lower}, 35]}}, "unit": "degC"}}}}}}"#)
    };
    assert_eq!(transient(&fitted(15.0), FAR).said("pass-1.json"), "");
    assert!(transient(&fitted(33.0), FAR).said("pass-1.json").contains("`box` 1.001 K below"));
    assert_eq!(transient(r#"{"measured": {}}"#, FAR).said("pass-1.json"), "");
    // A first reading that comes late is carried back to the start.
    let late = "time [s],Q [W],box [degC]\n0,5,\n60,5,23\n120,0,26\n180,0,29\n";
    assert_eq!(transient(start, late).said("pass-1.json"), "");
}

fn initial(study: &Study) -> Initial {
    let Rows::Transient { initial, .. } = &study.load().measurements[0].rows else { panic!("transient") };
    initial.clone()
}

/// Mean and standard deviation in degC of a start that is fitted.
fn fitted(value: &Uncertain) -> (f64, f64) {
    match value {
        Uncertain::Inferred(Distribution::Normal { mean, sd, lower: None, upper: None }) => (mean - 273.15, *sd),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_measured_start_is_fitted_about_the_first_readings() {
    // Nodes: plate, shroud (boundaries), box, panel (store heat; only the box has a sensor, of 0.1 K).
    let start = |settings: &str| match initial(&transient(&format!(r#"{{"measured": {settings}}}"#), FAR)) {
        Initial::Temperatures { values, balanced, .. } => (values, balanced),
        other => panic!("{other:?}"),
    };
    let near = |value: &Uncertain, mean: f64, sd: f64| {
        let found = fitted(value);
        assert!((found.0 - mean).abs() < 1e-9 && (found.1 - sd).abs() < 1e-9, "{found:?}, not {mean} {sd}");
    };
    let (values, balanced) = start("{}");
    near(&values[2], 32.0, 0.5);
    // Boundaries have temperatures of their own, and the panel is expected between the box and the cold.
    assert_eq!(balanced, [0, 1]);
    let (panel, sd) = fitted(&values[3]);
    assert!(panel < 32.0 && panel > -200.0 && sd >= 1.0, "{panel} {sd}");
    // The box moves by 1 K from the first row to the second, and by 1.5 K to the third.
    near(&start(r#"{"rows": 2}"#).0[2], 31.5, 1.25_f64.sqrt());
    near(&start(r#"{"over": {"value": 2, "unit": "min"}}"#).0[2], 31.0 + 1.0 / 6.0, 2.5_f64.sqrt());
    let known = |settings: &str| match start(settings).0[3] {
        Uncertain::Known(value) => value - 273.15,
        ref other => panic!("{other:?}"),
    };
    assert!((known(r#"{"temperatures": {"panel": {"value": -10, "unit": "degC"}}}"#) + 10.0).abs() < 1e-9);
    let prior = r#"{"temperatures": {"panel": {"prior": {"normal": {"mean": -10, "sd": 2}}, "unit": "degC"}}}"#;
    near(&start(prior).0[3], -10.0, 2.0);
    near(&start(r#"{"others": {"nearest": {}}, "others_sd": {"value": 3, "unit": "K"}}"#).0[3], 32.0, 3.0);
    assert!((known(r#"{"others": {"nearest": {}}, "others_sd": 0}"#) - 32.0).abs() < 1e-9);
    // In balance, whatever the parameters are.
    assert_eq!(start(r#"{"others_sd": 0}"#).1, [0, 1, 3]);
}

/// The box reads 32, 31, 30.5 and 30 degC in rows a minute apart.
#[test]
fn a_clock_that_is_off_moves_the_first_readings() {
    let with = |clock: &str| {
        let study = transient(r#"{"measured": {}}"#, FAR);
        let clock = format!(r#""measures": "box", "clock_behind": {{{clock}, "unit": "min"}}, "#);
        study.edit("pass-1.json", r#""measures": "box", "sigma""#, &format!(r#"{clock}"sigma""#));
        let start = match initial(&study) {
            Initial::Temperatures { values, .. } => fitted(&values[2]),
            other => panic!("{other:?}"),
        };
        let readings = study.load().measurements[0].readings.iter().map(Option::is_some).collect::<Vec<bool>>();
        (start, readings)
    };
    let loaded = |minutes: f64| with(&format!(r#""value": {minutes}"#));
    let near = |found: (f64, f64), mean: f64, sd: f64| {
        assert!((found.0 - mean).abs() < 1e-9 && (found.1 - sd).abs() < 1e-9, "{found:?}, not {mean} {sd}");
    };
    // Ahead by a minute: the second row shows the start, the first what was before it.
    let (start, readings) = loaded(-1.0);
    near(start, 31.0, 0.5);
    assert_eq!(readings, [false, true, true, true]);
    // Ahead by less than half a row: the second row shows what is nearest to the start of all that is known.
    let (start, readings) = loaded(-1.0 / 3.0);
    near(start, 31.0, 0.5);
    assert_eq!(readings, [false, true, true, true]);
    // Behind by a minute: the first row shows the second minute, and the box moves by 1 K within the next.
    let (start, readings) = loaded(1.0);
    near(start, 32.0, 1.25_f64.sqrt());
    assert_eq!(readings, [true, true, true, false]);
    // A time that is inferred leaves nothing out, and counts by its median.
    let (start, readings) = with(r#""prior": {"normal": {"mean": -1, "sd": 0.1}}"#);
    near(start, 31.0, 0.5);
    assert_eq!(readings, [true; 4]);
}

/// What is left out of a record of which the first row shows what was before it.
#[test]
fn a_row_that_is_left_out_is_one_of_the_readings() {
    let study = transient(r#"{"measured": {}}"#, FAR);
    let clock = r#""measures": "box", "clock_behind": {"prior": {"normal": {"mean": -1, "sd": 0.1}}, "unit": "min"}, "#;
    study.edit("pass-1.json", r#""measures": "box", "sigma""#, &format!(r#"{clock}"sigma""#));
    let left_out =
        r#""ignore": {"start": {"to": {"value": 30, "unit": "s"}, "because": "shows what was before"}}, "initial""#;
    study.edit("pass-1.json", r#""initial""#, left_out);
    let Initial::Temperatures { values, .. } = initial(&study) else { panic!("temperatures") };
    let (start, _) = fitted(&values[2]);
    assert!((start - 31.0).abs() < 1e-9, "{start}");
}

#[test]
fn many_starts_without_a_reading_are_fitted_where_a_spread_is_stated() {
    let study = |settings: &str| {
        let study = transient(&format!(r#"{{"measured": {settings}}}"#), FAR);
        let fins: String = (0..41).map(|k| format!(r#", "fin {k}": {{"capacity": 5}}"#)).collect();
        let arms: String =
            (0..41).map(|k| format!(r#""arm {k}": {{"between": ["box", "fin {k}"], "conductance": 1}}, "#)).collect();
        study.edit("model.json", r#""panel": {"capacity": 300}}"#, &format!(r#""panel": {{"capacity": 300}}{fins}}}"#));
        study.edit("model.json", r#""strap""#, &format!(r#"{arms}"strap""#));
        study
    };
    let said = study("{}").said("pass-1.json");
    assert!(said.contains("warning[start-assumed]: 42 nodes of `balance` store heat"), "{said}");
    let many = study(r#"{"others_sd": {"value": 2, "unit": "K"}}"#);
    assert_eq!(many.said("pass-1.json"), "");
    let Initial::Temperatures { values, .. } = initial(&many) else { panic!("temperatures") };
    assert_eq!(values.iter().filter(|value| value.prior().is_some()).count(), 43);
}

#[test]
fn a_measured_start_that_cannot_be_is_an_error() {
    let said =
        |settings: &str, run: &str| transient(&format!(r#"{{"measured": {settings}}}"#), run).said("pass-1.json");
    assert!(said(r#"{"rows": 0}"#, FAR).contains("0 of 4 rows"));
    assert!(said(r#"{"rows": 5}"#, FAR).contains("5 of 4 rows"));
    assert!(said(r#"{"rows": 1, "over": 3}"#, FAR).contains("`rows` and `over`"));
    assert!(said(r#"{"temperatures": {"lid": 300}}"#, FAR).contains("unknown node `lid`"));
    assert!(said(r#"{"temperatures": {"panel": -3}}"#, FAR).contains("-3 is not above 0"));
    assert!(said(r#"{"others_sd": -1}"#, FAR).contains("a standard deviation of -1 K"));
    let late = "time [s],Q [W],box [degC]\n0,5,\n60,5,23\n120,0,26\n180,0,29\n";
    assert!(said("{}", late).contains("`box` has no reading in the first rows to start at"));
    assert_eq!(said(r#"{"rows": 2}"#, late), "");
    // A node that nothing joins to the others has no balance.
    let study = transient(r#"{"measured": {}}"#, FAR);
    study.edit(
        "model.json",
        r#""panel": {"capacity": 300}}"#,
        r#""panel": {"capacity": 300}, "lid": {"capacity": 5}, "rim": {}}"#,
    );
    study.edit("model.json", r#""strap""#, r#""ring": {"between": ["lid", "rim"], "conductance": 1}, "strap""#);
    assert!(study.said("pass-1.json").contains("no start temperature of `lid` and `rim`: no path joins them"));
}

/// The steady study with two windows of one file.
fn windows() -> Study {
    let study = Study::new();
    let windows = r#""windows": {"P1": {"file": "data/run.csv", "to": 60}, "P2": {"file": "data/run.csv"}},"#;
    study.edit("pass-1.json", r#""file": "data/balance.csv","#, windows);
    study.edit("pass-1.json", r#", "panel": {"measures": "panel"}"#, "");
    study.edit("pass-1.json", r#", "ignore": {"P3": "not stabilised"}"#, "");
    study.edit("pass-1.json", r#""inputs": {"T_s": 90}"#, r#""inputs": {"T_s": 90, "T_if": 293}"#);
    study
}

#[test]
fn what_follows_from_a_file_that_cannot_be_read_is_not_said() {
    let bad_cell = |study: &Study| {
        study.edit("data/run.csv", "120,0,21.5", "120,x,21.5");
    };
    let lost_column = |study: &Study| {
        study.edit("data/run.csv", "box [degC]", "bux [degC]");
    };
    for (spoil, code) in [(&bad_cell as &dyn Fn(&Study), "table-cell"), (&lost_column, "table-column")] {
        let study = windows();
        spoil(&study);
        let said = study.said("pass-1.json");
        assert_eq!((said.matches("error[").count(), said.contains(&format!("error[{code}]"))), (1, true), "{said}");
        // A second measurement of the same file, of which the same is not said again.
        let file = std::fs::read_to_string(study.path("pass-1.json")).expect("readable");
        let (start, end) = (file.find("{\"steady\"").expect("there"), file.find("},\n \"design\"").expect("there"));
        let twice = format!("{}, \"again\": {}{}", &file[..end], &file[start..end], &file[end..]);
        study.put("pass-1.json", twice);
        let said = study.said("pass-1.json");
        assert!(!said.contains("table-empty") && !said.contains("``"), "{said}");
    }
    // What is wrong beside it is still said.
    let study = windows();
    bad_cell(&study);
    study.edit("pass-1.json", r#""phases": ["P2"]"#, r#""phases": ["P2", "P7"]"#);
    let said = study.said("pass-1.json");
    assert_eq!(said.matches("error[").count(), 2, "{said}");
    assert!(said.contains("unknown phase `P7`") && said.contains("one of `P1` and `P2`"), "{said}");
    // A measurement without windows has no file to name.
    let study = windows();
    let text = std::fs::read_to_string(study.path("pass-1.json")).expect("readable");
    let (from, to) = (text.find("\"windows\": {").expect("there"), text.find("\"sensors\"").expect("there"));
    study.put("pass-1.json", format!("{}\"windows\": {{}}, {}", &text[..from], &text[to..]));
    let said = study.said("pass-1.json");
    assert!(said.contains("the measurement `balance` has no windows") && !said.contains("``"), "{said}");
}

#[test]
fn an_empty_name_is_said_to_be_one() {
    let study = Study::new();
    study.edit("pass-1.json", r#"{"measures": "panel"}"#, r#"{"measures": ""}"#);
    let said = study.said("pass-1.json");
    assert!(said.contains("unknown quantity or node (an empty name)") && !said.contains("``"), "{said}");
    study.edit("pass-1.json", r#"{"measures": ""}"#, r#"{"measures": "panel"}"#);
    study.put("data/balance.csv", "phase,T_if [degC],Q [W],bux [degC],panel [degC],\nP1,20,5,24.5,-20.25,\n");
    let said = study.said("pass-1.json");
    assert!(said.contains("(an empty name)") && !said.contains("``"), "{said}");
}

#[test]
fn an_unused_column_of_nearly_an_input_s_name_is_reported() {
    let study = silent();
    study.put("data/balance.csv", "phase,T_if [degC],Q [W],Ts [K],box [degC],panel [degC]\nP1,20,5,80,24.5,-20.25\nP2,0,5,80,5.5,1\nP3,40,8,80,47,1\n");
    let said = study.said("pass-1.json");
    assert!(said.starts_with("warning[input-missing]: `balance` does not say what `T_s` (90 K) was"), "{said}");
    assert!(said.contains("the file has an unused column `Ts`: rename it `T_s`, or declare it"), "{said}");
    assert!(said.contains(r#""columns": {"T_s": {"header": "Ts [K]"}}"#), "{said}");
    // An input that every test sets, of a column without a unit.
    study.edit("model.json", r#""nominal": 90"#, r#""nominal": 90, "test_sets": true"#);
    study.edit("data/balance.csv", "Ts [K]", "TS");
    let said = study.said("pass-1.json");
    assert!(said.starts_with("error[input-missing]") && said.contains("an unused column `TS`"), "{said}");
    assert!(said.contains(r#"{"header": "TS", "unit": "K"}"#), "{said}");
    // The column of a sensor that is left out is none, and neither is one of another name.
    study.edit("data/balance.csv", "TS,box [degC],panel [degC]", "note,box [degC],T_p [degC]");
    study.edit("pass-1.json", r#""panel": {"measures": "panel"}"#, r#""T_p": {"measures": "panel"}"#);
    study.edit("pass-1.json", r#""ignore": {"#, r#""ignore": {"T_p": "loose", "#);
    assert!(!study.said("pass-1.json").contains("unused column"), "{}", study.said("pass-1.json"));
    // Windows say it too.
    let study = windows();
    study.edit("pass-1.json", r#", "T_if": 293"#, "");
    study.put("data/run.csv", "time [s],Q [W],Tif [degC],box [degC]\n0,5,20,20\n60,5,20,21\n120,0,20,21.5\n");
    assert!(study.said("pass-1.json").contains("the file has an unused column `Tif`: rename it `T_if`"));
}

#[test]
fn a_unit_in_which_the_values_would_lie_in_the_range_is_proposed_where_it_is_written() {
    let ranged = |range: &str, cells: [&str; 3]| {
        let study = with_shroud();
        study.edit("model.json", r#""nominal": 5"#, &format!(r#""nominal": 5, "range": {range}"#));
        let [a, b, c] = cells;
        let rows = format!("P1,20,{a},90,24.5,1\nP2,0,{b},90,5.5,\nP3,40,{c},90,47,1\n");
        study.put("data/balance.csv", format!("phase,T_if [degC],Q [W],T_s [K],box [degC],panel [degC]\n{rows}"));
        study.edit("pass-1.json", r#", "ignore": {"P3": "not stabilised"}"#, "");
        study
    };
    let study = ranged("[0, 16]", ["12006", "0", "8003"]);
    let said = study.said("pass-1.json");
    let expected = "error[input-range]: `Q` is 12006 W, far outside its range, 0 W to 16 W; it is outside in another row too: its \
                unit is most likely `mW`, not `W`";
    assert!(said.starts_with(expected), "{said}");
    assert!(said.contains("study/data/balance.csv:1:19") && said.contains("study/data/balance.csv:2:7"), "{said}");
    // Where the pass states the unit, there.
    study.edit("pass-1.json", r#""held_out""#, r#""columns": {"Q": {"header": "Q [W]", "unit": "W"}}, "held_out""#);
    let said = study.said("pass-1.json");
    assert!(said.contains("--> study/pass-1.json:7:") && said.contains("most likely `mW`"), "{said}");
    study.edit("pass-1.json", r#""header": "Q [W]", "unit": "W""#, r#""header": "Q [W]", "unit": "mW""#);
    assert!(!study.said("pass-1.json").contains("input-range"));
    let likely = |range: &str, cells: [&str; 3], unit: Option<&str>| {
        let said = ranged(range, cells).said("pass-1.json");
        let found = unit.map(|unit| format!("most likely `{unit}`, not `W`"));
        match found {
            Some(found) => assert!(said.contains(&found), "{found}: {said}"),
            None => assert!(!said.contains("most likely"), "{said}"),
        }
    };
    likely("[5, 16]", ["0.006", "0.012", "0.015"], Some("kW"));
    likely("[0, 16]", ["6e6", "12e6", "1"], Some("uW"));
    likely("[5e6, 6e6]", ["5.1", "5.2", "5.9"], Some("MW"));
    // Just outside, of several sizes, or with one slip: no unit explains it.
    likely("[0, 16]", ["17", "16", "15"], None);
    likely("[0, 16]", ["40", "16", "15"], None);
    likely("[0, 16]", ["12000", "12", "30000"], None);
    // Kelvins for degrees.
    let study = with_shroud();
    study.put("data/balance.csv", "phase,T_if [degC],Q [W],T_s [K],box [degC],panel [degC]\nP1,293,5,90,24.5,-20\nP2,273.15,5,90,5.5,\nP3,313,8,90,47,1\n");
    let said = study.said("pass-1.json");
    assert!(said.contains("most likely `K`, not `degC`"), "{said}");
    // A constant is stated at its unit.
    let study = silent();
    study.edit("model.json", r#""nominal": 90"#, r#""nominal": 90, "range": [70, 110]"#);
    study.edit("pass-1.json", r#""held_out""#, r#""inputs": {"T_s": {"value": -183, "unit": "K"}}, "held_out""#);
    let said = study.said("pass-1.json");
    assert!(said.contains("most likely `degC`, not `K`") && said.contains("study/pass-1.json:7:"), "{said}");
}

#[test]
fn that_an_input_leaves_its_range_is_said_once_a_pass_with_the_other_places() {
    let study = with_shroud();
    study.edit("data/balance.csv", "P2,0,", "P2,150,");
    let once = study.said("pass-1.json");
    let measurement = std::fs::read_to_string(study.path("pass-1.json")).expect("readable");
    let start = measurement.find(r#""balance": "#).expect("there");
    let other = measurement[start..].replacen("balance", "again", 1);
    let end = whole_entry(&other);
    study.put("pass-1.json", format!("{}{}, {}", &measurement[..start], &other[..end], &measurement[start..]));
    let twice = study.said("pass-1.json");
    assert_eq!(once.matches("warning[input-range]").count(), 1, "{once}");
    assert_eq!(twice.matches("warning[input-range]").count(), 1, "{twice}");
    assert!(twice.contains("and here"), "{twice}");
}

/// Length of the first entry of an object's text: to the end of its value.
fn whole_entry(text: &str) -> usize {
    let mut depth = 0;
    for (at, character) in text.char_indices() {
        match character {
            '{' => depth += 1,
            '}' if depth == 1 => return at + 1,
            '}' => depth -= 1,
            _ => {}
        }
    }
    text.len()
}
