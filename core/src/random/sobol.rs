//! Sobol points with Owen's scrambling, 64 bits a coordinate, any point by its index.
//!
//! Directions: S. Joe & F. Y. Kuo 2008 (SIAM J. Sci. Comput. 30, 2635), set D6, carried on to 64 bits by their recurrence.
//! Points come in Gray code order (Antonov & Saleev 1979). Nested uniform scrambling (Owen 1995) flips each digit by a
//! random bit that depends on all digits before it; the bits come from a hash of those digits, as Laine & Karras (2011)
//! and Burley (2020) do, here with a full-avalanche hash once for six digits.

use super::stream::StreamKey;

/// The first line belongs to the second dimension; the licence stands beside the file.
const DIRECTIONS: &str = include_str!("sobol_directions.txt");

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
    dimensions: usize,
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

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "the standard library as an independent reference")]
mod tests {
    use super::*;

    fn points(sobol: &Sobol, count: u64) -> Vec<Vec<f64>> {
        let (mut words, mut row) = (vec![0; sobol.dimensions], vec![0.0; sobol.dimensions]);
        (0..count)
            .map(|index| {
                sobol.words(index, &mut words);
                sobol.coordinates(&words, &mut row);
                row.clone()
            })
            .collect()
    }

    #[test]
    fn plain_points_are_the_reference_points() {
        // First points of new-joe-kuo-6.21201 in Gray code order, as scipy 1.17 (qmc.Sobol) gives them.
        let expected = [
            [0.0; 8],
            [0.5; 8],
            [0.75, 0.25, 0.25, 0.25, 0.75, 0.75, 0.25, 0.75],
            [0.25, 0.75, 0.75, 0.75, 0.25, 0.25, 0.75, 0.25],
            [0.375, 0.375, 0.625, 0.875, 0.375, 0.125, 0.375, 0.875],
            [0.875, 0.875, 0.125, 0.375, 0.875, 0.625, 0.875, 0.375],
            [0.625, 0.125, 0.875, 0.625, 0.625, 0.875, 0.125, 0.125],
            [0.125, 0.625, 0.375, 0.125, 0.125, 0.375, 0.625, 0.625],
        ];
        let sobol = Sobol::plain(8).unwrap();
        let (mut words, mut running) = ([0; 8], [0; 8]);
        for (index, expected) in expected.iter().enumerate() {
            sobol.words(index as u64, &mut words);
            if index > 0 {
                sobol.advance(index as u64, &mut running);
            }
            assert_eq!(words, running);
            for (word, expected) in words.iter().zip(expected) {
                assert_eq!(*word as f64 / 2_f64.powi(64), *expected, "point {index}");
            }
        }
    }

    #[test]
    fn far_points_in_high_dimensions_are_the_reference_points() {
        // Dimensions 10, 100, 500 and 1024 (counted from 1) as scipy 1.17 gives them; the crate sobol 1.0.2 agrees up to 500.
        let sobol = Sobol::plain(1024).unwrap();
        let mut words = [0; 1024];
        REFERENCE.iter().for_each(|(index, expected)| {
            sobol.words(*index, &mut words);
            for (dimension, expected) in [10, 100, 500, 1024].into_iter().zip(expected) {
                assert_eq!(words[dimension - 1] as f64 / 2_f64.powi(64), *expected, "point {index}, {dimension}");
            }
        });
        assert!(Sobol::plain(1025).is_none());
        assert_eq!(DIRECTIONS.lines().count(), MAX_DIMENSIONS - 1);
    }

    const REFERENCE: [(u64, [f64; 4]); 3] = [
        (5, [0.125, 0.375, 0.125, 0.375]),
        (1000, [0.0693359375, 0.1865234375, 0.2548828125, 0.7138671875]),
        (123457, [0.7490615844726562, 0.42577362060546875, 0.41883087158203125, 0.9469680786132812]),
    ];

    #[test]
    fn scrambled_points_stratify() {
        let dimensions = 60;
        let key = StreamKey::new(5, "test", "net");
        let rows = points(&Sobol::scrambled(dimensions, &key).unwrap(), 256);
        // Every dimension alone is a (0, m, 1)-net: one point in each of 256 slices.
        for d in 0..dimensions {
            let mut seen = [0; 256];
            rows.iter().for_each(|row| seen[(row[d] * 256.0) as usize] += 1);
            assert_eq!(seen, [1; 256], "dimension {d}");
        }
        // The first two form a (0, m, 2)-net: one point in each box of every shape of area 1/256.
        for level in 0..=8 {
            let (columns, lines) = ((1 << level) as f64, (256 >> level) as f64);
            let mut seen = [0; 256];
            for row in &rows {
                seen[(row[0] * columns) as usize * (256 >> level) + (row[1] * lines) as usize] += 1;
            }
            assert_eq!(seen, [1; 256], "level {level}");
        }
        // Property A (Sobol 1976) of the first dimensions: 2^3 points fall into the 2^3 half-cubes of the first three.
        let mut octants = [0; 8];
        for row in &rows[..8] {
            octants[(0..3).map(|d| ((row[d] * 2.0) as usize) << d).sum::<usize>()] += 1;
        }
        assert_eq!(octants, [1; 8]);
    }

    #[test]
    fn scrambled_coordinates_are_uniform_and_independent_over_keys() {
        // Any one point is uniform over the scrambles; the flips of neighbouring subtrees are independent.
        let n = 4000_u32;
        let (mut sum, mut squares, mut product, mut agree) = (0.0, 0.0, 0.0, 0);
        for seed in 0..n {
            let sobol = Sobol::scrambled(2, &StreamKey::new(u64::from(seed), "t", "u")).unwrap();
            let rows = points(&sobol, 3);
            let (x, y) = (rows[2][0] - 0.5, rows[2][1] - 0.5);
            sum += x;
            squares += x * x;
            product += x * y;
            // Points 0 (word 0) and 1 (0.5) lie in different halves: their second digits flip independently.
            agree += u32::from(((rows[0][0] * 4.0) as u32 & 1) == ((rows[1][0] * 4.0) as u32 & 1));
        }
        let n = f64::from(n);
        // Five standard errors of each statistic of uniform numbers.
        assert!((sum / n).abs() < 5.0 * (1.0 / 12.0 / n).sqrt());
        assert!((squares / n - 1.0 / 12.0).abs() < 5.0 * (1.0 / 180.0 / n).sqrt());
        assert!((product / n).abs() < 5.0 * (1.0 / 144.0 / n).sqrt());
        assert!((f64::from(agree) / n - 0.5).abs() < 5.0 * 0.5 / n.sqrt());
    }

    #[test]
    fn integration_error_of_a_smooth_function_falls_faster_than_one_over_n() {
        // Product of 1 + (x - 1/2) / (d + 1) over 6 dimensions integrates to 1; Owen (1997): error near N^-1.5.
        let rms = |count: u64| {
            let mut total = 0.0;
            let keys = 24;
            for seed in 0..keys {
                let sobol = Sobol::scrambled(6, &StreamKey::new(seed, "t", "i")).unwrap();
                let f = |row: &Vec<f64>| -> f64 {
                    row.iter().enumerate().map(|(d, x)| 1.0 + (x - 0.5) / (d as f64 + 1.0)).product()
                };
                let mean = points(&sobol, count).iter().map(f).sum::<f64>() / count as f64;
                total += (mean - 1.0) * (mean - 1.0);
            }
            (total / keys as f64).sqrt()
        };
        let order = (rms(64) / rms(4096)).ln() / 64_f64.ln();
        assert!(order > 1.3, "the error falls as N^-{order}");
    }
}
