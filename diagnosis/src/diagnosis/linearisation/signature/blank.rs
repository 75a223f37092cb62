//! Measurements whose residuals are predictions: readings of 0 with noise of 1.

use crate::measurement::{Measurement, Uncertain};

/// A measurement with a reading of 0 everywhere.
pub(super) fn blank(measurement: &Measurement) -> Measurement {
    let mut blank = measurement.clone();
    blank.readings.fill(Some(0.0));
    for sensor in &mut blank.sensors {
        sensor.sigma = Some(Uncertain::Known(1.0));
        sensor.correlation_time_s = None;
        sensor.white = None;
    }
    blank
}
