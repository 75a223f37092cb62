//! Random streams by name and index: raw ChaCha8 words (Bernstein 2008) from a key that is a hash of names.
//!
//! A key belongs to a study's seed, a job and a purpose; each key has 2^64 streams, each stream 2^67 words.
//! Sample i of a set takes its own fixed range of words, so any part of a set can be drawn alone.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

use crate::math::special::normal_quantile;

/// The key of a family of random streams.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamKey(pub [u8; 32]);

impl StreamKey {
    /// SHA-256 of a label, the seed, and both names with their lengths (so that no two triples meet).
    pub fn new(study_seed: u64, job: &str, purpose: &str) -> Self {
        let mut hash = Sha256::new();
        hash.update(b"bmv random stream 1\n");
        hash.update(study_seed.to_le_bytes());
        for name in [job, purpose] {
            hash.update((name.len() as u64).to_le_bytes());
            hash.update(name.as_bytes());
        }
        Self(hash.finalize().into())
    }

    /// One of the key's streams, at its first word. Chains and replicates take one each.
    pub fn stream(&self, index: u64) -> Stream {
        let mut generator = ChaCha8Rng::from_seed(self.0);
        generator.set_stream(index);
        Stream { generator }
    }
}

/// A sequence of random 64-bit words that can be entered at any word.
#[derive(Clone, Debug)]
pub struct Stream {
    generator: ChaCha8Rng,
}

impl Stream {
    /// Number of the next 64-bit word: what [`Stream::seek`] takes to go on from here.
    pub fn position(&self) -> u64 {
        // Words are numbered by 64 bits; nothing draws more of them.
        u64::try_from(self.generator.get_word_pos() / 2).unwrap_or(u64::MAX)
    }

    /// Makes the given 64-bit word (counted from 0) the next one.
    pub fn seek(&mut self, word: u64) {
        let position = 2 * u128::from(word);
        if self.generator.get_word_pos() != position {
            self.generator.set_word_pos(position);
        }
    }

    /// The next word.
    #[inline]
    pub fn word(&mut self) -> u64 {
        self.generator.next_u64()
    }

    /// The next uniform number, one word.
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        uniform_of(self.word())
    }

    /// The next standard normal number, one word.
    #[inline]
    pub fn normal(&mut self) -> f64 {
        normal_quantile(self.uniform())
    }

    /// A whole number from 0 to `bound - 1` (0 for a bound of 0), one word; the bias is below `bound / 2^64`.
    #[inline]
    pub fn below(&mut self, bound: usize) -> usize {
        ((u128::from(self.word()) * bound as u128) >> 64) as usize
    }

    /// Fills a slice with uniform numbers, one word each.
    pub fn fill_uniform(&mut self, values: &mut [f64]) {
        let mut bytes = [0; 256];
        for block in values.chunks_mut(32) {
            let bytes = &mut bytes[..8 * block.len()];
            self.generator.fill_bytes(bytes);
            for (value, word) in block.iter_mut().zip(bytes.as_chunks().0) {
                *value = uniform_of(u64::from_le_bytes(*word));
            }
        }
    }
}

/// A uniform number strictly inside (0, 1): `(2 k + 1) / 2^53` with k the word's upper 52 bits, so that `u` and `1 - u`
/// are equally fine and both exact.
#[inline]
pub fn uniform_of(word: u64) -> f64 {
    const STEP: f64 = 1.0 / (1_u64 << 53) as f64;
    ((word >> 11) | 1) as f64 * STEP
}
