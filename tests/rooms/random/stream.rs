//! Tests of `core/src/random/stream.rs`.

use bmv::random::stream::*;

#[test]
fn names_and_streams_give_different_words() {
    let first = |seed, job, purpose, index| StreamKey::new(seed, job, purpose).stream(index).word();
    let words = [
        first(1, "propagate", "points", 0),
        first(1, "propagate", "points", 1),
        first(2, "propagate", "points", 0),
        first(1, "propagatep", "oints", 0),
        first(1, "", "propagatepoints", 0),
    ];
    for (k, word) in words.iter().enumerate() {
        assert!(!words[..k].contains(word));
    }
}

#[test]
fn words_are_those_of_chacha8_with_the_hashed_key() {
    // First block of ChaCha8 for the all-zero key and nonce (ECRYPT test vector 3e00ef2f 895f40d6 ...).
    let mut stream = StreamKey([0; 32]).stream(0);
    assert_eq!(stream.word().to_le_bytes(), [0x3e, 0x00, 0xef, 0x2f, 0x89, 0x5f, 0x40, 0xd6]);
    // Kept, so that no change of a dependency changes the numbers of a study unseen.
    let mut stream = StreamKey::new(1, "propagate", "points").stream(0);
    assert_eq!((stream.word(), stream.word()), (0xda1e_a0d7_0eef_5731, 0x8a84_ee86_d389_ee3c));
}

#[test]
fn seeking_gives_the_same_words_as_reading_on() {
    let key = StreamKey::new(7, "job", "purpose");
    let mut stream = key.stream(3);
    let words: Vec<u64> = (0..300).map(|_| stream.word()).collect();
    for start in [0, 1, 31, 32, 33, 64, 299, 150] {
        stream.seek(start as u64);
        assert_eq!(stream.word(), words[start]);
    }
    let mut filled = [0.0; 299];
    stream.seek(1);
    stream.fill_uniform(&mut filled);
    assert!(filled.iter().zip(&words[1..]).all(|(&value, &word)| value == uniform_of(word)));
}

#[test]
fn uniform_numbers_stay_inside_and_are_symmetric() {
    assert_eq!(uniform_of(0), 1.0 / 9_007_199_254_740_992.0);
    assert!(uniform_of(u64::MAX) < 1.0);
    assert_eq!(1.0 - uniform_of(u64::MAX), uniform_of(0));
    let mut stream = StreamKey::new(1, "a", "b").stream(0);
    let n = 20_000;
    let (mut sum, mut squares, mut below) = (0.0, 0.0, [0_u32; 7]);
    for _ in 0..n {
        let z = stream.normal();
        sum += z;
        squares += z * z;
        below[stream.below(7)] += 1;
    }
    // Five standard errors: 1 / sqrt(n), sqrt(2 / n), sqrt(n p (1 - p)).
    assert!((sum / f64::from(n)).abs() < 5.0 * 0.0071);
    assert!((squares / f64::from(n) - 1.0).abs() < 5.0 * 0.01);
    assert!(below.iter().all(|&count| (f64::from(count) - 2857.1).abs() < 5.0 * 49.5), "{below:?}");
}
