//! Wrong measurements: what a pass says of them, and the tables themselves.

use crate::diagnostics::pass_study::{BALANCE, Study};

#[test]
fn a_missing_file() {
    let study = Study::new();
    study.edit("pass-1.json", r#"data/balance.csv"#, r#"data/balence.csv"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[file-missing]: the file `data/balence.csv` does not exist in the study's folder
     --> study/pass-1.json:5:50
      |
    5 |  "measurements": {"balance": {"steady": {"file": "data/balence.csv",
      |                                                  ^^^^^^^^^^^^^^^^^^
      |
      = note: at $.measurements.balance.steady.file
      = help: did you mean `data/balance.csv`?
    "##);
}

#[test]
fn a_path_that_leaves_the_study() {
    let study = Study::new();
    study.edit("pass-1.json", r#"data/balance.csv"#, r#"../balance.csv"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[path-refused]: the path `../balance.csv` leaves the study's folder: write it relative to that folder, without `..`
     --> study/pass-1.json:5:50
      |
    5 |  "measurements": {"balance": {"steady": {"file": "../balance.csv",
      |                                                  ^^^^^^^^^^^^^^^^
      |
      = note: at $.measurements.balance.steady.file
    "##);
}

#[test]
fn a_file_and_windows() {
    let study = Study::new();
    study.edit("pass-1.json", r#""file": "data/balance.csv","#, r#""file": "data/balance.csv", "windows": {},"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[measurement-form]: a steady measurement has either a `file` or `windows`
     --> study/pass-1.json:5:19
      |
    5 |  "measurements": {"balance": {"steady": {"file": "data/balance.csv", "windows": {},
      |                   ^^^^^^^^^ one of the two
      |
      = note: at $.measurements.balance
    "##);
}

#[test]
fn a_window_with_a_column_and_a_constant_value_of_an_input() {
    // The column would override the 9 W in silence.
    let study = Study::new();
    let window = r#""windows": {"P1": {"file": "data/run.csv", "inputs": {"Q": 9}}, "P2": {"file": "data/run.csv"}},"#;
    study.edit("pass-1.json", r#""file": "data/balance.csv","#, window);
    study.edit("pass-1.json", r#", "panel": {"measures": "panel"}"#, "");
    study.edit("pass-1.json", r#", "ignore": {"P3": "not stabilised"}"#, "");
    let said = study.said("pass-1.json");
    assert!(said.contains("`Q` has a column and a constant value"), "{said}");
}

#[test]
fn an_unknown_phase_held_out() {
    let study = Study::new();
    study.edit("pass-1.json", r#"["P2"]"#, r#"["P4"]"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[measurement-form]: unknown phase `P4`
     --> study/pass-1.json:7:28
      |
    7 |    "held_out": {"phases": ["P4"]}, "ignore": {"P3": "not stabilised"}, "inputs": {"T_s": 90}}}},
      |                            ^^^^ one of `P1`, `P2` and `P3`
      |
      = note: at $.measurements.balance.steady.held_out.phases[0]
      = help: did you mean `P1`?
    "##);
}

#[test]
fn an_ignored_phase_that_is_not_there() {
    let study = Study::new();
    study.edit("pass-1.json", r#"{"P3""#, r#"{"P33""#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[measurement-form]: unknown phase or sensor `P33`
     --> study/pass-1.json:7:47
      |
    7 |    "held_out": {"phases": ["P2"]}, "ignore": {"P33": "not stabilised"}, "inputs": {"T_s": 90}}}},
      |                                               ^^^^^ one of `P1`, `P2`, `P3`, `box` and `panel`
      |
      = note: at $.measurements.balance.steady.ignore.P33
      = help: did you mean `P3`?
    "##);
}

#[test]
fn a_sensor_called_as_an_input() {
    let study = Study::new();
    study.edit("pass-1.json", r#""panel": {"measures": "panel"}"#, r#""Q": {"measures": "panel"}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[name-unusable]: `Q` is an input of the model and a sensor here: its column would be both
     --> study/pass-1.json:6:83
      |
    6 |    "sensors": {"box": {"measures": "box", "sigma": {"value": 0.25, "unit": "K"}}, "Q": {"measures": "panel"}},
      |                                                                                   ^^^ another name
      |
      = note: at $.measurements.balance.steady.sensors.Q
    "##);
}

#[test]
fn a_sigma_of_zero() {
    let study = Study::new();
    study.edit("pass-1.json", r#""value": 0.25"#, r#""value": 0"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[out-of-range]: 0 is not above 0
     --> study/pass-1.json:6:52
      |
    6 |    "sensors": {"box": {"measures": "box", "sigma": {"value": 0, "unit": "K"}}, "panel": {"measures": "panel"}},
      |                                                    ^^^^^^^^^^^^^^^^^^^^^^^^^ a value above 0
      |
      = note: at $.measurements.balance.steady.sensors.box.sigma
    "##);
}

#[test]
fn a_sensor_without_a_column() {
    let study = Study::new();
    study.edit("pass-1.json", r#""panel": {"measures": "panel"}"#, r#""pannel": {"measures": "panel"}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[table-column]: `study/data/balance.csv` has no column `pannel`
     --> study/pass-1.json:6:83
      |
    6 |    "sensors": {"box": {"measures": "box", "sigma": {"value": 0.25, "unit": "K"}}, "pannel": {"measures": "panel"}},
      |                                                                                   ^^^^^^^^ the columns are `phase`, `T_if`, `Q`, `box`, `panel` and `note`
      |
      = note: at $.measurements.balance.steady.sensors.pannel
      = help: did you mean `panel`?
    "##);
}

#[test]
fn a_declared_column_that_is_not_there() {
    let study = Study::new();
    study.edit(
        "pass-1.json",
        r#""held_out""#,
        r#""columns": {"box": {"header": "Box (degC)", "unit": "degC"}}, "held_out""#,
    );
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[table-column]: `study/data/balance.csv` has no column `Box (degC)`
     --> study/pass-1.json:7:34
      |
    7 | ...": {"header": "Box (degC)", "unit": "degC"}}, "held_out": {"phases": ["P2"]}, "ignore": {"P3": "not stabilised"}, "inputs": {"T_s"...
      |                  ^^^^^^^^^^^^ the columns are `phase`, `T_if [degC]`, `Q [W]`, `box [degC]`, `panel [degC]` and `note`
      |
      = note: at $.measurements.balance.steady.columns.box.header
      = help: did you mean `box [degC]`?
    "##);
}

#[test]
fn a_declared_column_that_nothing_uses() {
    let study = Study::new();
    study.edit("pass-1.json", r#""held_out""#, r#""columns": {"bxo": {"header": "box [degC]"}}, "held_out""#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[table-column]: unknown sensor or input `bxo`
     --> study/pass-1.json:7:16
      |
    7 |    "columns": {"bxo": {"header": "box [degC]"}}, "held_out": {"phases": ["P2"]}, "ignore": {"P3": "not stabilised"}, "inputs": {"T_s"...
      |                ^^^^^ one of `phase`, `T_if`, `Q`, `T_s`, `box` and `panel`
      |
      = note: at $.measurements.balance.steady.columns.bxo
      = help: did you mean `box`?
    "##);
}

#[test]
fn a_separator_of_two_characters() {
    let study = Study::new();
    study.edit("pass-1.json", r#""held_out""#, r#""separator": "::", "held_out""#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[table-shape]: `::` cannot separate cells
     --> study/pass-1.json:7:17
      |
    7 |    "separator": "::", "held_out": {"phases": ["P2"]}, "ignore": {"P3": "not stabilised"}, "inputs": {"T_s": 90}}}},
      |                 ^^^^ one character such as `;`, or "tab"
      |
      = note: at $.measurements.balance.steady.separator
    "##);
}

#[test]
fn intervals_in_a_steady_measurement() {
    let study = Study::new();
    study.edit("pass-1.json", r#"{"phases": ["P2"]}"#, r#"{"intervals": [{"from": 3}]}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[measurement-form]: a steady measurement has no intervals to hold out
     --> study/pass-1.json:7:31
      |
    7 |    "held_out": {"intervals": [{"from": 3}]}, "ignore": {"P3": "not stabilised"}, "inputs": {"T_s": 90}}}},
      |                               ^^^^^^^^^^^ `phases` or `all`
      |
      = note: at $.measurements.balance.steady.held_out.intervals[0]
    "##);
}

#[test]
fn readings_below_absolute_zero() {
    let study = Study::new();
    study.edit("data/balance.csv", "24.5,-20.25", "-400,-20.25");
    let said = study.said("pass-1.json");
    assert!(said.contains("`box` is -126.85 K here, not above absolute zero"), "{said}");
}

#[test]
fn cells_that_are_no_numbers() {
    let study = Study::new();
    study.edit("data/balance.csv", r#"24.5,-20.25"#, r#"NaN,"1,5""#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[table-cell]: `NaN` is not a finite number
     --> study/data/balance.csv:2:9
      |
    2 | P1,20,5,NaN,"1,5",
      |         ^^^
      |
      = help: leave the cell of a missing reading empty

    error[table-cell]: `1,5` is not a number
     --> study/data/balance.csv:2:13
      |
    2 | P1,20,5,NaN,"1,5",
      |             ^^^^^
      |
      = help: a decimal is written with a point: write 1.5
    "##);
}

#[test]
fn a_missing_input_in_the_data() {
    let study = Study::new();
    study.edit("data/balance.csv", r#"P2,0,5"#, r#"P2,,5"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[table-cell]: `T_if` has no value in this row
     --> study/data/balance.csv:3:4
      |
    3 | P2,,5,5.5,,vented
      |    ^
      |
      = help: only a sensor's reading may be missing
    "##);
}

#[test]
fn a_ragged_row() {
    let study = Study::new();
    study.edit("data/balance.csv", r#"P3,40,8,47,1,"#, r#"P3,40,8,47"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[table-shape]: this row has 4 cells, the line of headers has 6
     --> study/data/balance.csv:4:1
      |
    4 | P3,40,8,47
      | ^^^^^^^^^^
    "##);
}

#[test]
fn a_phase_twice() {
    let study = Study::new();
    study.edit("data/balance.csv", r#"P2,0"#, r#"P1,0"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[table-cell]: `P1` stands twice under `phase`
     --> study/data/balance.csv:3:1
      |
    3 | P1,0,5,5.5,,vented
      | ^^
    "##);
}

#[test]
fn a_column_twice() {
    let study = Study::new();
    study.edit("data/balance.csv", r#"note"#, r#"box [degC]"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[table-column]: the column `box [degC]` stands twice
     --> study/data/balance.csv:1:49
      |
    1 | phase,T_if [degC],Q [W],box [degC],panel [degC],box [degC]
      |                                                 ^^^^^^^^^^ which one is meant?
      |
     ::: study/data/balance.csv:1:25
      |
    1 | phase,T_if [degC],Q [W],box [degC],panel [degC],box [degC]
      |                         ---------- the first one
    "##);
}

#[test]
fn an_unknown_unit_in_a_header() {
    let study = Study::new();
    study.edit("data/balance.csv", r#"T_if [degC]"#, r#"T_if [degX]"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[unknown-unit]: unknown unit `degX`
     --> study/data/balance.csv:1:7
      |
    1 | phase,T_if [degX],Q [W],box [degC],panel [degC],note
      |       ^^^^^^^^^^^ units look like W/K, W/(m2 K), mW, degC, 1
      |
      = help: did you mean `degC`?
    "##);
}

#[test]
fn a_wrong_unit_in_a_header() {
    let study = Study::new();
    study.edit("data/balance.csv", r#"Q [W]"#, r#"Q [W/K]"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[wrong-dimension]: the unit `W/K` does not fit here
     --> study/data/balance.csv:1:19
      |
    1 | phase,T_if [degC],Q [W/K],box [degC],panel [degC],note
      |                   ^^^^^^^ a unit of W
    "##);
}

#[test]
fn a_header_without_a_unit() {
    let study = Study::new();
    study.edit("data/balance.csv", r#"Q [W]"#, r#"Q"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[table-column]: the column `Q` states no unit
     --> study/data/balance.csv:1:19
      |
    1 | phase,T_if [degC],Q,box [degC],panel [degC],note
      |                   ^
      |
      = help: write `Q [W]`, or declare its unit under "columns"
    "##);
}

#[test]
fn another_separator() {
    let study = Study::new();
    study.put("data/balance.csv", BALANCE.replace(',', ";"));
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[table-shape]: the first line has one column only
     --> study/data/balance.csv:1:1
      |
    1 | phase;T_if [degC];Q [W];box [degC];panel [degC];note
      | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
      |
      = help: declare the separator: "separator": ";"
    "##);
}

#[test]
fn no_rows() {
    let study = Study::new();
    study.put("data/balance.csv", "phase,box [degC],panel [degC]\n");
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[table-empty]: `data/balance.csv` has no rows
     --> study/pass-1.json:5:50
      |
    5 |  "measurements": {"balance": {"steady": {"file": "data/balance.csv",
      |                                                  ^^^^^^^^^^^^^^^^^^ at least one row below the headers
      |
      = note: at $.measurements.balance.steady.file
    "##);
}

#[test]
fn bytes_that_are_no_text() {
    let study = Study::new();
    study.put("data/balance.csv", b"phase,box [\xb0C]\n");
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[not-utf8]: the file is not UTF-8: byte 0xb0 at offset 11
     --> study/data/balance.csv:1:12
      |
    1 | phase,box [�C]
      |            ^
      |
      = help: save the file as UTF-8
    "##);
}

#[test]
fn phases_in_a_transient() {
    let study = Study::transient();
    study.edit("pass-1.json", r#"{"intervals": [{"from": {"value": 2, "unit": "min"}}]}"#, r#"{"phases": ["P1"]}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[measurement-form]: a transient has no phases to hold out
     --> study/pass-1.json:7:28
      |
    7 |    "held_out": {"phases": ["P1"]}, "inputs": {"T_if": {"value": 20, "unit": "degC"}, "T_s": 90}}}},
      |                            ^^^^ `intervals` or `all`
      |
      = note: at $.measurements.balance.transient.held_out.phases[0]
    "##);
}

#[test]
fn an_interval_beyond_the_data() {
    let study = Study::transient();
    study.edit("pass-1.json", r#"{"value": 2, "unit": "min"}"#, r#"{"value": 2, "unit": "h"}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[interval]: no row of the data lies in this interval
     --> study/pass-1.json:7:31
      |
    7 |    "held_out": {"intervals": [{"from": {"value": 2, "unit": "h"}}]}, "inputs": {"T_if": {"value": 20, "unit": "degC"}, "T_s": 90}}}},
      |                               ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ the data run from 0 s to 180 s
      |
      = note: at $.measurements.balance.transient.held_out.intervals[0]
    "##);
}

#[test]
fn an_interval_upside_down() {
    let study = Study::transient();
    study.edit("pass-1.json", r#"{"from": {"value": 2, "unit": "min"}}"#, r#"{"from": 100, "to": 50}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[interval]: the interval from 100 s to 50 s is empty
     --> study/pass-1.json:7:31
      |
    7 |    "held_out": {"intervals": [{"from": 100, "to": 50}]}, "inputs": {"T_if": {"value": 20, "unit": "degC"}, "T_s": 90}}}},
      |                               ^^^^^^^^^^^^^^^^^^^^^^^ an end after the beginning
      |
      = note: at $.measurements.balance.transient.held_out.intervals[0]
    "##);
}

#[test]
fn start_temperatures_of_some_nodes() {
    let study = Study::transient();
    study.edit("pass-1.json", r#""all": {"value": 20"#, r#""box": {"value": 20"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[initial-temperatures]: no start temperature of `panel`
     --> study/pass-1.json:5:98
      |
    5 |  "measurements": {"balance": {"transient": {"file": "data/run.csv", "initial": {"temperatures": {"box": {"value": 20, "unit": "degC"}}},
      |                                                                                                  ^^^^^ a temperature for each, or `all`
      |
      = note: at $.measurements.balance.transient.initial.temperatures.box
    "##);
}

#[test]
fn an_input_held_without_a_column() {
    let study = Study::transient();
    study.edit("pass-1.json", r#"["Q"]"#, r#"["T_if"]"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[measurement-form]: `T_if` has no column to hold
     --> study/pass-1.json:6:13
      |
    6 |    "hold": ["T_if"], "sensors": {"box": {"measures": "box"}},
      |             ^^^^^^ an input with a column
      |
      = note: at $.measurements.balance.transient.hold[0]
    "##);
}

#[test]
fn times_that_do_not_increase() {
    let study = Study::transient();
    study.edit("data/run.csv", r#"120,0"#, r#"60,0"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[table-cell]: time 60 is not after 60, the time of the row before
     --> study/data/run.csv:4:1
      |
    4 | 60,0,21.5
      | ^^
    "##);
}

#[test]
fn no_column_of_time() {
    let study = Study::transient();
    study.edit("data/run.csv", r#"time [s]"#, r#"t [s]"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[table-column]: `study/data/run.csv` has no column `time`
     --> study/data/run.csv:1:1
      |
    1 | t [s],Q [W],box [degC]
      | ^^^^^^^^^^^^^^^^^^^^^^ the columns are `t`, `Q` and `box`
      |
      = help: declare it: "columns": {"time": {"header": "...", "unit": "..."}}
    "##);
}

#[test]
fn a_hash_that_is_none() {
    let study = Study::new();
    study.edit("pass-1.json", r#""held_out""#, r#""pinned": {"sha256": "abc"}, "held_out""#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[pinned-data]: `abc` is no SHA-256
     --> study/pass-1.json:7:25
      |
    7 |    "pinned": {"sha256": "abc"}, "held_out": {"phases": ["P2"]}, "ignore": {"P3": "not stabilised"}, "inputs": {"T_s": 90}}}},
      |                         ^^^^^ 64 hexadecimal digits
      |
      = note: at $.measurements.balance.steady.pinned.sha256
    "##);
}

#[test]
fn an_origin_that_is_not_fetched() {
    let study = Study::new();
    study.edit("pass-1.json", r#""held_out""#, r#""pinned": {"sha256": "10278caee2b095cca028e19acd9146157a75cdd8426e0490231de7a9def8ebdc", "origin": "ftp://example.org/x"}, "held_out""#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[pinned-data]: `ftp://example.org/x` cannot be fetched
     --> study/pass-1.json:7:103
      |
    7 | ...26e0490231de7a9def8ebdc", "origin": "ftp://example.org/x"}, "held_out": {"phases": ["P2"]}, "ignore": {"P3": "not stabilised"}, "i...
      |                                        ^^^^^^^^^^^^^^^^^^^^^ an address that begins with https://
      |
      = note: at $.measurements.balance.steady.pinned.origin
    "##);
}

#[test]
fn other_bytes_than_pinned() {
    let study = Study::new();
    study.edit(
        "pass-1.json",
        r#""held_out""#,
        r#""pinned": {"sha256": "10278caee2b095cca028e19acd9146157a75cdd8426e0490231de7a9def8ebdc"}, "held_out""#,
    );
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[pinned-data]: `data/balance.csv` has SHA-256 b5ac96e6345374a33b962950b0e8e7ed186ccdec557a3da33b6752e81b30be02, pinned is 10278caee2b095cca028e19acd9146157a75cdd8426e0490231de7a9def8ebdc
     --> study/pass-1.json:5:50
      |
    5 |  "measurements": {"balance": {"steady": {"file": "data/balance.csv",
      |                                                  ^^^^^^^^^^^^^^^^^^ not the pinned file
      |
      = note: at $.measurements.balance.steady.file
      = help: move the file away, then `bmv data get` brings the pinned one
    "##);
}

#[test]
fn a_logged_sensor_without_an_absolute_error() {
    let study = Study::transient();
    let sensor = r#"{"box": {"measures": "box"}}"#;
    assert!(!study.said("pass-1.json").contains("no-absolute-error"), "without a noise nothing is fitted");
    study.edit("pass-1.json", sensor, r#"{"box": {"measures": "box", "sigma": {"value": 0.1, "unit": "K"}}}"#);
    let said = study.said("pass-1.json");
    assert_eq!(said.matches("warning[no-absolute-error]").count(), 1, "{said}");
    assert!(said.contains("no absolute error is stated of `box` of `balance`"), "{said}");
    // What the help says is accepted, and ends it.
    let help = &said[said.find(r#"{"prior": {"normal""#).expect("a bias")..said.find(" for 1.5 K").expect("its end")];
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    let noisy = r#""sigma": {"value": 0.1, "unit": "K"}"#;
    for bias in [help.as_str(), r#"{"value": 0, "unit": "K"}"#] {
        study.put(
            "pass-2.json",
            std::fs::read_to_string(study.path("pass-1.json"))
                .expect("there")
                .replace(noisy, &format!(r#"{noisy}, "bias": {bias}"#)),
        );
        assert!(!study.said("pass-2.json").contains("no-absolute-error"), "{}", study.said("pass-2.json"));
    }
}
