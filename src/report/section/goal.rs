//! x
use crate::job::goal::{Next, Output};
use crate::report::page::Section;
use crate::report::view::PassReport;
/// x
pub fn build(_report: &PassReport<'_>) -> Option<Section> {
    None
}
/// x
pub fn next_words(_next: Next) -> &'static str {
    ""
}
/// x
pub fn reasons(output: &Output) -> Vec<String> {
    output.advice.reasons.clone()
}
