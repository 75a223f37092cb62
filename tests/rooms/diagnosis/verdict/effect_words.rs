//! Tests of `diagnosis/src/diagnosis/verdict/effect_words.rs`.

use bmv::diagnosis::output::{Amount, EffectHeat, EffectResult, Level, RmseChange};
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
    let lumped = or_model_error(&EffectResult { model_error: 0.5, ..effect(0.03) }, Likeness::LumpedNodes(0.062));
    assert!(lumped.starts_with(" Errors of 0.06 K, such as lumped nodes have"), "{lumped}");
}

#[test]
fn an_effect_that_only_the_held_out_rows_want_is_called_that() {
    let of = |log_bayes_factor: f64, held_out: [Option<f64>; 2]| {
        let rmse_k = RmseChange { held_out, ..effect(0.03).rmse_k };
        asked_for(&EffectResult { log_bayes_factor, rmse_k, ..effect(0.03) })
    };
    assert!(of(-2.0, [Some(1.2), Some(0.7)]).contains("the held-out rows alone do"));
    assert_eq!(of(2.0, [Some(1.2), Some(0.7)]), "");
    assert_eq!(of(-2.0, [None, None]), "");
    assert_eq!(of(-2.0, [Some(0.7), Some(1.2)]), "");
}

#[test]
fn the_value_that_is_adopted_stands_beside_a_mean_that_lies_elsewhere() {
    assert_eq!(size(&effect(0.0308), None), ", conductance 0.031 ± 0.013 W/K");
    assert_eq!(
        size(&effect(0.0347), None),
        ", conductance 0.031 ± 0.013 W/K (most probable with all others 0.03470 W/K)"
    );
}

/// In a group's law the node is one of several.
#[test]
fn heats_are_stated_in_watts_kilowatts_or_megawatts_and_of_a_group_by_its_largest_share() {
    let at = |phase: Option<&str>, watts: [f64; 2], where_kind: &str| {
        let (node, measurement) = ("tank".to_owned(), "day".to_owned());
        let time_s = phase.is_none().then_some(0.0);
        let carries = vec![EffectHeat { node, measurement, phase: phase.map(str::to_owned), time_s, watts: watts[0] }];
        carried(&EffectResult { watts: Some(watts), carries, where_kind: where_kind.to_owned(), ..effect(0.03) })
    };
    let of = |watts: [f64; 2], where_kind: &str| at(Some("P1"), watts, where_kind);
    assert_eq!(of([0.19, 0.49], "node"), ", which gives tank 0.19 to 0.49 W");
    let over_time = at(None, [0.19, 0.49], "node");
    assert_eq!(over_time, ", which gives tank 0.19 to 0.49 W (means over twelfths of each transient)");
    assert_eq!(of([-140_244.0, -99_969.0], "node"), ", which takes 100 to 140 kW from tank");
    assert_eq!(of([1.2e6, 2.4e6], "node"), ", which gives tank 1.2 to 2.4 MW");
    assert_eq!(of([0.87, 0.87], "group"), ", which gives tank 0.87 W and no other node more");
    assert_eq!(of([-0.5, -0.2], "group"), ", which takes 0.20 to 0.50 W from tank and from no other node more");
}

/// `date` comes before `power`.
#[test]
fn the_size_of_what_sets_in_is_not_when_it_does() {
    let amount = |value: f64, unit: &str| Amount {
        value,
        sd: 0.1 * value,
        most_probable: value,
        unit: unit.to_owned(),
        at_bound: false,
        level: None,
    };
    let amplitudes = [("date".to_owned(), amount(687.0, "s")), ("power".to_owned(), amount(2.0, "W"))].into();
    let load = EffectResult { amplitudes, ..effect(0.03) };
    assert_eq!(size(&load, load.amplitudes.get("date")), ", power 2.00 ± 0.20 W");
}

/// `at` comes before `change`; a temperature is stated as one reads it.
#[test]
fn the_value_at_which_an_effect_acts_stands_beside_its_size_with_what_it_is_a_value_of() {
    let of = |unit: &str, value: f64, level: Option<(&str, bool)>, at_bound: bool| Amount {
        value,
        sd: if at_bound { 0.0 } else { 0.02 },
        most_probable: value,
        unit: unit.to_owned(),
        at_bound,
        level: level.map(|(of, is_temperature)| Level { of: of.to_owned(), is_temperature }),
    };
    let with = |at: Amount| {
        let amplitudes = [("at".to_owned(), at), ("change".to_owned(), of("1", 0.42, None, false))].into();
        EffectResult { amplitudes, ..effect(0.03) }
    };
    let joint = with(of("K", 285.32, Some(("strap", true)), false));
    assert_eq!(size(&joint, None), ", change 0.420 ± 0.020");
    assert_eq!(level(&joint), ", at at `strap` = 12.170 ± 0.020 degC");
    assert_eq!(level(&with(of("K", 5.0, Some(("rise", false)), false))), ", at at `rise` = 5.000 ± 0.020 K");
    assert_eq!(level(&with(of("1", 3.0, Some(("speed", false)), true))), ", at at `speed` = 3.00 (at a bound)");
    assert_eq!(level(&effect(0.03)), "");
}

/// Two runs of 10 h, of which the second begins at 100 h by its own clock.
#[test]
fn a_date_is_stated_in_the_run_in_which_it_lies() {
    let hour = 3600.0;
    let run = |name, from: f64, begins: f64| Run {
        name,
        from: from * hour,
        to: (from + 10.0) * hour,
        begins_s: begins * hour,
    };
    let at = |when: f64, sd: f64| Amount {
        value: when * hour,
        sd: sd * hour,
        most_probable: when * hour,
        unit: "s".to_owned(),
        at_bound: false,
        level: None,
    };
    let runs = || vec![run("cold", 10.0, 100.0), run("hot", 0.0, 0.0)];
    assert_eq!(in_runs(&at(2.5, 0.1), runs()).unwrap(), ", from 2.50 ± 0.10 h of `hot` on");
    assert_eq!(in_runs(&at(12.5, 0.1), runs()).unwrap(), ", from 4.2708 ± 0.0042 d of `cold` on");
    for near in [at(9.96, 0.001), at(10.04, 0.001), at(9.0, 1.2), at(10.0, 40.0)] {
        assert_eq!(in_runs(&near, runs()).unwrap(), ", between `hot` and `cold`", "{near:?}");
    }
    assert_eq!(in_runs(&at(2.5, 0.1), vec![run("hot", 0.0, 0.0)]), None);
    let open = ", from a date that is open, most probably 3.0 h of `hot`";
    assert_eq!(in_runs(&at(3.0, 5.0), runs()).unwrap(), open, "half a run is not beside its end");
    // A date of which the runs say hardly anything is not stated to the hour.
    let alone = || vec![run("hot", 0.0, 10.0)];
    assert_eq!(in_runs(&at(4.567, 1.9), alone()), None);
    assert_eq!(in_runs(&at(4.567, 2.5), alone()).unwrap(), ", from a date that is open, most probably 4.6 h");
    assert_eq!(in_runs(&at(0.25, 0.01), runs()).unwrap(), ", from 15.00 ± 0.60 min of `hot` on");
}
