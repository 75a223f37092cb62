//! `bmv import csv`.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::Context;
use super::import::read;
use super::output::{escaped, print, print_json, shown, tell};
use super::status::{Failure, Status};
use crate::document::visible::shell_word;
use crate::import::logger::{self, Known, Settings, propose};
use crate::study::discover;

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
                  channels.csv has a line a channel, of which `unit` and `measures` may be left out:\n  \
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
    /// Print one JSON document
    #[arg(long)]
    json: bool,
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
        let before = discover::passes(&self.into).into_iter().max_by_key(|pass| discover::number(pass));
        let pass =
            before.as_ref().map(|pass| crate::study::load(&crate::job::kinds(), pass)).transpose().map_err(wrong)?;
        let known = pass.as_ref().map_or_else(Known::default, |pass| {
            let nodes = pass.model.nodes.iter().map(|node| node.name.clone());
            let quantities = pass.model.quantities.iter().map(|quantity| quantity.name.clone());
            Known {
                measured: nodes.chain(quantities).collect(),
                inputs: pass.model.inputs.iter().map(|input| input.name.clone()).collect(),
            }
        });
        let name = self.name.as_str();
        let file = format!("data/{name}.csv");
        let proposal = propose(&record, &known, &file);
        fs::create_dir_all(self.into.join("data")).map_err(|error| failed(&self.into, &error))?;
        write_new(&self.into.join(&file), &proposal.csv)?;
        let mut said = proposal.in_words(&record);
        said.push_str(&format!("Made {}\n", shown(&self.into.join(&file))));
        let mut written = None;
        if let Some(before) = before.as_deref().filter(|_| !proposal.sensors.is_empty()) {
            let next = next_pass(&self.into, before, name, &proposal.measurement)?;
            let command = format!("bmv compare {}", escaped(&shell_word(&next.display().to_string())));
            said.push_str(&format!("Made {}; now look through it, then try\n{command}\n", shown(&next)));
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
        if self.json {
            print_json(&json!({
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
}

/// The next free pass: that of the highest number so far as its parent, with the measurement.
fn next_pass(study: &Path, before: &Path, name: &str, measurement: &Value) -> Result<PathBuf, Failure> {
    let number = discover::number(before).unwrap_or(0) + 1;
    let pass = study.join(format!("pass-{number}.json"));
    let parent = before.file_name().map(|file| file.to_string_lossy().into_owned());
    let text = json!({
        "format": "bmv-pass/1",
        "title": format!("Pass {number}: the model against {name}"),
        "parent": parent,
        "measurements": {name: measurement},
        "jobs": {"delivered": {"compare": {"data": [name]}}, "missing": {"diagnose": {"data": [name]}}},
    });
    let text = serde_json::to_string_pretty(&text).map_err(|error| Failure::input(error.to_string()))? + "\n";
    write_new(&pass, &text)?;
    Ok(pass)
}

/// Writes a file that is not there yet.
fn write_new(path: &Path, text: &str) -> Result<(), Failure> {
    let mut file = fs::File::create_new(path).map_err(|error| failed(path, &error))?;
    file.write_all(text.as_bytes()).map_err(|error| failed(path, &error))
}

fn failed(path: &Path, error: &std::io::Error) -> Failure {
    let help = if error.kind() == std::io::ErrorKind::AlreadyExists { "; --name NAME writes another" } else { "" };
    Failure::input(format!("cannot write `{}`: {error}{help}", shown(path)))
}
