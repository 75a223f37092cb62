//! From a pass as written to a pass that can be run.

mod absolute_error;
pub mod adopt;
mod adopt_parameter;
mod adopt_place;
pub mod changes;
pub mod chosen;
mod clocks;
pub mod data;
pub mod design_variable;
mod drift;
mod figure;
pub mod gaps;
pub mod influence;
mod initial;
pub mod measurement;
mod noise;
mod outside;
pub mod parts;
pub use adopt::of_sensors;
pub use parts::belongs_to;
mod physical;
pub mod plausible;
pub mod posterior_prior;
pub mod requirement;
pub mod scope;
pub mod settings;
pub mod steady;
pub mod transient;
mod used_twice;

use std::path::Path;
use std::sync::Arc;

use crate::document::hash::sha256_hex;
use crate::document::written::check_format;
use crate::document::{
    Diagnostic, Diagnostics, MapEntry, NameOr, Node, Place, Source, Span, Spanned, Value, Written, canonical, code,
};
use crate::effect::{Catalogue, GroupPlace, SensorPlace, thermometers};
use crate::measurement::sensor_places;
use crate::thermal::{self, Clock, Quantity};

use super::folder::{Folder, FolderError};
use super::inherit::{Lineage, folder_diagnostic_at, lineage};
use super::job::Kinds;
use super::model::name::check_label;
use super::model::surrogate::Surrogate;
use super::model::{self, Group, QuantityForm, QuantityOrName, ResolvedModel};
use super::pass::measurement::MeasurementForm;
use super::pass::{self, PassForm};
use super::pinned::Pinned;
use super::reader::Reader;
use super::resolved::{Closing, Pass};
use super::{document, profile, rule};

use measurement::Outcome;
use posterior_prior::Upstreams;
use scope::{Scope, unit_of};
use settings::Offered;

/// The model's file where no pass names one.
const MODEL: &str = "model.json";
/// The seed where no pass states one.
const SEED: u64 = 1;
/// Largest seed: larger integers are not exact in every JSON reader.
pub const LARGEST_SEED: u64 = (1 << 53) - 1;

/// Reads a pass with its parents, its model and its data, because one of the study's passes of this chain uses it.
///
/// # Errors
/// All that is wrong with the files; warnings stand among them.
pub(super) fn load(reader: &Reader, pass: &Path, chain: &[String]) -> Result<Pass, Diagnostics> {
    let mut diagnostics = Diagnostics::new();
    let resolved = read(reader, pass, chain, &mut diagnostics);
    match resolved {
        Some(mut pass) if !diagnostics.has_errors() => {
            pass.warnings = diagnostics;
            Ok(pass)
        }
        Some(_) | None => Err(diagnostics),
    }
}

/// The program's effects, with those of a study's folder where one is given.
///
/// # Errors
/// What is wrong with the study's own.
pub fn effects(study: Option<&Path>) -> Result<Catalogue, Diagnostics> {
    let mut diagnostics = Diagnostics::new();
    let catalogue = match study.map(Folder::open) {
        None => Catalogue::embedded(&mut diagnostics),
        Some(Ok(folder)) => adopt::catalogue(&folder, &mut diagnostics).0,
        Some(Err(error)) => {
            let nowhere = Place::in_text(&Source::new("effects", ""), Span::default());
            diagnostics.push(folder_diagnostic_at(&error, &nowhere));
            Catalogue::default()
        }
    };
    if diagnostics.has_errors() { Err(diagnostics) } else { Ok(catalogue) }
}

/// The pinned data that a pass states, whether they are there or not, and its folder.
///
/// # Errors
/// What is wrong with the pass as written; its model and its data are not read.
pub fn pinned(pass: &Path) -> Result<(Folder, Vec<Pinned>), Diagnostics> {
    let mut diagnostics = Diagnostics::new();
    let written = written(&Reader::new(Kinds::default()), pass, &mut diagnostics);
    let form = written.as_ref().and_then(|(_, lineage)| PassForm::read(&lineage.merged, &mut diagnostics));
    let mut list = Vec::new();
    for entry in form.iter().flat_map(|form| form.measurements.iter()) {
        let (file, pin) = match &entry.value {
            MeasurementForm::Steady(form) => (form.file.as_ref(), &form.pinned),
            MeasurementForm::Transient(form) => (Some(&form.file), &form.pinned),
        };
        if let (Some(file), Some(pin)) = (file, pin) {
            list.extend(data::pin(&entry.name, &file.value, pin, &mut diagnostics));
        }
    }
    match written {
        Some((folder, _)) if !diagnostics.has_errors() => Ok((folder, list)),
        Some(_) | None => Err(diagnostics),
    }
}

/// A pass with its parents, their formats checked.
fn written(reader: &Reader, path: &Path, diagnostics: &mut Diagnostics) -> Option<(Folder, Lineage)> {
    let shown = path.display().to_string();
    let nowhere = Place::in_text(&Source::new(shown.as_str(), ""), Span::default());
    let unreadable = |error: FolderError, diagnostics: &mut Diagnostics| {
        diagnostics.push(folder_diagnostic_at(&error, &nowhere));
        None
    };
    let folder = match Folder::open(path.parent().unwrap_or(Path::new(""))) {
        Ok(folder) => folder,
        Err(error) => return unreadable(error, diagnostics),
    };
    let Some(file) = path.file_name().and_then(|name| name.to_str()) else {
        return unreadable(FolderError::Missing { path: shown }, diagnostics);
    };
    let lineage = match lineage(reader, &folder, file, diagnostics) {
        Ok(lineage) => lineage?,
        Err(error) => return unreadable(error, diagnostics),
    };
    let mut good = !diagnostics.has_errors();
    for file in &lineage.files {
        good &= check_format(&file.tree, pass::FORMAT, diagnostics);
    }
    good.then_some((folder, lineage))
}

fn read(reader: &Reader, path: &Path, chain: &[String], diagnostics: &mut Diagnostics) -> Option<Pass> {
    let (folder, lineage) = written(reader, path, diagnostics)?;
    let form = PassForm::read(&lineage.merged, diagnostics);
    let model_file = model_file(&lineage.merged);
    let (resolved, model_tree) = read_model(&folder, &model_file, diagnostics)?;
    let form = form?;
    let chain: Vec<String> = chain.iter().chain([&lineage.files[0].name]).cloned().collect();
    let files =
        Files { reader, folder: &folder, lineage: &lineage, chain: &chain, model: (&model_file.value, &model_tree) };
    let (resolved, from_data) = with_ranges_of_data(&files, &form, resolved);
    let mut pass = resolve(&files, &form, resolved, diagnostics)?;
    pass.ranges_from_data.extend(from_data);
    Some(pass)
}

/// The files of a pass.
struct Files<'a> {
    /// Reads the passes whose calibrations are used.
    reader: &'a Reader,
    folder: &'a Folder,
    lineage: &'a Lineage,
    /// Files of the passes that are being read, each because the one before uses it; the last is the pass itself.
    chain: &'a [String],
    /// The model's file and tree.
    model: (&'a str, &'a Node),
}

/// The model with the ranges that its inputs take from the data, and the names of those inputs. Effects scale with the
/// ranges, so a pass that adopts some must know them before it reads what the effects may be needed for: it is resolved
/// twice.
fn with_ranges_of_data(files: &Files, form: &PassForm, mut resolved: ResolvedModel) -> (ResolvedModel, Vec<String>) {
    let lacks_range = || resolved.model.inputs.iter().any(|input| input.range.is_none());
    let is_needed = !form.adopt.is_empty() && (lacks_range() || adopt::depends_on_time(files.folder, form));
    // What is wrong is said when the pass is resolved for good.
    let mut unheard = Diagnostics::new();
    let tried = is_needed.then(|| resolve(files, form, resolved.clone(), &mut unheard)).flatten();
    let Some(tried) = tried else { return (resolved, Vec::new()) };
    for clock in Clock::ALL {
        if let (Some(found), None) = (tried.model.clocks.get(clock), resolved.model.clocks.get(clock)) {
            // Adopted effects alone need it; its range and unit are those of the data.
            let input = resolved.clock_input(clock);
            resolved.model.inputs[input] = tried.model.inputs[found].clone();
        }
    }
    for input in &mut resolved.model.inputs {
        let tried_input = tried.model.inputs.iter().find(|other| other.name == input.name);
        input.range = input.range.or(tried_input.and_then(|other| other.range));
    }
    (resolved, tried.ranges_from_data)
}

/// The command that brings the pinned data of a study in this folder.
pub fn command(folder: &Path) -> String {
    let shown = folder.display().to_string();
    format!("bmv data get {}", if shown.is_empty() { "." } else { &shown })
}

/// The model's file, also where other parts of the pass are wrong.
fn model_file(merged: &Node) -> Spanned<String> {
    match merged.get("model") {
        Some(Node { value: Value::String(name), place }) => Spanned { value: name.clone(), place: place.clone() },
        Some(_) | None => {
            let start = merged.place.span.start;
            let place = Place { span: Span::new(start, start + 1), ..merged.place.clone() };
            Spanned { value: MODEL.to_owned(), place }
        }
    }
}

fn read_model(folder: &Folder, file: &Spanned<String>, diagnostics: &mut Diagnostics) -> Option<(ResolvedModel, Node)> {
    let bytes = match folder.read(&file.value) {
        Ok(bytes) => bytes,
        Err(error) => {
            diagnostics.push(folder_diagnostic_at(&error, &file.place));
            return None;
        }
    };
    let before = diagnostics.errors();
    let (form, tree) = model::read(&folder.shown_name(&file.value), &bytes, folder, diagnostics)?;
    if diagnostics.errors() > before {
        return None;
    }
    Some((model::resolve(&form, Some(folder), diagnostics)?, tree))
}

fn resolve(files: &Files, form: &PassForm, resolved: ResolvedModel, diagnostics: &mut Diagnostics) -> Option<Pass> {
    let (folder, lineage) = (files.folder, files.lineage);
    let (hosts, starts, given_storage) = (Vec::new(), Vec::new(), Vec::new());
    let (drawn, doubts) = (Vec::new(), Vec::new());
    let mut scope = Scope { folder, resolved, hosts, starts, given_storage, drawn, doubts, diagnostics };
    let seed = seed(&mut scope, form.seed.as_ref());
    check_names(&mut scope, form);
    let (changes, mut priors) = changes::changes(&mut scope, &form.parameters);
    let (catalogue, own_effects) = adopt::catalogue(folder, scope.diagnostics);
    let mut adoption = adopt::adopt(&mut scope, form, &catalogue);
    for entry in &form.quantities {
        quantity(&mut scope, entry);
    }
    let named_quantities = scope.resolved.model.quantities.len();
    let requirements = requirement::requirements(&mut scope, &form.requirements);
    let mut environments = requirement::environments(&mut scope, &form.environments);
    let (mut measurements, mut positions) = (Vec::new(), Vec::new());
    let (mut pinned, mut missing, mut ignored_sensors) = (Vec::new(), Vec::new(), Vec::new());
    for entry in &form.measurements {
        match measurement::measurement(&mut scope, entry, &mut pinned, &mut ignored_sensors) {
            Outcome::Ready(parts) => {
                for part in parts {
                    positions.push((part.name.clone(), Some(measurements.len())));
                    measurements.push(part);
                }
            }
            Outcome::Missing => {
                missing.extend(pinned.last().cloned());
                positions.push((entry.name.clone(), None));
            }
            // An error stands for it: nothing has this position.
            Outcome::Wrong => positions.push((entry.name.clone(), Some(usize::MAX))),
        }
    }
    adoption.adopt_at_sensors(&mut scope, form, &catalogue, &mut measurements);
    adoption.switch_on(&mut measurements, &mut environments);
    set_clocks(&mut scope, &mut measurements, &mut environments);
    priors.extend(adoption.priors.iter().copied());
    let mut upstreams = Upstreams::new(files.reader, files.chain);
    let posterior_priors = posterior_prior::resolve(&mut scope, &mut upstreams, &mut priors);
    let ranges_from_data = ranges_from_data(&mut scope, &measurements);
    let document = document::load(folder, scope.diagnostics);
    let rules = rule::load(Some(folder), scope.diagnostics);
    let profiles = profile::load(Some(folder), form.criteria.iter(), scope.diagnostics);
    let mut own_files = serde_json::Map::new();
    for adopted in &mut adoption.adopted {
        if own_effects.iter().any(|(name, _)| *name == adopted.effect) {
            adopted.file = Some(adopt::own_file(&adopted.effect));
        }
    }
    own_files.extend(own_effects.into_iter().map(|(name, json)| (adopt::own_file(&name), json)));
    own_files.extend(rules.iter().filter_map(|(rule, json)| Some((format!("rules/{}", rule.name), json.clone()?))));
    own_files.extend(
        profiles.iter().filter_map(|(profile, json)| Some((format!("criteria/{}", profile.name), json.clone()?))),
    );
    let surrogate = scope.resolved.surrogate.clone();
    let offered = Offered {
        file: &lineage.files[0].name,
        priors: &priors,
        posterior_priors: &posterior_priors,
        requirements: &requirements,
        environments: &environments,
        measurements: &positions,
        data: &measurements,
        ranges_from_data: &ranges_from_data,
        rules: &rules.into_iter().map(|(rule, _)| rule).collect::<Vec<_>>(),
        profiles: &profiles.into_iter().map(|(profile, _)| profile).collect::<Vec<_>>(),
        design: &form.design,
        surrogate: surrogate.as_ref().map(|surrogate| &surrogate.place),
        named_quantities,
        catalogue: &catalogue,
        command: command(folder.shown()),
    };
    let kinds = &files.reader.kinds;
    let forms = kinds.read(&form.jobs, scope.diagnostics);
    let mut jobs = kinds.resolve(&mut scope, &forms, &offered, &mut upstreams);
    used_twice::check(&mut scope, &jobs, &forms, &measurements, &posterior_priors);
    let mut refused = noise::refused(&scope, &jobs, form, &measurements);
    refused.extend(outside::refused(&scope, kinds, &jobs));
    let measured = form.measurements.iter().next().map(|entry| &entry.name_place);
    kinds.complete(&mut jobs, &forms, &offered, measured);
    physical::check(&mut scope, form, &priors, &environments, &measurements);
    let figures = figure::figures(&mut scope, &form.figures, &offered, &forms);
    if !scope.diagnostics.has_errors() {
        // What is wrong comes first.
        absolute_error::warn(&mut scope, form, &measurements);
        drift::doubts(&mut scope, form, &jobs, &mut measurements);
        for doubt in plausible::said_once(std::mem::take(&mut scope.doubts)) {
            scope.diagnostics.push(doubt);
        }
    }
    let definition_sha256 = definition(files, own_files);
    let groups = group_places(&scope.resolved, &sensor_places(measurements.iter()));
    let ResolvedModel { mut model, reconstructed, input_errors, external, .. } = scope.resolved;
    model.keeps_signs = true;
    let evaluator = external.as_ref().zip(files.reader.lender.as_ref()).map(|(external, lender)| lender.lend(external));
    let surrogate = match surrogate {
        // The model itself is asked for the runs behind the surrogate alone.
        Some(surrogate) => {
            let truth = thermal::External { evaluator, ..surrogate.truth.clone() };
            Some(Arc::new(Surrogate { truth, ..surrogate.as_ref().clone() }))
        }
        None => {
            if let (Some(asked), Some(evaluator)) = (&mut model.external, evaluator) {
                asked.evaluator = Some(evaluator);
            }
            None
        }
    };
    Some(Pass {
        folder: folder.shown().to_owned(),
        file: lineage.files[0].name.clone(),
        parents: lineage.files[1..].iter().map(|file| file.name.clone()).collect(),
        model_file: files.model.0.to_owned(),
        title: form.title.clone().unwrap_or_else(|| model.title.clone()),
        description: form.description.clone().unwrap_or_default(),
        reconstructed,
        document,
        closing: form.closing.as_ref().map(|closing| Closing {
            domain: closing.domain.clone(),
            dispositions: closing.dispositions.iter().map(|own| (own.name.clone(), own.value.clone())).collect(),
            left: closing.left.clone(),
        }),
        figures,
        files: folder.files(),
        definition_sha256,
        seed,
        model,
        external,
        surrogate,
        priors,
        posterior_priors,
        handed_on_depth: upstreams.depth(),
        upstream: upstreams.passes,
        input_errors,
        requirements,
        statements: requirement::statements(&form.requirements),
        environments,
        measurements,
        ignored_sensors,
        jobs,
        groups,
        catalogue: Arc::new(catalogue),
        refused,
        changes,
        adopted: adoption.adopted,
        ranges_from_data,
        pinned,
        missing,
        warnings: Diagnostics::new(),
    })
}

/// Groups as effects see them, and the one that the sensors imply; sensors without a measurement are no members.
fn group_places(model: &ResolvedModel, sensors: &[SensorPlace]) -> Vec<GroupPlace> {
    let place = |group: &Group| GroupPlace { name: group.name.clone(), site: group.members.site(sensors) };
    let mut groups: Vec<GroupPlace> = model.groups.iter().map(place).collect();
    groups.extend(thermometers(&model.model, &groups, sensors));
    groups
}

fn seed(scope: &mut Scope, written: Option<&Spanned<u64>>) -> u64 {
    let Some(seed) = written else { return SEED };
    if seed.value > LARGEST_SEED {
        let message = format!("the seed {} is above 2^53 - 1", seed.value);
        let expected = format!("an integer from 0 to {LARGEST_SEED}");
        scope.error(&code::OUT_OF_RANGE, &seed.place, message, &expected);
    }
    seed.value
}

/// Names of entries: text without control characters, `:` or `/`.
fn check_names(scope: &mut Scope, form: &PassForm) {
    fn names<T>(entries: &crate::document::Map<T>) -> impl Iterator<Item = (&str, &Place)> {
        entries.iter().map(|entry| (entry.name.as_str(), &entry.name_place))
    }
    let all = names(&form.adopt)
        .chain(names(&form.requirements))
        .chain(names(&form.environments))
        .chain(names(&form.measurements))
        .chain(names(&form.jobs))
        .chain(names(&form.quantities))
        .chain(names(&form.criteria));
    for (name, place) in all {
        check_label(name, place, scope.diagnostics);
    }
}

/// A quantity of the pass: it replaces one of the model of the same name.
fn quantity(scope: &mut Scope, entry: &MapEntry<QuantityOrName>) {
    let itself = match &entry.value {
        NameOr::Name(name) | NameOr::Other(QuantityForm::Temperature(name)) => name.value == entry.name,
        NameOr::Other(_) => false,
    };
    if scope.resolved.node(&entry.name).is_some() && !itself {
        let message = format!("the quantity `{}` has the name of a node", entry.name);
        scope.diagnostics.push(
            Diagnostic::error(&code::DUPLICATE_NAME, &entry.name_place, message)
                .help("a node's name alone means its temperature: rename the quantity"),
        );
        return;
    }
    let quantity = model::quantity::resolve(&entry.name, &entry.value, &mut scope.resolved, scope.diagnostics);
    let Some(quantity) = quantity else { return };
    put_quantity(&mut scope.resolved, quantity);
}

fn put_quantity(resolved: &mut ResolvedModel, quantity: Quantity) {
    let dimension = unit_of(&quantity.unit).dimension;
    match resolved.quantity(&quantity.name) {
        Some(index) => {
            resolved.model.quantities[index] = quantity;
            resolved.quantity_dimensions[index] = dimension;
        }
        None => {
            resolved.model.quantities.push(quantity);
            resolved.quantity_dimensions.push(dimension);
        }
    }
}

/// Says when measurements were made, where an adopted effect depends on it; environments have the nominal value.
fn set_clocks(
    scope: &mut Scope,
    measurements: &mut [crate::measurement::Measurement],
    environments: &mut [super::requirement::Environment],
) {
    let model = &mut scope.resolved.model;
    let all = measurements.to_vec();
    for clock in Clock::ALL {
        let Some(input) = model.set_clock(clock, &all, measurements) else { continue };
        for environment in environments.iter_mut() {
            environment.inputs.resize(environment.inputs.len().max(input + 1), 0.0);
            environment.inputs[input] = model.inputs[input].nominal;
        }
    }
}

/// Inputs without a stated range take the data's smallest and largest value.
fn ranges_from_data(scope: &mut Scope, measurements: &[crate::measurement::Measurement]) -> Vec<String> {
    let mut ranges = vec![None; scope.resolved.model.inputs.len()];
    for measurement in measurements {
        measurement::widen_ranges(measurement, &mut ranges);
    }
    let mut names = Vec::new();
    for (input, range) in scope.resolved.model.inputs.iter_mut().zip(ranges) {
        if input.range.is_none() && range.is_some_and(|[lower, upper]: [f64; 2]| lower < upper) {
            input.range = range;
            names.push(input.name.clone());
        }
    }
    names
}

/// SHA-256 of the canonical JSON of the files as written.
fn definition(files: &Files, mut own: serde_json::Map<String, serde_json::Value>) -> String {
    let passes: Vec<serde_json::Value> = files.lineage.files.iter().map(|file| file.tree.to_json()).collect();
    own.insert("passes".to_owned(), serde_json::Value::Array(passes));
    let (model_file, model_tree) = files.model;
    own.insert(model_file.to_owned(), model_tree.to_json());
    // Numbers of a file that was read are finite, so there is always a canonical text.
    sha256_hex(canonical::canonical(&serde_json::Value::Object(own)).unwrap_or_default().as_bytes())
}
