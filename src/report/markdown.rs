//! The page as Markdown (GitHub's dialect: tables). Everything from a study is escaped.

use std::fmt::Write as _;

use crate::document::visible::escaped_lines;

use super::page::{Block, Cell, Column, Figure, Inline, Numbering, Page, Placed, Status, Table, Text};

/// The page as Markdown; figures are links to `plots/NAME.svg`, with their numbers in `plots/NAME.csv`.
pub fn render(page: &Page) -> String {
    let mut out = format!("# {}\n", escape(&page.title));
    if !page.subtitle.0.is_empty() {
        paragraph(&mut out, &inline(&page.subtitle, false));
    }
    if !page.links.0.is_empty() {
        paragraph(&mut out, &inline(&page.links, false));
    }
    if !page.title_block.is_empty() {
        out.push_str("\n| Title block | |\n|---|---|\n");
        for (term, entry) in &page.title_block {
            let _ = writeln!(out, "| {} | {} |", inline(term, true), inline(entry, true));
        }
    }
    let mut writer = Writer { out, numbering: Numbering::default(), section: String::new(), heading: 0 };
    writer.contents(page);
    for placed in page.placed() {
        writer.section(placed);
    }
    let mut out = writer.out;
    if !page.footer.0.is_empty() {
        out.push_str("\n---\n");
        paragraph(&mut out, &inline(&page.footer, false));
    }
    // Marks that turn the direction of writing are no control characters, which became blanks.
    escaped_lines(&out).into_owned()
}

struct Writer {
    out: String,
    numbering: Numbering,
    section: String,
    heading: usize,
}

impl Writer {
    fn contents(&mut self, page: &Page) {
        self.out.push('\n');
        for Placed { number, anchor, title, begins_appendix, .. } in page.placed() {
            if begins_appendix {
                self.out.push_str("\nAppendix:\n\n");
            }
            // Lists know no letters.
            let is_lettered = number.starts_with(|letter: char| letter.is_ascii_uppercase());
            let mark = if is_lettered { format!("- {number}.") } else { format!("{number}.") };
            let _ = writeln!(self.out, "{mark} [{}](#{anchor})", escape(&title));
        }
    }

    fn section(&mut self, placed: Placed<'_>) {
        let Placed { section, number, anchor, title, begins_appendix } = placed;
        self.heading = 0;
        if begins_appendix {
            self.out.push_str("\n# Appendix\n");
        }
        let _ = write!(self.out, "\n<a id=\"{anchor}\"></a>\n\n## {number}. {}\n", escape(&title));
        self.section = number;
        self.blocks(&section.blocks);
    }

    fn blocks(&mut self, blocks: &[Block]) {
        for block in blocks {
            match block {
                Block::Heading(title) => {
                    self.heading += 1;
                    let _ = write!(self.out, "\n### {}.{} {}\n", self.section, self.heading, escape(title));
                }
                Block::Paragraph(text) | Block::Small(text) => paragraph(&mut self.out, &inline(text, false)),
                Block::List(items) => {
                    self.out.push('\n');
                    for item in items {
                        let _ = writeln!(self.out, "- {}", inline(item, false));
                    }
                }
                Block::Table(table) => {
                    let number = self.numbering.table();
                    self.table(number, table);
                }
                Block::Figure(figure) => {
                    let (number, name) = self.numbering.figure(figure);
                    self.figure(number, &name, figure);
                }
                Block::Beside(figures) => {
                    for figure in figures {
                        let (number, name) = self.numbering.figure(figure);
                        self.figure(number, &name, figure);
                    }
                }
                Block::Callout(tone, text) => {
                    let _ = write!(self.out, "\n> **{}.** {}\n", tone.word(), inline(text, false));
                }
                Block::Statements(statements) => {
                    self.out.push('\n');
                    for statement in statements {
                        let (label, value) = (escape(&statement.label), escape(&statement.value));
                        let _ = writeln!(self.out, "- **{label}: {value}.** {}", inline(&statement.text, false));
                    }
                }
                Block::Definitions(entries) => {
                    self.out.push('\n');
                    for (term, meaning) in entries {
                        let _ = writeln!(self.out, "- **{}:** {}", inline(term, false), inline(meaning, false));
                    }
                }
                Block::Details(title, blocks) => {
                    paragraph(&mut self.out, &format!("**{}**", escape(title)));
                    self.blocks(blocks);
                }
            }
        }
    }

    fn table(&mut self, number: usize, table: &Table) {
        paragraph(&mut self.out, &format!("**Table {number}.** {}", inline(&table.caption, false)));
        self.out.push_str("\n|");
        for column in &table.columns {
            let _ = write!(self.out, " {} |", heading(column));
        }
        self.out.push_str("\n|");
        for column in &table.columns {
            self.out.push_str(if column.is_numeric { "---:|" } else { "---|" });
        }
        self.out.push('\n');
        for row in &table.rows {
            self.out.push('|');
            for cell in row {
                let _ = write!(self.out, " {} |", cell_text(cell));
            }
            self.out.push('\n');
        }
    }

    fn figure(&mut self, number: usize, name: &str, figure: &Figure) {
        let _ = write!(self.out, "\n![{}](plots/{name}.svg)\n", escape(&figure.alternative));
        let caption = inline(&figure.caption, false);
        paragraph(&mut self.out, &format!("**Figure {number}.** {caption} [Data (CSV)](plots/{name}.csv)"));
    }
}

fn heading(column: &Column) -> String {
    let title = escape(&column.title);
    if column.unit.is_empty() { title } else { format!("{title} \\[{}\\]", escape(&column.unit)) }
}

/// A highlighted cell is strong where it fails, so that the highlight survives without colours.
fn cell_text(cell: &Cell) -> String {
    let text = inline(&cell.text, true);
    if cell.status == Some(Status::Fail) && !text.is_empty() && !text.starts_with('`') {
        format!("**{text}**")
    } else {
        text
    }
}

fn paragraph(out: &mut String, text: &str) {
    let _ = write!(out, "\n{}\n", at_line_start(text));
}

fn inline(text: &Text, in_table: bool) -> String {
    let mut out = String::new();
    for piece in &text.0 {
        match piece {
            Inline::Plain(text) => out.push_str(&escape(text)),
            Inline::Strong(text) => wrap(&mut out, "**", text),
            Inline::Code(text) => out.push_str(&code(text, in_table)),
            // Figures have no anchors here: a link leads to the page's beginning.
            Inline::Link { text, page, anchor } if page.is_empty() => {
                let _ = write!(out, "[{}](#{anchor})", escape(text));
            }
            Inline::Link { text, page, .. } => {
                let _ = write!(out, "[{}]({page}.md)", escape(text));
            }
        }
    }
    out
}

fn wrap(out: &mut String, mark: &str, text: &str) {
    let text = text.trim();
    if !text.is_empty() {
        let _ = write!(out, "{mark}{}{mark}", escape(text));
    }
}

/// A code span; its fence is longer than any run of backticks inside. A pipe needs its backslash in a table even here.
pub fn code(text: &str, in_table: bool) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.trim().is_empty() {
        return String::new();
    }
    // Outside a table a pipe could still begin one in the reader's eyes; inside, a backslash before it would stay.
    if in_table && text.contains('|') {
        return escape(&text);
    }
    let longest = text.split(|c| c != '`').map(str::len).max().unwrap_or(0);
    let fence = "`".repeat(longest + 1);
    let pad = if text.starts_with('`') || text.ends_with('`') { " " } else { "" };
    format!("{fence}{pad}{text}{pad}{fence}")
}

/// Escapes every character that Markdown or HTML could take for markup; line ends become blanks.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '~' | '#' | '$' | '^' => {
                out.push('\\');
                out.push(c);
            }
            // A colon after a scheme would make a bare address a link.
            ':' => out.push_str(if out.ends_with("http") || out.ends_with("https") { "&#58;" } else { ":" }),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// Escapes what is markup only at the beginning of a line: lists and rules.
pub fn at_line_start(text: &str) -> String {
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    if digits > 0 && matches!(text.as_bytes().get(digits), Some(b'.' | b')')) {
        return format!("{}\\{}", &text[..digits], &text[digits..]);
    }
    if text.starts_with(['-', '+', '=']) { format!("\\{text}") } else { text.to_owned() }
}
