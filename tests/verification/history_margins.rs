//! Margins from history: the synthetic history of `studies/radiator` made again, and its margins computed apart.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use bmv::job::kind::JobKind;
use bmv::job::margins_from_history::{Kind, MarginsFromHistory, Output, Spec};
use bmv::random::StreamKey;

use super::radiator::run;

/// Classes with the standard deviation of their differences, K: what the thesis quotes for predictions before and after
/// correlation in the 1960s and 1970s.
const CLASSES: [(&str, f64); 2] = [("uncorrelated", 9.0), ("correlated", 5.6)];
/// Made-up programs, and the temperatures of each in a class.
const PROGRAMS: [&str; 8] = ["A", "B", "C", "D", "E", "F", "G", "H"];
const TEMPERATURES: usize = 8;
/// Share of a difference's standard deviation that all temperatures of a program have in common.
const COMMON: f64 = 0.5;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/radiator")
}

fn output() -> Output {
    let Ok(pass) = bmv::job::load(&folder().join("pass-1.json")) else { panic!("the radiator loads") };
    let spec = pass.jobs.iter().find_map(|job| job.spec.get::<Spec>().cloned()).expect("the job");
    assert_eq!(spec.comparisons.len(), CLASSES.len() * PROGRAMS.len() * TEMPERATURES);
    run(&MarginsFromHistory::new(spec))
}

#[test]
fn the_history_is_made_again_byte_for_byte() {
    let mut text = String::from("program,class,predicted [degC],measured [degC]\n");
    let key = StreamKey::new(1970, "history", "differences");
    for (class_index, (class, sd)) in CLASSES.into_iter().enumerate() {
        for (index, program) in PROGRAMS.into_iter().enumerate() {
            let mut stream = key.stream((class_index * PROGRAMS.len() + index) as u64);
            let own = COMMON * sd * stream.normal();
            for _ in 0..TEMPERATURES {
                let predicted = (20.0 + 25.0 * stream.normal()).clamp(-60.0, 80.0);
                let measured = predicted + own + (1.0 - COMMON * COMMON).sqrt() * sd * stream.normal();
                writeln!(text, "program {program},{class},{predicted:.1},{measured:.1}").unwrap();
            }
        }
    }
    let stored = std::fs::read_to_string(folder().join("data/history.csv")).unwrap_or_default();
    if stored != text {
        let made = Path::new(env!("CARGO_TARGET_TMPDIR")).join("history.csv");
        std::fs::write(&made, &text).unwrap();
        panic!("studies/radiator/data/history.csv is not what the seed gives: see {}", made.display());
    }
}

#[test]
fn margins_are_those_of_a_computation_apart() {
    let output = output();
    let text = std::fs::read_to_string(folder().join("data/history.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert_eq!(output.groups.len(), 3);
    for group in &output.groups {
        let own: Vec<f64> = (rows.iter())
            .filter(|row| group.class.as_ref().is_none_or(|class| row[1] == *class))
            .map(|row| row[3].parse::<f64>().unwrap() - row[2].parse::<f64>().unwrap())
            .collect();
        let n = own.len() as f64;
        let mean = own.iter().sum::<f64>() / n;
        let sd = (own.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (n - 1.0)).sqrt();
        assert_eq!((group.comparisons, group.programs), (own.len() as u64, Some(8)));
        assert!((group.mean_k - mean).abs() < 1e-9 && (group.sd_k.unwrap() - sd).abs() < 1e-9);
        // The margin by bisection on the normal distribution function of another crate.
        let normal = statrs::distribution::Normal::new(mean, sd).unwrap();
        let inside = |margin: f64| {
            use statrs::distribution::ContinuousCDF as _;
            normal.cdf(margin) - normal.cdf(-margin)
        };
        let (mut low, mut high) = (0.0, 100.0);
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if inside(middle) < 0.95 { low = middle } else { high = middle }
        }
        assert!((group.margin_k.unwrap() - low).abs() < 1e-6, "{:?} {low}", group.margin_k);
        // Howe's factor with quantiles of another crate: z 0.975 and chi-square 0.05.
        use statrs::distribution::ContinuousCDF as _;
        let howe = |count: f64| {
            let chi_square = statrs::distribution::ChiSquared::new(count - 1.0).unwrap().inverse_cdf(0.05);
            1.959_963_984_540_054 * ((count - 1.0) * (1.0 + 1.0 / count) / chi_square).sqrt()
        };
        assert!((group.bound_k.unwrap() - (mean.abs() + howe(n) * sd)).abs() < 1e-5);
        assert!((group.bound_by_program_k.unwrap() - (mean.abs() + howe(8.0) * sd)).abs() < 1e-5);
        // Of 64 values the largest is above 95 % with confidence 95 %, of 128 the third largest (binomial tails by hand:
        // 1 - 0.95^64 = 0.962; 128 values: 0.955 for the third, 0.889 for the fourth).
        let mut magnitudes: Vec<f64> = own.iter().map(|value| value.abs()).collect();
        magnitudes.sort_by(f64::total_cmp);
        let back = if own.len() == 64 { 1 } else { 3 };
        // Differences of kelvin and of degrees Celsius round apart.
        assert!((group.distribution_free_k.unwrap() - magnitudes[own.len() - back]).abs() < 1e-9);
        let held = group.rules.iter().find(|held| held.rule == "military-11k").unwrap();
        assert_eq!(held.inside, own.iter().filter(|value| value.abs() <= 11.0).count() as u64);
        assert!(group.rules.iter().all(|held| held.rule != "none" && held.rule != "heat-load-25"));
        assert_eq!(group.counts.iter().sum::<u64>(), group.comparisons);
    }
    // The two classes were drawn with standard deviations of 9 and 5.6 K; over 64 differences of 8 programs a standard deviation is
    // known to some 15 %.
    for ((_, sd), group) in CLASSES.into_iter().zip(&output.groups[1..]) {
        let found = group.sd_k.unwrap();
        assert!((found / sd - 1.0).abs() < 0.45, "{found} {sd}");
    }
    // The history was made without a bias; over the means of eight programs none is seen, though over the rows of one class, taken as
    // independent, the mean is more than three standard errors from 0.
    assert!(output.findings.is_empty(), "{:?}", output.findings);
    assert_eq!(Kind::key_numbers(&output).len(), 3);
}

#[test]
fn a_bias_a_program_that_dominates_and_rows_without_a_program_are_reported() {
    let row = |program: &str, difference_k: f64| bmv::job::margins_from_history::Comparison {
        class: String::new(),
        program: program.to_owned(),
        difference_k,
    };
    let mut comparisons: Vec<_> =
        (0..12).map(|index| row(["A", "B", "C", "D"][index % 4], 6.0 + 0.1 * (index % 3) as f64)).collect();
    comparisons.extend((0..20).map(|index| row("A", 6.0 + 0.1 * f64::from(index % 5))));
    let spec = |comparisons, has_programs| Spec {
        file: "history.csv".to_owned(),
        sha256: String::new(),
        comparisons,
        has_programs,
        capture: 0.95,
        confidence: 0.95,
        rules: Vec::new(),
    };
    let output: Output = run(&MarginsFromHistory::new(spec(comparisons.clone(), true)));
    assert_eq!(output.groups.len(), 1);
    let said = output.findings.join("\n");
    assert!(said.contains("hotter than predicted") && said.contains("`A` has 23 of 32 comparisons"), "{said}");
    let output: Output = run(&MarginsFromHistory::new(spec(comparisons, false)));
    let said = output.findings.join("\n");
    assert!(said.contains("does not say which program") && !said.contains("the margins are mostly its own"), "{said}");
    assert_eq!((output.groups[0].programs, output.groups[0].bound_by_program_k), (None, None));
}
