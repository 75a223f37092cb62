//! Tests of `diagnosis/src/diagnosis/memory.rs`.

use bmv::diagnosis::memory::bytes;

#[test]
fn what_is_estimated_is_near_what_was_measured_and_its_columns_are_bounded_in_the_readings() {
    // A grid of 30 nodes, 20 sensors and 10 phases (`just sizes 30`): 5000 candidates took 165 MB beyond what `bmv plan` takes.
    let stated = bytes(5000, 210, 90, 300) as f64;
    assert!((0.5..2.0).contains(&(stated / 165e6)), "{stated}");
    // Columns of so many readings are never held all at once: what is left is what fits keep.
    let of_fits = 54_000.0 * 120.0 * 6.0 * 8.0;
    assert_eq!((bytes(100_000, 60_000, 0, 0) - bytes(100_000, 6000, 0, 0)) as f64, of_fits);
    assert!(bytes(100_000, 60_000, 0, 0) < 4 << 30);
}
