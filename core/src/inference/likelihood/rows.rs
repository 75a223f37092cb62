//! Readings told apart by content: which of them two fits share.
//!
//! A posterior that was had from readings may not be a prior for the same readings: they would count twice. A steady
//! reading is known by its phase, the inputs there, its sensor and its value, in whatever file it lies; a transient one,
//! whose coarse values repeat by chance, by its file, instant, sensor and value.

use crate::document::hash::sha256_hex;
use crate::inference::likelihood::is_used;
use crate::measurement::{Measurement, Rows};

/// A row of a measurement with the readings that a fit uses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UsedRow {
    /// Phase, or instant in seconds with its unit.
    pub label: String,
    /// Sensor and SHA-256 of each reading.
    pub readings: Vec<(String, String)>,
}

impl UsedRow {
    /// SHA-256 of the row's readings together.
    pub fn sha256(&self) -> String {
        let all: Vec<&str> = self.readings.iter().map(|(_, hash)| hash.as_str()).collect();
        sha256_hex(all.join(" ").as_bytes())
    }
}

/// The rows of a measurement that a fit uses: neither held out nor ignored, with a reading.
pub fn used_rows(measurement: &Measurement) -> Vec<UsedRow> {
    let mut rows = Vec::new();
    for row in 0..measurement.len() {
        let (label, origin) = match &measurement.rows {
            Rows::Steady(phases) => {
                let inputs: Vec<u64> = phases[row].inputs.iter().map(|value| value.to_bits()).collect();
                (phases[row].name.clone(), format!("{inputs:?}"))
            }
            Rows::Transient { inputs, .. } => (format!("{} s", inputs.times_s[row]), measurement.sha256.clone()),
        };
        let readings: Vec<(String, String)> = (0..measurement.sensors.len())
            .filter(|&sensor| is_used(measurement, row, sensor))
            .filter_map(|sensor| {
                let name = &measurement.sensors[sensor].name;
                let bits = measurement.reading(row, sensor)?.to_bits();
                Some((name.clone(), sha256_hex(format!("{label:?} {origin} {name:?} {bits}").as_bytes())))
            })
            .collect();
        if !readings.is_empty() {
            rows.push(UsedRow { label, readings });
        }
    }
    rows
}
