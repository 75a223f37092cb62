//! The title block: what identifies a document and who stands for it.

use crate::study::StudyDocument;

use super::page::Text;
use super::view::PassReport;

/// What stands where nobody has signed yet.
const NOT_SIGNED: &str = "not yet signed";

/// The title block of a pass's report, which is a part of the study's document.
pub fn of_pass(document: &StudyDocument, report: &PassReport<'_>) -> Vec<(Text, Text)> {
    with_part(document, Some(part(report)))
}

/// The title block of the whole.
pub fn of_study(document: &StudyDocument) -> Vec<(Text, Text)> {
    with_part(document, None)
}

/// Number and issue of a pass's report, for the foot of every page.
pub fn mark_of_pass(document: &StudyDocument, report: &PassReport<'_>) -> String {
    format!("{}, issue {}", number(document, Some(part(report))), document.issue)
}

/// Number and issue of the whole.
pub fn mark_of_study(document: &StudyDocument) -> String {
    format!("{}, issue {}", number(document, None), document.issue)
}

fn part<'a>(report: &'a PassReport<'_>) -> &'a str {
    report.pass_file.trim_end_matches(".json")
}

fn number(document: &StudyDocument, part: Option<&str>) -> String {
    match part {
        Some(part) => format!("{}, part {part}", document.number),
        None => document.number.clone(),
    }
}

fn with_part(document: &StudyDocument, part: Option<&str>) -> Vec<(Text, Text)> {
    let signed = |name: &Option<String>| name.clone().unwrap_or_else(|| NOT_SIGNED.to_owned());
    let mut entries = vec![
        ("Document", document.title.clone()),
        ("Number", number(document, part)),
        ("Issue", document.issue.clone()),
        ("Date", document.date.clone()),
    ];
    let optional = [("Project", &document.project), ("Organisation", &document.organisation)];
    entries.extend(optional.into_iter().filter_map(|(term, text)| Some((term, text.clone()?))));
    entries.extend([
        ("Author", signed(&document.author)),
        ("Checked", signed(&document.checker)),
        ("Approved", signed(&document.approver)),
    ]);
    entries.extend(document.licence.clone().map(|licence| ("Licence", licence)));
    entries.into_iter().map(|(term, text)| (term.into(), text.into())).collect()
}
