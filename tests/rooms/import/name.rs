//! Tests of `src/import/name.rs`.

use std::collections::HashMap;

use bmv::document::name::is_label;
use bmv::import::name::*;

#[test]
fn names_that_are_allowed_stay_and_others_change_little() {
    let mut names = Names::default();
    let labels = ["SUB.12", "a/b", " a_b ", "GL(3,7)", "", "\u{7}", "x\ty"].map(|name| names.label(name));
    assert_eq!(labels, ["SUB.12", "a_b", "a_b 2", "GL(3,7)", "unnamed", "_", "x_y"]);
    assert!(labels.iter().all(|label| is_label(label)));
    assert!(is_label(&names.label(&"long ".repeat(40))));
    let mut names = Names::default();
    let symbols = ["G_bi", "T", "_x", "12", "eps-mli", "eps_mli"].map(|name| names.symbol(name));
    assert_eq!(symbols, ["G_bi", "T_0", "p_x", "p12", "eps_mli", "eps_mli_2"]);
    assert!(symbols.iter().all(|symbol| is_symbol(symbol)));
}

#[test]
fn identifiers_are_renamed_and_numbers_are_not() {
    let names = HashMap::from([("e".to_owned(), "e_0".to_owned()), ("T".to_owned(), "T_0".to_owned())]);
    let text = "1e5*e + 2.5E-3 * (T_x - T) / .5e+2";
    assert_eq!(identifiers(text), ["e", "T_x", "T"]);
    assert_eq!(renamed(text, &names), "1e5*e_0 + 2.5E-3 * (T_x - T_0) / .5e+2");
    assert_eq!(renamed("\u{3a9} + \u{e9}e", &names), "\u{3a9} + \u{e9}e_0");
}
