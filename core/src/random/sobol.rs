//! Sobol points with Owen's scrambling, 64 bits a coordinate, any point by its index.
//!
//! Directions: S. Joe & F. Y. Kuo 2008 (SIAM J. Sci. Comput. 30, 2635), set D6, carried on to 64 bits by their recurrence.
//! Points come in Gray code order (Antonov & Saleev 1979). Nested uniform scrambling (Owen 1995) flips each digit by a
//! random bit that depends on all digits before it; the bits come from a hash of those digits, as Laine & Karras (2011)
//! and Burley (2020) do, here with a full-avalanche hash once for six digits.

use super::stream::StreamKey;

/// The first line belongs to the second dimension; the licence stands beside the file.
pub const DIRECTIONS: &str = include_str!("sobol_directions.txt");

/// Largest number of dimensions.
pub const MAX_DIMENSIONS: usize = 1024;

/// Leading digits scrambled each by all digits before it; later digits by these alone (of no effect below 2^30 points).
const NESTED_DIGITS: u32 = 30;
/// Digits decided by one hash: a binary tree of six levels has 63 nodes.
const DIGITS_A_HASH: u32 = 6;
/// Stream of a key from which the dimensions' scrambling seeds are read, apart from the points' own stream 0.
const SEED_STREAM: u64 = 1;

/// A Sobol sequence, plain or scrambled.
#[derive(Clone, Debug)]
pub struct Sobol {
    /// Dimensions of a point.
    pub dimensions: usize,
    /// Direction numbers: for each index bit, one word a dimension.
    directions: Vec<u64>,
    /// Scrambling seed of each dimension; empty without scrambling.
    seeds: Vec<u64>,
}

impl Sobol {
    /// The plain sequence; `None` for more than [`MAX_DIMENSIONS`] dimensions.
    pub fn plain(dimensions: usize) -> Option<Self> {
        (dimensions <= MAX_DIMENSIONS).then(|| Self {
            dimensions,
            directions: directions(dimensions),
            seeds: Vec::new(),
        })
    }

    /// The sequence scrambled with seeds from a key; `None` for more than [`MAX_DIMENSIONS`] dimensions.
    pub fn scrambled(dimensions: usize, key: &StreamKey) -> Option<Self> {
        let mut stream = key.stream(SEED_STREAM);
        let plain = Self::plain(dimensions)?;
        Some(Self { seeds: (0..dimensions).map(|_| stream.word()).collect(), ..plain })
    }

    /// Coordinates of a point (of the unscrambled sequence) as 64-bit fractions.
    pub fn words(&self, index: u64, words: &mut [u64]) {
        words.fill(0);
        let mut gray = index ^ (index >> 1);
        while gray != 0 {
            self.toggle(gray.trailing_zeros(), words);
            gray &= gray - 1;
        }
    }

    /// Turns the words of point `index - 1` into those of point `index` (at least 1).
    pub fn advance(&self, index: u64, words: &mut [u64]) {
        self.toggle(index.trailing_zeros(), words);
    }

    fn toggle(&self, bit: u32, words: &mut [u64]) {
        let start = bit as usize * self.dimensions;
        for (word, direction) in words.iter_mut().zip(&self.directions[start..start + self.dimensions]) {
            *word ^= direction;
        }
    }

    /// Coordinates strictly inside (0, 1) from a point's words, scrambled where the sequence is.
    pub fn coordinates(&self, words: &[u64], row: &mut [f64]) {
        if self.seeds.is_empty() {
            row.iter_mut().zip(words).for_each(|(x, &word)| *x = super::stream::uniform_of(word));
        }
        for ((x, &word), &seed) in row.iter_mut().zip(words).zip(&self.seeds) {
            *x = super::stream::uniform_of(scramble(word, seed));
        }
    }
}

/// Direction numbers to 64 bits, laid out as bit 0 of all dimensions, bit 1 of all dimensions, ...
fn directions(dimensions: usize) -> Vec<u64> {
    let mut table = vec![0; 64 * dimensions];
    let mut lines = DIRECTIONS.lines();
    for dimension in 0..dimensions {
        let mut column = [0_u64; 64];
        if dimension == 0 {
            column.iter_mut().enumerate().for_each(|(bit, v)| *v = 1 << (63 - bit));
        } else {
            let mut numbers = lines.next().unwrap_or_default().split_ascii_whitespace().filter_map(|n| n.parse().ok());
            let coefficients: u64 = numbers.next().unwrap_or_default();
            let mut degree = 0;
            for (bit, m) in numbers.enumerate() {
                column[bit] = m << (63 - bit);
                degree = bit + 1;
            }
            // v_i = a_1 v_(i-1) + ... + a_(s-1) v_(i-s+1) + v_(i-s) + v_(i-s) / 2^s, sums without carry.
            for bit in degree..64 {
                let mut v = column[bit - degree] ^ (column[bit - degree] >> degree);
                for k in 1..degree {
                    if (coefficients >> (degree - 1 - k)) & 1 == 1 {
                        v ^= column[bit - k];
                    }
                }
                column[bit] = v;
            }
        }
        for (bit, v) in column.into_iter().enumerate() {
            table[bit * dimensions + dimension] = v;
        }
    }
    table
}

/// Owen's scrambling of one coordinate.
fn scramble(word: u64, seed: u64) -> u64 {
    let mut flips = 0;
    for start in (0..NESTED_DIGITS).step_by(DIGITS_A_HASH as usize) {
        let before = if start == 0 { 0 } else { word >> (64 - start) };
        let tree = mix(seed ^ mix(before | (u64::from(start) << 58)));
        // The tree's level l has its nodes, one for each value of the l digits before, at bits 2^l - 1 onwards.
        let digits = (word << start) >> (64 - DIGITS_A_HASH);
        for level in 0..DIGITS_A_HASH {
            let node = (1 << level) - 1 + (digits >> (DIGITS_A_HASH - level));
            flips = (flips << 1) | ((tree >> node) & 1);
        }
    }
    let rest = 64 - NESTED_DIGITS;
    let below = mix(seed ^ mix((word >> rest) | (u64::from(NESTED_DIGITS) << 58)));
    word ^ (flips << rest) ^ (below >> NESTED_DIGITS)
}

/// A bijection of 64-bit words in which each bit changes every other (Steele, Lea & Flood 2014, variant 13 of Stafford).
#[inline]
fn mix(word: u64) -> u64 {
    let mut x = word.wrapping_add(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}
