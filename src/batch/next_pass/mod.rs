//! The next pass: a pass with effects that a diagnosis found missing.
//!
//! Only what changes is written: the effects with their place, priors and reasons, and the parent's jobs, which are not
//! inherited. Everything else follows from the parent. Adopting goes back to the original priors; the next pass is
//! calibrated anew.

mod acting;
mod adoption;
mod choose;
mod entry;
mod file;
mod mend;
pub mod name;
mod offer;
pub mod text;

pub use acting::{Acting, acts_in};
pub use adoption::{Adoption, adopt_into};
pub use choose::Asked;
pub use entry::probability_text;
pub use file::{destination, twin, write};
pub use mend::{Mended, to_mend};
pub use offer::{Offer, diagnosis, offers};

use std::path::Path;

use crate::diagnosis::output::{EffectFile, EffectResult};
use crate::diagnosis::{Output, PRIOR_OF};
use crate::document::json::Node;
use crate::document::written::read_document;
use crate::document::{Diagnostic, Diagnostics, code, suggest};
use crate::effect::Catalogue;

use crate::job::calibrate::{MANY_DRAWS, Sampler, is_long};
use crate::measurement::{Measurement, Sensor};
use crate::study::discover::number;
use crate::study::folder::Folder;
use crate::study::inherit::folder_diagnostic_at;
use crate::study::job::CALIBRATION;
use crate::study::pass::FORMAT;
use crate::study::problem::dated;
use crate::study::resolve::{effects, of_sensors};
use crate::study::resolved::Pass;
use choose::Chosen;
use text::Item;

/// A pass to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct NextPass<'f> {
    /// Its file's text.
    pub text: String,
    /// What it adopts, each with its name in the pass.
    pub adopted: Vec<(String, &'f EffectResult)>,
    /// Calibrations that list their parameters, to which those of the effects were added.
    pub extended: Vec<String>,
    /// Jobs that the parent does not have and that its error is stated by: name and kind.
    pub added: Vec<(String, &'static str)>,
    /// Calibrations whose settings are those that mend the parent's.
    pub mended: Vec<Mended>,
    /// What must be said of what is adopted: that the data do not settle it.
    pub warnings: Diagnostics,
    /// Effects that the study gets with it, since the diagnosis proposes them.
    pub files: Vec<&'f EffectFile>,
    /// Whether an effect acts on the model, so that predictions have it where its entry does not say otherwise.
    pub acts_on_model: bool,
}

/// The pass that adopts what was asked for, or what the diagnosis selected. `job` is the diagnosis's name in the pass;
/// `forced` lets through what it does not support; `file` is the new pass's.
///
/// # Errors
/// What is not known or not supported; a pass file or an effect that cannot be read.
pub fn next_pass<'f>(
    pass: &Pass,
    job: &str,
    diagnosis: &'f Output,
    asked: &Asked,
    forced: bool,
    file: &Path,
) -> Result<NextPass<'f>, Diagnostics> {
    let Chosen { effects: chosen, warnings } = choose::choose(diagnosis, asked, job, forced, &pass.model)?;
    let applies_to = asked.acting.names(pass, asked)?;
    let mut catalogue = effects(Some(&pass.folder))?;
    let mut diagnostics = Diagnostics::new();
    let proposed = chosen.iter().filter_map(|finding| finding.file.as_ref());
    let files: Vec<&EffectFile> = proposed.filter(|file| !has_it(&catalogue, file)).collect();
    for file in &files {
        if catalogue.get(&file.name).is_some() {
            let message = format!("there is another effect `{}` than the one that the diagnosis proposes", file.name);
            let diagnostic = Diagnostic::error(&code::ADOPT_FILE, &asked.command(), message);
            diagnostics.push(diagnostic.expected(format!("no effects/{}.json in the study, or the same", file.name)));
        }
        catalogue.read(&file.name, &format!("effects/{}.json", file.name), file.text.as_bytes(), &mut diagnostics);
    }
    if diagnostics.has_errors() {
        return Err(diagnostics);
    }
    let Some(tree) = tree(pass, asked, &mut diagnostics) else { return Err(diagnostics) };
    let mut adopted: Vec<Entered<'f>> = Vec::new();
    for finding in chosen {
        match adopt(pass, job, diagnosis, finding, (&catalogue, applies_to.as_deref()), &adopted) {
            Some(adoption) => adopted.push(adoption),
            None => {
                let message = format!("`{}` does not fit this model with these effects", finding.id);
                let diagnostic = Diagnostic::error(&code::ADOPT_UNKNOWN, &asked.command(), message)
                    .expected("an effect of the catalogue, at a place of the model");
                diagnostics.push(diagnostic.help("the diagnosis is of another version; run it again"));
            }
        }
    }
    if diagnostics.has_errors() {
        return Err(diagnostics);
    }
    let parameters: Vec<&str> = adopted.iter().flat_map(|one| &one.parameters).map(String::as_str).collect();
    let mut extended = Vec::new();
    let names: Vec<&str> = adopted.iter().map(|one| one.name.as_str()).collect();
    let mut jobs = jobs(tree.get("jobs"), &parameters, &mut extended);
    let mended = mend::mend(&mut jobs, &asked.mended);
    let added = add_judges(pass, job, &mut jobs);
    let entries = |is_prior: bool| -> Vec<(String, Item)> {
        let of_role = adopted.iter().filter(|one| one.is_prior == is_prior);
        of_role.map(|one| (one.key.clone(), one.item.clone())).collect()
    };
    let (priors, effects) = (entries(true), entries(false));
    let mut sections = vec![
        ("format".to_owned(), Item::text(FORMAT)),
        ("title".to_owned(), Item::text(&title(pass, &names, file))),
        ("description".to_owned(), Item::text(&description(pass, job, &names))),
        ("parent".to_owned(), Item::text(&pass.file)),
        ("model".to_owned(), Item::text(&pass.model_file)),
    ];
    for (section, entries) in [("parameters", priors), ("adopt", effects)] {
        if !entries.is_empty() {
            sections.push((section.to_owned(), Item::Object(entries)));
        }
    }
    sections.push(("jobs".to_owned(), Item::Object(jobs)));
    let document = Item::Object(sections);
    let acts_on_model = adopted.iter().any(|one| one.acts_on_model);
    let adopted = adopted.into_iter().map(|one| (one.name, one.finding)).collect();
    Ok(NextPass { text: document.document(), adopted, extended, added, mended, warnings, files, acts_on_model })
}

/// Whether a study has a proposed effect already.
fn has_it(catalogue: &Catalogue, file: &EffectFile) -> bool {
    let json: Option<serde_json::Value> = serde_json::from_str(&file.text).ok();
    catalogue.get(&file.name).is_some_and(|effect| Some(&effect.json) == json.as_ref())
}

/// An effect, or a wider prior, with its entry.
struct Entered<'f> {
    /// As people read it.
    name: String,
    /// Of its entry: the same, or the parameter that has the prior.
    key: String,
    is_prior: bool,
    acts_on_model: bool,
    finding: &'f EffectResult,
    item: Item,
    /// Names of its parameters that are not fixed.
    parameters: Vec<String>,
}

/// The pass's own file as a tree.
fn tree(pass: &Pass, asked: &Asked, diagnostics: &mut Diagnostics) -> Option<Node> {
    // Not another file than the one whose diagnosis is adopted from.
    let bytes = Folder::open(&pass.folder).and_then(|folder| folder.after(pass.files.clone()).read(&pass.file));
    match bytes {
        Ok(bytes) => read_document(&pass.folder.join(&pass.file).display().to_string(), &bytes, diagnostics),
        Err(error) => {
            diagnostics.push(folder_diagnostic_at(&error, &asked.command()));
            None
        }
    }
}

fn adopt<'f>(
    pass: &Pass,
    job: &str,
    diagnosis: &Output,
    finding: &'f EffectResult,
    (catalogue, applies_to): (&Catalogue, Option<&[String]>),
    before: &[Entered<'f>],
) -> Option<Entered<'f>> {
    let (model, _) = dated(pass, pass.measurements.clone());
    let model = &model;
    if finding.effect == PRIOR_OF {
        let [key] = finding.place.as_slice() else { return None };
        let (mut item, fitted) = entry::wider_prior(finding, pass, key)?;
        let because = format!(
            "{}; the prior before was too narrow for these data: ask where it came from",
            entry::because(finding, fitted.as_slice(), diagnosis, job, &pass.file)
        );
        item.push(("because".to_owned(), Item::text(&because)));
        let (name, key) = (format!("wider prior of {key}"), key.clone());
        let item = Item::Object(item);
        let parameters = Vec::new();
        return Some(Entered { name, key, is_prior: true, acts_on_model: false, finding, item, parameters });
    }
    let effect = catalogue.get(&finding.effect)?;
    let bound = entry::bound(effect, finding, model)?;
    // Names of elements, nodes, parameters and inputs are made of it.
    let is_used = |name: &str| {
        let below = |other: &str| other == name || other.strip_prefix(name).is_some_and(|rest| rest.starts_with('.'));
        before.iter().any(|other| other.name == name)
            || pass.adopted.iter().any(|other| other.name == name)
            || model.elements.iter().any(|element| element.name == name)
            || model.nodes.iter().any(|node| below(&node.name))
            || model.quantities.iter().any(|quantity| quantity.name == name)
            || model.parameters.iter().any(|parameter| below(&parameter.name))
            || model.inputs.iter().any(|input| below(&input.name))
    };
    let name = name::name(&finding.effect, &finding.place, &finding.where_kind, finding.input.as_deref(), &is_used);
    let (usage, fitted) = entry::usage(effect, finding, &bound, model);
    let acts_on_model = !of_sensors(effect);
    let mut fields = vec![("effect".to_owned(), usage)];
    fields.extend(entry::starts(finding, pass).map(|starts| ("starts".to_owned(), starts)));
    fields.push(("because".to_owned(), Item::text(&entry::because(finding, &fitted, diagnosis, job, &pass.file))));
    fields.push(("evidence".to_owned(), entry::evidence(finding, &fitted, job, &pass.file)));
    if let Some(names) = applies_to.filter(|_| acts_on_model) {
        fields.push(("applies_to".to_owned(), Item::List(names.iter().map(|name| Item::text(name)).collect())));
    }
    let item = Item::Object(fields);
    let parameters = effect.parameters(model, &bound).into_iter().filter(|parameter| !parameter.prior.is_fixed());
    let parameters = parameters.map(|parameter| format!("{name}.{}", parameter.name)).collect();
    Some(Entered { key: name.clone(), name, is_prior: false, acts_on_model, finding, item, parameters })
}

/// What is added to a title.
fn with(names: &[&str]) -> String {
    let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    match names.split_last() {
        None => String::new(),
        Some((last, [])) => format!(", with {last}"),
        Some((last, rest)) => format!(", with {} and {last}", rest.join(", ")),
    }
}

/// The parent's title with all adopted effects; where it tells the pass's number, the new one.
fn title(pass: &Pass, names: &[&str], file: &Path) -> String {
    let before: Vec<&str> = pass.adopted.iter().map(|adopted| adopted.name.as_str()).collect();
    let base = pass.title.strip_suffix(with(&before).as_str()).unwrap_or(&pass.title);
    // A title that could not be stripped names the earlier effects in its own way.
    let is_stripped = base.len() < pass.title.len();
    let all: Vec<&str> = before.into_iter().filter(|_| is_stripped).chain(names.iter().copied()).collect();
    let base = match (number(Path::new(&pass.file)), number(file)) {
        (Some(old), Some(new)) => renumbered(base, old, new),
        _ => base.to_owned(),
    };
    format!("{base}{}", with(&all))
}

/// A title with the new number where it has the old one: as `pass 1` or `Pass 1`, a word of its own.
pub fn renumbered(title: &str, old: u64, new: u64) -> String {
    let before = format!("pass {old}");
    // Of the same length: only ASCII letters change.
    let lower = title.to_ascii_lowercase();
    let is_word = |at: &usize| {
        let begins = !lower[..*at].ends_with(char::is_alphanumeric);
        begins && !lower[at + before.len()..].starts_with(|c: char| c.is_ascii_digit())
    };
    match lower.match_indices(before.as_str()).map(|(at, _)| at).find(is_word) {
        Some(at) => format!("{}{new}{}", &title[..at + "pass ".len()], &title[at + before.len()..]),
        None => title.to_owned(),
    }
}

fn description(pass: &Pass, job: &str, names: &[&str]) -> String {
    let effects = suggest::listed(names.iter().copied(), names.len()).replace('`', "");
    format!(
        "{} with what its diagnosis {job} names: {effects}. All else is inherited, and the calibration starts from the original priors; nominal values of the effect are those that the diagnosis fitted.",
        pass.file
    )
}

/// The parent's jobs as written; calibrations that list their parameters get those of the effects.
fn jobs(own: Option<&Node>, parameters: &[&str], extended: &mut Vec<String>) -> Vec<(String, Item)> {
    let Some(Item::Object(mut jobs)) = own.map(Item::of_node) else { return Vec::new() };
    for (name, job) in &mut jobs {
        let Item::Object(kinds) = job else { continue };
        for (_, settings) in kinds.iter_mut().filter(|(kind, _)| kind == "calibrate") {
            let Item::Object(settings) = settings else { continue };
            for (_, list) in settings.iter_mut().filter(|(setting, _)| setting == "parameters") {
                let Item::List(list) = list else { continue };
                list.extend(parameters.iter().map(|parameter| Item::text(parameter)));
                extended.push(name.clone());
            }
        }
    }
    jobs
}

/// Adds the jobs by which a pass's error is stated, as far as the parent has none of the kind: a calibration and a comparison,
/// on the data of the diagnosis.
fn add_judges(pass: &Pass, diagnosis: &str, jobs: &mut Vec<(String, Item)>) -> Vec<(String, &'static str)> {
    let diagnosis_job = pass.jobs.iter().find(|job| job.name == diagnosis);
    let data = diagnosis_job.and_then(|job| job.spec.inference()).map(|inference| inference.data);
    let data: Vec<&Measurement> =
        data.into_iter().flatten().filter_map(|&position| pass.measurements.get(position)).collect();
    let names = data.iter().map(|measurement| Item::text(&measurement.name)).collect();
    let settings = vec![("data".to_owned(), Item::List(names))];
    let is_long = is_long(data.iter().copied());
    let is_inferred = |sensor: &Sensor| sensor.bias.as_ref().is_some_and(|bias| bias.prior().is_some());
    // A calibration of a model without derivatives has no trajectories.
    let has_offsets = pass.external.is_none() && data.iter().any(|own| own.sensors.iter().any(is_inferred));
    let mut added = Vec::new();
    for (kind, wanted) in [(CALIBRATION, "tuned"), ("compare", "delivered")] {
        if pass.jobs.iter().any(|job| job.spec.kind() == kind) {
            continue;
        }
        let is_taken = |name: &str| jobs.iter().any(|(other, _)| other == name);
        let numbered = (2..).map(|number| format!("{wanted} {number}"));
        let name = std::iter::once(wanted.to_owned()).chain(numbered).find(|name| !is_taken(name));
        let name = name.unwrap_or_else(|| wanted.to_owned());
        let mut settings = settings.clone();
        if kind == CALIBRATION && is_long {
            settings.push(("sampler".to_owned(), Item::text(Sampler::IndependenceMetropolis.name())));
            settings.push(("draws".to_owned(), Item::number(MANY_DRAWS as f64)));
        } else if kind == CALIBRATION && has_offsets {
            // An offset of a sensor and what the model does there go together along a ridge, which bounded priors cut off.
            settings.push(("acceptance".to_owned(), Item::number(0.95)));
            settings.push(("warmup".to_owned(), Item::number(1000.0)));
            settings.push(("draws".to_owned(), Item::number(2000.0)));
        }
        jobs.push((name.clone(), Item::one(kind, Item::Object(settings))));
        added.push((name, kind));
    }
    added
}
