//! Names and numbers that try to break a report.
