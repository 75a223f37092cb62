//! Tests of `src/study/history.rs`.

use bmv::study::history::*;

#[test]
fn parents_are_listed_first_and_branches_in_order_of_file() {
    let parents: Vec<Vec<String>> = [&["pass-3.json"][..], &["pass-3.json"], &[], &["pass-1.json", "pass-3.json"]]
        .iter()
        .map(|list| list.iter().map(|&name| name.to_owned()).collect())
        .collect();
    let files = ["pass-1.json", "pass-2.json", "pass-3.json", "pass-4.json"];
    let passes: Vec<(&str, &[String])> = files.into_iter().zip(parents.iter().map(Vec::as_slice)).collect();
    assert_eq!(order(&passes), [2, 0, 1, 3]);
    let circle = [vec!["b".to_owned()], vec!["a".to_owned()]];
    assert_eq!(order(&[("a", &circle[0]), ("b", &circle[1])]), [0, 1]);
    assert!(order(&[]).is_empty());
}
