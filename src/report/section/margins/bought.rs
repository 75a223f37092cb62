//! What sizes by rule buy and cost, judged by what is known after the calibration.

use crate::job::conventional::{self, Basis, Size};
use crate::job::correlate::Method;
use crate::job::predict;
use crate::job::propagate::{self, Probability};
use crate::math::sort::sort_by;
use crate::math::special::{normal_cdf, normal_quantile};
use crate::report::number::{self, NONE, Shown, significant};
use crate::report::page::{Block, Cell, Column, Figure, Status, Table, Text, Tone};
use crate::report::plot::palette::{self, Colour};
use crate::report::plot::{Axis, Bar, bar_chart};
use crate::report::section::propagation::curve;
use crate::report::section::sizing::{label, pairs, sizes_of};
use crate::report::view::PassReport;
use crate::study::requirement::ALL;

/// What was known before the test, in a word.
const BEFORE: &str = "before";
/// Colour of what is neither surely safe nor surely not.
const GREY: Colour = (150, 162, 174);

/// A size or limit, with what it buys.
struct Row<'r> {
    label: String,
    /// What was known: before the test, after which correlation, the prediction.
    known: String,
    /// The same in a word, for the picture.
    short: &'static str,
    size: Option<f64>,
    interval: Option<[f64; 2]>,
    bought: Option<Probability>,
    /// The job behind it.
    job: &'r str,
    is_probabilistic: bool,
}

/// What is judged: a prediction over a design variable in an environment.
struct Question<'r> {
    job: &'r str,
    output: &'r predict::Output,
    environment: &'r str,
    design: &'r str,
    required: f64,
    requirement: String,
    rows: Vec<Row<'r>>,
    /// The rules: label of the margin, title and source.
    rules: Vec<(String, String)>,
}

/// The blocks on margins; none without sizes by rule over the design variable of a prediction.
pub(super) fn blocks(report: &PassReport<'_>) -> Vec<Block> {
    let mut blocks = Vec::new();
    for (job, output) in report.outputs::<predict::Kind>() {
        let Some(design) = output.posterior.design_variable.as_deref() else { continue };
        let mut environments: Vec<&str> = Vec::new();
        for case in &output.posterior.cases {
            if !environments.contains(&case.environment.as_str()) {
                environments.push(&case.environment);
            }
        }
        for environment in environments {
            let Some(question) = question(report, job, output, environment, design) else { continue };
            blocks.push(Block::paragraph(opening(&question)));
            blocks.extend(unsafe_rules(&question));
            blocks.push(Block::Figure(figure(report, &question)));
            blocks.push(table(report, &question));
            let rules = question.rules.iter();
            blocks.push(Block::List(rules.map(|(title, source)| Text::new(title).plain(": ").plain(source)).collect()));
        }
    }
    blocks
}

/// Straight on the probit scale between the values of a sweep; `None` outside it.
pub fn between(points: &[(f64, f64)], at: f64, samples: u64) -> Option<f64> {
    let half = 0.5 / samples.max(1) as f64;
    let pair = points.windows(2).find(|pair| pair[0].0 <= at && at <= pair[1].0)?;
    let [(x0, p0), (x1, p1)] = [pair[0], pair[1]];
    let share = if x1 > x0 { (at - x0) / (x1 - x0) } else { 0.0 };
    if p0 == p1 {
        return Some(p0);
    }
    let probit = |p: f64| normal_quantile(p.clamp(half, 1.0 - half));
    Some(normal_cdf(probit(p0) + share * (probit(p1) - probit(p0))))
}

fn bought(points: &[(f64, Probability)], at: f64, samples: u64) -> Option<Probability> {
    let of = |pick: fn(&Probability) -> f64| {
        let line: Vec<(f64, f64)> = points.iter().map(|(x, own)| (*x, pick(own))).collect();
        between(&line, at, samples)
    };
    Some(Probability { value: of(|own| own.value)?, lower: of(|own| own.lower)?, upper: of(|own| own.upper)? })
}

fn question<'r>(
    report: &'r PassReport<'_>,
    job: &'r str,
    output: &'r predict::Output,
    environment: &'r str,
    design: &'r str,
) -> Option<Question<'r>> {
    let own = |case: &&propagate::Case| case.environment == environment && case.design_value.is_some();
    let case = output.posterior.cases.iter().find(own)?;
    let met = case.requirements.iter().find(|met| met.requirement == ALL).or(case.requirements.first())?;
    let points = curve(&output.posterior, environment, &met.requirement);
    let samples = output.posterior.samples;
    let mut rows = Vec::new();
    let mut states: Vec<(&str, &'static str, &propagate::Output)> = vec![("before the test", BEFORE, &output.prior)];
    if let Some(validated) = &output.validated {
        states.push(("posterior alone", "posterior", &validated.without));
        states.push(("posterior and discrepancy", "validated", &output.posterior));
    } else {
        states.push(("posterior", "posterior", &output.posterior));
    }
    for (known, short, state) in states {
        let same = |own: &&propagate::Reached| own.environment == environment && own.requirement == met.requirement;
        let Some(reached) = state.reached.iter().find(same) else { continue };
        rows.push(Row {
            label: format!("probabilistic, P = {}", number::probability(reached.probability)),
            known: known.to_owned(),
            short,
            size: reached.design_value,
            interval: reached.interval,
            bought: reached.design_value.and_then(|size| bought(&points, size, samples)),
            job,
            is_probabilistic: true,
        });
    }
    let probabilistic = rows.len();
    let mut rules: Vec<(String, String)> = Vec::new();
    for (name, sizes) in report.outputs::<conventional::Kind>() {
        if sizes.design_variable != design {
            continue;
        }
        let (known, short) = match (&sizes.correlation, &sizes.priors_of) {
            (Some(correlation), _) if correlation.method == Method::LeastSquares.words() => {
                (format!("correlated, {}", correlation.method), "least sq.")
            }
            (Some(correlation), _) => (format!("correlated, {}", correlation.method), "one by one"),
            (None, Some(pass)) => (format!("before the test, as in {pass}"), BEFORE),
            (None, None) => ("before the test".to_owned(), BEFORE),
        };
        // All requirements together where the job has several of them.
        let Some(&pair) = pairs(sizes).iter().find(|pair| pair.0 == environment) else { continue };
        let row = |size: &Size| Row {
            label: label(size),
            known: known.clone(),
            short,
            size: size.size,
            interval: None,
            bought: size.size.and_then(|value| bought(&points, value, samples)),
            job: name,
            is_probabilistic: false,
        };
        let chosen = sizes_of(sizes, pair);
        for size in &chosen {
            let rule = (size.rule.title.clone(), size.rule.source.clone());
            if !rules.contains(&rule) {
                rules.push(rule);
            }
        }
        // A nominal analysis and a stack of worst cases are two practices; both are shown.
        rows.extend([Basis::Nominal, Basis::StackedWorstCase].iter().flat_map(|basis| {
            chosen.iter().filter(|size| size.basis == *basis).map(|size| row(size)).collect::<Vec<_>>()
        }));
    }
    let (required, requirement) = (met.required, met.requirement.clone());
    (rows.len() > probabilistic).then_some(Question {
        job,
        output,
        environment,
        design,
        required,
        requirement,
        rows,
        rules,
    })
}

impl Question<'_> {
    /// The size that is known best.
    fn reference(&self) -> Option<f64> {
        self.rows.iter().rev().find(|row| row.is_probabilistic)?.size
    }

    /// Whether a size is safe: its probability is the required one or more; `None` where its interval holds that, or where
    /// the size is outside the sweep.
    fn is_safe(&self, row: &Row<'_>) -> Option<bool> {
        let bought = row.bought?;
        if bought.lower >= self.required {
            Some(true)
        } else if bought.upper < self.required {
            Some(false)
        } else {
            None
        }
    }

    fn word(&self, row: &Row<'_>) -> (&'static str, Status) {
        match (row.size, self.is_safe(row)) {
            (None, _) => ("none in the range", Status::Caution),
            (Some(size), _) if row.is_probabilistic && self.reference() == Some(size) => ("just safe", Status::Ok),
            (Some(_), Some(true)) => ("safe", Status::Ok),
            (Some(_), Some(false)) => ("UNSAFE", Status::Fail),
            (Some(_), None) if row.bought.is_none() => ("outside the sweep", Status::Caution),
            (Some(_), None) => ("undecided", Status::Caution),
        }
    }
}

fn opening(question: &Question<'_>) -> Text {
    let with = if question.output.validated.is_some() { "posterior and the discrepancy" } else { "posterior" };
    Text::new("What does each margin buy and cost? Every size or limit of ")
        .code(question.design)
        .plain(" in environment ")
        .code(question.environment)
        .plain(", from the time when each was known, is judged by what is known last: the probability with the ")
        .plain(with)
        .plain(" of job ")
        .code(question.job)
        .plain(" that ")
        .plain(if question.requirement == ALL {
            "all requirements are met".to_owned()
        } else {
            format!("{} is met", question.requirement)
        })
        .plain(format!(", of which {} is required.", number::probability(question.required)))
}

/// Which rules are unsafe.
fn unsafe_rules(question: &Question<'_>) -> Option<Block> {
    let by_rule = || question.rows.iter().filter(|row| !row.is_probabilistic);
    let failed: Vec<&Row<'_>> = by_rule().filter(|row| question.is_safe(row) == Some(false)).collect();
    let mut groups: Vec<(&str, Vec<String>)> = Vec::new();
    for row in &failed {
        let bought = row.bought.map_or_else(String::new, |own| number::probability(own.value));
        let text = format!("{} (P = {bought})", row.label);
        match groups.iter_mut().find(|(known, _)| *known == row.known) {
            Some((_, list)) => list.push(text),
            None => groups.push((&row.known, vec![text])),
        }
    }
    let groups: Vec<String> = groups.iter().map(|(known, list)| format!("{known}: {}", list.join(", "))).collect();
    let text = format!(
        "UNSAFE: {} of {} sizes by rule buy less than the required probability of {}: {}.",
        failed.len(),
        by_rule().count(),
        number::probability(question.required),
        groups.join("; ")
    );
    (!failed.is_empty()).then(|| Block::callout(Tone::Warning, text))
}

fn figure(report: &PassReport<'_>, question: &Question<'_>) -> Figure {
    let shown = Shown::written(&question.output.posterior.design_unit);
    let nominal = report.nominal_design(question.design);
    let bars: Vec<Bar> = (question.rows.iter())
        .map(|row| {
            let text = match (row.size, row.bought) {
                (None, _) => "none in the range".to_owned(),
                (Some(size), None) => shown.text(size),
                (Some(size), Some(own)) => format!("{}, P {}", shown.text(size), number::probability(own.value)),
            };
            let colour = match (row.is_probabilistic, question.is_safe(row)) {
                (true, _) => palette::BLUE,
                (false, Some(true)) => palette::AMBER,
                (false, Some(false)) => palette::VERMILION,
                (false, None) => GREY,
            };
            Bar {
                label: format!("{}: {}", row.short, row.label.replace("stacked worst case", "stacked")),
                from: 0.0,
                value: row.size.map_or(f64::NAN, |size| shown.value(size)),
                interval: row.interval.map(|interval| interval.map(|end| shown.value(end))),
                text,
                colour,
            }
        })
        .collect();
    let marker = nominal.map(|value| (shown.value(value), format!("nominal design {}", shown.text(value))));
    let listed: Vec<String> = bars.iter().map(|bar| format!("{}: {}", bar.label, bar.text)).collect();
    Figure {
        id: format!("{}-margins-{}", question.job, question.environment),
        drawing: bar_chart(
            &Axis::new(shown.title(question.design)),
            &bars,
            marker.as_ref().map(|(value, text)| (*value, text.as_str())),
        ),
        caption: Text::new("Sizes and limits of ")
            .code(question.design)
            .plain(" before and after the test, environment ")
            .code(question.environment)
            .plain(
                ", with the probability that each buys by what is known last (before: before the test; one by one and least sq.: after \
                 a correlation, one parameter at a time and by least squares; stacked: all parameters at their worst ends): \
                 probabilistic in blue with the interval of its \
                 sampling, by rule in amber where that is the required one or more, in red where it is less, in grey where \
                 neither is sure.",
            ),
        alternative: format!("Bar chart of sizes. {}.", listed.join("; ")),
    }
}

/// Mean of a quantity along the sweep, straight between its values.
fn resource(question: &Question<'_>, name: &str, at: f64) -> Option<f64> {
    let own = question.output.posterior.cases.iter().filter(|case| case.environment == question.environment);
    let mut points: Vec<(f64, f64)> = own
        .filter_map(|case| Some((case.design_value?, case.quantities.iter().find(|own| own.name == name)?.mean)))
        .collect();
    sort_by(&mut points, |a, b| a.0.total_cmp(&b.0));
    let pair = points.windows(2).find(|pair| pair[0].0 <= at && at <= pair[1].0)?;
    let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
    Some(if x1 > x0 { y0 + (at - x0) / (x1 - x0) * (y1 - y0) } else { y0 })
}

fn table(report: &PassReport<'_>, question: &Question<'_>) -> Block {
    let design = Shown::written(&question.output.posterior.design_unit);
    let reference = question.reference();
    // What no requirement is about is what a size costs.
    let asked = |name: &str| {
        let quantity = |index: usize| report.model.quantities.get(index).is_some_and(|own| own.name == name);
        report.requirements.iter().any(|requirement| quantity(requirement.quantity))
    };
    let case = question.output.posterior.cases.iter().find(|case| case.environment == question.environment);
    let resources: Vec<(&str, Shown)> = case
        .iter()
        .flat_map(|case| &case.quantities)
        .filter(|own| !asked(&own.name))
        .map(|own| (own.name.as_str(), Shown::quantity(&own.unit, own.is_temperature)))
        .collect();
    let rows = question.rows.iter().map(|row| {
        let against = match (row.size, reference) {
            (Some(size), Some(reference)) if design.is_celsius() => number::signed(size - reference, 1),
            (Some(size), Some(reference)) if reference != 0.0 => number::signed(100.0 * (size / reference - 1.0), 1),
            _ => NONE.to_owned(),
        };
        let (word, status) = question.word(row);
        let label = if row.is_probabilistic { Text::default().strong(&row.label) } else { Text::new(&row.label) };
        let mut cells = vec![
            Cell::from(row.known.clone()),
            label.into(),
            row.size.map_or_else(|| NONE.to_owned(), |size| significant(design.value(size), 4)).into(),
            row.bought.map_or_else(|| NONE.to_owned(), |own| number::probability(own.value)).into(),
            Cell::marked(word, status),
            against.into(),
        ];
        for (name, shown) in &resources {
            let value = row.size.and_then(|size| resource(question, name, size));
            cells.push(value.map_or_else(|| NONE.to_owned(), |value| shown.number(value)).into());
        }
        cells.push(Cell::code(row.job));
        cells
    });
    let mut columns = vec![
        Column::text("Known"),
        Column::text("Rule"),
        Column::number(question.design, design.unit.clone()),
        Column::number("P that it buys", ""),
        Column::text("Judged"),
        Column::number("Against what is known last", if design.is_celsius() { "K" } else { "%" }),
    ];
    columns.extend(resources.iter().map(|(name, shown)| Column::number(*name, shown.unit.clone())));
    columns.push(Column::text("Job"));
    Block::Table(Table {
        caption: "Margins before and after: size or limit by every rule, the probability that it buys (between the points of the \
                  sweep straight on the probit scale), and what it costs against the probabilistic one that is known last."
            .into(),
        columns,
        rows: rows.collect(),
    })
}
