//! Text that can be shown: nothing of a file may steer a terminal, hide from the reader or turn the direction of a line.

use std::borrow::Cow;

/// Longer texts of a message are cut, in characters.
const LONGEST: usize = 1200;

/// Characters kept at the end of a text that is cut.
const TAIL: usize = 100;

/// Whether a character would not be seen or would change how its neighbours are shown: controls, and characters of
/// format such as zero widths and the marks that turn the direction of writing (Unicode's category Cf, without the
/// signs that are drawn).
pub fn is_hidden(character: char) -> bool {
    character.is_control()
        || matches!(
            character,
            '\u{ad}'
                | '\u{61c}'
                | '\u{180e}'
                | '\u{200b}'..='\u{200f}'
                | '\u{2028}'..='\u{202e}'
                | '\u{2060}'..='\u{206f}'
                | '\u{feff}'
                | '\u{fff9}'..='\u{fffb}'
                | '\u{1bca0}'..='\u{1bca3}'
                | '\u{1d173}'..='\u{1d17a}'
                | '\u{e0000}'..='\u{e007f}'
        )
}

/// The text with hidden characters as their codes, `\u{1b}`; a line break as `\n`, a tab as `\t`.
pub fn escaped(text: &str) -> Cow<'_, str> {
    escaped_but(text, |_| false)
}

/// As [`escaped`]; line breaks and tabs stay.
pub fn escaped_lines(text: &str) -> Cow<'_, str> {
    escaped_but(text, |character| matches!(character, '\n' | '\t'))
}

/// A JSON text with the hidden characters of its strings as escapes of JSON: it means the same.
pub fn escaped_json(text: &str) -> Cow<'_, str> {
    let is_bad = |character: char| is_hidden(character) && character != '\n';
    if !text.contains(is_bad) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        if is_bad(character) {
            let mut units = [0; 2];
            let escapes = character.encode_utf16(&mut units).iter().map(|unit| format!("\\u{unit:04x}"));
            out.extend(escapes);
        } else {
            out.push(character);
        }
    }
    Cow::Owned(out)
}

fn escaped_but(text: &str, stays: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.chars().any(|character| is_hidden(character) && !stays(character)) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        if is_hidden(character) && !stays(character) {
            out.extend(character.escape_default());
        } else {
            out.push(character);
        }
    }
    Cow::Owned(out)
}

/// A text of a message; of a very long one the beginning and the end.
pub fn shortened(text: &str) -> Cow<'_, str> {
    // A text of few bytes has no more characters.
    if text.len() <= LONGEST {
        return Cow::Borrowed(text);
    }
    let starts: Vec<usize> = text.char_indices().map(|(start, _)| start).collect();
    if starts.len() <= LONGEST {
        return Cow::Borrowed(text);
    }
    let (head, tail) = (LONGEST - TAIL, starts.len() - TAIL);
    let left_out = tail - head;
    Cow::Owned(format!("{} ... ({left_out} characters) ... {}", &text[..starts[head]], &text[starts[tail]..]))
}

/// A word of a command as a shell takes it: in quotes where it would read anything into it.
pub fn shell_word(text: &str) -> Cow<'_, str> {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./:,+=@%".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        return Cow::Borrowed(text);
    }
    Cow::Owned(format!("'{}'", text.replace('\'', "'\\''")))
}
