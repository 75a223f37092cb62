//! Tests of `core/src/expression/unit.rs`.

use bmv::expression::dimension::Dimension;
use bmv::expression::unit::*;

#[test]
fn a_coulomb_is_most_likely_meant_for_celsius() {
    let instead = |text: &str| Unit::parse(text).expect("a unit").without_coulomb();
    assert_eq!(instead("C").as_deref(), Some("degC"));
    assert_eq!(instead("W/C").as_deref(), Some("W/K"));
    assert_eq!(instead("J/(kg C)").as_deref(), Some("J/(kg K)"));
    for other in ["degC", "°C", "℃", "W/K", "cd", "mC", "1"] {
        assert_eq!(instead(other), None, "{other}");
    }
}

#[test]
fn conversions_by_hand() {
    for (text, value, si) in [
        ("degC", 20.0, 293.15),
        ("mW/K", 800.0, 0.8),
        ("W/(m2 K)", 3.0, 3.0),
        ("W m-2 K-1", 3.0, 3.0),
        ("kJ/(kg.K)", 0.9, 900.0),
        ("%", 86.0, 0.86),
        ("min", 2.0, 120.0),
        ("h", 1.5, 5400.0),
        ("d", 1.0, 86_400.0),
        ("mbar", 1.0, 100.0),
        ("cm^2", 50.0, 0.005),
        ("cm²", 50.0, 0.005),
        ("L/min", 60.0, 1e-3),
        ("deg", 180.0, std::f64::consts::PI),
        ("1/K", 0.1, 0.1),
        ("g/kg", 1.0, 1e-3),
        ("µm", 1.0, 1e-6),
        ("um", 1.0, 1e-6),
        ("Wh", 1.0, 3600.0),
        ("mΩ", 185.0, 0.185),
        ("W / m2 / K", 1.0, 1.0),
        ("ppm/K", 1.0, 1e-6),
    ] {
        let unit = Unit::parse(text).expect(text);
        assert!((unit.to_si(value) - si).abs() <= 1e-15 * si.abs().max(1e-6) * 4.0, "{text}: {}", unit.to_si(value));
        assert!((unit.from_si(unit.to_si(value)) - value).abs() <= 1e-12 * value.abs(), "{text}");
    }
    assert_eq!(Unit::parse("degC").expect("known").difference_to_si(0.25), 0.25);
    assert_eq!(Unit::parse("mK").expect("known").difference_to_si(250.0), 0.25);
}

#[test]
fn dimensions_are_worked_out() {
    let dimension = |text: &str| Unit::parse(text).expect(text).dimension;
    assert_eq!(dimension("W/K"), Dimension::CONDUCTANCE);
    assert_eq!(dimension("J/(s K)"), Dimension::CONDUCTANCE);
    assert_eq!(dimension("V A"), Dimension::POWER);
    assert_eq!(dimension("V/A"), Dimension::RESISTANCE);
    assert_eq!(dimension("T m2"), dimension("Wb"));
    assert_eq!(dimension("C/V"), dimension("F"));
    assert_eq!(dimension("W/K^1.25").times(Dimension::TEMPERATURE.power(1.25)), Dimension::POWER);
    assert!(dimension("rad").is_none() && dimension("sr").is_none() && dimension("lm/cd").is_none());
    assert_eq!(dimension("W/K^1.25").to_string(), "kg m2/(s3 K^1.25)");
    assert_eq!(dimension("kg/m3").to_string(), "kg/m3");
    assert_eq!(dimension("m2").to_string(), "m2");
}

#[test]
fn faults_have_places_and_help() {
    for (text, start, end, help) in [
        ("Watt", 0, 4, Some("write `W`")),
        ("W/Kelvin", 2, 8, Some("write `K`")),
        ("celsius", 0, 7, Some("write `degC`")),
        ("MBAR", 0, 4, Some("did you mean `mbar`?")),
        ("W/degC", 2, 6, Some("write `K`: a difference of 1 degC is 1 K")),
        ("W//K", 2, 3, None),
        ("(W", 0, 1, None),
        ("", 0, 0, Some("write `1` for a number without unit")),
        ("m^99", 1, 4, None),
        ("10 W", 0, 2, Some("put the number into the value, or use a prefix such as `k` or `m`")),
        ("W/(1000 K)", 3, 5, Some("put the number into the value, or use a prefix such as `k` or `m`")),
    ] {
        let error = Unit::parse(text).expect_err(text);
        assert_eq!((error.start, error.end, error.help.as_deref()), (start, end, help), "{text}: {error}");
    }
}
