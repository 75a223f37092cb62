//! Model specifications of xija, the thermal models of the Chandra X-ray Observatory (`github.com/sot/xija`, read at
//! commit e2c9b61; specifications in `github.com/sot/chandra_models`).
//!
//! A specification is JSON: `comps`, the components in order with the arguments of their class, and `pars`, their fitted
//! parameters in the same order. xija writes rates, not heats: `dT/dt = sum (Tj - T) / tau + sum P` with `tau` in ks and
//! `P` in K/ks, and has no heat capacities. Here every node has [1000 J/K](NODE_CAPACITY_J_PER_K), so that `1 / tau` in
//! 1/ks is a conductance in W/K, `tau` a thermal resistance in K/W, and 1 K/ks is 1 W.
//!
//! `t` is in seconds from 1998-01-01 by the calendar (see [`date`]). The angles `pitch` and `roll` are inputs in `deg`;
//! expressions see them, as all inputs, in SI: in radians.

mod arguments;
mod assembly;
mod class;
mod component;
pub mod date;
mod earth;
mod electronics;
mod heater;
mod method;
mod network;
mod notes;
mod parameters;
mod pitch;
mod solar;
mod specification;

use crate::deck::Deck;
use crate::error::DeckError;

use assembly::Assembly;
use specification::Specification;

/// The capacity that stands for xija's 1 where its solver keeps the equations' rates (see [`read`]).
pub const NODE_CAPACITY_J_PER_K: f64 = 1000.0;

/// Whether a text looks like a specification: a JSON object with the lists `comps` and `pars`.
pub fn recognises(text: &str) -> bool {
    text.trim_start().starts_with('{')
        && ["\"comps\"", "\"pars\"", "\"class_name\""].iter().all(|key| text.contains(key))
}

/// Reads a specification; `name` is the file's name in errors.
///
/// With `evolve_method` 1, the default, xija's solver advances by 1.5 times the time that it covers; the capacities are
/// then divided by 1.5, so that an exact solution of the deck follows xija. A note says so.
///
/// # Errors
/// Text that is no specification; every component that is not understood or whose arguments or parameters do not fit.
pub fn read(name: &str, text: &str) -> Result<Deck, Vec<DeckError>> {
    let document = serde_json::from_str(text).map_err(|error| {
        let message = format!("not JSON: {error}; NaN and Infinity, which Python writes, must be replaced by numbers");
        vec![DeckError::at(name, error.line().max(1), message)]
    })?;
    let specification = Specification::read(name, text, &document)?;
    Assembly::new(&specification).finish()
}
