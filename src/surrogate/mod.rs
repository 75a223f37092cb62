//! Surrogates of expensive functions.
