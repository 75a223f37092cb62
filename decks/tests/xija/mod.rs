//! Specifications of xija: how they are read and refused, and the equations of their decks.

mod date;
mod equations;
mod expression;
mod network;
mod specification;
