//! Rendered reports.
