//! `bmv completions`.

use clap::CommandFactory;
use clap_complete::{Shell, generate};

use super::Program;
use super::output::or_no_reader;
use super::status::{Failure, Status};

/// Arguments of `bmv completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
                  bmv completions bash > ~/.local/share/bash-completion/completions/bmv\n  \
                  bmv completions zsh > ~/.zfunc/_bmv\n  \
                  bmv completions fish > ~/.config/fish/completions/bmv.fish")]
pub(super) struct Completions {
    /// The shell
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

impl Completions {
    pub(super) fn execute(self) -> Result<Status, Failure> {
        let mut script = Vec::new();
        generate(self.shell, &mut Program::command(), "bmv", &mut script);
        // It is made of the program's own words alone.
        or_no_reader(std::io::Write::write_all(&mut std::io::stdout().lock(), &script))?;
        Ok(Status::Done)
    }
}
