//! Calls of a program: a fresh folder, what it is given, what it gives back.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use std::process::ExitStatus;
use std::time::Duration;

use serde_json::{Map, Value};

use super::call::{Call, Failure};
use super::output::Outputs;
use super::process::{self, End, MOST_BYTES};
use crate::study::external::{Command, Input, Program};
use crate::study::file;

/// Characters shown of what a program said last.
const LAST_WORDS: usize = 200;
/// Bytes of the error stream that are looked at.
const ERRORS_BYTES: u64 = MOST_BYTES;

/// A number as decks, JSON and command lines read it: the shortest that is the same number, with a point or an exponent.
fn number(value: f64) -> String {
    format!("{value:?}")
}

/// A text with values in their places.
fn filled(parts: &[(String, Option<usize>)], given: &[f64]) -> String {
    let value =
        |place: &Option<usize>| place.and_then(|place| given.get(place)).map_or_else(String::new, |v| number(*v));
    parts.iter().map(|(text, place)| format!("{text}{}", value(place))).collect()
}

/// Calls a program; gives the numbers of the outputs.
pub(super) fn call(call: &Call<'_>, command: &Command) -> Result<Vec<f64>, Failure> {
    let broken = |what: &str| {
        let what = what.to_owned();
        move |error: std::io::Error| Failure::Broken(format!("{what}: {error}"))
    };
    let whole = tempfile::Builder::new().prefix("bmv-call-").tempdir();
    let whole = whole.map_err(broken("no folder for the program can be made"))?;
    let folder = whole.path().join("run");
    fs::create_dir(&folder).map_err(broken("no folder for the program can be made"))?;
    for (name, _) in &command.files {
        let place = folder.join(name);
        let parent = place.parent().unwrap_or(&folder);
        let linked = fs::create_dir_all(parent).and_then(|()| link(&command.folder.join(name), &place));
        linked.map_err(broken(&format!("`{name}` cannot be laid into the program's folder")))?;
    }
    let program = match &command.program {
        Program::Inside(path, _) => command.folder.join(path).into_os_string(),
        Program::Outside(name) => name.into(),
    };
    let mut started = std::process::Command::new(&program);
    started.current_dir(&folder).args(command.arguments.iter().map(|parts| filled(parts, call.given)));
    let lay = |name: &str, text: &str| {
        let place = folder.join(name);
        let parent = place.parent().unwrap_or(&folder);
        let written = fs::create_dir_all(parent).and_then(|()| fs::write(&place, text));
        written.map_err(broken(&format!("`{name}` cannot be written")))
    };
    match &command.input {
        Input::Json(name) => {
            let pairs = call.external.given.iter().zip(call.given);
            let object: Map<String, Value> =
                pairs.map(|(given, value)| (given.name.clone(), (*value).into())).collect();
            lay(name, &Value::Object(object).to_string())?;
        }
        Input::Environment(names) => {
            started.envs(names.iter().zip(call.given).map(|(name, value)| (name, number(*value))));
        }
        Input::Templates(templates) => {
            for template in templates {
                lay(&template.name, &filled(&template.parts, call.given))?;
            }
        }
    }
    let (output, errors) = (whole.path().join("output"), whole.path().join("errors"));
    let timeout = Duration::try_from_secs_f64(call.external.calls.timeout_s).unwrap_or(Duration::MAX / 4);
    let end = process::run(started, &output, &errors, timeout, call.is_over);
    match end.map_err(broken(&format!("`{}` cannot be started", Path::new(&program).display())))? {
        End::Left => return Err(Failure::at("the program was ended", "the run was left")),
        End::TimedOut => {
            let detail = format!("it was ended after {} s, with its group of processes", timeout.as_secs_f64());
            return Err(Failure::at("the program took longer than its timeout", detail));
        }
        End::WroteTooMuch => {
            let detail = format!("more than {} MiB to its output", MOST_BYTES >> 20);
            return Err(Failure::at("the program wrote too much", detail));
        }
        End::Exited(status) => {
            let is_accepted = status.code().and_then(|code| u64::try_from(code).ok());
            if !is_accepted.is_some_and(|code| command.exit_codes.contains(&code)) {
                if let Some(signal) = from_outside(status) {
                    // A machine that is taken away, a shortage of memory: it says nothing of the point.
                    let why =
                        format!("the program was ended from outside ({signal}), so nothing is known of its point");
                    return Err(Failure::Broken(why));
                }
                let said = last_words(&errors).or_else(|| last_words(&output));
                let said = said.map_or_else(String::new, |said| format!("; it said last: {said}"));
                return Err(Failure::at("the program did not succeed", format!("{status}{said}")));
            }
        }
    }
    Outputs { folder: &folder, output: &output, command }.numbers(&call.external.outputs)
}

#[cfg(unix)]
fn link(from: &Path, to: &Path) -> std::io::Result<()> {
    std::os::unix::fs::symlink(from, to)
}

/// The signal by which somebody else ended a program, or what its shell says of one.
fn from_outside(status: ExitStatus) -> Option<&'static str> {
    use std::os::unix::process::ExitStatusExt;
    // A shell adds 128 to the signal of what it ran.
    let signal = status.signal().or_else(|| status.code()?.checked_sub(128))?;
    Some(match signal {
        1 => "SIGHUP",
        2 => "SIGINT",
        9 => "SIGKILL, as where memory is short",
        15 => "SIGTERM",
        _ => return None,
    })
}

/// The last line of a stream that is not empty.
fn last_words(path: &Path) -> Option<String> {
    let bytes = file::read(path, ERRORS_BYTES).ok()?;
    let text = String::from_utf8_lossy(&bytes);
    let line = text.lines().rev().find(|line| !line.trim().is_empty())?.trim().to_owned();
    let shown: String = line.chars().filter(|c| !c.is_control()).take(LAST_WORDS).collect();
    Some(shown)
}

/// Whether a file is not there, in words for a program's output.
pub(super) fn absent(error: &std::io::Error) -> String {
    if error.kind() == ErrorKind::NotFound { "the program did not write it".to_owned() } else { error.to_string() }
}
