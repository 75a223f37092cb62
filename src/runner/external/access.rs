//! What may be asked: commands run only where the user says so.

use std::path::PathBuf;

use crate::study::external::{Command, External, Input};
use crate::study::file;

/// Largest list that is read, bytes.
const LIST_BYTES: u64 = 1 << 20;
/// The list below the user's folder of settings.
const LIST: &str = "bmv/allowed-commands";

/// What the user allows.
#[derive(Clone, Debug, Default)]
pub struct Access {
    commands: bool,
    remote: bool,
    /// Folder of the user's settings.
    settings: Option<PathBuf>,
}

impl Access {
    /// All commands or those of the user's list; servers of other machines or of this one alone.
    pub fn new(commands: bool, remote: bool) -> Self {
        let of = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let settings = of("XDG_CONFIG_HOME").or_else(|| Some(of("HOME")?.join(".config")));
        Self { commands, remote, settings }
    }

    /// Whether all commands may run, and whether servers of other machines may be asked.
    pub fn flags(&self) -> (bool, bool) {
        (self.commands, self.remote)
    }

    /// The user's list of commands that may run, if there is one.
    pub fn list(&self) -> Option<Vec<u8>> {
        file::read(&self.settings.as_ref()?.join(LIST), LIST_BYTES).ok()
    }

    /// Whether servers of other machines may be asked.
    pub(super) fn is_remote_allowed(&self) -> bool {
        self.remote
    }

    /// Whether a command may run.
    ///
    /// # Errors
    /// What would run, and how to allow it.
    pub(super) fn command(&self, external: &External, command: &Command) -> Result<(), String> {
        let fingerprint = external.fingerprint();
        let list = self.settings.as_ref().map(|settings| settings.join(LIST));
        if self.commands || list.as_ref().is_some_and(|list| is_listed(list, &fingerprint)) {
            return Ok(());
        }
        let names: Vec<String> = external.given.iter().map(|given| given.name.clone()).collect();
        let input = match &command.input {
            Input::Json(name) => format!("parameters and inputs in `{name}`"),
            Input::Environment(_) => "parameters and inputs in its environment".to_owned(),
            Input::Templates(templates) => {
                let names: Vec<String> = templates.iter().map(|template| format!("`{}`", template.name)).collect();
                format!("parameters and inputs in {}", names.join(", "))
            }
        };
        let listed = list.map_or_else(String::new, |list| {
            format!(
                ", or put the line `{fingerprint}` into `{}`, which holds until command or files change",
                list.display()
            )
        });
        Err(format!(
            "the model is a command, and commands run only where you allow it; it would run `{}` in an empty folder, with {input}; \
             look at it, then give --allow-commands{listed}",
            command.shown(&names)
        ))
    }
}

/// Whether a line of the list begins with the fingerprint.
fn is_listed(list: &std::path::Path, fingerprint: &str) -> bool {
    let Ok(bytes) = file::read(list, LIST_BYTES) else { return false };
    let text = String::from_utf8_lossy(&bytes);
    text.lines().any(|line| line.split_whitespace().next() == Some(fingerprint))
}
