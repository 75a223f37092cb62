//! Tests of `diagnosis/src/diagnosis/verdict/one_kind.rs`.

use bmv::diagnosis::Problem;
use bmv::diagnosis::output::EffectResult;
use bmv::diagnosis::verdict::one_kind::{laws, one_kind};
use bmv::thermal::NodeKind;

use super::words::{effect, star};

/// An effect at a place, with the heat that it gives there.
fn at(problem: &Problem, name: &str, place: &[&str], watts: [f64; 2]) -> EffectResult {
    let is_it = |own: &&bmv::effect::Candidate| own.effect == name && own.place == place;
    let candidate = problem.candidates.iter().find(is_it).unwrap_or_else(|| panic!("{name} at {place:?}"));
    EffectResult {
        id: candidate.id.clone(),
        effect: name.to_owned(),
        place: candidate.place.clone(),
        input: candidate.input.clone(),
        watts: Some(watts),
        ..effect(0.03)
    }
}

/// What the effects at these places are together.
fn together(problem: &Problem, own: &[(&str, &[&str], [f64; 2])]) -> Option<String> {
    let effects: Vec<EffectResult> = own.iter().map(|(name, place, watts)| at(problem, name, place, *watts)).collect();
    let effects: Vec<&EffectResult> = effects.iter().collect();
    let (what, open) = one_kind(&effects, problem)?;
    Some(format!("{what}, {open} the readings do not tell ({})", laws(&effects)))
}

#[test]
fn laws_of_one_thing_at_one_place_are_called_that() {
    let problem = star();
    let of = |is_boundary: bool| {
        let is_it = |kind: &NodeKind| matches!(kind, NodeKind::Boundary { .. }) == is_boundary;
        problem.model.nodes.iter().filter(|node| is_it(&node.kind)).map(|node| node.name.as_str()).collect::<Vec<_>>()
    };
    let (inner, outer) = (of(false), of(true));
    let (a, b, sink) = (inner[0], inner[1], outer[0]);
    let loss = [-3.0, -1.0];
    let between = |end| if a < end { [a, end] } else { [end, a] };
    let to_sink = between(sink);
    let losses: [(&str, &[&str], [f64; 2]); 3] =
        [("free-convection", &[a], loss), ("radiation-to-ambient", &[a], loss), ("conductive-path", &to_sink, loss)];
    assert_eq!(
        together(&problem, &losses).as_deref(),
        Some(&*format!(
            "a loss of heat from `{a}` to its surroundings, whose law the readings do not tell (free-convection, \
             radiation-to-ambient or conductive-path)"
        ))
    );
    let a_pair = between(b);
    let paths: [(&str, &[&str], [f64; 2]); 2] = [("conductive-path", &a_pair, loss), ("radiative-path", &a_pair, loss)];
    let said = together(&problem, &paths).expect("one path");
    assert!(said.starts_with("a path for heat between `") && said.contains("whose law"), "{said}");
    let heats: [(&str, &[&str], [f64; 2]); 2] = [("heat-load", &[a], [0.5, 0.5]), ("dated-load", &[a], [0.0, 1.0])];
    assert_eq!(
        together(&problem, &heats).as_deref(),
        Some(&*format!(
            "heat dissipated in `{a}`, whose dependence on time and inputs the readings do not tell (heat-load or dated-load)"
        ))
    );
    let elsewhere: [(&str, &[&str], [f64; 2]); 2] = [("heat-load", &[a], [0.5, 0.5]), ("heat-load", &[b], [0.5, 0.5])];
    assert_eq!(together(&problem, &elsewhere), None);
    // A store of heat is one kind wherever it is: inside a path, or hidden behind a node.
    let is_joint = |own: &&bmv::effect::Candidate| own.effect == "path-capacity" && !own.is_group();
    let joint = problem.candidates.iter().find(is_joint).expect("conductors").place.clone();
    let joint: Vec<&str> = joint.iter().map(String::as_str).collect();
    let said_of_store = |node: &str| {
        let swing = [-0.5, 0.5];
        together(&problem, &[("path-capacity", &joint, swing), ("hidden-node", &[node], swing)]).expect("stores")
    };
    let said: Vec<String> = inner.iter().map(|node| said_of_store(node)).collect();
    let elsewhere = "a heat capacity that the model lacks, whose place and coupling the readings do not tell (path-capacity or hidden-node)";
    assert!(said.iter().any(|own| own == elsewhere), "{said:?}");
    assert!(
        said.iter().all(|own| own == elsewhere || own.starts_with("a heat capacity that the model lacks at `")),
        "{said:?}"
    );
    let mixed: [(&str, &[&str], [f64; 2]); 2] = [("heat-load", &[a], [0.5, 0.5]), ("conductive-path", &a_pair, loss)];
    assert_eq!(together(&problem, &mixed), None);
    assert_eq!(together(&problem, &losses[..1]), None);
}
