//! x
use crate::job::sensitivity::Sobol;
use crate::report::page::Section;
use crate::report::view::PassReport;
/// x
pub fn build(_report: &PassReport<'_>) -> Option<Section> {
    None
}
/// x
pub fn by_total(sobol: &Sobol) -> Vec<usize> {
    let mut order: Vec<usize> = (0..sobol.total.len()).collect();
    order.sort_by(|&i, &j| sobol.total[j].estimate.value.total_cmp(&sobol.total[i].estimate.value));
    order
}
