//! The command line: a file a verb; parses, calls, prints; holds no logic of its own.

/// Runs the program.
pub fn main() -> std::process::ExitCode {
    std::process::ExitCode::SUCCESS
}
