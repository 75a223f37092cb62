//! Sections as plain text for a terminal: headings, wrapped paragraphs, aligned tables. Figures are left out. Text of
//! a study can neither move the cursor nor change the direction of a line.

pub mod table;

use std::fmt::Write as _;

use crate::document::visible;

use super::page::{Block, Inline, Section, Statement, Status, Table, Text};
use table::Entry;
pub use table::wrapped;

/// How text is laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Characters in a line.
    pub width: usize,
    /// Whether headings and outcomes are coloured.
    pub is_coloured: bool,
}

impl Default for Layout {
    /// What is no terminal gets lines of 100 characters without colours.
    fn default() -> Self {
        Self { width: 100, is_coloured: false }
    }
}

/// Sections one below the other.
pub fn render(sections: &[Section], layout: Layout) -> String {
    let mut writer = Writer { out: String::new(), layout };
    for section in sections {
        writer.heading(&section.title, '=');
        writer.blocks(&section.blocks);
    }
    writer.out
}

/// Text without the characters that steer a terminal, which are shown by their codes.
pub fn escaped(text: &str) -> String {
    visible::escaped(text).into_owned()
}

struct Writer {
    out: String,
    layout: Layout,
}

impl Writer {
    fn heading(&mut self, title: &str, rule: char) {
        self.gap();
        let title = plain(title);
        let rule: String = std::iter::repeat_n(rule, title.chars().count().min(self.layout.width)).collect();
        let title = if self.layout.is_coloured { format!("\u{1b}[1m{title}\u{1b}[0m") } else { title };
        let _ = writeln!(self.out, "{title}\n{rule}");
    }

    /// An empty line between two blocks.
    fn gap(&mut self) {
        if !self.out.is_empty() {
            self.out.push('\n');
        }
    }

    fn blocks(&mut self, blocks: &[Block]) {
        for block in blocks {
            match block {
                Block::Heading(title) => self.heading(title, '-'),
                Block::Paragraph(text) | Block::Small(text) => {
                    self.gap();
                    self.paragraph("", &inline(text), None);
                }
                Block::List(items) => {
                    self.gap();
                    items.iter().for_each(|item| self.paragraph("- ", &inline(item), None));
                }
                Block::Table(table) => self.table(table),
                Block::Callout(tone, text) => {
                    self.gap();
                    self.paragraph("", &format!("{}: {}", tone.word(), inline(text)), None);
                }
                Block::Statements(statements) => self.statements(statements),
                Block::Definitions(entries) => {
                    let rows = entries.iter().map(|(term, meaning)| vec![entry(term), entry(meaning)]).collect();
                    self.borderless(rows);
                }
                Block::Details(title, blocks) => {
                    if blocks.iter().any(|block| !matches!(block, Block::Figure(_))) {
                        self.heading(title, '-');
                        self.blocks(blocks);
                    }
                }
                Block::Figure(_) | Block::Beside(_) => {}
            }
        }
    }

    /// Wrapped text whose first line begins with `lead`, the others with as many blanks.
    fn paragraph(&mut self, lead: &str, text: &str, status: Option<Status>) {
        let indent = lead.chars().count();
        let lines = table::wrapped(text, self.layout.width.saturating_sub(indent).max(1));
        for (position, line) in lines.iter().enumerate() {
            let lead = if position == 0 { lead.to_owned() } else { " ".repeat(indent) };
            let line = table::coloured(line, status.filter(|_| self.layout.is_coloured));
            let _ = writeln!(self.out, "{lead}{line}");
        }
    }

    fn statements(&mut self, statements: &[Statement]) {
        let rows = statements
            .iter()
            .map(|s| {
                let value = Entry { text: plain(&s.value), status: s.status };
                vec![Entry::from(plain(&s.label)), value, Entry::from(inline(&s.text))]
            })
            .collect();
        self.borderless(rows);
    }

    fn borderless(&mut self, rows: Vec<Vec<Entry>>) {
        self.gap();
        let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
        self.out.push_str(&table::lay_out(&[], &rows, &vec![false; columns], self.layout));
    }

    fn table(&mut self, table: &Table) {
        self.gap();
        self.paragraph("", &inline(&table.caption), None);
        let has_content = |column: usize| {
            let says = |row: &Vec<super::page::Cell>| {
                row.get(column).is_some_and(|cell| {
                    let text = inline(&cell.text);
                    !text.is_empty() && text != super::number::NONE
                })
            };
            table.rows.iter().any(says)
        };
        let kept: Vec<usize> = (0..table.columns.len()).filter(|&column| has_content(column)).collect();
        if kept.is_empty() {
            self.out.push_str("(nothing)\n");
            return;
        }
        let headings: Vec<String> = kept
            .iter()
            .map(|&column| {
                let column = &table.columns[column];
                let unit = if column.unit.is_empty() { String::new() } else { format!(" [{}]", column.unit) };
                plain(&format!("{}{unit}", column.title))
            })
            .collect();
        let numeric: Vec<bool> = kept.iter().map(|&column| table.columns[column].is_numeric).collect();
        let rows: Vec<Vec<Entry>> = table
            .rows
            .iter()
            .map(|row| {
                let cells = kept.iter().map(|&column| row.get(column));
                cells
                    .map(|cell| {
                        cell.map_or_else(Entry::default, |cell| Entry { status: cell.status, ..entry(&cell.text) })
                    })
                    .collect()
            })
            .collect();
        self.out.push_str(&table::lay_out(&headings, &rows, &numeric, self.layout));
    }
}

/// The text of a cell; names stand without the quotes that they have in running text.
fn entry(text: &Text) -> Entry {
    let pieces = text.0.iter().map(|piece| match piece {
        Inline::Plain(text) | Inline::Strong(text) | Inline::Code(text) | Inline::Link { text, .. } => plain(text),
    });
    Entry::from(pieces.collect::<String>())
}

fn inline(text: &Text) -> String {
    let pieces = text.0.iter().map(|piece| match piece {
        Inline::Plain(text) | Inline::Strong(text) | Inline::Link { text, .. } => plain(text),
        Inline::Code(text) => format!("`{}`", plain(text)),
    });
    pieces.collect()
}

/// A piece of running text for a terminal, names in quotes.
pub fn sentence(text: &Text) -> String {
    inline(text)
}

/// Text for a terminal: nothing that steers it, line ends as blanks, the minus of the keyboard, which can be copied
/// into other programs.
pub fn plain(text: &str) -> String {
    let text: String = text.chars().map(|c| if matches!(c, '\n' | '\r' | '\t') { ' ' } else { c }).collect();
    escaped(&text).replace('\u{2212}', "-")
}
