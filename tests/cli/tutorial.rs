//! The tutorial as typed: its files, its commands, and what they print.

use std::fs;
use std::path::Path;

use super::studies::printed;

/// The lines of what is printed must hold those of the page in their order; `...` stands for any lines.
fn assert_prints(command: &str, said: &str, expected: &[&str]) {
    let lines: Vec<&str> = said.lines().map(str::trim_end).collect();
    let (mut at, mut is_open) = (0, false);
    for line in expected {
        if *line == "..." {
            is_open = true;
            continue;
        }
        let found = lines[at..].iter().position(|own| own == line);
        let place = found.unwrap_or_else(|| panic!("{command}: `{line}` is not printed from line {at} on:\n{said}"));
        assert!(is_open || place == 0, "{command}: `{}` stands before `{line}`", lines[at]);
        (at, is_open) = (at + place + 1, false);
    }
    assert!(is_open || at == lines.len(), "{command}: more is printed: {}", lines[at..].join("\n"));
}

#[test]
#[ignore = "thorough"]
fn the_tutorial_does_what_it_says() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("docs/tutorial.md")).unwrap();
    let work = tempfile::tempdir().unwrap();
    fs::create_dir(work.path().join("my-box")).unwrap();
    for log in ["log-1.csv", "log-2.csv"] {
        fs::copy(root.join("docs/tutorial").join(log), work.path().join(log)).unwrap();
    }
    let mut commands = 0;
    for (position, block) in page.split("\n```").enumerate().filter(|(position, _)| position % 2 == 1) {
        let (head, text) = block.split_once('\n').unwrap_or_else(|| panic!("block {position} has a line"));
        match head.split_whitespace().collect::<Vec<_>>().as_slice() {
            [_, file] => fs::write(work.path().join(file), format!("{text}\n")).unwrap(),
            ["console"] => {
                for typed in format!("\n{text}").split("\n$ ").skip(1) {
                    let mut lines = typed.lines();
                    let command = lines.next().expect("a command");
                    let arguments: Vec<&str> = command.split(' ').skip(1).collect();
                    let expected: Vec<&str> = lines.collect();
                    assert_prints(command, &printed(work.path(), &arguments), &expected);
                    commands += 1;
                }
            }
            _ => {}
        }
    }
    assert_eq!(commands, 7);
}
