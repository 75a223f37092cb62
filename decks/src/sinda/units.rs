//! Units of a deck: what its numbers are multiplied by. Thermal Desktop states them in comments `TDUNITS, Energy = J`, and
//! so may anyone.

use super::block::Block;
use crate::{CELSIUS_ZERO_K, DeckError};

/// Energies in J. BTU is that of the International Table.
const ENERGIES: [(&str, f64); 6] =
    [("J", 1.0), ("KJ", 1e3), ("WHR", 3600.0), ("WH", 3600.0), ("BTU", 1_055.055_852_62), ("CAL", 4.1868)];
/// Times in s.
const TIMES: [(&str, f64); 8] = [
    ("S", 1.0),
    ("SEC", 1.0),
    ("SECOND", 1.0),
    ("MIN", 60.0),
    ("MINUTE", 60.0),
    ("HR", 3600.0),
    ("H", 3600.0),
    ("HOUR", 3600.0),
];
/// Lengths in m.
const LENGTHS: [(&str, f64); 7] =
    [("M", 1.0), ("CM", 0.01), ("MM", 1e-3), ("IN", 0.0254), ("INCH", 0.0254), ("FT", 0.3048), ("FEET", 0.3048)];
/// Degrees in K, and the temperature of 0 in K.
const TEMPERATURES: [(&str, (f64, f64)); 4] = [
    ("K", (1.0, 0.0)),
    ("C", (1.0, CELSIUS_ZERO_K)),
    ("R", (5.0 / 9.0, 0.0)),
    ("F", (5.0 / 9.0, 459.67 * (5.0 / 9.0))),
];

/// What one unit of the deck is in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Units {
    /// Energy in J.
    pub(super) joule: f64,
    /// Time in s.
    pub(super) second: f64,
    /// Length in m.
    pub(super) metre: f64,
    /// A degree in K.
    pub(super) kelvin_per_degree: f64,
    /// The temperature of 0 in K.
    pub(super) zero_k: f64,
}

impl Units {
    /// SI units with K.
    pub(super) const SI: Self = Self { joule: 1.0, second: 1.0, metre: 1.0, kelvin_per_degree: 1.0, zero_k: 0.0 };

    /// Power in W.
    pub(super) fn watt(&self) -> f64 {
        self.joule / self.second
    }

    /// A temperature in K.
    pub(super) fn kelvin(&self, degrees: f64) -> f64 {
        degrees * self.kelvin_per_degree + self.zero_k
    }
}

/// Units that comments state.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct Stated {
    pub(super) joule: Option<f64>,
    pub(super) second: Option<f64>,
    pub(super) metre: Option<f64>,
    /// A degree in K, and the temperature of 0 in K.
    pub(super) temperature: Option<(f64, f64)>,
}

/// The units that the comments of a deck state.
pub(super) fn stated(blocks: &[Block<'_>], errors: &mut Vec<DeckError>) -> Stated {
    let mut stated = Stated::default();
    for (block, comment) in blocks.iter().flat_map(|block| block.comments.iter().map(move |comment| (block, comment))) {
        let Some(unit) = comment.text.strip_prefix("TDUNITS,") else { continue };
        let Some((name, unit)) = unit.split_once('=') else { continue };
        let name = name.trim().to_ascii_uppercase();
        let done = match name.as_str() {
            "ENERGY" => find(&ENERGIES, unit).map(|value| stated.joule = Some(value)),
            "TIME" => find(&TIMES, unit).map(|value| stated.second = Some(value)),
            "LENGTH" => find(&LENGTHS, unit).map(|value| stated.metre = Some(value)),
            "TEMP" => find(&TEMPERATURES, unit).map(|value| stated.temperature = Some(value)),
            _ => Ok(()),
        };
        if let Err(known) = done {
            let message = format!(
                "{} in {}: expected one of {known}; write the deck in one of these units",
                name.to_ascii_lowercase(),
                unit.trim()
            );
            errors.push(DeckError::at(block.file, comment.line, message));
        }
    }
    stated
}

/// The value of a unit by its name, or all names.
fn find<T: Copy>(known: &[(&str, T)], unit: &str) -> Result<T, String> {
    let plain: String = unit.chars().filter(char::is_ascii_alphabetic).map(|c| c.to_ascii_uppercase()).collect();
    let found = known.iter().find(|(name, _)| *name == plain || plain.strip_suffix('S') == Some(name));
    found.map(|(_, value)| *value).ok_or_else(|| known.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", "))
}
