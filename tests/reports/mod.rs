//! Rendered reports.

mod calibration;
mod history;
mod hostile;
mod rendering;
mod samples;
mod sensitivity;
