//! Tests of `core/src/expression/parse.rs`.

use bmv::expression::graph::{Graph, Symbol};
use bmv::expression::parse::*;
use bmv::expression::scope::{Names, Scope};

fn value(text: &str) -> Result<f64, ParseError> {
    let mut graph = Graph::new();
    let mut names = Names::default();
    for (i, name) in ["x", "y", "harness.conductance"].into_iter().enumerate() {
        let id = graph.symbol(Symbol::Parameter(i as u32));
        names.values.insert(name.to_owned(), id);
    }
    let table = graph.table(bmv::expression::Table { x: vec![0.0, 1.0], y: vec![10.0, 20.0] });
    names.tables.insert("a curve".to_owned(), table);
    names.tables.insert("louver".to_owned(), table);
    let id = parse(text, &mut graph, &Scope::new(&names))?;
    Ok(graph.evaluate(id, &|s| match s {
        Symbol::Parameter(0) => 2.0,
        Symbol::Parameter(1) => 3.0,
        Symbol::Parameter(_) => 0.5,
        _ => 100.0,
    }))
}

#[test]
fn values_follow_the_usual_precedence() {
    // By hand, x = 2, y = 3, t = 100.
    for (text, expected) in [
        ("1 + 2 * 3", 7.0),
        ("-x^2", -4.0),
        ("2^3^2", 512.0),
        ("2^-x", 0.25),
        ("(1 + x) * y", 9.0),
        ("12 / 2 / 3", 2.0),
        ("10 - 4 - 3", 3.0),
        ("x - -y", 5.0),
        ("+x", 2.0),
        ("min(x, y, 1)", 1.0),
        ("max(x, y)", 3.0),
        ("clamp(7, x, y)", 3.0),
        ("abs(-x)", 2.0),
        ("step(0) + step(-1)", 1.0),
        ("smoothstep(0.5)", 0.5),
        ("smoothstep(1, 3, x)", 0.5),
        ("interp(louver, 0.25)", 12.5),
        ("interp('a curve', x)", 20.0),
        ("harness.conductance * 4", 2.0),
        ("t + .5", 100.5),
        ("1e3 + 2.5E-1", 1000.25),
        ("sqrt(16)", 4.0),
    ] {
        assert_eq!(value(text).as_ref().ok(), Some(&expected), "{text}");
    }
    assert!((value("log(exp(x)) + sin(pi)").expect("parses") - 2.0).abs() < 1e-14);
    assert!((value("sigma * 300^4").expect("parses") - 459.300_327_939).abs() < 1e-9);
}

#[test]
fn faults_have_places() {
    for (text, kind, start, end) in [
        ("", Fault::Syntax, 0, 0),
        ("x +", Fault::Syntax, 3, 3),
        ("x y", Fault::Syntax, 2, 3),
        ("2x", Fault::Syntax, 1, 2),
        ("(x", Fault::Syntax, 0, 1),
        ("x)", Fault::Syntax, 1, 2),
        ("x ** 2", Fault::Syntax, 2, 4),
        ("x + zz", Fault::UnknownName, 4, 6),
        ("1 / 0", Fault::Undefined, 0, 5),
        ("x + sqrt(-2)", Fault::Undefined, 4, 12),
        ("(-8)^0.5", Fault::Undefined, 0, 8),
        ("clamp(x, 1)", Fault::Arguments, 0, 11),
        ("exp", Fault::Arguments, 0, 3),
        ("min(x)", Fault::Arguments, 0, 6),
        ("interp(x, 1)", Fault::UnknownName, 7, 8),
        ("1e999", Fault::Undefined, 0, 5),
        ("x > 2", Fault::Syntax, 2, 3),
    ] {
        let error = value(text).expect_err(text);
        assert_eq!((error.fault, error.start, error.end), (kind, start, end), "{text}: {error}");
    }
}

#[test]
fn depth_is_limited() {
    let deep = format!("{}x{}", "(".repeat(5000), ")".repeat(5000));
    assert_eq!(value(&deep).expect_err("deep").fault, Fault::Depth);
    assert_eq!(value(&"-".repeat(5000)).expect_err("deep").fault, Fault::Depth);
    assert_eq!(value(&format!("x{}", "^x".repeat(5000))).expect_err("deep").fault, Fault::Depth);
    assert_eq!(value(&format!("x{}", "+x".repeat(5000))).expect_err("long").fault, Fault::Depth);
    assert_eq!(value(&"x+".repeat(50_000)).expect_err("long").fault, Fault::Depth);
}
