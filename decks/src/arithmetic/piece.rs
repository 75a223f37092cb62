//! Words, numbers and signs of a line of a deck.

/// A piece of a statement.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Piece {
    /// A letter or `_`, then letters, digits and `_`.
    Word(String),
    /// A number, and whether it is written as an integer.
    Number(f64, bool),
    /// A text in quotes.
    Text(String),
    /// `**`.
    Power,
    /// Any other sign.
    Sign(char),
}

impl Piece {
    /// As it stands in a message.
    pub(crate) fn described(&self) -> String {
        match self {
            Self::Word(word) => format!("`{word}`"),
            Self::Number(value, _) => format!("`{value}`"),
            Self::Text(text) => format!("'{text}'"),
            Self::Power => "`**`".to_owned(),
            Self::Sign(sign) => format!("`{sign}`"),
        }
    }
}

/// Pieces of a line without comment.
pub(crate) fn pieces(code: &str) -> Result<Vec<Piece>, String> {
    let characters: Vec<char> = code.chars().collect();
    let at = |position: usize| characters.get(position).copied().unwrap_or('\0');
    let run = |start: usize, belongs: fn(char) -> bool| {
        characters.iter().skip(start).take_while(|c| belongs(**c)).collect::<String>()
    };
    let mut pieces = Vec::new();
    let mut position = 0;
    while position < characters.len() {
        let character = at(position);
        if character.is_whitespace() {
            position += 1;
        } else if character.is_ascii_alphabetic() || character == '_' {
            let word = run(position, |c| c.is_ascii_alphanumeric() || c == '_');
            position += word.len();
            pieces.push(Piece::Word(word));
        } else if character.is_ascii_digit() || (character == '.' && at(position + 1).is_ascii_digit()) {
            let (piece, length) = number(&characters, position)?;
            position += length;
            pieces.push(piece);
        } else if character == '\'' || character == '"' {
            let text: String = characters.iter().skip(position + 1).take_while(|c| **c != character).collect();
            position += text.chars().count() + 2;
            if position > characters.len() {
                return Err("a quoted text does not end in its line".to_owned());
            }
            pieces.push(Piece::Text(text));
        } else if character == '*' && at(position + 1) == '*' {
            position += 2;
            pieces.push(Piece::Power);
        } else if "+-*/(),;=:".contains(character) {
            position += 1;
            pieces.push(Piece::Sign(character));
        } else {
            return Err(format!("`{character}` has no meaning here"));
        }
    }
    Ok(pieces)
}

/// The number at a position and its length in characters. The exponent is marked by E or D.
fn number(characters: &[char], start: usize) -> Result<(Piece, usize), String> {
    let mut text = String::new();
    let mut is_integer = true;
    let mut rest = characters.iter().copied().skip(start).peekable();
    let mut length = 0;
    while let Some(character) = rest.next() {
        match character {
            '0'..='9' => text.push(character),
            '.' if is_integer => {
                is_integer = false;
                text.push('.');
            }
            'E' | 'e' | 'D' | 'd' if rest.peek().is_some_and(|c| c.is_ascii_digit() || matches!(c, '+' | '-')) => {
                text.push('e');
                length += 1;
                is_integer = false;
                while let Some(digit) =
                    rest.next_if(|c| c.is_ascii_digit() || (text.ends_with('e') && "+-".contains(*c)))
                {
                    text.push(digit);
                    length += 1;
                }
                break;
            }
            _ => break,
        }
        length += 1;
    }
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok((Piece::Number(value, is_integer), length)),
        _ => Err(format!("`{text}` is not a finite number")),
    }
}
