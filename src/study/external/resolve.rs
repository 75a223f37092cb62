//! From a model outside as written to one that can be asked.

use crate::document::hash::sha256_hex;
use crate::document::{Amount, Diagnostic, Diagnostics, Map, Place, Sense, Spanned, code, suggest};
use crate::expression::{Dimension, Unit};
use crate::study::folder::{Folder, FolderError};
use crate::thermal::Derivatives;

use super::command::{self, Command, Input, Program, Separator, Table, Template};
use super::form::{
    CommandForm, CsvFromForm, DerivativesForm, FromForm, InputForm, TemplateForm, UmBridgeForm, UnitsForm,
};
use super::{Calls, External, Given, How, Output, UmBridge};

/// Seconds that a call may take where nothing is said.
const TIMEOUT_S: f64 = 600.0;
/// Seconds that a request to a server may take where nothing is said: models of servers run for ten minutes and more, and a request is
/// not ended by being given up.
const SERVER_TIMEOUT_S: f64 = 3600.0;
/// Longest time of a call: a week.
const LONGEST_S: f64 = 7.0 * 86_400.0;
/// Most repetitions of a call.
const MOST_RETRIES: u64 = 100;
/// Repetitions of a request to a server where nothing is said: it may be starting anew.
const SERVER_RETRIES: u64 = 2;
/// Most calls at a time.
const MOST_AT_ONCE: u64 = 1024;
/// The file of parameters and inputs where nothing is said.
const INPUT: &str = "input.json";

/// A parameter or input, with what is known of it.
#[derive(Clone, Debug)]
pub struct Asked {
    /// What is given.
    pub given: Given,
    /// Step of differences where the study states none, SI.
    pub step: f64,
    /// Whether it is a parameter that is not fixed.
    pub is_uncertain: bool,
}

/// What a model outside is made of beside its own entry.
pub struct Sources<'a> {
    /// The study's folder.
    pub folder: &'a Folder,
    /// All parameters, then all inputs, in the model's order.
    pub asked: &'a [Asked],
    /// How many of these are parameters.
    pub parameters: usize,
}

/// What both kinds state.
struct Common<'f> {
    place: &'f Place,
    units: UnitsForm,
    steps: &'f Map<Amount>,
    derivatives: DerivativesForm,
    timeout: &'f Option<Amount>,
    /// Seconds of a call where nothing is said.
    usual_timeout_s: f64,
    retries: &'f Option<Spanned<u64>>,
    /// Repetitions where nothing is said.
    usual_retries: u64,
    at_once: &'f Option<Spanned<u64>>,
}

fn wrong(place: &Place, message: impl Into<String>, expected: &str, diagnostics: &mut Diagnostics) {
    let diagnostic = Diagnostic::error(&code::EXTERNAL_MODEL, place, message);
    diagnostics.push(if expected.is_empty() { diagnostic } else { diagnostic.expected(expected) });
}

impl Sources<'_> {
    fn find(&self, name: &str) -> Option<usize> {
        self.asked.iter().position(|asked| asked.given.name == name)
    }

    fn known(&self, name: &str, place: &Place, diagnostics: &mut Diagnostics) -> Option<usize> {
        let found = self.find(name);
        if found.is_none() {
            let names = self.asked.iter().map(|asked| asked.given.name.as_str());
            let near = diagnostics.nearest(name, names.clone());
            let diagnostic =
                Diagnostic::error(&code::UNKNOWN_NAME, place, format!("unknown parameter or input `{name}`"))
                    .expected(format!("one of {}", suggest::listed(names, 12)))
                    .suggest(near);
            diagnostics.push(diagnostic);
        }
        found
    }

    /// Texts and the places of the values between them, of a text with `{{NAME}}`.
    fn parts(&self, text: &str, place: &Place, diagnostics: &mut Diagnostics) -> Vec<(String, Option<usize>)> {
        let mut parts = Vec::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once("{{") {
            let Some((name, behind)) = after.split_once("}}") else {
                wrong(place, "`{{` has no `}}` behind it", "{{NAME}} of a parameter or input", diagnostics);
                break;
            };
            parts.push((before.to_owned(), self.known(name.trim(), place, diagnostics)));
            rest = behind;
        }
        parts.push((rest.to_owned(), None));
        parts
    }

    /// A file of the study: its bytes, which are noted as read.
    fn file(&self, path: &Spanned<String>, diagnostics: &mut Diagnostics) -> Option<Vec<u8>> {
        match self.folder.read_table(&path.value) {
            Ok(bytes) => Some(bytes),
            Err(error) => {
                let diagnostic = Diagnostic::error(&code::EXTERNAL_MODEL, &path.place, error.to_string());
                let help = "copy it into the study; a program of the machine is named alone, or by its absolute path, with `version`";
                let leads_out = matches!(error, FolderError::NotPlain { .. } | FolderError::LeadsOut { .. });
                diagnostics.push(if leads_out { diagnostic.help(help) } else { diagnostic });
                None
            }
        }
    }

    /// The model of an entry, whose outputs have units; `how` is what is asked.
    fn external(&self, common: &Common<'_>, outputs: Vec<Output>, how: How, diagnostics: &mut Diagnostics) -> External {
        let mut steps: Vec<f64> = self.asked.iter().map(|asked| asked.step).collect();
        let mut stated = vec![false; steps.len()];
        for entry in common.steps {
            let Some(place) = self.known(&entry.name, &entry.name_place, diagnostics) else { continue };
            let unit = self.asked[place].given.unit.as_ref();
            let dimension = unit.map_or(Dimension::NONE, |unit| unit.dimension);
            let Some(step) = entry.value.si(dimension, unit, Sense::Difference, diagnostics) else { continue };
            if !(step > 0.0 && step.is_finite()) {
                wrong(&entry.place, format!("a step of {step}"), "a number above 0", diagnostics);
            }
            (steps[place], stated[place]) = (step, true);
        }
        let states_steps = self.asked.iter().zip(&stated).all(|(asked, stated)| *stated || !asked.is_uncertain);
        let derivatives = match common.derivatives {
            DerivativesForm::Served => Derivatives::Served,
            DerivativesForm::Differences if states_steps => Derivatives::StatedSteps,
            DerivativesForm::Differences => Derivatives::UsualSteps,
        };
        if let (Derivatives::Served, Some(entry)) = (derivatives, common.steps.iter().next()) {
            let message = "steps of differences beside derivatives that are served";
            wrong(&entry.name_place, message, "one of `steps` and \"derivatives\": \"served\"", diagnostics);
        }
        let mut limited = |written: &Option<Spanned<u64>>, least: u64, most: u64, what: &str| {
            let written = written.as_ref()?;
            if !(least..=most).contains(&written.value) {
                let expected = format!("an integer from {least} to {most}");
                wrong(&written.place, format!("{} {what}", written.value), &expected, diagnostics);
            }
            Some(written.value)
        };
        let retries = limited(common.retries, 0, MOST_RETRIES, "repetitions").unwrap_or(common.usual_retries);
        let at_once = limited(common.at_once, 1, MOST_AT_ONCE, "calls at a time");
        let mut timeout_s = common.usual_timeout_s;
        if let Some(amount) = common.timeout
            && let Some(seconds) = amount.si(Dimension::TIME, None, Sense::Difference, diagnostics)
        {
            if !(seconds > 0.0 && seconds <= LONGEST_S) {
                wrong(
                    &amount.place,
                    format!("a timeout of {seconds} s"),
                    "a time above 0, at most a week",
                    diagnostics,
                );
            }
            timeout_s = seconds.clamp(0.0, LONGEST_S);
        }
        let position = common.place.position();
        External {
            place: format!("{}:{}:{}", common.place.source.name(), position.line, position.column),
            given: self.asked.iter().map(|asked| asked.given.clone()).collect(),
            parameters: self.parameters,
            outputs,
            is_si: common.units == UnitsForm::Si,
            steps,
            derivatives,
            calls: Calls { timeout_s, retries, at_once },
            how,
        }
    }
}

/// A program as written.
pub fn command(form: &Spanned<CommandForm>, sources: &Sources<'_>, diagnostics: &mut Diagnostics) -> Option<External> {
    let before = diagnostics.errors();
    let Spanned { value: form, place } = form;
    let Some((first, arguments)) = form.run.value.split_first().filter(|(first, _)| !first.value.is_empty()) else {
        wrong(&form.run.place, "there is nothing to run", "[\"PROGRAM\", \"ARGUMENT\", ...]", diagnostics);
        return None;
    };
    let is_outside = first.value.starts_with('/') || !first.value.contains('/');
    let program = if is_outside {
        if form.version.is_none() {
            let message = format!("`{}` is no file of the study, and no `version` stands for it", first.value);
            let help = format!(
                "write \"version\": \"...\", which is changed when the program changes; a program of the study is named by its \
                 path with a `/`: \"./{}\"",
                first.value.rsplit('/').next().unwrap_or_default()
            );
            diagnostics.push(Diagnostic::error(&code::EXTERNAL_MODEL, &first.place, message).help(help));
        }
        Program::Outside(first.value.clone())
    } else {
        let path = first.value.trim_start_matches("./").to_owned();
        let named = Spanned { value: path.clone(), place: first.place.clone() };
        Program::Inside(path, sha256_hex(&sources.file(&named, diagnostics).unwrap_or_default()))
    };
    let files = form.files.iter().filter_map(|file| {
        let bytes = sources.file(file, diagnostics)?;
        Some((file.value.clone(), sha256_hex(&bytes)))
    });
    let files: Vec<(String, String)> = files.collect();
    let arguments =
        arguments.iter().map(|argument| sources.parts(&argument.value, &argument.place, diagnostics)).collect();
    let input = input(form.input.as_ref(), sources, &files, diagnostics);
    let (mut outputs, mut places) = (Vec::new(), Vec::new());
    for entry in &form.outputs {
        outputs.push(Output { name: entry.name.clone(), unit: entry.value.unit.unit.clone() });
        let (file, found) = match &entry.value.from {
            FromForm::Json(from) => {
                if !from.pointer.value.is_empty() && !from.pointer.value.starts_with('/') {
                    let message = format!("the pointer `{}` does not begin with `/`", from.pointer.value);
                    wrong(&from.pointer.place, message, "a JSON pointer, such as \"/nodes/plate\"", diagnostics);
                }
                (&from.file, command::Place::Json(from.pointer.value.clone()))
            }
            FromForm::Csv(from) => (&from.file, command::Place::Csv(table(from, diagnostics))),
        };
        if let Some(file) = file {
            own_name(file, sources.folder, diagnostics);
        }
        places.push((file.as_ref().map(|file| file.value.clone()), found));
    }
    let exit_codes = match &form.exit_codes {
        None => vec![0],
        Some(codes) => {
            if codes.value.is_empty() {
                let message = "with no exit code at all no call succeeds".to_owned();
                wrong(&codes.place, message, "the exit codes of a call that succeeded, such as [0]", diagnostics);
            }
            let codes = &codes.value;
            for code in codes.iter().filter(|code| code.value > 255) {
                wrong(&code.place, format!("an exit code of {}", code.value), "a number from 0 to 255", diagnostics);
            }
            codes.iter().map(|code| code.value).collect()
        }
    };
    let command = Command {
        folder: sources.folder.root().to_owned(),
        program,
        version: form.version.as_ref().map(|version| version.value.clone()),
        arguments,
        files,
        input,
        outputs: places,
        exit_codes,
    };
    let common = Common {
        place,
        units: form.units,
        steps: &form.steps,
        derivatives: DerivativesForm::Differences,
        timeout: &form.timeout,
        usual_timeout_s: TIMEOUT_S,
        retries: &form.retries,
        usual_retries: 0,
        at_once: &form.at_once,
    };
    let external = sources.external(&common, outputs, How::Command(command), diagnostics);
    (diagnostics.errors() == before).then_some(external)
}

fn input(
    form: Option<&InputForm>,
    sources: &Sources<'_>,
    files: &[(String, String)],
    diagnostics: &mut Diagnostics,
) -> Input {
    let checked = |name: &Spanned<String>, diagnostics: &mut Diagnostics| {
        own_name(name, sources.folder, diagnostics);
        if files.iter().any(|(file, _)| *file == name.value) {
            let message = format!("`{}` is a file of the study that the program reads", name.value);
            wrong(&name.place, message, "another name: nothing is written through to the study", diagnostics);
        }
    };
    match form {
        None => Input::Json(INPUT.to_owned()),
        Some(InputForm::Json(name)) => {
            checked(name, diagnostics);
            Input::Json(name.value.clone())
        }
        Some(InputForm::Environment(prefix)) => {
            let text = format!("{}x", prefix.value);
            let is_name = text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
                && !text.starts_with(|c: char| c.is_ascii_digit());
            if !is_name || prefix.value.is_empty() {
                let message = format!("the prefix `{}` does not begin the name of a variable", prefix.value);
                wrong(&prefix.place, message, "letters, digits and underscores, such as \"MODEL_\"", diagnostics);
            }
            let names = sources.asked.iter().map(|asked| format!("{}{}", prefix.value, asked.given.name));
            Input::Environment(names.collect())
        }
        Some(InputForm::Templates(templates)) => {
            let made = templates.iter().filter_map(|TemplateForm { file, name }| {
                checked(name, diagnostics);
                let bytes = sources.file(file, diagnostics)?;
                let Ok(text) = String::from_utf8(bytes) else {
                    wrong(&file.place, format!("`{}` is no UTF-8 text", file.value), "a text file", diagnostics);
                    return None;
                };
                let parts = sources.parts(&text, &file.place, diagnostics);
                Some(Template { name: name.value.clone(), parts })
            });
            Input::Templates(made.collect())
        }
    }
}

/// Checks the name of a file in the folder in which the program runs: it does not leave that folder.
fn own_name(name: &Spanned<String>, folder: &Folder, diagnostics: &mut Diagnostics) {
    if let Err(FolderError::NotPlain { path }) = folder.place(&name.value) {
        let message = format!("the path `{path}` leaves the folder in which the program runs");
        wrong(&name.place, message, "a plain path below it, without `..`", diagnostics);
    }
}

fn table(form: &CsvFromForm, diagnostics: &mut Diagnostics) -> Table {
    if let Some(row) = form.row.as_ref().filter(|row| row.value == 0) {
        wrong(&row.place, "row 0", "a number from 1; the last row where it is left out", diagnostics);
    }
    let separator = match form.separator.as_ref().map(|separator| (separator, separator.value.as_str())) {
        None => Separator::Character(','),
        Some((_, "tab")) => Separator::Character('\t'),
        Some((_, "blanks")) => Separator::Blanks,
        Some((written, text)) => {
            let mut characters = text.chars();
            match (characters.next(), characters.next()) {
                (Some(character), None) => Separator::Character(character),
                _ => {
                    wrong(
                        &written.place,
                        format!("the separator {text:?}"),
                        "a character, `tab` or `blanks`",
                        diagnostics,
                    );
                    Separator::Blanks
                }
            }
        }
    };
    Table {
        column: form.column.value.clone(),
        row: form.row.as_ref().map(|row| row.value),
        condition: form.condition.iter().map(|entry| (entry.name.clone(), entry.value.value.clone())).collect(),
        separator,
        skip: form.skip,
        header: form.header,
    }
}

/// A server as written.
pub fn umbridge(
    form: &Spanned<UmBridgeForm>,
    sources: &Sources<'_>,
    diagnostics: &mut Diagnostics,
) -> Option<External> {
    let before = diagnostics.errors();
    let Spanned { value: form, place } = form;
    let Some((host, path)) = address(&form.url.value) else {
        let message = format!("`{}` is no address that can be asked", form.url.value);
        wrong(&form.url.place, message, "an address such as \"http://127.0.0.1:4242\", without TLS", diagnostics);
        return None;
    };
    let all = sources.asked.len();
    let mut inputs = Vec::new();
    match &form.inputs {
        None => {
            inputs = vec![(0..sources.parameters).collect(), (sources.parameters..all).collect()];
            inputs.retain(|vector: &Vec<usize>| !vector.is_empty());
        }
        Some(vectors) => {
            for vector in vectors {
                let known = |name: &Spanned<String>| sources.known(&name.value, &name.place, diagnostics);
                inputs.push(vector.value.iter().filter_map(known).collect());
            }
            let missing = (0..all).find(|place| !inputs.iter().flatten().any(|given| given == place));
            if let (Some(missing), Some(first)) = (missing, vectors.first()) {
                let message = format!("`{}` is in none of the vectors", sources.asked[missing].given.name);
                wrong(&first.place, message, "every parameter and input of the model", diagnostics);
            }
        }
    }
    let (mut outputs, mut places) = (Vec::new(), Vec::new());
    for (order, entry) in form.outputs.iter().enumerate() {
        outputs.push(Output { name: entry.name.clone(), unit: entry.value.unit.unit.clone() });
        places.push(match &entry.value.at {
            None => [0, order],
            Some(at) => at.value.map(|place| usize::try_from(place).unwrap_or(usize::MAX)),
        });
    }
    let model = UmBridge {
        host,
        path,
        name: form.name.value.clone(),
        version: form.version.value.clone(),
        inputs,
        outputs: places,
        config: form.config.as_ref().map_or_else(|| serde_json::json!({}), crate::document::Node::to_json),
    };
    let common = Common {
        place,
        units: form.units,
        steps: &form.steps,
        derivatives: form.derivatives,
        timeout: &form.timeout,
        usual_timeout_s: SERVER_TIMEOUT_S,
        retries: &form.retries,
        usual_retries: SERVER_RETRIES,
        at_once: &form.at_once,
    };
    let external = sources.external(&common, outputs, How::UmBridge(model), diagnostics);
    (diagnostics.errors() == before).then_some(external)
}

/// Host with port, and path, of an address.
fn address(url: &str) -> Option<(String, String)> {
    let rest = url.strip_prefix("http://")?;
    let (host, path) = rest.split_once('/').map_or((rest, String::new()), |(host, path)| (host, format!("/{path}")));
    let plain = |text: &str| text.chars().all(|c| c.is_ascii_graphic() && !matches!(c, '@' | '?' | '#' | '\\'));
    let port = host.rsplit_once(':').map(|(_, port)| port);
    let has_port = port.is_some_and(|port| port.parse::<u16>().is_ok_and(|port| port > 0));
    let host = if has_port { host.to_owned() } else { format!("{host}:80") };
    let is_host = plain(&host) && !host.starts_with(':') && (has_port || port.is_none() || host.starts_with('['));
    (is_host && plain(&path)).then(|| (host, path.trim_end_matches('/').to_owned()))
}

/// The unit of an output for people, and whether it is an absolute temperature.
impl Output {
    /// SI unit of its value.
    pub fn si_unit(&self) -> String {
        if self.unit.has_offset() { "K".to_owned() } else { Unit::si(self.unit.dimension).text }
    }
}
