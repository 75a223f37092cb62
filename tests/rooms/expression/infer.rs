//! Tests of `core/src/expression/infer.rs`.

use bmv::expression::dimension::Dimension;
use bmv::expression::graph::{Graph, Symbol};
use bmv::expression::infer::*;
use bmv::expression::parse::parse;
use bmv::expression::scope::{Names, Scope};
use bmv::expression::unit::Unit;

fn inferred(text: &str) -> (Inferred, Vec<String>) {
    let mut graph = Graph::new();
    let mut names = Names::default();
    for (i, (name, unit)) in
        [("G", "W/K"), ("A", "m2"), ("h", "W/(m2 K)"), ("e", "1"), ("a", "1/K")].into_iter().enumerate()
    {
        let symbol = Symbol::Parameter(i as u32);
        let id = graph.symbol(symbol);
        names.values.insert(name.to_owned(), id);
        names.dimensions.insert(symbol, Unit::parse(unit).expect("a unit").dimension);
    }
    let node = graph.symbol(Symbol::Node(0));
    let scope = Scope::with(&names, vec![("T", node)]);
    let id = parse(text, &mut graph, &scope).expect("parses");
    let mut clashes = Vec::new();
    let result = infer(&graph, id, &|s| names.dimension(s), &[], &mut clashes);
    (result, clashes)
}

#[test]
fn products_and_sums() {
    assert_eq!(inferred("G + A * h"), (Some(Dimension::CONDUCTANCE), vec![]));
    assert_eq!(inferred("h * A * T"), (Some(Dimension::POWER), vec![]));
    assert_eq!(inferred("e * 0.045"), (None, vec![]));
    assert_eq!(inferred("1 + a * (T - 293)"), (Some(Dimension::NONE), vec![]));
    assert_eq!(inferred("sqrt(A^2)").0, Some(Dimension::AREA));
}

#[test]
fn clashes_are_named() {
    assert_eq!(inferred("G + A").1, ["something in W/K is added to something in m2"]);
    assert_eq!(inferred("exp(T)").1, ["exp is taken of something in K"]);
    assert_eq!(inferred("e ^ T").1, ["an exponent is in K"]);
    assert!(inferred("exp(T / 300)").1.is_empty());
}
