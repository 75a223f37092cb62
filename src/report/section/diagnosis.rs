//! Diagnosis: what physics is missing, how surely, what it does to the error, what else it could be.

mod figures;

use crate::diagnosis::Verdict;
use crate::diagnosis::output::{EffectResult, Output, RmseChange};
use crate::report::number::{NONE, fixed, percent, significant, typeset};
use crate::report::page::{Block, Cell, Column, Section, Status, Table, Text, Tone};
use crate::report::view::PassReport;

/// Effects in the table.
const MOST_EFFECTS: usize = 15;
/// Effects with their detectable amplitudes in the table.
const MOST_DETECTABLE: usize = 12;

/// The section on diagnoses; not without one.
pub fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    let jobs = report.diagnoses().count();
    for (name, output) in report.diagnoses() {
        if jobs > 1 {
            blocks.push(Block::Heading(format!("Job {name}")));
        }
        let tone = if output.verdict == Verdict::Adequate { Tone::Note } else { Tone::Verdict };
        let verdict = Text::default().plain("Verdict: ").strong(output.verdict.word()).plain(".");
        blocks.push(Block::callout(tone, verdict));
        blocks.push(Block::List(output.words.iter().map(|word| Text::new(word.clone())).collect()));
        blocks.extend(output.warnings.iter().map(|warning| Block::callout(Tone::Warning, warning.clone())));
        blocks.push(effects(output));
        blocks.extend(figures::figures(name, output));
        blocks.extend(experiment(output));
        blocks.extend(tests(output));
        blocks.extend(noise(output));
        blocks.extend(detectable(output));
        blocks.extend(goes_with(output));
        blocks.push(Block::paragraph(method(output)));
    }
    (!blocks.is_empty()).then(|| Section { id: "diagnosis", title: "What is missing".into(), blocks })
}

fn change(values: [Option<f64>; 2]) -> String {
    match values {
        [Some(before), Some(after)] => format!("{} \u{2192} {}", fixed(before, 2), fixed(after, 2)),
        _ => NONE.to_owned(),
    }
}

fn amplitudes(effect: &EffectResult) -> String {
    let one = |(name, amount): (&String, &crate::diagnosis::output::Amount)| {
        let unit = typeset(&amount.unit);
        let spread =
            if amount.at_bound { "at a bound".to_owned() } else { format!("\u{00B1} {}", significant(amount.sd, 2)) };
        format!("{name} {} {spread} {unit}", significant(amount.value, 3))
    };
    let all: Vec<String> = effect.amplitudes.iter().take(2).map(one).collect();
    let more = effect.amplitudes.len().saturating_sub(2);
    if more > 0 { format!("{}; {more} more", all.join("; ")) } else { all.join("; ") }
}

fn effects(output: &Output) -> Block {
    let rows = output.effects.iter().take(MOST_EFFECTS).map(|effect| {
        let RmseChange { train, held_out } = effect.rmse_k;
        let is_selected = output.selected.contains(&effect.id);
        vec![
            Cell { text: Text::default().code(&effect.id), status: is_selected.then_some(Status::Ok) },
            percent(effect.probability, 1).into(),
            fixed(effect.log_bayes_factor, 1).into(),
            effect.group.map_or_else(|| NONE.to_owned(), |group| group.to_string()).into(),
            amplitudes(effect).into(),
            change(train).into(),
            change(held_out).into(),
        ]
    });
    Block::Table(Table {
        caption: "Effects that would explain the misfit, most probable first: the probability counts every set that an \
                  effect belongs to; amplitudes and errors are those of its best set, before and after it. Green: would be \
                  adopted. Effects of one group cannot be told apart with these data."
            .into(),
        columns: vec![
            Column::text("Effect"),
            Column::number("Probability", ""),
            Column::number("Log Bayes factor", ""),
            Column::number("Group", ""),
            Column::text("Size"),
            Column::number("RMSE, fitted rows", "K"),
            Column::number("RMSE, held out", "K"),
        ],
        rows: rows.collect(),
    })
}

fn experiment(output: &Output) -> Option<Block> {
    let experiment = output.separating_experiment.as_ref()?;
    let rows = experiment.conditions.iter().map(|(name, setting)| {
        let shown = crate::report::number::Shown::quantity(&setting.unit, setting.unit == "K");
        vec![Cell::code(name), shown.text(setting.value).into()]
    });
    let limits = if experiment.limits_ok { "" } else { " The red limits of a node are passed there." };
    Some(Block::Table(Table {
        caption: format!(
            "A phase that would tell {} apart, with probability {}; repeating the best old phase: {}.{limits}",
            experiment.between.join(" and "),
            percent(experiment.probability, 1),
            percent(experiment.repeat_probability, 1)
        )
        .into(),
        columns: vec![Column::text("Input"), Column::text("Set to")],
        rows: rows.collect(),
    }))
}

fn tests(output: &Output) -> Option<Block> {
    let rows: Vec<Vec<Cell>> = output
        .misfit
        .tests
        .iter()
        .map(|test| vec![test.name.clone().into(), Cell::code(&test.at), significant(test.p, 2).into()])
        .collect();
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: format!(
                "Tests of the tuned model as it was believed; together p = {}.",
                significant(output.misfit.family_wise_p, 2)
            )
            .into(),
            columns: vec![Column::text("Test"), Column::text("Worst at"), Column::number("p", "")],
            rows,
        })
    })
}

fn noise(output: &Output) -> Option<Block> {
    let estimated: Vec<_> = output.noise.iter().filter(|(_, noise)| noise.estimated).collect();
    let rows: Vec<Vec<Cell>> = estimated
        .into_iter()
        .map(|(sensor, noise)| {
            vec![
                Cell::code(sensor),
                significant(noise.sigma, 3).into(),
                noise.correlation_time_s.map_or_else(|| "white".to_owned(), |time| significant(time, 3)).into(),
                percent(noise.correlated_share, 0).into(),
            ]
        })
        .collect();
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: "Noise that was not wholly stated, as estimated from what the best pair of effects leaves.".into(),
            columns: vec![
                Column::text("Sensor"),
                Column::number("Standard deviation", "K"),
                Column::number("Correlation time", "s"),
                Column::number("Correlated share", ""),
            ],
            rows,
        })
    })
}

fn detectable(output: &Output) -> Option<Block> {
    if output.verdict != Verdict::Adequate || output.detectable.is_empty() {
        return None;
    }
    let rows = output.detectable.iter().take(MOST_DETECTABLE).map(|(id, amount)| {
        vec![Cell::code(id), format!("{} {}", significant(amount.value, 2), typeset(&amount.unit)).into()]
    });
    Some(Block::Table(Table {
        caption: "What would have shown in nine of ten cases: amplitudes above these.".into(),
        columns: vec![Column::text("Effect"), Column::text("Above")],
        rows: rows.collect(),
    }))
}

fn goes_with(output: &Output) -> Option<Block> {
    let rows: Vec<Vec<Cell>> = output
        .goes_with
        .iter()
        .map(|one| {
            vec![
                Cell::code(&one.node),
                Cell::code(&one.input),
                significant(one.slope, 3).into(),
                significant(one.p, 2).into(),
            ]
        })
        .collect();
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: "What the missing heat goes with: slope in W per SI unit of the input.".into(),
            columns: vec![
                Column::text("Node"),
                Column::text("Input"),
                Column::number("Slope", ""),
                Column::number("p", ""),
            ],
            rows,
        })
    })
}

fn method(output: &Output) -> String {
    let [effects, pairs, sets] = output.looked_at;
    let mut text = format!(
        "{effects} effects at their places and {pairs} pairs were screened, {sets} sets fitted; probability that nothing is \
         missing {}, that something is missing which no set explains {}. {} effects cannot be seen with these data.",
        percent(output.probability_nothing, 1),
        percent(output.probability_unexplained, 1),
        output.unseen.len()
    );
    if let Some(p) = output.remaining_p {
        text.push_str(&format!(" What the selected set leaves: p = {}.", significant(p, 2)));
    }
    if let Some(test) = &output.held_out_test {
        text.push_str(&format!(
            " Held-out rows, in {} blocks: squared error falls by {} \u{00B1} {} a block in units of the noise.",
            test.blocks,
            significant(test.gain, 3),
            significant(test.se, 2)
        ));
    }
    text
}
