//! Tests of `src/report/plot/canvas.rs`.

use bmv::report::plot::canvas::*;
use bmv::report::plot::palette::INK;

#[test]
fn hostile_text_is_escaped_in_body_title_and_description() {
    let hostile = "<img src=x onerror=alert(1)> & \"quoted\"\u{0}";
    let drawing = draw(100, |canvas| canvas.text(hostile, (10.0, 10.0), Lettering::new(TEXT, INK)));
    let svg = drawing.svg("a", hostile, hostile, true);
    assert!(!svg.contains("<img"), "{svg}");
    assert!(!svg.contains('\u{0}'));
    assert_eq!(svg.matches("&lt;img").count(), 3);
    assert!(svg.contains("font-size=\"34\""), "the size is written without rounding residue: {svg}");
}

#[test]
fn a_point_that_is_no_number_breaks_a_line() {
    let points = [(0.0, 0.0), (10.0, 0.0), (f64::NAN, 1.0), (20.0, 0.0), (30.0, 0.0)];
    let drawing = draw(100, |canvas| canvas.path(&points, INK, 2));
    assert_eq!(drawing.svg("a", "", "", false).matches("<polyline").count(), 2);
}

#[test]
fn thousands_of_points_in_a_column_draw_its_ends() {
    let points: Vec<(f64, f64)> = (0..1500).map(|i| (3.0, f64::from(i % 97))).collect();
    assert_eq!(thinned(&points), [(3, 0), (3, 0), (3, 96), (3, 44)]);
    let long: Vec<(f64, f64)> = (0..9000).map(|i| (f64::from(i) / 1000.0, f64::from((i + 50) % 97))).collect();
    let drawn = thinned(&long);
    assert!(drawn.len() <= 8, "two for each five pixels: {drawn:?}");
    assert!(drawn.iter().any(|p| p.1 == 0) && drawn.iter().any(|p| p.1 == 96), "the ends are kept");
}

#[test]
fn dashes_cover_their_share_of_the_line() {
    let drawing = draw(100, |canvas| canvas.dashed(&[(0.0, 0.0), (100.0, 0.0)], INK, 1, 6.0, 4.0));
    assert_eq!(drawing.svg("a", "", "", false).matches("<polyline").count(), 10);
}
