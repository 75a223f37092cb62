//! Tests of `diagnosis/src/diagnosis/fits/controlled_heat.rs`.

use bmv::diagnosis::fits::controlled_heat::is_controlled;

/// What holds a temperature in the last two is not the logged heat: a thermostat that is not logged, or a path that opens.
#[test]
fn a_heat_under_control_falls_at_the_level_and_goes_on_changing() {
    let full = [100.0, 100.0, 98.0, 100.0];
    assert!(is_controlled(&full, &[60.0, 45.0, 52.0, 48.0], 100.0));
    assert!(!is_controlled(&full, &[90.0, 80.0, 95.0, 85.0], 100.0), "hardly less at the level");
    assert!(
        !is_controlled(&[55.0, 60.0, 50.0], &[70.0, 20.0, 30.0], 120.0),
        "a car's fuel, on the way far below its largest"
    );
    assert!(!is_controlled(&[], &[50.0, 60.0], 100.0), "a run that begins at the level");
    assert!(!is_controlled(&full, &[0.0, 0.0, 0.0], 100.0), "a payload that is switched off, and a survival heater");
    assert!(!is_controlled(&full, &[60.0, 60.0, 60.0], 100.0), "a boost and then a constant power, and a heat pipe");
}
