//! What the calibrated model leaves unexplained: law, residuals with its band, checks, confounded parameters.

mod brief;
mod joint;

use crate::document::counted;
use crate::job::discrepancy::{Check, Curve, Kind, Law, Output, PhaseResidual, SensorDiscrepancy};
use crate::report::number::{self, NONE, Shown, fixed, percent, signed, significant};
use crate::report::page::{Block, Cell, Column, Figure, Section, Status, Table, Text, Tone};
use crate::report::plot::{Along, Axis, Chart, Layer, Limit, Mark, Stroke, palette};
use crate::report::view::PassReport;

use super::Entry;

/// Half of a 95 % interval, in standard deviations.
const HALF_WIDTH: f64 = 1.96;

/// The section, and its kind's results in brief.
pub(super) const SECTION: Entry = Entry::of_kind(build, &brief::Discrepancy);

/// The section on discrepancies; not without such a job.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    for (name, output) in report.outputs::<Kind>() {
        blocks.push(Block::Paragraph(opening(name, output)));
        if !output.converged {
            let text = "The chains behind the posterior or the hyperparameters did not converge: nothing here is to be trusted.";
            blocks.push(Block::callout(Tone::Warning, text));
        }
        blocks.extend(output.findings.iter().map(|finding| {
            let mut text = finding.replace('`', "");
            text.replace_range(..1, &text[..1].to_uppercase());
            Block::callout(Tone::Warning, format!("{text}."))
        }));
        blocks.push(laws(output));
        let findings = output.sensors.iter().flat_map(|own| {
            own.findings.iter().map(move |finding| Text::default().code(&own.sensor).plain(format!(": {finding}")))
        });
        let findings: Vec<Text> = findings.collect();
        if !findings.is_empty() {
            blocks.push(Block::List(findings));
        }
        blocks.extend(hyperparameters(output));
        blocks.extend(parameters(output));
        let mut folded = Vec::new();
        for own in &output.sensors {
            for (place, curve) in own.curves.iter().enumerate() {
                let figure = Block::Figure(figure(report, name, own, place, curve));
                if own.law == Law::GaussianProcess { blocks.push(figure) } else { folded.push(figure) }
            }
            if own.curves.is_empty() || own.law == Law::ResidualLaw {
                blocks.push(Block::Figure(histogram(name, own)));
            }
        }
        if !folded.is_empty() {
            blocks.push(Block::Details(format!("Residuals against inputs ({})", folded.len()), folded));
        }
        blocks.push(Block::Details("Scores of all laws".into(), vec![scores(output)]));
        blocks.push(Block::Details("What was tested".into(), vec![tested(report, output)]));
    }
    (!blocks.is_empty()).then(|| Section {
        id: "discrepancy",
        title: "What the model leaves unexplained".into(),
        blocks,
    })
}

fn opening(name: &str, output: &Output) -> Text {
    if let Some(joint) = &output.joint {
        return joint::opening(name, output, joint);
    }
    let inputs = if output.inputs.is_empty() { "no input".to_owned() } else { output.inputs.join(", ") };
    Text::new("Job ").code(name).plain(format!(
        ": residuals after the calibration {} (measured minus predicted at the posterior mean, and at {} of its posterior), and \
         for each sensor the simplest law that predicts readings left out about as well as the best: none, a constant, a \
         residual law (a constant and scatter), a Gaussian process over {inputs} (and scatter). The posterior stays as it is \
         (modular, Kennedy & O'Hagan 2001); a prediction takes for each draw of it the discrepancy that belongs to it.",
        output.source.replace('`', ""),
        counted(output.draws[0], "draw"),
    ))
}

fn check_text(check: &Check) -> String {
    if check.count == 0 {
        return NONE.to_owned();
    }
    format!("{} of {}", check.inside, check.count)
}

fn laws(output: &Output) -> Block {
    let rows = output.sensors.iter().map(|own| {
        let score = own.laws.iter().find(|score| score.law == own.law);
        let standing = |check: &Check| if check.count >= 5 && check.rms > 1.5 { Status::Caution } else { Status::Ok };
        vec![
            Cell::code(&own.sensor),
            own.law.words().into(),
            own.because.clone().into(),
            score.and_then(|score| score.score).map_or_else(|| NONE.to_owned(), |score| signed(score, 1)).into(),
            Cell::marked(check_text(&own.left_out), standing(&own.left_out)),
            fixed(own.left_out.rms, 2).into(),
            Cell::marked(check_text(&own.held_out), standing(&own.held_out)),
        ]
    });
    Block::Table(Table {
        caption: "Law of each sensor's discrepancy. The score is the sum of the log densities of readings left out in turn. \
                  Inside: readings within the 95 % interval that the others give (noise included); the root mean square of their \
                  errors in standard deviations is 1 with the right law."
            .into(),
        columns: vec![
            Column::text("Sensor"),
            Column::text("Law"),
            Column::text("Why"),
            Column::number("Score", ""),
            Column::number("Left out, inside", ""),
            Column::number("Root mean square", ""),
            Column::number("Held out, inside", ""),
        ],
        rows: rows.collect(),
    })
}

fn scores(output: &Output) -> Block {
    let number =
        |value: Option<f64>, decimals: usize| value.map_or_else(|| NONE.to_owned(), |value| signed(value, decimals));
    let mut rows = Vec::new();
    for own in &output.sensors {
        for score in &own.laws {
            rows.push(vec![
                Cell::code(&own.sensor),
                match &score.refused {
                    Some(reason) => format!("{}: {reason}", score.law.words()),
                    None => score.law.words().to_owned(),
                }
                .into(),
                number(score.score, 2).into(),
                number(score.score_se, 2).into(),
                number(score.behind, 2).into(),
                number(score.behind_se, 2).into(),
                number(score.held_out_score, 2).into(),
                number(score.log_marginal_likelihood, 2).into(),
            ]);
        }
    }
    Block::Table(Table {
        caption: "All laws: score by readings left out with its standard error, by how much it is behind the best law with the \
                  standard error of the paired differences, score of the readings held out, marginal likelihood (logarithms)."
            .into(),
        columns: vec![
            Column::text("Sensor"),
            Column::text("Law"),
            Column::number("Score", ""),
            Column::number("Standard error", ""),
            Column::number("Behind", ""),
            Column::number("Standard error", ""),
            Column::number("Held out", ""),
            Column::number("Marginal likelihood", ""),
        ],
        rows,
    })
}

fn hyperparameters(output: &Output) -> Option<Block> {
    let central = if output.joint.is_some() { "medians" } else { "those of the highest marginal likelihood" };
    let mut rows = Vec::new();
    for own in &output.sensors {
        for parameter in &own.hyperparameters {
            let interval = parameter
                .interval
                .map_or_else(|| NONE.to_owned(), |[a, b]| format!("{} to {}", significant(a, 3), significant(b, 3)));
            let note = if parameter.at_bound { "at a bound of the search" } else { "" };
            rows.push(vec![
                Cell::code(&own.sensor),
                parameter.name.clone().into(),
                significant(parameter.value, 3).into(),
                interval.into(),
                parameter.unit.clone().into(),
                note.into(),
            ]);
        }
    }
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: format!(
                "Hyperparameters: {central}, and 95 % intervals of their draws, over which predictions go; coefficients of the \
                 trend are means over the draws. Differences of temperatures are in K."
            )
            .into(),
            columns: vec![
                Column::text("Sensor"),
                Column::text("Hyperparameter"),
                Column::number(if output.joint.is_some() { "Median" } else { "Most probable" }, ""),
                Column::number("95 % interval", ""),
                Column::text("Unit"),
                Column::text("Note"),
            ],
            rows,
        })
    })
}

fn parameters(output: &Output) -> Option<Block> {
    if let Some(joint) = &output.joint {
        return joint::parameters(output, joint);
    }
    let rows: Vec<Vec<Cell>> = (output.parameters.iter())
        .map(|own| {
            let status = if own.is_confounded { Status::Caution } else { Status::Ok };
            vec![
                Cell::code(&own.name),
                percent(own.absorbed, 0).into(),
                fixed(own.free_sd / own.sd, 2).into(),
                signed(own.shift / own.sd, 2).into(),
                Cell::marked(if own.is_confounded { "confounded" } else { "told apart" }, status),
            ]
        })
        .collect();
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: "What would become of the calibrated unknowns if the Gaussian processes as fitted to all sensors were free \
                      beside them, to first order: share of what the readings say of each alone that the processes could say as \
                      well, ratio of the posterior standard deviations, shift of the mean in standard deviations."
                .into(),
            columns: vec![
                Column::text("Unknown"),
                Column::number("Could be absorbed", ""),
                Column::number("Width with it free", "times"),
                Column::number("Shift", "standard deviations"),
                Column::text("Outcome"),
            ],
            rows,
        })
    })
}

/// An input as people read it.
fn shown(report: &PassReport<'_>, input: &str, unit: &str) -> Shown {
    let own = report.model.inputs.iter().find(|own| own.name == input);
    own.map_or_else(|| Shown::si(unit), |own| Shown::written(&own.unit))
}

fn tested(report: &PassReport<'_>, output: &Output) -> Block {
    let rows = output.tested.iter().map(|range| {
        let shown = shown(report, &range.input, &range.unit);
        let is_used = output.inputs.contains(&range.input);
        let note = match (is_used, range.lower == range.upper) {
            (true, _) => "the discrepancy may depend on it",
            (false, true) => "the same in all phases: what it does to the discrepancy is not known",
            (false, false) => "not asked for",
        };
        vec![Cell::code(&range.input), shown.text(range.lower).into(), shown.text(range.upper).into(), note.into()]
    });
    Block::Table(Table {
        caption:
            "Range of every input over the phases behind the laws. A prediction outside it is an extrapolation, and is \
                  flagged as one."
                .into(),
        columns: vec![
            Column::text("Input"),
            Column::number("From", ""),
            Column::number("To", ""),
            Column::text("Note"),
        ],
        rows: rows.collect(),
    })
}

fn figure(report: &PassReport<'_>, job: &str, own: &SensorDiscrepancy, place: usize, curve: &Curve) -> Figure {
    let x = shown(report, &curve.input, &curve.unit);
    let band = (curve.at.iter().zip(&curve.lower).zip(&curve.upper))
        .map(|((at, lower), upper)| (x.value(*at), *lower, *upper));
    let line = curve.at.iter().zip(&curve.mean).map(|(at, mean)| (x.value(*at), *mean));
    let of = |held_out: bool| {
        let chosen = own.residuals.iter().filter(move |residual| residual.held_out == held_out);
        chosen.map(|residual| (x.value(residual.inputs[place]), residual.residual)).collect::<Vec<_>>()
    };
    let error = |residual: &PhaseResidual| {
        let (noise, calibration) = (residual.noise_sd, residual.calibration_sd);
        let sd = (noise * noise + calibration * calibration).sqrt();
        let (at, half) = (x.value(residual.inputs[place]), HALF_WIDTH * sd);
        (at, residual.residual - half, residual.residual + half)
    };
    let mut layers = vec![
        Layer::Band { points: band.collect(), colour: palette::BLUE, label: "95 % band, scatter included".into() },
        Layer::Line {
            points: line.collect(),
            colour: palette::BLUE,
            stroke: Stroke::Solid,
            label: own.law.words().into(),
        },
        Layer::Intervals { points: own.residuals.iter().map(error).collect(), colour: palette::MUTED },
        Layer::Dots { points: of(false), colour: palette::INK, mark: Mark::Disc, label: "residuals".into() },
    ];
    let held_out = of(true);
    if !held_out.is_empty() {
        layers.push(Layer::Dots { points: held_out, colour: palette::INK, mark: Mark::Ring, label: "held out".into() });
    }
    let chart = Chart {
        x: Axis::new(x.title(&curve.input)),
        y: Axis::new(format!("measured \u{2212} predicted [{}]", own.unit)),
        layers,
        limits: vec![Limit { along: Along::Y, value: 0.0, label: String::new(), colour: palette::MUTED }],
        height: 700,
        ..Chart::default()
    };
    let caption = format!(
        "Residuals of {} against {} with the 95 % interval of noise and calibration, and the discrepancy ({}) along it with the \
         other inputs in the middle of what was tested.",
        own.sensor,
        curve.input,
        own.law.words()
    );
    Figure {
        id: format!("{job}-{}-{}-residuals", own.sensor, curve.input),
        drawing: chart.draw(),
        alternative: caption.clone(),
        caption: caption.into(),
    }
}

/// Histogram of the residuals, as samples of a residual law.
fn histogram(job: &str, own: &SensorDiscrepancy) -> Figure {
    let values: Vec<f64> = own.residuals.iter().map(|residual| residual.residual).collect();
    let largest = values.iter().fold(f64::MIN_POSITIVE, |most, value| most.max(value.abs()));
    let bins = 13;
    let width = 2.0 * largest / bins as f64;
    let edges: Vec<f64> = (0..=bins).map(|i| -largest + width * i as f64).collect();
    let mut heights = vec![0.0; bins];
    for value in &values {
        heights[(((value + largest) / width) as usize).min(bins - 1)] += 1.0;
    }
    let chart = Chart {
        x: Axis::new(format!("measured \u{2212} predicted [{}]", own.unit)),
        y: Axis::new("phases"),
        layers: vec![Layer::Bars { edges, heights, colour: palette::BLUE, label: String::new() }],
        limits: vec![Limit { along: Along::X, value: 0.0, label: String::new(), colour: palette::INK }],
        height: 700,
        ..Chart::default()
    };
    let caption = format!("Residuals of {} over {}, noise included.", own.sensor, counted(values.len(), "phase"));
    Figure {
        id: format!("{job}-{}-histogram", own.sensor),
        drawing: chart.draw(),
        alternative: format!("Histogram. {caption}"),
        caption: caption.into(),
    }
}

/// A number with its unit, for other sections.
pub(super) fn amount(value: f64, unit: &str) -> String {
    format!("{} {unit}", number::signed(value, 2))
}
