//! Rendered reports.

mod calibration;
mod hostile;
mod rendering;
mod samples;
mod sensitivity;
