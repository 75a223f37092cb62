//! What reports say of a diagnosis: on the first screen and in its own section.

use bmv::diagnosis::Output;
use bmv::diagnosis::output::{EffectHeat, GroupKind, Precedence};
use bmv::job::diagnose::Kind;
use serde_json::{Value, json};

use super::rendering::{assert_well_formed, rendered, section};
use super::samples::{Sample, edit, entry, steady};

fn effect(id: &str, probability: f64, group: Option<u64>) -> Value {
    let parts: Vec<&str> = id.split(':').collect();
    json!({"id": id, "effect": parts[0], "title": "Path between two nodes", "where": parts[1..].to_vec(), "where_kind": "nodes",
        "input": null, "probability": probability, "log_bayes_factor": 41.25, "log_bayes_factor_scales": null, "group": group,
        "amplitudes": {"conductance": {"value": 0.0491, "sd": 0.0031, "most_probable": 0.0490, "unit": "W/K", "at_bound": false}},
        "rmse_k": {"train": [0.71, 0.26], "held_out": [0.83, 0.27]}, "watts": [0.1, 2.0],
        "carries": [carried("board", "P01", 0.1), carried("board", "P02", 2.0), carried("baseplate", "P01", -0.1), carried("baseplate", "P02", -2.0)],
        "confused_with": ["radiative-path"], "separate": "another temperature"})
}

fn carried(node: &str, phase: &str, watts: f64) -> Value {
    json!({"node": node, "measurement": "balance test", "phase": phase, "time_s": null, "watts": watts})
}

/// A diagnosis of this verdict over two rivals.
pub fn output(verdict: &str) -> Output {
    let selected: Vec<&str> = match verdict {
        "identified" | "ambiguous" => vec!["conductive-path:baseplate:board"],
        _ => vec![],
    };
    let rival = if verdict == "ambiguous" { Some(1) } else { None };
    let experiment = json!({"between": ["conductive-path:baseplate:board", "radiative-path:baseplate:board"],
        "conditions": {"T_if": {"value": 313.15, "unit": "K"}}, "probability": 0.97, "repeat_probability": 0.6, "limits_ok": true,
        "predictions": {"board": [300.15, 301.15]}});
    let heat = |node: &str, phase: &str, watts: f64| json!({"node": node, "phase": phase, "time_s": null, "watts": watts, "sd": 0.1});
    serde_json::from_value(json!({
        "verdict": verdict, "words": ["The words of the diagnosis."], "probability_nothing": 1e-12, "probability_unexplained": 0.004,
        "misfit": {"reduced_chi2": 3.1, "family_wise_p": 1e-9, "rmse_k": {"train": 0.71, "held_out": 0.83},
            "tests": [{"name": "effects", "at": "conductive-path:baseplate:board", "p": 1e-9}]},
        "effects": [effect("conductive-path:baseplate:board", 0.9996, Some(1)), effect("radiative-path:baseplate:board", 0.08, rival),
            effect("heat-load:board", 2e-4, None), effect("heat-load:strap", 1e-5, None), effect("heat-load:radiator", 0.0, None)],
        "models": [{"effects": ["conductive-path:baseplate:board"], "log_evidence": -31.2, "probability": 0.91, "chi_square": 80.0,
            "rmse_k": {"train": 0.26, "held_out": 0.27}}],
        "selected": selected, "unseen": [], "detectable": {"heat-load:board": {"value": 0.0123, "unit": "W"}},
        "noise": {}, "separating_experiment": if verdict == "ambiguous" { experiment } else { Value::Null },
        "heat": [heat("board", "P01", 0.42), heat("strap", "P01", 0.05), heat("board", "P02", -0.9)],
        "goes_with": [{"node": "board", "input": "Q_1", "slope": 0.1, "p": 1e-4}],
        "held_out_test": null, "remaining_p": 0.4, "looked_at": [120, 7140, 40], "warnings": []
    }))
    .expect("an output")
}

/// A steady sample with a diagnosis of this verdict.
pub fn diagnosed(verdict: &str) -> Sample {
    let mut sample = steady();
    sample.results.push(entry::<Kind>("missing", "11", output(verdict)));
    sample
}

/// The Markdown of the report on such a sample: its first section, and that on the diagnosis.
fn reported(verdict: &str) -> (String, String) {
    let report = rendered(&diagnosed(verdict));
    for (_, svg) in &report.figures {
        assert_well_formed(svg);
    }
    let markdown = report.markdown.replace('\u{A0}', " ");
    let summary =
        markdown.split("## 1. Summary").nth(1).and_then(|rest| rest.split("\n## ").next()).expect("a summary");
    (summary.to_owned(), section(&markdown, "diagnosis"))
}

fn has(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{part} in {text}");
    }
}

#[test]
fn the_first_screen_says_what_is_missing_how_surely_and_what_it_does() {
    let (summary, own) = reported("identified");
    has(&summary, &["Tuned with proposed `conductive-path:baseplate:board`", "What is missing", "0.0491 ± 0.0031 W/K"]);
    has(
        &summary,
        &["**identified**: **Path** between `baseplate` and `board`: 0.0491 ± 0.0031 W/K", "bmv adopt sample/"],
    );
    has(
        &summary,
        &[
            "How sure: identified",
            "Probability that it is missing",
            "99.9 %",
            "0.83 → 0.27 K",
            "0.71 → 0.26 K",
            "no rival",
            "8.0 %",
        ],
    );
    has(&own, &["identified", "99.9 %", "The words of the diagnosis.", "2 more were fitted"]);
    assert!(!own.contains("heat-load:strap") && !own.contains("Verdict: Verdict"), "{own}");
    has(&summary, &["up to 2.0 W into `board`"]);
    has(&own, &["What the selected effects carry", "selected: `conductive-path:baseplate:board`."]);
    has(
        &own,
        &[
            "`board` | 0.10 | P01 | 1.1 | 2.0 | P02 |",
            "`baseplate` | \u{2212}2.0 | P02 | \u{2212}1.1 | \u{2212}0.10 | P01 |",
        ],
    );
    assert!(!own.contains("goes with"), "an effect explains the heat: {own}");
}

#[test]
fn the_first_screen_tells_the_steps_and_what_each_does_to_the_error() {
    let step = |effect: Option<&str>, train: [f64; 2], held_out: [f64; 2]| json!({"effect": effect, "probability": 0.62, "rmse_k": {"train": train, "held_out": held_out}, "alternatives": []});
    let shown = |steps: Vec<Value>| {
        let mut sample = diagnosed("ambiguous");
        let is_one = edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
            output.steps = serde_json::from_value(Value::from(steps.clone())).expect("steps");
        });
        assert!(is_one, "a diagnosis");
        let markdown = rendered(&sample).markdown.replace('\u{A0}', " ");
        markdown.split("## 2. ").next().expect("a summary").to_owned()
    };
    let first = step(Some("conductive-path:baseplate:board"), [0.71, 0.30], [0.83, 0.35]);
    let second = step(Some("heat-load:board"), [0.30, 0.26], [0.35, 0.36]);
    let summary = shown(vec![first.clone(), second.clone(), step(None, [0.26, 0.26], [0.36, 0.36])]);
    has(&summary, &["Error, step 1: 0.83 → 0.35 K", "`conductive-path:baseplate:board`, probability 62.0 %"]);
    has(&summary, &["Error, step 2: 0.35 → 0.36 K", "0.30 → 0.26 K", "No further effect is added."]);
    assert!(!summary.contains("What that does to the error"), "{summary}");
    // As many effects as a set may have: nothing was said of a further one.
    assert!(!shown(vec![first, second]).contains("No further effect"));
}

#[test]
fn rivals_are_named_with_the_phase_that_parts_them() {
    let (summary, own) = reported("ambiguous");
    let next = "tells `conductive-path:baseplate:board` from `radiative-path:baseplate:board`: `bmv diagnose sample/";
    has(
        &summary,
        &[next, "How sure: ambiguous", "1 rival", "radiative-path:baseplate:board", "with probability 97.0 %"],
    );
    has(&own, &["with probability 97.0 %; repeating the best old phase: 60.0 %", "27.00", "28.00"]);
}

/// Of effects that cannot be told apart the proposed one may be the less probable: the page leads with the group then.
#[test]
fn a_rival_that_is_more_probable_than_what_is_proposed_is_said_first() {
    let shown = |rival: f64| {
        let mut sample = diagnosed("ambiguous");
        assert!(edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
            (output.effects[0].probability, output.effects[1].probability) = (0.226, rival);
        }));
        rendered(&sample).markdown.replace('\u{A0}', " ").split("\n## ").nth(1).expect("a summary").to_owned()
    };
    let summary = shown(0.753);
    has(
        &summary,
        &[
            "**ambiguous**: **one of 2 effects** that these data cannot tell apart; proposed, with a probability of 22.6 %",
        ],
    );
    has(&summary, &["What is missing: One of 2 effects.", "more probable: `radiative-path:baseplate:board` 75.3 %"]);
    assert!(
        summary.contains("; to be proposed first makes an effect no surer") && !summary.contains("goes second"),
        "{summary}"
    );
    has(&summary, &["Log Bayes factors: 41.2", "the evidence against the model without it"]);
    let summary = shown(0.1);
    assert!(!summary.contains("One of 2 effects") && !summary.contains("more probable"), "{summary}");
}

/// Where all of a group are laws of one thing, that is said, and from 0.91 on it is what is missing: the law alone is open then.
#[test]
fn what_all_laws_of_a_group_are_is_said_before_the_one_that_is_proposed() {
    let shown = |probability: f64| {
        let mut sample = diagnosed("ambiguous");
        assert!(edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
            (output.effects[0].probability, output.effects[1].probability) = (0.52, probability - 0.52);
            let what = "a path for heat between `baseplate` and `board`".to_owned();
            output.kinds = vec![GroupKind { group: 1, what, open: "whose law".to_owned(), probability }];
        }));
        let markdown = rendered(&sample).markdown.replace('\u{A0}', " ");
        (markdown.split("\n## ").nth(1).expect("a summary").to_owned(), section(&markdown, "diagnosis"))
    };
    let (summary, own) = shown(0.97);
    let path = "a path for heat between `baseplate` and `board`";
    has(&own, &[&format!("**ambiguous**: missing is {path}, whose law is open.")]);
    let proposed = "whose law the data do not tell; proposed, with a probability of 52.0 %: **Path** between `baseplate` and `board`";
    has(&summary, &[&format!("missing is {path} (97.0 %), {proposed}"), "A path for heat between baseplate and board"]);
    has(
        &summary,
        &[
            "whose law is open; one of them: `conductive-path:baseplate:board`",
            "97.0 %",
            "Probability of what is called missing",
        ],
    );
    let (summary, own) = shown(0.6);
    assert!(!summary.contains("missing is") && !own.contains("missing is"), "{summary}{own}");
    has(&summary, &[&format!("**ambiguous**: {path} (60.0 %), {proposed}")]);
}

/// With several effects it is said before which of them, and by which rule.
#[test]
fn the_rule_by_which_a_less_probable_effect_is_proposed_stands_beside_its_rivals() {
    let mut sample = diagnosed("ambiguous");
    assert!(edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
        (output.effects[0].probability, output.effects[1].probability) = (0.226, 0.753);
        output.effects[0].precedence = Some(Precedence::Set);
        output.effects[2].group = Some(2);
        output.selected.push("heat-load:board".into());
    }));
    let summary = rendered(&sample).markdown.replace('\u{A0}', " ");
    let said = "more probable than `conductive-path:baseplate:board`: `radiative-path:baseplate:board` 75.3 % (the proposed one goes first: all \
                that is selected is more probable than what was fitted with the other in its place)";
    has(&summary, &[said]);
}

/// What comes nearest may be probable among what was fitted, and no explanation.
#[test]
fn an_unexplained_misfit_is_not_contradicted_by_a_table() {
    let shown = |unexplained: f64| {
        let mut sample = diagnosed("unexplained");
        assert!(edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
            (output.effects[0].probability, output.probability_unexplained) = (0.86, unexplained);
        }));
        rendered(&sample).markdown.replace('\u{A0}', " ")
    };
    let near = shown(0.004);
    has(&near, &["half of each probability is given to what no effect describes, and the rest compares", "| 86.0 % |"]);
    has(&near, &["How sure: unexplained: p &lt; 1e-6", "nothing that was fitted explains enough of it"]);
    has(&shown(0.97), &["nearest; none of them explains the misfit.", "How sure: unexplained: 97.0 %"]);
}

/// A size and the value at which it acts, or the time from which on it does, are one thing.
#[test]
fn a_size_is_stated_with_where_or_when_it_acts() {
    let shown = |name: &str, setting: Value| {
        let mut sample = diagnosed("identified");
        assert!(edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
            let effect = &mut output.effects[0];
            let mut size = effect.amplitudes.remove("conductance").expect("an amplitude");
            (size.value, size.unit) = (-1.46, "W".into());
            let setting = serde_json::from_value(setting.clone()).expect("an amount");
            effect.amplitudes = [("power".to_owned(), size), (name.to_owned(), setting)].into();
        }));
        let markdown = rendered(&sample).markdown.replace('\u{A0}', " ");
        (markdown.split("\n## ").nth(1).expect("a summary").to_owned(), section(&markdown, "diagnosis"))
    };
    let of = |value: f64, sd: f64, unit: &str| json!({"value": value, "sd": sd, "most_probable": value, "unit": unit, "at_bound": false});
    let mut level = of(285.32, 0.11, "K");
    level["level"] = json!({"of": "strap", "is_temperature": true});
    let (summary, own) = shown("below", level);
    has(&summary, &["power \u{2212}1.4600 ± 0.0031 W, below at strap = 12.17 ± 0.11 °C"]);
    has(&own, &["| power \u{2212}1.4600 ± 0.0031 W, below at strap = 12.17 ± 0.11 °C |"]);
    let (_, own) = shown("elapsed", of(7200.5, 60.0, "s"));
    has(&own, &["| power \u{2212}1.4600 ± 0.0031 W, from 2.000 ± 0.017 h after each start on |"]);
    let (_, own) = shown("date", of(7e6, 86400.0, "s"));
    has(&own, &["W, from 81.0 ± 1.0 d on |"]);
    let (_, own) = shown("date", of(37.9, 2.8, "1"));
    has(&own, &["W, from phase 38 ± 3 on |"]);
    let (_, own) = shown("date", of(0.1, 40.0, "1"));
    has(&own, &["W; date open |"]);
}

/// The first and the last minutes of a long record have one unit.
#[test]
fn times_of_one_table_of_heat_have_one_unit() {
    let mut sample = diagnosed("identified");
    assert!(edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
        let times = [2160.0, 48_708.0];
        for (one, time_s) in output.effects[0].carries.iter_mut().zip(times) {
            (one.phase, one.time_s) = (None, Some(time_s));
        }
    }));
    let markdown = rendered(&sample).markdown.replace('\u{A0}', " ");
    has(&section(&markdown, "diagnosis"), &["`board` | 0.10 | 0.6000 h | 1.1 | 2.0 | 13.53 h |"]);
}

#[test]
fn a_daily_load_is_stated_by_its_amplitude_and_the_time_of_its_maximum() {
    let mut sample = diagnosed("identified");
    assert!(edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
        let effect = &mut output.effects[0];
        let mut part = effect.amplitudes.remove("conductance").expect("an amplitude");
        (part.unit, part.sd) = ("W".into(), 0.01);
        let with = |value: f64| bmv::diagnosis::output::Amount { value, ..part.clone() };
        effect.effect = "daily-load".into();
        effect.amplitudes = [("cosine".to_owned(), with(0.0)), ("sine".to_owned(), with(-0.3))].into();
    }));
    let markdown = rendered(&sample).markdown.replace('\u{A0}', " ");
    let stated = "0.300 ± 0.010 W, largest 18.0 h after the record's start and every 24 h";
    has(markdown.split("\n## ").nth(1).expect("a summary"), &[stated, &format!("amplitude {stated}")]);
    has(&section(&markdown, "diagnosis"), &[stated]);
}

#[test]
fn what_is_settled_beside_what_is_open_is_the_next_step() {
    let mut sample = diagnosed("ambiguous");
    let is_one = edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
        output.discriminating_experiment = None;
        (output.effects[1].group, output.effects[2].group) = (Some(2), Some(2));
        output.selected.push("radiative-path:baseplate:board".into());
    });
    assert!(is_one, "a diagnosis");
    let summary = rendered(&sample).markdown.replace('\u{A0}', " ");
    let next = "conductive-path:baseplate:board` adopts what is settled; the rest stays open.";
    has(&summary, &["`bmv adopt sample/", next, "missing is **Path** between", "; open is **Path** between"]);
    let is_one = edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
        output.effects[2].group = None;
        output.effects[0].probability = 0.6;
    });
    assert!(is_one, "a diagnosis");
    has(&rendered(&sample).markdown.replace('\u{A0}', " "), &["these data do not settle that they are there."]);
}

#[test]
fn a_missing_hidden_node_is_drawn_as_a_node_with_its_conductance() {
    let mut sample = diagnosed("identified");
    let is_one = edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
        let effect = &mut output.effects[0];
        (effect.id, effect.effect) = ("hidden-node:board".into(), "hidden-node".into());
        (effect.place, effect.where_kind) = (vec!["board".into()], "node".into());
        output.selected = vec!["hidden-node:board".into()];
        output.models[0].effects.clone_from(&output.selected);
    });
    assert!(is_one, "a diagnosis");
    let report = rendered(&sample);
    let drawing = &report.figures.iter().find(|figure| figure.0 == "network").expect("a network").1;
    assert_well_formed(drawing);
    has(&drawing.replace('\u{A0}', " "), &["\nhidden node\n", "missing: hidden node, 0.0491 ± 0.0031 W/K"]);
}

/// What a whole surface loses has no one node: it is drawn where most of it goes, and says that it is not there alone.
#[test]
fn a_missing_effect_of_a_group_is_drawn_where_it_carries_most() {
    let mut sample = diagnosed("identified");
    let is_one = edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
        let effect = &mut output.effects[0];
        (effect.id, effect.effect) = ("radiation-to-ambient:panels".into(), "radiation-to-ambient".into());
        (effect.place, effect.where_kind) = (vec!["panels".into()], "group".into());
        effect.carries.retain(|own| own.node == "board");
        output.selected = vec!["radiation-to-ambient:panels".into()];
        output.models[0].effects.clone_from(&output.selected);
    });
    assert!(is_one, "a diagnosis");
    let report = rendered(&sample);
    let drawing = &report.figures.iter().find(|figure| figure.0 == "network").expect("a network").1;
    assert_well_formed(drawing);
    has(&drawing.replace(['\u{A0}', '\n'], " "), &["missing at all of", "panels: radiation to", "up to 2.0 W here"]);
    assert!(edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
        let back = output.effects[0].carries.iter().map(|own| EffectHeat {
            node: "baseplate".into(),
            watts: -own.watts,
            ..own.clone()
        });
        let back: Vec<EffectHeat> = back.collect();
        output.effects[0].carries.extend(back);
    }));
    let report = rendered(&sample);
    let drawing = &report.figures.iter().find(|figure| figure.0 == "network").expect("a network").1;
    assert!(!drawing.contains("missing at all"), "what goes from node to node is no heat at one: {drawing}");
}

#[test]
fn what_nothing_explains_is_shown_as_heat_by_node_and_phase() {
    let (summary, own) = reported("unexplained");
    has(&summary, &["something unknown", "board", "P02", "How sure: unexplained"]);
    has(&own, &["0.90 ± 0.10", "0.42 ± 0.10", "What the missing heat goes with", "Q_1"]);
    assert!(!own.contains("0.05 ± 0.10"), "noise is no row: {own}");
}

#[test]
fn an_adequate_model_comes_with_what_would_have_shown() {
    let shown = |p: f64, probability: f64| {
        let mut sample = diagnosed("adequate");
        assert!(edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
            output.misfit.family_wise_p = p;
            output.effects[0].probability = probability;
        }));
        let markdown = rendered(&sample).markdown.replace('\u{A0}', " ");
        let summary = markdown.split("\n## ").nth(1).expect("a summary").to_owned();
        (summary, section(&markdown, "diagnosis"))
    };
    // The words agree with the numbers beside them.
    for (p, probability, part) in [
        (0.015, 0.01, "noise alone leaves such a misfit with p = 0.015 only"),
        (0.4, 0.476, "`conductive-path:baseplate:board` is missing with a probability of 47.6 %"),
    ] {
        let (summary, own) = shown(p, probability);
        has(&summary, &["nothing that is sure", "no effect is needed by the level of the tests", part]);
        has(&own, &["no effect is needed by the level of the tests, but", part]);
        assert!(!summary.contains("nothing is missing that"), "{summary}");
    }
    let (summary, own) = shown(0.4, 0.01);
    has(&summary, &["nothing is missing that these data could show"]);
    has(&summary, &["nothing that shows", "120 effects and 7140 pairs", "How sure: adequate"]);
    has(&own, &["`heat-load` | 1 | 0.012 W | `board` | 0.012 W | `board` |", "none is needed"]);
    assert!(!summary.contains("What else it could be"), "{summary}");
}

#[test]
fn effects_that_change_nothing_are_counted_and_not_listed() {
    let mut sample = diagnosed("adequate");
    let is_one = edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
        for effect in output.effects.iter_mut().filter(|effect| effect.id.starts_with("heat-load")) {
            effect.changes_nothing = true;
        }
    });
    assert!(is_one, "a diagnosis");
    let report = rendered(&sample);
    let markdown = report.markdown.replace('\u{A0}', " ");
    let own = section(&markdown, "diagnosis");
    has(&own, &["`radiative-path`", "Of 3 more the best size is one that changes nothing."]);
    assert!(!own.contains("`heat-load` | `board`"), "{own}");
    // On a phone a row of this table is a list, each value beside its heading.
    has(&report.html, &["<div class=\"table stacks\"", "data-label=\"RMSE, held out [K]\""]);
}

#[test]
fn a_doubtful_start_stands_before_any_verdict() {
    for verdict in ["identified", "ambiguous", "unexplained", "adequate"] {
        let mut sample = diagnosed(verdict);
        let job = sample.results.last_mut().expect("a diagnosis");
        let doubts = vec![bmv::measurement::Doubt {
            code: "start-apart".into(),
            message: "the first readings of run lie apart from its start temperatures: board 12.73 K above".into(),
            repair: Some(r#""initial": {"measured": {}} starts at the first readings"#.into()),
        }];
        assert!(edit::<Kind>(job, |output| output.doubts = doubts), "a diagnosis");
        let lines = bmv::report::headline::headlines(job);
        assert!(lines[0].contains("board 12.73 K above. Repair: \"initial\": {\"measured\": {}}"), "{lines:?}");
        let report = rendered(&sample);
        let own = section(&report.markdown, "diagnosis");
        let at = own.find("12.73 K above").expect("it is said");
        assert!(at < own.find(verdict).expect("a verdict"), "{verdict}: {own}");
        assert!(own.contains("Repair: "), "{own}");
        // And on the first screen, before the states of the model.
        let (said, table) = (report.markdown.find("**Warning.** Data: "), report.markdown.find("| State of the model"));
        assert!(said.is_some() && said < table, "{verdict}");
    }
}

#[test]
fn one_held_out_block_has_no_standard_error_and_no_p_is_0() {
    let mut sample = diagnosed("identified");
    let is_one = edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
        output.held_out_test = Some(bmv::diagnosis::output::HeldOutTest {
            gain: 155.0,
            se: None,
            blocks: 1,
            chi_square: None,
            readings: 3,
            p: None,
            veto: false,
        });
        output.misfit.family_wise_p = 0.0;
        output.misfit.tests[0].p = 0.0;
        output.looked_at = [1, 0, 1];
    });
    assert!(is_one, "a diagnosis");
    let markdown = rendered(&sample).markdown.replace('\u{A0}', " ");
    let own = section(&markdown, "diagnosis");
    has(
        &own,
        &[
            "Held-out rows, in one block, which has no standard error: squared error falls by 155 in units",
            "1 set fitted",
        ],
    );
    has(&markdown, &["together p &lt; 1e-6."]);
    assert!(!markdown.contains("p = 0.") || !markdown.contains("p = 0 "), "{markdown}");
}

/// Rivals that predict temperatures far from all that were measured: the phase may break the hardware, or the model.
#[test]
fn a_phase_far_from_what_was_measured_is_said_to_be_extrapolated() {
    let text_at = |predicted: f64| {
        let mut sample = diagnosed("ambiguous");
        let is_one = edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
            let experiment = output.discriminating_experiment.as_mut().expect("an experiment");
            experiment.predictions = [("board".to_owned(), vec![predicted, predicted + 1.0])].into();
        });
        assert!(is_one, "a diagnosis");
        section(&rendered(&sample).markdown, "diagnosis").replace('\u{A0}', " ")
    };
    assert!(!text_at(300.15).contains("Extrapolated"), "{}", text_at(300.15));
    for far in [500.0, 120.0] {
        has(
            &text_at(far),
            &["Extrapolated: measured were ", "see first whether the hardware bears what is predicted."],
        );
    }
}

/// A group of one has no rival, and a column that says nothing is left out.
#[test]
fn groups_stand_in_the_table_where_they_tell_rivals() {
    let (_, of_rivals) = reported("ambiguous");
    has(
        &of_rivals,
        &["| Rivals |", "| group 1 |", "Effects of one group are rivals: these data cannot tell them apart."],
    );
    let (_, of_one) = reported("identified");
    assert!(!of_one.contains("| Rivals |") && !of_one.contains("group 1"), "{of_one}");
}

/// A test costs days in a chamber: none is the next step that is little better than guessing, or that the hardware may not bear.
#[test]
fn only_a_phase_that_is_worth_a_test_is_the_next_step() {
    let next = |change: &dyn Fn(&mut Output)| {
        let mut sample = diagnosed("ambiguous");
        assert!(edit::<Kind>(sample.results.last_mut().expect("a job"), |output| change(output)));
        let summary = rendered(&sample).markdown.replace('\u{A0}', " ").replace('\\', "");
        summary.lines().find(|line| line.starts_with("> **Next.**")).expect("a next step").to_owned()
    };
    let phase = |probability: f64, near_tested: bool| {
        next(&|output| {
            let experiment = output.discriminating_experiment.as_mut().expect("an experiment");
            (experiment.probability, experiment.near_tested) = (probability, near_tested);
        })
    };
    has(&phase(0.81, true), &["Measure a phase that tells `conductive-path:baseplate:board` from"]);
    for text in [phase(0.79, true), phase(0.99, false)] {
        assert!(!text.contains("Measure") && text.contains("lists what else it could be"), "{text}");
    }
    let step = |probability: f64| {
        next(&|output| {
            output.discriminating_experiment = None;
            let step = json!({"input": "Q_1", "from": {"value": 0.0, "unit": "W"}, "to": {"value": 2.5, "unit": "W"}, "like": "test",
                "duration_s": 9000.0, "slowest": "board", "time_constant_s": 3000.0, "probability": probability, "limits_ok": true,
                "near_tested": true, "was_set": true});
            let own = json!({"between": ["thermal-mass:board", "path-capacity:strap"], "step": step});
            output.only_in_transients = serde_json::from_value(own).expect("a step");
        })
    };
    let worth = "Measure a step of Q_1 from 0 to 2.5 W for 2.5 h: it tells `thermal-mass:board` from `path-capacity:strap` \
                 with probability 97.0 %.";
    has(&step(0.97), &[worth]);
    assert!(!step(0.62).contains("Measure"), "{}", step(0.62));
}

/// Errors beyond the noise, in which no test finds anything definite, are not called missing heat.
#[test]
fn where_the_tests_find_nothing_definite_nothing_is_said_to_be_missing() {
    let of = |only_small_errors: bool| {
        let mut sample = diagnosed("unexplained");
        assert!(edit::<Kind>(sample.results.last_mut().expect("a job"), |output| {
            output.only_small_errors = only_small_errors;
        }));
        rendered(&sample).markdown.replace('\u{A0}', " ")
    };
    let (definite, small) = (of(false), of(true));
    let missing = "something is missing, and nothing in the catalogue explains it";
    assert!(definite.matches(missing).count() >= 1 && !small.contains(missing), "{small}");
    has(&small, &["the tests find nothing definite: small errors everywhere may be all there is."]);
}
