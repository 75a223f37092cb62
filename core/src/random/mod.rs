//! Named, indexed random streams, distributions by their quantiles, Latin hypercube and scrambled Sobol points.

pub mod distribution;
pub mod points;
pub mod sobol;
pub mod stream;
mod truncated;

pub use distribution::{Distribution, DistributionError};
pub use points::{PointKind, Points, PointsError};
pub use stream::{Stream, StreamKey};
