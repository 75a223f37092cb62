//! The absolute error of a logged thermometer, as far as its name and readings tell: the tolerance of its type, which a
//! calibration certificate replaces.

use serde_json::{Value, json};

use super::record::Channel;
use crate::report::number::significant;

/// Words in small letters, without the numbers behind them, that name platinum resistance thermometers.
const PLATINUM: &[&str] = &["pt", "prt", "rtd"];
/// Below this temperature, degC, IEC 60584-1 has class 3 alone for base-metal thermocouples.
const COLD_C: f64 = -40.0;

/// A tolerance, and whose it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Largest error over the readings, K, to two digits.
    pub tolerance_k: f64,
    /// Type and class of the thermometer.
    pub class: &'static str,
}

/// The tolerance that the type of a temperature channel has at its readings; `None` where it reads no temperature.
///
/// Platinum resistance: 0.15 K + 0.002 |t| of class A (IEC 60751). All others count as thermocouples of type K or N
/// (IEC 60584-1): the larger of 1.5 K and 0.004 |t| of class 1, below -40 degC of 2.5 K and 0.015 |t| of class 3.
pub fn tolerance(channel: &Channel) -> Option<Tolerance> {
    let celsius = |value: f64| match channel.unit.as_deref() {
        Some("degC") => Some(value),
        Some("K") => Some(value - 273.15),
        Some("degF") => Some((value - 32.0) / 1.8),
        _ => None,
    };
    let known: Vec<f64> = channel.readings.iter().flatten().filter_map(|value| celsius(*value)).collect();
    let coldest = known.iter().copied().reduce(f64::min)?;
    let largest = known.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let words = |text: &str| text.split(|c: char| !c.is_alphanumeric()).map(str::to_lowercase).collect::<Vec<_>>();
    let is_platinum = [words(&channel.name), words(&channel.label)]
        .iter()
        .flatten()
        .any(|word| PLATINUM.contains(&word.trim_end_matches(|c: char| c.is_ascii_digit())));
    let (tolerance, class) = if is_platinum {
        (0.15 + 0.002 * largest, "a Pt100 of IEC 60751 class A")
    } else if coldest < COLD_C {
        ((0.015 * largest).max(2.5), "a thermocouple of IEC 60584 class 3")
    } else {
        ((0.004 * largest).max(1.5), "a thermocouple of IEC 60584 class 1")
    };
    Some(Tolerance { tolerance_k: significant(tolerance, 2).parse().unwrap_or(tolerance), class })
}

impl Tolerance {
    /// The sensor's `bias`: normal about 0, with the tolerance as two standard deviations.
    pub fn bias(&self) -> Value {
        json!({"prior": {"normal": {"mean": 0, "sd": self.tolerance_k / 2.0}}, "unit": "K"})
    }

    /// What the sensor's `description` says of it.
    pub fn in_words(&self) -> String {
        format!("bias: assumed, {} K of {} as two standard deviations", self.tolerance_k, self.class)
    }
}

/// What to know of the absolute errors that were assumed; `None` where none was.
pub fn note(assumed: &[(String, Tolerance)]) -> Option<String> {
    let mut classes: Vec<(Tolerance, Vec<&str>)> = Vec::new();
    for (name, own) in assumed {
        match classes.iter_mut().find(|(other, _)| other == own) {
            Some((_, names)) => names.push(name),
            None => classes.push((*own, vec![name])),
        }
    }
    let listed: Vec<String> = (classes.iter())
        .map(|(own, names)| format!("{} K ({}) for {}", own.tolerance_k, own.class, names.join(", ")))
        .collect();
    (!listed.is_empty()).then(|| {
        format!(
            "the absolute error of each sensor, its `bias`, is an assumption: {}; replace it by the calibration certificate's or the \
             type's",
            listed.join("; ")
        )
    })
}
