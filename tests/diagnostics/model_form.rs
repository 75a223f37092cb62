//! Models that are JSON, and wrong.

use super::rendered;

#[test]
fn unknown_field() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capcity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[unknown-field]: unknown field `capcity`
     --> model.json:4:22
      |
    4 |  "nodes": {"plate": {"capcity": 900}, "wall": {"boundary": "T_if"}},
      |                      ^^^^^^^^^
      |
      = note: at $.nodes.plate.capcity
      = help: did you mean `capacity`?
    "#);
}

#[test]
fn missing_field() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"]}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[missing-field]: missing field `conductance`
     --> model.json:5:26
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"]}}}
      |                          ^ `conductance`: a number, an expression, or {"value": 20, "unit": "degC"}
      |
      = note: at $.conductors.bolts
    "#);
}

#[test]
fn wrong_type() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": [900]}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[wrong-type]: an array cannot stand here
     --> model.json:4:34
      |
    4 |  "nodes": {"plate": {"capacity": [900]}, "wall": {"boundary": "T_if"}},
      |                                  ^^^^^ a number, an expression, or {"value": 20, "unit": "degC"}
      |
      = note: at $.nodes.plate.capacity
    "#);
}

#[test]
fn three_ends() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall", "plate"], "conductance": 1}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[wrong-length]: expected 2 members, found 3
     --> model.json:5:38
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall", "plate"], "conductance": 1}}}
      |                                      ^^^^^^^^^^^^^^^^^^^^^^^^^^ an array of 2, each a string
      |
      = note: at $.conductors.bolts.between
    "#);
}

#[test]
fn unknown_node() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plat", "wall"], "conductance": 1}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[unknown-reference]: unknown node `plat`
     --> model.json:5:39
      |
    5 |  "conductors": {"bolts": {"between": ["plat", "wall"], "conductance": 1}}}
      |                                       ^^^^^^ the name of a node
      |
      = note: at $.conductors.bolts.between[0]
      = help: did you mean `plate`?
    "#);
}

#[test]
fn both_ends_at_one_node() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "plate"], "conductance": 1}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[self-loop]: both ends are the node `plate`
     --> model.json:5:48
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "plate"], "conductance": 1}}}
      |                                                ^^^^^^^ two different nodes
      |
      = note: at $.conductors.bolts.between[1]
    "#);
}

#[test]
fn negative_conductance() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": -0.5}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[out-of-range]: a conductance of -0.5 W/K
     --> model.json:5:72
      |
    5 |  "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": -0.5}}}
      |                                                                        ^^^^ 0 or more
      |
      = note: at $.conductors.bolts.conductance
    "#);
}

#[test]
fn prior_upside_down() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8, "prior": {"uniform": [1.2, 0.4]}}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[invalid-prior]: the prior's lower bound 1.2 is above its upper bound 0.4
     --> model.json:3:78
      |
    3 |  "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8, "prior": {"uniform": [1.2, 0.4]}}},
      |                                                                              ^^^^^^^^^^ [lower, upper]
      |
      = note: at $.parameters.G_bi.prior.uniform
      = help: write [0.4, 1.2]
    "#);
}

#[test]
fn prior_of_unknown_kind() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8, "prior": {"unifrom": [0.4, 1.2]}}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[unknown-kind]: unknown kind `unifrom` of a prior
     --> model.json:3:67
      |
    3 |  "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8, "prior": {"unifrom": [0.4, 1.2]}}},
      |                                                                   ^^^^^^^^^ one of `uniform`, `normal`, `lognormal`, `loguniform`, `halfnormal`, `triangular`, `fixed`, `posterior` and `draws`
      |
      = note: at $.parameters.G_bi.prior.unifrom
      = help: did you mean `uniform`?
    "#);
}

#[test]
fn prior_with_kind_field() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8, "prior": {"kind": "uniform", "lower": 0.4, "upper": 1.2}}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[one-kind]: a prior needs exactly one kind, and this object has 3 keys
     --> model.json:3:66
      |
    3 |  "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8, "prior": {"kind": "uniform", "lower": 0.4, "upper": 1.2}}},
      |                                                                  ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ an object with one key of `uniform`, `normal`, `lognormal`, `loguniform`, `halfnormal`, `triangular`, `fixed`, `posterior` and `draws`
      |
      = note: at $.parameters.G_bi.prior
      = help: the kind is the key: {"uniform": ...}
    "#);
}

#[test]
fn sd_not_above_zero() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8, "prior": {"normal": {"mean": 1, "sd": -1}}}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[invalid-prior]: a standard deviation of -1 is not above 0
     --> model.json:3:95
      |
    3 |  "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8, "prior": {"normal": {"mean": 1, "sd": -1}}}},
      |                                                                                               ^^ a number above 0
      |
      = note: at $.parameters.G_bi.prior.normal.sd
    "#);
}

#[test]
fn nominal_outside_prior() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 800, "prior": {"uniform": [0.4, 1.2]}}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    warning[nominal-outside]: the nominal value 800 of `G_bi` lies outside its prior, 0.4 to 1.2 W/K
     --> model.json:3:52
      |
    3 |  "parameters": {"G_bi": {"unit": "W/K", "nominal": 800, "prior": {"uniform": [0.4, 1.2]}}},
      |                                                    ^^^ a value within the prior
      |
      = note: at $.parameters.G_bi.nominal
    "#);
}

#[test]
fn reserved_name() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"nominal": 290}, "sigma": {"nominal": 1}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[reserved-name]: the name `sigma` is reserved
     --> model.json:2:39
      |
    2 |  "inputs": {"T_if": {"nominal": 290}, "sigma": {"nominal": 1}},
      |                                       ^^^^^^^ a name that no expression already knows
      |
      = note: at $.inputs.sigma
      = help: rename it, for instance `sigma_0`
    "#);
}

#[test]
fn name_that_is_no_symbol() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"nominal": 290}, "Q-board": {"nominal": 1}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[invalid-name]: "Q-board" is no name of a parameter or input
     --> model.json:2:39
      |
    2 |  "inputs": {"T_if": {"nominal": 290}, "Q-board": {"nominal": 1}},
      |                                       ^^^^^^^^^ letters, digits and underscores, beginning with a letter
      |
      = note: at $.inputs["Q-board"]
      = help: write `Q_board`
    "#);
}

#[test]
fn name_with_a_slash() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {}, "wall": {"boundary": "T_if"}, "a/b": {}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[invalid-name]: the name "a/b" is not allowed: it holds '/'
     --> model.json:4:55
      |
    4 |  "nodes": {"plate": {}, "wall": {"boundary": "T_if"}, "a/b": {}},
      |                                                       ^^^^^ text without control characters, `:` or `/`
      |
      = note: at $.nodes["a/b"]
    "#);
}

#[test]
fn parameter_and_input_of_one_name() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"nominal": 290}, "G_bi": {"nominal": 1}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[duplicate-name]: `G_bi` is the name of an input and of a parameter
     --> model.json:2:39
      |
    2 |  "inputs": {"T_if": {"nominal": 290}, "G_bi": {"nominal": 1}},
      |                                       ^^^^^^
      |
     ::: model.json:3:17
      |
    3 |  "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
      |                 ------ the parameter
      |
      = note: at $.inputs.G_bi
      = help: rename one of them: expressions could not tell them apart
    "#);
}

#[test]
fn unknown_unit() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "Watt/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[unknown-unit]: unknown unit `Watt`
     --> model.json:3:35
      |
    3 |  "parameters": {"G_bi": {"unit": "Watt/K", "nominal": 0.8}},
      |                                   ^^^^ units look like W/K, W/(m2 K), mW, degC, 1
      |
      = note: at $.parameters.G_bi.unit
      = help: write `W`
    "#);
}

#[test]
fn unit_that_does_not_parse() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W//K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[unit-syntax]: expected a unit, found `/`
     --> model.json:3:37
      |
    3 |  "parameters": {"G_bi": {"unit": "W//K", "nominal": 0.8}},
      |                                     ^ units look like W/K, W/(m2 K), mW, degC, 1
      |
      = note: at $.parameters.G_bi.unit
    "#);
}

#[test]
fn celsius_in_a_product() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/degC", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[unit-syntax]: degC has an offset and cannot stand in a product
     --> model.json:3:37
      |
    3 |  "parameters": {"G_bi": {"unit": "W/degC", "nominal": 0.8}},
      |                                     ^^^^ units look like W/K, W/(m2 K), mW, degC, 1
      |
      = note: at $.parameters.G_bi.unit
      = help: write `K`: a difference of 1 degC is 1 K
    "#);
}

#[test]
fn unit_of_another_kind() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": {"value": 900, "unit": "J"}}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[wrong-dimension]: the unit `J` does not fit here
     --> model.json:4:57
      |
    4 |  "nodes": {"plate": {"capacity": {"value": 900, "unit": "J"}}, "wall": {"boundary": "T_if"}},
      |                                                         ^^^ a unit of J/K
      |
      = note: at $.nodes.plate.capacity.unit
    "#);
}

#[test]
fn boundary_below_zero_kelvin() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {}, "wall": {"boundary": -20}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[out-of-range]: a boundary temperature of -20 K
     --> model.json:4:46
      |
    4 |  "nodes": {"plate": {}, "wall": {"boundary": -20}},
      |                                              ^^^ a temperature above 0 K, or {"value": ..., "unit": "degC"}
      |
      = note: at $.nodes.wall.boundary
    "#);
}

#[test]
fn boundary_with_capacity() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {}, "wall": {"boundary": 290, "capacity": 3}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[one-kind]: the node `wall` has a boundary temperature and a heat capacity
     --> model.json:4:63
      |
    4 |  "nodes": {"plate": {}, "wall": {"boundary": 290, "capacity": 3}},
      |                                                               ^ either `boundary` or `capacity`, or neither
      |
      = note: at $.nodes.wall.capacity
      = help: a boundary's temperature is given, so its capacity plays no part: remove `capacity`
    "#);
}

#[test]
fn boundary_of_a_temperature() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {}, "wall": {"boundary": "T + 5"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[unknown-name]: unknown name `T`
     --> model.json:4:47
      |
    4 |  "nodes": {"plate": {}, "wall": {"boundary": "T + 5"}},
      |                                               ^
      |
      = note: at $.nodes.wall.boundary
      = help: T is known in a load's power and a node's capacity
    "#);
}

#[test]
fn range_upside_down() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20, "range": [60, -40]}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[out-of-range]: the range [60, -40] is not in order
     --> model.json:2:62
      |
    2 |  "inputs": {"T_if": {"unit": "degC", "nominal": 20, "range": [60, -40]}},
      |                                                              ^^^^^^^^^ [lower, upper], lower below upper
      |
      = note: at $.inputs.T_if.range
    "#);
}

#[test]
fn range_of_strings() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20, "range": ["low", 60]}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[needs-number]: a string cannot stand here: the value must be known
     --> model.json:2:63
      |
    2 |  "inputs": {"T_if": {"unit": "degC", "nominal": 20, "range": ["low", 60]}},
      |                                                               ^^^^^ a number, or {"value": 20, "unit": "degC"}
      |
      = note: at $.inputs.T_if.range[0]
    "#);
}

#[test]
fn table_that_falls() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}},
 "tables": {"louver": {"x": [300, 280], "y": [1, 2]}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[invalid-table]: x does not increase: 280 follows 300
     --> model.json:6:29
      |
    6 |  "tables": {"louver": {"x": [300, 280], "y": [1, 2]}}}
      |                             ^^^^^^^^^^ strictly increasing numbers
      |
      = note: at $.tables.louver.x
    "#);
}

#[test]
fn cooler_without_drive() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}},
 "coolers": {"tec": {"cold": "plate", "hot": "wall", "seebeck": 4e-4, "resistance": 0.2, "conductance": 4e-4, "couples": 8}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[one-kind]: a cooler has either `voltage` or `current`, and this one has neither
     --> model.json:6:14
      |
    6 |  "coolers": {"tec": {"cold": "plate", "hot": "wall", "seebeck": 4e-4, "resistance": 0.2, "conductance": 4e-4, "couples": 8}}}
      |              ^^^^^ exactly one of `voltage`, `current`
      |
      = note: at $.coolers.tec
    "#);
}

#[test]
fn cooler_stages_and_couples() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}},
 "coolers": {"tec": {"cold": "plate", "hot": "wall", "current": 1, "seebeck": 4e-4, "resistance": 0.2, "conductance": 4e-4, "couples": [8, 24]}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[wrong-length]: 2 numbers of couples for 1 stage
     --> model.json:6:136
      |
    6 | ... "conductance": 4e-4, "couples": [8, 24]}}}
      |                                     ^^^^^^^ 1, from cold to hot: one more than nodes in `interstage`
      |
      = note: at $.coolers.tec.couples
    "#);
}

#[test]
fn heater_without_control() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}},
 "heaters": {"trim": {"into": "plate", "power": 5}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[one-kind]: a heater has either `thermostat` or `proportional`, and this one has neither
     --> model.json:6:14
      |
    6 |  "heaters": {"trim": {"into": "plate", "power": 5}}}
      |              ^^^^^^ exactly one of `thermostat`, `proportional`
      |
      = note: at $.heaters.trim
      = help: a heater without control is one of the `loads`
    "#);
}

#[test]
fn thermostat_upside_down() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}},
 "heaters": {"trim": {"into": "plate", "power": 5, "thermostat": {"on_below": 280, "off_above": 270}}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[out-of-range]: the heater switches off above 270 K and on below 280 K
     --> model.json:6:97
      |
    6 |  "heaters": {"trim": {"into": "plate", "power": 5, "thermostat": {"on_below": 280, "off_above": 270}}}}
      |                                                                                                 ^^^ `off_above` above `on_below`
      |
      = note: at $.heaters.trim.thermostat.off_above
    "#);
}

#[test]
fn group_of_an_unknown_conductor() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}},
 "groups": {"bar": {"conductors": ["bolt"]}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[unknown-reference]: unknown conductor `bolt`
     --> model.json:6:36
      |
    6 |  "groups": {"bar": {"conductors": ["bolt"]}}}
      |                                    ^^^^^^ the name of a conductor
      |
      = note: at $.groups.bar.conductors[0]
      = help: did you mean `bolts`?
    "#);
}

#[test]
fn quantity_of_an_unknown_node() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}},
 "quantities": {"hot": {"temperature": "plaet"}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[unknown-reference]: unknown node `plaet`
     --> model.json:6:40
      |
    6 |  "quantities": {"hot": {"temperature": "plaet"}}}
      |                                        ^^^^^^^ the name of a node
      |
      = note: at $.quantities.hot.temperature
      = help: did you mean `plate`?
    "#);
}

#[test]
fn quantity_over_time_inside_another() {
    let text = r#"{"format": "bmv-network/1",
 "inputs": {"T_if": {"unit": "degC", "nominal": 20}},
 "parameters": {"G_bi": {"unit": "W/K", "nominal": 0.8}},
 "nodes": {"plate": {"capacity": 900}, "wall": {"boundary": "T_if"}},
 "conductors": {"bolts": {"between": ["plate", "wall"], "conductance": "G_bi"}},
 "quantities": {"hot": {"difference": [{"over_time": {"maximum": "plate"}}, "wall"]}}}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[nested-over-time]: a quantity over time cannot stand inside another quantity
     --> model.json:6:66
      |
    6 |  "quantities": {"hot": {"difference": [{"over_time": {"maximum": "plate"}}, "wall"]}}}
      |                                                                  ^^^^^^^ a quantity at an instant
      |
      = note: at $.quantities.hot.difference[0].over_time.maximum
    "#);
}

#[test]
fn nothing_in_it() {
    let text = r#"{"format": "bmv-network/1"}"#;
    insta::assert_snapshot!(rendered(text), @r#"
    error[empty-model]: the model has neither nodes nor quantities
     --> model.json:1:12
      |
    1 | {"format": "bmv-network/1"}
      |            ^^^^^^^^^^^^^^^ beside it "nodes", or "quantities" of an algebraic model
      |
      = note: at $.format
    "#);
}
