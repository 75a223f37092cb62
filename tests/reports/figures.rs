//! Figures that a study asks for.

use bmv::report::render;
use bmv::study::figure::{Contours, Coordinate, Drawn, Estimate, Figure, Readings, Source};

use super::samples::steady;

fn readings(of: usize, minus: Option<Source>, estimates: Vec<Estimate>) -> Figure {
    let drawn = Readings {
        measurement: "balance test".into(),
        sensor: of,
        minus,
        against: Source::Input(0),
        by: Some(0),
        estimates,
    };
    Figure { name: "by power".into(), description: Some("Look here.".into()), drawn: Drawn::Readings(drawn) }
}

/// The text of the figures' section.
fn said(figures: Vec<Figure>) -> String {
    let sample = steady();
    let mut report = sample.report();
    report.figures = figures;
    let markdown = render(&report).expect("renders").markdown.replace('\u{A0}', " ");
    let start = markdown.find("Figures of this study\n").expect("a section");
    let rest = &markdown[start..];
    rest[..rest.find("<a id=").unwrap_or(rest.len())].to_owned()
}

#[test]
fn readings_stand_beside_the_model_and_estimates_with_their_source() {
    let estimate = Estimate {
        name: "data sheet".into(),
        points: vec![(0.0, 280.0), (6.0, 310.0)],
        source: "issue <2>".into(),
        reconstructed: Some("read off a curve".into()),
    };
    let text = said(vec![readings(0, None, vec![estimate])]);
    for part in [
        "Look here.",
        "housing against P, balance test: points as read, rings held out. Lines: the model as delivered",
        // By the formula of the sample: sqrt(mean((0.55 load + 0.25 sin(7.1 p))^2)) over the phases that are kept.
        "measured minus predicted 1.87 K root mean square, 3.15 K at most",
        "| `data sheet` | reconstructed | issue &lt;2&gt; |",
        "**Reconstructed.** data sheet: read off a curve",
        "plots/figure-by-power.svg",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let difference = said(vec![readings(0, Some(Source::Sensor(1)), Vec::new())]);
    assert!(difference.contains("housing minus bracket against P"), "{difference}");
}

#[test]
fn what_cannot_be_drawn_says_why() {
    let over = [Coordinate::Input(0), Coordinate::Quantity("housing".into())];
    let contours = Contours { quantity: "board".into(), job: "as delivered".into(), over };
    let figure = Figure { name: "surface".into(), description: None, drawn: Drawn::Contours(contours) };
    let text = said(vec![figure]);
    let why = "This figure cannot be drawn: job as delivered is no propagation or prediction with a result.";
    assert!(text.contains(why), "{text}");
}
