//! Tests of `core/src/inference/prior/joint_prior.rs`.

use bmv::inference::prior::joint_prior::*;
use bmv::random::{Distribution, Stream, StreamKey};

fn draws(count: usize, mut one: impl FnMut(&mut Stream) -> Vec<f64>) -> Vec<Vec<f64>> {
    let mut stream = StreamKey::new(3, "draws", "test").stream(0);
    (0..count).map(|_| one(&mut stream)).collect()
}

const WIDE: Distribution = Distribution::Normal { mean: 0.0, sd: 10.0, lower: None, upper: None };

fn fitted(base: [Distribution; 2], draws: &[Vec<f64>]) -> Result<JointPrior, JointPriorError> {
    JointPrior::new(&[0, 1], &["a", "b"], &base, draws, draws.len() as f64)
}

#[test]
fn normal_draws_are_described_with_their_correlation() {
    let draws = draws(4000, |s| {
        let (u, v) = (s.normal(), s.normal());
        vec![1.0 + 0.5 * u, -2.0 + 0.8 * u + 0.6 * v]
    });
    let prior = fitted([WIDE; 2], &draws).expect("normal");
    assert!(prior.fit().doubts.is_empty(), "{:?}", prior.fit());
    let (mean, slopes) = prior.at(&[0.0, 0.0]);
    // Five standard errors of the means, 0.5 and 1 over the root of 4000.
    assert!((mean[0] - 1.0).abs() < 0.04 && (mean[1] + 2.0).abs() < 0.08, "{mean:?}");
    let d = prior.derivatives(&slopes);
    let covariance = d[0] * d[2];
    assert!((covariance - 0.4).abs() < 5.0 * 0.64 / 4000.0_f64.sqrt(), "{covariance}");
    let back = prior.whitened(&prior.at(&[0.3, -1.2]).0);
    assert!((back[0] - 0.3).abs() < 1e-12 && (back[1] + 1.2).abs() < 1e-12);
}

#[test]
fn derivatives_are_pulled_back() {
    let base = [Distribution::Uniform { lower: 0.0, upper: 1.0 }, Distribution::HalfNormal { scale: 2.0 }];
    let draws = draws(500, |s| {
        let u = 0.3 * s.normal();
        vec![normal(0.1 + u), 1.0 + 0.3 * u + 0.1 * s.normal()]
    });
    let prior = fitted(base, &draws).expect("described");
    let f = |u: &[f64]| {
        let x = prior.at(u).0;
        x[0] * x[0] + 3.0 * x[1]
    };
    let at = [0.4, -0.6];
    let (x, slopes) = prior.at(&at);
    let mut gradient = [2.0 * x[0], 3.0];
    prior.pull_back(&slopes, &mut gradient);
    for i in 0..2 {
        let moved = |by: f64| {
            let mut point = at;
            point[i] += by;
            f(&point)
        };
        let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
        assert!((difference - gradient[i]).abs() < 1e-7, "{i}: {difference} {}", gradient[i]);
    }
    let d = prior.derivatives(&slopes);
    assert!((prior.log_slope(&slopes) - bmv::math::functions::ln(d[0] * d[3])).abs() < 1e-12);
}

fn normal(x: f64) -> f64 {
    bmv::math::special::normal_cdf(x)
}

#[test]
fn an_unseen_parameter_keeps_its_prior() {
    // Uniform in the box beside a well determined neighbour: normal in its score, not in itself.
    let base = [Distribution::Uniform { lower: 2.0, upper: 5.0 }, WIDE];
    let draws = draws(2000, |s| vec![base[0].quantile(s.uniform()), 1.0 + 0.01 * s.normal()]);
    assert!(fitted(base, &draws).expect("described").fit().doubts.is_empty());
}

#[test]
fn split_curved_and_one_sided_draws_are_refused_and_skewed_ones_doubted() {
    let what = |draws: &[Vec<f64>]| match fitted([WIDE; 2], draws) {
        Err(JointPriorError::NotNormal { what }) => what,
        other => panic!("{other:?}"),
    };
    let split = draws(2000, |s| {
        let side = if s.uniform() < 0.5 { -2.0 } else { 2.0 };
        vec![side + 0.3 * s.normal(), s.normal()]
    });
    assert!(what(&split).contains("quantile of `a`"));
    let one_sided = draws(2000, |s| vec![s.normal(), -bmv::math::functions::ln(s.uniform())]);
    assert!(what(&one_sided).contains("quantile of `b`"));
    // A ring: its marginals deviate by less, its distances by most.
    let ring = draws(2000, |s| {
        let (u, v) = (s.normal(), s.normal());
        let length = (u * u + v * v).sqrt();
        vec![u / length + 0.05 * s.normal(), v / length + 0.05 * s.normal()]
    });
    assert!(matches!(fitted([WIDE; 2], &ring), Err(JointPriorError::NotNormal { .. })));
    let skewed = draws(2000, |s| vec![s.normal(), bmv::math::functions::exp(0.3 * s.normal())]);
    let doubts = fitted([WIDE; 2], &skewed).expect("described").fit().doubts.clone();
    assert!(doubts.len() == 1 && doubts[0].contains("`b`"), "{doubts:?}");
}

#[test]
fn draws_without_spread_or_too_few_are_refused() {
    let same = draws(200, |s| vec![s.normal(), 1.0]);
    assert_eq!(fitted([WIDE; 2], &same), Err(JointPriorError::Degenerate { parameter: "b".into() }));
    let together = draws(200, |s| {
        let u = s.normal();
        vec![u, 2.0 * u + 1.0]
    });
    // A wide prior's scores bend a straight line by more than rounding: then it is the fit that is refused.
    assert!(fitted([WIDE; 2], &together).is_err());
    let few = draws(30, |s| vec![s.normal(), s.normal()]);
    assert!(matches!(fitted([WIDE; 2], &few), Err(JointPriorError::TooFew { .. })));
}
