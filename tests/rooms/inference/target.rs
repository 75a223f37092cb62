//! Tests of `core/src/inference/target.rs`.

use bmv::inference::target::*;

#[test]
fn rejections_are_counted_by_reason_and_stay_bounded() {
    let mut rejections = Rejections::default();
    for i in 0..40 {
        rejections.count(&Rejected::new(format!("reason {}", i % 20)));
    }
    assert_eq!(rejections.total(), 40);
    assert_eq!(rejections.by_reason.len(), Rejections::MOST_REASONS);
    assert_eq!(rejections.by_reason[0], ("reason 0".to_owned(), 2));
    assert_eq!(rejections.by_reason[15].0, OTHER_REASONS);
    assert_eq!(rejections.by_reason[15].1, 10);
    let mut sum = rejections.clone();
    sum.merge(&rejections);
    assert_eq!(sum.total(), 80);
}
