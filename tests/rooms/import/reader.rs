//! Tests of `src/import/reader.rs`.

use bmv::import::reader::*;
use bmv_decks::{Deck, DeckError};

#[test]
fn the_first_reader_that_recognises_the_files_reads_them() {
    let deck = Reader {
        tool: "Example (.ex)",
        recognises: |files| files.iter().all(|file| file.name.ends_with(".ex")),
        read: |files| match files.first() {
            Some(file) if !file.bytes.is_empty() => Ok(Deck { title: file.text(), ..Deck::default() }),
            _ => Err(vec![DeckError::at("a.ex", 3, "no node"), DeckError::of("a.ex", "no title")]),
        },
    };
    let file = |name: &str, bytes: &[u8]| DeckFile { name: name.to_owned(), bytes: bytes.to_vec() };
    assert_eq!(read(&[deck], &[file("a.ex", b"10 \xb0C")]).map(|deck| deck.title), Ok("10 \u{b0}C".to_owned()));
    let refused = read(&[deck], &[file("a.ex", b"")]).expect_err("no text");
    assert_eq!(refused.to_string(), "a.ex:3: no node\na.ex: no title");
    let unknown = read(&[deck], &[file("a.txt", b"x")]).expect_err("another name");
    assert_eq!(unknown.to_string(), "no reader recognises `a.txt`: there are readers of Example (.ex)");
}
