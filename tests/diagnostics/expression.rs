//! Expressions that do not parse, or clash.

use super::rendered;

#[test]
fn unknown_name() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "Gbi * 2"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[unknown-name]: unknown name `Gbi`
     --> model.json:5:73
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "Gbi * 2"}}}
      |                                                                         ^^^
      |
      = note: at $.conductors.bolts.conductance
      = help: did you mean `G_bi`?
    "#);
}

#[test]
fn product_not_written() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "2 G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[expression-syntax]: unexpected `G_bi`
     --> model.json:5:75
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "2 G_bi"}}}
      |                                                                           ^^^^ an operator + - * / ^
      |
      = note: at $.conductors.bolts.conductance
      = help: a product is written `* G_bi`
    "#);
}

#[test]
fn power_of_another_language() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi ** 2"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[expression-syntax]: `**` is no operator
     --> model.json:5:78
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi ** 2"}}}
      |                                                                              ^^
      |
      = note: at $.conductors.bolts.conductance
      = help: a power is written with `^`
    "#);
}

#[test]
fn bracket_not_closed() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi * (1 + Tm / 300"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[expression-syntax]: this bracket is not closed
     --> model.json:5:80
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi * (1 + Tm / 300"}}}
      |                                                                                ^ a `)` for it
      |
      = note: at $.conductors.bolts.conductance
    "#);
}

#[test]
fn operand_missing() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi * "}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[expression-syntax]: the expression ends too early
     --> model.json:5:80
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi * "}}}
      |                                                                                ^ a number, a name, a function or `(`
      |
      = note: at $.conductors.bolts.conductance
    "#);
}

#[test]
fn function_of_another_language() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi * ln(2)"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[unknown-name]: unknown function `ln`
     --> model.json:5:80
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi * ln(2)"}}}
      |                                                                                ^^
      |
      = note: at $.conductors.bolts.conductance
      = help: write `log(x)`
    "#);
}

#[test]
fn arguments_missing() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "clamp(G_bi, 1)"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[expression-arguments]: `clamp` is given 2 arguments
     --> model.json:5:73
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "clamp(G_bi, 1)"}}}
      |                                                                         ^^^^^^^^^^^^^^ `clamp(x, lower, upper)`
      |
      = note: at $.conductors.bolts.conductance
    "#);
}

#[test]
fn table_unknown() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "interp(louver, Tm)"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[unknown-name]: unknown table `louver`
     --> model.json:5:80
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "interp(louver, Tm)"}}}
      |                                                                                ^^^^^^ `interp(table, x)`
      |
      = note: at $.conductors.bolts.conductance
      = help: the model has no "tables"
    "#);
}

#[test]
fn no_finite_value() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi / (2 - 2)"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[undefined-value]: `G_bi / (2 - 2)` divides by 0
     --> model.json:5:73
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi / (2 - 2)"}}}
      |                                                                         ^^^^^^^^^^^^^^
      |
      = note: at $.conductors.bolts.conductance
    "#);
}

#[test]
fn temperature_of_no_element() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}},
 "loads": {"board": {"into": "plate", "power": "0.1 * Ta"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[unknown-name]: unknown name `Ta`
     --> model.json:6:55
      |
    6 |  "loads": {"board": {"into": "plate", "power": "0.1 * Ta"}}}
      |                                                       ^^
      |
      = note: at $.loads.board.power
      = help: Ta, Tb and Tm are known inside conductors, radiations and flows
    "#);
}

#[test]
fn decimal_comma() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "0,5"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[expression-syntax]: unexpected `,`
     --> model.json:5:74
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "0,5"}}}
      |                                                                          ^ an operator: commas separate arguments of functions
      |
      = note: at $.conductors.bolts.conductance
      = help: a decimal is written with a point
    "#);
}

#[test]
fn place_behind_an_escape() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi \u002a Gbi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[unknown-name]: unknown name `Gbi`
     --> model.json:5:85
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi \u002a Gbi"}}}
      |                                                                                     ^^^
      |
      = note: at $.conductors.bolts.conductance
      = help: did you mean `G_bi`?
    "#);
}

#[test]
fn dimension_clash() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}, "A": {"unit": "m2", "nominal": 1}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "A"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    warning[unit-clash]: a conductance in W/K is expected; the expression is in m2
     --> model.json:5:72
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "A"}}}
      |                                                                        ^^^ something in W/K
      |
      = note: at $.conductors.bolts.conductance
    "#);
}

#[test]
fn sum_of_unlike_things() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}, "A": {"unit": "m2", "nominal": 1}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi + A"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    warning[unit-clash]: the units clash: something in W/K is added to something in m2
     --> model.json:5:72
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi + A"}}}
      |                                                                        ^^^^^^^^^^
      |
      = note: at $.conductors.bolts.conductance
    "#);
}

#[test]
fn exponential_of_a_temperature() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi * exp(Tm)"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    warning[unit-clash]: the units clash: exp is taken of something in K
     --> model.json:5:72
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi * exp(Tm)"}}}
      |                                                                        ^^^^^^^^^^^^^^^^
      |
      = note: at $.conductors.bolts.conductance
    "#);
}

#[test]
fn too_deep() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((1))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[expression-depth]: the expression is nested deeper than 64 levels
     --> model.json:5:137
      |
    5 | ...((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((1)))))))))))))))))))))))))))))))))))))))))))))))))))))))))))...
      |                                                                    ^
      |
      = note: at $.conductors.bolts.conductance
    "#);
}
