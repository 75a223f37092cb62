//! What each approach knew when: the design values to which the passes lead, one after the other.

use crate::report::number::{NONE, Shown};
use crate::report::page::{Block, Cell, Column, Figure, Section, Table};
use crate::report::plot::{Axis, Chart, Layer, Mark, Stroke, palette};
use crate::report::section::design_values::{DesignValue, Way};

use super::study_page::{link, name};
use super::{ArchivedPass, ArchivedStudy};

/// Share of the way to the next pass by which values of one approach in one pass stand apart.
const APART: f64 = 0.12;

/// The section; not where no pass has a design value, or only one has.
pub(super) fn section(study: &ArchivedStudy) -> Option<Section> {
    let mut asked: Vec<(&str, &str)> = Vec::new();
    for own in study.passes.iter().flat_map(|pass| &pass.record.design_values) {
        let pair = (own.variable.as_str(), own.environment.as_str());
        if !asked.contains(&pair) {
            asked.push(pair);
        }
    }
    let mut blocks = Vec::new();
    for (variable, environment) in asked {
        let is_asked = |own: &&DesignValue| own.variable == variable && own.environment == environment;
        let passes: Vec<(&ArchivedPass, Vec<&DesignValue>)> = (study.passes.iter())
            .map(|pass| (pass, pass.record.design_values.iter().filter(is_asked).collect::<Vec<_>>()))
            .filter(|(_, values)| !values.is_empty())
            .collect();
        if passes.len() > 1 {
            blocks.push(Block::Figure(figure(&passes, variable, environment)));
            let table = Block::Table(table(&passes, variable, environment));
            blocks.push(Block::Details("The same in numbers".into(), vec![table]));
        }
    }
    let title = "What each approach knew when".into();
    (!blocks.is_empty()).then_some(Section { id: "timeline", title, blocks })
}

/// How the values of all passes are shown: in one unit, that of the largest.
fn shown(passes: &[(&ArchivedPass, Vec<&DesignValue>)]) -> Shown {
    let all = || passes.iter().flat_map(|(_, values)| values);
    let largest = all().filter_map(|own| own.value).map(f64::abs).fold(0.0, f64::max);
    Shown::parameter_of(all().next().map_or("1", |own| own.unit.as_str()), largest)
}

/// An approach with its values: number of the pass (from 1), value, interval.
type Series<'r> = (&'r DesignValue, Vec<(f64, f64, Option<[f64; 2]>)>);

fn series<'r>(passes: &[(&'r ArchivedPass, Vec<&'r DesignValue>)]) -> Vec<Series<'r>> {
    let mut all: Vec<Series<'r>> = Vec::new();
    for (position, (_, values)) in passes.iter().enumerate() {
        for own in values {
            let same: Vec<&&DesignValue> = values.iter().filter(|other| other.approach == own.approach).collect();
            let rank = same.iter().position(|other| std::ptr::eq(**other, *own)).unwrap_or(0) as f64;
            let offset = APART * (rank - 0.5 * (same.len() as f64 - 1.0));
            let point = own.value.map(|value| (position as f64 + 1.0 + offset, value, own.interval));
            match all.iter_mut().find(|(first, _)| first.approach == own.approach) {
                Some((_, points)) => points.extend(point),
                None => all.push((own, point.into_iter().collect())),
            }
        }
    }
    all
}

fn figure(passes: &[(&ArchivedPass, Vec<&DesignValue>)], variable: &str, environment: &str) -> Figure {
    let all = series(passes);
    let shown = shown(passes);
    let mut layers = Vec::new();
    // Margins of one size have one colour: on nominal values a ring, on stacked worst cases a disc.
    let mut margins: Vec<&str> = Vec::new();
    for (own, points) in &all {
        let place = points.iter().map(|(at, value, _)| (*at, shown.value(*value))).collect::<Vec<_>>();
        let label = own.approach.clone();
        if own.way == Way::Probability {
            let intervals = points
                .iter()
                .filter_map(|(at, _, interval)| interval.map(|[low, high]| (*at, shown.value(low), shown.value(high))));
            layers.push(Layer::Intervals { points: intervals.collect(), colour: palette::INK });
            let line = Layer::Line { points: place.clone(), colour: palette::INK, stroke: Stroke::Solid, label };
            layers.push(line);
            layers.push(Layer::Dots { points: place, colour: palette::INK, mark: Mark::Disc, label: String::new() });
            continue;
        }
        let margin = own.approach.split_once(", ").map_or("", |(_, margin)| margin);
        let number = margins.iter().position(|known| *known == margin).unwrap_or_else(|| {
            margins.push(margin);
            margins.len() - 1
        });
        let colour = palette::series(number);
        let mark = if own.way == Way::RuleOnNominal { Mark::Ring } else { Mark::Disc };
        let stroke = Stroke::Dashed;
        layers.push(Layer::Line { points: place.clone(), colour, stroke, label: String::new() });
        layers.push(Layer::Dots { points: place, colour, mark, label });
    }
    let end = passes.len() as f64 + 0.5;
    layers.extend(all.iter().find_map(|(own, _)| own.nominal).map(|value| Layer::Line {
        points: vec![(0.5, shown.value(value)), (end, shown.value(value))],
        colour: palette::MUTED,
        stroke: Stroke::Dashed,
        label: format!("nominal {}", shown.text(value)),
    }));
    let names = passes.iter().map(|(pass, _)| name(pass).to_owned()).collect();
    let chart = Chart {
        x: Axis::of_names("pass", names),
        y: Axis::new(shown.title(variable)),
        layers,
        height: 1000,
        ..Chart::default()
    };
    let probable = all.iter().filter(|(own, _)| own.way == Way::Probability).flat_map(|(_, points)| points);
    let said: Vec<String> = probable.map(|(_, value, _)| shown.text(*value)).collect();
    let caption = format!(
        "{variable} to which each approach leads, pass by pass, environment {environment}: by probability {}; by rule on \
         nominal values (rings) and on stacked worst cases (discs), before the test and after each correlation.",
        said.join(", ")
    );
    Figure {
        id: format!("timeline-{variable}-{environment}"),
        drawing: chart.draw(),
        alternative: format!("Chart over the passes. {caption}"),
        caption: caption.into(),
    }
}

fn table(passes: &[(&ArchivedPass, Vec<&DesignValue>)], variable: &str, environment: &str) -> Table {
    let shown = shown(passes);
    let rows = passes.iter().flat_map(|(pass, values)| {
        values.iter().map(|own| {
            let interval = own.interval.map_or_else(
                || NONE.to_owned(),
                |[low, high]| format!("{} to {}", shown.number(low), shown.number(high)),
            );
            vec![
                Cell::from(link(pass)),
                own.approach.clone().into(),
                own.known.clone().into(),
                own.value.map_or_else(|| "none passes".to_owned(), |value| shown.number(value)).into(),
                interval.into(),
                Cell::code(&own.job),
            ]
        })
    });
    Table {
        caption: format!("The same in numbers: {variable}, environment {environment}, all requirements together.")
            .into(),
        columns: vec![
            Column::text("Pass"),
            Column::text("Approach"),
            Column::text("What was known"),
            Column::number(variable, shown.unit.clone()),
            Column::text("95 % interval"),
            Column::text("Job"),
        ],
        rows: rows.collect(),
    }
}
