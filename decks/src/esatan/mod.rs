//! Readers of ESATAN and ESATAN-TMS models: results with the model in them (`.TMD`), dumps as CSV, and the text of a
//! model (`.d`).
//!
//! Temperatures of ESATAN are in degC and become K here. The heat into a node is `QS + QA + QE + QI + QR`: solar,
//! albedo, planet, internal and other.

mod csv;
mod rows;
mod text;
mod tmd;

pub use csv::read_csv;
pub use text::read_text;
pub use tmd::read_tmd;

/// The forms in which ESATAN models are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// HDF5 file of the thermal model's data: [`read_tmd`].
    Tmd,
    /// Dump of nodes, conductors or temperatures as CSV: [`read_csv`].
    Csv,
    /// Text of a model: [`read_text`].
    Text,
}

/// The form of a file by its contents, if it is one of ESATAN's. Any HDF5 file counts as [`Form::Tmd`], whose reader
/// says what it lacks. The name decides nothing: models are met as `.d`, `.txt`, `.tpl` and `.DAT`.
pub fn recognises(bytes: &[u8]) -> Option<Form> {
    if bytes.starts_with(b"\x89HDF\r\n\x1a\n") {
        return Some(Form::Tmd);
    }
    let head = String::from_utf8_lossy(bytes.get(..bytes.len().min(65536))?);
    if head.trim_start().starts_with("ESATAN") && head.lines().any(|line| line.starts_with("TIME,")) {
        return Some(Form::Csv);
    }
    let first = head.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'))?;
    let word = first.split_whitespace().next()?;
    word.eq_ignore_ascii_case("$MODEL").then_some(Form::Text)
}

/// Stefan-Boltzmann constant in W/(m2 K4) where a form states none. The steady cases that ESATAN 2017 sp2 wrote for
/// `mlauryn/EsatanOpt` close 3 to 75 times better with it than with the CODATA value.
const DEFAULT_STEFAN_BOLTZMANN: f64 = 5.6686e-8;
