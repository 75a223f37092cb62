//! Reports as PDF, printed by a browser that is there.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::batch::BatchError;
use crate::runner::external::process::{End, run};

/// Names the browser that prints; without it, the first of [`BROWSERS`] on the path does.
const BROWSER: &str = "BMV_BROWSER";
const BROWSERS: [&str; 5] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"];
/// Longest time that a report may take.
const LONGEST: Duration = Duration::from_secs(120);

/// The browser that prints.
///
/// # Errors
/// There is none.
pub fn browser() -> Result<PathBuf, BatchError> {
    if let Some(named) = std::env::var_os(BROWSER).filter(|named| !named.is_empty()) {
        return Ok(named.into());
    }
    let folders: Vec<PathBuf> = std::env::var_os("PATH").iter().flat_map(std::env::split_paths).collect();
    let mut places = BROWSERS.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    places.find(|place| place.is_file()).ok_or_else(|| {
        BatchError::input(format!(
            "no browser prints the reports: install Chromium or Chrome, or name one of them with {BROWSER}=PATH"
        ))
    })
}

/// Prints a page into a PDF; `is_over` leaves it.
///
/// # Errors
/// The browser does not start, takes too long or writes no PDF.
pub fn pdf(browser: &Path, page: &Path, to: &Path, is_over: &dyn Fn() -> bool) -> Result<(), BatchError> {
    let failed = |why: String| BatchError::input(format!("`{}` printed no PDF: {why}", browser.display()));
    let scratch = tempfile::tempdir().map_err(|error| failed(error.to_string()))?;
    let page = std::path::absolute(page).map_err(|error| failed(error.to_string()))?;
    let written = scratch.path().join("report.pdf");
    let mut why = String::new();
    // Where the system lets no user isolate processes, as in many containers, a browser starts only without its sandbox. What it is shown
    // has no script and loads nothing.
    for sandbox in [&[][..], &["--no-sandbox"][..]] {
        let mut command = Command::new(browser);
        command.args(["--headless", "--disable-gpu", "--no-pdf-header-footer", "--no-first-run"]).args(sandbox);
        command.arg(argument("--user-data-dir=", &scratch.path().join("profile")));
        command.arg(argument("--print-to-pdf=", &written)).arg(address(&page));
        let [output, errors] = ["output", "errors"].map(|name| scratch.path().join(name));
        match run(command, &output, &errors, LONGEST, is_over) {
            Err(error) => return Err(failed(error.to_string())),
            Ok(End::Left) => return Err(failed("it was left".to_owned())),
            Ok(End::TimedOut) => return Err(failed(format!("it took longer than {} s", LONGEST.as_secs()))),
            Ok(End::WroteTooMuch) => return Err(failed("it wrote too many messages".to_owned())),
            Ok(End::Exited(status)) if status.success() && is_pdf(&written) => {
                let folder = to.parent().unwrap_or(Path::new(""));
                let copied = std::fs::create_dir_all(folder).and_then(|()| std::fs::copy(&written, to));
                return copied.map(|_| ()).map_err(|error| failed(format!("`{}`: {error}", to.display())));
            }
            Ok(End::Exited(status)) => {
                let said = std::fs::read_to_string(&errors).unwrap_or_default();
                let last = said.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("").trim().to_owned();
                why = if last.is_empty() { status.to_string() } else { format!("{status}, {last}") };
            }
        }
    }
    Err(failed(why))
}

fn argument(option: &str, path: &Path) -> std::ffi::OsString {
    let mut argument = std::ffi::OsString::from(option);
    argument.push(path);
    argument
}

/// The address of a file, with all but plain letters encoded by their bytes.
pub fn address(page: &Path) -> String {
    let plain = |byte: &u8| byte.is_ascii_alphanumeric() || b"/-_.~".contains(byte);
    let one = |byte: u8| if plain(&byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") };
    format!("file://{}", page.as_os_str().as_encoded_bytes().iter().map(|&byte| one(byte)).collect::<String>())
}

fn is_pdf(file: &Path) -> bool {
    std::fs::read(file).is_ok_and(|bytes| bytes.starts_with(b"%PDF-"))
}
