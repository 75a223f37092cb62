//! The ladder of the model's states: as delivered, tuned, tuned with effects, each with its error, the criteria that it
//! keeps and its worst sensor.

use crate::diagnosis::output::Output as Diagnosis;
use crate::job::{compare, diagnose};
use crate::report::history::PassErrors;
use crate::report::ladder::{Standing, standings, unit};
use crate::report::number::{NONE, Shown, fixed, signed, typeset};
use crate::report::page::{Cell, Column, Status, Table, Text};
use crate::report::section::validation::tuned_in;
use crate::report::view::PassReport;

/// Passes before this one that stand in the ladder, the first and the last of them.
const MOST_BEFORE: usize = 5;

/// A state and what is said of it.
#[derive(Default)]
pub struct Rung {
    /// Its name.
    pub state: Text,
    /// What its errors are.
    pub standing: Standing,
    /// Error on rows that its fit did not see, but by which its effects were chosen.
    pub unseen: Option<f64>,
}

/// The ladder and what must be said to it; none where nothing was measured.
pub(super) fn table(report: &PassReport<'_>) -> Option<(Table, Text)> {
    let mut outputs = report.outputs::<compare::Kind>().filter(|(_, output)| !output.rows.is_empty()).peekable();
    let unit = unit(outputs.peek()?.1).to_owned();
    let has_several = report.outputs::<compare::Kind>().count() > 1;
    let mut rungs = before(report);
    let mut noise: Option<[f64; 2]> = None;
    for (name, output) in outputs.filter(|(_, output)| self::unit(output) == unit) {
        for (position, standing) in standings(output).into_iter().enumerate() {
            // As delivered, several comparisons of the same readings and the pass before say the same.
            if position == 0 && (is_half_way(output, report) || rungs.iter().any(|rung| rung.standing == standing)) {
                continue;
            }
            let state = state(report, position > 0, rungs.is_empty());
            let state = if has_several { state.plain(" (").code(name).plain(")") } else { state };
            rungs.push(Rung { state, standing, unseen: None });
        }
        for sigma in output.sensors.iter().filter(|sensor| sensor.unit == unit).filter_map(|sensor| sensor.sigma) {
            let [low, high] = noise.unwrap_or([sigma; 2]);
            noise = Some([low.min(sigma), high.max(sigma)]);
        }
    }
    let is_tuned = report.outputs::<compare::Kind>().any(|(_, output)| output.tuned.is_some());
    if let Some((_, output)) = report.outputs::<diagnose::Kind>().next() {
        rungs.extend(proposed(report, output, is_tuned));
    }
    Some(laid_out(&rungs, &unit, noise))
}

/// Whether the first state of a comparison is none that anybody uses: effects at nominal size, beside the tuned one, or untuned
/// where predictions rest on the tuned state of an earlier pass.
fn is_half_way(output: &compare::Output, report: &PassReport<'_>) -> bool {
    !report.adopted.is_empty() && output.tuned.is_some() || tuned_in(report).is_some()
}

/// What a state is called.
fn state(report: &PassReport<'_>, is_tuned: bool, is_first: bool) -> Text {
    let ids: Vec<&str> = report.adopted.iter().map(|effect| effect.id.as_str()).collect();
    match (is_tuned, ids.is_empty(), is_first) {
        (false, true, true) => "As delivered".into(),
        (false, true, false) => "As delivered, parameters of this pass".into(),
        (false, false, _) => "Untuned, with the adopted effects at nominal size".into(),
        (true, true, _) => "Tuned".into(),
        (true, false, _) => with(Text::new("Tuned with "), &ids),
    }
}

fn with(mut text: Text, ids: &[&str]) -> Text {
    for (position, id) in ids.iter().enumerate() {
        text = text.plain(if position == 0 { "" } else { ", " }).code(*id);
    }
    text
}

/// The states of the passes before this one whose errors are of the same readings: others say nothing of progress.
fn before(report: &PassReport<'_>) -> Vec<Rung> {
    let Some(history) = &report.history else { return Vec::new() };
    let Some(own) = history.passes.iter().find(|pass| pass.pass == report.pass_file) else { return Vec::new() };
    let mut chain: Vec<&PassErrors> = Vec::new();
    let mut at = own;
    while let Some(earlier) = history.before(at) {
        if !earlier.has_readings_of(own) || chain.iter().any(|pass| pass.pass == earlier.pass) {
            break;
        }
        chain.push(earlier);
        at = earlier;
    }
    chain.reverse();
    if chain.len() > MOST_BEFORE {
        chain.drain(1..chain.len() + 1 - MOST_BEFORE);
    }
    let mut rungs: Vec<Rung> = Vec::new();
    for pass in chain {
        for (position, standing) in pass.standings.iter().enumerate() {
            let is_half_way = !pass.adopted.is_empty() && pass.standings.len() > 1;
            if position == 0 && (is_half_way || rungs.iter().any(|rung| rung.standing == *standing)) {
                continue;
            }
            let ids: Vec<&str> = pass.adopted.iter().map(String::as_str).collect();
            let state = match (position, ids.is_empty()) {
                (0, true) => "As delivered".into(),
                (0, false) => "Untuned, with its effects at nominal size".into(),
                (_, true) => "Tuned".into(),
                (_, false) => with(Text::new("Tuned with "), &ids),
            };
            let state = state.plain(", ").code(&pass.pass);
            rungs.push(Rung { state, standing: standing.clone(), unseen: None });
        }
        if pass.is_tuned_by_diagnosis {
            let ids: Vec<&str> = pass.adopted.iter().map(String::as_str).collect();
            let state = if ids.is_empty() { "Tuned".into() } else { with(Text::new("Tuned with "), &ids) };
            let tuned = pass.rmse_k.tuned;
            rungs.push(Rung {
                state: state.plain(", by the diagnosis, ").code(&pass.pass),
                standing: Standing { fitted: tuned.train, held_out: tuned.held_out, ..Standing::default() },
                unseen: None,
            });
        }
    }
    rungs
}

/// The fits of a diagnosis: tuned, where no comparison has that state, and with the effects that it selects.
fn proposed(report: &PassReport<'_>, output: &Diagnosis, is_tuned: bool) -> Vec<Rung> {
    let mut rungs = Vec::new();
    let rung = |state: Text, train: Option<f64>, held_out: Option<f64>| {
        (train.is_some() || held_out.is_some()).then(|| Rung {
            state,
            standing: Standing { fitted: train, held_out, ..Standing::default() },
            unseen: None,
        })
    };
    if !is_tuned {
        let errors = output.misfit.rmse_k;
        let state = state(report, true, false).plain(", by the diagnosis");
        rungs.extend(rung(state, errors.train, errors.held_out));
    }
    let ids: Vec<&str> = output.selected.iter().map(String::as_str).collect();
    let is_selected = |set: &[String]| set.len() == ids.len() && set.iter().all(|id| output.selected.contains(id));
    if let Some(model) = output.models.iter().find(|model| !ids.is_empty() && is_selected(&model.effects)) {
        let state = proposal(report, &ids);
        let own = rung(state, model.rmse_k.train, model.rmse_k.held_out);
        // Step by step, rows that no fit saw judge each effect: for what came about so they are not held out any more.
        let is_chosen_by_them = !output.steps.is_empty();
        rungs.extend(own.map(|mut own| {
            own.unseen = own.standing.held_out.take_if(|_| is_chosen_by_them);
            own
        }));
    }
    rungs
}

/// What the state with proposed effects is called: beside those that are adopted, of which one may come a second time.
fn proposal(report: &PassReport<'_>, ids: &[&str]) -> Text {
    if report.adopted.is_empty() {
        return with(Text::new("Tuned with proposed "), ids);
    }
    let mut text = Text::new("Tuned, in addition with proposed ");
    for (position, id) in ids.iter().enumerate() {
        let is_second = report.adopted.iter().any(|effect| effect.id == *id);
        text =
            text.plain(if position == 0 { "" } else { ", " }).plain(if is_second { "second " } else { "" }).code(*id);
    }
    text
}

/// The rungs as a table, and what must be said to it; a column of which no rung knows anything is left out.
pub fn laid_out(rungs: &[Rung], unit: &str, noise: Option<[f64; 2]>) -> (Table, Text) {
    let digits = if unit == "K" { 2 } else { 4 };
    let number = |value: Option<f64>| value.map_or_else(|| NONE.to_owned(), |value| fixed(value, digits));
    let has = |known: fn(&Standing) -> bool| rungs.iter().any(|rung| known(&rung.standing));
    let has_fitted = has(|standing| standing.fitted.is_some());
    let has_held_out = has(|standing| standing.held_out.is_some());
    let has_unseen = rungs.iter().any(|rung| rung.unseen.is_some());
    let has_criteria = has(|standing| standing.kept.is_some());
    let shown = typeset(unit);
    let mut columns = vec![Column::text("State of the model")];
    if has_fitted {
        columns.push(Column::number("Fitted", shown.clone()));
    }
    if has_unseen {
        columns.push(Column::number("Unseen", shown.clone()));
    }
    if has_held_out {
        columns.push(Column::number("Held out", shown.clone()));
    }
    if has_criteria {
        columns.push(Column::text("Criteria"));
    }
    columns.extend([
        Column::text("Worst sensor"),
        Column::number("Mean", shown.clone()),
        Column::number("Largest", shown.clone()),
    ]);
    let rows = (rungs.iter())
        .map(|Rung { state, standing, unseen }| {
            let mut row = vec![Cell::from(state.clone())];
            if has_fitted {
                row.push(number(standing.fitted).into());
            }
            if has_unseen {
                row.push(number(*unseen).into());
            }
            if has_held_out {
                row.push(number(standing.held_out).into());
            }
            if has_criteria {
                row.push(standing.kept.map_or_else(
                    || Cell::from(NONE),
                    |[kept, of]| Cell::marked(format!("{kept} of {of}"), Status::kept(kept == of)),
                ));
            }
            match &standing.worst {
                Some(worst) => row.extend([
                    Cell::code(&worst.name),
                    signed(worst.mean, digits).into(),
                    fixed(worst.largest, digits).into(),
                ]),
                None => row.extend([NONE, NONE, NONE].map(Cell::from)),
            }
            row
        })
        .collect();
    let shown = Shown::si(unit);
    let noise = noise.map_or_else(String::new, |[low, high]| {
        let range =
            if low == high { shown.text(low) } else { format!("{} to {}", shown.number(low), shown.text(high)) };
        format!("; the sensors' noise is {range}")
    });
    let caption =
        format!("States of the model on the same readings: root mean square of measured minus predicted{noise}.");
    (Table { caption: caption.into(), columns, rows }, notes(rungs, has_held_out, has_unseen).into())
}

/// What readings the errors are of, and why some places are empty.
fn notes(rungs: &[Rung], has_held_out: bool, has_unseen: bool) -> String {
    let readings = match (has_held_out, has_unseen) {
        (false, false) => "No reading is held out: every error is of readings that tuning may use.",
        (_, true) => {
            "Unseen: readings that no fit saw, but by which the diagnosis chose the effects, so that they judge its choice too \
             well; held out: readings that had no part in either. Only the diagnosis chooses by such readings; other states \
             have no such error."
        }
        (true, false) => "Held out: readings that no fit and no choice of effects of this pass used.",
    };
    let judged = |of: fn(&Standing) -> bool| {
        rungs.iter().any(|rung| of(&rung.standing)) && rungs.iter().any(|rung| !of(&rung.standing))
    };
    let is_undecided = judged(|standing| standing.kept.is_some()) || judged(|standing| standing.worst.is_some());
    let undecided = if is_undecided {
        format!(" {NONE}: known once the effect is adopted and the pass is run.")
    } else {
        String::new()
    };
    format!("{readings}{undecided}")
}
