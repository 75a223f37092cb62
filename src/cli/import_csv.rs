//! `bmv import csv`.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::Context;
use super::import::read;
use super::output::{escaped, print, print_json, shown, tell};
use super::status::{Failure, Status};
use crate::document::visible::shell_word;
use crate::expression::Symbol;
use crate::import::logger::{self, Known, MapTemplate, Said, Settings, map_template, propose};
use crate::job::calibrate::{MANY_DRAWS, Sampler};
use crate::study::file::{self, Existing};
use crate::study::job::CALIBRATION;
use crate::study::{Pass, discover};
use crate::thermal::{Model, Node, NodeKind};

/// Diagnostics printed of logs that are not understood.
const MOST_DIAGNOSTICS: usize = 20;

/// Arguments of `bmv import csv`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "The files together are one record: a header, perhaps lines before it and a row of units below it, then a \
                  row an instant. Separators are ; tab | or , and decimals have a point or a comma. Times are ISO 8601, \
                  17.05.2024 12:30:00, seconds since 1970, or counted from the start.\n\n\
                  Written are STUDY/data/NAME.csv and, where STUDY has a pass, the next free pass with the sensors and \
                  inputs that are named like its model's; else the measurement is printed.\n\n\
                  Examples:\n  \
                  bmv import csv log-1.csv log-2.csv --into my-study\n  \
                  bmv import csv log.csv --into my-study --channels channels.csv\n\n\
                  channels.csv has a line for each channel that is not named like a node, a quantity or an input; `unit` and `measures` may be left out:\n  \
                  channel,name,unit,measures\n  \
                  Kanal 1,TC1,degC,box"
)]
pub(super) struct Csv {
    /// Files of the logger
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Folder of the study
    #[arg(long, value_name = "STUDY")]
    into: PathBuf,
    /// Name of the measurement
    #[arg(long, default_value = "log")]
    name: String,
    /// CSV file of what the channels are called and what they measure
    #[arg(long, value_name = "FILE")]
    channels: Option<PathBuf>,
    /// Header of the column that holds the time
    #[arg(long, value_name = "HEADER")]
    time: Option<String>,
    /// An input that moves in steps: its value holds until the next row; may be given several times
    #[arg(long, value_name = "INPUT")]
    hold: Vec<String>,
    /// An input that moves steadily: its value is linear between rows; may be given several times
    #[arg(long, value_name = "INPUT")]
    linear: Vec<String>,
    /// A channel whose readings all stay, though they look dead; may be given several times
    #[arg(long, value_name = "CHANNEL")]
    keep: Vec<String>,
    /// Write the measurement anew where an earlier import wrote it: its file, and the pass as far as nothing was added to it
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// Boundary nodes whose temperature is an input: names of both.
fn boundaries(model: &Model) -> Vec<(String, String)> {
    let input = |node: &Node| {
        let NodeKind::Boundary { temperature } = node.kind else { return None };
        match model.graph.symbols(temperature).into_iter().collect::<Vec<_>>().as_slice() {
            [Symbol::Input(index)] => model.inputs.get(*index as usize),
            _ => None,
        }
    };
    model.nodes.iter().filter_map(|node| Some((node.name.clone(), input(node)?.name.clone()))).collect()
}

/// How many parameters a calibration of a pass infers; none of a program in place of a network, whose runs may be costly.
fn uncertain_parameters(pass: &Pass) -> usize {
    let inferred = pass.priors.iter().filter(|prior| !prior.is_fixed());
    if pass.external.is_some() { 0 } else { inferred.count() }
}

impl Csv {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
        if self.name.is_empty() || !self.name.chars().all(is_plain) {
            let name = escaped(&self.name);
            return Err(Failure::input(format!("`{name}` cannot name a file: write letters, digits, - and _")));
        }
        let text = |path: &PathBuf| read(path).map(|file| (file.name.clone(), file.text()));
        let files = self.files.iter().map(text).collect::<Result<Vec<_>, _>>()?;
        let channels = self.channels.as_ref().map(text).transpose()?;
        let wrong = |diagnostics: crate::document::Diagnostics| {
            Failure::rendered(diagnostics.render(context.coloured, MOST_DIAGNOSTICS))
        };
        let record = logger::read(&files, &Settings { time: self.time.clone(), channels }).map_err(wrong)?;
        let passes = discover::passes(&self.into);
        let last = passes.iter().max_by_key(|pass| discover::number(pass));
        // The pass of an earlier import of this measurement is no parent of the one that takes its place.
        let earlier = last.filter(|pass| self.is_of_import(pass));
        let others = passes.iter().filter(|pass| Some(*pass) != earlier);
        let before = others.max_by_key(|pass| discover::number(pass)).cloned();
        let pass =
            before.as_ref().map(|pass| crate::study::load(&crate::job::kinds(), pass)).transpose().map_err(wrong)?;
        let known = pass.as_ref().map_or_else(Known::default, |pass| {
            let mut measured: Vec<String> = pass.model.nodes.iter().map(|node| node.name.clone()).collect();
            // What is required of a node is a quantity of its name.
            let others = pass.model.quantities.iter().map(|quantity| &quantity.name);
            let others: Vec<String> = others.filter(|name| !measured.contains(name)).cloned().collect();
            measured.extend(others);
            Known {
                measured,
                inputs: pass.model.inputs.iter().map(|input| input.name.clone()).collect(),
                units: pass.model.inputs.iter().map(|input| input.unit.clone()).collect(),
                boundaries: boundaries(&pass.model),
            }
        });
        let name = self.name.as_str();
        let file = format!("data/{name}.csv");
        let said = Said { held: self.hold.clone(), linear: self.linear.clone(), kept: self.keep.clone() };
        let proposal = propose(&record, &known, &said, &file).map_err(Failure::input)?;
        let mut said = proposal.in_words(&record);
        let is_mapped = self.channels.is_some() || known == Known::default() || !proposal.has_unknown;
        let template = (!is_mapped).then(|| map_template(&record, &known));
        if let Some(template) = template.as_ref().filter(|_| proposal.sensors.is_empty()) {
            said.push_str(&format!(
                "Nothing was written: no channel is named like a node or a quantity.\n{}",
                self.next_step(template, false)
            ));
            if self.json {
                print_json(&json!({"file": null, "pass": null, "notes": proposal.notes, "channels": template.csv}))?;
            } else {
                print(&said)?;
            }
            return Ok(Status::Done);
        }
        let became = self.write(Path::new(&file), &proposal.csv)?;
        said.push_str(&format!("{became} {}\n", shown(&self.into.join(&file))));
        let mut written = None;
        if let Some(before) = before.as_deref().filter(|_| !proposal.sensors.is_empty()) {
            let unknown = pass.as_ref().map_or(0, uncertain_parameters);
            let is_tuned = proposal.can_tune(record.times_s.len(), unknown);
            let (next, became) = self.next_pass(before, &proposal.measurement, is_tuned)?;
            let command = format!("bmv compare {}", escaped(&shell_word(&next.display().to_string())));
            // Where channels are still to be mapped, that goes first: one next step.
            said.push_str(&match &template {
                None => format!("{became} {}; now look through it, then try\n{command}\n", shown(&next)),
                Some(_) => format!(
                    "{became} {}, without the channels that are named like nothing of the model\n",
                    shown(&next)
                ),
            });
            // Loaded as any pass is: what a model knows of its inputs is checked there.
            let loaded = crate::study::load(&crate::job::kinds(), &next).map_err(|diagnostics| {
                let report = diagnostics.render(context.coloured, MOST_DIAGNOSTICS);
                let pass = shown(&next);
                Failure::rendered(format!("{report}\n{pass} was written, but is no pass yet: mend these places"))
            })?;
            if !loaded.warnings.is_empty() {
                tell(&loaded.warnings.render(context.coloured, MOST_DIAGNOSTICS));
            }
            written = Some(next);
        } else {
            let measurement = json!({"measurements": {name: proposal.measurement}});
            let measurement = serde_json::to_string_pretty(&measurement).unwrap_or_default();
            said.push_str(&format!("No pass was written; to be put into one:\n{measurement}\n"));
        }
        said.push_str(&template.as_ref().map_or_else(String::new, |template| self.next_step(template, true)));
        if self.json {
            print_json(&json!({
                "channels": template.map(|template| template.csv),
                "file": file,
                "pass": written.map(|pass| pass.display().to_string()),
                "measurements": {name: proposal.measurement},
                "sensors": proposal.sensors,
                "inputs": proposal.inputs,
                "notes": proposal.notes,
            }))?;
        } else {
            print(&said)?;
        }
        Ok(Status::Done)
    }

    /// A map of the channels to begin with, and the command that reads it.
    fn next_step(&self, template: &MapTemplate, is_written: bool) -> String {
        let shown_word = |path: &PathBuf| escaped(&shell_word(&path.display().to_string()));
        let files: Vec<String> = self.files.iter().map(shown_word).collect();
        let name = if self.name == "log" { String::new() } else { format!(" --name {}", self.name) };
        let force = if is_written { " --force" } else { "" };
        let without = match template.without_channel.as_str() {
            "" => String::new(),
            names => format!("without a channel so far: {}\n", escaped(names)),
        };
        let (what, only) = match template.is_of_some {
            true => ("the other channels", " (the channels that are named like what they are need no line)"),
            false => ("the channels", ""),
        };
        format!(
            "Say what {what} are: write these lines to channels.csv{only}, mend what was guessed by name (`name` is an input, or \
             the sensor's name with what it `measures`; a line without a name leaves its channel out), then\n\
             bmv import csv {} --into {}{name} --channels channels.csv{force}\n{without}\n{}",
            files.join(" "),
            shown_word(&self.into),
            crate::document::visible::escaped_lines(&template.csv)
        )
    }

    /// Title of the pass that takes a measurement up.
    fn title(&self, number: u64) -> String {
        format!("Pass {number}: the model against {}", self.name)
    }

    /// Whether a pass is one that an import of this measurement wrote, and nothing was added to it.
    fn is_of_import(&self, pass: &Path) -> bool {
        let text = fs::read_to_string(pass).unwrap_or_default();
        let written: Value = serde_json::from_str(&text).unwrap_or_default();
        let Some(parent) = written["parent"].as_str() else { return false };
        let (number, measurement) = (discover::number(pass).unwrap_or(0), &written["measurements"][&self.name]);
        // Whether it calibrates depends on the log of that time.
        [true, false].into_iter().any(|is_tuned| self.pass(number, parent, measurement, is_tuned) == written)
    }

    /// A pass with the measurement, which holds the model against it as delivered and, where it can be tuned, as tuned without
    /// new physics: by the sampler that takes one likelihood a draw, which finds the best fit at little cost.
    fn pass(&self, number: u64, parent: &str, measurement: &Value, is_tuned: bool) -> Value {
        let name = self.name.as_str();
        let mut jobs = json!({"delivered": {"compare": {"data": [name]}}, "missing": {"diagnose": {"data": [name]}}});
        if is_tuned {
            let sampler = Sampler::IndependenceMetropolis.name();
            jobs["tuned"] = json!({CALIBRATION: {"data": [name], "sampler": sampler, "draws": MANY_DRAWS}});
        }
        json!({
            "format": "bmv-pass/1",
            "title": self.title(number),
            "parent": parent,
            "measurements": {name: measurement},
            "jobs": jobs,
        })
    }

    /// Writes the next free pass: that of the highest number so far as its parent, with the measurement.
    fn next_pass(
        &self,
        before: &Path,
        measurement: &Value,
        is_tuned: bool,
    ) -> Result<(PathBuf, &'static str), Failure> {
        let number = discover::number(before).unwrap_or(0) + 1;
        let file = format!("pass-{number}.json");
        let parent = before.file_name().map(|file| file.to_string_lossy().into_owned()).unwrap_or_default();
        let pass = self.pass(number, &parent, measurement, is_tuned);
        let text = serde_json::to_string_pretty(&pass).map_err(|error| Failure::input(error.to_string()))? + "\n";
        let became = self.write(Path::new(&file), &text)?;
        Ok((self.into.join(file), became))
    }

    /// Writes a file below the study, unless it is there with other content and the user does not say --force. What became
    /// of it: `Made`, `Replaced` or `Unchanged`.
    fn write(&self, relative: &Path, text: &str) -> Result<&'static str, Failure> {
        let path = self.into.join(relative);
        let there = path.symlink_metadata().is_ok();
        if there && fs::read(&path).is_ok_and(|bytes| bytes == text.as_bytes()) {
            return Ok("Unchanged:");
        }
        if there && !self.force {
            return Err(Failure::input(format!(
                "`{}` is there already with other content, from an earlier import or of your own; --force writes it anew, \
                 --name NAME keeps it and writes another",
                shown(&path)
            )));
        }
        file::write(&self.into, relative, text.as_bytes(), Existing::Replace)
            .map_err(|error| Failure::input(format!("cannot write `{}`: {error}", shown(&path))))?;
        Ok(if there { "Replaced" } else { "Made" })
    }
}
