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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_that_turn_the_direction_of_writing_are_hidden_and_letters_are_not() {
        for hidden in ['\u{202e}', '\u{2067}', '\u{200b}', '\u{feff}', '\u{9b}', '\n', '\u{61c}', '\u{e0041}'] {
            assert!(is_hidden(hidden), "{hidden:?}");
        }
        for shown in ['a', 'ä', '温', 'µ', '°', ' ', '-', '\u{a0}'] {
            assert!(!is_hidden(shown), "{shown:?}");
        }
    }

    #[test]
    fn hidden_characters_are_shown_by_their_codes() {
        assert_eq!(escaped("a\u{1b}[2J\u{202e}\n\0ä"), "a\\u{1b}[2J\\u{202e}\\n\\u{0}ä");
        assert_eq!(escaped_lines("a\n\tb\r"), "a\n\tb\\r");
        assert!(matches!(escaped("plain"), Cow::Borrowed(_)));
    }

    #[test]
    fn json_means_the_same_with_its_hidden_characters_escaped() {
        let value = serde_json::json!({"a\u{202e}": ["\u{9b}\u{e0041}ä", 1.5]});
        let text = serde_json::to_string_pretty(&value).expect("JSON");
        let shown = escaped_json(&text);
        assert!(shown.contains("\\u202e") && shown.contains("\\u009b\\udb40\\udc41ä"), "{shown}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&shown).expect("JSON"), value);
    }

    #[test]
    fn a_shell_reads_a_word_as_it_is() {
        assert_eq!(shell_word("conductive-path:box:plate"), "conductive-path:box:plate");
        assert_eq!(shell_word("product-load:box:T_pl*Q"), "'product-load:box:T_pl*Q'");
        assert_eq!(shell_word("sensor-bias:TC o'clock"), "'sensor-bias:TC o'\\''clock'");
        assert_eq!(shell_word(""), "''");
    }

    #[test]
    fn long_texts_keep_both_ends() {
        let text = format!("begin{}end", "ä".repeat(5000));
        let short = shortened(&text);
        assert!(short.starts_with("begin") && short.ends_with("end") && short.chars().count() < 1300);
        assert!(short.contains("(3808 characters)"), "{short}");
        assert_eq!(shortened("as it is"), "as it is");
    }
}
