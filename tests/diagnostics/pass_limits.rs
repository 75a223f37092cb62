//! Files that are no harm: sizes, chains of passes, and what is said of many mistakes.

use bmv::job::load;
use bmv::study::Reader;

use crate::diagnostics::pass_study::Study;

/// Passes of which each takes one parameter's posterior from the pass before it, and the other from the one before that;
/// each has readings of its own.
fn chain(length: usize) -> Study {
    let study = Study::new();
    study.edit(
        "model.json",
        r#""A": {"unit": "m2", "nominal": 0.04}"#,
        r#""A": {"unit": "m2", "nominal": 0.04, "prior": {"uniform": [0.03, 0.05]}}"#,
    );
    for index in 1..=length {
        let posterior = |name: &str, from: usize| {
            format!(
                r#""{name}": {{"prior": {{"posterior": {{"pass": "pass-{from}.json", "job": "t"}}}}, "because": "handed on"}}"#
            )
        };
        let parameters: Vec<String> = [("G", 1), ("A", 2)]
            .into_iter()
            .filter(|(_, back)| index > *back)
            .map(|(name, back)| posterior(name, index - back))
            .collect();
        study.put(
            &format!("pass-{index}.json"),
            format!(
                r#"{{"format": "bmv-pass/1", "parent": null, "parameters": {{{}}}, "jobs": {{"t": {{"calibrate": {{}}}}}},
 "measurements": {{"own": {{"steady": {{"file": "data/own-{index}.csv", "sensors": {{"box": {{"measures": "box", "sigma": 0.25}}}}}}}}}}}}"#,
                parameters.join(", ")
            ),
        );
        study.put(&format!("data/own-{index}.csv"), format!("phase,box [K]\nP1,{}\n", 300 + index));
    }
    study
}

#[test]
fn a_pass_that_several_build_upon_is_read_once() {
    let study = chain(24);
    let pass = load(&study.path("pass-24.json")).unwrap_or_else(|e| panic!("{}", e.render(false, 9)));
    // Reached along 46,368 ways, and each one's readings stand behind the prior once.
    let behind: Vec<usize> = pass.posterior_priors.iter().map(|own| own.behind.len()).collect();
    assert_eq!(behind, [23, 22]);
    let reader = Reader::new(bmv::job::kinds());
    let last = reader.load(&study.path("pass-24.json")).expect("loads");
    let before = reader.load(&study.path("pass-23.json")).expect("loads");
    let upstream = last.upstream.iter().find(|own| own.file == "pass-23.json").expect("used");
    assert!(std::sync::Arc::ptr_eq(upstream, &before));
}

#[test]
fn a_mistake_in_a_pass_that_several_build_upon_is_said_once() {
    let study = chain(12);
    study.edit("pass-1.json", r#""calibrate""#, r#""calibrat""#);
    let Err(diagnostics) = load(&study.path("pass-12.json")) else { panic!("it has a mistake") };
    let plain = diagnostics.plain();
    assert_eq!(plain.iter().filter(|own| own.message.contains("unknown kind `calibrat`")).count(), 1);
    assert_eq!(plain.len(), diagnostics.errors());
    assert!(diagnostics.errors() < 40, "{}", diagnostics.errors());
}

/// On a thread with as much stack as the program's own: frames of an unoptimised build are several times as large.
#[test]
#[ignore = "thorough"]
fn a_chain_of_posteriors_has_an_end_from_wherever_it_is_read() {
    let own = std::thread::Builder::new().stack_size(8 << 20);
    own.spawn(chain_of_posteriors).expect("a thread").join().expect("no assertion fails");
}

fn chain_of_posteriors() {
    let study = chain(53);
    let refused = |reader: &Reader, pass: usize| match reader.load(&study.path(&format!("pass-{pass}.json"))) {
        Ok(_) => false,
        Err(diagnostics) => {
            let plain = diagnostics.plain();
            assert!(plain.iter().any(|own| own.code == "chain-length"), "{}", diagnostics.render(false, 3));
            true
        }
    };
    assert!(!refused(&Reader::new(bmv::job::kinds()), 51));
    assert!(refused(&Reader::new(bmv::job::kinds()), 52));
    let upwards = Reader::new(bmv::job::kinds());
    let ends: Vec<bool> = (1..=53).map(|pass| refused(&upwards, pass)).collect();
    assert_eq!(ends.iter().position(|refused| *refused), Some(51));
    assert!(refused(&Reader::new(bmv::job::kinds()), 53));
}

#[test]
fn a_link_to_the_schema_is_no_part_of_the_study() {
    let plain = Study::new().load();
    let study = Study::new();
    for file in ["model.json", "pass-1.json"] {
        study.edit(file, r#"{"format""#, r#"{"$schema": "../x.schema.json", "format""#);
    }
    for (file, text) in [
        (
            "rules/own.json",
            r#"{"$schema": "r", "format": "bmv-rule/1", "title": "5 K", "margin": {"temperature": {"value": 5, "unit": "K"}}, "source": "x"}"#,
        ),
        (
            "criteria/own.json",
            r#"{"$schema": "c", "format": "bmv-criteria/1", "title": "own", "source": "x", "each": {"value": 3, "unit": "K"}}"#,
        ),
    ] {
        study.put(file, text);
        plain_file(&study, file);
    }
    assert_eq!(study.said("pass-1.json"), "");
    let linked = study.load();
    for file in ["rules/own.json", "criteria/own.json"] {
        std::fs::remove_file(study.path(file)).expect("removed");
    }
    assert_ne!(linked.definition_sha256, plain.definition_sha256, "own rules count");
    assert_eq!(study.load().definition_sha256, plain.definition_sha256);
    study.edit("model.json", r#""../x.schema.json""#, "3");
    assert!(study.said("pass-1.json").contains("a number cannot stand here"));
    for kind in bmv::study::schema::KINDS {
        let schema = bmv::study::schema(kind, &bmv::job::kinds()).expect("a schema");
        let name = schema["$ref"].as_str().and_then(|own| own.strip_prefix("#/$defs/")).expect("a reference");
        assert_eq!(schema["$defs"][name]["properties"]["$schema"]["type"], "string", "{kind}");
    }
}

/// That a file has no errors of its own.
fn plain_file(study: &Study, file: &str) {
    assert!(!study.said("pass-1.json").contains(file), "{}", study.said("pass-1.json"));
}

#[test]
fn the_column_of_an_ignored_sensor_may_be_declared() {
    let study = Study::new();
    let columns =
        r#""ignore": {"P3": "not stabilised", "panel": "torn off"}, "columns": {"panel": {"header": "panel [degC]"}}"#;
    study.edit("pass-1.json", r#""ignore": {"P3": "not stabilised"}"#, columns);
    study.edit("pass-1.json", r#""panel": {"measures": "panel"}"#, r#""panel": {"measures": "panel", "sigma": 0.5}"#);
    assert_eq!(study.said("pass-1.json"), "");
    assert_eq!(study.load().ignored_sensors.len(), 1);
    study.edit("pass-1.json", r#""columns": {"panel""#, r#""columns": {"panle""#);
    assert!(study.said("pass-1.json").contains("unknown sensor or input `panle`"));
}

#[test]
fn celsius_is_not_the_coulomb() {
    let study = Study::new();
    study.edit("model.json", r#""unit": "degC", "nominal": 20, "range": [-40, 60]"#, r#""unit": "C", "nominal": 20"#);
    study.edit("pass-1.json", r#""below": {"value": -30, "unit": "degC"}"#, r#""below": {"value": -30, "unit": "C"}"#);
    study.put(
        "data/balance.csv",
        "phase,T_if [C],Q [W],box [C],panel [degC]\nP1,20,5,24.5,-20.25\nP2,0,5,5.5,1\nP3,40,8,47,1\n",
    );
    // The cause alone is said, where the unit is written, and nothing that follows from it.
    let reports = |places: &[&str]| {
        let said = study.said("pass-1.json");
        assert_eq!((said.matches("error[").count(), said.matches("warning[").count()), (places.len(), 0), "{said}");
        assert_eq!(said.matches("error[coulomb]: `C` is the coulomb").count(), places.len(), "{said}");
        assert_eq!(said.matches("help: write `degC`").count(), places.len(), "{said}");
        for place in places {
            assert!(said.contains(place), "{place}: {said}");
        }
    };
    reports(&["study/model.json:2:", "study/pass-1.json:3:"]);
    study.edit("model.json", r#""unit": "C""#, r#""unit": "degC""#);
    study.edit("pass-1.json", r#""unit": "C""#, r#""unit": "degC""#);
    reports(&["study/data/balance.csv:1:7", "study/data/balance.csv:1:22"]);
    // In a product it stands for a difference; a charge has another name.
    let study = Study::new();
    study.edit("model.json", r#""unit": "W/K""#, r#""unit": "W/C""#);
    let said = study.said("pass-1.json");
    assert!(said.contains("`C` in the unit `W/C` is the coulomb") && said.contains("write `W/K`"), "{said}");
    let study = Study::new();
    study.edit("model.json", r#""parameters": {"#, r#""parameters": {"charge": {"unit": "A s", "nominal": 2}, "#);
    assert!(!study.said("pass-1.json").contains("coulomb"));
}

#[test]
fn a_wrong_cell_is_said_once_however_many_windows_cover_it() {
    let study = Study::new();
    let windows: Vec<String> = (0..12).map(|index| format!(r#""W{index}": {{"file": "data/run.csv"}}"#)).collect();
    study.edit("pass-1.json", r#""file": "data/balance.csv","#, &format!(r#""windows": {{{}}},"#, windows.join(", ")));
    study.edit("pass-1.json", r#", "panel": {"measures": "panel"}"#, "");
    study.edit(
        "pass-1.json",
        r#""held_out": {"phases": ["P2"]}, "ignore": {"P3": "not stabilised"}"#,
        r#""separator": ";""#,
    );
    let rows: String = (0..15).map(|index| format!("{index};5;20,{index}\n")).collect();
    study.put("data/run.csv", format!("time [s];Q [W];box [degC]\n{rows}"));
    let said = study.said("pass-1.json");
    assert_eq!(said.matches("is not a number").count(), 3, "{said}");
    assert!(said.contains("`20,2` is not a number; and 12 more like it in this column"), "{said}");
    assert!(said.contains("a decimal is written with a point: write 20.0"), "{said}");
}

#[test]
fn a_file_of_the_study_s_own_that_cannot_be_read_is_not_passed_over() {
    for folder in ["rules", "criteria", "effects"] {
        let study = Study::new();
        std::fs::create_dir_all(study.path(&format!("{folder}/own.json"))).expect("made");
        let said = study.said("pass-1.json");
        assert!(said.contains(&format!("`{folder}/own.json` cannot be read: it is no file")), "{said}");
    }
}

#[test]
fn a_table_larger_than_is_read_is_refused_by_its_size() {
    let study = Study::new();
    let file = std::fs::File::create(study.path("data/balance.csv")).expect("made");
    file.set_len(6 << 30).expect("sized");
    let said = study.said("pass-1.json");
    assert!(said.starts_with("error[file-size]: the file `data/balance.csv` has 6442450944 bytes; at most"), "{said}");
    assert!(said.contains("study/pass-1.json:5:50"), "{said}");
}
