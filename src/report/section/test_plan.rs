//! The plan of a test: objectives, phases, predictions, limits, instruments, durations, data sheet.

mod brief;

use crate::document::time::unit_of_time;
use crate::job::test_plan::{Kind, Limited, Output, PlannedPhase, Probability};
use crate::report::number::{self, NONE, Shown, probability, significant, with_error};
use crate::report::page::{Block, Cell, Column, Section, Status, Table, Text, Tone};
use crate::report::view::PassReport;

use super::Entry;

/// Probability outside limits from which on a phase is worth a look.
const CAUTION: f64 = 0.01;
/// The same from which on it should not be run as planned.
const REFUSED: f64 = 0.05;
/// An hour, s.
const HOUR_S: f64 = 3600.0;

/// The section, and its kind's results in brief.
pub(super) const SECTION: Entry = Entry::of_kind(build, &brief::TestPlan);

/// The section on test plans; not without one.
pub(super) fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    let jobs = report.outputs::<Kind>().count();
    for (name, output) in report.outputs::<Kind>() {
        if jobs > 1 {
            blocks.push(Block::Heading(format!("Job {name}")));
        }
        blocks.push(Block::Paragraph(opening(name, output)));
        blocks.extend(output.findings.iter().map(|finding| Block::callout(Tone::Warning, format!("{finding}."))));
        blocks.push(Block::Heading("Objectives".into()));
        blocks.push(Block::List(objectives(output)));
        blocks.push(Block::Heading("Success criteria".into()));
        blocks.push(Block::List(success(output)));
        blocks.push(Block::Heading("Phases".into()));
        blocks.push(phases(output));
        blocks.push(Block::Heading("Predicted readings".into()));
        blocks.push(predictions(output));
        blocks.extend(limits(output));
        blocks.push(Block::Heading("Instrumentation and data sheet".into()));
        blocks.push(instruments(output));
        blocks.push(sheet(output));
        blocks.push(Block::Paragraph(
            Text::new("The sheet as a file, and the measurement that reads it: ")
                .code(format!("bmv test-plan {} --sheet FILE", report.pass_file))
                .plain("."),
        ));
    }
    (!blocks.is_empty()).then(|| Section { id: "test-plan", title: "Test plan".into(), blocks })
}

/// A time as people state it.
pub(super) fn time(seconds: f64) -> String {
    if seconds == 0.0 {
        return "0\u{A0}h".to_owned();
    }
    let (length, unit) = unit_of_time(seconds);
    number::with_unit(&significant(seconds / length, if unit == "min" { 2 } else { 3 }), unit)
}

fn time_or_none(seconds: Option<f64>) -> String {
    seconds.map_or_else(|| NONE.to_owned(), time)
}

fn opening(name: &str, output: &Output) -> Text {
    Text::new("Job ")
        .code(name)
        .plain(": the phases that ")
        .code(&output.design)
        .plain(format!(
            " chose, in its order: each adds the most to those before it, so that a test that ends early has lost the least. \
             Bands and probabilities are over the priors of all parameters ({} samples), durations over {} of them. A phase begins in \
             the steady state of the one before; its set points are reached at once, so that the time which the facility needs \
             for that comes on top.",
            output.samples[0], output.samples[1]
        ))
}

fn objectives(output: &Output) -> Vec<Text> {
    let mut learnt = Text::new("Learn ");
    for (place, name) in output.learn.iter().enumerate() {
        let before = if place == 0 {
            ""
        } else if place + 1 == output.learn.len() {
            " and "
        } else {
            ", "
        };
        learnt = learnt.plain(before).code(name);
    }
    if let Some(last) = output.phases.last() {
        let value = with_error(last.information_nats, last.information_se);
        learnt = learnt.plain(format!(": {value} nats of information expected from all phases."));
    }
    std::iter::once(learnt).chain(output.objectives.iter().map(|text| Text::new(text.clone()))).collect()
}

fn success(output: &Output) -> Vec<Text> {
    let rate = significant(output.rate_k_per_s * HOUR_S, 2);
    let mut criteria = vec![
        Text::new(format!(
            "Each phase is steady before it is read: all temperatures change by less than {rate}\u{A0}K/h (criteria {}); its readings are the \
             means over {} from then on.",
            output.criteria.name,
            time(output.hold_s)
        )),
        Text::new("No red limit is left. A yellow limit that is left stops the phase until someone has decided."),
        Text::new(
            "Every sensor of the data sheet has a reading in every phase, and the set points as they were are written down.",
        ),
    ];
    criteria.extend(output.success.iter().map(|text| Text::new(text.clone())));
    criteria
}

fn phases(output: &Output) -> Block {
    let varied: Vec<usize> = (0..output.inputs.len()).filter(|&index| output.inputs[index].varies).collect();
    let shown = |index: usize| Shown::written(&output.inputs[index].unit);
    let value = |index: usize, si: f64| number::as_given(shown(index).value(si));
    let mut columns = vec![Column::text("Phase")];
    columns.extend(varied.iter().map(|&index| Column::number(output.inputs[index].name.clone(), shown(index).unit)));
    columns.extend([
        Column::number("Information so far", "nats"),
        Column::number("Steady after, nominal", ""),
        Column::number("5 to 95 % of the samples", ""),
        Column::number("Time constant", ""),
        Column::number("Ends after, nominal", ""),
    ]);
    let mut rows = Vec::new();
    let mut before = vec![Cell::from("before")];
    before.extend(varied.iter().map(|&index| value(index, output.inputs[index].start).into()));
    before.extend(std::iter::repeat_n(Cell::from(NONE), 5));
    rows.push(before);
    let mut end_s = Some(0.0);
    for phase in &output.phases {
        let settling = &phase.settling;
        end_s = end_s.zip(settling.nominal_s).map(|(end, own)| end + own + output.hold_s);
        let mut row = vec![Cell::code(&phase.name)];
        row.extend(varied.iter().map(|&index| value(index, phase.set_points[index]).into()));
        let [early, _, late] = settling.quantiles_s.map(time_or_none);
        row.extend([
            with_error(phase.information_nats, phase.information_se).into(),
            Cell::from(time_or_none(settling.nominal_s)),
            format!("{early} to {late}").into(),
            time_or_none(settling.time_constant_s).into(),
            time_or_none(end_s).into(),
        ]);
        rows.push(row);
    }
    let constant: Vec<String> = (0..output.inputs.len())
        .filter(|index| !varied.contains(index))
        .filter_map(|index| {
            let set = *output.phases.first()?.set_points.get(index)?;
            let text = number::with_unit(&value(index, set), &shown(index).unit);
            Some(format!("{} = {text}", output.inputs[index].name))
        })
        .collect();
    let constant =
        if constant.is_empty() { String::new() } else { format!(" In all phases: {}.", constant.join(", ")) };
    let [nominal, early, _, late] = output.duration_s.map(time_or_none);
    Block::Table(Table {
        caption: format!(
            "Phases in order with their set points.{constant} A phase ends {} after it is steady. All phases take {nominal} at the \
             nominal parameters, {early} to {late} in 5 to 95 % of the samples. Times are known to a twentieth.",
            time(output.hold_s)
        )
        .into(),
        columns,
        rows,
    })
}

fn predictions(output: &Output) -> Block {
    let rows = output.phases.iter().flat_map(|phase| {
        output.sensors.iter().zip(&phase.sensors).map(|(sensor, predicted)| {
            let shown = Shown::quantity(&sensor.unit, sensor.is_temperature);
            let [low, high] = predicted.band.map(|end| shown.number(end));
            vec![
                Cell::code(&phase.name),
                Cell::code(&sensor.name),
                shown.number(predicted.nominal).into(),
                shown.number(predicted.mean).into(),
                format!("{low} to {high}").into(),
                shown.unit.clone().into(),
            ]
        })
    });
    Block::Table(Table {
        caption: "What the sensors will read: at the nominal parameters, on average over the priors, and the 95 % band; their own \
                  errors come on top (see the instrumentation)."
            .into(),
        columns: vec![
            Column::text("Phase"),
            Column::text("Sensor"),
            Column::number("Nominal", ""),
            Column::number("Mean", ""),
            Column::number("95 % band", ""),
            Column::text("Unit"),
        ],
        rows: rows.collect(),
    })
}

fn limits(output: &Output) -> Vec<Block> {
    let range = |range: Option<[f64; 2]>| {
        range.map_or_else(|| NONE.to_owned(), |ends| ends.map(|end| Shown::celsius().number(end)).join(" to "))
    };
    let outside = |outside: Option<Probability>| match outside {
        None => Cell::from(NONE),
        Some(own) => {
            let status = match own.value {
                value if value > REFUSED => Status::Fail,
                value if value > CAUTION => Status::Caution,
                _ => Status::Ok,
            };
            let text =
                if own.value == 0.0 { format!("0 (below {})", probability(own.upper)) } else { probability(own.value) };
            Cell::marked(text, status)
        }
    };
    let row = |phase: &PlannedPhase, own: &Limited| {
        vec![
            Cell::code(&phase.name),
            Cell::code(&own.node),
            range(Some(own.predicted.band)).into(),
            range(own.yellow).into(),
            range(own.red).into(),
            outside(own.outside_yellow),
            outside(own.outside_red),
        ]
    };
    let rows: Vec<Vec<Cell>> =
        output.phases.iter().flat_map(|phase| phase.limits.iter().map(move |own| row(phase, own))).collect();
    if rows.is_empty() {
        return vec![Block::callout(
            Tone::Note,
            "No node of the model has limits (`limits` with `yellow` and `red`), so that nothing is said of what the phases endanger.",
        )];
    }
    let failed: u64 = output.phases.iter().map(|phase| phase.failed).sum();
    let mut caption =
        "Limits: 95 % band of each node that has some, and the probability with which it lies outside.".to_owned();
    if failed > 0 {
        caption.push_str(&format!(" {failed} samples had no solution and count as outside."));
    }
    vec![
        Block::Heading("Limits".into()),
        Block::Table(Table {
            caption: caption.into(),
            columns: vec![
                Column::text("Phase"),
                Column::text("Node"),
                Column::number("95 % band", "\u{B0}C"),
                Column::number("Yellow", "\u{B0}C"),
                Column::number("Red", "\u{B0}C"),
                Column::number("Outside yellow", ""),
                Column::number("Outside red", ""),
            ],
            rows,
        }),
    ]
}

fn instruments(output: &Output) -> Block {
    let rows = output.sensors.iter().map(|sensor| {
        let spread = |value: f64| number::with_unit(&significant(value, 3), &number::typeset(&sensor.unit));
        vec![
            Cell::code(&sensor.name),
            Cell::code(&sensor.quantity),
            spread(sensor.sigma).into(),
            sensor.bias_sd.map_or_else(|| NONE.to_owned(), spread).into(),
        ]
    });
    Block::Table(Table {
        caption: "Sensors with the standard deviations of their noise and of a constant error that nobody knows."
            .into(),
        columns: vec![
            Column::text("Sensor"),
            Column::text("Measures"),
            Column::number("Noise", ""),
            Column::number("Constant error", ""),
        ],
        rows: rows.collect(),
    })
}

/// The sheet, to be filled in.
fn sheet(output: &Output) -> Block {
    let mut columns = vec![Column::text("Phase")];
    columns
        .extend(output.inputs.iter().map(|input| Column::number(input.name.clone(), Shown::written(&input.unit).unit)));
    columns.extend(
        output.sensors.iter().map(|sensor| {
            Column::number(sensor.name.clone(), Shown::quantity(&sensor.unit, sensor.is_temperature).unit)
        }),
    );
    let row = |phase: &PlannedPhase| {
        let mut row = vec![Cell::code(&phase.name)];
        let set = output.inputs.iter().zip(&phase.set_points);
        row.extend(set.map(|(input, si)| Cell::from(number::as_given(Shown::written(&input.unit).value(*si)))));
        row.extend(std::iter::repeat_n(Cell::from(""), output.sensors.len()));
        row
    };
    let rows = output.phases.iter().map(row).collect();
    Block::Table(Table {
        caption: "Data sheet: set points as planned, readings to be written down.".into(),
        columns,
        rows,
    })
}
