//! Inputs that missing heat goes with.

use super::sources::{Kind, Source};
use crate::diagnosis::Problem;
use crate::diagnosis::output::GoesWith;
use crate::math::sort::sort_by;
use crate::math::special::student_t_cdf;
use crate::thermal::Clock;

/// p-value below which heat is said to go with an input.
const GOES: f64 = 0.01;

/// Inputs that a node's missing heat goes with, by linear regression over its phases or stretches.
pub(super) fn relations(problem: &Problem, watts: &[(&Source, f64)]) -> Vec<GoesWith> {
    let nodes: Vec<usize> = (0..problem.model.nodes.len()).collect();
    // Stretches of a transient have no time since its start.
    let elapsed = problem.model.clocks.get(Clock::Elapsed);
    let inputs: Vec<_> = problem.model.inputs.iter().enumerate().filter(|(input, _)| Some(*input) != elapsed).collect();
    let tests = (nodes.len() * inputs.len()).max(1) as f64;
    let mut significant = Vec::new();
    for node in nodes {
        let node_heats: Vec<&(&Source, f64)> =
            watts.iter().filter(|(source, _)| source.kind == Kind::Node(node)).collect();
        let heat: Vec<f64> = node_heats.iter().map(|(_, watts)| *watts).collect();
        if node_heats.len() < 4 {
            continue;
        }
        for &(input, entry) in &inputs {
            let x: Vec<f64> = node_heats.iter().filter_map(|(source, _)| source.inputs.get(input).copied()).collect();
            if x.len() != heat.len() {
                continue;
            }
            let count = x.len() as f64;
            let (mx, my) = (x.iter().sum::<f64>() / count, heat.iter().sum::<f64>() / count);
            let sxx: f64 = x.iter().map(|v| (v - mx) * (v - mx)).sum();
            let sxy: f64 = x.iter().zip(&heat).map(|(v, w)| (v - mx) * (w - my)).sum();
            let syy: f64 = heat.iter().map(|w| (w - my) * (w - my)).sum();
            if !(sxx > 0.0 && syy > 0.0) {
                continue;
            }
            let square = (sxy * sxy / (sxx * syy)).min(1.0 - 1e-15);
            let t = (square * (count - 2.0) / (1.0 - square)).sqrt();
            let p = (tests * 2.0 * student_t_cdf(-t, count - 2.0)).min(1.0);
            if p < GOES {
                significant.push(GoesWith {
                    node: problem.model.nodes[node].name.clone(),
                    input: entry.name.clone(),
                    slope: sxy / sxx,
                    p,
                });
            }
        }
    }
    sort_by(&mut significant, |a, b| a.p.total_cmp(&b.p));
    significant
}
