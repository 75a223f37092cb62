//! Tests of `src/study/resolve/parts.rs`.

use bmv::study::resolve::parts::*;

#[test]
fn instants_are_parted_where_they_lie_too_far_apart() {
    let times = [0.0, 10.0, 20.0, 500.0, 510.0, 1000.0];
    assert_eq!(rows_of_parts(&times, Some(60.0)), [0..3, 3..5, 5..6]);
    assert_eq!(rows_of_parts(&times, Some(480.0)), [0..5, 5..6]);
    assert!(rows_of_parts(&times, None).iter().eq([&(0..6)]));
    assert_eq!(rows_of_parts(&[], Some(1.0)).len(), 1);
}

#[test]
fn parts_belong_to_what_was_written() {
    assert!((0..3).all(|part| belongs_to(&part_name("test", part), "test")));
    for other in ["test 2", "test (part 1)", "test (part two)", "tests", "a test"] {
        assert!(!belongs_to(other, "test"), "{other}");
    }
}
