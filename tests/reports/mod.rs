//! Rendered reports.

mod hostile;
mod rendering;
mod samples;
