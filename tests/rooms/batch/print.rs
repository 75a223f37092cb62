//! Tests of `src/batch/print.rs`.

use bmv::batch::print::address;

#[test]
fn the_address_of_a_page_has_no_letter_that_means_something() {
    let page = std::path::Path::new("/a b/50%#1?/report.html");
    assert_eq!(address(page), "file:///a%20b/50%25%231%3F/report.html");
}
