//! Results against stored references made by other programs.

mod arviz;
mod nist;
mod poisson;
mod posteriordb;
