//! A program that answers for a model.

use std::path::PathBuf;

use serde_json::{Value, json};

/// The program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Program {
    /// A file of the study, by its path there, with the SHA-256 of its bytes.
    Inside(String, String),
    /// One of the machine: its name on PATH, or its absolute path.
    Outside(String),
}

/// A file made of a template.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Template {
    /// Name of the file that the program reads.
    pub name: String,
    /// The template: texts and, after each but the last, the place of a value among what is given.
    pub parts: Vec<(String, Option<usize>)>,
}

/// How the program is given parameters and inputs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Input {
    /// As an object in a JSON file.
    Json(String),
    /// As variables of its environment: the name of each.
    Environment(Vec<String>),
    /// As files made of templates.
    Templates(Vec<Template>),
}

/// What separates the cells of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// A character.
    Character(char),
    /// Any number of blanks.
    Blanks,
}

/// Where in a table a number stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// The column, by its header or its number from 1.
    pub column: String,
    /// The row, from 1.
    pub row: Option<u64>,
    /// Columns with the texts that the row has in them.
    pub condition: Vec<(String, String)>,
    /// What separates cells.
    pub separator: Separator,
    /// Lines left out at the beginning.
    pub skip: u64,
    /// Whether a line of headers follows.
    pub header: bool,
}

/// Where an output stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// At a pointer into JSON.
    Json(String),
    /// In a table.
    Csv(Table),
}

/// A program that answers for a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Command {
    /// The study's folder, links resolved.
    pub folder: PathBuf,
    /// The program.
    pub program: Program,
    /// What stands for the bytes of a program that is none of the study's.
    pub version: Option<String>,
    /// Its arguments, in which values may stand.
    pub arguments: Vec<Vec<(String, Option<usize>)>>,
    /// Files of the study that it reads, with the SHA-256 of their bytes.
    pub files: Vec<(String, String)>,
    /// How it is given parameters and inputs.
    pub input: Input,
    /// Where each output stands: the file, or `None` for the standard output.
    pub outputs: Vec<(Option<String>, Place)>,
    /// Exit codes of a call that succeeded.
    pub exit_codes: Vec<u64>,
}

impl Command {
    /// What of it decides a result.
    pub(super) fn identity(&self) -> Value {
        let program = match &self.program {
            Program::Inside(path, sha256) => json!({"file": path, "sha256": sha256}),
            Program::Outside(name) => json!({"name": name}),
        };
        let input = match &self.input {
            Input::Json(name) => json!({"json": name}),
            Input::Environment(names) => json!({"environment": names}),
            Input::Templates(templates) => {
                templates.iter().map(|template| json!([template.name, template.parts])).collect()
            }
        };
        let outputs: Vec<Value> = (self.outputs.iter())
            .map(|(file, place)| match place {
                Place::Json(pointer) => json!([file, pointer]),
                Place::Csv(table) => {
                    let separator = match table.separator {
                        Separator::Character(character) => character.to_string(),
                        Separator::Blanks => "blanks".to_owned(),
                    };
                    json!([file, table.column, table.row, table.condition, separator, table.skip, table.header])
                }
            })
            .collect();
        json!({
            "program": program,
            "version": self.version,
            "arguments": self.arguments,
            "files": self.files,
            "input": input,
            "outputs": outputs,
            "exit_codes": self.exit_codes,
        })
    }

    /// What is run, for people: values by their placeholders.
    pub fn shown(&self, names: &[String]) -> String {
        let program = match &self.program {
            Program::Inside(path, _) => path,
            Program::Outside(name) => name,
        };
        let name = |place: &Option<usize>| {
            place.and_then(|place| names.get(place)).map_or_else(String::new, |name| format!("{{{{{name}}}}}"))
        };
        let argument = |parts: &Vec<(String, Option<usize>)>| -> String {
            parts.iter().map(|(text, place)| format!("{text}{}", name(place))).collect()
        };
        let words = std::iter::once(program.clone()).chain(self.arguments.iter().map(argument));
        words.collect::<Vec<_>>().join(" ")
    }
}
