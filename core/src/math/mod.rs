//! Functions, special functions, ordered sums, dense and sparse linear algebra, root finding, quadrature.

pub mod cholesky;
pub mod dense;
pub mod elimination;
pub mod functions;
pub mod lanes;
pub mod listed_lu;
pub mod ordering;
pub mod pivoting_lu;
pub mod quadrature;
pub mod root;
pub mod scalar_products;
pub mod sort;
pub mod sparse;
pub mod sparse_lu;
pub mod special;
pub mod sum;
