//! A sensitivity analysis in brief.

use crate::document::counted;
use crate::job::sensitivity::{Kind, Output};
use crate::report::number::{self, percent};
use crate::report::section::brief::Brief;
use crate::report::view::JobEntry;

use super::by_total;

/// Parameters that are stated.
const MOST_LEADING: usize = 3;

/// A sensitivity analysis in brief.
pub(in crate::report::section) struct Sensitivity;

impl Brief for Sensitivity {
    type Kind = Kind;

    /// The leading parameters of each quantity.
    fn headline(_: &JobEntry, output: &Output) -> Vec<String> {
        let mut lines = Vec::new();
        for case in &output.cases {
            let place = if output.cases.len() == 1 { String::new() } else { format!(" in {}", case.environment) };
            for quantity in &case.quantities {
                let Some(sobol) = &quantity.sobol else {
                    lines.extend(quantity.is_constant.then(|| format!("{} does not vary{place}", quantity.name)));
                    continue;
                };
                let leading: Vec<String> = by_total(sobol)
                    .into_iter()
                    .take(MOST_LEADING)
                    .map(|at| {
                        let total = number::percent(sobol.total[at].estimate.value, 0);
                        format!("{} {total}", output.parameters[at].name)
                    })
                    .collect();
                lines.push(format!("{}: total effects {}{place}", quantity.name, leading.join(", ")));
            }
            if case.failed > 0 {
                let (failed, solves, rows) = (case.failed, case.solves, case.rows_left_out);
                let are = if rows == 1 { "is" } else { "are" };
                let rows = counted(rows, "row");
                lines.push(format!("{failed} of {} failed, {rows} {are} left out{place}", counted(solves, "solve")));
            }
        }
        lines.extend(output.precision.filter(|precision| !precision.is_reached).map(|precision| {
            let (widest, asked) = (number::significant(precision.widest, 2), number::significant(precision.asked, 2));
            format!("the precision asked for is NOT reached: the widest interval is {widest}, asked for {asked}")
        }));
        lines
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
        let mut rows = Vec::new();
        for case in &output.cases {
            let place = if output.cases.len() == 1 { String::new() } else { format!(" in {}", case.environment) };
            for quantity in &case.quantities {
                let Some(sobol) = &quantity.sobol else { continue };
                for (parameter, total) in output.parameters.iter().zip(&sobol.total) {
                    let name = format!("{}: total effect of {}{place}", quantity.name, parameter.name);
                    rows.push((name, percent(total.estimate.value, 0)));
                }
            }
        }
        rows
    }
}
