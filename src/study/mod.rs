//! Model and pass as written, inheritance, resolution to SI and names, measurements, pinned data.

pub mod model;
