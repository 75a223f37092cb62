//! Where the figures and tables of another document have their counterparts in the reports, each with the hash of its file.

use crate::report::number::NONE;
use crate::report::page::{Block, Cell, Column, Section, Status, Table, Text};
use crate::study::document::{Counterpart, Shown};

use super::{ArchivedPass, ArchivedStudy};

/// Digits of a hash that are shown: enough to find it in a manifest, which has all.
const DIGITS: usize = 16;

/// The section; not where the study's document names no counterparts. `all` are the studies whose reports lie beside it.
pub(super) fn section(study: &ArchivedStudy, all: &[ArchivedStudy]) -> Option<Section> {
    let document = study.document()?;
    let of = document.counterparts_of.as_ref()?;
    let rows = document.counterparts.iter().map(|own| row(study, all, own)).collect();
    let with = document.counterparts.iter().filter(|own| matches!(own.shown, Shown::In { .. })).count();
    let caption = format!(
        "Figures and tables of {of}, by what their titles name, and where these reports show the same: {with} of {} entries \
         have a counterpart. SHA-256: the first digits of the hash of the figure's file, of a table that of report.md; \
         manifest.json of the pass has all.",
        document.counterparts.len()
    );
    Some(Section {
        id: "counterparts",
        title: format!("Counterparts of {of}"),
        blocks: vec![Block::Details(
            "What stands where".into(),
            vec![Block::Table(Table {
                caption: caption.into(),
                columns: vec![
                    Column::text("Item"),
                    Column::text("What it shows"),
                    Column::text("Counterpart"),
                    Column::text("Difference"),
                    Column::text("SHA-256"),
                ],
                rows,
            })],
        )],
    })
}

fn row(study: &ArchivedStudy, all: &[ArchivedStudy], own: &Counterpart) -> Vec<Cell> {
    let remark = own.note.clone().unwrap_or_else(|| NONE.to_owned());
    let head = |place: Cell, remark: String, hash: Cell| {
        vec![own.item.clone().into(), own.title.clone().into(), place, remark.into(), hash]
    };
    let Shown::In { study: other, pass, anchor, is_figure } = &own.shown else {
        let Shown::Nowhere(why) = &own.shown else { return Vec::new() };
        return head("none".into(), why.clone(), NONE.into());
    };
    let folder = pass.trim_end_matches(".json");
    let holder = match other {
        Some(other) => all.iter().find(|known| known.folder == *other),
        None => Some(study),
    };
    let mut parts: Vec<&str> = other.iter().flat_map(|other| ["..", other.as_str()]).collect();
    parts.extend([folder, "report"]);
    let name = match other {
        Some(other) => format!("{other} {folder}, {anchor}"),
        None => format!("{folder}, {anchor}"),
    };
    let found: Option<&ArchivedPass> =
        holder.and_then(|holder| holder.passes.iter().find(|known| known.record.pass == *pass));
    let file = if *is_figure { format!("plots/{anchor}.svg") } else { "report.md".to_owned() };
    match found.and_then(|found| found.manifest.outputs.get(&file)) {
        Some(output) => {
            let link = Text::default().link_into(name, &parts, anchor);
            head(link.into(), remark, Cell::code(output.sha256.as_str().chars().take(DIGITS).collect::<String>()))
        }
        None => head(Cell::marked(format!("{name}: not among the reports here"), Status::Fail), remark, NONE.into()),
    }
}
