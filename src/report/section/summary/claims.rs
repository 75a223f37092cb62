//! What requirements and sizes say on the first screen, each claim in the light of the model's test.

use crate::job::{conventional, predict, propagate};
use crate::math::sort::sort_by;
use crate::report::number::{self, Shown};
use crate::report::page::{Statement, Text};
use crate::report::section::validation::{Rests, claim, objection};
use crate::report::section::{problem, propagation, sizing};
use crate::report::view::PassReport;
use crate::study::requirement::ALL;

/// Statements about requirements, and about the quantities behind them.
type Statements = (Vec<Statement>, Vec<Statement>);

/// Of a propagation of the priors.
pub(super) fn of_propagated(report: &PassReport<'_>, output: &propagate::Output) -> Statements {
    of_propagation(report, output, "Probability", Rests::OnDelivered)
}

/// Of a prediction after calibration.
pub(super) fn of_predicted(report: &PassReport<'_>, output: &predict::Output) -> Statements {
    of_propagation(report, &output.posterior, "Probability after calibration", Rests::OnTuned)
}

/// Why no requirement may be called met, of the first state of the model on which a claim rests.
pub(in crate::report::section) fn objection_to_all(report: &PassReport<'_>) -> Option<Text> {
    let predicted = report.outputs::<predict::Kind>().map(|(_, output)| (Rests::OnTuned, &output.posterior));
    let propagated = report.outputs::<propagate::Kind>().map(|(_, output)| (Rests::OnDelivered, output));
    predicted.chain(propagated).find_map(|(rests, output)| {
        objection(report, rests, propagation::nominal_cases(output).flat_map(|case| &case.requirements))
    })
}

/// By environment: the requirement that is farthest from what is required, under this label, and its quantity's
/// distribution.
fn of_propagation(report: &PassReport<'_>, output: &propagate::Output, probability: &str, rests: Rests) -> Statements {
    let (mut out, mut quantities) = (Vec::new(), Vec::new());
    for case in propagation::nominal_cases(output) {
        let Some(met) = case.requirements.iter().min_by(|a, b| {
            (a.probability.value - a.required)
                .total_cmp(&(b.probability.value - b.required))
                .then((a.requirement == ALL).cmp(&(b.requirement == ALL)))
        }) else {
            continue;
        };
        let shown = report.quantity_shown(&met.quantity, &met.unit);
        let what = if met.quantity.is_empty() {
            "all requirements together".to_owned()
        } else {
            format!("{} {}", met.quantity, problem::limits(&shown, met.above, met.below))
        };
        let (words, status) = claim(report, rests, met);
        out.push(Statement {
            label: format!("{probability}, nominal design, {}", case.environment),
            value: propagation::probability_stated(&met.probability),
            text: Text::new(format!("{what}; required {}: ", number::probability(met.required)))
                .strong(words)
                .plain("."),
            status: Some(status),
        });
        if let Some(q) = case.quantities.iter().find(|q| q.name == met.quantity).or(case.quantities.first()) {
            let shown = Shown::quantity(&q.unit, q.is_temperature);
            quantities.push(Statement {
                label: format!("{}, {}", q.name, case.environment),
                value: number::with_unit(
                    &format!("{} \u{00B1} {}", shown.number(q.mean), shown.difference().number(q.sd)),
                    &shown.unit,
                ),
                text: Text::new(format!("mean and standard deviation; nominal {}.", shown.text(q.nominal))),
                status: None,
            });
        }
    }
    (out, quantities)
}

/// By environment: the design value that all requirements allow, before and after.
pub(super) fn of_prediction(output: &predict::Output) -> Vec<Statement> {
    let mut out: Vec<Statement> = Vec::new();
    let Some(design) = &output.posterior.design_variable else { return out };
    let shown = Shown::written(&output.posterior.design_unit);
    for case in propagation::nominal_cases(&output.posterior) {
        let is_whole = |reached: &&propagate::Reached| {
            reached.environment == case.environment && (reached.requirement == ALL || case.requirements.len() == 1)
        };
        let find =
            |from: &propagate::Output| from.reached.iter().find(is_whole).and_then(|reached| reached.design_value);
        let Some(value) = find(&output.posterior) else { continue };
        let text = find(&output.prior).map_or_else(
            || "no value of the sweep reached it with the priors.".to_owned(),
            |before| format!("reaches what is required; with the priors {}.", shown.text(before)),
        );
        out.push(Statement {
            label: format!("{design} after calibration, {}", case.environment),
            value: shown.text(value),
            text: Text::new(text),
            status: None,
        });
    }
    out
}

/// Sizes by rule and by probability. The job is named where there are several.
pub(super) fn of_sizes(report: &PassReport<'_>, output: &conventional::Output, job: Option<&str>) -> Vec<Statement> {
    let mut out = Vec::new();
    let job = job.map_or(String::new(), |name| format!(", {name}"));
    let design = Shown::written(&output.design_unit);
    let mut environments: Vec<&str> = Vec::new();
    let what = if output.seeks_largest() { format!("limit of {}", output.design_variable) } else { "size".to_owned() };
    // The first pair of an environment is that of all its requirements.
    for pair in sizing::pairs(output) {
        if environments.contains(&pair.0) {
            continue;
        }
        environments.push(pair.0);
        let reached = sizing::probabilistic(report, &output.design_variable, pair);
        let probabilistic = reached.and_then(|r| r.design_value.map(|v| (v, r)));
        if let Some((value, reached)) = probabilistic {
            let interval = reached
                .interval
                .map_or(String::new(), |[a, b]| format!(" ({} to {})", design.number(a), design.text(b)));
            out.push(Statement {
                label: format!("Probabilistic {what}, {}{job}", pair.0),
                value: design.text(value),
                text: Text::code(Text::default(), &output.design_variable)
                    .plain(format!(" for P = {}{interval}.", number::probability(reached.probability))),
                status: None,
            });
        }
        let sizes: Vec<&conventional::Size> =
            sizing::sizes_of(output, pair).into_iter().filter(|s| s.size.is_some()).collect();
        let stacked = sizes.iter().filter(|s| s.basis == conventional::Basis::StackedWorstCase);
        let middle = sorted_middle(stacked.copied().collect());
        if let Some((size, value)) = middle.and_then(|s| Some((s, s.size?))) {
            let against = probabilistic.map_or(String::new(), |(design_value, _)| {
                let difference = design.difference();
                let relative = match (design.is_celsius(), design_value < value) {
                    (false, _) => propagation::relative(design_value, value),
                    (true, true) => format!("{} colder", difference.text(value - design_value)),
                    (true, false) => format!("{} warmer", difference.text(design_value - value)),
                };
                format!(" The probabilistic {what} is {relative}.")
            });
            let all = || sizes.iter().filter_map(|s| s.size);
            let (least, most) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
            let range = format!(" All rules: {} to {}.", design.number(least), design.text(most));
            out.push(Statement {
                label: format!("Conventional {what}, {}{job}", pair.0),
                value: design.text(value),
                text: Text::new(format!("{} ({}).{against}{range}", sizing::label(size), size.rule.title)),
                status: None,
            });
        }
    }
    out
}

/// The middle one by size, the larger of two.
fn sorted_middle(mut sizes: Vec<&conventional::Size>) -> Option<&conventional::Size> {
    sort_by(&mut sizes, |a, b| a.size.unwrap_or(f64::NAN).total_cmp(&b.size.unwrap_or(f64::NAN)));
    sizes.get(sizes.len() / 2).copied()
}
