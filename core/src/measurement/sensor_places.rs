//! The sensors of measurements as places of effects.

use crate::effect::SensorPlace;
use crate::measurement::{Measurement, Rows};

/// Sensors of measurements, each name with each quantity once.
pub fn sensor_places<'m>(measurements: impl Iterator<Item = &'m Measurement>) -> Vec<SensorPlace> {
    let mut places: Vec<SensorPlace> = Vec::new();
    for measurement in measurements {
        let steady = matches!(measurement.rows, Rows::Steady(_));
        for sensor in &measurement.sensors {
            match places.iter_mut().find(|place| place.name == sensor.name && place.quantity == sensor.quantity) {
                Some(place) => {
                    place.steady |= steady;
                    place.transient |= !steady;
                }
                None => places.push(SensorPlace {
                    name: sensor.name.clone(),
                    quantity: sensor.quantity,
                    steady,
                    transient: !steady,
                }),
            }
        }
    }
    places
}
