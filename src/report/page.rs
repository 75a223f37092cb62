//! The document that sections build and that Markdown and HTML are made of. Text is always made here from pieces,
//! never parsed, so nothing that a study writes can become markup.

use crate::math::sort::sort_by;
use serde::{Deserialize, Serialize};

use super::plot::Drawing;

/// A piece of running text.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", content = "text", rename_all = "snake_case")]
pub enum Inline {
    /// As it is.
    Plain(String),
    /// Strong.
    Strong(String),
    /// A name or a value as it stands in a file.
    Code(String),
    /// A link to another page of the reports.
    Link {
        /// What is read.
        text: String,
        /// The page, from this one's folder: `pass-2/report`, without the ending, which is that of the page itself.
        page: String,
        /// The place in it, an anchor; empty for its beginning.
        anchor: String,
    },
}

/// Running text.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Text(pub Vec<Inline>);

impl Text {
    /// Text of one plain piece.
    pub fn new(text: impl Into<String>) -> Self {
        Self(vec![Inline::Plain(text.into())])
    }

    /// Text of a finding, in which names stand between backticks.
    pub fn with_names(text: &str) -> Self {
        let parts: Vec<&str> = text.split('`').collect();
        if parts.len().is_multiple_of(2) {
            // A backtick without its other one is no sign of a name.
            return Self::new(text);
        }
        parts.iter().enumerate().filter(|(_, part)| !part.is_empty()).fold(Self::default(), |text, (place, part)| {
            if place.is_multiple_of(2) { text.plain(*part) } else { text.code(*part) }
        })
    }

    /// Appends plain text.
    pub fn plain(mut self, text: impl Into<String>) -> Self {
        self.0.push(Inline::Plain(text.into()));
        self
    }

    /// Appends strong text.
    pub fn strong(mut self, text: impl Into<String>) -> Self {
        self.0.push(Inline::Strong(text.into()));
        self
    }

    /// Appends another text, if there is one.
    pub fn joined(mut self, other: Option<Self>) -> Self {
        self.0.extend(other.into_iter().flat_map(|other| other.0));
        self
    }

    /// The text without its marks.
    pub fn in_plain_words(&self) -> String {
        let pieces = self.0.iter().map(|piece| match piece {
            Inline::Plain(text) | Inline::Strong(text) | Inline::Code(text) | Inline::Link { text, .. } => {
                text.as_str()
            }
        });
        pieces.collect()
    }

    /// Appends a link to another page of the reports, named by the parts of its path from this one's folder.
    pub fn link(self, text: impl Into<String>, parts: &[&str]) -> Self {
        self.link_into(text, parts, "")
    }

    /// Appends a link to a place of the same page, by its anchor.
    pub fn link_here(mut self, text: impl Into<String>, anchor: &str) -> Self {
        self.0.push(Inline::Link { text: text.into(), page: String::new(), anchor: encoded(anchor) });
        self
    }

    /// The same to a section or a figure of that page, by its anchor.
    pub fn link_into(mut self, text: impl Into<String>, parts: &[&str], anchor: &str) -> Self {
        let page = parts.iter().map(|part| encoded(part)).collect::<Vec<_>>().join("/");
        self.0.push(Inline::Link { text: text.into(), page, anchor: encoded(anchor) });
        self
    }

    /// Appends a name or value as in a file.
    pub fn code(mut self, text: impl Into<String>) -> Self {
        self.0.push(Inline::Code(text.into()));
        self
    }
}

/// A part of a path as a relative address has it (RFC 3986): all but unreserved characters as their bytes.
pub fn encoded(part: &str) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~".contains(&byte);
    let one = |byte: u8| if is_plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") };
    part.bytes().map(one).collect()
}

impl From<&str> for Text {
    fn from(text: &str) -> Self {
        Self::new(text)
    }
}

impl From<String> for Text {
    fn from(text: String) -> Self {
        Self::new(text)
    }
}

/// How a value stands against what is asked of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Kept.
    Ok,
    /// Worth a look.
    Caution,
    /// Not kept.
    Fail,
}

impl Status {
    /// `Ok` or `Fail`.
    pub fn kept(kept: bool) -> Self {
        if kept { Self::Ok } else { Self::Fail }
    }
}

/// A cell of a table.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Cell {
    /// Contents.
    pub text: Text,
    /// Highlight, if any.
    pub status: Option<Status>,
}

impl Cell {
    /// A highlighted cell.
    pub fn marked(text: impl Into<Text>, status: Status) -> Self {
        Self { text: text.into(), status: Some(status) }
    }

    /// A cell with a name as in a file.
    pub fn code(text: impl Into<String>) -> Self {
        Self { text: Text::default().code(text), status: None }
    }
}

impl<T: Into<Text>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self { text: text.into(), status: None }
    }
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Column {
    /// Heading.
    pub title: String,
    /// Unit of all its numbers, typeset; empty without one.
    pub unit: String,
    /// Whether it holds numbers, which stand to the right.
    pub is_numeric: bool,
}

impl Column {
    /// A column of text.
    pub fn text(title: impl Into<String>) -> Self {
        Self { title: title.into(), unit: String::new(), is_numeric: false }
    }

    /// A column of numbers of a unit.
    pub fn number(title: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { title: title.into(), unit: unit.into(), is_numeric: true }
    }
}

/// A table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// Caption.
    pub caption: Text,
    /// Columns.
    pub columns: Vec<Column>,
    /// Rows, a cell a column.
    pub rows: Vec<Vec<Cell>>,
}

/// Rows above which a table keeps its worst ones.
const MANY_ROWS: usize = 40;
/// So many of them.
const WORST_ROWS: usize = 20;

impl Table {
    /// The table with its worst rows alone, worst first, where it has very many: `sizes` says of each row how bad it is. The
    /// caption says how many are left out, and where they are.
    pub fn cut(mut self, sizes: &[f64]) -> Self {
        if self.rows.len() <= MANY_ROWS || sizes.len() != self.rows.len() {
            return self;
        }
        let all = self.rows.len();
        let mut rows: Vec<(f64, Vec<Cell>)> = sizes.iter().copied().zip(std::mem::take(&mut self.rows)).collect();
        // Equal ones keep their order; what is no number comes first.
        sort_by(&mut rows, |a, b| b.0.total_cmp(&a.0));
        self.rows = rows.into_iter().take(WORST_ROWS).map(|(_, row)| row).collect();
        self.caption = self
            .caption
            .plain(format!(" The worst {WORST_ROWS} of {all} rows; all are in "))
            .code("results.json")
            .plain(".");
        self
    }
}

/// A figure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Name, of letters, digits and `-`; made unique when the page is numbered.
    pub id: String,
    /// The drawing.
    pub drawing: Drawing,
    /// Caption.
    pub caption: Text,
    /// What it shows, for those who do not see it.
    pub alternative: String,
}

/// What a callout is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Tone {
    /// The outcome.
    Verdict,
    /// What to do next.
    Next,
    /// Something that limits what the results mean.
    Warning,
    /// An explanation.
    Note,
    /// Numbers that were reconstructed, not taken from their source.
    Reconstructed,
}

impl Tone {
    /// The word before the text.
    pub fn word(self) -> &'static str {
        match self {
            Self::Verdict => "Verdict",
            Self::Next => "Next",
            Self::Warning => "Warning",
            Self::Note => "Note",
            Self::Reconstructed => "Reconstructed",
        }
    }
}

/// A key statement: something large to read, and what it means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Statement {
    /// What it is about, in a few words.
    pub label: String,
    /// The number or word.
    pub value: String,
    /// What it means.
    pub text: Text,
    /// How it stands.
    pub status: Option<Status>,
}

/// A part of a section.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// A heading below the section's.
    Heading(String),
    /// A paragraph.
    Paragraph(Text),
    /// Small print to the table or the figures before it.
    Small(Text),
    /// Unordered items.
    List(Vec<Text>),
    /// A table.
    Table(Table),
    /// A figure.
    Figure(Figure),
    /// Figures that stand beside one another.
    Beside(Vec<Figure>),
    /// A callout.
    Callout(Tone, Text),
    /// Key statements beside one another.
    Statements(Vec<Statement>),
    /// Terms and what they mean.
    Definitions(Vec<(Text, Text)>),
    /// Blocks that are folded away in HTML.
    Details(String, Vec<Block>),
}

impl Block {
    /// A paragraph.
    pub fn paragraph(text: impl Into<Text>) -> Self {
        Self::Paragraph(text.into())
    }

    /// A callout.
    pub fn callout(tone: Tone, text: impl Into<Text>) -> Self {
        Self::Callout(tone, text.into())
    }
}

/// A section.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Anchor, of letters, digits and `-`.
    pub id: &'static str,
    /// Title.
    pub title: String,
    /// Parts.
    pub blocks: Vec<Block>,
}

/// The whole report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    /// Title.
    pub title: String,
    /// Line below it.
    pub subtitle: Text,
    /// Links to the pages round it; empty without any.
    pub links: Text,
    /// Terms and entries of the title block; empty without one.
    pub title_block: Vec<(Text, Text)>,
    /// What identifies the document at the foot of every printed page; empty without a title block.
    pub mark: String,
    /// Line at the foot.
    pub footer: Text,
    /// Sections in order.
    pub sections: Vec<Section>,
    /// Sections of the appendix, which are lettered: what is looked up, and what is left of a section that stands in part
    /// before it.
    pub appendix: Vec<Section>,
}

/// A section at its place in the page.
#[derive(Clone, Debug)]
pub struct Placed<'p> {
    /// The section.
    pub section: &'p Section,
    /// Its number, or letter in the appendix.
    pub number: String,
    /// Its anchor; of the rest of a section another than that of its first part.
    pub anchor: String,
    /// Its title.
    pub title: String,
    /// Whether the appendix begins with it.
    pub begins_appendix: bool,
}

impl Page {
    /// The sections in the order in which they stand, with numbers and anchors.
    pub fn placed(&self) -> impl Iterator<Item = Placed<'_>> {
        let body = self.sections.iter().enumerate().map(|(at, section)| Placed {
            section,
            number: (at + 1).to_string(),
            anchor: section.id.to_owned(),
            title: section.title.clone(),
            begins_appendix: false,
        });
        let appendix = self.appendix.iter().enumerate().map(|(at, section)| {
            let is_rest = self.sections.iter().any(|own| own.id == section.id);
            Placed {
                section,
                number: letter(at),
                anchor: if is_rest { rest_of(section.id) } else { section.id.to_owned() },
                title: if is_rest { format!("{}: details", section.title) } else { section.title.clone() },
                begins_appendix: at == 0,
            }
        });
        body.chain(appendix)
    }
}

/// The anchor of what the appendix has of a section.
pub fn rest_of(id: &str) -> String {
    format!("{id}-details")
}

/// The letter of a section of the appendix; after Z comes AA.
pub fn letter(at: usize) -> String {
    let own = char::from(b'A' + (at % 26) as u8).to_string();
    if at < 26 { own } else { letter(at / 26 - 1) + &own }
}

/// Runs through a page's blocks and hands out numbers of figures and tables in order.
#[derive(Debug, Default)]
pub struct Numbering {
    figures: usize,
    tables: usize,
    names: Vec<String>,
}

impl Numbering {
    /// Number and unique name of the next figure.
    pub fn figure(&mut self, figure: &Figure) -> (usize, String) {
        self.figures += 1;
        let name = free(&slug(&figure.id), |name| self.names.contains(name));
        self.names.push(name.clone());
        (self.figures, name)
    }

    /// Number of the next table.
    pub fn table(&mut self) -> usize {
        self.tables += 1;
        self.tables
    }
}

/// A name of lower-case letters, digits and `-`, at most 60 bytes: safe as an anchor and as a file's name.
pub fn slug(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        if out.len() >= 60 {
            break;
        }
        if c.is_ascii_alphanumeric() {
            out.push(c.to_ascii_lowercase());
        } else if !out.is_empty() && !out.ends_with('-') {
            out.push('-');
        }
    }
    let trimmed = out.trim_end_matches('-');
    if trimmed.is_empty() { "figure".to_owned() } else { trimmed.to_owned() }
}

/// A name, with a number behind it where it is given already.
pub fn free(base: &str, is_given: impl Fn(&String) -> bool) -> String {
    let mut name = base.to_owned();
    let mut copy = 1;
    while is_given(&name) {
        copy += 1;
        name = format!("{base}-{copy}");
    }
    name
}

/// The figures of a page with their unique names, in order.
pub fn figures(page: &Page) -> Vec<(String, &Figure)> {
    fn walk<'a>(blocks: &'a [Block], numbering: &mut Numbering, out: &mut Vec<(String, &'a Figure)>) {
        for block in blocks {
            match block {
                Block::Figure(figure) => out.push((numbering.figure(figure).1, figure)),
                Block::Beside(figures) => out.extend(figures.iter().map(|own| (numbering.figure(own).1, own))),
                Block::Details(_, blocks) => walk(blocks, numbering, out),
                _ => {}
            }
        }
    }
    let (mut numbering, mut out) = (Numbering::default(), Vec::new());
    for section in page.sections.iter().chain(&page.appendix) {
        walk(&section.blocks, &mut numbering, &mut out);
    }
    out
}
