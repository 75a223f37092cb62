//! Tests of `core/src/inference/prior/score.rs`.

use super::transform::every_kind;
use bmv::inference::prior::score::*;
use bmv::math::special::normal_quantile;
use bmv::random::Distribution;

#[test]
fn scores_invert_and_slopes_agree_with_differences() {
    for prior in every_kind() {
        let score = Score::new(&prior, [prior.quantile(0.3)]).expect("a score");
        for z in [-2.5, -0.7, 0.05, 1.1, 2.8] {
            let here = score.at(z);
            assert!((score.of(here.value) - z).abs() < 1e-9, "{prior:?} {z}");
            let difference = (score.at(z + 1e-5).value - score.at(z - 1e-5).value) / 2e-5;
            assert!((difference / here.slope - 1.0).abs() < 1e-6, "{prior:?} {z}: {difference} {}", here.slope);
        }
    }
}

#[test]
fn the_prior_itself_has_the_standard_normal_score() {
    for prior in every_kind() {
        let score = Score::new(&prior, [prior.quantile(0.5)]).expect("a score");
        if matches!(score, Score::Probability(_)) {
            for u in [0.01, 0.3, 0.5, 0.9] {
                assert!((score.of(prior.quantile(u)) - normal_quantile(u)).abs() < 1e-9, "{prior:?} {u}");
            }
        }
    }
}

#[test]
fn draws_far_out_in_a_tail_get_the_coordinate_of_the_support() {
    let prior = Distribution::HalfNormal { scale: 1.0 };
    assert!(matches!(Score::new(&prior, [0.5]), Ok(Score::Probability(_))));
    let score = Score::new(&prior, [0.5, 9.0]).expect("a score");
    assert!((score.at(score.of(9.0)).value - 9.0).abs() < 1e-12);
    // At a bound the score stays finite.
    assert!(Score::Probability(Distribution::Uniform { lower: 0.0, upper: 1.0 }).of(1.0).is_finite());
}
