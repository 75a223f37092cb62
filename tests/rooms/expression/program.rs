//! Tests of `core/src/expression/program.rs`.

use bmv::expression::graph::{Graph, Symbol};
use bmv::expression::program::*;

#[test]
fn a_branch_uses_only_the_segments_it_names() {
    let mut graph = Graph::new();
    let x = graph.symbol(Symbol::Time);
    let square = graph.multiply(x, x);
    let three = graph.number(3.0);
    let first = graph.add(square, three);
    let second = graph.multiply(square, three);
    // Both need the square; the second does not follow the first.
    let program = Program::compile_branches(
        &graph,
        &[Symbol::Time],
        &[Segment { after: &[], outputs: &[first] }, Segment { after: &[], outputs: &[second] }],
    );
    let mut file = program.registers::<f64>();
    file[0] = 5.0;
    program.run(1, &mut file);
    assert_eq!(file[program.outputs(1)[0].index()], 75.0);
    assert_eq!(program.cost(1), 2);
    // A segment that follows another reuses its work.
    let shared = Program::compile(&graph, &[Symbol::Time], &[&[first], &[second]]);
    assert_eq!(shared.cost(1), 1);
    let mut file = shared.registers::<[f64; 2]>();
    file[0] = [5.0, -1.0];
    shared.run(0, &mut file);
    shared.run(1, &mut file);
    assert_eq!(file[shared.outputs(1)[0].index()], [75.0, 3.0]);
    assert_eq!(file[shared.outputs(0)[0].index()], [28.0, 4.0]);
}
