//! The document that the reports of a study belong to: `document.json`, format `bmv-document/1`. It says what a title
//! block says, and what people write of the test. No job reads it: who signs does not decide a result.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::document::{Diagnostic, Diagnostics, Map, Spanned, code, read_file, written_struct};

use super::folder::Folder;
use super::inherit::unnamed_file_diagnostic;

/// The file's name within the study.
pub const FILE: &str = "document.json";
/// The format's name in the file.
const FORMAT: &str = "bmv-document/1";
/// Most characters of an entry of the title block.
const LONGEST: usize = 300;
/// Most characters of the summary.
const LONGEST_SUMMARY: usize = 2000;
/// Most characters of an assumption.
const LONGEST_ASSUMPTION: usize = 600;
/// Most assumptions.
const MOST_ASSUMPTIONS: usize = 100;

written_struct! {
    /// The title block of a study's reports, and what people write of its test.
    pub struct DocumentForm: "a document" {
        /// `bmv-document/1`.
        required format: String,
        /// Title of the whole.
        required title: Spanned<String>,
        /// Number of the document.
        required number: Spanned<String>,
        /// Issue or revision.
        required issue: Spanned<String>,
        /// Day of issue, `2026-06-30`.
        required date: Spanned<String>,
        /// Project.
        optional project: Spanned<String>,
        /// Who issues it.
        optional organisation: Spanned<String>,
        /// Who wrote it; not yet signed where it is left out, as the next two.
        optional author: Spanned<String>,
        /// Who checked it.
        optional checker: Spanned<String>,
        /// Who approved it.
        optional approver: Spanned<String>,
        /// Licence of the reports, such as `CC-BY-4.0` or an address.
        optional licence: Spanned<String>,
        /// What it is about, in a few sentences.
        optional summary: Spanned<String>,
        /// Documents that bind.
        default(Vec::new()) applicable_documents: Vec<ReferenceForm>,
        /// Documents that inform.
        default(Vec::new()) reference_documents: Vec<ReferenceForm>,
        /// Assumptions, a sentence each.
        default(Vec::new()) assumptions: Vec<Spanned<String>>,
        /// The test in words.
        optional test: TestForm,
        /// Set where what stands here was reconstructed: what and how.
        optional reconstructed: String,
        /// Passes whose reports are not kept with the others, each with the reason; the index leaves them out.
        default(Map::default()) not_archived: Map<String>,
        /// Where the figures and tables of another document have their counterparts in the reports.
        optional counterparts: CounterpartsForm,
    }
}

written_struct! {
    /// Counterparts of the figures and tables of another document.
    pub struct CounterpartsForm: "counterparts" {
        /// Which document, such as `Stout 2015, chapter 5`.
        required of: String,
        /// Its items in order; an item with several counterparts stands several times.
        required items: Vec<Spanned<CounterpartForm>>,
    }
}

written_struct! {
    /// A figure or table of another document, and its counterpart.
    pub struct CounterpartForm: "an item with its counterpart" {
        /// Its number there, such as `Figure 5-2`.
        required item: String,
        /// What it shows, by its title.
        required title: String,
        /// The study whose reports show the same, where it is not this one.
        optional study: Spanned<String>,
        /// The pass.
        optional pass: Spanned<String>,
        /// The figure, by the name of its file in `plots` without `.svg`.
        optional figure: Spanned<String>,
        /// Or the section, by its anchor in the report.
        optional section: Spanned<String>,
        /// In what the counterpart differs.
        optional note: String,
        /// Why there is no counterpart.
        optional none: Spanned<String>,
    }
}

written_struct! {
    /// A document that is referred to.
    pub struct ReferenceForm: "a reference to a document" {
        /// Number.
        required number: String,
        /// Title.
        required title: String,
        /// Issue or year.
        optional issue: String,
    }
}

written_struct! {
    /// The test in words.
    pub struct TestForm: "a description of the test" {
        /// What was tested.
        optional article: String,
        /// Where.
        optional facility: String,
        /// Sensors, their places and calibration, acquisition.
        optional instrumentation: String,
        /// When a phase counted as steady.
        optional stabilisation: String,
    }
}

/// The document of a study.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StudyDocument {
    /// Title.
    pub title: String,
    /// Number.
    pub number: String,
    /// Issue.
    pub issue: String,
    /// Day of issue, `YYYY-MM-DD`.
    pub date: String,
    /// Project.
    pub project: Option<String>,
    /// Who issues it.
    pub organisation: Option<String>,
    /// Who wrote it; `None`: not yet signed, as the next two.
    pub author: Option<String>,
    /// Who checked it.
    pub checker: Option<String>,
    /// Who approved it.
    pub approver: Option<String>,
    /// Licence of the reports.
    pub licence: Option<String>,
    /// What it is about.
    pub summary: Option<String>,
    /// Documents that bind.
    pub applicable: Vec<Reference>,
    /// Documents that inform.
    pub references: Vec<Reference>,
    /// Assumptions.
    pub assumptions: Vec<String>,
    /// The test in words: what about it, and the text.
    pub test: Vec<(String, String)>,
    /// What of this was reconstructed, and how.
    pub reconstructed: Option<String>,
    /// Files of passes whose reports are not kept with the others, each with the reason.
    pub not_archived: Vec<(String, String)>,
    /// The document whose figures and tables have counterparts in the reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counterparts_of: Option<String>,
    /// Those figures and tables.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub counterparts: Vec<Counterpart>,
}

/// A figure or table of another document.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counterpart {
    /// Its number there.
    pub item: String,
    /// What it shows.
    pub title: String,
    /// Where the reports show the same.
    pub shown: Shown,
    /// In what the counterpart differs.
    pub note: Option<String>,
}

/// Where reports show something.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shown {
    /// In the report of a pass.
    In {
        /// The study; `None` for the own one.
        study: Option<String>,
        /// File of the pass.
        pass: String,
        /// The figure's name, or the section's anchor.
        anchor: String,
        /// Whether it is a figure.
        is_figure: bool,
    },
    /// Nowhere, and why.
    Nowhere(String),
}

/// A document that is referred to.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reference {
    /// Number.
    pub number: String,
    /// Title.
    pub title: String,
    /// Issue or year; may be empty.
    pub issue: String,
}

impl StudyDocument {
    /// Why the report of a pass is not kept with the others; `None` where it is.
    pub fn not_archived(&self, pass: &str) -> Option<&str> {
        self.not_archived.iter().find(|(file, _)| file == pass).map(|(_, why)| why.as_str())
    }
}

/// The document of a study, where it has one.
pub fn load(folder: &Folder, diagnostics: &mut Diagnostics) -> Option<Arc<StudyDocument>> {
    if !folder.has_file(FILE) {
        return None;
    }
    let bytes = match folder.read(FILE) {
        Ok(bytes) => bytes,
        Err(error) => {
            diagnostics.push(unnamed_file_diagnostic(folder, FILE, &error));
            return None;
        }
    };
    let (form, _) = read_file::<DocumentForm>(&folder.shown_name(FILE), &bytes, FORMAT, diagnostics)?;
    Some(Arc::new(form.resolve(folder, diagnostics)))
}

impl DocumentForm {
    fn resolve(self, folder: &Folder, diagnostics: &mut Diagnostics) -> StudyDocument {
        for (what, text) in [("title", &self.title), ("number", &self.number), ("issue", &self.issue)] {
            if text.value.trim().is_empty() {
                let message = format!("the document has no {what}");
                diagnostics.push(
                    Diagnostic::error(&code::DOCUMENT_FILE, &text.place, message).expected(format!("its {what}")),
                );
            }
        }
        let block = [Some(&self.title), Some(&self.number), Some(&self.issue), self.project.as_ref()];
        let people = [&self.organisation, &self.author, &self.checker, &self.approver, &self.licence];
        let mut limit = |text: &Spanned<String>, what: &str, longest: usize, instead: &str| {
            let length = text.value.chars().count();
            if length > longest {
                diagnostics.push(
                    Diagnostic::error(&code::DOCUMENT_FILE, &text.place, format!("{what} with {length} characters"))
                        .expected(format!("at most {longest} characters"))
                        .help(instead),
                );
            }
        };
        for text in block.into_iter().chain(people.map(Option::as_ref)).flatten() {
            limit(text, "an entry of the title block", LONGEST, "longer texts have their place in `summary`");
        }
        if let Some(text) = &self.summary {
            let instead = "say what the document is about; longer texts have their place in `test`, or in the passes' `description`";
            limit(text, "a summary", LONGEST_SUMMARY, instead);
        }
        for text in self.assumptions.iter().take(MOST_ASSUMPTIONS) {
            limit(
                text,
                "an assumption",
                LONGEST_ASSUMPTION,
                "write a sentence, and an entry of its own for each assumption",
            );
        }
        if let Some(text) = self.assumptions.get(MOST_ASSUMPTIONS) {
            let message = format!("{} assumptions", self.assumptions.len());
            diagnostics.push(
                Diagnostic::error(&code::DOCUMENT_FILE, &text.place, message)
                    .expected(format!("at most {MOST_ASSUMPTIONS}"))
                    .help("refer to the document that lists them, under `reference_documents`"),
            );
        }
        if !is_day(&self.date.value) {
            let message = format!("`{}` is no day", self.date.value);
            diagnostics.push(
                Diagnostic::error(&code::DOCUMENT_FILE, &self.date.place, message)
                    .expected("year, month and day, such as \"2026-06-30\""),
            );
        }
        for entry in &self.not_archived {
            let is_pass = super::discover::number(std::path::Path::new(&entry.name)).is_some();
            if !is_pass || !folder.has_file(&entry.name) {
                let message = format!("the study has no pass `{}`", entry.name);
                let expected = "the file of a pass, such as \"pass-1.json\"";
                diagnostics
                    .push(Diagnostic::error(&code::DOCUMENT_FILE, &entry.name_place, message).expected(expected));
            }
        }
        let (counterparts_of, counterparts) = match self.counterparts {
            Some(form) => {
                let items = form.items.into_iter().filter_map(|item| counterpart(item, folder, diagnostics));
                (Some(form.of), items.collect())
            }
            None => (None, Vec::new()),
        };
        let reference = |form: ReferenceForm| Reference {
            number: form.number,
            title: form.title,
            issue: form.issue.unwrap_or_default(),
        };
        let test = self.test.map_or_else(Vec::new, |test| {
            let parts = [
                ("Test article", test.article),
                ("Facility", test.facility),
                ("Instrumentation", test.instrumentation),
                ("Stabilisation", test.stabilisation),
            ];
            parts.into_iter().filter_map(|(what, text)| Some((what.to_owned(), text?))).collect()
        });
        StudyDocument {
            title: self.title.value,
            number: self.number.value,
            issue: self.issue.value,
            date: self.date.value,
            project: self.project.map(|text| text.value),
            organisation: self.organisation.map(|text| text.value),
            author: self.author.map(|text| text.value),
            checker: self.checker.map(|text| text.value),
            approver: self.approver.map(|text| text.value),
            licence: self.licence.map(|text| text.value),
            summary: self.summary.map(|text| text.value),
            applicable: self.applicable_documents.into_iter().map(reference).collect(),
            references: self.reference_documents.into_iter().map(reference).collect(),
            assumptions: self.assumptions.into_iter().map(|text| text.value).collect(),
            test,
            reconstructed: self.reconstructed,
            not_archived: (self.not_archived.iter()).map(|entry| (entry.name.clone(), entry.value.clone())).collect(),
            counterparts_of,
            counterparts,
        }
    }
}

/// An item with its counterpart: a pass with a figure or a section of it, or why there is none.
fn counterpart(item: Spanned<CounterpartForm>, folder: &Folder, diagnostics: &mut Diagnostics) -> Option<Counterpart> {
    let Spanned { value: form, place } = item;
    let anchor = match (form.figure, form.section) {
        (Some(figure), None) => Some((figure.value, true)),
        (None, Some(section)) => Some((section.value, false)),
        (None, None) => None,
        (Some(_), Some(section)) => {
            let message = format!("`{}` names a figure and a section", form.item);
            diagnostics
                .push(Diagnostic::error(&code::DOCUMENT_FILE, &section.place, message).expected("one of the two"));
            return None;
        }
    };
    let shown = match (form.none, form.pass, anchor) {
        (Some(why), None, None) if form.study.is_none() && !why.value.trim().is_empty() => Shown::Nowhere(why.value),
        (None, Some(pass), Some((anchor, is_figure))) => {
            if form.study.is_none() && !folder.has_file(&pass.value) {
                let message = format!("the study has no pass `{}`", pass.value);
                let diagnostic = Diagnostic::error(&code::DOCUMENT_FILE, &pass.place, message)
                    .expected("the file of a pass, such as \"pass-1.json\"")
                    .help("a pass of another study needs its name beside it: \"study\": \"NAME\"");
                diagnostics.push(diagnostic);
                return None;
            }
            Shown::In { study: form.study.map(|study| study.value), pass: pass.value, anchor, is_figure }
        }
        _ => {
            let message = format!("where `{}` has its counterpart is not clear", form.item);
            let diagnostic = Diagnostic::error(&code::DOCUMENT_FILE, &place, message)
                .expected("`pass` with either `figure` or `section`, or `none` with the reason")
                .help(
                    "{\"item\": \"Figure 3\", \"title\": \"...\", \"pass\": \"pass-1.json\", \"figure\": \"network\"}",
                );
            diagnostics.push(diagnostic);
            return None;
        }
    };
    Some(Counterpart { item: form.item, title: form.title, shown, note: form.note })
}

/// Whether a text is a day of the Gregorian calendar as ISO 8601 writes it.
pub fn is_day(text: &str) -> bool {
    let parts: Vec<&str> = text.split('-').collect();
    let [year, month, day] = parts.as_slice() else { return false };
    let number = |text: &str, digits: usize| {
        let is_plain = text.len() == digits && text.bytes().all(|byte| byte.is_ascii_digit());
        if is_plain { text.parse::<u32>().ok() } else { None }
    };
    let (Some(year), Some(month), Some(day)) = (number(year, 4), number(month, 2), number(day, 2)) else {
        return false;
    };
    let is_leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let days = match month {
        1 | 3 | 5 | 7 | 8 | 10 | 12 => 31,
        4 | 6 | 9 | 11 => 30,
        2 if is_leap => 29,
        2 => 28,
        _ => 0,
    };
    (1..=days).contains(&day)
}
