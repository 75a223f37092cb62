//! Point sets in the open unit cube by index: Monte Carlo, Latin hypercube, scrambled Sobol.

use thiserror::Error;

use super::sobol::{MAX_DIMENSIONS, Sobol};
use super::stream::{Stream, StreamKey};

/// First of the streams that order a Latin hypercube's slices, one a dimension; the points' own stream is 0.
const FIRST_PERMUTATION_STREAM: u64 = 1;

/// Kind of a point set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointKind {
    /// Independent uniform points.
    MonteCarlo,
    /// One point in each of N equal slices of every dimension, at random within it (McKay, Beckman & Conover 1979).
    LatinHypercube,
    /// Scrambled Sobol points.
    Sobol,
}

/// A point set that cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum PointsError {
    /// More dimensions than there are direction numbers.
    #[error("{dimensions} dimensions are too many for Sobol points, which have at most {MAX_DIMENSIONS}")]
    TooManyDimensions {
        /// Dimensions asked for.
        dimensions: usize,
    },
    /// More points than a Latin hypercube can number.
    #[error("{samples} points are too many for a Latin hypercube, which has at most 4294967295")]
    TooManySamples {
        /// Points asked for.
        samples: usize,
    },
    /// No points or no dimensions.
    #[error(
        "a point set needs at least one point and one dimension, but has {samples} points of {dimensions} dimensions"
    )]
    Empty {
        /// Points asked for.
        samples: usize,
        /// Dimensions asked for.
        dimensions: usize,
    },
}

/// Points of (0, 1)^d. Each point depends on its index alone (a Latin hypercube's also on their number), so the first
/// 1000 of 2000 Monte Carlo or Sobol points are the 1000 of before.
#[derive(Clone, Debug)]
pub struct Points {
    key: StreamKey,
    dimensions: usize,
    set: Set,
}

#[derive(Clone, Debug)]
enum Set {
    MonteCarlo,
    /// Slice of each point, for each dimension.
    LatinHypercube(Vec<Vec<u32>>),
    Sobol(Sobol),
}

impl Points {
    /// A set of `samples` points in `dimensions` dimensions. A Latin hypercube keeps a table of 4 bytes a coordinate and takes
    /// points beyond `samples` from the start again.
    ///
    /// # Errors
    /// [`PointsError`] for an empty set or too many Sobol dimensions.
    pub fn new(kind: PointKind, key: StreamKey, samples: usize, dimensions: usize) -> Result<Self, PointsError> {
        if samples == 0 || dimensions == 0 {
            return Err(PointsError::Empty { samples, dimensions });
        }
        let set = match kind {
            PointKind::MonteCarlo => Set::MonteCarlo,
            PointKind::LatinHypercube => {
                let size = u32::try_from(samples).map_err(|_| PointsError::TooManySamples { samples })?;
                let stream = |dimension| key.stream(FIRST_PERMUTATION_STREAM + dimension as u64);
                Set::LatinHypercube((0..dimensions).map(|dimension| permutation(size, stream(dimension))).collect())
            }
            PointKind::Sobol => {
                Set::Sobol(Sobol::scrambled(dimensions, &key).ok_or(PointsError::TooManyDimensions { dimensions })?)
            }
        };
        Ok(Self { key, dimensions, set })
    }

    /// Dimensions of each point.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// Writes one point; `row` is as long as the dimensions.
    pub fn fill_row(&self, index: usize, row: &mut [f64]) {
        self.fill_rows(index, row);
    }

    /// Writes the points from index `first` on, row after row, as many as `rows` holds: the same bits as one by one.
    pub fn fill_rows(&self, first: usize, rows: &mut [f64]) {
        let d = self.dimensions;
        match &self.set {
            Set::MonteCarlo => {
                let mut stream = self.key.stream(0);
                stream.seek(first as u64 * d as u64);
                stream.fill_uniform(rows);
            }
            Set::LatinHypercube(permutations) => {
                let mut stream = self.key.stream(0);
                stream.seek(first as u64 * d as u64);
                for (offset, row) in rows.chunks_exact_mut(d).enumerate() {
                    for (x, permutation) in row.iter_mut().zip(permutations) {
                        let slice = permutation[(first + offset) % permutation.len()];
                        let value = (f64::from(slice) + stream.uniform()) / permutation.len() as f64;
                        // In the last slice rounding could reach 1.
                        *x = value.min(1.0 - f64::EPSILON / 2.0);
                    }
                }
            }
            Set::Sobol(sobol) => {
                let mut words = vec![0; d];
                for (offset, row) in rows.chunks_exact_mut(d).enumerate() {
                    let index = (first + offset) as u64;
                    if offset == 0 {
                        sobol.words(index, &mut words);
                    } else {
                        sobol.advance(index, &mut words);
                    }
                    sobol.coordinates(&words, row);
                }
            }
        }
    }
}

/// A random order of 0..size (Fisher & Yates, as in Knuth 1969, algorithm P).
pub fn permutation(size: u32, mut stream: Stream) -> Vec<u32> {
    let mut places: Vec<u32> = (0..size).collect();
    for last in (1..places.len()).rev() {
        places.swap(last, stream.below(last + 1));
    }
    places
}
