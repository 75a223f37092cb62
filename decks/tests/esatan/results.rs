//! A public result of ESATAN-TMS with its model (README.md beside it), and damaged copies of it.

use bmv_decks::esatan::{Form, read_tmd, recognises};
use bmv_decks::{CouplingKind, NodeKind};

use super::closure::{missing_heat_w, net_heat_w, value_at};

const TMD: &[u8] = include_bytes!("DISCTR_TRANSIENT.TMD");

/// The file has 103 nodes, one of them inactive, 190 linear and 5050 radiative conductors and 101 instants, as `h5dump` shows.
#[test]
fn a_result_with_its_model_reads_and_balances() {
    assert_eq!(recognises(TMD), Some(Form::Tmd));
    let deck = read_tmd("DISCTR_TRANSIENT.TMD", TMD).expect("a result");
    let count = |kind| deck.couplings.iter().filter(|coupling| coupling.kind == kind).count();
    assert_eq!(deck.nodes.len(), 102);
    assert_eq!((count(CouplingKind::Linear), count(CouplingKind::Radiative)), (190, 5050));
    let record = deck.record.as_ref().expect("a record");
    assert_eq!(record.times_s.len(), 101);
    assert!(!record.is_steady && record.temperatures_k.iter().all(|rows| rows.len() == 101));
    let net: Vec<Vec<f64>> = (0..101).map(|row| net_heat_w(&deck, row)).collect();
    for (node, entry) in deck.nodes.iter().enumerate() {
        let NodeKind::Diffusion { capacity } = &entry.kind else { continue };
        for row in 2..100 {
            let pair = [record.temperatures_k[node][row], record.temperatures_k[node][row + 1]];
            let interval_s = record.times_s[row + 1] - record.times_s[row];
            let capacity = value_at(capacity, &deck, record, row);
            let missing = missing_heat_w(capacity, pair, [net[row][node], net[row + 1][node]], interval_s);
            // The trapezium errs by h^2/12 of the heats' second derivative. Differences of three rows show it; where it
            // changes from row to row a factor of 4 is left, and the solver iterates to 1e-6 of the heats that meet.
            let bend = |row: usize| (net[row - 1][node] - 2.0 * net[row][node] + net[row + 1][node]).abs();
            let allowed = 4.0 * bend(row).max(bend((row + 1).min(99))) / 12.0 + 1e-5;
            assert!(missing.abs() < allowed, "{} at row {row}: {missing} W of {allowed} W", entry.name);
        }
    }
}

/// A file that is cut off or has wrong bytes is read or refused with its name; nothing else happens.
#[test]
#[ignore = "thorough"]
fn damaged_results_are_read_or_refused() {
    let mut state = 7_u64;
    let mut next = |below: usize| {
        // Knuth's multiplier (The Art of Computer Programming, 3.3.4).
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let mut refused = 0;
    for round in 0..60 {
        let mut bytes = TMD.to_vec();
        if round % 3 == 0 {
            bytes.truncate(next(TMD.len()));
        } else {
            // Sizes and addresses stand before the data: damage there is the worst.
            let reach = if round % 3 == 1 { 40_000 } else { TMD.len() };
            for _ in 0..8 {
                bytes[next(reach)] = [0x00, 0xff, 0x7f, 0x80][next(4)];
            }
        }
        if let Err(error) = read_tmd("damaged.TMD", &bytes) {
            refused += 1;
            assert!(error.to_string().starts_with("damaged.TMD: "), "{error}");
        }
    }
    assert!(refused >= 20, "cut files at least: {refused}");
}
