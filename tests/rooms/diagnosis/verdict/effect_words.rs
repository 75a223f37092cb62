//! Tests of `core/src/diagnosis/verdict/effect_words.rs`.

use bmv::diagnosis::output::EffectResult;
use bmv::diagnosis::verdict::effect_words::*;

use super::words::effect;

#[test]
fn why_errors_of_the_model_may_be_it_is_said_where_it_is_so() {
    let of = |model_error: f64, prior_width: f64| {
        or_model_error(&EffectResult { model_error, prior_width, ..effect(0.03) }, Likeness::None)
    };
    assert!(of(0.04, 1.0).is_empty());
    assert_eq!(of(0.13, 1.0), " Errors of the model itself explain as much with probability 13.0 %.");
    assert!(of(0.5, 10.0).starts_with(" It explains less than what else is missing"));
    assert_eq!(
        of(0.5, 100.0),
        " Errors of the model itself may be all that it stands for: half of the probability is given to them."
    );
    let pulled = or_model_error(&EffectResult { model_error: 0.5, ..effect(0.03) }, Likeness::Gradient);
    assert!(pulled.starts_with(" A gradient within the node would read the same"), "{pulled}");
    let warm = or_model_error(&EffectResult { model_error: 0.5, ..effect(0.03) }, Likeness::Source);
    assert!(warm.starts_with(" These surroundings are warmer than every boundary"), "{warm}");
    let few = or_model_error(&EffectResult { model_error: 0.5, ..effect(0.03) }, Likeness::Phases);
    assert!(few.starts_with(" There are hardly more phases than the curve has values"), "{few}");
}

#[test]
fn the_value_that_is_adopted_stands_beside_a_mean_that_lies_elsewhere() {
    assert_eq!(size(&effect(0.0308)), ", conductance 0.031 ± 0.013 W/K");
    assert_eq!(size(&effect(0.0347)), ", conductance 0.031 ± 0.013 W/K (most probable with all others 0.03470 W/K)");
}
