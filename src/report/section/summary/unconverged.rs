//! Chains that did not converge: said before all else, with what mends them as the next step.

use crate::job::calibrate::{Output, Remedy};
use crate::job::{calibrate, predict};
use crate::report::page::Text;
use crate::report::view::PassReport;

/// The first calibration of the pass whose chains did not converge.
fn first<'r>(report: &'r PassReport<'_>) -> Option<(&'r str, &'r Output)> {
    report.outputs::<calibrate::Kind>().find(|(_, output)| !output.converged)
}

/// The first prediction of the pass with draws of such chains.
fn prediction<'r>(report: &'r PassReport<'_>) -> Option<&'r str> {
    report.outputs::<predict::Kind>().find(|(_, output)| !output.converged).map(|(name, _)| name)
}

/// That the posterior is not to be trusted, and why; nothing where all chains converged.
pub(super) fn headline(report: &PassReport<'_>) -> Option<Text> {
    let text = Text::default().strong("The posterior is not to be trusted");
    let Some((name, output)) = first(report) else {
        let name = prediction(report)?;
        return Some(text.plain(": the chains behind ").code(name).plain(" did not converge."));
    };
    let mut text = text.plain(": calibration ").code(name).plain(" did not converge");
    if let Some(objection) = output.objections.first() {
        let more = output.objections.len() - 1;
        text = text.plain(format!(" ({objection}"));
        text = text.plain(if more > 0 { format!("; {more} more)") } else { ")".to_owned() });
    }
    Some(text.plain("."))
}

/// What mends it.
pub(super) fn next_step(report: &PassReport<'_>) -> Option<Text> {
    let run = |text: Text, what: &str| text.plain("; then ").code(format!("bmv run {what}")).plain(".");
    let pass = format!("{}/{}", report.study, report.pass_file);
    let Some((name, output)) = first(report) else {
        prediction(report)?;
        let text = Text::new("Mend the calibration that the prediction takes its draws from: ");
        return Some(text.code(format!("bmv run {}", report.study)).plain(" says what to write in its pass."));
    };
    Some(match output.remedy()? {
        Remedy::Settings(settings) => {
            let text = Text::new("In ").code(&report.pass_file).plain(" write ").code(settings).plain(" under ");
            run(text.code(format!("jobs.{name}.calibrate")), &pass)
        }
        Remedy::Upstream(source) => {
            run(Text::with_names(&format!("Mend {source} first, whose draws are the prior here")), &report.study)
        }
    })
}
