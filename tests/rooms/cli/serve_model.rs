//! Tests of `src/cli/serve_model.rs`.

use bmv::cli::serve_model::in_si;

#[test]
fn a_converted_number_has_no_residue() {
    for (value, expected) in
        [(123.149_999_999_999_98, 123.15), (0.1 + 0.2, 0.3), (0.0, 0.0), (1e-300, 1e-300), (273.15, 273.15)]
    {
        assert_eq!(in_si(value), expected);
    }
}
