//! What rendered reports say, and that they say it in the same bytes every time.

use std::path::Path;

use bmv::report::{RenderedReport, render};
use bmv::runner::Manifest;

use super::samples::{Sample, radiator, steady, transient};

pub fn rendered(sample: &Sample) -> RenderedReport {
    render(&sample.report()).expect("renders")
}

/// The summary of the Markdown without its heading.
fn summary(report: &RenderedReport) -> &str {
    let start = report.markdown.split("## 1. Summary").nth(1).expect("a summary");
    start.split("<a id=\"problem\"").next().expect("its end").trim()
}

/// A section of the Markdown by its anchor, with what the appendix has of it.
pub fn section(markdown: &str, id: &str) -> String {
    let part = |anchor: &str| {
        let after = markdown.split(&format!("<a id=\"{anchor}\"></a>")).nth(1);
        after.and_then(|rest| rest.split("<a id=").next()).unwrap_or_default().to_owned()
    };
    let (first, rest) = (part(id), part(&format!("{id}-details")));
    assert!(!first.is_empty(), "a section {id}");
    first + &rest
}

/// Every figure of a page: what stands between its tags.
fn figures(html: &str) -> Vec<&str> {
    html.split("<figure ").skip(1).map(|part| part.split("</figure>").next().expect("closed")).collect()
}

/// Checks that tags open and close in order, without an XML parser: comments and declarations do not occur.
pub fn assert_well_formed(svg: &str) {
    let mut open = Vec::new();
    for part in svg.split('<').skip(1) {
        let tag = part.split('>').next().expect("closed tag");
        let name = tag.trim_start_matches('/').split([' ', '/', '\n']).next().expect("a name");
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "closing tag in {svg:.300}");
        } else {
            assert_eq!(tag.matches('"').count() % 2, 0, "quotes in <{tag}>");
            if !tag.ends_with('/') {
                open.push(name);
            }
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
    assert!(!svg.contains("NaN") && !svg.contains("inf\""), "numbers are finite");
}

#[test]
fn radiator_report_sets_probabilistic_and_conventional_sizes_side_by_side() {
    let report = rendered(&radiator());
    let summary = summary(&report);
    assert!(
        summary.starts_with("> **Verdict.** Requirement: T at most 35.00\u{A0}\u{B0}C, hot: predicted ")
            && summary.contains("P\u{A0}=\u{A0}0.950, required 0.990, **not met**."),
        "{summary}"
    );
    for part in [
        "- **Probability, nominal design, hot: 0.950.** T at most 35.00\u{A0}\u{B0}C; required 0.990: **not met**.",
        "- **Probabilistic size, hot: 0.3144\u{A0}m\u{B2}.** `A` for P = 0.990",
        "- **Conventional size, hot: 0.4152\u{A0}m\u{B2}.** stacked worst case, + 11",
        "- **T, hot: 28.91 \u{B1} 4.19\u{A0}\u{B0}C.** mean and standard deviation",
        "**Reconstructed.** All numbers of this case are reconstructed",
        "**Next.** In the next pass set `A` to 0.3144\u{A0}m\u{B2}; then `bmv run sample`.",
        "plots/first-screen-network.svg",
    ] {
        assert!(summary.contains(part), "{part} in {summary}");
    }
    assert!(report.markdown.contains("plots/margins-sizes-hot-temperature.svg"));
    assert!(report.markdown.contains("| 0.2945 |") && report.markdown.contains(", unsafe"), "{}", report.markdown);
    // Half-way between the sweep's points 0.32 (P = 0.99501) and 0.33 (0.99845), at 0.3244: 0.9965.
    assert!(report.markdown.contains("| nominal, + 11 K | 0.3244 | +3.2 | 0.997 |"), "{}", report.markdown);
    assert!(report.markdown.contains("| `eps` | 0.85 |  | normal, 0.85 \u{B1} 0.03, below 1 |"));
}

#[test]
fn transient_report_says_which_sensor_and_when() {
    let report = rendered(&transient());
    let summary = summary(&report);
    for part in [
        "> **Verdict.** Held-out error 1.64\u{A0}K as delivered. Worst: `T1`, +",
        "| As delivered | 1.14 | 1.64 | 2 of 2 | `T1` |",
        "> **Next.** `bmv diagnose sample/pass-1.json` says which physical effects",
        "Measured and predicted T1 over time, with the residual below. RMSE 1.53\u{A0}K, held out 2.20\u{A0}K.",
        "plots/first-screen-as-delivered-step-test-t1-history.svg",
    ] {
        assert!(summary.contains(part), "{part} in {summary}");
    }
    assert!(report.markdown.contains("0 to 2 s | valve moving"), "left-out instants are one row with their reason");
    assert!(report.markdown.contains("**Missing readings:** 2 of 1202"), "{}", report.markdown);
    // 0.8 W/K in the unit of the study.
    assert!(
        report.markdown.contains("| `G\\_bi` | 800 | mW/K |") || report.markdown.contains("| `G_bi` | 800 | mW/K |")
    );
}

#[test]
fn steady_report_has_the_map_of_phases_and_the_criteria() {
    let report = rendered(&steady());
    let summary = summary(&report);
    for part in [
        "> **Verdict.** Held-out error 0.84\u{A0}K as delivered. Worst: `housing`, +",
        "| As delivered | 0.87 | 0.84 | **1 of 2** | `housing` |",
        "Heat map of measured minus predicted in K for 9 phases and 6 sensors of balance test.",
        "the worst 9 of 22 phases",
        "plots/first-screen-as-delivered-balance-test-phases.svg",
    ] {
        assert!(summary.contains(part), "{part} in {summary}");
    }
    let map = &report.figures.iter().find(|f| f.0 == "as-delivered-balance-test-phases").expect("a map").1;
    // Phase 7: load 6, housing 0.55 * 6 + 0.25 sin(42.6) = 3.05.
    assert!(map.contains("\n+3.05\n") && map.contains("\nP22\n") && map.contains("\nstrap\n"));
    assert!(report.markdown.contains("| `P07` | not stabilised |"));
    // 1.2e-4 K/s and its error of 1e-5 K/s by the hour.
    assert!(report.markdown.contains("| `P07` | `housing` | 0.432 \u{B1} 0.036 |"), "{}", report.markdown);
    assert!(
        report.markdown.contains("| largest deviation of one reading, K | 3.15 | 3.00 | **not kept** |"),
        "{}",
        report.markdown
    );
    assert!(!report.markdown.contains("-0.0") && !report.markdown.contains("\u{2212}0.00 "));
}

#[test]
fn pages_need_nothing_from_outside_and_run_their_own_script_alone() {
    for sample in [radiator(), transient(), steady()] {
        let html = rendered(&sample).html;
        for forbidden in ["http:", "https:", "src=", "url(", "@import", "<script ", "<link", "javascript:", "onload"] {
            assert!(!html.contains(forbidden), "`{forbidden}` in the page");
        }
        let script = html.split("<script>").nth(1).and_then(|rest| rest.split("</script>").next()).expect("a script");
        let hash = bmv::document::hash::sha256_hex(script.as_bytes());
        let policy =
            html.split("script-src 'sha256-").nth(1).and_then(|rest| rest.split('\'').next()).expect("a policy");
        assert_eq!(hexadecimal(policy), hash, "the policy admits the script that is there");
        assert_eq!(html.matches("<script").count(), 1);
    }
}

/// Base 64 as hexadecimal digits.
fn hexadecimal(text: &str) -> String {
    const DIGITS: &str = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let bits: String = text.chars().filter_map(|c| DIGITS.find(c)).map(|digit| format!("{digit:06b}")).collect();
    (0..bits.len() / 8)
        .map(|at| format!("{:02x}", u8::from_str_radix(&bits[8 * at..8 * at + 8], 2).expect("bits")))
        .collect()
}

#[test]
fn the_numbers_behind_a_figure_are_those_that_it_shows() {
    let report = rendered(&steady());
    let csv = &report.data.iter().find(|own| own.0 == "as-delivered-balance-test-phases").expect("a map").1;
    let row = csv.lines().find(|line| line.starts_with("P07,housing,")).expect("a row");
    // As the map's cell: load 6, housing 0.55 * 6 + 0.25 sin(42.6) = 3.05.
    let value: f64 = row.split(',').nth(2).expect("a cell").parse().expect("a number");
    assert!((value - 3.05).abs() < 0.005, "{row}");
    assert_eq!(csv.lines().count(), 1 + 22 * 6);
    // A small table is in the page, byte for byte; a large one lies beside it.
    let all = [report, rendered(&transient()), rendered(&radiator())];
    let (mut held, mut linked) = (0, 0);
    for report in &all {
        assert_eq!(report.figures.len(), report.data.len());
        for (name, csv) in &report.data {
            let link = format!("download=\"{name}.csv\"");
            let before = report.html.split(&link).next().expect("a page");
            let address = before.rsplit("href=\"").next().and_then(|rest| rest.split('"').next()).expect("an address");
            match address.strip_prefix("data:text/csv;charset=utf-8,") {
                Some(text) => {
                    assert_eq!(&decoded(text), csv);
                    held += 1;
                }
                None => {
                    assert_eq!(address, format!("plots/{name}.csv"));
                    linked += 1;
                }
            }
            assert!(report.markdown.contains(&format!("[Data (CSV)](plots/{name}.csv)")));
            assert!(csv.lines().count() > 1, "{name} has no numbers");
        }
    }
    assert!(held > 3 && linked > 0, "{held} in the page, {linked} beside it");
}

/// What a percent-encoded text says.
fn decoded(text: &str) -> String {
    let mut parts = text.split('%');
    let mut bytes = parts.next().unwrap_or_default().as_bytes().to_vec();
    for part in parts {
        bytes.push(u8::from_str_radix(&part[..2], 16).expect("two digits"));
        bytes.extend(&part.as_bytes()[2..]);
    }
    String::from_utf8(bytes).expect("UTF-8")
}

#[test]
fn every_figure_has_a_title_a_description_a_caption_and_a_file() {
    for sample in [radiator(), transient(), steady()] {
        let report = rendered(&sample);
        let figures = figures(&report.html);
        assert_eq!(figures.len(), report.figures.len());
        assert!(figures.len() >= 2);
        for figure in figures {
            for part in ["role=\"img\"", "<title id=", "<desc id=", "<figcaption>"] {
                assert!(figure.contains(part), "{part} in {figure:.400}");
            }
            let description =
                figure.split("<desc id=").nth(1).and_then(|d| d.split('>').nth(1)).expect("a description");
            assert!(description.len() > 25, "{description}");
        }
        for (name, svg) in &report.figures {
            assert_well_formed(svg);
            assert!(report.markdown.contains(&format!("](plots/{name}.svg)")), "{name} is linked");
            assert!(svg.len() < 200_000, "{name} has {} bytes", svg.len());
        }
        let anchors: Vec<&str> = report.html.split(" id=\"").skip(1).filter_map(|p| p.split('"').next()).collect();
        let distinct: std::collections::BTreeSet<_> = anchors.iter().collect();
        assert_eq!(anchors.len(), distinct.len(), "anchors are unique: {anchors:?}");
        for target in report.html.split("href=\"#").skip(1).filter_map(|p| p.split('"').next()) {
            assert!(anchors.contains(&target), "{target} exists");
        }
    }
}

#[test]
fn same_results_same_bytes() {
    for (one, two) in [(radiator(), radiator()), (transient(), transient()), (steady(), steady())] {
        assert_eq!(rendered(&one), rendered(&two));
    }
}

#[test]
fn results_hold_every_output_in_si() {
    let report = rendered(&radiator());
    let results: serde_json::Value = serde_json::from_str(&report.results_json).expect("JSON");
    assert_eq!(results["jobs"]["uncertainty"]["kind"], "propagate");
    assert_eq!(results["jobs"]["uncertainty"]["output"]["cases"][0]["quantities"][0]["mean"], 302.06);
    assert_eq!(results["jobs"]["margins"]["output"]["sizes"].as_array().map(Vec::len), Some(8));
}

#[test]
fn writing_puts_every_file_in_its_place_and_removes_what_the_earlier_report_had() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join("deep/report");
    let mut earlier = rendered(&radiator());
    earlier.figures.push(("old".to_owned(), "<svg/>".to_owned()));
    let write = |report| bmv::report::write(report, Manifest::new("bmv report"), root.path(), Path::new("deep/report"));
    write(&earlier).expect("written");
    std::fs::write(folder.join("plots/foreign.svg"), "<svg/>").expect("written");
    let report = rendered(&radiator());
    write(&report).expect("written");
    let listed = Manifest::read(&folder).expect("a manifest").outputs;
    assert_eq!(listed.len(), 4 + report.figures.len() + report.data.len());
    assert_eq!(std::fs::read_to_string(folder.join("report.md")).expect("read"), report.markdown);
    assert!(!folder.join("plots/old.svg").exists(), "the earlier manifest names it");
    assert!(folder.join("plots/foreign.svg").exists(), "no manifest names it");
}

#[cfg(unix)]
#[test]
fn a_report_writes_and_removes_nothing_through_links() {
    let report = rendered(&radiator());
    for link in ["report", "report/plots", "report/report.md", "report/manifest.json"] {
        let (root, outside) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
        let write = |report| bmv::report::write(report, Manifest::new("bmv report"), root.path(), Path::new("report"));
        let foreign = outside.path().join("foreign.svg");
        std::fs::write(&foreign, "foreign").expect("written");
        let place = root.path().join(link);
        std::fs::create_dir_all(place.parent().expect("a folder")).expect("made");
        let to = if link.contains('.') { &foreign } else { outside.path() };
        std::os::unix::fs::symlink(to, &place).expect("linked");
        let said = write(&report).expect_err(link).to_string();
        assert!(said.contains("is a link, and nothing is written through links"), "{said}");
        assert_eq!(std::fs::read(&foreign).expect("there"), b"foreign", "{link}");
        assert_eq!(std::fs::read_dir(outside.path()).expect("listed").count(), 1, "{link}");
    }
}

#[test]
fn adopted_effects_stand_with_place_prior_and_reason() {
    let sample = steady();
    let mut report = sample.report();
    report.adopted = vec![bmv::study::AdoptedEffect {
        name: "harness".into(),
        id: "conductive-path:baseplate:board".into(),
        effect: "conductive-path".into(),
        title: "Conductive path between two nodes".into(),
        equation: "Q = G (Ta - Tb)".into(),
        source: "Fourier's law".into(),
        file: None,
        place: vec!["board".into(), "baseplate".into()],
        inputs: vec![],
        parameters: 0..1,
        because: "the <b>cable</b> was seen".into(),
        evidence: Some(bmv::study::Evidence {
            pass: "pass-1.json".into(),
            job: "missing".into(),
            ..bmv::study::Evidence::default()
        }),
        applies_to: vec!["balance test".into()],
        is_of_readings: false,
    }];
    let rendered = render(&report).expect("renders");
    let section = rendered.markdown.split("<a id=\"adopted\">").nth(1).expect("the section");
    for text in ["harness", "Q = G (Ta - Tb)", "board, baseplate", "balance test", &sample.model.parameters[0].name] {
        assert!(section.contains(text), "{text} in {section:.2000}");
    }
    assert!(rendered.html.contains("job missing of pass-1.json"));
    assert!(!rendered.html.contains("<b>cable</b>"), "texts of a study are escaped");
    assert!(!render(&sample.report()).expect("renders").markdown.contains("<a id=\"adopted\">"), "none without");
}

/// An adopted effect at the elements of the steady sample.
pub fn adopted(name: &str, place: &[&str]) -> bmv::study::AdoptedEffect {
    bmv::study::AdoptedEffect {
        name: name.into(),
        id: format!("conductive-path:{}", place.join(":")),
        effect: "conductive-path".into(),
        title: "Conductive path between two nodes".into(),
        equation: String::new(),
        source: String::new(),
        file: None,
        place: place.iter().map(|&name| name.into()).collect(),
        inputs: vec![],
        parameters: 0..1,
        because: "the cable was seen".into(),
        evidence: Some(bmv::study::Evidence {
            pass: "pass-1.json".into(),
            job: "missing".into(),
            probability: Some(0.51),
            sd: vec![("conductance".into(), 0.01)],
        }),
        applies_to: vec![],
        is_of_readings: false,
    }
}

#[test]
fn the_network_marks_what_adopted_effects_add_and_what_they_change() {
    let sample = steady();
    let drawing = |adopted: Vec<bmv::study::AdoptedEffect>| {
        let mut report = sample.report();
        report.adopted = adopted;
        let figures = render(&report).expect("renders").figures;
        figures.into_iter().find(|figure| figure.0 == "network").expect("a network").1
    };
    let band = "#FAD670";
    let plain = drawing(vec![]);
    assert!(!plain.contains(band) && !plain.contains("adopted"), "nothing is adopted");
    let path = sample.model.elements[0].name.clone();
    let added = drawing(vec![adopted(&path, &["board", "baseplate"])]);
    assert!(added.contains(band) && added.contains(&format!("adopted: {path}")), "{added:.3000}");
    // What is changed keeps its own name, and the key says what the band means.
    let changed = drawing(vec![adopted("less of it", &[&path])]);
    assert!(changed.contains(band) && !changed.contains("adopted: "), "{changed:.3000}");
    assert!(changed.contains("adopted") || changed.contains("changed"), "{changed:.3000}");
}

#[test]
fn the_first_screen_says_which_adopted_effects_act_in_predictions_and_how_sure_they_are() {
    let mut sample = steady();
    let summary = |sample: &super::samples::Sample, applies_to: &[&str], is_of_readings: bool| {
        let mut report = sample.report();
        let mut effect = adopted("harness", &["board", "baseplate"]);
        effect.applies_to = applies_to.iter().map(|&name| name.into()).collect();
        effect.is_of_readings = is_of_readings;
        report.adopted = vec![effect];
        let markdown = render(&report).expect("renders").markdown.replace('\u{A0}', " ");
        markdown.split("\n## 2. ").next().expect("a summary").to_owned()
    };
    assert!(!summary(&sample, &[], false).contains("predictions too"), "there is no environment to predict in");
    sample.environments = vec![bmv::study::requirement::Environment { name: "hot flight".into(), inputs: vec![] }];
    let everywhere = summary(&sample, &[], false);
    let said = "> **Warning.** An adopted effect acts in predictions too (`hot flight`): `harness`, a choice at 51.0 % in \
                pass-1.json";
    assert!(everywhere.contains(said), "{everywhere}");
    assert!(summary(&sample, &["hot flight"], false).contains(said));
    let of_test = summary(&sample, &["balance test"], false);
    assert!(of_test.contains("> **Note.** Of the test alone, in no prediction: `harness`."), "{of_test}");
    let of_readings = summary(&sample, &[], true);
    assert!(!of_readings.contains("predictions too") && !of_readings.contains("Of the test alone"), "{of_readings}");
}

/// A transient with a gap goes on as another measurement of the same file.
#[test]
#[ignore = "thorough"]
fn a_history_shows_all_parts_of_a_record_in_a_unit_that_keeps_its_numbers_short() {
    use bmv::job::compare::Kind;
    let rendered_in = |scale: f64, in_parts: bool| {
        let mut sample = transient();
        if in_parts {
            let mut part = sample.measurements[0].clone();
            part.name = "step test (part 2)".into();
            sample.measurements.push(part);
        }
        let is_one = super::samples::edit::<Kind>(&mut sample.results[0], |output| {
            let mut rows: Vec<_> = output.rows.iter().map(|row| row.to_owned()).collect();
            for row in &mut rows {
                if in_parts && row.held_out {
                    row.measurement = "step test (part 2)".into();
                }
                row.time_s = row.time_s.map(|time| scale * time);
            }
            output.rows = rows.into_iter().collect();
        });
        assert!(is_one, "a comparison");
        rendered(&sample)
    };
    let history = |report: &bmv::report::RenderedReport| {
        let is_history = |name: &str| name.starts_with("first-screen") && name.contains("history");
        report.figures.iter().find(|figure| is_history(&figure.0)).expect("a history").1.clone()
    };
    for (scale, unit) in [(1.0, "s"), (10.0, "min"), (100.0, "h"), (1000.0, "d")] {
        let drawn = history(&rendered_in(scale, false));
        assert!(drawn.contains(&format!("time [{unit}]")), "{unit}");
    }
    let parts = rendered_in(1.0, true);
    let summary = parts.markdown.split("\n## 2. ").next().expect("a summary");
    assert!(
        summary.contains("of `step test`, all 2 parts between its gaps") && summary.contains("held out "),
        "{summary}"
    );
    assert!(history(&parts).contains("held out"), "the rows held out are marked");
    let whole = rendered_in(1.0, false).markdown;
    assert!(!whole.contains("parts between its gaps"), "there is no gap");
}
