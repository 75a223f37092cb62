//! Parameters that were inferred together with the discrepancies, beside what the calibration alone says.

use crate::document::counted;
use crate::job::discrepancy::{Joint, Output};
use crate::report::number::{fixed, percent, signed, significant};
use crate::report::page::{Block, Cell, Column, Status, Table, Text};

pub(super) fn opening(name: &str, output: &Output, joint: &Joint) -> Text {
    let [chains, draws] = joint.chains;
    Text::new("Job ").code(name).plain(format!(
        ": the parameters of the calibration {} inferred anew, together with a discrepancy of each sensor (Kennedy & O'Hagan 2001), \
         by {chains} chains of {}, of which {} are kept. Residuals are those at the mean of that posterior. A prediction takes \
         parameters and discrepancy of the same draw.",
        output.source.replace('`', ""),
        counted(draws, "draw"),
        joint.draws.values.len(),
    ))
}

/// The parameters under both.
pub(super) fn parameters(output: &Output, joint: &Joint) -> Option<Block> {
    let rows: Vec<Vec<Cell>> = (output.parameters.iter().zip(&output.means))
        .map(|(own, mean)| {
            let status = if own.is_confounded { Status::Caution } else { Status::Ok };
            let interval = joint.parameters.get(&own.name).map_or([f64::NAN; 2], |known| known.interval);
            vec![
                Cell::code(&own.name),
                significant(mean - own.shift, 4).into(),
                significant(own.sd, 2).into(),
                significant(*mean, 4).into(),
                significant(own.free_sd, 2).into(),
                interval.map(|end| significant(end, 4)).join(" to ").into(),
                fixed(own.free_sd / own.sd, 2).into(),
                signed(own.shift / own.sd, 2).into(),
                percent(own.absorbed, 0).into(),
                Cell::marked(if own.is_confounded { "confounded" } else { "told apart" }, status),
            ]
        })
        .collect();
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: "The calibrated unknowns without and with the discrepancies (SI): mean and standard deviation of both \
                      posteriors, how much wider the second is, by how many standard deviations of the first the mean moved, and \
                      the share of what the readings say of each alone that the discrepancies could say as well."
                .into(),
            columns: vec![
                Column::text("Unknown"),
                Column::number("Calibration", ""),
                Column::number("Standard deviation", ""),
                Column::number("Together", ""),
                Column::number("Standard deviation", ""),
                Column::number("95 % interval", ""),
                Column::number("Width", "times"),
                Column::number("Shift", "standard deviations"),
                Column::number("Could be absorbed", ""),
                Column::text("Outcome"),
            ],
            rows,
        })
    })
}
