//! The section on the error of a study's passes.

use bmv::report::history::{History, PassErrors, Readings, Split, States};
use bmv::report::render;

use super::rendering::{assert_well_formed, section};
use super::samples::steady;

fn split(train: f64, held_out: f64) -> Split {
    Split { train: Some(train), held_out: Some(held_out) }
}

fn pass(file: &str, parent: Option<&str>, added: &[&str], delivered: Split, tuned: Split) -> PassErrors {
    PassErrors {
        pass: file.into(),
        parent: parent.map(str::to_owned),
        adopted: added.iter().map(|&id| id.into()).collect(),
        added: added.iter().map(|&id| id.into()).collect(),
        rmse_k: States { delivered, tuned },
        mean_k: States { delivered: split(0.4, 0.5), tuned: split(-0.01, 0.02) },
        within_limit: States { delivered: split(0.5, 0.4), tuned: split(1.0, 0.95) },
        limit_k: Some(3.0),
        reduced_chi2: Some(1.25),
        log_evidence: Some(-31.24),
        log_evidence_sd: Some(0.05),
        converged: Some(true),
        readings: Readings { train: 100, held_out: 40 },
        comparison: Some("fit".into()),
        ..PassErrors::default()
    }
}

fn history() -> History {
    let none = Split::default();
    History {
        passes: vec![
            PassErrors { pass: "pass-1.json".into(), ..PassErrors::default() },
            pass("pass-2.json", Some("pass-1.json"), &[], split(3.1, 3.7), split(1.6, 1.9)),
            pass("pass-3.json", Some("pass-2.json"), &["sink-offset:<plate>"], split(3.0, 3.6), split(0.26, 0.3)),
            pass("pass-4.json", Some("pass-2.json"), &["heat-load:box"], split(3.0, 3.6), split(1.5, 2.0)),
            pass("pass-5.json", Some("pass-3.json"), &[], split(2.0, 2.6), none),
        ],
    }
}

#[test]
fn the_fall_is_stated_in_words_numbers_and_three_curves() {
    let sample = steady();
    let mut report = sample.report();
    report.history = Some(history());
    let rendered = render(&report).expect("renders");
    let words = section(&rendered.markdown, "history").replace('\u{A0}', " ");
    for text in [
        "`pass-2.json` as delivered → tuned, without new physics: RMSE held-out 3.70 K → 1.90 K, for fitting 3.10 K → 1.60 K.",
        "adds `sink-offset:<plate>`: RMSE held-out 1.90 K → 0.30 K, for fitting 1.60 K → 0.26 K (tuned, against `pass-2.json`).",
        "held-out 1.90 K → 2.00 K",
        "**the error did not fall**",
        "`pass-5.json` adds no effect: RMSE held-out 3.60 K → 2.60 K, for fitting 3.00 K → 2.00 K (as delivered, against `pass-3.json`).",
        "Without a comparison in kelvin: `pass-1.json`.",
        "| `pass-3.json` | 3.00 / 3.60 | 0.26 / 0.30 |",
        "as delivered 3.70 K, tuned only 1.90 K; tuned: pass-2.json 1.90 K, pass-3.json 0.30 K",
    ] {
        let plain = words
            .replace("\\-", "-")
            .replace("-\\>", "->")
            .replace("&lt;", "<")
            .replace("&gt;", ">")
            .replace("\\<", "<")
            .replace("\\>", ">");
        assert!(plain.contains(text), "{text} in {plain}");
    }
    let (name, svg) = rendered.figures.iter().find(|figure| figure.0.contains("error-by-pass")).expect("the figure");
    assert_well_formed(svg);
    for label in [
        "as delivered (pass-2)",
        "tuned only (pass-2)",
        "tuned with the effects",
        "pass-5",
        "RMSE held-out [K]",
        "RMSE for fitting [K]",
    ] {
        assert!(svg.contains(label), "{label} in {name}");
    }
    assert!(!rendered.html.contains("sink-offset:<plate>"), "texts of a study are escaped");
    assert_eq!(render(&report).expect("renders"), rendered);
}

#[test]
fn errors_of_other_readings_are_not_held_against_one_another() {
    let sample = steady();
    let mut report = sample.report();
    let mut other = history();
    // As many readings, but not the same.
    other.passes[2].readings_sha256 = Some("ab".into());
    report.history = Some(other);
    let markdown = render(&report).expect("renders").markdown.replace('\u{A0}', " ");
    let section = section(&markdown, "history");
    let stated = "held-out error 3.60 K with sink-offset:&lt;plate&gt; at nominal size, held-out error 0.30 K tuned, on other readings than \
                those of `pass-2.json`";
    assert!(section.replace("\\-", "-").contains(stated), "{section}");
    assert!(!section.contains("1.90 K → 0.30 K") && !section.contains("1.90 K \\-\\> 0.30"), "{section}");
}

#[test]
fn one_pass_is_no_history() {
    let sample = steady();
    let mut report = sample.report();
    let mut passes = history().passes;
    passes.truncate(2);
    report.history = Some(History { passes });
    assert!(!render(&report).expect("renders").markdown.contains("<a id=\"history\">"));
}

#[test]
fn an_evidence_that_is_not_to_be_trusted_and_chains_that_did_not_converge_are_marked() {
    let sample = steady();
    let mut report = sample.report();
    let mut doubtful = history();
    doubtful.passes[2].log_evidence_is_trusted = Some(false);
    doubtful.passes[3].converged = Some(false);
    doubtful.passes[3].remedy = Some("write \"draws\": 4000 under jobs.tuned.calibrate".into());
    report.history = Some(doubtful);
    let markdown = render(&report).expect("renders").markdown.replace('\u{A0}', " ");
    let section = section(&markdown, "history");
    let row =
        |pass: &str| section.lines().find(|line| line.starts_with(&format!("| `{pass}`"))).expect("a row").to_owned();
    assert!(
        !row("pass-2.json").contains("31.24**") && row("pass-2.json").contains("31.24 |"),
        "{}",
        row("pass-2.json")
    );
    assert!(row("pass-3.json").contains("31.24**") && row("pass-4.json").contains("31.24**"), "{section}");
    assert!(
        section.contains("The evidence of pass-3.json is marked: its importance weights have a Pareto k above 0.7")
            && section.contains("`\"sampler\": \"smc\"` gives it without such weights."),
        "{section}"
    );
    assert!(section.contains("What mends it: write \"draws\": 4000 under jobs.tuned.calibrate."), "{section}");
}

/// A report of a pass alone, or of one whose parents have no error: its first state has what was adopted in it.
#[test]
fn a_pass_that_adopts_is_not_called_as_delivered() {
    let sample = steady();
    let mut report = sample.report();
    let whole = history();
    report.history = Some(History { passes: vec![whole.passes[2].clone(), whole.passes[4].clone()] });
    let words = section(&render(&report).expect("renders").markdown, "history").replace('\u{A0}', " ");
    let said = "`pass-3.json` with sink-offset:&lt;plate&gt; at nominal size → tuned, nothing further added: RMSE held-out 3.60 K";
    assert!(words.contains(said), "{words}");
    assert!(!words.contains("without new physics") && !words.contains("pass-3.json` as delivered"), "{words}");
}

/// A pass that calibrates nothing is tuned by its diagnosis, and lacks no calibration.
#[test]
fn the_fit_of_a_diagnosis_is_the_tuned_state_of_a_pass_without_a_calibration() {
    let sample = steady();
    let mut report = sample.report();
    let mut whole = history();
    whole.passes.truncate(3);
    whole.passes[1].is_tuned_by_diagnosis = true;
    report.history = Some(whole);
    let words = section(&render(&report).expect("renders").markdown, "history").replace('\u{A0}', " ");
    assert!(
        words.contains("as delivered → tuned, without new physics (by the diagnosis): RMSE held-out 3.70 K → 1.90 K"),
        "{words}"
    );
}
