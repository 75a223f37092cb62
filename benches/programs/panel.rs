//! Ten orbits of a panel of 200 nodes, so many times; prints the temperatures of the last at every minute of some nodes, K, a row
//! a minute. `benches/peers/transient.py` compares them, and the CPU seconds that each takes, with a peer's.
//!
//! usage: panel REPEATS NODE...

#[allow(dead_code, clippy::unwrap_used)]
#[path = "../../tests/verification/build.rs"]
mod build;
#[allow(dead_code, clippy::unwrap_used)]
#[path = "../../tests/verification/orbit.rs"]
mod orbit;

use std::process::ExitCode;

use bmv::thermal::{Network, TransientOptions};

fn main() -> ExitCode {
    let arguments: Option<Vec<usize>> = std::env::args().skip(1).map(|argument| argument.parse().ok()).collect();
    let Some((&repeats, read)) = arguments.as_deref().and_then(<[usize]>::split_first) else {
        eprintln!("usage: panel REPEATS NODE...");
        return ExitCode::FAILURE;
    };
    let network = match Network::compile(&orbit::panel200(), &[]) {
        Ok(network) => network,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    let outputs = orbit::every_minute();
    let mut last = None;
    for _ in 0..repeats {
        last = Some(orbit::orbits(&network, TransientOptions::default(), &outputs));
    }
    for row in last.iter().flat_map(|run| run.temperatures.chunks_exact(network.nodes())) {
        let shown: Vec<String> = read.iter().filter_map(|&node| row.get(node)).map(f64::to_string).collect();
        println!("{}", shown.join(" "));
    }
    ExitCode::SUCCESS
}
