//! Readers of thermal models that other tools wrote: one [`Deck`] in SI units from each.
//!
//! A reader works on text or bytes that it is given and touches no file. It refuses what it does not understand, at its
//! line, and says in the deck's [notes](Deck::notes) what it assumed or left out.

mod arithmetic;
pub mod deck;
pub mod error;
pub mod esatan;
mod identifier;
pub mod sinda;
pub mod xija;

pub use deck::{
    Coupling, CouplingKind, Deck, Group, Heater, Input, Load, Node, NodeKind, Note, Parameter, Record, Table, Value,
};
pub use error::DeckError;

/// 0 degC in K (exact).
const CELSIUS_ZERO_K: f64 = 273.15;
