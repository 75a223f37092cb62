//! A deck of two boards on a frame, its malformed variants, and public decks where a folder of them is given.

mod laws;

use bmv_decks::sinda::{SindaFile, read, read_result, recognises};
use bmv_decks::{CouplingKind, Deck, NodeKind, Value};

const INP: &str = "C a case
HEADER OPTIONS DATA
TITLE Two boards
HEADER CONTROL DATA, GLOBAL
    abszro = -273.15
    sigma = 5.6704E-8
    UID = SI
HEADER OPERATION DATA
BUILD ALL
      CALL STEADY
INSERT case.cc
INSERT C0A0.k_in
";

const CC: &str = "HEADER OPTIONS
C    SINDA Data generated with Thermal Desktop 6.2 Patch 15
C    TDUNITS,   Energy     = J
C    TDUNITS,   Temp       = C
HEADER NODE DATA, BOARD
            1,    20.,    10.5  $ chip
            2,    20.,    30.
            GEN 3, 2, 1, 20., 4.0
HEADER CONDUCTOR DATA, BOARD
            1,    BOARD.1,    BOARD.2,    0.5
C Contact - Face Contactor-Clamp[BOARD][1]::4F
            2,    BOARD.2,    FRAME.1,    0.15
            3,    BOARD.2,    FRAME.2,    0.05
            4,    1,    3,    2.0D-1
            5,    3,    4,    2*0.1
HEADER VARIABLES 0, BOARD
C Heat Load-Chip[BOARD]::51
      BOARD.Q1 = BOARD.Q1 + 1.5
      BOARD.Q3 = BOARD.Q3 + 0.5
HEADER NODE DATA, FRAME
            1,    20.,    -1.0
            2,    20.,    100.
            -3,    -10.,    -1.0
HEADER CONDUCTOR DATA, FRAME
            1,    FRAME.1,    FRAME.2,    1.0
            2,    FRAME.2,    FRAME.3,    0.25
HEADER NODE DATA, SPACE
            -1,    -270.,    -1.0
HEADER SUBROUTINE
F     SUBROUTINE TDHTR
F     RETURN
F     END
";

const K: &str = "HEADER CONDUCTOR DATA, C0A0
PSTOP
C    cond_id    node_1     node_2     Area*e*Bij $  Bij   Bji
           -1,     BOARD.4,        SPACE.1,  0.01   $    0.9
           -2,     FRAME.2,        SPACE.1,  0.02   $    0.8, 0.2
PSTART
";

fn files<'a>(inp: &'a str, cc: &'a str, k: &'a str) -> [SindaFile<'a>; 3] {
    [
        SindaFile { name: "runs/CASE.INP", text: inp },
        SindaFile { name: "runs/case.cc", text: cc },
        SindaFile { name: "runs/C0A0.k", text: k },
    ]
}

/// A value at the deck's own parameters and inputs.
fn number(deck: &Deck, value: &Value) -> f64 {
    match value {
        Value::Number(number) => *number,
        Value::Scaled { parameter, factor } => {
            factor * deck.parameters.iter().find(|own| own.name == *parameter).expect("a parameter").nominal
        }
        Value::Expression(text) => {
            let (share, input) = text.split_once(" * ").expect("a share of an input");
            let input = deck.inputs.iter().find(|own| own.name == input).expect("an input");
            share.parse::<f64>().expect("a number") * input.nominal
        }
    }
}

/// Net heat into each node, in W.
fn net_heat_w(deck: &Deck, kelvin: &[f64]) -> Vec<f64> {
    let mut net = vec![0.0; deck.nodes.len()];
    for load in &deck.loads {
        net[load.into] += number(deck, &load.power);
    }
    for coupling in &deck.couplings {
        let [a, b] = coupling.between;
        let difference = match coupling.kind {
            CouplingKind::Radiative => {
                deck.stefan_boltzmann.unwrap() * (libm::pow(kelvin[a], 4.0) - libm::pow(kelvin[b], 4.0))
            }
            CouplingKind::Linear | CouplingKind::OneWay => kelvin[a] - kelvin[b],
        };
        let heat = number(deck, &coupling.value) * difference;
        net[a] -= heat;
        net[b] += heat;
    }
    net
}

/// The steady state by underrelaxed steps towards each node's own balance: slow, and independent of any solver.
fn steady(deck: &Deck) -> Vec<f64> {
    let mut kelvin: Vec<f64> = deck.nodes.iter().map(|node| node.initial_temperature_k.unwrap()).collect();
    for _ in 0..20_000 {
        let net = net_heat_w(deck, &kelvin);
        for (node, entry) in deck.nodes.iter().enumerate() {
            if !matches!(entry.kind, NodeKind::Boundary { .. }) {
                kelvin[node] += 0.3 * net[node];
            }
        }
    }
    kelvin
}

/// What SINDA/FLUINT prints of a steady state, with a state before it that is not one.
fn printed(deck: &Deck, kelvin: &[f64]) -> String {
    let mut text = " SYSTEMS IMPROVED NUMERICAL DIFFERENCING ANALYZER\n MODEL = SINDA   Two boards\n  \n".to_owned();
    text.push_str("  SUBMODEL NAME = BOARD\n   T       1=  999.00\n");
    for submodel in ["BOARD", "FRAME", "SPACE"] {
        text.push_str(&format!(" MODEL = SINDA   Two boards\n   STEADY\n\n  SUBMODEL NAME = {submodel}\n"));
        text.push_str(
            "         MAX DIFF DELTA T PER ITER     DRLXCC(CHIP               2)= 5.2E-05 VS. DRLXCA= 1.0E-03\n",
        );
        for (node, kelvin) in deck.nodes.iter().zip(kelvin) {
            if let Some(number) = node.name.strip_prefix(&format!("{submodel}.")) {
                text.push_str(&format!("   T {number:>7}={:>8.2}    ", kelvin - 273.15));
            }
        }
        text.push('\n');
    }
    text
}

#[test]
fn a_deck_reads_and_its_printed_result_closes() {
    let deck = read(&files(INP, CC, K)).expect("a deck");
    assert_eq!((deck.title.as_str(), deck.tool.as_str()), ("Two boards", "Thermal Desktop 6.2 Patch 15"));
    assert_eq!(deck.stefan_boltzmann, Some(5.6704e-8));
    let names: Vec<&str> = deck.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["BOARD.1", "BOARD.2", "BOARD.3", "BOARD.4", "FRAME.1", "FRAME.2", "FRAME.3", "SPACE.1"]);
    assert_eq!(deck.nodes[0].kind, NodeKind::Diffusion { capacity: Value::Number(10.5) });
    assert_eq!(deck.nodes[3].kind, NodeKind::Diffusion { capacity: Value::Number(4.0) });
    assert_eq!(deck.nodes[4].kind, NodeKind::Arithmetic);
    assert_eq!(deck.nodes[6].kind, NodeKind::Boundary { temperature: Value::Number(-10.0 + 273.15) });
    let values: Vec<f64> = deck.couplings.iter().map(|coupling| number(&deck, &coupling.value)).collect();
    assert_eq!(values, [0.5, 0.15, 0.05, 0.2, 0.2, 1.0, 0.25, 0.01, 0.02]);
    assert_eq!(deck.couplings.iter().filter(|one| one.kind == CouplingKind::Radiative).count(), 2);
    // Line 4 joins two nodes of the board: the contact ended before it.
    let clamp = &deck.parameters[0];
    assert_eq!((clamp.name.as_str(), clamp.unit.as_str(), clamp.nominal), ("Clamp", "W/K", 0.15 + 0.05));
    assert_eq!(deck.groups[0].couplings, [1, 2]);
    assert_eq!((deck.parameters[1].name.as_str(), deck.parameters[1].nominal), ("radiation_C0A0", 1.0));
    let chip = &deck.inputs[0];
    assert_eq!((chip.name.as_str(), chip.unit.as_str(), chip.nominal), ("Chip", "W", 2.0));

    let kelvin = steady(&deck);
    let text = printed(&deck, &kelvin);
    let [inp, cc, k] = files(INP, CC, K);
    let all = [inp, cc, k, SindaFile { name: "case.out", text: &text }];
    assert!(recognises(&all) && recognises(&all[..3]) && !recognises(&all[3..]));
    let deck = read(&all).expect("a deck with its result");
    let record = deck.record.as_ref().expect("a record");
    assert!(record.is_steady && record.inputs == [[2.0]]);
    let kelvin: Vec<f64> = record.temperatures_k.iter().map(|rows| rows[0]).collect();
    for (node, heat) in net_heat_w(&deck, &kelvin).into_iter().enumerate() {
        if matches!(deck.nodes[node].kind, NodeKind::Boundary { .. }) {
            continue;
        }
        // The print rounds by up to 0.005 K here and at each neighbour; the conductances at a node add up to at most 1.6 W/K,
        // with 4 sigma A T^3 below 0.2 W/K.
        assert!(heat.abs() < 2.0 * 0.005 * 1.8, "{}: {heat} W", deck.nodes[node].name);
    }
}

#[test]
fn registers_are_parameters_and_kelvins_stay() {
    let inp = "HEADER CONTROL DATA, GLOBAL\n abszro = 0., sigma = 1.\nHEADER REGISTER DATA\n G = 2.0\n H = G/4\n";
    let cc = "HEADER NODE DATA, A\n 1, 300., 5*G\n -2, 290.\nHEADER CONDUCTOR DATA, A\n 1, 1, 2, 3*H\nHEADER SOURCE DATA, A\n 1, 0.5\n";
    let text = format!("{inp}{cc}");
    let deck = read(&[SindaFile { name: "a.inp", text: &text }]).expect("a deck");
    assert_eq!(deck.parameters[0].name, "G");
    assert_eq!(deck.nodes[1].kind, NodeKind::Boundary { temperature: Value::Number(290.0) });
    let capacity = Value::Scaled { parameter: "G".to_owned(), factor: 5.0 };
    assert_eq!(deck.nodes[0].kind, NodeKind::Diffusion { capacity });
    assert_eq!(number(&deck, &deck.couplings[0].value), 1.5);
    assert_eq!(deck.loads[0].power, Value::Number(0.5));
}

const HEATING: &str = "HEADER ARRAY DATA, C0A1
C     Energy units:            J
C     Data Array units:        W
PSTOP
C Average heating rates
C     1= 1.0e-01 ,2.5e-01
C Relative node storage for LOADQ
C solar albedo planetshine - BOARD.1 Area = 0.01 Avg = 0.08 0.01 0.01
C   5= 1.0e-01 ,1.0e-01
C solar albedo planetshine - FRAME.2 Area = 0.01 Avg = 0.2 0.03 0.02
PSTART
HEADER VARIABLES 0, C0A1
F     CALL LOADQ_C0A1_1654263672
";

#[test]
fn heating_rates_are_the_means_of_the_orbit() {
    let inp = format!("{INP}{HEATING}");
    let deck = read(&files(&inp, CC, K)).expect("a deck");
    let heats: Vec<(usize, f64)> = deck.loads[2..].iter().map(|load| (load.into, number(&deck, &load.power))).collect();
    assert_eq!(heats, [(0, 0.1), (5, 0.25)]);
    assert!(deck.parameters.iter().any(|parameter| parameter.name == "heating_C0A1" && parameter.nominal == 1.0));
    let inp = format!("{INP}{}", HEATING.replace("0.2 0.03", "0.3 0.03"));
    let errors = read(&files(&inp, CC, K)).expect_err("means that disagree");
    let expected =
        "runs/CASE.INP:22: its means add up to 0.35 W, array 1 says 0.25 W; let Thermal Desktop write the file anew";
    assert!(errors[0].to_string().starts_with(expected), "{}", errors[0]);
}

#[test]
fn malformed_decks_are_refused_at_their_line() {
    let refused = |files: &[SindaFile<'_>], start: &str, words: &str| {
        let errors = read(files).expect_err(start);
        let first = errors[0].to_string();
        assert!(first.starts_with(start) && first.contains(words), "{first}");
    };
    let inp = |from: &str, to: &str, start: &str, words: &str| {
        assert!(INP.contains(from), "{from}");
        refused(&files(&INP.replacen(from, to, 1), CC, K), start, words);
    };
    let cc = |from: &str, to: &str, start: &str, words: &str| {
        assert!(CC.contains(from), "{from}");
        refused(&files(INP, &CC.replacen(from, to, 1), K), start, words);
    };
    inp("C0A0.k_in", "C0A7.k_in", "runs/CASE.INP:12:", "or its text `c0a7.k`");
    inp("INSERT case.cc", "INSERT case.inp", "runs/CASE.INP:11:", "inserts itself");
    inp("C0A0.k_in", "case.cc", "runs/CASE.INP:12:", "a second time");
    let circle = [
        SindaFile { name: "a", text: "HEADER NODE DATA, A\nINSERT b" },
        SindaFile { name: "b", text: "HEADER NODE DATA, B\nINSERT a" },
    ];
    refused(&circle, "a:", "in a circle");
    inp("abszro = -273.15", "abszro = -459.67", "runs/CASE.INP:", "degF");
    inp("abszro = -273.15", "abszro = 0.", "runs/CASE.INP:", "does not go with TDUNITS");
    inp("sigma = 5.6704E-8", "sigma = 0.", "runs/CASE.INP:", "above 0");
    inp("UID = SI", "UID = ENG", "runs/CASE.INP:", "UID other than SI");
    inp("HEADER OPERATION DATA", "HEADER FLOW DATA, WATER", "runs/CASE.INP:9:", "not read");
    inp("HEADER OPERATION DATA", "HEADER OPERAND DATA", "runs/CASE.INP:8:", "not known");
    inp("HEADER OPTIONS DATA", "HEADERS", "runs/CASE.INP:2:", "`HEADER ...`");
    cc("Energy     = J", "Energy     = erg", "runs/case.cc:3:", "energy in erg");
    cc("Temp       = C", "Temp       = X", "runs/case.cc:4:", "temp in X");
    cc("1,    20.,    10.5", "1,    20.,    ten", "runs/case.cc:6:", "no register");
    cc("1,    20.,    10.5", "1,    20.,    0.", "runs/case.cc:6:", "write -1");
    cc("1,    20.,    10.5", "1,    20.", "runs/case.cc:6:", "third field");
    cc("1,    20.,    10.5", "1,    -300.,    1.", "runs/case.cc:6:", "absolute zero");
    cc("1,    20.,    10.5", "1,    1e999,    1.", "runs/case.cc:6:", "finite");
    cc("1,    20.,    10.5", "0,    20.,    1.", "runs/case.cc:6:", "number 0");
    cc("1,    20.,    10.5", "2,    20.,    1.", "runs/case.cc:7:", "defined twice");
    cc("1,    20.,    10.5", "SIV 1, 20., A1, 1.", "runs/case.cc:6:", "not among ARRAY DATA");
    cc("GEN 3, 2, 1", "GEN 3, 2000000000, 1", "runs/case.cc:8:", "expected 1 to 100000");
    cc("GEN 3, 2, 1", "GEN 9223372036854775807, 2, 1", "runs/case.cc:8:", "too large");
    cc("HEADER NODE DATA, BOARD", "HEADER NODE DATA", "runs/case.cc:5:", "submodel");
    cc("BOARD.1,    BOARD.2,    0.5", "BOARD.1,    BOARD.9,    0.5", "runs/case.cc:10:", "BOARD.9 is not defined");
    cc("BOARD.1,    BOARD.2,    0.5", "BOARD.1,    -2,    0.5", "runs/case.cc:10:", "one-way");
    cc("BOARD.1,    BOARD.2,    0.5", "BOARD.1,    BOARD.2,    -0.5*T", "runs/case.cc:10:", "no register");
    cc("BOARD.1,    BOARD.2,    0.5", "BOARD.1,    BOARD.2", "runs/case.cc:10:", "3 fields");
    cc("BOARD.1,    BOARD.2,    0.5", "BOARD.1,    BOARD.2,    0.5/0", "runs/case.cc:10:", "finite");
    cc("BOARD.Q1 = BOARD.Q1 + 1.5", "IF(TIMEN .GT. 3.) BOARD.Q1 = 2.", "runs/case.cc:18:", "heat added to a node");
    cc("BOARD.Q1 = BOARD.Q1 + 1.5", "BOARD.Q1 = BOARD.Q2 + 1.5", "runs/case.cc:18:", "heat added to a node");
    cc("BOARD.Q1 = BOARD.Q1 + 1.5", "CALL HEATER(1)", "runs/case.cc:18:", "heat added to a node");
    cc("BOARD.Q1 = BOARD.Q1 + 1.5", "CALL LOADQ_C0A1_7", "runs/CASE.INP:", "give its `.hra`");
    cc("HEADER VARIABLES 0, BOARD", "HEADER VARIABLES 2, BOARD", "runs/case.cc:18:", "behind each step");
    cc("F     RETURN", "M     BOARD.Q1 = 3.", "runs/case.cc:31:", "heaters and other logic");
    cc("SUBROUTINE TDHTR", "SUBROUTINE MINE(X)", "runs/case.cc:30:", "MINE");
    refused(&files(INP, CC, "\u{0}\u{1}\u{fffd}"), "runs/C0A0.k:1:", "in TDHTR");
    refused(&files("HEADER CONTROL DATA, GLOBAL\n abszro = 0.\n", "", ""), "runs/CASE.INP:", "no nodes");
    refused(&[SindaFile { name: "a", text: "" }], ": expected ABSZRO", "`.inp`");
}

#[test]
fn a_result_of_another_deck_is_refused() {
    let [inp, cc, k] = files(INP, CC, K);
    let other = " S I N D A\n MODEL = SINDA\n   STEADY\n  SUBMODEL NAME = OTHER\n   T  1=  20.0\n";
    let errors = read(&[inp, cc, k, SindaFile { name: "o.out", text: other }]).expect_err("another deck");
    assert!(errors[0].to_string().contains("none of the deck's nodes"), "{}", errors[0]);
    let error = read_result("o.out", " S I N D A\n").expect_err("nothing printed");
    assert!(error.to_string().contains("TPRINT"), "{error}");
    let error = read_result("o.out", &other.replace("20.0", "******")).expect_err("no number");
    assert_eq!(error.line, Some(5));
}

#[test]
fn damaged_decks_are_read_or_refused_and_nothing_else() {
    let mut state = 1_u64;
    let mut next = |below: usize| {
        // Knuth's multiplier (The Art of Computer Programming, 3.3.4).
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below.max(1)
    };
    let characters: Vec<char> = CC.chars().collect();
    let mut refused = 0;
    for round in 0..2000 {
        let mut damaged = characters.clone();
        for _ in 0..=next(4) {
            let place = next(damaged.len());
            damaged[place] = [',', '.', '-', '9', 'C', 'F', '\n', '=', '*', '(', 'é', '\u{0}'][next(12)];
        }
        if round % 3 == 0 {
            damaged.truncate(next(damaged.len()));
        }
        let text: String = damaged.into_iter().collect();
        refused += usize::from(read(&files(INP, &text, K)).is_err());
    }
    assert!(refused > 500, "most damage is seen: {refused} of 2000");
}
