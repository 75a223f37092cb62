//! Tests of `src/report/body.rs`.

use bmv::report::body::divided;
use bmv::report::page::{Block, Column, Page, Section, Table, letter};

fn table(rows: usize) -> Block {
    let rows = (0..rows).map(|row| vec![format!("row {row}").into()]).collect();
    Block::Table(Table { caption: "A table.".into(), columns: vec![Column::text("Row")], rows })
}

fn section(id: &'static str, blocks: Vec<Block>) -> Section {
    Section { id, title: id.to_uppercase(), blocks }
}

fn ids(sections: &[Section]) -> Vec<&'static str> {
    sections.iter().map(|section| section.id).collect()
}

#[test]
fn a_short_report_has_no_appendix() {
    let sections = vec![section("summary", vec![table(3)]), section("glossary", vec![table(3)])];
    let (body, appendix) = divided(sections.clone());
    assert_eq!((body, appendix), (sections, Vec::new()));
}

#[test]
fn of_a_long_report_every_block_stands_once_and_a_heading_above_what_it_is_of() {
    let list = Block::List(vec!["one".into()]);
    let sections = vec![
        section("summary", vec![table(3)]),
        section(
            "comparison",
            vec![
                Block::Heading("sensors".into()),
                Block::paragraph("Where it fails:"),
                table(200),
                list.clone(),
                Block::Details("folded".into(), vec![table(9)]),
                Block::Heading("phases".into()),
                list.clone(),
            ],
        ),
        section("glossary", vec![table(3)]),
    ];
    let (body, appendix) = divided(sections);
    assert_eq!((ids(&body), ids(&appendix)), (vec!["summary", "comparison"], vec!["comparison", "glossary"]));
    // The line that ends with a colon goes with the table that it announces; the second heading does not overtake it.
    let first = &body[1].blocks;
    assert_eq!(first[..2], [Block::Heading("sensors".into()), list.clone()]);
    assert!(matches!(&first[2], Block::Small(_)) && first.len() == 3, "{first:?}");
    let rest = &appendix[0].blocks;
    assert_eq!(rest[..2], [Block::Heading("sensors".into()), Block::paragraph("Where it fails:")]);
    assert_eq!(rest[4..], [Block::Heading("phases".into()), list]);
    let page = Page { sections: body, appendix, ..Page::default() };
    let placed: Vec<(String, String, String)> = page.placed().map(|own| (own.number, own.anchor, own.title)).collect();
    let own = |number: &str, anchor: &str, title: &str| (number.to_owned(), anchor.to_owned(), title.to_owned());
    assert_eq!(placed[1], own("2", "comparison", "COMPARISON"));
    assert_eq!(placed[2], own("A", "comparison-details", "COMPARISON: details"));
    assert_eq!(placed[3], own("B", "glossary", "GLOSSARY"));
}

#[test]
fn letters_go_on_after_the_alphabet() {
    assert_eq!([0, 25, 26, 701].map(letter), ["A", "Z", "AA", "ZZ"]);
}
