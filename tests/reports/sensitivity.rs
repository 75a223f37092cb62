//! The sections on sensitivity and goal setting.

use bmv::job::{goal, sensitivity};
use serde_json::{Value, json};

use super::rendering::{assert_well_formed, rendered};
use super::samples::{Sample, entry, radiator};

fn index(value: f64, reach: f64, bounds: Value) -> Value {
    json!({"value": value, "lower": value - reach, "upper": value + reach, "bounds": bounds})
}

fn effects(failed: bool) -> sensitivity::Output {
    let bounds = |value: f64| if failed { json!([value - 0.1, value + 0.1]) } else { Value::Null };
    let total = |value: f64, reach: f64| index(value, reach, bounds(value));
    let local =
        |derivative: f64| json!({"derivative": derivative, "scaled_by_value": 0.1, "scaled_by_sd": derivative / 10.0});
    let morris = |size: f64| json!({"mu": size, "mu_star": size, "mu_star_standard_error": 0.01, "sigma": 0.2});
    let bound = |value: f64| json!({"value": value, "lower": value, "upper": value, "root_mean_square": 3.0});
    let failure =
        json!({"place": "row 7 of scramble 0, first point", "parameters": [["eps", 0.8]], "reason": "it is singular"});
    serde_json::from_value(json!({
        "methods": ["local", "morris", "sobol", "derivative"], "samples": 1024, "scrambles": 8, "trajectories": 64,
        "parameters": [{"name": "Q", "unit": "W", "nominal": 100.0, "sd": 2.9}, {"name": "eps", "unit": "1", "nominal": 0.85, "sd": 0.04},
            {"name": "<b>", "unit": "1", "nominal": 0.2, "sd": 0.03}],
        "precision": {"asked": 0.001, "widest": 0.02, "is_reached": false},
        "cases": [{"environment": "hot", "solves": 5000, "failed": if failed { 3 } else { 0 }, "rows": 8192,
            "rows_left_out": if failed { 2 } else { 0 }, "trajectories_left_out": 0,
            "failures": if failed { vec![failure] } else { vec![] },
            "quantities": [
                {"name": "T", "unit": "K", "is_temperature": true, "nominal": 302.0, "is_constant": false,
                 "local": [local(0.6), local(-85.0), local(47.0)], "morris": [morris(6.0), morris(12.0), morris(5.0)],
                 "sobol": {"mean": 302.0, "sd": 4.2, "main": [index(0.187, 0.001, Value::Null), index(0.676, 0.001, Value::Null), index(0.18, 0.01, Value::Null)],
                    "total": [total(0.188, 0.001), total(0.677, 0.001), total(0.181, 0.01)],
                    "second_order": [{"parameters": ["Q", "eps"], "value": 0.001, "lower": 0.0, "upper": 0.002}],
                    "sum_main": {"value": 0.999, "lower": 0.998, "upper": 1.0},
                    "places": [{"best": 2, "worst": 3}, {"best": 1, "worst": 1}, {"best": 2, "worst": 3}]},
                 "derivative": [bound(0.2), bound(0.8), bound(0.2)],
                 "scatter": {"parameters": [1, 0], "x": [[0.8, 0.9], [99.0, 101.0]], "y": [304.0, 300.0]}},
                {"name": "mass", "unit": "kg", "is_temperature": false, "nominal": 1.5, "is_constant": true, "local": [], "morris": [],
                 "sobol": null, "derivative": [], "scatter": null}]}]
    }))
    .expect("an output")
}

fn goals() -> goal::Output {
    let probability = |value: f64| json!({"value": value, "lower": value - 0.01, "upper": value + 0.004});
    let level = |ratio: f64, value: f64, design: Value| json!({"ratio": ratio, "sds": [0.04 * ratio], "probability": probability(value), "design_value": design, "is_design_sought": ratio != 0.4});
    serde_json::from_value(json!({
        "samples": 4096, "required": 0.99, "design_variable": "A", "design_unit": "m2", "design_nominal": 0.3, "design_range": [0.26, 0.36],
        "probability": probability(0.92),
        "requirements": [{"requirement": "warm", "environment": "hot", "quantity": "T", "probability": probability(0.92), "mean": 302.0, "sd": 4.0}],
        "driving": {"requirement": "warm", "environment": "hot", "quantity": "T", "unit": "K", "is_temperature": true},
        "leading": [{"parameter": "eps", "unit": "1", "mean": 0.85, "sd": 0.04, "main": {"value": 0.676, "lower": 0.67, "upper": 0.68}}],
        "prior_design_value": 0.3144,
        "knowledge": [{"parameters": ["eps"], "levels": [level(0.4, 0.985, Value::Null), level(0.25, 0.997, json!(0.2971)), level(0.0, 0.999, json!(0.2947))]}],
        "target": {"parameters": ["eps"], "units": ["1"], "ratio": 0.36, "variance_ratio": 0.1296, "sds": [0.0144], "probability": probability(0.991)},
        "truths": {"parameters": ["eps"], "ratio": 0.36, "count": 64, "reaching": {"value": 0.5, "lower": 0.4, "upper": 0.6},
            "design_values": [0.28, 0.31], "mean_design_value": 0.2999},
        "tolerable_discrepancy": null, "discrepancy": [], "failed": 0, "solves": 100000,
        "advice": {"next": "parameter-inference", "reasons": ["it is enough to know `eps` to 36.0 % of the prior standard deviation"]}
    }))
    .expect("an output")
}

/// A sample with both jobs.
pub fn with(failed: bool) -> Sample {
    let mut sample = radiator();
    sample.results.push(entry::<sensitivity::Kind>("effects", "00", effects(failed)));
    sample.results.push(entry::<goal::Kind>("aim", "00", goals()));
    sample
}

#[test]
fn ties_are_said_and_constants_named() {
    let report = rendered(&with(false));
    let section = &report.markdown[report.markdown.find("Job `effects`").expect("the section")..];
    for text in [
        "`eps` has 67.7\u{a0}% of the variance in all",
        "2 to 3 (tie)",
        "the 0.0010 asked for is not reached",
        "mass does not vary",
    ] {
        assert!(section.contains(text), "{text}: {section}");
    }
    assert!(!section.contains("rows left out at worst"));
    for (_, svg) in &report.figures {
        assert_well_formed(svg);
    }
    for name in ["effects-hot-t-shares", "effects-hot-t-tornado", "aim-knowledge"] {
        assert!(
            report.figures.iter().any(|(found, _)| found.to_lowercase().contains(name)),
            "{name}: {:?}",
            report.figures.iter().map(|(name, _)| name).collect::<Vec<_>>()
        );
    }
}

#[test]
fn failures_are_stated_with_what_they_could_do() {
    let report = rendered(&with(true));
    for text in ["3 of 5000 solves failed", "it is singular", "0.577 to 0.777"] {
        assert!(report.markdown.contains(text), "{text}");
    }
}

#[test]
fn the_goal_says_what_comes_next_and_why() {
    let report = rendered(&with(false));
    let section = &report.markdown[report.markdown.find("Job `aim`").expect("the section")..];
    for text in [
        "an experiment that infers the leading parameters",
        "with prior knowledge A = 0.3144",
        "A = 0.2971",
        "A = 0.2999",
        "0.2947",
    ] {
        assert!(section.contains(text), "{text}: {section}");
    }
}
