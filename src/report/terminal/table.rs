//! Columns of text within a width.

use super::Layout;
use crate::report::page::Status;

/// Blanks between columns.
const GAP: usize = 2;
/// A column of words is not made narrower than this for the sake of others.
const NARROWEST: usize = 12;

/// A cell.
#[derive(Clone, Debug, Default)]
pub struct Entry {
    /// Its text, in one line.
    pub text: String,
    /// How it stands.
    pub status: Option<Status>,
}

impl From<String> for Entry {
    fn from(text: String) -> Self {
        Self { text, status: None }
    }
}

/// Lines of at most `width` characters, broken at blanks, and within words that are longer, there after a hyphen or a
/// colon if one stands in time. A no-break blank does not break and is printed as a blank.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = String::new();
    let mut used = 0;
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        let mut word: Vec<char> = word.chars().map(|c| if c == '\u{A0}' { ' ' } else { c }).collect();
        if used > 0 && used + 1 + word.len() > width {
            lines.push(std::mem::take(&mut line));
            used = 0;
        }
        while word.len() > width {
            let joint = (1..=width).rev().find(|&end| matches!(word[end - 1], '-' | ':' | '/' | '_'));
            lines.push(word.drain(..joint.unwrap_or(width)).collect());
        }
        if used > 0 {
            line.push(' ');
            used += 1;
        }
        used += word.len();
        line.extend(word);
    }
    if !line.is_empty() || lines.is_empty() {
        lines.push(line);
    }
    lines
}

/// A line in the colour of its standing.
pub(super) fn coloured(line: &str, status: Option<Status>) -> String {
    let code = match status {
        None => return line.to_owned(),
        Some(Status::Ok) => "32",
        Some(Status::Caution) => "33",
        Some(Status::Fail) => "31",
    };
    format!("\u{1b}[{code}m{line}\u{1b}[0m")
}

/// Rows below headings (none: no heading), in columns. Numbers stand to the right; those that are marked carry `!` or
/// `*`, because not every terminal has colours. Where the columns do not fit, the rows become lists.
pub fn lay_out(headings: &[String], rows: &[Vec<Entry>], numeric: &[bool], layout: Layout) -> String {
    let marked: Vec<bool> = (0..numeric.len())
        .map(|column| {
            let has_mark = |row: &Vec<Entry>| row.get(column).is_some_and(|cell| !mark(cell.status).is_empty());
            numeric[column] && !headings.is_empty() && rows.iter().any(has_mark)
        })
        .collect();
    let text = |row: &[Entry], column: usize| -> String {
        let Some(cell) = row.get(column) else { return String::new() };
        match marked[column] {
            true => format!("{}{:1}", cell.text, mark(cell.status)),
            false => cell.text.clone(),
        }
    };
    let columns: Vec<Measured> = (0..numeric.len())
        .map(|column| {
            let cells: Vec<String> = rows.iter().map(|row| text(row, column)).collect();
            measured(
                headings.get(column).map_or("", String::as_str),
                &cells,
                numeric[column],
                usize::from(marked[column]),
            )
        })
        .collect();
    let Some(widths) =
        widths(&columns, layout.width, |c| c.whole).or_else(|| widths(&columns, layout.width, |c| c.least))
    else {
        return lists(headings, rows, &text, layout);
    };
    let mut out = String::new();
    if !headings.is_empty() {
        // A heading of numbers ends where the digits end, not above the marks.
        let cells: Vec<(Vec<String>, Option<Status>)> = headings
            .iter()
            .enumerate()
            .map(|(column, heading)| {
                let pad = usize::from(marked[column]);
                let lines = wrapped(heading, widths[column] - pad);
                (lines.into_iter().map(|line| line + &" ".repeat(pad)).collect(), None)
            })
            .collect();
        push_row(&mut out, &cells, &widths, numeric, false);
        let rules: Vec<String> = widths.iter().map(|&width| "-".repeat(width)).collect();
        out.push_str(&format!("{}\n", rules.join(&" ".repeat(GAP))));
    }
    for row in rows {
        let cells: Vec<(Vec<String>, Option<Status>)> = (0..widths.len())
            .map(|column| {
                let status = row.get(column).and_then(|cell| cell.status);
                let text = text(row, column);
                let lines = if text.chars().count() <= widths[column] {
                    vec![text.replace('\u{A0}', " ")]
                } else {
                    wrapped(&text, widths[column])
                };
                (lines, status)
            })
            .collect();
        push_row(&mut out, &cells, &widths, numeric, layout.is_coloured);
    }
    out.push_str(&legend(rows, &marked));
    out
}

fn mark(status: Option<Status>) -> &'static str {
    match status {
        Some(Status::Fail) => "!",
        Some(Status::Caution) => "*",
        Some(Status::Ok) | None => "",
    }
}

fn legend(rows: &[Vec<Entry>], marked: &[bool]) -> String {
    let has = |status: Status| {
        rows.iter().any(|row| row.iter().zip(marked).any(|(cell, &marked)| marked && cell.status == Some(status)))
    };
    match (has(Status::Fail), has(Status::Caution)) {
        (true, true) => "(! not kept, * worth a look)\n".to_owned(),
        (true, false) => "(! not kept)\n".to_owned(),
        (false, true) => "(* worth a look)\n".to_owned(),
        (false, false) => String::new(),
    }
}

/// Widths that a column may have.
struct Measured {
    /// With its heading in one line, or in two above numbers.
    wished: usize,
    /// No cell of numbers broken, no word broken.
    whole: usize,
    /// Cells broken at any blank.
    least: usize,
}

fn measured(heading: &str, cells: &[String], is_numeric: bool, mark: usize) -> Measured {
    let longest_word = |text: &str| text.split(' ').map(|word| word.chars().count()).max().unwrap_or(0);
    let widest = cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0);
    let word = cells.iter().map(|cell| longest_word(cell)).max().unwrap_or(0);
    let heading_width = (longest_word(heading) + mark).max(1);
    if is_numeric {
        let whole = heading_width.max(widest);
        let two_lines = |width: &usize| wrapped(heading, width - mark).len() <= 2;
        let wished = (whole..whole.max(heading.chars().count() + mark) + 1).find(two_lines).unwrap_or(whole);
        Measured { wished, whole, least: heading_width.max(word + mark) }
    } else {
        // A single long word is broken rather than to make all else narrow.
        let least = heading_width.max(word.min(NARROWEST.max(widest / 4)));
        Measured { wished: widest.max(heading.chars().count()).max(1), whole: least, least }
    }
}

/// Widths of the columns, none below its `floor`; nothing where they do not fit. The widest column gives way first.
fn widths(columns: &[Measured], width: usize, floor: fn(&Measured) -> usize) -> Option<Vec<usize>> {
    let gaps = GAP * columns.len().saturating_sub(1);
    if columns.iter().map(floor).sum::<usize>() + gaps > width {
        return None;
    }
    let mut widths: Vec<usize> = columns.iter().map(|column| column.wished).collect();
    while widths.iter().sum::<usize>() + gaps > width {
        let can_give = (0..widths.len()).filter(|&column| widths[column] > floor(&columns[column]));
        let widest = can_give.max_by_key(|&column| widths[column])?;
        widths[widest] -= 1;
    }
    Some(widths)
}

/// Each row as a list of `heading: text`.
fn lists(
    headings: &[String],
    rows: &[Vec<Entry>],
    text: &impl Fn(&[Entry], usize) -> String,
    layout: Layout,
) -> String {
    let mut out = String::new();
    for (position, row) in rows.iter().enumerate() {
        if position > 0 {
            out.push('\n');
        }
        for column in 0..row.len() {
            let heading = headings.get(column).map_or(String::new(), |heading| format!("{heading}: "));
            let whole = format!("{heading}{}", text(row, column).trim_end());
            for (line, part) in wrapped(&whole, layout.width.saturating_sub(2).max(1)).iter().enumerate() {
                out.push_str(&format!("{}{part}\n", if line > 0 { "  " } else { "" }));
            }
        }
    }
    out
}

/// A row of cells of several lines each.
fn push_row(
    out: &mut String,
    cells: &[(Vec<String>, Option<Status>)],
    widths: &[usize],
    numeric: &[bool],
    is_coloured: bool,
) {
    let height = cells.iter().map(|cell| cell.0.len()).max().unwrap_or(0);
    for position in 0..height {
        let mut line = String::new();
        let mut owed = 0;
        for (column, (lines, status)) in cells.iter().enumerate() {
            let text = lines.get(position).map_or("", String::as_str);
            let fill = widths[column].saturating_sub(text.chars().count());
            let (before, after) = if numeric[column] { (fill, 0) } else { (0, fill) };
            // Blanks at the end of a line are never printed.
            if !text.trim_end().is_empty() {
                line.push_str(&" ".repeat(owed + before));
                let trailing = text.chars().count() - text.trim_end().chars().count();
                line.push_str(&coloured(text.trim_end(), status.filter(|_| is_coloured)));
                owed = trailing + after + GAP;
            } else {
                owed += widths[column] + GAP;
            }
        }
        out.push_str(&line);
        out.push('\n');
    }
}
