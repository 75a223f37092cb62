//! Tests of `src/import/parts.rs`.

use bmv::import::parts::*;

#[test]
fn a_list_of_parts_is_refused_at_its_place() {
    let said = |text: &str| ranges("parts.csv", text).map(|_| ()).expect_err(text).to_string();
    assert_eq!(said("name,first\n"), "parts.csv:1:1: expected the columns `part,first,last`, as in `rim,1070,1099`");
    assert_eq!(
        said("part,first,last\nhub,1,9\nrim,ten,19\n"),
        "parts.csv:3:5: `ten` is no node number: write a whole number"
    );
    assert_eq!(said("part,first,last\nhub,9,1\n"), "parts.csv:2:7: the range ends at 1, before it begins at 9");
    assert_eq!(said("part,first,last\nhub,1,9\nrim,9,12\n"), "parts.csv:3:5: the range has numbers of line 2 (`hub`)");
    assert_eq!(said("part,first,last\n,1,9\n"), "parts.csv:2:1: the part has no name");
    assert_eq!(said("part,first,last\nhub,1\n"), "parts.csv:2:1: 2 cells, but the header has 3 columns");
    assert!(said("part,first,last\n").starts_with("parts.csv:2:1: no part is listed"));
}
