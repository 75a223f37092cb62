//! Figures that a study asks for: what is refused, where, and with what to write instead.

use crate::diagnostics::pass_study::Study;

fn said(figure: &str) -> String {
    let study = Study::new();
    study.edit("pass-1.json", r#" "jobs": {"#, &format!(r#" "figures": {{"own": {figure}}}, "jobs": {{"#));
    study.said("pass-1.json")
}

#[test]
fn what_is_there_can_be_drawn() {
    for figure in [
        r#"{"readings": {"data": "balance", "of": "box", "minus": "T_if", "against": "Q", "by": "T_if",
            "estimates": {"sheet": {"points": [[5, 4.5]], "units": ["W", "K"], "source": "data sheet"}}}}"#,
        r#"{"contours": {"of": "panel", "from": "spread", "over": ["T_if", "box"]}}"#,
    ] {
        assert_eq!(said(figure), "", "{figure}");
    }
}

#[test]
fn what_is_not_there_is_named_at_its_place() {
    let cases: [(&str, &[&str]); 8] = [
        (
            r#"{"readings": {"data": "balanc", "of": "box", "against": "Q"}}"#,
            &["unknown measurement `balanc`", "`balance`"],
        ),
        (
            r#"{"readings": {"data": "balance", "of": "bx", "against": "Q"}}"#,
            &["unknown sensor `bx`", "did you mean `box`?"],
        ),
        (
            r#"{"readings": {"data": "balance", "of": "box", "against": "Qx"}}"#,
            &["unknown input or sensor `Qx`", "did you mean `Q`?"],
        ),
        (
            r#"{"readings": {"data": "balance", "of": "box", "minus": "Q", "against": "T_if"}}"#,
            &["`Q` has another dimension than `box`"],
        ),
        (
            r#"{"readings": {"data": "balance", "of": "box", "against": "Q", "estimates": {"sheet": {"points": [], "units": ["W", "degC"], "source": " "}}}}"#,
            &["the estimate `sheet` has no points", "does not say where it comes from", "\"reconstructed\""],
        ),
        (
            r#"{"readings": {"data": "balance", "of": "box", "against": "Q", "estimates": {"sheet": {"points": [[1, 2]], "units": ["V", "degC"], "source": "s"}}}}"#,
            &["`V`"],
        ),
        (
            r#"{"contours": {"of": "panel", "from": "sprea", "over": ["T_if", "T_if"]}}"#,
            &["unknown job of this pass `sprea`", "did you mean `spread`?", "both axes are `T_if`"],
        ),
        (r#"{"scatter": {}}"#, &["unknown kind `scatter` of a figure", "`readings` and `contours`"]),
    ];
    for (figure, parts) in cases {
        let said = said(figure);
        for part in parts {
            assert!(said.contains(part), "{part}\n{said}");
        }
        assert!(said.contains("pass-1.json:9:"), "{said}");
    }
}
