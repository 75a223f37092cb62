//! Tests of `core/src/math/sort.rs`.

use bmv::math::sort::{sort_by, sort_by_key};

/// Numbers with many that are equal, by a linear congruence; each with the place at which it stood.
fn list(count: u64) -> Vec<(u64, u64)> {
    (0..count).map(|place| ((place * 6_364_136 + 1_442_695) % 7_919 % 13, place)).collect()
}

#[test]
fn the_order_is_that_of_the_standard_library_with_equals_as_they_stood() {
    for count in [0, 1, 2, 3, 20, 21, 500] {
        let (mut expected, mut down, mut up) = (list(count), list(count), list(count));
        expected.sort_by_key(|own| std::cmp::Reverse(own.0));
        sort_by(&mut down, |a, b| b.0.cmp(&a.0));
        assert_eq!(down, expected, "{count}");
        expected.sort_by_key(|own| own.1);
        expected.sort_by_key(|own| own.0);
        sort_by_key(&mut up, |own| own.0);
        assert_eq!(up, expected, "{count}");
    }
}
