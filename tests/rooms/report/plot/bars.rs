//! Tests of `src/report/plot/bars.rs`.

use bmv::report::plot::{Axis, Bar, bar_chart, palette};

#[test]
fn an_axis_of_probabilities_ends_at_1() {
    let text = "a long text at its end that needs room of its own";
    let bar =
        |value| Bar { label: "one".into(), from: 0.0, value, interval: None, text: text.into(), colour: palette::BLUE };
    let drawn = |axis: &Axis| bar_chart(axis, &[bar(0.98)], None).svg("a", "", "", false);
    let ends_beyond = |svg: &str| ["\n1.2\n", "\n1.5\n"].iter().any(|tick| svg.contains(tick));
    let axis = Axis::over("Probability", 0.0, 1.0);
    let svg = drawn(&axis);
    assert!(ends_beyond(&svg), "the room of the text has ticks");
    let svg = drawn(&axis.up_to(1.0));
    assert!(!ends_beyond(&svg) && svg.contains("\n1.0\n"), "{svg}");
    assert_eq!(Axis::new("share").up_to(1.0).within((0.2, 1.06)), (0.2, 1.0));
}
