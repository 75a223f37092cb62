//! A model outside the program as written.

use crate::document::{Amount, Map, Node, Spanned, WrittenUnit, written_choice, written_struct, written_words};

written_struct! {
    /// A program that gives outputs for parameters and inputs. It runs in an empty folder of its own, once a point.
    pub struct CommandForm: "a command" {
        /// The program, then its arguments, in which `{{NAME}}` stands for the value of a parameter or input. A program of the study is
        /// named by its path with a `/`; one of the machine alone (found on PATH) or by its absolute path.
        required run: Spanned<Vec<Spanned<String>>>,
        /// What stands for the bytes of a program that is none of the study's.
        optional version: Spanned<String>,
        /// Files of the study that the program reads; they lie under the same paths in the folder in which it runs.
        default(Vec::new()) files: Vec<Spanned<String>>,
        /// How the program is given parameters and inputs; as JSON in `input.json` where it is left out.
        optional input: InputForm,
        /// What it gives.
        required outputs: Map<CommandOutputForm>,
        /// In which units numbers are exchanged.
        default(UnitsForm::AsWritten) units: UnitsForm,
        /// Steps of finite differences, by parameter or input, in its unit.
        default(Map::default()) steps: Map<Amount>,
        /// How long a call may take (10 minutes).
        optional timeout: Amount,
        /// How often a call that failed is tried again (0).
        optional retries: Spanned<u64>,
        /// Exit codes of a call that succeeded ([0]).
        optional exit_codes: Spanned<Vec<Spanned<u64>>>,
        /// Calls at a time (as many as the run has threads).
        optional at_once: Spanned<u64>,
    }
}

written_choice! {
    /// How a program is given parameters and inputs.
    pub enum InputForm: "an input" {
        /// As an object `{"NAME": value}` in the JSON file of this name.
        "json" => Json(Spanned<String>),
        /// As variables of its environment, named by this prefix and the parameter or input.
        "environment" => Environment(Spanned<String>),
        /// As files made of templates in which `{{NAME}}` stands for a value.
        "templates" => Templates(Vec<TemplateForm>),
    }
}

written_struct! {
    /// A file made of a template.
    pub struct TemplateForm: "a template" {
        /// The template, a file of the study.
        required file: Spanned<String>,
        /// Name of the file that the program reads.
        required name as "as": Spanned<String>,
    }
}

written_struct! {
    /// An output of a program.
    pub struct CommandOutputForm: "an output" {
        /// The unit of its number.
        required unit: WrittenUnit,
        /// Where it stands.
        required from: FromForm,
    }
}

written_choice! {
    /// Where an output stands.
    pub enum FromForm: "a place of an output" {
        /// In JSON.
        "json" => Json(JsonFromForm),
        /// In a table.
        "csv" => Csv(CsvFromForm),
    }
}

written_struct! {
    /// A number in JSON.
    pub struct JsonFromForm: "a place in JSON" {
        /// The file that the program writes; its standard output where it is left out.
        optional file: Spanned<String>,
        /// Where in it (RFC 6901), such as `/nodes/plate/0`.
        required pointer: Spanned<String>,
    }
}

written_struct! {
    /// A number in a table.
    pub struct CsvFromForm: "a place in a table" {
        /// The file that the program writes; its standard output where it is left out.
        optional file: Spanned<String>,
        /// The column, by its header, or by its number from 1.
        required column: Spanned<String>,
        /// The row, from 1 below the header; the last where neither this nor `where` is there.
        optional row: Spanned<u64>,
        /// The first row that has these texts in these columns.
        default(Map::default()) condition as "where": Map<Spanned<String>>,
        /// Separator: one character, `tab`, or `blanks` for any number of blanks; a comma where it is left out.
        optional separator: Spanned<String>,
        /// Lines that are left out at the beginning.
        default(0) skip: u64,
        /// Whether a line of headers follows.
        default(true) header: bool,
    }
}

written_words! {
    /// In which units numbers are exchanged.
    pub enum UnitsForm: "units" {
        /// Those that parameters, inputs and outputs state.
        "as-written" => AsWritten,
        /// SI units.
        "si" => Si,
    }
}

written_words! {
    /// Where slopes come from.
    pub enum DerivativesForm: "derivatives" {
        /// From finite differences.
        "differences" => Differences,
        /// From the server, which offers `Gradient` or `ApplyJacobian`.
        "served" => Served,
    }
}

written_struct! {
    /// A model of a server of the UM-Bridge protocol.
    pub struct UmBridgeForm: "a model of a server" {
        /// Where it listens, such as `http://127.0.0.1:4242`.
        required url: Spanned<String>,
        /// The model's name there.
        required name: Spanned<String>,
        /// What stands for the model in the keys of jobs: another version is another model.
        required version: Spanned<String>,
        /// Parameters and inputs in the order of its vectors; all parameters, then all inputs where there are some, where it is
        /// left out.
        optional inputs: Vec<Spanned<Vec<Spanned<String>>>>,
        /// What it gives.
        required outputs: Map<UmBridgeOutputForm>,
        /// Its configuration.
        optional config: Node,
        /// In which units numbers are exchanged.
        default(UnitsForm::AsWritten) units: UnitsForm,
        /// Where slopes come from.
        default(DerivativesForm::Differences) derivatives: DerivativesForm,
        /// Steps of finite differences, by parameter or input, in its unit.
        default(Map::default()) steps: Map<Amount>,
        /// How long a request may take (an hour).
        optional timeout: Amount,
        /// How often a request that failed is tried again (2).
        optional retries: Spanned<u64>,
        /// Requests at a time (as many as the run has threads).
        optional at_once: Spanned<u64>,
    }
}

written_struct! {
    /// An output of a server.
    pub struct UmBridgeOutputForm: "an output" {
        /// The unit of its number.
        required unit: WrittenUnit,
        /// Output vector and place in it, from 0; the outputs stand in the first vector in their order where it is left out.
        optional at: Spanned<[u64; 2]>,
    }
}
