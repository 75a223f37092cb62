//! Tests of `diagnosis/src/twin/score.rs`.

use bmv::diagnosis::Verdict;
use bmv::math::functions::ln;
use bmv::twin::answer::{Answer, StatedAmplitude, StatedModel};
use bmv::twin::score::*;
use bmv::twin::truth::{HiddenEffect, HiddenValue, NoiseTruth, Outside, Rival, Truth};

fn truth(ids: &[&str], size: f64) -> Truth {
    let effect = |id: &&str| HiddenEffect {
        id: (*id).to_owned(),
        effect: id.split(':').next().unwrap_or_default().to_owned(),
        place: Vec::new(),
        input: None,
        parameters: vec![HiddenValue { name: "a".into(), value: 1.0, unit: "W".into(), amplitude: true }],
        alone: 0.0,
    };
    Truth {
        effects: ids.iter().map(effect).collect(),
        outside: None,
        finer: None,
        parameters: Vec::new(),
        noise: NoiseTruth::AsStated,
        size,
        asked: (!ids.is_empty()).then_some(size),
        rivals: Some(vec![Rival { effects: vec!["z".into()], cosine: 0.9, delta2: 12.0 }]),
    }
}

fn answer(verdict: Verdict, selected: &[&str], probability: f64) -> Answer {
    let ids: Vec<String> = selected.iter().map(|id| (*id).to_owned()).collect();
    Answer {
        verdict,
        groups: ids.iter().map(|id| vec![id.clone()]).collect(),
        probabilities: ids.iter().map(|id| (id.clone(), probability)).collect(),
        models: vec![StatedModel { effects: ids.clone(), probability }],
        nothing: if ids.is_empty() { probability } else { 1.0 - probability },
        unexplained: 0.0,
        first_step: Vec::new(),
        amplitudes: ids
            .iter()
            .map(|id| StatedAmplitude { id: id.clone(), parameter: "a".into(), lower: 0.9, upper: 1.05 })
            .collect(),
        selected: ids,
    }
}

#[test]
fn rates_are_counted_by_kind() {
    let mut grouped = answer(Verdict::Ambiguous, &["p:2"], 0.5);
    grouped.groups = vec![vec!["p:1".into(), "p:2".into()]];
    let mut outside = truth(&[], 1.0);
    outside.outside = Some(Outside::Unlogged { node: "n".into() });
    let trials = vec![
        Trial { truth: truth(&[], 0.0), answer: answer(Verdict::Adequate, &[], 0.95) },
        Trial { truth: truth(&[], 0.0), answer: answer(Verdict::Identified, &["p:9"], 0.95) },
        Trial { truth: truth(&["p:1"], 1.0), answer: answer(Verdict::Identified, &["p:1"], 0.95) },
        Trial { truth: truth(&["p:1"], 1.0), answer: grouped },
        Trial { truth: truth(&["p:1"], 1.0), answer: answer(Verdict::Adequate, &[], 0.7) },
        Trial { truth: outside, answer: answer(Verdict::Unexplained, &[], 0.0) },
    ];
    let score = score(&trials);
    assert_eq!((score.false_alarms.hits, score.false_alarms.of), (1, 2));
    assert_eq!((score.false_alarms_correlated.of, score.cases), (0, 6));
    let [one] = score.sizes.as_slice() else { panic!("one size") };
    assert_eq!((one.all.found.hits, one.all.named.hits, one.all.grouped.hits, one.all.found.of), (2, 1, 2, 3));
    assert_eq!(one.separable.found.of, 3);
    assert_eq!(score.group_sizes, [(1, 2), (2, 1)]);
    assert_eq!((score.coverage.hits, score.coverage.of), (1, 1));
    // Sure: the first null rightly, the second wrongly, the first effect rightly.
    assert_eq!((score.sure_and_right.hits, score.sure_and_right.of), (2, 3));
    assert_eq!((score.outside_unexplained.hits, score.outside_misnamed.hits), (1, 0));
    let top = score.reliability.last().expect("a bin");
    assert_eq!((top.true_rate.hits, top.true_rate.of, top.stated), (1, 2, 0.95));
    let mean = (2.0 * ln(0.95) + ln(1.0 - 0.95) + 3.0 * ln(1e-6)) / 6.0;
    assert!((score.log_score.expect("cases") - mean).abs() < 1e-12, "{:?} {mean}", score.log_score);
}

#[test]
fn intervals_are_exact() {
    // Clopper and Pearson for 0 of 10 and 5 of 10 (tables of Fisher & Yates).
    let none = Rate::of([false; 10]);
    assert!((none.upper - 0.3085).abs() < 1e-4 && none.lower == 0.0);
    let half = Rate::of((0..10).map(|case| case < 5));
    assert!((half.lower - 0.1871).abs() < 1e-4 && (half.upper - 0.8129).abs() < 1e-4);
}
