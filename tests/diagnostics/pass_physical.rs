//! What the baseline model cannot have: values of the wrong sign, nodes that nothing leads to.

use crate::diagnostics::pass_study::Study;

#[test]
fn a_conductance_below_zero_at_the_nominal_values() {
    let study = Study::new();
    study.edit("model.json", r#""conductance": "G""#, r#""conductance": "-G""#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r#"
    error[out-of-range]: the conductance of the conductor `bolts` is -0.8 W/K at the nominal values
     --> study/model.json:6:71
      |
    6 |  "conductors": {"bolts": {"between": ["box", "plate"], "conductance": "-G"}, "strap": {"between": ["box", "panel"], "conductance": 0....
      |                                                                       ^^^^ 0 or more
      |
      = note: at $.conductors.bolts.conductance
    "#);
}

#[test]
fn other_values_with_a_sign() {
    for (from, to, said) in [
        (
            r#""0.85 * A""#,
            r#""0.85 * A - 1""#,
            "error[out-of-range]: the exchange area of the radiation `panel` is -0.966 m2 at",
        ),
        (r#""capacity": 900"#, r#""capacity": "900 * (A - 1)""#, "the heat capacity of the node `box` is -864 J/K at"),
        (r#""boundary": "T_s""#, r#""boundary": "T_s - 100""#, "the temperature of the node `shroud` is -10 K at"),
        // Of what depends on temperatures nothing is known but those of the boundaries: here 90 K and 293.15 K.
        (
            r#""conductance": 0.3"#,
            r#""conductance": "-1e-3 * Tm""#,
            "the conductance of the conductor `strap` is -0.09 W/K at",
        ),
        // In the second phase only the input is 0 degC, and in the environment 40 degC.
        (r#""conductance": "G""#, r#""conductance": "G * (T_if - 280)""#, "in the phase `P2` of `balance`"),
        (r#""conductance": "G""#, r#""conductance": "G * (300 - T_if)""#, "in the environment `hot`"),
    ] {
        let study = Study::new();
        study.edit("model.json", from, to);
        let found = study.said("pass-1.json");
        assert!(found.contains(said) && found.starts_with("error"), "{to}: {found}");
    }
}

#[test]
fn values_that_may_get_the_wrong_sign_are_warned_of() {
    for (from, to, said) in [
        ("[0.2, 1.4]", "[-0.2, 1.4]", "is -0.2 W/K where `G` is -0.2 (SI), which it may be"),
        (r#"{"uniform": [0.2, 1.4]}"#, r#"{"normal": {"mean": 0.8, "sd": 0.4}}"#, "which it may be"),
    ] {
        let study = Study::new();
        study.edit("pass-1.json", from, to);
        let found = study.said("pass-1.json");
        assert!(found.starts_with("warning[possibly-negative]") && found.contains(said), "{to}: {found}");
    }
}

#[test]
fn values_that_keep_their_sign_are_not_spoken_of() {
    for (from, to) in [
        (r#""conductance": 0.3"#, r#""conductance": "2e-3 * Tm""#),
        // Wrong at 90 K only, which its nodes need not meet.
        (r#""conductance": 0.3"#, r#""conductance": "2e-3 * (Tm - 150)""#),
        (r#""conductance": 0.3"#, r#""conductance": "0.3 * abs(Ta - Tb) ^ 0.25""#),
        (r#""conductance": 0.3"#, r#""conductance": 0"#),
        (r#""conductance": 0.3"#, r#""conductance": "G - G""#),
        (r#""conductance": 0.3"#, r#""conductance": "0.1 * max(0, T_if - 280)""#),
        // A heat has a direction.
        (r#""power": "Q""#, r#""power": "-Q""#),
    ] {
        let study = Study::new();
        study.edit("model.json", from, to);
        assert_eq!(study.said("pass-1.json"), "", "{to}");
    }
    for prior in [r#"{"halfnormal": 1}"#, r#"{"lognormal": {"median": 0.8, "factor": 2}}"#, r#"{"uniform": [0, 1]}"#] {
        let study = Study::new();
        study.edit("pass-1.json", r#"{"uniform": [0.2, 1.4]}"#, prior);
        study.edit("model.json", r#""capacity": 900"#, r#""capacity": "900 * G""#);
        assert_eq!(study.said("pass-1.json"), "", "{prior}");
    }
}

#[test]
fn a_value_below_zero_in_a_sample_is_named_with_its_element() {
    use bmv::thermal::{Network, Start, SteadyError};
    let pass = Study::new().load();
    let network = Network::compile(&pass.model, &[]).expect("a network");
    let mut workspace = network.workspace();
    network.set_parameters(&mut workspace, &[-0.3]);
    let error = network.solve_steady(&mut workspace, Start::Default).expect_err("refused");
    let (element, what, unit) = ("bolts".to_owned(), "conductance", "W/K");
    assert_eq!(error.to_string(), "the conductance of `bolts` is -0.3 W/K: it must be 0 or more");
    assert_eq!(error, SteadyError::Sign { element, what, unit, value: -0.3, above_zero: false });
    let mut batch = network.batch::<4>();
    batch.set_parameter(2, 0, -0.3);
    network.solve_steady_batch(&mut batch, Start::Default);
    let outcomes: Vec<bool> = (0..4).map(|lane| batch.outcome(lane).is_ok()).collect();
    assert_eq!(outcomes, [true, true, false, true]);
    // Effects are tried with either sign.
    let problem = bmv::study::problem(&pass);
    let network = Network::compile(&problem.model, &[]).expect("a network");
    let mut workspace = network.workspace();
    network.set_parameters(&mut workspace, &[-0.001]);
    assert!(network.solve_steady(&mut workspace, Start::Default).is_ok());
}

#[test]
fn a_node_that_nothing_leads_to() {
    let study = Study::new();
    study.edit("model.json", r#""panel": {"capacity": 300}"#, r#""panel": {"capacity": 300}, "lid": {"capacity": 5}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r#"
    error[unconnected-node]: nothing leads to the node `lid`: its temperature is undetermined
     --> study/model.json:5:128
      |
    5 | ... 900}, "panel": {"capacity": 300}, "lid": {"capacity": 5}},
      |                                       ^^^^^ a conductor, radiation, flow or cooler to another node
      |
      = note: at $.nodes.lid
      = help: connect the node, or leave it out
    "#);
    // What a pass adopts connects as well, and a given temperature needs no balance.
    let adopt =
        r#""adopt": {"seen": {"effect": {"conductive-path": {"where": ["lid", "box"]}}, "because": "seen"}}, "design""#;
    study.edit("pass-1.json", r#""design""#, adopt);
    assert_eq!(study.said("pass-1.json"), "");
    let study = Study::new();
    study.edit("model.json", r#""panel": {"capacity": 300}"#, r#""panel": {"capacity": 300}, "lid": {"boundary": 5}"#);
    assert_eq!(study.said("pass-1.json"), "");
}
