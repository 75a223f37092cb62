//! Tests of `core/src/expression/graph.rs`.

use bmv::expression::graph::*;
use std::collections::HashMap;

#[test]
fn substitution_replaces_everywhere_and_simplifies() {
    let mut graph = Graph::new();
    let (a, b) = (graph.symbol(Symbol::Node(0)), graph.symbol(Symbol::Node(1)));
    let difference = graph.subtract(a, b);
    let sine = graph.unary(Unary::Sin, difference);
    let product = graph.multiply(sine, a);
    let zero = graph.number(0.0);
    let renewed = graph.substitute(&[product, difference, a], &HashMap::from([(b, zero)]));
    let plain = graph.unary(Unary::Sin, a);
    let expected = graph.multiply(plain, a);
    assert_eq!(renewed, [expected, a, a]);
}

#[test]
fn discontinuities_are_the_functions_of_time_that_switch() {
    let mut graph = Graph::new();
    let time = graph.symbol(Symbol::Time);
    let cosine = graph.unary(Unary::Cos, time);
    let zero = graph.number(0.0);
    let lit = graph.binary(Binary::Maximum, cosine, zero);
    let node = graph.symbol(Symbol::Node(0));
    let magnitude = graph.unary(Unary::Abs, node);
    let root = graph.add(lit, magnitude);
    let given = Dependence::PARAMETER.union(Dependence::INPUT).union(Dependence::TIME);
    assert_eq!(graph.discontinuities(&[root], given), [cosine]);
}
