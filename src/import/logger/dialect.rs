//! How a log is written: what separates its cells, where its header and its units stand, comma or point.

/// Candidates of a separator, the likelier first.
const SEPARATORS: [u8; 4] = [b';', b'\t', b'|', b','];
/// Lines that are looked at.
const LOOKED_AT: usize = 400;
/// What stands in the cell of a reading that was not taken or could not be, in small letters.
const MISSING: &[&str] = &[
    "",
    "-",
    "--",
    "---",
    "----",
    "nan",
    "na",
    "n/a",
    "#n/a",
    "null",
    "none",
    "inf",
    "-inf",
    "+inf",
    "ol",
    "over",
    "overflow",
    "+over",
    "-over",
    "overrange",
    "err",
    "error",
    "open",
    "burnout",
    "invalid",
    "fault",
];
/// A number that large is what loggers write for an input out of range.
const OVERFLOW: f64 = 9.8e37;

/// How a log is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dialect {
    /// What stands between cells.
    pub separator: u8,
    /// Line of the header, from 0.
    pub header: usize,
    /// Whether a decimal is written with a comma.
    pub has_comma: bool,
}

/// Cells of a line, quotes allowed for.
pub(super) fn cells(line: &str, separator: u8) -> Vec<String> {
    let mut out = vec![String::new()];
    let mut is_quoted = false;
    for c in line.chars() {
        match c {
            '"' => is_quoted = !is_quoted,
            c if !is_quoted && c == char::from(separator) => out.push(String::new()),
            c => {
                if let Some(cell) = out.last_mut() {
                    cell.push(c);
                }
            }
        }
    }
    out.into_iter().map(|cell| cell.trim().to_owned()).collect()
}

/// The dialect of a text; `None` where no separator makes several columns of two lines.
pub fn dialect(text: &str) -> Option<Dialect> {
    let lines: Vec<&str> = text.trim_start_matches('\u{feff}').lines().take(LOOKED_AT).collect();
    let mut best: Option<(usize, usize, u8)> = None;
    for separator in SEPARATORS {
        let counts: Vec<usize> = lines.iter().map(|line| cells(line, separator).len()).collect();
        // The commonest number of cells, of several lines at least.
        let common = counts
            .iter()
            .copied()
            .filter(|&count| count > 1)
            .max_by_key(|&count| (counts.iter().filter(|&&other| other == count).count(), count));
        let Some(common) = common else { continue };
        let agreeing = counts.iter().filter(|&&count| count == common).count();
        if agreeing > 1 && best.is_none_or(|(most, ..)| agreeing > most) {
            best = Some((agreeing, common, separator));
        }
    }
    let (_, columns, separator) = best?;
    let header = lines.iter().position(|line| cells(line, separator).len() == columns)?;
    let body = lines.iter().skip(header + 1);
    let has_comma = separator != b','
        && body.flat_map(|line| cells(line, separator)).any(|cell| {
            let (whole, fraction) = cell.split_once(',').unwrap_or(("", ""));
            let digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
            digits(whole.trim_start_matches(['-', '+'])) && digits(fraction)
        });
    Some(Dialect { separator, header, has_comma })
}

/// Whether the line that would be the header holds readings: no line names the columns, or the separator is another.
pub(super) fn is_without_names(text: &str, dialect: &Dialect) -> bool {
    let line = text.trim_start_matches('\u{feff}').lines().nth(dialect.header).unwrap_or_default();
    let own: Vec<String> = cells(line, dialect.separator).into_iter().filter(|cell| !cell.is_empty()).collect();
    let begins_as_number =
        |cell: &&String| cell.trim_start_matches(['-', '+']).starts_with(|c: char| c.is_ascii_digit());
    // Names of channels may be numbers, that of the time is none.
    own.first().is_some_and(|first| begins_as_number(&first))
        && 2 * own.iter().filter(begins_as_number).count() > own.len()
}

/// A character that stands equally often in nearly all lines, and oftener than any other such one: what separates the cells
/// of a log that is written in no known way.
pub(super) fn other_separator(text: &str) -> Option<char> {
    let lines: Vec<&str> = text.lines().filter(|line| !line.trim().is_empty()).take(LOOKED_AT).collect();
    let is_candidate =
        |c: char| c == ' ' || (c.is_ascii_punctuation() && !matches!(c, '.' | ',' | '-' | '+' | '"' | '\''));
    let candidates = (' '..='~').filter(|c| is_candidate(*c));
    let counted = candidates.filter_map(|candidate| {
        let mut counts: Vec<usize> = lines.iter().map(|line| line.matches(candidate).count()).collect();
        counts.sort_unstable();
        let common = counts.get(counts.len() / 2).copied().filter(|common| *common > 0)?;
        let agreeing = counts.iter().filter(|count| **count == common).count();
        (lines.len() > 1 && 10 * agreeing >= 8 * lines.len()).then_some((common, candidate))
    });
    // A space of dates goes after what stands as often.
    counted.max_by_key(|&(common, candidate)| (common, candidate != ' ')).map(|(_, candidate)| candidate)
}

/// What a cell says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// A number.
    Number(f64),
    /// Nothing was read.
    Missing,
    /// Some other text.
    Text,
}

/// The reading of a cell.
pub fn reading(cell: &str, has_comma: bool) -> Reading {
    if MISSING.contains(&cell.to_ascii_lowercase().as_str()) {
        return Reading::Missing;
    }
    let written =
        if has_comma && cell.contains(',') { cell.replace('.', "").replace(',', ".") } else { cell.to_owned() };
    match written.parse::<f64>() {
        Ok(number) if number.is_finite() && number.abs() < OVERFLOW => Reading::Number(number),
        Ok(_) => Reading::Missing,
        Err(_) => Reading::Text,
    }
}

/// Name and unit of a header: `T1 [degC]`, `T1 (°C)`, `T1`.
pub fn name_and_unit(header: &str) -> (String, Option<String>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((name, unit)) = header.strip_suffix(close).and_then(|rest| rest.rsplit_once(open))
            && let Some(unit) = unit_of(unit).filter(|_| !name.trim().is_empty())
        {
            return (name.trim().to_owned(), Some(unit));
        }
    }
    (header.to_owned(), None)
}

/// A unit as the study format writes it; `None` where it is none.
pub(super) fn unit_of(text: &str) -> Option<String> {
    let text = text.trim().trim_start_matches(['[', '(']).trim_end_matches([']', ')']).trim();
    let unit = match text {
        "C" | "\u{B0}C" | "\u{BA}C" | "\u{2103}" | "Deg C" | "deg C" | "degC" | "DegC" | "Grad C" | "celsius"
        | "Celsius" => "degC",
        "sec" | "secs" | "seconds" | "Sec" => "s",
        "mins" | "minutes" => "min",
        "hours" | "hr" | "hrs" => "h",
        "Watt" | "watt" | "Watts" => "W",
        "Volt" | "volt" | "VDC" | "V DC" | "V dc" => "V",
        "Amp" | "amp" | "ADC" | "A DC" => "A",
        "" => return None,
        other => other,
    };
    crate::expression::Unit::parse(unit).is_ok().then(|| unit.to_owned())
}
