//! Errors and warnings at their places, collected and shown in the source.

use std::borrow::Cow;

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use serde::Serialize;

use super::code::Code;
use super::source::{Place, floor_boundary};
use super::suggest;
use super::visible::{escaped, is_hidden, shortened};
use crate::math::sort::sort_by_key;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, PartialOrd, Ord)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Nothing can be run.
    Error,
    /// Worth a look; runs.
    Warning,
}

/// One finding in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// Which kind of finding (`bmv explain CODE`).
    pub code: &'static Code,
    /// Error or warning.
    pub severity: Severity,
    /// Where.
    pub place: Place,
    /// What is wrong, lower-case, with the offending value.
    pub message: String,
    /// What was expected there; shown under the place.
    pub expected: Option<String>,
    /// What to write instead.
    pub help: Option<String>,
    /// Other places that belong to it, with what they are.
    pub related: Vec<(Place, String)>,
}

impl Diagnostic {
    /// An error.
    pub fn error(code: &'static Code, place: &Place, message: impl Into<String>) -> Self {
        Self {
            code,
            severity: Severity::Error,
            place: place.clone(),
            message: message.into(),
            expected: None,
            help: None,
            related: Vec::new(),
        }
    }

    /// A warning.
    pub fn warning(code: &'static Code, place: &Place, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(code, place, message) }
    }

    /// Adds what was expected.
    pub fn expected(mut self, text: impl Into<String>) -> Self {
        self.expected = Some(text.into());
        self
    }

    /// Adds what to write instead.
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }

    /// Adds a suggestion, where there is one: "did you mean `x`?".
    pub fn suggest(self, name: Option<&str>) -> Self {
        match name {
            Some(name) => self.help(format!("did you mean `{name}`?")),
            None => self,
        }
    }

    /// Adds another place.
    pub fn related(mut self, place: &Place, what: impl Into<String>) -> Self {
        self.related.push((place.clone(), what.into()));
        self
    }

    /// The finding as text in its source, coloured for a terminal or plain.
    pub fn render(&self, coloured: bool) -> String {
        let level = match self.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let label = self.expected.as_deref().map(visible).unwrap_or_default();
        let mut group = Group::with_title(level.primary_title(visible(&self.message)).id(self.code.name));
        group = shown(group, &self.place, AnnotationKind::Primary, label);
        for (place, what) in &self.related {
            group = shown(group, place, AnnotationKind::Context, visible(what));
        }
        if !self.place.path.is_empty() {
            group = group.element(Level::NOTE.message(visible(&format!("at {}", self.place.path))));
        }
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(visible(help)));
        }
        let renderer = if coloured { Renderer::styled() } else { Renderer::plain() };
        renderer.render(&[group])
    }

    /// The finding as data.
    pub fn plain(&self) -> PlainDiagnostic {
        let position = self.place.position();
        PlainDiagnostic {
            code: self.code.name.to_owned(),
            severity: self.severity,
            file: self.place.source.name().to_owned(),
            line: position.line,
            column: position.column,
            path: self.place.path.to_string(),
            message: self.message.clone(),
            expected: self.expected.clone(),
            help: self.help.clone(),
        }
    }
}

/// A text of a message as it is printed: short enough to be read, without anything that steers a terminal. Whoever
/// writes a message need not think of it.
fn visible(text: &str) -> String {
    escaped(&shortened(text)).into_owned()
}

/// Lines of a source longer than this are shown around the place only, in bytes.
const WIDE: usize = 2000;

/// Bytes of a cut line shown before and behind the place.
const AROUND: usize = 60;

/// Adds the line of a place with its mark.
fn shown<'a>(group: Group<'a>, place: &'a Place, kind: AnnotationKind, label: String) -> Group<'a> {
    let text = place.source.text();
    let start = floor_boundary(text, place.span.start);
    let end = floor_boundary(text, place.span.end).max(start);
    let mut first = text[..start].rfind('\n').map_or(0, |i| i + 1);
    // A mark over many lines hides what it means: the first line is enough.
    let line_end = text[start..].find('\n').map_or(text.len(), |i| start + i);
    let mut last = line_end;
    let end = end.min(line_end);
    let cut = last - first > WIDE;
    if cut {
        first = floor_boundary(text, start.saturating_sub(AROUND).max(first));
        last = floor_boundary(text, (start + AROUND).max(end.min(start + WIDE)).min(last));
    }
    let position = place.position();
    let end = end.min(last);
    let label = if label.is_empty() { None } else { Some(label) };
    // Each hidden character becomes one of three bytes, so that the line keeps its columns.
    let part = |from: usize, to: usize| -> String { text[from..to].chars().map(drawn).collect() };
    let (before, marked) = (part(first, start), part(start, end));
    let span = before.len()..before.len() + marked.len();
    let snippet = Snippet::source(before + &marked + &part(end, last))
        .line_start(position.line)
        .annotation(kind.span(span).label(label));
    let name = visible(place.source.name());
    if cut {
        // Columns of a part of the line would be wrong: the place is given apart.
        let origin = Origin::path(name).line(position.line).char_column(position.column);
        return group.element(origin).element(snippet);
    }
    group.element(snippet.path(name))
}

/// A character of a source as it is drawn: a hidden one as U+FFFD; blanks stay.
fn drawn(character: char) -> char {
    if is_hidden(character) && !matches!(character, '\t' | '\r' | '\n') {
        char::REPLACEMENT_CHARACTER
    } else {
        character
    }
}

/// A finding as data, for `--json` and tests. Lines and columns count from 1, columns in characters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlainDiagnostic {
    /// Which kind of finding.
    pub code: String,
    /// Error or warning.
    pub severity: Severity,
    /// File as shown.
    pub file: String,
    /// Line.
    pub line: usize,
    /// Column.
    pub column: usize,
    /// JSON path; empty outside JSON.
    pub path: String,
    /// What is wrong.
    pub message: String,
    /// What was expected.
    pub expected: Option<String>,
    /// What to write instead.
    pub help: Option<String>,
}

/// No more findings than this are kept; the rest is counted.
pub const KEPT: usize = 1000;

/// Behind so many errors no name is suggested any more.
const SUGGESTED: usize = 100;

/// An empty name in backticks, which says nothing.
const NO_NAME: &str = "``";

/// The findings of a run over some files.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
    errors: usize,
    warnings: usize,
}

impl Diagnostics {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a finding; of very long texts the beginning and the end are kept, and an empty name is said to be one.
    pub fn push(&mut self, mut diagnostic: Diagnostic) {
        match diagnostic.severity {
            Severity::Error => self.errors += 1,
            Severity::Warning => self.warnings += 1,
        }
        if self.list.len() < KEPT {
            for text in [Some(&mut diagnostic.message), diagnostic.expected.as_mut(), diagnostic.help.as_mut()] {
                let Some(text) = text else { continue };
                if text.contains(NO_NAME) {
                    *text = text.replace(NO_NAME, "(an empty name)");
                }
                if let Cow::Owned(short) = shortened(text) {
                    *text = short;
                }
            }
            self.list.push(diagnostic);
        }
    }

    /// Adds a finding, unless it is here already.
    pub fn push_once(&mut self, diagnostic: Diagnostic) {
        if !self.list.contains(&diagnostic) {
            self.push(diagnostic);
        }
    }

    /// Adds all findings of another collection that are not here yet: of a file that several others name, each thing is
    /// said once.
    pub fn extend(&mut self, other: &Self) {
        let mut kept = 0;
        for diagnostic in &other.list {
            kept += 1;
            self.push_once(diagnostic.clone());
        }
        // What was not kept there cannot be compared.
        let errors = other.list.iter().filter(|diagnostic| diagnostic.severity == Severity::Error).count();
        self.errors += other.errors - errors;
        self.warnings += other.warnings - (kept - errors);
    }

    /// The findings without those of another collection.
    pub fn without(&self, other: &Self) -> Self {
        let mut rest = self.clone();
        rest.list.retain(|diagnostic| !other.list.contains(diagnostic));
        let errors =
            |list: &[Diagnostic]| list.iter().filter(|diagnostic| diagnostic.severity == Severity::Error).count();
        let said = self.list.len() - rest.list.len();
        let errors_said = errors(&self.list) - errors(&rest.list);
        rest.errors -= errors_said;
        rest.warnings -= said - errors_said;
        rest
    }

    /// The candidate nearest to a name that nothing has, for a suggestion. Behind a hundred errors there is none: nobody
    /// reads so far, and among many names each takes its time.
    pub fn nearest<'a>(&self, name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
        if self.errors < SUGGESTED { suggest::nearest(name, candidates) } else { None }
    }

    /// Number of errors.
    pub fn errors(&self) -> usize {
        self.errors
    }

    /// Number of warnings.
    pub fn warnings(&self) -> usize {
        self.warnings
    }

    /// Whether there is an error.
    pub fn has_errors(&self) -> bool {
        self.errors > 0
    }

    /// Whether there is nothing.
    pub fn is_empty(&self) -> bool {
        self.errors + self.warnings == 0
    }

    /// The findings, errors first, then file by file (in the order in which they first appear) from top to bottom.
    pub fn sorted(&self) -> Vec<&Diagnostic> {
        let mut files: Vec<&str> = Vec::new();
        for diagnostic in &self.list {
            if !files.contains(&diagnostic.place.source.name()) {
                files.push(diagnostic.place.source.name());
            }
        }
        let rank = |d: &Diagnostic| files.iter().position(|f| *f == d.place.source.name());
        let mut sorted: Vec<&Diagnostic> = self.list.iter().collect();
        sort_by_key(&mut sorted, |d| (d.severity, rank(d), d.place.span.start));
        sorted
    }

    /// All findings as text, at most `most` of them, then how many more there are.
    pub fn render(&self, coloured: bool, most: usize) -> String {
        let mut out = String::new();
        for diagnostic in self.sorted().into_iter().take(most) {
            out.push_str(&diagnostic.render(coloured));
            out.push_str("\n\n");
        }
        let hidden = (self.errors + self.warnings).saturating_sub(most.min(self.list.len()));
        if hidden > 0 {
            out.push_str(&format!("and {hidden} more\n"));
        }
        out
    }

    /// All findings as data, in the order of [`Self::sorted`].
    pub fn plain(&self) -> Vec<PlainDiagnostic> {
        self.sorted().into_iter().map(Diagnostic::plain).collect()
    }
}
