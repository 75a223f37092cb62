//! Couplings in tables: the same model as with objects, and what is wrong at its cell.

use crate::diagnostics::pass_study::{MODEL, Study};

const CONDUCTORS: &str = "\"conductors\": {\"bolts\": {\"between\": [\"box\", \"plate\"], \"conductance\": \"G\"}, \
                          \"strap\": {\"between\": [\"box\", \"panel\"], \"conductance\": 0.3}}";
const RADIATION: &str = "\"exchange_area\": \"0.85 * A\"";
const RADIATIONS: &str =
    "\"radiations\": {\"panel\": {\"between\": [\"panel\", \"shroud\"], \"exchange_area\": \"A * 0.85\"}}";
const TABULATED: &str = "\"tabulated\": {\"conductors\": {\"file\": \"data/conductors.csv\"}, \
                         \"radiations\": {\"file\": \"data/radiations.csv\", \"separator\": \";\"}}";

/// The study with its couplings in objects; a parameter stands before its factor, as in a table.
fn with_objects() -> Study {
    let study = Study::new();
    study.edit("model.json", RADIATION, "\"exchange_area\": \"A * 0.85\"");
    study
}

/// The same with all of them in tables.
fn with_tables() -> Study {
    let study = with_objects();
    study.edit("model.json", CONDUCTORS, TABULATED).edit("model.json", &format!(",\n {RADIATIONS}"), "");
    study.put(
        "data/conductors.csv",
        "name,from,to,value [mW/K],parameter,factor\nbolts,box,plate,,G,\nstrap,box,panel,300,,\n",
    );
    study.put("data/radiations.csv", "factor;parameter;to;from;name\n0.85;A;shroud;panel;panel\n");
    study
}

#[test]
fn a_table_and_objects_are_one_model() {
    let (objects, tables) = (with_objects(), with_tables());
    let (by_objects, by_tables) = (objects.load(), tables.load());
    assert_eq!(by_tables.model.identity().to_string(), by_objects.model.identity().to_string());
    assert_eq!(by_tables.definition_sha256, by_objects.definition_sha256, "the same definition");
    for file in ["data/conductors.csv", "data/radiations.csv"] {
        assert!(by_tables.files.contains_key(file), "{file} is among the files that an archive holds");
    }
    assert_eq!(tables.said("pass-1.json"), objects.said("pass-1.json"));
    tables.edit("data/conductors.csv", "300", "301");
    let after = tables.load();
    assert_ne!(after.definition_sha256, by_tables.definition_sha256);
    let changed = bmv::study::changed(&by_objects, &after).expect("readable");
    let changed: Vec<_> = changed.into_iter().map(|one| (one.entry, one.before, one.after)).collect();
    let text = |value: &str| Some(value.to_owned());
    assert_eq!(changed, [("conductors.strap.conductance".to_owned(), text("0.3"), text("301"))]);
}

#[test]
fn rows_without_a_name_get_one_that_is_free() {
    let study = with_tables();
    let rows = "name,from,to,value,parameter,factor\n,box,plate,,G,\nbox-panel 2,box,panel,0.1,,\n,box,panel,0.1,,\n,box,panel,0.1,,\n";
    study.put("data/conductors.csv", rows);
    study.edit("model.json", "{\"heat\": \"bolts\"}", "{\"heat\": \"box-plate\"}");
    let names: Vec<String> = study.load().model.elements.into_iter().map(|element| element.name).collect();
    assert_eq!(names, ["box-plate", "box-panel 2", "box-panel", "box-panel 3", "panel", "board"]);
    // Beside objects: these come first, and keep their names.
    study.edit(
        "model.json",
        "\"tabulated\"",
        &format!("{},\n \"tabulated\"", CONDUCTORS.replace("bolts", "box-plate")),
    );
    let pass = study.load();
    let names: Vec<&str> = pass.model.elements.iter().map(|element| element.name.as_str()).collect();
    assert_eq!(&names[..3], ["box-plate", "strap", "box-plate 2"]);
}

/// What is said of a table of conductors: code, line and column, and the message.
fn said(table: &str) -> Vec<String> {
    let study = with_tables();
    study.put("data/conductors.csv", table);
    let diagnostics = bmv::job::load(&study.path("pass-1.json")).expect_err("wrong");
    diagnostics
        .plain()
        .into_iter()
        .map(|plain| format!("{}:{} {}: {}", plain.line, plain.column, plain.code, plain.message))
        .collect()
}

#[test]
fn every_mistake_of_a_table_has_its_place() {
    let head = "name,from,to,value,parameter,factor\nbolts,box,plate,,G,\n";
    let with = |row: &str| format!("{head}{row}\n");
    let cases: &[(String, &[&str])] = &[
        (with("strap,box,panle,0.3,,"), &["3:11 unknown-reference: unknown node `panle`"]),
        (with("strap,box,,0.3,,"), &["3:1 table-cell: the `to` of this row is empty"]),
        (with("strap,box,box,0.3,,"), &["3:11 self-loop: both ends are the node `box`"]),
        (with("strap,box,panel,0.3x,,"), &["3:17 table-cell: `0.3x` is not a number"]),
        (with("strap,box,panel,-0.3,,"), &["3:17 out-of-range: a conductance of -0.3 W/K"]),
        (with("strap,box,panel,,,"), &["3:1 table-cell: this row has no conductance"]),
        (with("strap,box,panel,0.3,G,"), &["3:21 table-cell: this row has a `value` and a `parameter`"]),
        (with("strap,box,panel,0.3,,2"), &["3:22 table-cell: this row has a `factor` without a `parameter`"]),
        (with("strap,box,panel,,H,2"), &["3:18 unknown-name: unknown name `H`"]),
        (with("strap,box,panel,,G+1,2"), &["3:18 invalid-name: \"G+1\" is no name of a parameter or input"]),
        (with("bolts,box,panel,0.3,,"), &["3:1 duplicate-key: `bolts` is the name of two conductors"]),
        (with("a/b,box,panel,0.3,,"), &["3:1 invalid-name: the name \"a/b\" is not allowed: it holds '/'"]),
        (with("strap,box,panel,0.3"), &["3:1 table-shape: this row has 4 cells, the line of headers has 6"]),
        (with("strap,box,panel,\"0.3,,"), &["3:17 table-shape: this quote is not closed"]),
        ("from,to,vlaue\nbox,plate,1\n".to_owned(), &["1:9 table-column: a table of couplings has no column `vlaue`"]),
        (
            "from,to\nbox,plate\n".to_owned(),
            &["1:1 table-column: the table has neither a column `value` nor one `parameter`"],
        ),
        ("from,value\nbox,1\n".to_owned(), &["1:1 table-column: the table has no column `to`"]),
        ("from,to,value,value\nbox,plate,1,1\n".to_owned(), &["1:15 table-column: the column `value` stands twice"]),
        ("from,to,value [W]\nbox,plate,1\n".to_owned(), &["1:9 wrong-dimension: the unit `W` does not fit here"]),
        (String::new(), &["1:1 table-empty: the file has no line of headers"]),
    ];
    for (table, expected) in cases {
        let mut said = said(table);
        // Without its conductors the quantity `leak` and the group of nodes lose what they name.
        said.retain(|line| !line.contains("element `bolts`") && !line.contains("conductor `bolts`"));
        assert_eq!(said, *expected, "{table}");
    }
}

#[test]
fn a_table_that_is_not_there_is_named_where_it_is_asked_for() {
    let study = with_tables();
    study.edit("model.json", "data/radiations.csv", "data/none.csv");
    let said = study.said("pass-1.json");
    assert!(said.contains("error[file-missing]: the file `data/none.csv` does not exist"), "{said}");
    assert!(said.contains("= note: at $.tabulated.radiations.file"), "{said}");
    study.edit("model.json", "\"file\": \"data/none.csv\"", "\"table\": \"data/none.csv\"");
    let said = study.said("pass-1.json");
    assert!(said.contains("unknown field `table`") && said.contains("missing field `file`"), "{said}");
    let alone = MODEL.replace(CONDUCTORS, TABULATED);
    let mut diagnostics = bmv::document::Diagnostics::new();
    assert!(bmv::study::model::load("model.json", alone.as_bytes(), &mut diagnostics).is_none());
    assert!(diagnostics.render(false, 5).contains("cannot be read without the study's folder"));
}

#[test]
fn thousands_of_couplings_take_linear_time() {
    use std::fmt::Write;
    let (mut nodes, mut rows) = (String::from("\"n0\": {\"boundary\": 290}"), String::from("from,to,value\n"));
    for index in 1..=2000 {
        write!(nodes, ", \"n{index}\": {{\"capacity\": 1}}").expect("memory");
        for other in [1, 3].into_iter().filter(|other| *other <= index) {
            writeln!(rows, "n{},n{index},0.5", index - other).expect("memory");
        }
    }
    let study = Study::empty();
    study.put("data/conductors.csv", rows).put("pass-1.json", "{\"format\": \"bmv-pass/1\", \"parent\": null}");
    let model = format!(
        "{{\"format\": \"bmv-network/1\", \"nodes\": {{{nodes}}}, \"tabulated\": {{\"conductors\": {{\"file\": \
         \"data/conductors.csv\"}}}}}}"
    );
    study.put("model.json", model);
    let pass = study.load();
    assert_eq!(pass.model.elements.len(), 2000 + 1998);
    // Work, not time: each element adds a bounded number of terms, and equal numbers are one.
    assert!(pass.model.graph.len() < 20_000, "{}", pass.model.graph.len());
}
