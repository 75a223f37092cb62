//! Samplers of a posterior. `chains`: what all have in common, `parts`: chains that go on after a stop, `convergence`: split
//! R-hat and effective samples. `nuts` (with `metric`), `metropolis`, `smc` (with `proposal`), all tuned by `adaptation`;
//! `independence` and `importance` about a fit (with `student`), the latter smoothed by `psis`.

pub mod adaptation;
pub mod chains;
pub mod convergence;
pub mod importance;
pub mod independence;
pub mod metric;
pub mod metropolis;
pub mod nuts;
pub mod parts;
mod proposal;
pub mod psis;
pub mod smc;
pub mod student;
