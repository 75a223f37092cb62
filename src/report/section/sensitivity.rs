//! Which parameters matter: shares of the variance with their intervals, elementary effects, derivatives.

mod brief;

use crate::document::counted;
use crate::job::sensitivity::{Case, Kind, Method, OfQuantity, Output, Parameter, Sobol};
use crate::math::sort::sort_by;
use crate::report::number::{self, NONE, Shown, fixed, percent, significant};
use crate::report::page::{Block, Cell, Column, Figure, Section, Status, Table, Text, Tone};
use crate::report::plot::{Axis, Bar, Chart, Layer, Mark, bar_chart, palette};
use crate::report::view::PassReport;
use crate::statistics::sobol_indices::{Estimate, Place};

use super::Entry;

/// Parameters in a figure.
const MOST_BARS: usize = 8;
/// Failed solves that are listed.
const MOST_FAILURES: usize = 20;
/// Pairs in the table of second-order effects.
const MOST_PAIRS: usize = 12;

/// The section, and its kind's results in brief.
pub(super) const SECTION: Entry = Entry::of_kind(build, &brief::Sensitivity);

/// The section on sensitivity; not without such a job.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    // A model that is asked outside has no derivatives of its own.
    let by_differences = report.model.external.is_some();
    for (name, output) in report.outputs::<Kind>() {
        blocks.push(Block::Paragraph(introduction(name, output)));
        blocks.extend(precision(output));
        let mut is_first = true;
        for case in &output.cases {
            blocks.extend(failures(case));
            for quantity in &case.quantities {
                let shown = of_quantity(name, output, case, quantity, by_differences);
                if is_first {
                    blocks.push(Block::Heading(heading(output, case, quantity)));
                    blocks.extend(shown);
                } else {
                    blocks.push(Block::Details(heading(output, case, quantity), shown));
                }
                is_first = false;
            }
        }
    }
    (!blocks.is_empty()).then(|| Section { id: "sensitivity", title: "Which parameters matter".into(), blocks })
}

/// Positions of the parameters by total effect, largest first.
pub fn by_total(sobol: &Sobol) -> Vec<usize> {
    let mut order: Vec<usize> = (0..sobol.total.len()).collect();
    sort_by(&mut order, |&i, &j| sobol.total[j].estimate.value.total_cmp(&sobol.total[i].estimate.value));
    order
}

/// Positions of the parameters in the order in which they are shown.
fn order(output: &Output, quantity: &OfQuantity) -> Vec<usize> {
    if let Some(sobol) = &quantity.sobol {
        return by_total(sobol);
    }
    let size = |at: usize| {
        let morris = quantity.morris.get(at).map(|effect| effect.mu_star);
        let local = quantity.local.get(at).and_then(|local| local.scaled_by_sd);
        morris.or(local.map(f64::abs)).or(quantity.derivative.get(at).map(|d| d.bound.value)).unwrap_or(0.0)
    };
    let mut order: Vec<usize> = (0..output.parameters.len()).collect();
    sort_by(&mut order, |&i, &j| size(j).total_cmp(&size(i)));
    order
}

fn heading(output: &Output, case: &Case, quantity: &OfQuantity) -> String {
    if output.cases.len() == 1 {
        quantity.name.clone()
    } else {
        format!("{}, environment {}", quantity.name, case.environment)
    }
}

fn introduction(name: &str, output: &Output) -> Text {
    let solves: u64 = output.cases.iter().map(|case| case.solves).sum();
    let mut text = Text::new("Job ").code(name).plain(format!(
        ": {}, {}.",
        counted(output.parameters.len(), "uncertain parameter"),
        counted(solves, "solve")
    ));
    if output.methods.contains(&Method::Sobol) {
        text = text.plain(format!(
            " Shares of the variance by {} of {} each (Saltelli 2010 for main, Jansen 1999 for \
             total effects); 95 % intervals by Student's t from the scatter of the scrambles. A main effect is the share of \
             the variance that would go if the parameter were known, a total effect the share that would stay if all others were.",
            counted(output.scrambles, "independent scramble"),
            counted(output.samples, "base point")
        ));
    }
    text.plain(" The parameters are taken as independent.")
}

fn precision(output: &Output) -> Option<Block> {
    let precision = output.precision?;
    let (asked, widest) = (significant(precision.asked, 2), significant(precision.widest, 2));
    Some(if precision.is_reached {
        Block::paragraph(format!("The widest interval is {widest}, narrower than the {asked} asked for."))
    } else {
        let text =
            format!("The widest interval is {widest}: the {asked} asked for is not reached with these base points.");
        Block::callout(Tone::Warning, text)
    })
}

fn failures(case: &Case) -> Vec<Block> {
    if case.failed == 0 {
        return Vec::new();
    }
    let text = format!(
        "{} of {} failed in environment {}. {} of {} and {} are left out whole; the tables bound what that \
         could do to each index.",
        case.failed,
        counted(case.solves, "solve"),
        case.environment,
        case.rows_left_out,
        counted(case.rows, "row"),
        counted(case.trajectories_left_out, "trajectory")
    );
    let row = |failure: &crate::job::sensitivity::FailedSolve| {
        let parameters = failure.parameters.iter().map(|(name, value)| format!("{name} = {}", significant(*value, 5)));
        vec![
            failure.place.clone().into(),
            failure.reason.clone().into(),
            parameters.collect::<Vec<_>>().join(", ").into(),
        ]
    };
    vec![
        Block::callout(Tone::Warning, text),
        Block::Table(Table {
            caption: "The first failed solves, parameters in SI.".into(),
            columns: vec![Column::text("Where"), Column::text("Reason"), Column::text("Parameters")],
            rows: case.failures.iter().take(MOST_FAILURES).map(row).collect(),
        }),
    ]
}

fn of_quantity(job: &str, output: &Output, case: &Case, quantity: &OfQuantity, by_differences: bool) -> Vec<Block> {
    if quantity.is_constant {
        return vec![Block::paragraph(format!("{} does not vary with the uncertain parameters.", quantity.name))];
    }
    let order = order(output, quantity);
    let mut blocks = Vec::new();
    if let Some(sobol) = &quantity.sobol {
        blocks.push(Block::Paragraph(ranking(output, sobol, &order)));
        blocks.push(Block::Figure(shares(job, output, case, quantity, sobol, &order)));
    }
    blocks.extend(tornado(job, output, case, quantity, &order, by_differences).map(Block::Figure));
    blocks.extend(scatters(job, output, case, quantity).into_iter().map(Block::Figure));
    blocks.extend(table(output, quantity, &order));
    let derivatives = derivatives(output, quantity, &order, by_differences);
    let details = elementary(output, quantity, &order).into_iter().chain(derivatives);
    let details: Vec<Block> = details.chain(pairs(quantity)).collect();
    if !details.is_empty() {
        let what = match (quantity.morris.is_empty(), quantity.local.is_empty()) {
            (false, false) => "Elementary effects and derivatives",
            (false, true) => "Elementary effects",
            (true, _) => "Derivatives and pairs",
        };
        blocks.push(Block::Details(format!("{what}, {}", quantity.name), details));
    }
    blocks
}

/// `0.6761 (0.6759 to 0.6763)`.
pub(super) fn estimate_text(estimate: &Estimate) -> String {
    format!("{} ({} to {})", fixed(estimate.value, 4), fixed(estimate.lower, 4), fixed(estimate.upper, 4))
}

/// `2`, or `2 to 4` where the intervals do not tell.
fn place_text(place: Place) -> String {
    if place.best == place.worst { place.best.to_string() } else { format!("{} to {} (tie)", place.best, place.worst) }
}

/// What leads, what ties, and what is left for interactions.
fn ranking(output: &Output, sobol: &Sobol, order: &[usize]) -> Text {
    let name = |at: usize| output.parameters[at].name.as_str();
    let mut text = Text::default();
    let Some(&first) = order.first() else { return text };
    let total = |at: usize| percent(sobol.total[at].estimate.value, 1);
    let is_tied = sobol.places[first].worst > 1;
    text = if is_tied { text.plain("These points do not tell which parameter leads: ") } else { text };
    text = text.code(name(first)).plain(format!(
        " has {} of the variance in all{}",
        total(first),
        if is_tied { ", and others may have as much" } else { "" }
    ));
    let others: Vec<usize> = order[1..].iter().copied().take(2).collect();
    for (position, &at) in others.iter().enumerate() {
        let joint = if position + 1 == others.len() && others.len() > 1 { " and " } else { ", " };
        text = text.plain(joint).code(name(at)).plain(format!(" {}", total(at)));
    }
    text = text.plain(". ");
    // Parameters whose intervals hold 0 or lie below a thousandth matter little however they are ranked.
    let mut tied: Vec<&str> = Vec::new();
    for &at in order {
        let place = sobol.places[at];
        if place.best != place.worst && sobol.total[at].estimate.upper > 1e-3 {
            tied.push(name(at));
        }
    }
    if !tied.is_empty() {
        text = text.plain("Not told apart by their intervals from a neighbour: ");
        for (position, name) in tied.iter().enumerate() {
            text = text.plain(if position == 0 { "" } else { ", " }).code(*name);
        }
        text = text.plain(". ");
    }
    let alone = &sobol.sum_main;
    text.plain(format!(
        "One by one the parameters explain {} of the variance ({} to {}); the rest is interaction.",
        percent(alone.value, 1),
        percent(alone.lower, 1),
        percent(alone.upper, 1)
    ))
}

fn shares(job: &str, output: &Output, case: &Case, quantity: &OfQuantity, sobol: &Sobol, order: &[usize]) -> Figure {
    let mut bars = Vec::new();
    for &at in order.iter().take(MOST_BARS) {
        let name = &output.parameters[at].name;
        for (kind, index, colour) in
            [("total", &sobol.total[at], palette::BLUE), ("main", &sobol.main[at], palette::SKY)]
        {
            let estimate = &index.estimate;
            bars.push(Bar {
                label: format!("{name}, {kind}"),
                from: 0.0,
                value: estimate.value,
                interval: Some([estimate.lower, estimate.upper]),
                text: fixed(estimate.value, 3),
                colour,
            });
        }
    }
    let caption = format!(
        "Total and main effects on {} in environment {}, largest first, with 95 % intervals.",
        quantity.name, case.environment
    );
    Figure {
        id: format!("{job}-{}-{}-shares", case.environment, quantity.name),
        drawing: bar_chart(&Axis::new("share of the variance").up_to(1.0), &bars, None),
        alternative: format!("Bar chart. {caption}"),
        caption: caption.into(),
    }
}

/// What a standard deviation of each parameter does to the quantity about its nominal value.
fn tornado(
    job: &str,
    output: &Output,
    case: &Case,
    quantity: &OfQuantity,
    order: &[usize],
    by_differences: bool,
) -> Option<Figure> {
    let shown = Shown::quantity(&quantity.unit, quantity.is_temperature);
    let mut reach: Vec<(usize, f64)> =
        order.iter().filter_map(|&at| Some((at, quantity.local.get(at)?.scaled_by_sd?))).collect();
    if reach.is_empty() {
        return None;
    }
    sort_by(&mut reach, |a, b| b.1.abs().total_cmp(&a.1.abs()));
    let bars: Vec<Bar> = reach
        .iter()
        .take(MOST_BARS)
        .map(|&(at, reach)| Bar {
            label: output.parameters[at].name.clone(),
            from: shown.value(quantity.nominal - reach.abs()),
            value: shown.value(quantity.nominal + reach.abs()),
            interval: None,
            text: format!("{}{}", if reach > 0.0 { "+" } else { "" }, shown.difference().text(reach)),
            colour: if reach > 0.0 { palette::VERMILION } else { palette::BLUE },
        })
        .collect();
    let nominal = format!("nominal {}", shown.text(quantity.nominal));
    let caption = format!(
        "Tornado of {} in environment {}: nominal value plus and minus the {} times one prior standard deviation; the \
         number is the change for a larger parameter.",
        quantity.name,
        case.environment,
        if by_differences { "derivative by differences" } else { "exact derivative" }
    );
    Some(Figure {
        id: format!("{job}-{}-{}-tornado", case.environment, quantity.name),
        drawing: bar_chart(
            &Axis::new(shown.title(&quantity.name)),
            &bars,
            Some((shown.value(quantity.nominal), &nominal)),
        ),
        alternative: format!("Tornado chart. {caption}"),
        caption: caption.into(),
    })
}

/// The quantity against its leading parameters.
fn scatters(job: &str, output: &Output, case: &Case, quantity: &OfQuantity) -> Vec<Figure> {
    let Some(scatter) = &quantity.scatter else { return Vec::new() };
    let shown = Shown::quantity(&quantity.unit, quantity.is_temperature);
    let figure = |(&at, x): (&usize, &Vec<f64>)| {
        let parameter = &output.parameters[at];
        let along = Shown::parameter_of(&parameter.unit, parameter.size());
        let points = x.iter().zip(&scatter.y).map(|(&x, &y)| (along.value(x), shown.value(y))).collect();
        let chart = Chart {
            x: Axis::new(along.title(&parameter.name)),
            y: Axis::new(shown.title(&quantity.name)),
            layers: vec![Layer::Dots { points, colour: palette::BLUE, mark: Mark::Disc, label: String::new() }],
            height: 620,
            ..Chart::default()
        };
        let caption = format!(
            "{} against {} in environment {}: {} of the priors.",
            quantity.name,
            parameter.name,
            case.environment,
            counted(scatter.y.len(), "sample")
        );
        Figure {
            id: format!("{job}-{}-{}-{}", case.environment, quantity.name, parameter.name),
            drawing: chart.draw(),
            alternative: format!("Scatter plot. {caption}"),
            caption: caption.into(),
        }
    };
    scatter.parameters.iter().zip(&scatter.x).map(figure).collect()
}

fn table(output: &Output, quantity: &OfQuantity, order: &[usize]) -> Option<Block> {
    if quantity.sobol.is_none() && quantity.derivative.is_empty() {
        return None;
    }
    let mut columns = vec![Column::text("Parameter")];
    let sobol = quantity.sobol.as_ref();
    let has_bounds = sobol.is_some_and(|sobol| sobol.total.iter().any(|index| index.bounds.is_some()));
    if sobol.is_some() {
        columns.extend([
            Column::number("Place", ""),
            Column::number("Total effect", ""),
            Column::number("Main effect", ""),
        ]);
    }
    if has_bounds {
        columns.push(Column::number("Total effect, rows left out at worst", ""));
    }
    if !quantity.derivative.is_empty() {
        columns.push(Column::number("Total effect at most, by derivatives", ""));
    }
    let rows = order
        .iter()
        .map(|&at| {
            let mut row = vec![Cell::code(&output.parameters[at].name)];
            if let Some(sobol) = sobol {
                let place = sobol.places[at];
                let text = place_text(place);
                row.push(if place.best == place.worst { text.into() } else { Cell::marked(text, Status::Caution) });
                row.push(estimate_text(&sobol.total[at].estimate).into());
                row.push(estimate_text(&sobol.main[at].estimate).into());
                if has_bounds {
                    let bounds = sobol.total[at].bounds;
                    row.push(
                        bounds.map_or(NONE.to_owned(), |[a, b]| format!("{} to {}", fixed(a, 3), fixed(b, 3))).into(),
                    );
                }
            }
            if let Some(derivative) = quantity.derivative.get(at) {
                row.push(significant(derivative.bound.value, 3).into());
            }
            row
        })
        .collect();
    let caption = format!(
        "Effects on {}, with 95 % intervals. A tie: the intervals do not tell the parameter from a neighbour. The bound by \
         derivatives is that of Sobol and Kucherenko (2009).",
        quantity.name
    );
    Some(Block::Table(Table { caption: caption.into(), columns, rows }))
}

fn elementary(output: &Output, quantity: &OfQuantity, order: &[usize]) -> Option<Block> {
    if quantity.morris.is_empty() {
        return None;
    }
    let shown = Shown::quantity(&quantity.unit, quantity.is_temperature).difference();
    let rows = order.iter().filter_map(|&at| {
        let effect = quantity.morris.get(at)?;
        Some(vec![
            Cell::code(&output.parameters[at].name),
            number::with_error(effect.mu_star, effect.mu_star_standard_error).into(),
            shown.number(effect.sigma).into(),
        ])
    });
    let caption = format!(
        "Elementary effects on {}: changes over the whole prior (Morris 1991); their scatter tells of curvature and interaction.",
        quantity.name
    );
    Some(Block::Table(Table {
        caption: caption.into(),
        columns: vec![
            Column::text("Parameter"),
            Column::number("Mean size", shown.unit.clone()),
            Column::number("Scatter", shown.unit.clone()),
        ],
        rows: rows.collect(),
    }))
}

fn derivatives(output: &Output, quantity: &OfQuantity, order: &[usize], by_differences: bool) -> Option<Block> {
    if quantity.local.is_empty() {
        return None;
    }
    let quantity_shown = Shown::quantity(&quantity.unit, quantity.is_temperature).difference();
    let text = |value: Option<f64>| value.map_or(NONE.to_owned(), |value| significant(value, 4));
    let rows = order
        .iter()
        .map(|&at| {
            let (local, parameter): (_, &Parameter) = (&quantity.local[at], &output.parameters[at]);
            let unit = Shown::parameter_of(&parameter.unit, parameter.size()).difference();
            // A derivative by the unit in which the parameter is stated.
            let scale = unit.value(1.0);
            vec![
                Cell::code(&parameter.name),
                text(local.derivative.map(|d| d / scale)).into(),
                format!("{} / {}", quantity_shown.unit, if unit.unit.is_empty() { "1" } else { &unit.unit }).into(),
                text(local.scaled_by_value).into(),
                text(local.scaled_by_sd).into(),
            ]
        })
        .collect();
    Some(Block::Table(Table {
        caption: format!(
            "{} of {} at the nominal parameters: raw, times parameter by quantity (absolute temperatures in \
             K), times the prior's standard deviation.",
            if by_differences {
                "Derivatives by the model's steps, differences rather than exact,"
            } else {
                "Exact derivatives"
            },
            quantity.name
        )
        .into(),
        columns: vec![
            Column::text("Parameter"),
            Column::number("Derivative", ""),
            Column::text("Unit"),
            Column::number("Scaled by values", ""),
            Column::number("By standard deviation", quantity_shown.unit.clone()),
        ],
        rows,
    }))
}

fn pairs(quantity: &OfQuantity) -> Option<Block> {
    let sobol = quantity.sobol.as_ref().filter(|sobol| !sobol.second_order.is_empty())?;
    let mut pairs: Vec<_> = sobol.second_order.iter().collect();
    sort_by(&mut pairs, |a, b| b.estimate.value.total_cmp(&a.estimate.value));
    let rows = pairs
        .iter()
        .take(MOST_PAIRS)
        .map(|pair| {
            let [a, b] = &pair.parameters;
            vec![Cell::code(a), Cell::code(b), estimate_text(&pair.estimate).into()]
        })
        .collect();
    Some(Block::Table(Table {
        caption: format!("Effects of pairs on {} beyond the main effects of both, the largest.", quantity.name).into(),
        columns: vec![Column::text("Parameter"), Column::text("Parameter"), Column::number("Effect of the pair", "")],
        rows,
    }))
}
