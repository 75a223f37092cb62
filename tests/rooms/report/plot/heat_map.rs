//! Tests of `src/report/plot/heat_map.rs`.

use bmv::report::plot::canvas::{WIDTH, text_width};
use bmv::report::plot::heat_map::*;

fn map(columns: usize, value: f64) -> HeatMap {
    HeatMap {
        columns: (0..columns).map(|at| format!("TC {}", 1000 + at)).collect(),
        rows: (0..40).map(|at| (format!("P{at:02}"), at % 5 == 0, vec![Some(value); columns])).collect(),
        full_scale: 20.0,
        limit: Some(3.0),
        decimals: 2,
        mark_label: "held out".into(),
        ..HeatMap::default()
    }
}

#[test]
fn numbers_lose_decimals_and_then_go_before_they_touch() {
    let fits = |columns: usize, value: f64| {
        let map = map(columns, value);
        let width = (f64::from(WIDTH) - 150.0) / columns as f64;
        let chosen = lettering(&map, width, 38.0);
        if let Some((decimals, size)) = chosen {
            assert!(text_width(&text_of(&map, value, decimals), size) <= width - AROUND + 1e-9);
        }
        chosen.map(|(decimals, _)| decimals)
    };
    assert_eq!([fits(5, -18.8), fits(20, -18.8), fits(40, -18.8)], [Some(2), Some(1), None]);
}

#[test]
fn what_is_beyond_the_limit_has_a_frame_and_the_scale_marks_it() {
    let outlines = |value: f64| heat_map(&map(2, value)).svg("a", "", "", false).matches("<polyline").count();
    assert_eq!(outlines(3.5) - outlines(2.5), 80, "a frame a cell");
    assert!(heat_map(&map(2, 1.0)).svg("a", "", "", false).contains("+3.0"));
}
