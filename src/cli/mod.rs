//! The command line: a file a verb; parses, calls, prints; holds no logic of its own.

mod adopt;
mod attach;

mod cache;
mod cancel;
mod check;
mod cluster;
mod collect;
mod compare;
mod completions;
mod data;
pub mod diagnose;
mod diff;
mod effects;
mod execute;
mod explain;
mod export;
mod history;
mod import;
mod import_csv;
mod init;
mod lab;

mod options;
pub mod output;
mod pinned;
mod plan;
mod report;
mod run;
mod schema;
mod select;
pub mod serve_model;
mod shard;
mod show;
pub mod status;
mod test_plan;
mod verify;
mod watch;

use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use std::sync::Arc;

use clap::{Parser, Subcommand, ValueEnum};

use status::{Failure, Status};

use crate::batch::Reading;
use crate::report::terminal::Layout;
use crate::runner::external::{Access, Outside};
use crate::runner::interrupt::Interrupts;

/// Lines are never made shorter than this, however narrow the terminal says that it is.
const NARROWEST: usize = 40;

/// Reproducible Bayesian-based model validation of thermal models.
#[derive(Debug, Parser)]
#[command(
    name = "bmv",
    version,
    propagate_version = false,
    arg_required_else_help = true,
    after_help = "Exit status:\n  \
                  0 done\n  \
                  1 a check failed, or with --require a requirement is not met\n  \
                  2 the input is wrong, or what was asked for is not there\n  \
                  3 a job failed\n  \
                  4 a sampler did not converge\n  \
                  130 interrupted; what was finished is kept\n\n\
                  Words of other tools (GL, GR, QI, MLI, D, A and B nodes): bmv explain WORD."
)]
pub struct Program {
    /// Colours in messages
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto")]
    color: Color,
    /// Run the commands that models name
    #[arg(long, global = true)]
    allow_commands: bool,
    /// Ask models of servers on other machines
    #[arg(long, global = true)]
    allow_remote_models: bool,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Color {
    /// On a terminal, unless NO_COLOR is set
    Auto,
    Always,
    Never,
}

impl Color {
    /// Whether there are colours on something that is a terminal or not.
    fn applies(self, is_terminal: bool) -> bool {
        match self {
            Self::Always => true,
            Self::Never => false,
            Self::Auto => is_terminal && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()),
        }
    }
}

/// What all verbs know.
#[derive(Debug)]
struct Context {
    /// Whether messages on standard error are coloured.
    coloured: bool,
    /// How passes are read.
    reading: Reading,
    /// How text on standard output is laid out.
    layout: Layout,
    /// The width within which lines are broken, where standard output is a terminal.
    fold: Option<usize>,
    /// What Ctrl-C does.
    interrupts: Interrupts,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Run the jobs of passes; what is in the cache is not run again
    Run(run::Run),
    /// Follow a run on a cluster that was left
    Attach(attach::Attach),
    /// Reduce what is there of a run on a cluster, without waiting
    Collect(collect::Collect),
    /// End a run on a cluster; what is finished is kept
    Cancel(cancel::Cancel),
    /// Compute one shard of a run: what a task of a cluster calls
    Shard(shard::ShardVerb),
    /// Render report.md, report.html, plots, results.json and manifest.json
    Report(report::Report),
    /// Run a study again whenever a file of it changes, and serve its reports to a browser of this machine
    Watch(watch::Watch),
    /// Hold a model against its measurements
    Compare(compare::Compare),
    /// Name the physics that a model is missing
    Diagnose(diagnose::Diagnose),
    /// Write the next pass, with effects that a diagnosis found missing
    Adopt(adopt::Adopt),
    /// Show what became of the error, pass by pass
    History(history::HistoryVerb),
    /// Show results as tables, or as they are stored
    Show(show::Show),
    /// Plan the test that a design chose: phases, predictions, limits, durations, data sheet
    TestPlan(test_plan::TestPlanVerb),
    /// Write all draws of a calibration, with what they predict, for ArviZ and other programs
    Export(export::Export),
    /// Answer other programs for the model of a pass, by the UM-Bridge protocol
    ServeModel(serve_model::ServeModel),
    /// Check all files, and show what would run, what is cached, and how long it takes
    Plan(plan::PlanVerb),
    /// Look after the cache
    #[command(subcommand)]
    Cache(cache::CacheVerb),
    /// Recompute every hash of a report's manifest
    Verify(verify::Verify),
    /// Bring or check measurements that are pinned by their hash
    #[command(subcommand)]
    Data(data::Data),
    /// Show the catalogue of physical effects, or one of them at length
    Effects(effects::Effects),
    /// Hide an effect in a model and see whether its test would find it
    Lab(lab::LabVerb),
    /// Print the JSON Schema of a file format
    Schema(schema::Schema),
    /// Print a script that completes commands in a shell
    Completions(completions::Completions),
    /// Explain a diagnostic at length
    Explain(explain::Explain),
    /// Make a new study that runs at once
    Init(init::Init),
    /// Make a study of another tool's model, with its results as a measurement
    Import(import::Import),
    /// Show what changed between two passes, in definitions and in results
    Diff(diff::Diff),
    /// Run jobs again and hold the results against archived ones; `plan` checks files alone
    Check(check::Check),
}

impl Verb {
    fn execute(self, context: &Context) -> Result<Status, Failure> {
        match self {
            Self::Run(verb) => verb.execute(context),
            Self::Attach(verb) => verb.execute(context),
            Self::Collect(verb) => verb.execute(context),
            Self::Cancel(verb) => verb.execute(),
            Self::Shard(verb) => verb.execute(context),
            Self::Report(verb) => verb.execute(context),
            Self::Watch(verb) => verb.execute(context),
            Self::Compare(verb) => verb.execute(context),
            Self::Diagnose(verb) => verb.execute(context),
            Self::Adopt(verb) => verb.execute(context),
            Self::History(verb) => verb.execute(context),
            Self::Show(verb) => verb.execute(context),
            Self::TestPlan(verb) => verb.execute(context),
            Self::Export(verb) => verb.execute(context),
            Self::ServeModel(verb) => verb.execute(context),
            Self::Plan(verb) => verb.execute(context),
            Self::Cache(verb) => verb.execute(context),
            Self::Verify(verb) => verb.execute(),
            Self::Data(verb) => verb.execute(),
            Self::Effects(verb) => verb.execute(context),
            Self::Lab(verb) => verb.execute(context),
            Self::Schema(verb) => verb.execute(),
            Self::Completions(verb) => verb.execute(),
            Self::Explain(verb) => verb.execute(context),
            Self::Init(verb) => verb.execute(),
            Self::Import(verb) => verb.execute(context),
            Self::Diff(verb) => verb.execute(context),
            Self::Check(verb) => verb.execute(context),
        }
    }
}

/// Runs the program: parses the arguments, executes the verb, prints an error once.
pub fn main() -> ExitCode {
    // First of all, so that a signal ends the program with its own status however early it comes.
    let interrupts = match Interrupts::catch(Status::Interrupted.code().into()) {
        Ok(interrupts) => interrupts,
        Err(error) => {
            output::tell(&format!("error: {error}"));
            return Status::JobFailed.into();
        }
    };
    let program = match Program::try_parse() {
        Ok(program) => program,
        // Help and version too come this way.
        Err(message) => return said(&message),
    };
    let coloured = program.color.applies(std::io::stderr().is_terminal());
    let mut layout =
        Layout { is_coloured: program.color.applies(std::io::stdout().is_terminal()), ..Layout::default() };
    let mut fold = None;
    if let Some((_, columns)) = console::Term::stdout().size_checked().filter(|_| std::io::stdout().is_terminal()) {
        layout.width = usize::from(columns).max(NARROWEST);
        fold = Some(layout.width);
    }
    let access = Access::new(program.allow_commands, program.allow_remote_models);
    let reading = Reading { coloured, outside: Arc::new(Outside::new(access)) };
    let context = Context { coloured, reading, layout, fold, interrupts };
    let status = program.verb.execute(&context).unwrap_or_else(|failure| {
        let label = if coloured { "\u{1b}[1;31merror:\u{1b}[0m" } else { "error:" };
        let message = failure.message.trim_end();
        output::tell(&if failure.is_rendered { message.to_owned() } else { format!("{label} {message}") });
        failure.status
    });
    status.into()
}

/// Prints help, version, or what is wrong with the arguments, and gives the status of that.
fn said(message: &clap::Error) -> ExitCode {
    match output::or_no_reader(message.print().and_then(|()| std::io::stdout().flush())) {
        Ok(()) => ExitCode::from(u8::try_from(message.exit_code()).unwrap_or(Status::WrongInput.code())),
        Err(error) => {
            let failure = Failure::from(error);
            output::tell(&format!("error: {}", failure.message));
            failure.status.into()
        }
    }
}
