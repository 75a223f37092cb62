//! Names and numbers that try to break a report.

use bmv::inference::gaussian_process::tested_range::Outside;
use bmv::job::calibrate::KeptDraws;
use bmv::job::compare::{Deviation, Readings, Row};
use bmv::job::{calibrate, compare, conventional, design, diagnose, goal, kind, predict, propagate, sensitivity};
use bmv::report::PassReport;
use bmv::report::plot::{
    Along, Axis, Bar, Chart, Diagram, HeatMap, History, Layer, Limit, Mark, NodeShape, Path, Shade, Source, Strip,
    Stroke,
};
use bmv::report::plot::{bar_chart, heat_map, history, network, palette, residual_strips};
use bmv::study::document::Reference;
use bmv::study::posterior_prior::PosteriorPriorSummary;
use bmv::study::{Closing, StudyDocument};

use super::calibration::calibrated;
use super::diagnosis::diagnosed;
use super::rendering::{assert_well_formed, rendered};
use super::samples::{Sample, edit, radiator, steady, transient};
use super::sensitivity::with;

const HOSTILE: &str = "<img src=x onerror=alert(1)>|`a`[b](javascript:c)\"'&\\";

/// The radiator with its propagation as a prediction.
fn predicted() -> Sample {
    let mut sample = radiator();
    for job in &mut sample.results {
        if let Some(output) = job.output_of::<propagate::Kind>() {
            let posterior_priors = PosteriorPriorSummary {
                source: "`tuned` of `pass-1.json`".into(),
                parameters: vec!["eps".into()],
                draws: 1000,
                effective: 800.0,
                converged: false,
            };
            let posterior = propagate::Output { posterior_priors: vec![posterior_priors], ..output.clone() };
            let tested = [300.0, 300.0];
            let outside = Outside { input: HOSTILE.into(), unit: "K".into(), value: 4.0, tested, beyond: None };
            let term = predict::Term {
                environment: output.cases[0].environment.clone(),
                design_value: None,
                sensor: HOSTILE.into(),
                quantities: vec![HOSTILE.into()],
                law: "residual law".into(),
                unit: "K".into(),
                mean: f64::NAN,
                sd: 1.0,
                outside: vec![outside],
                distance: f64::INFINITY,
            };
            let validated = predict::Validated { source: HOSTILE.into(), terms: vec![term], without: output.clone() };
            let validated = Some(validated);
            let output = predict::Output { converged: false, prior: output.clone(), posterior, validated };
            job.output = kind::output::<predict::Kind>(output);
        }
    }
    sample
}

/// The sample with every name that a study chooses replaced.
fn poisoned(sample: Sample) -> Sample {
    poisoned_with(sample, HOSTILE)
}

/// The same with a text.
fn poisoned_with(mut sample: Sample, hostile: &str) -> Sample {
    let name = || hostile.to_owned();
    sample.title = name();
    sample.reconstructed = Some(name());
    sample.closing = Some(Closing { domain: vec![name()], dispositions: vec![(name(), name())], left: vec![name()] });
    sample.document = Some(StudyDocument {
        title: name(),
        number: name(),
        issue: name(),
        date: "2026-06-30".into(),
        author: Some(name()),
        licence: Some(name()),
        applicable: vec![Reference { number: name(), title: name(), issue: name() }],
        assumptions: vec![name()],
        test: vec![(name(), name())],
        reconstructed: Some(name()),
        ..StudyDocument::default()
    });
    sample.model.title = name();
    for node in &mut sample.model.nodes {
        node.name = name();
    }
    for element in &mut sample.model.elements {
        element.name = name();
    }
    for parameter in &mut sample.model.parameters {
        parameter.name = name();
        parameter.description = name();
        parameter.source = name();
        parameter.unit = name();
    }
    for measurement in &mut sample.measurements {
        measurement.file = name();
        measurement.unused_columns.push(name());
        for sensor in &mut measurement.sensors {
            sensor.unit = name();
        }
    }
    for job in &mut sample.results {
        job.name = name();
        edit::<compare::Kind>(job, |output| {
            output.fails.push(name());
            output.criteria.title = name();
            output.criteria.source = name();
            let rows = output.rows.iter().map(|row| Row {
                sensor: format!("{hostile}{}", row.sensor),
                phase: row.phase.map(|p| hostile.to_owned() + p),
                ..row.to_owned()
            });
            output.rows = rows.collect();
            for verdict in &mut output.verdicts {
                verdict.criterion = name();
            }
        });
        edit::<propagate::Kind>(job, |output| {
            output.design_variable = Some(name());
            for case in &mut output.cases {
                case.environment = name();
                for q in &mut case.quantities {
                    q.name = name();
                }
            }
        });
        edit::<predict::Kind>(job, |output| {
            output.posterior.design_variable = Some(name());
            output.posterior.posterior_priors[0].source = name();
            output.posterior.posterior_priors[0].parameters = vec![name()];
            for case in output.posterior.cases.iter_mut().chain(&mut output.prior.cases) {
                case.environment = name();
                case.quantities.iter_mut().for_each(|q| q.name = name());
            }
        });
        edit::<conventional::Kind>(job, |output| {
            output.design_variable = name();
            for size in &mut output.sizes {
                size.rule.title = name();
                size.requirement = name();
            }
        });
        edit::<design::Kind>(job, |output| {
            output.learn = vec![name()];
            output.nuisance = vec![name()];
            output.findings.push(name());
            for sensor in &mut output.sensors {
                sensor.name = name();
            }
        });
        edit::<calibrate::Kind>(job, |output| {
            output.sampler = name();
            output.objections.push(name());
            output.findings.push(name());
            for check in &mut output.predictive {
                check.sensor = name();
            }
        });
        edit::<diagnose::Kind>(job, |output| {
            output.words.push(name());
            output.warnings.push(name());
            for effect in &mut output.effects {
                effect.id = name();
                effect.effect = name();
                effect.title = name();
                effect.place = vec![name(), name()];
                effect.input = Some(name());
                effect.confused_with = vec![name()];
                effect.amplitudes = effect.amplitudes.values().map(|amount| (name(), amount.clone())).collect();
            }
            output.selected = output.selected.iter().map(|_| name()).collect();
            for model in &mut output.models {
                model.effects = model.effects.iter().map(|_| name()).collect();
            }
            for heat in &mut output.heat {
                heat.node = name();
                heat.phase = Some(name());
            }
            for test in &mut output.misfit.tests {
                test.at = name();
            }
            if let Some(experiment) = &mut output.discriminating_experiment {
                experiment.between = vec![name(), name()];
                experiment.conditions =
                    experiment.conditions.values().map(|setting| (name(), setting.clone())).collect();
                experiment.predictions =
                    experiment.predictions.values().map(|readings| (name(), readings.clone())).collect();
            }
        });
        edit::<sensitivity::Kind>(job, |output| {
            output.parameters.iter_mut().for_each(|parameter| parameter.name = name());
            for case in &mut output.cases {
                case.environment = name();
                case.quantities.iter_mut().for_each(|quantity| quantity.name = name());
                case.failures.iter_mut().for_each(|failure| failure.reason = name());
            }
        });
        edit::<goal::Kind>(job, |output| {
            output.design_variable = Some(name());
            output.advice.reasons.push(name());
            output.leading.iter_mut().for_each(|leading| leading.parameter = name());
            output.knowledge.iter_mut().for_each(|knowledge| knowledge.parameters = vec![name()]);
        });
    }
    sample
}

#[test]
#[ignore = "thorough"]
fn hostile_names_are_text_everywhere() {
    let diagnoses = ["identified", "ambiguous", "unexplained", "adequate"].map(diagnosed);
    let plain = [radiator(), transient(), steady(), predicted(), with(true)];
    for sample in plain.into_iter().chain(diagnoses) {
        let sample = poisoned(sample);
        let mut view: PassReport<'_> = sample.report();
        view.description = HOSTILE.into();
        view.changes[0].because = HOSTILE.into();
        view.warnings.push(HOSTILE.into());
        view.command = HOSTILE.into();
        let report = bmv::report::render(&view).expect("renders");
        assert!(!report.html.contains("<img"));
        assert_scripts_are_the_program_s(&report.html);
        assert!(report.html.contains("&lt;img src=x onerror=alert(1)&gt;"));
        // Outside code spans, where HTML is inert, no tag survives in the Markdown.
        let outside: String = without_code(&report.markdown);
        assert!(!outside.contains("<img"), "{outside}");
        assert!(!outside.replace("\\]", "").contains("](javascript:"), "{outside}");
        for (name, svg) in &report.figures {
            assert_well_formed(svg);
            assert!(!svg.contains("<img"));
            assert!(name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'-'), "{name} is a safe file name");
        }
        report.data.iter().for_each(|(name, csv)| assert_inert_csv(name, csv));
        assert_tables_are_even(&report.markdown);
    }
}

/// A page runs its own script and nothing else: one element of it, whose text is that of every page, and no attribute that runs.
fn assert_scripts_are_the_program_s(html: &str) {
    let plain = rendered(&steady()).html;
    let script =
        |page: &str| page.split("<script").nth(1).and_then(|rest| rest.split("</script>").next().map(str::to_owned));
    assert_eq!(html.matches("<script").count(), 1);
    assert_eq!(script(html), script(&plain));
    assert_eq!(html.matches("</script").count(), 1);
    let (policy, own) = (
        |page: &str| page.split("Content-Security-Policy\" content=\"").nth(1).map(|rest| rest[..120].to_owned()),
        html,
    );
    assert_eq!(policy(own), policy(&plain), "the policy is that of every page");
    // Tags alone: what is escaped between them is text.
    for tag in
        own.split("<script").next().unwrap_or_default().split('<').skip(1).filter_map(|part| part.split('>').next())
    {
        let names = tag.split('"').step_by(2).flat_map(str::split_whitespace);
        let runs = names.clone().find(|name| name.starts_with("on") && name.contains('='));
        assert_eq!(runs, None, "<{tag}>");
        for address in tag.split("href=\"").skip(1).filter_map(|rest| rest.split('"').next()) {
            let is_own =
                ["#", "data:text/csv;charset=utf-8,", "plots/", ".."].iter().any(|start| address.starts_with(start));
            assert!(is_own && !address.contains(['<', '>', '\'']), "{address:.200}");
        }
    }
}

/// A table of as many cells in each row, none of which a spreadsheet takes for a formula or a browser for markup that it runs.
fn assert_inert_csv(name: &str, csv: &str) {
    assert!(name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'-'), "{name} is a safe file name");
    let rows: Vec<Vec<String>> = csv.lines().map(cells).collect();
    for row in &rows {
        assert_eq!(row.len(), rows[0].len(), "{name}: {row:?}");
        for cell in row {
            let is_formula = cell.trim_start().starts_with(['=', '+', '-', '@']) && cell.parse::<f64>().is_err();
            assert!(!is_formula && !cell.contains(['\t', '\r', '\u{202e}']), "{name}: {cell:?}");
        }
    }
}

/// The cells of a line of CSV (RFC 4180); no cell of these files holds a line end.
fn cells(line: &str) -> Vec<String> {
    let (mut all, mut is_quoted) = (vec![String::new()], false);
    for part in line.split_inclusive(['"', ',']) {
        let (text, end) = part.split_at(part.trim_end_matches(['"', ',']).len());
        let last = all.last_mut().expect("a cell");
        last.push_str(text);
        match end {
            "\"" => is_quoted = !is_quoted,
            "," if is_quoted => last.push(','),
            "," => all.push(String::new()),
            _ => {}
        }
    }
    assert!(!is_quoted, "{line}");
    all
}

/// What may stand in a title, a name, a cell, an effect or a log and be more than text: for a browser, a spreadsheet, Markdown, a
/// style sheet, the page's script, a terminal.
const TRIES: [&str; 40] = [
    "<script>alert(1)</script>",
    "</script><script>alert(1)</script>",
    "</title><script>alert(1)</script>",
    "</style><script>alert(1)</script>",
    "\"><script>alert(1)</script>",
    "'><img src=x onerror=alert(1)>",
    "\" onmouseover=\"alert(1)",
    "\" autofocus onfocus=alert(1) x=\"",
    "<svg onload=alert(1)>",
    "</svg><svg onload=alert(1)>",
    "</desc><script>alert(1)</script>",
    "<a href=javascript:alert(1)>a</a>",
    "[a](javascript:alert(1))",
    "![a](https://example.org/a.png)",
    "<https://example.org>",
    "<iframe srcdoc=\"<script>alert(1)</script>\">",
    "<base href=https://example.org/>",
    "<meta http-equiv=refresh content=0>",
    "<details open ontoggle=alert(1)>",
    "<!--<script>alert(1)//-->",
    "]]><script>alert(1)</script>",
    "&lt;script&gt;alert(1)&lt;/script&gt;",
    "&#60;script&#62;alert(1)",
    "\u{202e}<script>alert(1)</script>",
    "a\n12 12\t<img src=x onerror=alert(1)>",
    "a\t<b>\n0 0\tb",
    "data:text/html,<script>alert(1)</script>",
    "plots/../../../etc/passwd",
    "..\\..\\a",
    "{{ policy | safe }}",
    "{% raw %}<script>{% endraw %}",
    "\"; } body { background: url(https://example.org) } /*",
    "=HYPERLINK(\"https://example.org\",\"a\")",
    "=cmd|' /C calc'!A0",
    "+1+cmd|' /C calc'!A0",
    "-2+3+cmd|' /C calc'!A0",
    "@SUM(1+1)*cmd|' /C calc'!A0",
    " \t=1+1",
    "a\",=1+1,\"",
    "a\r\n=1+1",
];

#[test]
#[ignore = "thorough"]
fn no_try_of_a_name_gets_through() {
    for (number, hostile) in TRIES.iter().enumerate() {
        // Each sort of page in turn: rendering all would cost the more the less it tells.
        let sample = [steady, transient, predicted, radiator][number % 4]();
        let sample = poisoned_with(sample, hostile);
        let mut view: PassReport<'_> = sample.report();
        view.description = (*hostile).into();
        view.warnings.push((*hostile).into());
        view.command = (*hostile).into();
        let report = bmv::report::render(&view).expect("renders");
        assert_scripts_are_the_program_s(&report.html);
        let before_script = report.html.split("<script").next().expect("a page");
        for tag in
            ["<img", "<iframe", "<base", "<svg onload", "<details open ", "<meta http-equiv=refresh", "<a href=java"]
        {
            assert!(!before_script.contains(tag), "{hostile}: {tag}");
            assert!(!without_code(&report.markdown).contains(tag), "{hostile}: {tag}");
        }
        let styles = report.html.split("<style").skip(1).map(|part| part.split("</style>").next().unwrap_or(part));
        assert!(styles.clone().count() > 0 && styles.into_iter().all(|style| !style.contains("url(")), "{hostile}");
        assert!(!report.html.contains('\u{202e}') && !report.markdown.contains('\u{202e}'));
        report.figures.iter().for_each(|(_, svg)| assert_well_formed(svg));
        report.data.iter().for_each(|(name, csv)| assert_inert_csv(name, csv));
        // What the script reads: as many cells in each line as headings, places of numbers.
        for values in report.html.split("data-values=\"").skip(1).filter_map(|rest| rest.split('"').next()) {
            let headings = values.lines().next().expect("headings").split('\t').count();
            for line in values.lines().skip(1) {
                let cells: Vec<&str> = line.split('\t').collect();
                assert_eq!(cells.len(), headings + 1, "{line}");
                assert!(cells[0].split(' ').all(|place| place.parse::<i32>().is_ok()), "{line}");
            }
        }
    }
}

/// Markdown without its code spans.
fn without_code(markdown: &str) -> String {
    let mut out = String::new();
    let mut rest = markdown;
    while let Some(start) = rest.find('`') {
        if rest[..start].ends_with('\\') {
            out.push_str(&rest[..=start]);
            rest = &rest[start + 1..];
            continue;
        }
        let fence: usize = rest[start..].bytes().take_while(|b| *b == b'`').count();
        out.push_str(&rest[..start]);
        let after = &rest[start + fence..];
        let Some(end) = find_fence(after, fence) else { break };
        rest = &after[end + fence..];
    }
    out + rest
}

fn find_fence(text: &str, fence: usize) -> Option<usize> {
    let bytes = text.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        let run = bytes[at..].iter().take_while(|b| **b == b'`').count();
        if run == fence {
            return Some(at);
        }
        at += run.max(1);
    }
    None
}

/// Every row of a table has as many cells as its heading.
fn assert_tables_are_even(markdown: &str) {
    let cells = |line: &str| line.replace("\\\\", "").replace("\\|", "").matches('|').count();
    let mut heading = None;
    let mut tables = 0;
    for line in markdown.lines() {
        if !line.starts_with('|') {
            heading = None;
            continue;
        }
        match heading {
            None => {
                heading = Some(cells(line));
                tables += 1;
            }
            Some(expected) => assert_eq!(cells(line), expected, "{line}"),
        }
    }
    assert!(tables > 3, "{tables} tables seen");
}

#[test]
fn pages_without_results_are_pages() {
    for mut sample in [radiator(), transient(), steady()] {
        sample.results.clear();
        assert!(rendered(&sample).markdown.contains("No job of this pass has a result yet"));
        sample.measurements.clear();
        sample.model = bmv::thermal::Model::default();
        assert!(!rendered(&sample).html.contains("Thermal model"));
    }
}

#[test]
#[ignore = "thorough"]
fn empty_and_broken_outputs_are_reported_not_fatal() {
    for mut sample in [radiator(), transient(), steady(), calibrated(), predicted(), with(true)] {
        for job in &mut sample.results {
            edit::<compare::Kind>(job, |output| {
                let rows = output.rows.iter().map(|row| Row { predicted: f64::NAN, ..row.to_owned() });
                output.rows = rows.collect();
                output.train = Deviation { rmse: f64::NAN, ..Deviation::default() };
                output.chi2_per_reading = Some(f64::INFINITY);
            });
            edit::<propagate::Kind>(job, |output| {
                for q in output.cases.iter_mut().flat_map(|c| &mut c.quantities) {
                    q.mean = f64::NAN;
                    q.histogram_counts.clear();
                    q.cdf = vec![1.0];
                    q.quantiles.clear();
                }
                output.reached[0].design_value = None;
            });
            edit::<predict::Kind>(job, |output| {
                output.prior.cases.clear();
                output.posterior.cases.truncate(3);
                output.posterior.reached.clear();
                for q in output.posterior.cases.iter_mut().flat_map(|c| &mut c.quantities) {
                    q.mean = f64::NAN;
                    q.quantiles.clear();
                }
            });
            edit::<conventional::Kind>(job, |output| {
                for size in &mut output.sizes {
                    size.size = None;
                    size.margin = f64::NAN;
                }
            });
            edit::<design::Kind>(job, |output| {
                output.candidates.clear();
                output.correlations.clear();
            });
            edit::<calibrate::Kind>(job, |output| {
                output.draws = KeptDraws::default();
                output.correlations.clear();
                for own in output.parameters.values_mut() {
                    own.mean = f64::NAN;
                    own.rhat = None;
                }
            });
            edit::<diagnose::Kind>(job, |output| {
                output.misfit.family_wise_p = f64::NAN;
                for effect in &mut output.effects {
                    effect.probability = f64::NAN;
                    effect.amplitudes.clear();
                }
                for heat in &mut output.heat {
                    heat.watts = f64::NAN;
                }
            });
            edit::<sensitivity::Kind>(job, |output| {
                for quantity in output.cases.iter_mut().flat_map(|c| &mut c.quantities) {
                    quantity.local.iter_mut().for_each(|local| local.scaled_by_sd = None);
                    quantity.morris.clear();
                    quantity.scatter = None;
                    for index in quantity.sobol.iter_mut().flat_map(|sobol| &mut sobol.total) {
                        index.estimate.value = f64::NAN;
                    }
                }
            });
            edit::<goal::Kind>(job, |output| {
                output.knowledge.clear();
                output.target = None;
                output.truths = None;
                output.leading.clear();
            });
        }
        for (_, svg) in rendered(&sample).figures {
            assert_well_formed(&svg);
        }
        for job in &mut sample.results {
            edit::<compare::Kind>(job, |output| {
                output.rows = Readings::default();
                output.sensors.clear();
                output.phases.clear();
            });
            edit::<propagate::Kind>(job, |output| {
                output.cases.clear();
            });
        }
        assert!(!rendered(&sample).html.is_empty());
    }
}

/// Sets of values that plots are known to stumble over.
fn degenerate() -> Vec<Vec<(f64, f64)>> {
    let nan = f64::NAN;
    vec![
        vec![],
        vec![(1.0, 1.0)],
        vec![(1.0, 2.0); 5],
        vec![(nan, nan), (nan, 1.0), (1.0, nan)],
        vec![(0.0, f64::INFINITY), (1.0, f64::NEG_INFINITY)],
        vec![(-1e300, 1e300), (1e300, -1e300)],
        vec![(1e-300, 1e-300), (2e-300, 3e-300)],
        vec![(0.0, 273.15), (1.0, 273.15 + 1e-13)],
    ]
}

#[test]
fn plots_of_degenerate_data_are_drawings() {
    for points in degenerate() {
        let triples: Vec<(f64, f64, f64)> = points.iter().map(|p| (p.0, p.1, p.1)).collect();
        let edges: Vec<f64> = points.iter().map(|p| p.0).collect();
        let heights: Vec<f64> = points.iter().map(|p| p.1).collect();
        let colour = palette::BLUE;
        let label = "a label".to_owned();
        let chart = Chart {
            is_small: false,
            x: Axis::new("x"),
            y: Axis::new("y"),
            layers: vec![
                Layer::Band { points: triples.clone(), colour, label: label.clone() },
                Layer::Line { points: points.clone(), colour, stroke: Stroke::Dashed, label: label.clone() },
                Layer::Line { points: points.clone(), colour, stroke: Stroke::Step, label: label.clone() },
                Layer::Dots { points: points.clone(), colour, mark: Mark::Ring, label: label.clone() },
                Layer::Intervals { points: triples.clone(), colour },
                Layer::Bars { edges: edges.clone(), heights: heights.clone(), colour, label: label.clone() },
                Layer::Cells {
                    x_edges: edges.clone(),
                    y_edges: edges.clone(),
                    values: vec![heights.clone()],
                    colour,
                    label,
                },
            ],
            limits: points
                .iter()
                .map(|p| Limit { along: Along::X, value: p.1, label: "limit".into(), colour })
                .collect(),
            shades: points.iter().map(|p| Shade { from: p.0, to: p.1 }).collect(),
            shade_label: "shade".into(),
            height: 0,
        };
        let strips = [Strip { label: "s".into(), points: points.clone() }];
        let bars: Vec<Bar> = points
            .iter()
            .map(|p| Bar {
                label: "b".into(),
                from: 0.0,
                value: p.0,
                interval: Some([p.0, p.1]),
                text: "t".into(),
                colour,
            })
            .collect();
        let map = HeatMap {
            columns: vec!["c".repeat(80)],
            rows: points.iter().map(|p| ("r".to_owned(), true, vec![Some(p.0)])).collect(),
            ..HeatMap::default()
        };
        for drawing in [
            chart.draw(),
            residual_strips("x", "y", &strips, &[]),
            residual_strips("x", "y", &[], &[]),
            bar_chart(&Axis::new("x"), &bars, points.first().map(|p| (p.1, "marker"))),
            heat_map(&map),
            history(&History { points: triples, limit: Some(1.0), ..History::default() }),
        ] {
            let svg = drawing.svg("id", "title", "description", true);
            assert_well_formed(&svg);
            assert!(aspect(&svg) > 0.05);
        }
    }
}

#[test]
fn networks_of_any_shape_are_drawings() {
    for count in [0, 1, 2, 5, 20, 60] {
        let mut diagram = Diagram::default();
        for i in 0..count {
            let shape = [NodeShape::Diffusion, NodeShape::Arithmetic, NodeShape::Boundary][i % 3];
            diagram.nodes.push((format!("node {i} {}", "x".repeat(i)), shape));
            diagram.paths.push((
                format!("path {i}"),
                [Path::Conductor, Path::Radiation, Path::Flow, Path::Cooler][i % 4],
                i,
                (i * 7 + 1) % count,
            ));
            diagram.sources.push((format!("source {i}"), Source::Heater, i));
        }
        // A path to a node that is not there, and one from a node to itself.
        diagram.paths.push(("odd".into(), Path::Conductor, 0, 999));
        diagram.paths.push(("self".into(), Path::Cooler, 0, 0));
        let svg = network(&diagram).svg("id", "title", "description", true);
        assert_well_formed(&svg);
        assert!(count == 0 || svg.contains("\nnode 0\n"));
    }
}

/// Height divided by width of a drawing.
fn aspect(svg: &str) -> f64 {
    let view_box = svg.split_once("viewBox=\"0 0 ").and_then(|(_, rest)| rest.split_once('"')).expect("a view box").0;
    let (width, height) = view_box.split_once(' ').expect("a width and a height");
    height.parse::<f64>().expect("a number") / width.parse::<f64>().expect("a number")
}
