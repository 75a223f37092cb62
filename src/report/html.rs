//! The page as one HTML file that needs nothing else: style, drawings and a small script inside, no network.

use serde::Serialize;
use thiserror::Error;

use crate::document::visible::escaped_lines;

use super::page::{Block, Cell, Column, Figure, Inline, Numbering, Page, Placed, Status, Table, Text, Tone};
use super::script;

const TEMPLATE: &str = include_str!("../../templates/report.html");
const STYLE: &str = include_str!("../../templates/report.css");
/// Numbers behind a figure that are this long or longer, bytes of CSV, are linked and not held in the page.
const LINKED_FROM: usize = 24 << 10;
/// Where the content begins.
pub const MAIN: &str = "<main id=\"content\" tabindex=\"-1\">";

/// Why a page could not be rendered.
#[derive(Debug, Error)]
pub enum HtmlError {
    /// The template does not fit what it is given.
    #[error("the report's template failed: {0}")]
    Template(#[from] tera::Error),
}

/// Where the numbers behind figures can be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beside {
    /// A file of each figure's numbers lies beside the page: `plots/NAME.csv`.
    Files,
    /// In the page alone.
    Nothing,
}

/// The page as HTML.
///
/// # Errors
/// A template that does not fit the page.
pub fn render(page: &Page, beside: Beside) -> Result<String, HtmlError> {
    let mut tera = tera::Tera::default();
    // Names that end in `.html` are escaped.
    tera.add_raw_template("report.html", TEMPLATE)?;
    let mut flat =
        Flat { blocks: Vec::new(), numbering: Numbering::default(), section: String::new(), heading: 0, beside };
    let sections: Vec<FlatSection<'_>> = page
        .placed()
        .map(|Placed { section, number, anchor, title, begins_appendix }| {
            flat.section = number.clone();
            flat.heading = 0;
            flat.add(&section.blocks);
            FlatSection { id: anchor, number, title, begins_appendix, blocks: std::mem::take(&mut flat.blocks) }
        })
        .collect();
    let context = tera::Context::from_serialize(&Whole {
        policy: script::policy(&[script::OF_PAGES]),
        script: script::OF_PAGES,
        title: &page.title,
        subtitle: &page.subtitle,
        links: &page.links,
        title_block: page.title_block.iter().map(|(term, entry)| [term, entry]).collect(),
        footer: &page.footer,
        style: format!("{STYLE}{}{}", current_section(page), page_foot(page)),
        sections,
    })?;
    // Names and texts of the study are what could hold hidden characters; neither page nor drawings need any.
    Ok(escaped_lines(&tera.render("report.html", &context)?).into_owned())
}

/// The style that marks, among the contents, the section that was jumped to.
fn current_section(page: &Page) -> String {
    let marks = page.placed().map(|own| format!("body:has(#{0}:target) nav a[href=\"#{0}\"]", own.anchor));
    let marks: Vec<String> = marks.collect();
    if marks.is_empty() {
        return String::new();
    }
    format!("{} {{ border-color: var(--blue); background: var(--soft); font-weight: 650; }}\n", marks.join(", "))
}

/// The style of the foot of printed pages: what the document is.
fn page_foot(page: &Page) -> String {
    let text = if page.mark.is_empty() { page.title.clone() } else { format!("{} · {}", page.mark, page.title) };
    format!("@page {{ @bottom-left {{ content: \"{}\"; }} }}\n", in_style(&text))
}

/// A text within a string of a style sheet: whatever might mean something there, or end the sheet, by its number (CSS Syntax,
/// section 4.3.7).
pub fn in_style(text: &str) -> String {
    let one = |letter: char| match letter {
        ' ' => " ".to_owned(),
        _ if letter.is_ascii_alphanumeric() => letter.to_string(),
        _ => format!("\\{:x} ", u32::from(letter)),
    };
    text.chars().map(one).collect()
}

#[derive(Serialize)]
struct Whole<'a> {
    policy: String,
    script: &'static str,
    title: &'a str,
    subtitle: &'a Text,
    links: &'a Text,
    title_block: Vec<[&'a Text; 2]>,
    footer: &'a Text,
    style: String,
    sections: Vec<FlatSection<'a>>,
}

#[derive(Serialize)]
struct FlatSection<'a> {
    id: String,
    number: String,
    title: String,
    begins_appendix: bool,
    blocks: Vec<FlatBlock<'a>>,
}

/// A block as the template sees it; folded blocks stand between an opening and a closing one.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum FlatBlock<'a> {
    Heading { id: String, number: String, title: &'a str },
    Paragraph { text: &'a Text },
    Small { text: &'a Text },
    List { items: &'a [Text] },
    Table { number: usize, caption: &'a Text, columns: &'a [Column], stacks: bool, rows: Vec<Vec<FlatCell<'a>>> },
    Figure { number: usize, id: String, caption: &'a Text, svg: String, values: &'a str, data: String, file: String },
    Callout { tone: Tone, word: &'static str, text: &'a Text },
    Statements { statements: Vec<FlatStatement<'a>> },
    Definitions { entries: Vec<[&'a Text; 2]> },
    Open { title: &'a str },
    Close,
    OpenBeside,
    CloseBeside,
}

#[derive(Serialize)]
struct FlatCell<'a> {
    text: &'a [Inline],
    class: String,
    /// What stands beside it where rows stand as lists.
    label: String,
}

#[derive(Serialize)]
struct FlatStatement<'a> {
    label: &'a str,
    value: &'a str,
    text: &'a Text,
    class: &'static str,
}

fn class(status: Option<Status>) -> &'static str {
    match status {
        None => "",
        Some(Status::Ok) => "ok",
        Some(Status::Caution) => "caution",
        Some(Status::Fail) => "fail",
    }
}

/// Columns of a table that is too wide for a phone.
const WIDE: usize = 4;

/// Whether the rows of a table stand as lists on a narrow screen: many columns have no room there.
fn stacks(table: &Table) -> bool {
    table.columns.len() >= WIDE
}

fn label(column: &Column) -> String {
    if column.unit.is_empty() { column.title.clone() } else { format!("{} [{}]", column.title, column.unit) }
}

fn cell<'a>(cell: &'a Cell, column: Option<&Column>, stacks: bool) -> FlatCell<'a> {
    let side = if column.is_some_and(|c| c.is_numeric) { "number" } else { "text" };
    let label = column.filter(|_| stacks).map(label).unwrap_or_default();
    FlatCell { text: &cell.text.0, class: format!("{side} {}", class(cell.status)).trim_end().to_owned(), label }
}

struct Flat<'a> {
    blocks: Vec<FlatBlock<'a>>,
    numbering: Numbering,
    section: String,
    heading: usize,
    beside: Beside,
}

/// The address of the numbers behind a figure: the numbers themselves (RFC 2397), or the file beside the page where they are many.
fn data(figure: &Figure, id: &str, beside: Beside) -> String {
    let csv = &figure.drawing.numbers().csv;
    if beside == Beside::Files && csv.len() >= LINKED_FROM {
        return format!("plots/{id}.csv");
    }
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~,".contains(&byte);
    let mut out = String::from("data:text/csv;charset=utf-8,");
    for byte in csv.bytes() {
        if is_plain(byte) { out.push(char::from(byte)) } else { out.push_str(&format!("%{byte:02X}")) }
    }
    out
}

impl<'a> Flat<'a> {
    fn figure(&mut self, figure: &'a Figure) -> FlatBlock<'a> {
        let (number, id) = self.numbering.figure(figure);
        let svg = figure.drawing.svg(&id, &format!("Figure {number}"), &figure.alternative, false);
        let values = &figure.drawing.numbers().values;
        let (data, file) = (data(figure, &id, self.beside), format!("{id}.csv"));
        FlatBlock::Figure { number, id, caption: &figure.caption, svg, values, data, file }
    }

    fn add(&mut self, blocks: &'a [Block]) {
        for block in blocks {
            let flat = match block {
                Block::Heading(title) => {
                    self.heading += 1;
                    let number = format!("{}.{}", self.section, self.heading);
                    FlatBlock::Heading { id: format!("section-{}-{}", self.section, self.heading), number, title }
                }
                Block::Paragraph(text) => FlatBlock::Paragraph { text },
                Block::Small(text) => FlatBlock::Small { text },
                Block::List(items) => FlatBlock::List { items },
                Block::Table(table) => FlatBlock::Table {
                    number: self.numbering.table(),
                    caption: &table.caption,
                    columns: &table.columns,
                    stacks: stacks(table),
                    rows: (table.rows.iter())
                        .map(|row| {
                            let cells = row.iter().enumerate();
                            cells.map(|(i, table_cell)| cell(table_cell, table.columns.get(i), stacks(table))).collect()
                        })
                        .collect(),
                },
                Block::Figure(figure) => self.figure(figure),
                Block::Beside(figures) => {
                    self.blocks.push(FlatBlock::OpenBeside);
                    for figure in figures {
                        let flat = self.figure(figure);
                        self.blocks.push(flat);
                    }
                    FlatBlock::CloseBeside
                }
                Block::Callout(tone, text) => FlatBlock::Callout { tone: *tone, word: tone.word(), text },
                Block::Statements(statements) => FlatBlock::Statements {
                    statements: statements
                        .iter()
                        .map(|s| FlatStatement {
                            label: &s.label,
                            value: &s.value,
                            text: &s.text,
                            class: class(s.status),
                        })
                        .collect(),
                },
                Block::Definitions(entries) => {
                    FlatBlock::Definitions { entries: entries.iter().map(|(term, meaning)| [term, meaning]).collect() }
                }
                Block::Details(title, blocks) => {
                    self.blocks.push(FlatBlock::Open { title });
                    self.add(blocks);
                    FlatBlock::Close
                }
            };
            self.blocks.push(flat);
        }
    }
}
