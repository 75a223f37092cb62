//! Tests of `src/import/logger/absolute_error.rs`.

use bmv::import::logger::absolute_error::*;
use bmv::import::logger::{Channel, Known, Said, Settings, propose, read};

fn of(name: &str, unit: &str, readings: &[f64]) -> Option<(f64, &'static str)> {
    let channel = Channel {
        name: name.into(),
        unit: Some(unit.into()),
        readings: readings.iter().map(|own| Some(*own)).collect(),
        ..Channel::default()
    };
    tolerance(&channel).map(|own| (own.tolerance_k, own.class))
}

#[test]
fn the_tolerance_is_that_of_the_type_at_the_readings() {
    let [first, third, platinum] =
        ["a thermocouple of IEC 60584 class 1", "a thermocouple of IEC 60584 class 3", "a Pt100 of IEC 60751 class A"];
    assert_eq!(of("TC box", "degC", &[-10.0, 80.0]), Some((1.5, first)));
    assert_eq!(of("TC oven", "degC", &[20.0, 500.0]), Some((2.0, first)));
    assert_eq!(of("TC1", "K", &[93.15, 293.15]), Some((2.7, third)));
    for name in ["PRT_IF", "Pt100 plate", "RTD 3", "PT1000_2"] {
        assert_eq!(of(name, "degC", &[-25.0, 100.0]), Some((0.35, platinum)), "{name}");
    }
    assert_eq!(of("optics", "degF", &[32.0]), Some((1.5, first)), "`pt` within a word is no platinum");
    assert_eq!(of("Q", "W", &[5.0]), None);
}

#[test]
fn every_sensor_of_an_import_has_an_absolute_error_that_is_said_to_be_assumed() {
    let log = "time [s],PRT 1 [degC],TC 2 [degC]\n0,20,20\n10,20.1,20.3\n20,20.05,20.2\n30,20.2,20.1\n";
    let map = "channel,name,measures\nPRT 1,warm,box\nTC 2,cold,panel\n";
    let settings = Settings { time: None, channels: Some(("map.csv".into(), map.into())) };
    let record = read(&[("a.csv".to_owned(), log.to_owned())], &settings).expect("understood");
    let known = Known { measured: vec!["box".into(), "panel".into()], ..Known::default() };
    let proposal = propose(&record, &known, &Said::default(), "data/log.csv").expect("proposed");
    let sensors = &proposal.measurement["transient"]["sensors"];
    let sd = |name: &str| sensors[name]["bias"]["prior"]["normal"]["sd"].as_f64();
    // The channel's own heading says what the map calls otherwise.
    assert_eq!((sd("warm"), sd("cold")), (Some(0.095), Some(0.75)));
    assert!(sensors["cold"]["description"].as_str().is_some_and(|words| words.contains("bias: assumed, 1.5 K")));
    let notes = proposal.notes.join("\n");
    assert!(notes.contains("is an assumption: 0.19 K (a Pt100 of IEC 60751 class A) for warm; 1.5 K"), "{notes}");
}
