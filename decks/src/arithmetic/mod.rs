//! Arithmetic of decks: numbers and names with `+ - * / **`, brackets and the usual functions, as in Fortran.

pub(crate) mod piece;
pub(crate) mod quantity;
