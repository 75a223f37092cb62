//! Model and pass as written, inheritance, resolution to SI and names, measurements, pinned data.

pub mod discover;
pub mod evidence;
pub mod folder;
pub mod inherit;
pub mod pass;
pub mod pinned;
pub mod profile;
pub mod rule;
pub mod table;
pub mod window;
pub mod model;
