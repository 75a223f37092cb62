//! Tests of `core/src/expression/schedule.rs`.

use bmv::expression::schedule::*;

/// A chain of alternating kinds cannot be put together; many chains beside one another can.
#[test]
fn like_instructions_stand_together_and_after_their_arguments() {
    let (chains, length) = (40, 30);
    let before = |place: usize| [(!place.is_multiple_of(length)).then(|| place - 1), None];
    let found = order(chains * length, |place| place % length % 3, before);
    let mut sorted = found.clone();
    sorted.sort_unstable();
    assert!(sorted.into_iter().eq(0..chains * length));
    let place_of: Vec<usize> =
        (0..chains * length).map(|old| found.iter().position(|&own| own == old).unwrap()).collect();
    for old in 0..chains * length {
        if let [Some(argument), _] = before(old) {
            assert!(place_of[argument] < place_of[old]);
        }
    }
    let changes = found.windows(2).filter(|pair| pair[0] % length % 3 != pair[1] % length % 3).count();
    // Three windows, each with the length of a chain and what is cut off at its ends.
    assert!(changes < 3 * 3 * length, "{changes}");
}
