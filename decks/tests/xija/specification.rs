//! Specifications of the tests, and what is refused. The laws are checked against xija's in `equations.rs`.

use bmv_decks::xija::{read, recognises};
use bmv_decks::{CouplingKind, Deck, NodeKind, Value};
use serde_json::{Value as Json, json};

/// Two nodes, a coupling, a sink, a heat of the Sun and a dated heat.
fn specification() -> Json {
    let parameters = [
            ("coupling__box__box0", "tau", 40.0), ("heatsink__box0", "T", -10.0), ("heatsink__box0", "tau", 80.0),
            ("solarheat__box0", "P_45", 1.0), ("solarheat__box0", "P_90", 2.0), ("solarheat__box0", "P_180", 0.5),
            ("solarheat__box0", "dP_45", 0.1), ("solarheat__box0", "dP_90", 0.2), ("solarheat__box0", "dP_180", 0.3),
            ("solarheat__box0", "tau", 365.0), ("solarheat__box0", "ampl", 0.05), ("solarheat__box0", "bias", 0.1),
            ("step_power__box", "P", 0.3),
        ].map(|(component, name, value)| {
            json!({"comp_name": component, "name": name, "val": value, "min": -200.0, "max": 400.0, "frozen": name == "tau"})
        });
    json!({
        "name": "small", "dt": 328.0, "evolve_method": 2, "rk4": 0, "datestart": "2024:001", "datestop": "2024:100",
        "bad_times": [["2024:010:00:00:00", "2024:011:00:00:00"]],
        "limits": {"box": {"planning.warning.high": 40.0, "unit": "degC"}},
        "comps": [
            {"class_name": "Pitch", "init_args": [], "init_kwargs": {}, "name": "pitch"},
            {"class_name": "Eclipse", "init_args": [], "init_kwargs": {}, "name": "eclipse"},
            {"class_name": "Node", "init_args": ["1box"], "init_kwargs": {"name": "box", "data": 20}, "name": "box"},
            {"class_name": "Node", "init_args": ["box0"], "init_kwargs": {"sigma": 100000.0}, "name": "box0"},
            {"class_name": "Coupling", "init_args": ["box"], "init_kwargs": {"node2": "box0", "tau": 9}, "name": "coupling__box__box0"},
            {"class_name": "HeatSink", "init_args": ["box0"], "init_kwargs": {}, "name": "heatsink__box0"},
            {"class_name": "SolarHeat", "init_args": ["box0", "pitch", "eclipse", [45, 90, 180]],
             "init_kwargs": {"var_func": "linear", "epoch": "2020:001"}, "name": "solarheat__box0"},
            {"class_name": "StepFunctionPower", "init_args": [], "init_kwargs": {"node": "box", "time": "2024:247:12:00:00"},
             "name": "step_power__box"},
        ],
        "pars": parameters,
    })
}

fn pretty(specification: &Json) -> String {
    serde_json::to_string_pretty(specification).expect("a value of JSON")
}

fn deck(specification: &Json) -> Deck {
    read("small.json", &pretty(specification)).expect("a specification")
}

#[test]
fn a_specification_becomes_a_network() {
    let text = pretty(&specification());
    assert!(recognises(&text) && !recognises("{\"comps\": []}") && !recognises("[]") && !recognises(""));
    let deck = deck(&specification());
    assert_eq!((deck.title.as_str(), deck.tool.as_str()), ("small", "xija"));
    let names: Vec<&str> = deck.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["box", "box0", "heatsink__box0"]);
    assert_eq!(deck.nodes[0].label.as_deref(), Some("1box"));
    assert_eq!(deck.nodes[0].initial_temperature_k, Some(293.15));
    assert_eq!(deck.nodes[0].kind, NodeKind::Diffusion { capacity: Value::Number(1000.0) });
    let sink = Value::Scaled { parameter: "heatsink__box0__T".to_owned(), factor: 1.0 };
    assert_eq!(deck.nodes[2].kind, NodeKind::Boundary { temperature: sink });
    // Heat goes into `box`, the first argument, alone.
    assert_eq!((deck.couplings[0].kind, deck.couplings[0].between), (CouplingKind::OneWay, [1, 0]));
    assert_eq!((deck.couplings[1].kind, deck.couplings[1].between), (CouplingKind::Linear, [2, 1]));
    assert_eq!(deck.couplings[0].value, Value::Expression("1 / coupling__box__box0__tau".to_owned()));
    let parameter = |name: &str| deck.parameters.iter().find(|parameter| parameter.name == name).expect(name);
    assert_eq!((parameter("heatsink__box0__T").nominal, parameter("heatsink__box0__T").unit.as_str()), (263.15, "K"));
    assert_eq!(parameter("solarheat__box0__tau").nominal, 365.0 * 86_400.0);
    assert!(parameter("solarheat__box0__tau").description.contains("frozen"));
    assert!(parameter("solarheat__box0__P_90").description.contains("-200 to 400"));
    assert_eq!(deck.parameters.len(), 13);
    // 1725364800 s and 883612800 s are the Unix times of the date and of 1998.
    assert_eq!(deck.loads[1].power, Value::Expression("step_power__box__P * step(t - 841752000)".to_owned()));
    let inputs: Vec<(&str, &str)> =
        deck.inputs.iter().map(|input| (input.name.as_str(), input.unit.as_str())).collect();
    assert_eq!(inputs, [("pitch", "deg"), ("eclipse", "1")]);
    let notes: Vec<&str> = deck.notes.iter().map(|note| note.message.as_str()).collect();
    for part in [
        "1 intervals",
        "limits of box: planning.warning.high:40.0",
        "2024:001 to 2024:100",
        "no weight",
        "is 2, an ordinary",
    ] {
        assert!(notes.iter().any(|note| note.contains(part)), "{part} in {notes:#?}");
    }
}

#[test]
fn the_doubled_pairs_of_method_1_divide_the_capacities() {
    for method in [json!(1), json!(null), json!(0)] {
        let mut specification = specification();
        specification["evolve_method"] = method;
        let deck = deck(&specification);
        assert_eq!(deck.nodes[1].kind, NodeKind::Diffusion { capacity: Value::Number(1000.0 / 1.5) });
        assert!(deck.notes.iter().any(|note| note.message.contains("1.5 times the time")));
    }
}

#[test]
fn equal_and_opposite_couplings_become_one() {
    let mut both = specification();
    let back = json!({"class_name": "Coupling", "init_args": ["box0", "box"], "init_kwargs": {}, "name": "coupling__box0__box"});
    both["comps"].as_array_mut().expect("a list").push(back);
    both["pars"]
        .as_array_mut()
        .expect("a list")
        .push(json!({"comp_name": "coupling__box0__box", "name": "tau", "val": 40.0}));
    let merged = deck(&both);
    assert_eq!(merged.couplings.len(), 2);
    assert_eq!((merged.couplings[0].kind, merged.couplings[0].between), (CouplingKind::Linear, [1, 0]));
    both["pars"][13]["val"] = json!(41.0);
    assert!(deck(&both).couplings.iter().filter(|coupling| coupling.kind == CouplingKind::OneWay).count() == 2);
}

/// A component with a parameter that cannot be expressed with parameters: too many points.
#[test]
fn many_points_become_a_table() {
    let mut many = specification();
    let pitches: Vec<f64> = (0..50).map(|at| 45.0 + 2.7 * f64::from(at)).collect();
    many["comps"][6]["init_args"][3] = json!(pitches);
    let parameters = many["pars"].as_array_mut().expect("a list");
    let solar = |name: String, value: usize| json!({"comp_name": "solarheat__box0", "name": name, "val": value as f64});
    let points = ["P", "dP"].into_iter().flat_map(|kind| (0..50).map(move |at| solar(format!("{kind}_{at}"), at)));
    parameters.splice(3..9, points);
    let deck = deck(&many);
    assert_eq!(deck.tables.iter().map(|table| table.x.len()).collect::<Vec<_>>(), [50, 50]);
    assert_eq!((deck.tables[0].x[0], deck.tables[0].y[49]), (45.0_f64.to_radians(), 49.0));
    assert_eq!(deck.parameters.len(), 7);
}

/// A change of the specification, with what its error must say.
type Fault = (&'static str, fn(&mut Json), &'static str);

const FAULTS: &[Fault] = &[
    ("no components", |s| s["comps"] = json!(null), "the list `comps` is missing"),
    ("components of another type", |s| s["comps"] = json!({"a": 1}), "the list `comps` is missing"),
    ("no parameters", |s| s["pars"] = json!(3), "the list `pars` is missing"),
    ("a component without a name", |s| s["comps"][2]["name"] = json!(null), "component 3 of `comps` has no `name`"),
    ("a component that is a number", |s| s["comps"][2] = json!(7), "component 3 of `comps` has no `name`"),
    ("a class of another type", |s| s["comps"][2]["class_name"] = json!([]), "no `class_name`"),
    (
        "an unknown class",
        |s| s["comps"][6]["class_name"] = json!("MoonHeat"),
        "`solarheat__box0` of class MoonHeat: this class",
    ),
    ("two of one name", |s| s["comps"][3]["name"] = json!("box"), "two components are called `box`"),
    ("a coupling to nothing", |s| s["comps"][4]["init_kwargs"]["node2"] = json!("lid"), "`lid`, which is no Node"),
    ("a coupling to a driver", |s| s["comps"][4]["init_kwargs"]["node2"] = json!("pitch"), "`pitch`, which is no Node"),
    ("a coupling to itself", |s| s["comps"][4]["init_kwargs"]["node2"] = json!("box"), "a node to itself"),
    ("a coupling of one node", |s| s["comps"][4]["init_kwargs"] = json!({}), "`node2` is missing"),
    ("arguments of another type", |s| s["comps"][4]["init_args"] = json!("box"), "`init_args` is no list"),
    ("too many arguments", |s| s["comps"][0]["init_args"] = json!([1]), "more entries than the class has"),
    (
        "an unknown argument",
        |s| s["comps"][4]["init_kwargs"]["R"] = json!(1),
        "no argument `R`; it has: node1, node2, tau",
    ),
    ("an argument twice", |s| s["comps"][4]["init_kwargs"]["node1"] = json!("box"), "`node1` is given twice"),
    ("a node that is a number", |s| s["comps"][4]["init_args"] = json!([5]), "`node1` is 5; a text is expected"),
    (
        "a start that is a text",
        |s| s["comps"][2]["init_kwargs"]["data"] = json!("warm"),
        "`data` is \"warm\"; a number",
    ),
    ("a node in kelvin", |s| s["comps"][2]["init_kwargs"]["units"] = json!("K"), "only temperatures in degC"),
    ("a node that is given", |s| s["comps"][2]["init_kwargs"]["predict"] = json!(false), "not predicted"),
    ("pitch that falls", |s| s["comps"][6]["init_args"][3] = json!([45, 180, 90]), "in degrees that rise"),
    ("pitch twice", |s| s["comps"][6]["init_args"][3] = json!([45, 45, 90]), "in degrees that rise"),
    ("one pitch", |s| s["comps"][6]["init_args"][3] = json!([45]), "two or more pitch angles"),
    ("pitch as a text", |s| s["comps"][6]["init_args"][3] = json!([45, "90", 180]), "a list of numbers is expected"),
    ("too few powers", |s| s["comps"][6]["init_kwargs"]["Ps"] = json!([1, 2]), "`Ps` has 2 powers for 3 pitch angles"),
    (
        "other ends",
        |s| s["comps"][6]["init_kwargs"]["dP_pitches"] = json!([60, 180]),
        "begin and end at the same pitch",
    ),
    ("another function of time", |s| s["comps"][6]["init_kwargs"]["var_func"] = json!("sin"), "must be linear or exp"),
    ("a date by months", |s| s["comps"][7]["init_kwargs"]["time"] = json!("2024-09-03"), "`2024-09-03` is no date"),
    ("no date", |s| s["comps"][7]["init_kwargs"] = json!({"node": "box"}), "`time` is missing"),
    ("no such driver", |s| s["comps"][6]["init_args"][1] = json!("roll"), "`roll`, which is no component"),
    (
        "a driver of another class",
        |s| s["comps"][6]["init_args"][1] = json!("eclipse"),
        "of class Eclipse; expected is [Pitch]",
    ),
    ("a value of null, as NaN is often written", |s| s["pars"][0]["val"] = json!(null), "parameter 1 of `pars` needs"),
    ("a value of text", |s| s["pars"][0]["val"] = json!("40"), "parameter 1 of `pars` needs"),
    ("no time constant", |s| s["pars"][0]["val"] = json!(0.0), "must be above 0 ks"),
    ("too large", |s| s["pars"][9]["val"] = json!(1e308), "is too large"),
    ("a parameter too few", |s| _ = s["pars"].as_array_mut().map(Vec::pop), "`pars` ends before it"),
    ("a parameter too many", |s| s["pars"][13] = json!({"comp_name": "x", "name": "P", "val": 1}), "has 14 parameters"),
    ("another order", |s| s["pars"][1]["name"] = json!("tau"), "expected at place 2 of `pars`"),
    ("another solver", |s| s["evolve_method"] = json!(3), "`evolve_method` must be 1 or 2"),
    ("a solver of text", |s| s["evolve_method"] = json!("2"), "`evolve_method` must be 1 or 2"),
    ("no step", |s| s["dt"] = json!(0), "`dt` must be a number above 0"),
];

#[test]
fn faults_are_refused_by_name() {
    for (what, change, expected) in FAULTS {
        let mut faulty = specification();
        if *what == "a parameter too many" {
            faulty["pars"].as_array_mut().expect("a list").push(json!(null));
        }
        change(&mut faulty);
        let errors = read("small.json", &pretty(&faulty)).expect_err(what);
        assert!(errors.iter().any(|error| error.message.contains(expected)), "{what}: {errors:#?}");
        assert!(errors.iter().all(|error| error.file == "small.json"));
    }
}

#[test]
fn an_error_stands_at_the_name_of_its_component() {
    let mut faulty = specification();
    faulty["comps"][7]["init_kwargs"]["time"] = json!("2024");
    let text = pretty(&faulty);
    let errors = read("small.json", &text).expect_err("a date without a day");
    let line = text.lines().position(|line| line.contains("\"name\": \"step_power__box\"")).expect("its name") + 1;
    assert_eq!((errors.len(), errors[0].line), (1, Some(line)));
}

#[test]
fn broken_text_is_refused_at_its_line() {
    let text = pretty(&specification());
    for (broken, line) in
        [(text.replace("40.0,\n", "NaN,\n"), None), (String::new(), Some(1)), ("[\n[".to_owned(), Some(2))]
    {
        let errors = read("small.json", &broken).expect_err("broken");
        let at = line.or_else(|| broken.lines().position(|row| row.contains("NaN")).map(|at| at + 1));
        assert_eq!(errors[0].line, at, "{errors:?}");
        assert!(errors[0].message.contains("not JSON"));
    }
    // Every beginning of the text, by bytes that end a character, is refused; none panics.
    for end in (0..text.len() - 1).filter(|end| text.is_char_boundary(*end)) {
        assert!(read("small.json", &text[..end]).is_err(), "{end}");
    }
    assert!(read("small.json", "[]").is_err() && read("small.json", "null").is_err());
}

#[test]
fn names_become_identifiers_of_their_kind() {
    let mut odd = specification();
    let switch = json!({"class_name": "MsidStatePower", "init_args": ["box", "215PCAST", "OFF "], "init_kwargs": {}, "name": "215pcast_off"});
    odd["comps"].as_array_mut().expect("a list").push(switch);
    // The component that the list names is another: the place counts.
    odd["pars"].as_array_mut().expect("a list").push(json!({"comp_name": "fa6", "name": "P", "val": 0.2}));
    let deck = deck(&odd);
    assert_eq!(deck.inputs[2].name, "_215pcast_off");
    assert_eq!(deck.inputs[2].description, "1 while 215pcast is OFF, else 0");
    assert_eq!(deck.loads[2].power, Value::Expression("_215pcast_off__P * _215pcast_off".to_owned()));
    assert!(deck.parameters[13].description.contains("fa6__P"));
    assert!(deck.notes.iter().any(|note| note.message.contains("1 parameters stand in `pars` under a name")));
}
