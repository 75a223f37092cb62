//! Models of other tools: what a deck becomes, and whether what the other tool computed balances there.

use std::fs;
use std::path::Path;

use bmv::import::{Closure, ImportedStudy, closure, import};
use bmv_decks::{
    Coupling, CouplingKind, Deck, Group, Input, Load, Node, NodeKind, Note, Parameter, Record, Table, Value,
};
use serde_json::Value as Json;

use super::studies::{bmv, code, plate, printed, text};

fn node(name: &str, kind: NodeKind) -> Node {
    Node { name: name.to_owned(), label: None, kind, initial_temperature_k: None }
}

fn store(name: &str, capacity: f64) -> Node {
    node(name, NodeKind::Diffusion { capacity: Value::Number(capacity) })
}

fn arithmetic(name: &str) -> Node {
    node(name, NodeKind::Arithmetic)
}

fn boundary(name: &str, kelvin: f64) -> Node {
    node(name, NodeKind::Boundary { temperature: Value::Number(kelvin) })
}

fn coupling(name: &str, kind: CouplingKind, between: [usize; 2], value: Value) -> Coupling {
    Coupling { name: name.to_owned(), kind, between, value }
}

fn load(name: &str, into: usize, power: Value) -> Load {
    Load { name: name.to_owned(), into, power }
}

/// A steady result with one row.
fn steady(temperatures_k: &[f64], inputs: &[f64]) -> Option<Record> {
    Some(Record {
        times_s: vec![0.0],
        is_steady: true,
        inputs: inputs.iter().map(|value| vec![*value]).collect(),
        held: false,
        temperatures_k: temperatures_k.iter().map(|value| vec![*value]).collect(),
    })
}

/// The deck as a study in a new folder, loaded, with the closure of its record.
fn imported(deck: &Deck) -> (tempfile::TempDir, ImportedStudy, Option<Closure>) {
    let root = tempfile::tempdir().unwrap();
    let study = import(deck, &["deck.inp".to_owned()]).unwrap();
    study.write(&root.path().join("study")).unwrap();
    let pass = bmv::job::load(&root.path().join("study/pass-1.json"));
    let pass = pass.unwrap_or_else(|diagnostics| panic!("{}", diagnostics.render(false, 20)));
    let closure = closure::closure(&study, &pass).unwrap();
    (root, study, closure)
}

/// The mean deviation of a sensor from the delivered model, K.
fn deviation(root: &Path, sensor: &str) -> f64 {
    let output = printed(root, &["compare", "study/pass-1.json", "--json"]);
    let result: Json = serde_json::from_str(&output).unwrap();
    result["sensors"][sensor]["delivered"]["mean"].as_f64().unwrap_or_else(|| panic!("{output}"))
}

/// The study's model as JSON.
fn model_of(study: &ImportedStudy) -> Json {
    let (_, text) = study.files.iter().find(|(path, _)| *path == "model.json").unwrap();
    serde_json::from_str(text).unwrap()
}

/// 10 W go from `A.1` over 0.5 W/K to `A.2` and over 2 x 0.5 W/K to a sink at 290 K: 300 K and 320 K.
fn chain() -> Deck {
    Deck {
        title: "Chain".into(),
        tool: "Example 1".into(),
        inputs: vec![Input { name: "Q".into(), unit: "W".into(), nominal: 8.0, description: "board".into() }],
        parameters: vec![
            Parameter { name: "G".into(), unit: "W/K".into(), nominal: 0.5, description: "bolt".into() },
            Parameter { name: "unused".into(), unit: "1".into(), nominal: 3.0, description: String::new() },
        ],
        nodes: vec![store("A.1", 100.0), arithmetic("A.2"), boundary("sink", 290.0)],
        couplings: vec![
            coupling("A.1", CouplingKind::Linear, [0, 1], Value::Number(0.5)),
            coupling("A.2", CouplingKind::Linear, [1, 2], Value::Scaled { parameter: "G".into(), factor: 2.0 }),
        ],
        loads: vec![load("board", 0, Value::Expression("Q".into()))],
        groups: vec![Group { name: "A".into(), nodes: vec![0, 1, 2], couplings: vec![] }],
        record: steady(&[320.0, 300.0, 290.0], &[10.0]),
        notes: vec![Note::at("deck.inp:3", "A.2 has no material")],
        ..Deck::default()
    }
}

#[test]
fn a_deck_becomes_a_study_that_predicts_what_is_computed_by_hand() {
    let (root, study, closure) = imported(&chain());
    assert_eq!(text(&bmv(root.path(), &["plan", "study"]).stderr), "", "without a warning");
    // The solver closes to 1e-9 W, over conductances of at least 0.5 W/K in a row.
    for sensor in ["A.1", "A.2"] {
        assert!(deviation(root.path(), sensor).abs() < 1e-8, "{sensor}");
    }
    let closure = closure.unwrap();
    assert_eq!((closure.closing(), closure.nodes.len(), closure.worst_boundary.clone()), (2, 2, None));
    let model = model_of(&study);
    assert_eq!(model["parameters"]["G"]["prior"]["lognormal"]["factor"], 2);
    assert_eq!(model["parameters"]["G"]["source"], "imported, not elicited");
    assert!(model["parameters"]["unused"].is_null());
    assert_eq!(model["groups"]["A"]["nodes"], serde_json::json!({"A.1": 1, "A.2": 1}), "no boundary among them");
    assert!(model["description"].as_str().unwrap().contains("deck.inp:3: A.2 has no material."));
    insta::assert_snapshot!(study.summary.in_words(), @r"
    Read from deck.inp: `Chain`, by Example 1.
      Nodes: 1 diffusion node, 1 arithmetic node, 1 boundary node.
      Heat: 2 conductors, 1 load.
      Values: 1 input, 1 parameter, 1 group.
      Left out: 1 parameter of the deck that nothing uses.
      Record: 1 row with temperatures of 2 nodes.
    Notes:
      - deck.inp:3: A.2 has no material.
    ");
    // What the other tool computed decides: a kelvin more there is a kelvin of deviation here.
    let mut other = chain();
    other.record = steady(&[321.0, 300.0, 290.0], &[10.0]);
    let (root, _, _) = imported(&other);
    assert!((deviation(root.path(), "A.1") - 1.0).abs() < 1e-8);
}

/// A board at 310 K that radiates 0.02 m2 to space at 0 K, with 0.3 W/K to a bracket at 290 K and 0.6 W/K from there to a
/// wall at 280 K. The deck's Stefan-Boltzmann constant is 5.67e-8, and its power is what balances the board with that.
fn radiating() -> Deck {
    let power = 0.3 * 20.0 + 5.67e-8 * 0.02 * 310.0 * 310.0 * 310.0 * 310.0;
    Deck {
        title: "Board".into(),
        tool: "Example".into(),
        stefan_boltzmann: Some(5.67e-8),
        nodes: vec![store("board", 50.0), arithmetic("bracket"), boundary("wall", 280.0), boundary("space", 0.0)],
        couplings: vec![
            coupling("1", CouplingKind::Linear, [0, 1], Value::Number(0.3)),
            coupling("2", CouplingKind::Linear, [1, 2], Value::Number(0.6)),
            coupling("1R", CouplingKind::Radiative, [0, 3], Value::Number(0.02)),
        ],
        loads: vec![load("board", 0, Value::Number(power))],
        record: steady(&[310.0, 290.0, 280.0, 0.0], &[]),
        ..Deck::default()
    }
}

#[test]
fn a_record_closes_with_the_decks_own_radiation_constant() {
    let (_root, study, closure) = imported(&radiating());
    let closure = closure.unwrap();
    // Terms of at most 17 W in 64 bits: rounding leaves less than 1e-13 W.
    assert!(closure.nodes.iter().all(|node| node.imbalance_w.abs() < 1e-9), "{closure:?}");
    assert_eq!(closure.nodes.len(), 2);
    let model = model_of(&study);
    let source = model["source"].as_str().unwrap();
    assert!(source.contains("5.67e-8") && source.contains("5.670374419e-8"), "{source}");
    let mut other = radiating();
    other.stefan_boltzmann = None;
    let (_root, _, closure) = imported(&other);
    // The same areas with the constant of 2018.
    let expected = -(5.670374419e-8 - 5.67e-8) * 0.02 * 310.0 * 310.0 * 310.0 * 310.0;
    let board = closure.unwrap().nodes.into_iter().find(|node| node.node == "board").unwrap();
    assert!((board.imbalance_w - expected).abs() < 1e-9, "{} {expected}", board.imbalance_w);
}

#[test]
fn what_is_left_out_shows_at_its_node_in_watts_and_kelvin() {
    let mut deck = radiating();
    deck.couplings.remove(1);
    deck.notes.push(Note::new("the fluid lump beside bracket is left out").of_node("bracket"));
    let (_root, _, closure) = imported(&deck);
    let closure = closure.unwrap();
    let worst = &closure.nodes[0];
    // 6 W arrive over 0.3 W/K and have nowhere to go.
    assert_eq!(worst.node, "bracket");
    assert!((worst.imbalance_w - 6.0).abs() < 1e-9 && (worst.imbalance_k.unwrap() - 20.0).abs() < 1e-8, "{worst:?}");
    assert_eq!(worst.hint.as_deref(), Some("the fluid lump beside bracket is left out"));
    assert_eq!(closure.closing(), 1);
    assert_eq!(closure.table()[1][..3], ["bracket", "+6.000e0", "+2.000e1"]);
    deck.notes.clear();
    deck.couplings.insert(1, coupling("2", CouplingKind::Linear, [1, 2], Value::Number(0.6)));
    deck.loads.clear();
    let (_root, _, closure) = imported(&deck);
    let board = closure.unwrap().nodes.remove(0);
    assert!(board.node == "board" && board.imbalance_w < 0.0, "{board:?}");
    assert!(board.hint.unwrap().starts_with("heat that comes in"));
}

#[test]
fn a_node_without_a_temperature_leaves_its_neighbours_unjudged() {
    let mut deck = radiating();
    deck.record.as_mut().unwrap().temperatures_k[1].clear();
    let (root, _, closure) = imported(&deck);
    let closure = closure.unwrap();
    assert_eq!((closure.nodes.len(), closure.not_judged.len()), (0, 2));
    assert!(deviation(root.path(), "board").abs() < 1e-8);
}

#[test]
fn a_one_way_coupling_heats_what_lies_downstream_alone() {
    let one_way = |name: &str, between| coupling(name, CouplingKind::OneWay, between, Value::Number(2.0));
    // 2 W/K come in at 280 K. A wall with 10 W gives them to the first lump, which is 5 K warmer, and stays so
    // whatever the second one takes; there 4 W come in.
    let deck = Deck {
        title: "Loop".into(),
        tool: "Example".into(),
        nodes: vec![
            boundary("inlet", 280.0),
            arithmetic("lump 1"),
            arithmetic("lump 2"),
            store("wall", 10.0),
            boundary("drain", 1.0),
        ],
        couplings: vec![
            one_way("F1", [0, 1]),
            one_way("F2", [1, 2]),
            one_way("F3", [2, 4]),
            coupling("film", CouplingKind::Linear, [3, 1], Value::Number(1.0)),
        ],
        loads: vec![load("wall", 3, Value::Number(10.0)), load("pump", 2, Value::Number(4.0))],
        record: steady(&[280.0, 285.0, 287.0, 295.0, 1.0], &[]),
        ..Deck::default()
    };
    let (root, study, closure) = imported(&deck);
    for sensor in ["lump 1", "lump 2", "wall"] {
        assert!(deviation(root.path(), sensor).abs() < 1e-8, "{sensor}");
    }
    let closure = closure.unwrap();
    // Terms of at most 600 W in 64 bits.
    assert!(closure.nodes.iter().all(|node| node.imbalance_w.abs() < 1e-9), "{closure:?}");
    let model = model_of(&study);
    assert_eq!(model["flows"]["F2"]["one_way"], true);
    assert!(model["conductors"]["F1"].is_object(), "out of a boundary nothing is missed");
    assert_eq!((study.summary.counts.flows, study.summary.counts.couplings_left_out), (1, 1));
}

#[test]
fn a_large_deck_stands_in_tables_and_wild_names_are_tamed() {
    let mut deck = chain();
    deck.record = None;
    deck.inputs[0].name = "T".into();
    deck.loads[0].power = Value::Expression("T * interp(curve, T)".into());
    deck.tables = vec![Table { name: "curve".into(), x: vec![0.0, 10.0], y: vec![1.0, 1.0] }];
    for index in 0..60 {
        deck.nodes.push(arithmetic(&format!("B/{index}")));
        let value = if index == 7 { Value::Number(-0.25) } else { Value::Number(1.0) };
        deck.couplings.push(coupling(&format!("GL({index},\"2\")"), CouplingKind::Linear, [3 + index, 0], value));
        deck.couplings.push(coupling(
            &format!("extra:{index}"),
            CouplingKind::Linear,
            [3 + index, 2],
            Value::Number(1.0),
        ));
    }
    deck.nodes.push(arithmetic("lonely"));
    deck.couplings.push(coupling("loop", CouplingKind::Linear, [0, 0], Value::Number(1.0)));
    let group = Group { name: "ties".into(), nodes: vec![], couplings: vec![1, 2, 16] };
    deck.groups.push(group);
    let (root, study, closure) = imported(&deck);
    assert!(closure.is_none());
    let names: Vec<&str> = study.files.iter().map(|(path, _)| *path).collect();
    assert_eq!(names, ["data/conductors.csv", "model.json", "pass-1.json"]);
    assert!(
        study.files[0]
            .1
            .starts_with("name,from,to,value [W/K],parameter,factor\nA.1,A.1,A.2,0.5,,\nA.2,A.2,sink,,G,2\n")
    );
    assert!(study.files[0].1.contains("\n\"GL(0,\"\"2\"\")\",B_0,A.1,1,,\n"));
    let notes = study.summary.notes.join("\n");
    for note in [
        "the node `B/0` is called `B_0`",
        "`T` is called `T_0`",
        "the node `lonely` is left out: nothing leads to it",
        "60 couplings have names with `_` for what the study format does not allow in names",
        "1 couplings of a node with itself are left out",
        "1 couplings with a value below 0 are flows",
    ] {
        assert!(notes.contains(note), "{note}: {notes}");
    }
    let model = model_of(&study);
    assert_eq!(model["loads"]["board"]["power"], "T_0 * interp(curve, T_0)");
    assert_eq!(model["flows"]["GL(7,\"2\")"]["heat"], "(-0.25) * (Ta - Tb)");
    assert_eq!(
        model["groups"]["ties"]["conductors"],
        serde_json::json!(["A.2", "GL(0,\"2\")"]),
        "flows are in no group"
    );
    for verb in ["plan", "run"] {
        printed(root.path(), &[verb, "study"]);
    }
}

#[test]
fn a_transient_begins_where_the_record_does_and_closes_with_its_slopes() {
    // 100 J/K over 0.5 W/K: a time constant of 200 s towards 290 K; the shell is half-way to the wall.
    let instants: Vec<f64> = (0..=50).map(|row| 10.0 * f64::from(row)).collect();
    let body: Vec<f64> = instants.iter().map(|time| 290.0 + 20.0 * libm::exp(-time / 200.0)).collect();
    let shell: Vec<f64> = body.iter().map(|body| 0.5 * (body + 290.0)).collect();
    let deck = Deck {
        title: "Decay".into(),
        tool: "Example".into(),
        nodes: vec![store("body", 100.0), arithmetic("shell"), boundary("wall", 290.0)],
        couplings: vec![
            coupling("1", CouplingKind::Linear, [0, 1], Value::Number(1.0)),
            coupling("2", CouplingKind::Linear, [1, 2], Value::Number(1.0)),
        ],
        record: Some(Record {
            times_s: instants,
            temperatures_k: vec![body, shell, vec![290.0; 51]],
            ..Record::default()
        }),
        ..Deck::default()
    };
    let (root, _, closure) = imported(&deck);
    // A step errs by at most 3e-5 K + 3e-7 of the temperature, 1.2e-4 K, and what errs decays with the 200 s.
    for sensor in ["body", "shell"] {
        assert!(deviation(root.path(), sensor).abs() < 1e-3, "{sensor}");
    }
    let closure = closure.unwrap();
    let of = |name: &str| closure.nodes.iter().find(|entry| entry.node == name).unwrap();
    let (shell, body) = (of("shell"), of("body"));
    assert!(shell.allowed_w == 0.0 && shell.imbalance_w.abs() < 1e-9, "{shell:?}");
    // The parabola's slope errs by h^2/6 of the third derivative, 20 K / (200 s)^3: 4.2e-5 K/s, of which 100 J/K make
    // 4.2e-3 W at the first row, and less later. Slopes before and behind a row differ by h times the second derivative,
    // 20 K / (200 s)^2: half of it is 2.5e-3 K/s, which allows for more.
    assert!(body.imbalance_w.abs() < 4.3e-3 && body.allowed_w > body.imbalance_w.abs(), "{body:?}");
    assert!(body.closes(0.0) && closure.closing() == 2);
}

#[test]
fn a_deck_that_does_not_hold_together_is_refused() {
    let refusal = |change: &dyn Fn(&mut Deck)| {
        let mut deck = chain();
        change(&mut deck);
        import(&deck, &[]).expect_err("refused").to_string()
    };
    type Case<'a> = (&'a dyn Fn(&mut Deck), &'a str);
    let cases: [Case; 7] = [
        (&|deck| deck.couplings[0].between[1] = 9, "the coupling `A.1` names node 9 of 3"),
        (&|deck| deck.groups[0].couplings.push(5), "the group `A` names coupling 5 of 2"),
        (&|deck| deck.couplings[0].value = Value::Number(f64::NAN), "the coupling `A.1` is NaN"),
        (&|deck| deck.parameters[1].name = "Q".into(), "are called `Q`"),
        (&|deck| deck.record.as_mut().unwrap().temperatures_k.truncate(2), "values of 2 nodes, the deck has 3"),
        (&|deck| deck.record.as_mut().unwrap().inputs[0].push(1.0), "1 rows, and 2 values"),
        (&|deck| deck.nodes.clear(), "it has no nodes"),
    ];
    for (change, expected) in cases {
        let said = refusal(change);
        assert!(said.starts_with("the deck `Chain` cannot be imported: ") && said.contains(expected), "{said}");
    }
}

#[test]
fn nothing_is_overwritten() {
    let root = plate();
    fs::write(root.path().join("notes.txt"), "no deck").unwrap();
    let before = fs::read(root.path().join("plate/model.json")).unwrap();
    let output = bmv(root.path(), &["import", "notes.txt", "--into", "plate"]);
    assert_eq!(code(&output), 2);
    assert!(
        text(&output.stderr).contains("`plate` is not empty, and an import replaces nothing"),
        "{}",
        text(&output.stderr)
    );
    let study = import(&chain(), &[]).unwrap();
    assert!(study.write(&root.path().join("plate")).unwrap_err().to_string().contains("is not empty"));
    assert_eq!(fs::read(root.path().join("plate/model.json")).unwrap(), before);
    let output = bmv(root.path(), &["import", "notes.txt", "--into", "fresh"]);
    assert_eq!(code(&output), 2);
    assert!(text(&output.stderr).contains("no reader recognises `notes.txt`"), "{}", text(&output.stderr));
    assert!(!root.path().join("fresh").exists(), "no folder is made in vain");
}

#[test]
fn a_loggers_files_become_a_table_and_the_next_pass() {
    let root = plate();
    let log = "Logger 7; bench 2\n\nZeit;Kanal 1;Q;T wall;Kanal 9\n;\u{B0}C;W;\u{B0}C;\u{B0}C\n\
               17.05.2024 12:00:00;43,0;10;20;9,9E+37\n17.05.2024 12:10:00;43,1;10;20;9,9E+37\n";
    fs::write(root.path().join("log.csv"), log).unwrap();
    fs::write(root.path().join("map.csv"), "channel,name,measures\nKanal 1,TC1,plate\n").unwrap();
    let arguments = ["import", "csv", "log.csv", "--into", "plate", "--channels", "map.csv"];
    let said = printed(root.path(), &arguments);
    assert!(said.contains("1 sensor, 2 inputs") && said.contains("`Kanal 9` has no reading: left out"), "{said}");
    assert!(said.ends_with("now look through it, then try\nbmv compare plate/pass-2.json\n"), "{said}");
    let clean = fs::read_to_string(root.path().join("plate/data/log.csv")).unwrap();
    assert_eq!(clean, "time [s],TC1 [degC],Q [W],T_wall [degC]\n0,43,10,20\n600,43.1,10,20\n");
    let pass: Json = serde_json::from_str(&fs::read_to_string(root.path().join("plate/pass-2.json")).unwrap()).unwrap();
    assert_eq!(pass["measurements"]["log"]["transient"]["sensors"]["TC1"]["measures"], "plate");
    // The same again changes nothing; other content is overwritten where the user says so alone, and the pass of the first
    // try is no parent of its successor. What is not understood is said at its place.
    let again = printed(root.path(), &arguments);
    assert!(again.contains("Unchanged: plate/data/log.csv\nUnchanged: plate/pass-2.json; now"), "{again}");
    fs::write(root.path().join("log.csv"), log.replace("43,1", "43,2")).unwrap();
    let refused = bmv(root.path(), &arguments);
    let said = text(&refused.stderr);
    assert!(code(&refused) == 2 && said.contains("`plate/data/log.csv` is there already with other content"), "{said}");
    let forced = [&arguments[..], &["--force", "--hold", "Q", "--linear", "T wall"]].concat();
    let said = printed(root.path(), &forced);
    assert!(said.contains("input Q is held from row to row: as --hold says"), "{said}");
    assert!(said.contains("Replaced plate/data/log.csv\nReplaced plate/pass-2.json; now"), "{said}");
    assert!(!root.path().join("plate/pass-3.json").exists());
    let wrong = bmv(root.path(), &[&arguments[..], &["--hold", "P"]].concat());
    assert!(
        code(&wrong) == 2 && text(&wrong.stderr).contains("`P` is no input with a channel"),
        "{}",
        text(&wrong.stderr)
    );
    fs::write(root.path().join("log.csv"), log.replace("43,1", "4E,1")).unwrap();
    let wrong = bmv(root.path(), &["import", "csv", "log.csv", "--into", "plate", "--name", "b"]);
    assert!(code(&wrong) == 2 && text(&wrong.stderr).contains("log.csv:6:21"), "{}", text(&wrong.stderr));
    assert!(!root.path().join("plate/data/b.csv").exists());
}

#[test]
fn without_a_map_the_next_step_is_a_map_to_begin_with() {
    let root = plate();
    let log = "time [s];TC01 Plate probe [degC];Power supply [W];T wall [degC]\n0;43,0;10;20\n600;43,1;10;20\n1200;43,2;10;20\n";
    fs::write(root.path().join("log.csv"), log).unwrap();
    let said = printed(root.path(), &["import", "csv", "log.csv", "--into", "plate"]);
    assert!(said.contains("Nothing was written: no channel is named like a node or a quantity."), "{said}");
    assert!(!root.path().join("plate/data/log.csv").exists() && !root.path().join("plate/pass-2.json").exists());
    let command = "bmv import csv log.csv --into plate --channels channels.csv\n";
    assert!(said.contains(command) && said.contains("without a channel so far: inputs `Q [W]`"), "{said}");
    let map = &said[said.find("channel,name,unit,measures").unwrap_or_else(|| panic!("{said}"))..];
    assert!(map.contains("TC01 Plate probe,TC01 Plate probe,degC,plate\n"), "{said}");
    // As it is proposed, with the one line mended that could not be guessed.
    fs::write(root.path().join("channels.csv"), map.replace("Power supply,Power supply,W,", "Power supply,Q,W,"))
        .unwrap();
    let said = printed(root.path(), &["import", "csv", "log.csv", "--into", "plate", "--channels", "channels.csv"]);
    assert!(said.contains("1 sensor, 2 inputs") && said.contains("Made plate/pass-2.json"), "{said}");
    assert!(!said.contains("channel,name,unit,measures"), "the map is there: {said}");
}

/// Channels that are named like what they are need no line of a map, and the map goes before all else: one next step.
#[test]
fn a_map_of_the_odd_channels_is_the_one_next_step() {
    let root = plate();
    let log = "time;plate [degC];Power supply [W];T wall [degC]\n14.03.2026 06:00:00;43,0;10;20\n14.03.2026 06:10:00;43,1;10;20\n\
               14.03.2026 06:20:00;43,2;10;20\n";
    fs::write(root.path().join("log.csv"), log).unwrap();
    let said = printed(root.path(), &["import", "csv", "log.csv", "--into", "plate"]);
    assert!(said.contains("Made plate/pass-2.json, without the channels that are named like nothing"), "{said}");
    assert!(!said.contains("bmv compare"), "{said}");
    assert!(said.contains("(the channels that are named like what they are need no line)"), "{said}");
    let map = &said[said.find("channel,name,unit,measures").unwrap_or_else(|| panic!("{said}"))..];
    assert_eq!(map.trim_end(), "channel,name,unit,measures\nPower supply,Power supply,W,", "{said}");
    fs::write(root.path().join("channels.csv"), map.replace(",Power supply,W,", ",Q,W,")).unwrap();
    let command = ["import", "csv", "log.csv", "--into", "plate", "--channels", "channels.csv", "--force"];
    let said = printed(root.path(), &command);
    assert!(said.contains("1 sensor, 2 inputs") && said.contains("try\nbmv compare plate/pass-2.json\n"), "{said}");
    // When the record began stays with it.
    let pass: Json = serde_json::from_str(&fs::read_to_string(root.path().join("plate/pass-2.json")).unwrap()).unwrap();
    assert_eq!(pass["measurements"]["log"]["transient"]["time_zero"], "2026-03-14T06:00:00");
    let wrong = pass.to_string().replace("2026-03-14T06:00:00", "last Saturday");
    fs::write(root.path().join("plate/pass-2.json"), wrong).unwrap();
    let refused = bmv(root.path(), &["plan", "plate"]);
    assert!(text(&refused.stderr).contains("`last Saturday` is no date and time"), "{}", text(&refused.stderr));
}

/// The model as delivered and as tuned without new physics stand side by side where the log has rows enough; whether it had is
/// no part of what tells an import's pass from one of the user's own.
#[test]
fn the_pass_of_a_log_is_tuned_where_its_rows_are_enough() {
    let root = plate();
    let rows = |count: usize| -> String {
        let row = |row: usize| format!("{},{:.2},10,20\n", 600 * row, 43.0 + 0.1 * (row % 3) as f64);
        format!("time [s],plate [degC],Q [W],T_wall [degC]\n{}", (0..count).map(row).collect::<String>())
    };
    let jobs = |count: usize| {
        fs::write(root.path().join("log.csv"), rows(count)).unwrap();
        printed(root.path(), &["import", "csv", "log.csv", "--into", "plate", "--force"]);
        assert!(!root.path().join("plate/pass-3.json").exists(), "the pass of {count} rows takes the other's place");
        let pass = fs::read_to_string(root.path().join("plate/pass-2.json")).unwrap();
        let pass: Json = serde_json::from_str(&pass).unwrap();
        pass["jobs"].clone()
    };
    let many = jobs(40);
    assert_eq!(many["tuned"]["calibrate"]["data"], serde_json::json!(["log"]), "{many}");
    assert_eq!(many["tuned"]["calibrate"]["sampler"], "independence-metropolis", "{many}");
    let few = jobs(2);
    assert!(few["tuned"].is_null() && few["missing"]["diagnose"].is_object(), "{few}");
    assert_eq!(jobs(40), many);
    // The error before any effect, by a calibration that no later pass has to make up for.
    let history: Json = serde_json::from_slice(&bmv(root.path(), &["history", "plate", "--json"]).stdout).unwrap();
    let pass = &history["passes"][1];
    assert_eq!((&pass["pass"], &pass["calibration"]), (&"pass-2.json".into(), &"tuned".into()), "{pass}");
    let [delivered, tuned] = ["delivered", "tuned"].map(|state| pass["rmse_k"][state]["train"].as_f64().unwrap());
    assert!(delivered > 3.0 && tuned < 0.1, "{pass}");
}
