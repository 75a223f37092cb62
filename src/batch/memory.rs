//! How much memory jobs need, and how much there is.

use super::BatchError;
use crate::report::terminal::escaped;
use crate::runner::plan::Preview;

/// Where the system does not tell how much there is, more is refused.
const ASSUMED_BYTES: u64 = 1 << 40;
/// Less is not worth a word.
pub const WORTH_TELLING: u64 = 256 << 20;

/// Refuses jobs that do not fit the machine before any of them runs.
///
/// # Errors
/// Each of them with what it needs.
pub fn check(needed: &[Preview]) -> Result<(), BatchError> {
    refused(needed, machine_bytes())
}

/// What people should know of the memory that jobs take, a line each.
pub fn notes(needed: &[Preview]) -> Vec<String> {
    let large = needed.iter().filter(|job| job.memory_bytes >= WORTH_TELLING);
    large.map(|job| format!("{} takes about {} of memory", escaped(&job.job), bytes_text(job.memory_bytes))).collect()
}

/// Refuses what needs more memory than so many bytes.
///
/// # Errors
/// A job needs more; all of them are named.
pub fn refused(needed: &[Preview], there_bytes: u64) -> Result<(), BatchError> {
    let too_large = needed.iter().filter(|job| job.memory_bytes > there_bytes);
    let refusals: Vec<String> = too_large
        .map(|job| {
            format!(
                "`{}` needs about {} of memory, this machine has {}: give it fewer `samples` (or `draws`), or a sweep of \
                 fewer `steps`, or less `data` and fewer `effects`",
                escaped(&job.job),
                bytes_text(job.memory_bytes),
                bytes_text(there_bytes)
            )
        })
        .collect();
    if refusals.is_empty() { Ok(()) } else { Err(BatchError::input(refusals.join("\n"))) }
}

/// Memory of the machine, bytes.
fn machine_bytes() -> u64 {
    let memory_info = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let total = memory_info.lines().find_map(|line| line.strip_prefix("MemTotal:"));
    let kibibytes = total.and_then(|rest| rest.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    kibibytes.map_or(ASSUMED_BYTES, |kibibytes| kibibytes << 10)
}

/// An amount of memory, in words.
pub fn bytes_text(bytes: u64) -> String {
    match bytes as f64 {
        b if b < 1e9 => format!("{:.0} MB", b / 1e6),
        b if b < 1e11 => format!("{:.1} GB", b / 1e9),
        b if b < 1e12 => format!("{:.0} GB", b / 1e9),
        b => format!("{:.1} TB", b / 1e12),
    }
}
