//! The command line program.

fn main() -> std::process::ExitCode {
    bmv::cli::main()
}
