//! The error of the study's passes: what each added and what became of the error, on held-out readings above all.

use crate::report::history::{History, PassErrors, Split, States};
use crate::report::number::{NONE, fixed, percent, signed};
use crate::report::page::{Block, Cell, Column, Figure, Section, Status, Table, Text, Tone};
use crate::report::plot::{PassCurves, pass_curves};
use crate::report::view::PassReport;
use crate::study::job::CALIBRATION;

use super::Entry;

/// The section.
pub(super) const SECTION: Entry = Entry::plain(build);

/// The section on the passes; not where fewer than two of them have measurements.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let history = report.history.as_ref()?;
    if history.measured().len() < 2 { None } else { section(history) }
}

/// The section, also for a single pass; not where nothing was measured.
pub fn section(history: &History) -> Option<Section> {
    let measured = history.measured();
    let first = *measured.first()?;
    let mut words = "Root mean square of measured minus predicted over all sensors in kelvin. As delivered: nominal parameters; tuned: the \
                     most probable parameters of the pass's calibration, which saw the readings for fitting alone."
        .to_owned();
    if measured.iter().any(|pass| pass.is_tuned_by_diagnosis) {
        words.push_str(" A pass without a calibration is tuned by its diagnosis.");
    }
    let mut blocks = vec![Block::paragraph(words)];
    blocks.push(Block::List(measured.iter().map(|pass| in_words(history, pass)).collect()));
    blocks.push(Block::Table(table(&measured)));
    let missing: Vec<Text> = history.passes.iter().flat_map(missing_jobs).collect();
    if !missing.is_empty() {
        blocks.push(Block::List(missing));
    }
    let unmeasured: Vec<&PassErrors> = history.passes.iter().filter(|pass| !pass.is_measured()).collect();
    if !unmeasured.is_empty() {
        let mut text = Text::new("Without a comparison in kelvin: ");
        for (position, pass) in unmeasured.iter().enumerate() {
            text = text.plain(if position == 0 { "" } else { ", " }).code(&pass.pass);
        }
        blocks.push(Block::Paragraph(text.plain(".")));
    }
    for pass in measured.iter().filter(|pass| pass.converged == Some(false)) {
        let remedy = pass.remedy.as_ref().map_or_else(String::new, |remedy| format!(" What mends it: {remedy}."));
        let text = Text::new("The calibration of ").code(&pass.pass).plain(format!(
            " did not converge: the tuned state is a point at which the model was run, the evidence is not to be trusted.{remedy}"
        ));
        blocks.push(Block::callout(Tone::Warning, text));
    }
    let doubtful: Vec<&str> = measured.iter().filter(|pass| is_doubtful(pass)).map(|pass| pass.pass.as_str()).collect();
    if !doubtful.is_empty() {
        let text = Text::new(format!(
            "The evidence of {} is marked: its importance weights have a Pareto k above 0.7, so that it is not to be trusted. In the \
             settings of the calibration ",
            doubtful.join(", ")
        ));
        let remedy = r#""sampler": "smc""#;
        blocks.push(Block::callout(Tone::Warning, text.code(remedy).plain(" gives it without such weights.")));
    }
    if measured.len() > 1 {
        blocks.push(Block::Figure(figure(history, &measured, first)));
    }
    Some(Section { id: "history", title: "Error by pass".into(), blocks })
}

/// Whether a pass has an evidence that is not to be trusted.
fn is_doubtful(pass: &PassErrors) -> bool {
    pass.log_evidence_is_trusted == Some(false)
}

/// The logarithm of a pass's evidence to so many decimals, marked where it is not to be trusted.
pub(super) fn evidence(pass: &PassErrors, decimals: usize) -> Cell {
    let text = pass.log_evidence.map_or_else(|| NONE.to_owned(), |value| fixed(value, decimals));
    let is_marked = is_doubtful(pass) || pass.converged == Some(false);
    Cell { text: text.into(), status: is_marked.then_some(Status::Fail) }
}

/// Which jobs a pass lacks, what is not known without them, and what to write.
pub fn missing_jobs(pass: &PassErrors) -> Vec<Text> {
    let words = |kind: &String| {
        let (unknown, example) = if kind == CALIBRATION {
            ("its tuned error and its evidence are not known", r#""tuned": {"calibrate": {}}"#)
        } else {
            ("its error is not known", r#""delivered": {"compare": {}}"#)
        };
        Text::default()
            .code(&pass.pass)
            .plain(format!(" has no job of kind {kind}, so that {unknown}; add to its jobs "))
            .code(example)
            .plain(".")
    };
    pass.missing.iter().map(words).collect()
}

fn kelvin(value: f64) -> String {
    format!("{}\u{A0}K", fixed(value, 2))
}

/// `RMSE held-out 3.70 K → 1.90 K, for fitting 2.10 K → 1.10 K`; as far as both are known.
fn change(before: &Split, after: &Split) -> Option<String> {
    let pairs = [("held-out", before.held_out, after.held_out), ("for fitting", before.train, after.train)];
    let changes: Vec<String> = pairs
        .iter()
        .filter_map(|(what, before, after)| {
            Some(format!("{what} {} \u{2192} {}", kelvin((*before)?), kelvin((*after)?)))
        })
        .collect();
    (!changes.is_empty()).then(|| format!("RMSE {}", changes.join(", ")))
}

/// Whether the error fell, on held-out readings where there are any.
fn fell(before: &Split, after: &Split) -> Option<bool> {
    let of = |split: &Split| split.held_out.or(split.train);
    Some(of(after)? < of(before)?)
}

/// What a pass is and what became of the error, in a sentence.
fn in_words(history: &History, pass: &PassErrors) -> Text {
    let mut text = Text::default().code(&pass.pass);
    let Some(before) = history.before(pass) else {
        return match change(&pass.rmse_k.delivered, &pass.rmse_k.tuned) {
            Some(change) => {
                let by = if pass.is_tuned_by_diagnosis { " (by the diagnosis)" } else { "" };
                let states = format!(" {} \u{2192} {}{by}", pass.untuned_in_words(), tuned_from_there(pass));
                text.plain(format!("{states}: {change}."))
            }
            None => {
                let of = pass.rmse_k.delivered;
                let value = of.held_out.or(of.train).map_or_else(|| NONE.to_owned(), kelvin);
                let what = if of.held_out.is_some() { "held-out " } else { "" };
                text.plain(format!(" {}: RMSE {what}{value}; the pass has no job ", pass.untuned_in_words()))
                    .code("calibrate")
                    .plain(" that tunes it.")
            }
        };
    };
    if pass.added.is_empty() {
        text = text.plain(" adds no effect");
    } else {
        text = text.plain(" adds ");
        for (position, id) in pass.added.iter().enumerate() {
            text = text.plain(if position == 0 { "" } else { " and " }).code(id);
        }
    }
    if !before.has_readings_of(pass) {
        return other_readings(text, before, pass);
    }
    let states = |states: &States| [states.tuned, states.delivered];
    let words = ["tuned", if pass.adopted.is_empty() { "as delivered" } else { "untuned" }];
    let pairs = states(&before.rmse_k).into_iter().zip(states(&pass.rmse_k)).zip(words);
    let changes =
        pairs.filter_map(|((before, after), word)| Some((change(&before, &after)?, fell(&before, &after), word)));
    let Some((change, fell, word)) = changes.into_iter().next() else { return text.plain(": no error to compare.") };
    text = text.plain(format!(": {change} ({word}, against ")).code(&before.pass).plain(")");
    // Where the pass before was not tuned, what this one reaches is held against nothing.
    let tuned = pass.rmse_k.tuned.held_out.or(pass.rmse_k.tuned.train).filter(|_| word != words[0]);
    if let Some(tuned) = tuned {
        text = text.plain(format!("; tuned {}", kelvin(tuned)));
    }
    match fell {
        Some(false) => text.plain("; ").strong("the error did not fall").plain("."),
        _ => text.plain("."),
    }
}

/// What tuning made of the state before, which names the effects already.
fn tuned_from_there(pass: &PassErrors) -> &'static str {
    if pass.adopted.is_empty() { "tuned, without new physics" } else { "tuned, nothing further added" }
}

/// The error of a pass whose readings are not those of the pass before: it says nothing of whether the model became better.
fn other_readings(text: Text, before: &PassErrors, pass: &PassErrors) -> Text {
    let of = |split: &Split, state: &str| {
        let (value, what) =
            split.held_out.map(|value| (value, "held-out ")).or(split.train.map(|value| (value, "")))?;
        Some(format!("{what}error {} {state}", kelvin(value)))
    };
    let known = [of(&pass.rmse_k.delivered, &pass.untuned_in_words()), of(&pass.rmse_k.tuned, "tuned")];
    let known: Vec<String> = known.into_iter().flatten().collect();
    text.plain(format!(": {}, on other readings than those of ", known.join(", ")))
        .code(&before.pass)
        .plain(", so that the two errors cannot be held against one another.")
}

/// Two numbers side by side.
fn pair(split: &Split, shown: &dyn Fn(f64) -> String) -> Cell {
    let one = |value: Option<f64>| value.map_or_else(|| NONE.to_owned(), shown);
    match (split.train, split.held_out) {
        (None, None) => NONE.into(),
        (train, None) => one(train).into(),
        (train, held_out) => format!("{} / {}", one(train), one(held_out)).into(),
    }
}

fn table(measured: &[&PassErrors]) -> Table {
    // The tuned state where there is one.
    let state = |pass: &PassErrors, states: &States| {
        let is_tuned = pass.rmse_k.tuned != Split::default();
        if is_tuned { states.tuned } else { states.delivered }
    };
    let rows = measured
        .iter()
        .map(|pass| {
            let within = state(pass, &pass.within_limit);
            let all = |split: &Split| [split.train, split.held_out].into_iter().flatten().all(|share| share >= 1.0);
            let within_cell = Cell {
                status: (within != Split::default()).then(|| if all(&within) { Status::Ok } else { Status::Caution }),
                ..pair(&within, &|share| percent(share, 0))
            };
            vec![
                Cell::code(&pass.pass),
                pair(&pass.rmse_k.delivered, &|value| fixed(value, 2)),
                pair(&pass.rmse_k.tuned, &|value| fixed(value, 2)),
                pair(&state(pass, &pass.mean_k), &|value| signed(value, 2)),
                within_cell,
                pass.reduced_chi2.map_or_else(|| NONE.to_owned(), |value| fixed(value, 2)).into(),
                evidence(pass, 2),
            ]
        })
        .collect();
    let limits: Vec<Option<f64>> = measured.iter().map(|pass| pass.limit_k).collect();
    let limit = match limits.first() {
        Some(Some(limit)) if limits.iter().all(|other| other == &limits[0]) => {
            format!("Within {} K", crate::report::number::as_given(*limit))
        }
        _ => "Within limit".to_owned(),
    };
    Table {
        caption: "Readings for fitting / held out. Untuned: at nominal parameters, as delivered; what a pass adopts stands at its \
                  nominal size there, so that tuned errors alone tell whether it helped. Mean deviation (measured minus predicted) and share within the limit are of the \
                  tuned state where there is one. Reduced chi-square: sum of squares of the whitened residuals over readings less unknowns, \
                  by the noise of the calibration; a diagnosis that estimates the noise itself tells another. Evidence compares passes \
                  that fit the same readings."
            .into(),
        columns: vec![
            Column::text("Pass"),
            Column::number("RMSE untuned", "K"),
            Column::number("RMSE tuned", "K"),
            Column::number("Mean", "K"),
            Column::number(limit, ""),
            Column::number("Reduced chi-square", ""),
            Column::number("Log evidence", ""),
        ],
        rows,
    }
}

fn figure(history: &History, measured: &[&PassErrors], first: &PassErrors) -> Figure {
    let position = |pass: &PassErrors| measured.iter().position(|other| other.pass == pass.pass);
    // Errors of different readings are not joined.
    let steps = measured.iter().enumerate().filter_map(|(place, pass)| {
        let before = history.before(pass).filter(|before| before.has_readings_of(pass))?;
        Some((position(before)?, place))
    });
    let steps: Vec<(usize, usize)> = steps.collect();
    let has_effects = measured.iter().any(|pass| !pass.adopted.is_empty());
    let of = |pick: fn(&Split) -> Option<f64>| {
        let tuned = measured.iter().map(|pass| pick(&pass.rmse_k.tuned)).collect();
        (pick(&first.rmse_k.delivered), pick(&first.rmse_k.tuned), tuned)
    };
    let data = PassCurves {
        passes: measured.iter().map(|pass| pass.pass.trim_end_matches(".json").to_owned()).collect(),
        steps,
        held_out: of(|split| split.held_out),
        train: of(|split| split.train),
        first_labels: [first.untuned_in_words(), first.tuned_in_words()],
        tuned_label: if has_effects { "tuned with the effects" } else { "tuned" }.to_owned(),
    };
    let alternative = measured.iter().map(|pass| {
        let tuned = pass.rmse_k.tuned;
        let value = tuned.held_out.or(tuned.train).map_or_else(|| "none".to_owned(), kelvin);
        format!("{} {value}", pass.pass)
    });
    let [untuned, tuned] = [first.untuned_in_words(), first.tuned_in_words()];
    let first_errors = [(&untuned, first.rmse_k.delivered), (&tuned, first.rmse_k.tuned)];
    let first_errors = first_errors.map(|(what, split)| {
        format!("{what} {}", split.held_out.or(split.train).map_or_else(|| "none".to_owned(), kelvin))
    });
    Figure {
        id: "error-by-pass".into(),
        drawing: pass_curves(&data),
        caption: Text::new(format!("Error by pass: {untuned} and {tuned} are states of "))
            .code(&first.pass)
            .plain("; each pass's own tuned state beside them."),
        alternative: format!(
            "Curves of the RMSE by pass, on held-out readings where there are any: {}; tuned: {}.",
            first_errors.join(", "),
            alternative.collect::<Vec<_>>().join(", ")
        ),
    }
}
