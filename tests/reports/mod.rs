//! Rendered reports.

mod calibration;
pub mod diagnosis;
mod figures;
mod history;
mod hostile;
mod rendering;
mod samples;
mod sensitivity;
