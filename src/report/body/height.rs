//! How high a block of a page is, estimated: no font is read. Pixels in a window of 1280 × 800, with the style of
//! `templates/report.css`.

use crate::report::page::{Block, Figure, Table, Text};

/// Title, links and title block, with what is free round them.
pub const HEADER: f64 = 150.0;
/// Heading of a section, and what is free below it.
pub const SECTION: f64 = 88.0;

/// Width of the page beside the contents.
const PAGE: f64 = 966.0;
/// Characters in a line of a paragraph, which is not as wide as the page.
const PARAGRAPH: f64 = 92.0;
/// Characters in a line of a callout.
const CALLOUT: f64 = 122.0;
/// Characters in a line of a caption.
const CAPTION: f64 = 136.0;
/// Height of a line of text, and of one of a table or a caption.
const LINE: f64 = 24.8;
const SMALL_LINE: f64 = 22.5;

fn lines(characters: usize, in_a_line: f64) -> f64 {
    (characters as f64 / in_a_line).ceil().max(1.0)
}

fn length(text: &Text) -> usize {
    text.in_plain_words().chars().count()
}

/// The height of a block with what is free below it.
pub fn height(block: &Block) -> f64 {
    match block {
        Block::Heading(_) => 66.0,
        Block::Paragraph(text) => LINE * lines(length(text), PARAGRAPH) + 14.0,
        Block::Small(text) => 20.0 * lines(length(text), 150.0) + 14.0,
        Block::List(items) => 14.0 + items.iter().map(|item| LINE * lines(length(item), PARAGRAPH - 6.0)).sum::<f64>(),
        Block::Table(table) => SMALL_LINE * lines(length(&table.caption), CAPTION) + 42.0 + rows(table),
        Block::Figure(figure) => of_figure(figure, 900.0, CAPTION),
        Block::Beside(figures) => figures.iter().map(|own| of_figure(own, 440.0, 66.0)).fold(0.0, f64::max),
        Block::Callout(_, text) => LINE * lines(length(text), CALLOUT) + 38.0,
        Block::Statements(statements) => {
            let one = |text: &Text| 100.0 + 21.0 * lines(length(text), 26.0);
            let rows = statements.chunks(4);
            20.0 + rows.map(|row| row.iter().map(|own| one(&own.text)).fold(0.0, f64::max) + 12.0).sum::<f64>()
        }
        Block::Definitions(entries) => {
            18.0 + entries.iter().map(|(_, meaning)| 5.0 + LINE * lines(length(meaning), 96.0)).sum::<f64>()
        }
        // Folded.
        Block::Details(..) => 63.0,
    }
}

fn of_figure(figure: &Figure, width: f64, caption: f64) -> f64 {
    let (own_width, own_height) = figure.drawing.size();
    width / f64::from(own_width.max(1)) * f64::from(own_height)
        + 22.0
        + SMALL_LINE * lines(length(&figure.caption) + 14, caption)
        + 46.0
}

/// Height of a table's rows: columns share the width as a browser shares it, between their longest word and their longest text
/// (CSS 2.1, section 17.5.2.2).
fn rows(table: &Table) -> f64 {
    const LETTER: f64 = 7.3;
    const BESIDE: f64 = 22.0;
    let columns = table.columns.len();
    let word = |text: &str| text.split_whitespace().map(|word| word.chars().count()).max().unwrap_or(0);
    let mut least = vec![0.0_f64; columns];
    let mut most = vec![0.0_f64; columns];
    for (at, column) in table.columns.iter().enumerate() {
        let title = column.title.chars().count() + column.unit.chars().count() + 3;
        least[at] = word(&column.title) as f64 * LETTER + BESIDE;
        most[at] = title as f64 * LETTER + BESIDE;
    }
    let texts: Vec<Vec<String>> =
        table.rows.iter().map(|row| row.iter().map(|cell| cell.text.in_plain_words()).collect()).collect();
    for row in &texts {
        for (at, text) in row.iter().enumerate().take(columns) {
            let whole = text.chars().count() as f64 * LETTER + BESIDE;
            let unbroken = if table.columns[at].is_numeric { whole } else { word(text) as f64 * LETTER + BESIDE };
            least[at] = least[at].max(unbroken);
            most[at] = most[at].max(whole);
        }
    }
    let (sum_least, sum_most): (f64, f64) = (least.iter().sum(), most.iter().sum());
    let share = if sum_most <= PAGE { 1.0 } else { ((PAGE - sum_least) / (sum_most - sum_least).max(1.0)).max(0.0) };
    let of_row = |row: &Vec<String>| {
        let needed = row.iter().enumerate().take(columns).map(|(at, text)| {
            let width = least[at] + share * (most[at] - least[at]) - BESIDE;
            lines(text.chars().count(), (width / LETTER + 0.5).max(1.0))
        });
        SMALL_LINE * needed.fold(1.0, f64::max) + 14.0
    };
    let head = if share < 0.99 { 2.0 } else { 1.0 };
    SMALL_LINE * head + 14.0 + texts.iter().map(of_row).sum::<f64>() + if texts.len() >= 10 { 36.0 } else { 0.0 }
}
