//! Tests of `core/src/math/sparse.rs`.

use bmv::math::sparse::*;

#[test]
fn repeated_entries_share_a_slot_and_the_diagonal_is_complete() {
    let pattern = Pattern::new(3, &[(2, 0), (0, 0), (2, 0), (1, 2)]).unwrap();
    assert_eq!(pattern.stored(), 5);
    assert_eq!(pattern.slots()[0], pattern.slots()[2]);
    assert_eq!(pattern.rows(), [0, 2, 1, 1, 2]);
    assert_eq!(pattern.diagonal(), [0, 2, 4]);
    assert_eq!(pattern.slots(), [1, 0, 1, 3]);
    assert_eq!(pattern.symmetric_neighbours(), [vec![2], vec![2], vec![0, 1]]);
}

#[test]
fn products_agree_with_hand_calculation() {
    // A = [[1, 0, 0], [0, 0, 5], [3, 0, 0]]
    let pattern = Pattern::new(3, &[(2, 0), (0, 0), (1, 2)]).unwrap();
    let mut values = vec![0.0; pattern.stored()];
    for (slot, value) in pattern.slots().iter().zip([3.0, 1.0, 5.0]) {
        values[*slot] += value;
    }
    let mut product = [0.0; 3];
    pattern.multiply(&values, &[2.0, 7.0, 4.0], &mut product);
    assert_eq!(product, [2.0, 20.0, 6.0]);
}

#[test]
fn entries_outside_are_refused() {
    let error = Pattern::new(2, &[(0, 0), (1, 2)]).unwrap_err();
    assert_eq!(error, PatternError { entry: 1, row: 1, column: 2, size: 2 });
}
