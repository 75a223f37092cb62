//! Small models and dumps, and malformed ones.

use bmv_decks::esatan::{Form, read_csv, read_text, recognises};
use bmv_decks::{CouplingKind, Deck, DeckError, NodeKind, Value};

const MODEL: &str = "$MODEL CAMERA
$CONSTANTS
$REAL
CLAMP = 0.25;  # clamp to the bench
HALF = CLAMP / 2;
$CONTROL
STEFAN = 5.6686D-8;
TABS = 273.15;
NLOOP = 100;
$MODEL LENS
$NODES
D1 = 'barrel', T = 20.0, C = 12.5, QI = 0.5, ALP = 0.3, EPS = 0.8;
D2 = 'glass', T = 20.0, C = 0.0;
$CONDUCTORS
GL(1,2) = 2 * CLAMP;
$ENDMODEL LENS
$NODES
B99 = 'space', T = -270.0;
X98 = 'nothing';
D5 = 'box', T = 20.0,
   C = 100.0, QI = 3.0;
$CONDUCTORS
GL(LENS:2, 5) = HALF;
GR(LENS:1, 99) = 0.8 * 0.01;
GF(5, LENS:1) = 0.1;
GR(5, 98) = 0.2;
$VARIABLES1
# nothing
$EXECUTION
CALL SLFWBK
$ENDMODEL CAMERA
";

fn read_model(text: &str) -> Result<Deck, Vec<DeckError>> {
    read_text("camera.d", text)
}

#[test]
fn a_text_reads_with_its_submodel() {
    let deck = read_model(MODEL).expect("a model");
    assert_eq!(recognises(MODEL.as_bytes()), Some(Form::Text));
    assert_eq!((deck.title.as_str(), deck.stefan_boltzmann), ("CAMERA", Some(5.6686e-8)));
    let nodes: Vec<&str> = deck.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(nodes, ["LENS.1", "LENS.2", "99", "5"]);
    assert_eq!(deck.nodes[0].kind, NodeKind::Diffusion { capacity: Value::Number(12.5) });
    assert_eq!(deck.nodes[1].kind, NodeKind::Arithmetic);
    assert_eq!(deck.nodes[2].kind, NodeKind::Boundary { temperature: Value::Number(-270.0 + 273.15) });
    let scaled = |factor: f64| Value::Scaled { parameter: "CLAMP".to_owned(), factor };
    let couplings: Vec<(CouplingKind, [usize; 2], Value)> =
        deck.couplings.iter().map(|one| (one.kind, one.between, one.value.clone())).collect();
    let expected = [
        (CouplingKind::Linear, [0, 1], scaled(2.0)),
        (CouplingKind::Linear, [1, 3], scaled(0.5)),
        (CouplingKind::Radiative, [0, 2], Value::Number(0.8 * 0.01)),
        (CouplingKind::OneWay, [3, 0], Value::Number(0.1)),
    ];
    assert_eq!(couplings, expected);
    assert_eq!(deck.parameters.len(), 1);
    assert_eq!(deck.parameters[0].description, "Constant CLAMP: clamp to the bench");
    assert_eq!(
        deck.loads.iter().map(|load| (load.into, load.power.clone())).collect::<Vec<_>>(),
        [(0, Value::Number(0.5)), (3, Value::Number(3.0)),]
    );
    assert!(deck.groups.iter().any(|group| group.name == "LENS" && group.nodes == [0, 1]));
}

#[test]
fn what_esatan_tms_writes_into_every_model_is_passed_over() {
    let plain = read_model(MODEL).expect("a model");
    let text = MODEL.replacen("$MODEL CAMERA", "$MODEL CAMERA, ACDFILE", 1);
    let text = text.replacen("$VARIABLES1", "$INITIAL\n      GENMOR\n$VARIABLES1", 1);
    let deck = read_model(&text).expect("a model");
    assert_eq!((deck.title.as_str(), deck.nodes), ("CAMERA", plain.nodes));
    let errors = read_model(&text.replacen("GENMOR", "GENMOR\n QI5 = 7.0", 1)).expect_err("code");
    assert!(errors[0].line == Some(29) && errors[0].message.contains("$INITIAL"), "{}", errors[0]);
}

#[test]
fn malformed_texts_are_refused_at_their_line() {
    let refused = |from: &str, to: &str, line: usize, words: &str| {
        assert!(MODEL.contains(from), "{from}");
        let errors = read_model(&MODEL.replacen(from, to, 1)).expect_err(to);
        let first = &errors[0];
        assert!(first.line == Some(line) && first.message.contains(words), "{to}: {first}");
    };
    refused("CLAMP = 0.25;", "CLAMP = 0.25", 4, "instead of");
    refused("CLAMP = 0.25;", "CLAMP = ;", 4, "expected a number");
    refused("HALF = CLAMP / 2;", "HALF = CLAMP / 0;", 5, "finite");
    refused("HALF = CLAMP / 2;", "HALF = GRIP / 2;", 5, "not defined");
    refused("HALF = CLAMP / 2;", "CLAMP = 1;", 5, "twice");
    refused("TABS = 273.15;", "TABS = -1;", 8, "not negative");
    refused("D1 = 'barrel'", "D1 = barrel", 12, "label in quotes");
    refused("D1 = 'barrel'", "F1 = 'barrel'", 12, "type F");
    refused("C = 12.5", "C = -12.5", 12, "negative");
    refused("T = 20.0, C = 12.5", "T = -300.0, C = 12.5", 12, "absolute zero");
    refused("C = 12.5", "VOL = 12.5", 12, "not read");
    refused("D2 = 'glass'", "D1 = 'glass'", 13, "twice");
    refused("GL(1,2)", "GL(1,7)", 15, "7 is not defined");
    refused("GL(1,2)", "GV(1,2)", 15, "GL, GR or GF");
    refused("GL(1,2)", "GL(1,1)", 15, "to itself");
    refused("2 * CLAMP", "-2 * CLAMP", 15, "negative");
    refused("$ENDMODEL LENS", "$ENDMODEL LENSE", 16, "ends model LENS");
    refused("B99 = 'space', T = -270.0;", "B99 = 'space';", 18, "no T");
    refused("# nothing", "QI5 = 7.0", 28, "");
    refused("$EXECUTION", "$FLUID", 29, "not read here");
    refused("$MODEL CAMERA", "$NODES", 1, "stands in no model");
    assert!(read_model("").is_err() && read_model("$MODEL A\n$ENDMODEL A\n").is_err());
}

const TITLE: &str = "ESATAN 2017 sp2;  MODEL CAMERA;  TIME 29 May 2020  19:03:59\n \n";

/// Two nodes and the environment, and the heats of two cases.
fn dumps() -> [(String, String); 2] {
    let conductors = format!("{TITLE}TIME,GL:(1;2),GL:(2;1),GR:(1;99999),GR:(99999;1)\n 0.0E+00,0.5,0.5,0.01,0.01\n");
    let temperatures = format!(
        "{TITLE}TIME,T1,T2,T99999,QI1,QI2\n 0.0E+00,20.0,24.0,-270.0,0.1,2.0\n 0.0E+00,10.0,12.0,-270.0,0.1,1.0\n"
    );
    [("cond.csv".to_owned(), conductors), ("temp.csv".to_owned(), temperatures)]
}

#[test]
fn dumps_of_one_model_are_read_together() {
    let deck = read_csv(&dumps()).expect("dumps");
    assert_eq!(recognises(dumps()[0].1.as_bytes()), Some(Form::Csv));
    assert_eq!(deck.couplings.len(), 2, "each pair stands there twice");
    assert_eq!(deck.couplings[0].value, Value::Number(0.5));
    let record = deck.record.expect("a record");
    assert!(record.is_steady && record.times_s.len() == 2);
    assert_eq!(record.temperatures_k[1], [24.0 + 273.15, 12.0 + 273.15]);
    // What changes from case to case is an input, what does not a number.
    assert_eq!((deck.inputs.len(), record.inputs), (1, vec![vec![2.0, 1.0]]));
    assert_eq!(deck.loads[0].power, Value::Number(0.1));
}

#[test]
fn malformed_dumps_are_refused_at_their_line() {
    let refused = |from: &str, to: &str, line: Option<usize>, words: &str| {
        let mut files = dumps();
        assert!(files.iter().any(|(_, text)| text.contains(from)), "{from}");
        files.iter_mut().for_each(|(_, text)| *text = text.replacen(from, to, 1));
        let errors = read_csv(&files).expect_err(to);
        assert!(errors[0].line == line && errors[0].message.contains(words), "{to}: {}", errors[0]);
    };
    refused("0.5,0.5,0.01", "0.5,0.6,0.01", Some(4), "GL:(2;1) is 6e-1");
    refused("0.5,0.5,0.01", "0.5,x,0.01", Some(4), "not a finite number");
    refused("0.5,0.5,0.01", "0.5,0.01", Some(4), "");
    refused("GL:(1;2)", "GL:(1;2", Some(3), "column 2");
    refused("GL:(1;2)", "GL:(2;1)", Some(3), "twice");
    refused("T1,T2,T99999", "T1,T2,T9", Some(3), "which no dump lists");
    refused("ESATAN 2017", "Thermica", Some(1), "expected a line `ESATAN");
    refused("TIME,T1", "T1,TIME", Some(2), "names of columns");
    assert!(read_csv(&[]).is_err());
}
