//! Functions, special functions, ordered sums, dense and sparse linear algebra, root finding.

pub mod functions;
