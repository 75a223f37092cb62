//! Heating rates over an orbit (`.hra`): the mean of each node, which is what a steady state takes.
//!
//! Thermal Desktop writes them into comments between PSTOP and PSTART: array 1 holds the means in the order of the nodes,
//! and each node has a line with its own means by source, against which array 1 is checked.

use super::block::Block;

/// Relative difference of a node's mean and the sum of its means by source: these have 6 decimals.
const PRINTED: f64 = 2e-6;
/// What to do where the file does not hold together.
const WRITE_ANEW: &str = "let Thermal Desktop write the file anew";
/// The line above array 1.
const MEANS: &str = "Average heating rates";

/// Mean heats of nodes, in W.
pub(super) type Means = Vec<((String, i64), f64)>;

/// The mean heat into each node of a block of arrays; `None` where the block holds no heating rates.
///
/// # Errors
/// The line and what is wrong.
pub(super) fn means(block: &Block<'_>) -> Option<Result<Means, (usize, String)>> {
    let start = block.comments.iter().position(|comment| comment.text.starts_with(MEANS))?;
    Some(read(block, start))
}

fn read(block: &Block<'_>, start: usize) -> Result<Means, (usize, String)> {
    let line = block.comments.get(start).map_or(block.line, |comment| comment.line);
    let units = |name: &str| {
        let text = block.comments.iter().find_map(|comment| comment.text.strip_prefix(name))?;
        Some(text.trim_start_matches(':').trim().to_owned())
    };
    for (name, expected) in [("Data Array units", "W"), ("Energy units", "J"), ("Time units", "s")] {
        if let Some(unit) = units(name)
            && unit != expected
        {
            return Err((line, format!("{name} are {unit}: expected {expected}; write absorbed heats in SI units")));
        }
    }
    let mut means: Vec<f64> = Vec::new();
    for comment in block.comments.get(start + 1..).unwrap_or_default() {
        let text = match comment.text.split_once('=') {
            Some((number, rest)) if means.is_empty() && number.trim() == "1" => rest,
            None if !means.is_empty() && comment.text.starts_with(|c: char| c.is_ascii_digit() || c == '-') => {
                comment.text
            }
            _ => break,
        };
        for number in text.split([',', ' ']).filter(|number| !number.is_empty()) {
            let value: f64 =
                number.parse().map_err(|_| (comment.line, format!("`{number}`: expected a mean heat in W")))?;
            means.push(value);
        }
    }
    let mut nodes = Vec::new();
    for comment in &block.comments {
        let Some((heading, by_source)) = comment.text.split_once("Avg =") else { continue };
        let name = heading.split_once(" - ").map(|(_, rest)| rest.trim_start());
        let name = name.and_then(|rest| rest.split_whitespace().next()).and_then(|name| name.rsplit_once('.'));
        let Some((submodel, number)) = name else {
            return Err((comment.line, "expected `... - SUBMODEL.number Area = ... Avg = ...`".to_owned()));
        };
        let number = number.parse().map_err(|_| (comment.line, format!("`{number}`: expected a node's number")))?;
        let parts: Result<Vec<f64>, _> = by_source.split_whitespace().map(str::parse).collect();
        let sum: f64 =
            parts.map_err(|_| (comment.line, "expected means by source behind `Avg =`".to_owned()))?.iter().sum();
        let Some(&mean) = means.get(nodes.len()) else {
            return Err((comment.line, format!("array 1 has {} means: expected one for each node", means.len())));
        };
        if (mean - sum).abs() > PRINTED + 1e-4 * sum.abs() {
            let message = format!(
                "its means add up to {sum} W, array 1 says {mean} W; {WRITE_ANEW}, or write the sum into array 1"
            );
            return Err((comment.line, message));
        }
        nodes.push(((submodel.to_ascii_uppercase(), number), mean));
    }
    if nodes.len() != means.len() || nodes.is_empty() {
        return Err((line, format!("array 1 has {} means for {} nodes; {WRITE_ANEW}", means.len(), nodes.len())));
    }
    Ok(nodes)
}
