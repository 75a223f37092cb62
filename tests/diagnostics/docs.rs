//! The examples of the documentation are studies that load, without a warning.

use std::path::Path;

use crate::diagnostics::pass_study::Study;

/// A fenced block: the words behind the fence, and its text.
struct Block {
    language: String,
    file: Option<String>,
    text: String,
}

/// The fenced blocks of a page.
fn blocks(page: &str) -> Vec<Block> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(page);
    let text = std::fs::read_to_string(path).expect("the page");
    let mut found = Vec::new();
    let mut open: Option<Block> = None;
    for line in text.lines() {
        match (line.strip_prefix("```"), open.take()) {
            (Some(words), None) => {
                let mut words = words.split_whitespace().map(str::to_owned);
                let language = words.next().unwrap_or_default();
                open = Some(Block { language, file: words.next(), text: String::new() });
            }
            (Some(_), Some(block)) => found.push(block),
            (None, Some(mut block)) => {
                block.text.push_str(line);
                block.text.push('\n');
                open = Some(block);
            }
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "{page}: a fence is not closed");
    found
}

/// A folder with the files of a page's blocks, and the passes among them.
fn written(page: &str, study: &Study) -> Vec<String> {
    let mut passes = Vec::new();
    for block in blocks(page) {
        let Some(file) = block.file else { continue };
        study.put(&file, &block.text);
        if file.starts_with("pass-") {
            passes.push(file);
        }
    }
    passes
}

#[test]
fn the_studies_of_the_pages_load_without_a_warning() {
    for (page, count) in [("docs/guide.md", 4), ("docs/study-format.md", 1)] {
        let study = Study::empty();
        let passes = written(page, &study);
        assert_eq!(passes.len(), count, "{page}");
        for pass in passes {
            assert_eq!(study.said(&pass), "", "{page}: {pass}");
            let loaded = bmv::job::load(&study.path(&pass)).expect("loads");
            for (name, readiness) in bmv::job::ready(&loaded) {
                use bmv::job::ready::Readiness::{After, NotRun, Ready, Refused};
                match readiness {
                    Ready(_) | After(_) => {}
                    NotRun(reason) => panic!("{page}: {pass}: `{name}` does not run: {reason}"),
                    Refused(findings) => panic!("{page}: {pass}: `{name}`: {}", findings[0].reason),
                }
            }
        }
    }
}

#[test]
fn every_json_block_names_its_file_or_is_part_of_a_pass() {
    let study = Study::empty();
    written("docs/study-format.md", &study);
    let mut parts = 0;
    for page in ["README.md", "docs/effects.md", "docs/study-format.md", "docs/guide.md"] {
        for block in blocks(page).into_iter().filter(|block| block.language == "json" && block.file.is_none()) {
            parts += 1;
            let name = format!("pass-part-{parts}.json");
            let head = "{\"format\": \"bmv-pass/1\", \"parent\": \"pass-1.json\", \"jobs\": {},\n";
            study.put(&name, format!("{head}{}}}", block.text));
            assert_eq!(study.said(&name), "", "{page}");
        }
    }
    assert_eq!(parts, 2, "the entry under `adopt`, the figures");
}

/// The page lists every effect of the catalogue, with what it acts on and its inputs, and nothing else.
#[test]
fn the_catalogue_of_the_page_is_that_of_the_program() {
    let catalogue = bmv::study::effects(None).expect("the catalogue");
    let row = |effect: &bmv::effect::Effect| {
        let places = effect.places.iter().map(|place| place.word()).chain(effect.groups.then_some("group"));
        let inputs: Vec<String> = effect.form.inputs.iter().map(|input| format!("`{}`", input.name)).collect();
        let inputs = if inputs.is_empty() { "\u{2014}".to_owned() } else { inputs.join(", ") };
        format!("| `{}` | {} | {inputs} | {} |", effect.name, places.collect::<Vec<_>>().join(", "), effect.form.title)
    };
    let mut expected: Vec<String> = catalogue.effects().iter().map(row).collect();
    let page = include_str!("../../docs/effects.md");
    let table = page.split("## The catalogue").nth(1).and_then(|rest| rest.split("\n## ").next()).expect("the section");
    let mut listed: Vec<String> = table.lines().filter(|line| line.starts_with("| `")).map(str::to_owned).collect();
    expected.sort();
    listed.sort();
    assert_eq!(listed, expected);
}

#[test]
fn the_effect_of_the_page_is_an_effect() {
    let study = Study::empty();
    written("docs/effects.md", &study);
    assert!(bmv::study::effects(Some(&study.path(""))).is_ok_and(|all| all.get("tilting-heat-pipe").is_some()));
}
