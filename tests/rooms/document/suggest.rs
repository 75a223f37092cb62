//! Tests of `core/src/document/suggest.rs`.

use bmv::document::suggest::*;

fn within(a: &str, b: &str, most: usize) -> Option<usize> {
    let chars = |text: &str| text.chars().collect::<Vec<_>>();
    distance(&chars(a), &chars(b), most)
}

#[test]
fn distances_by_hand() {
    assert_eq!(within("kitten", "sitting", 9), Some(3));
    assert_eq!(within("nodse", "nodes", 9), Some(1));
    assert_eq!(within("", "abc", 9), Some(3));
    assert_eq!(within("abc", "", 3), Some(3));
}

/// The whole table, as the definition has it.
fn by_definition(a: &[char], b: &[char]) -> usize {
    let mut table = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            table[i][j] = if i == 0 || j == 0 {
                i + j
            } else {
                let change = usize::from(a[i - 1] != b[j - 1]);
                let plain = (table[i - 1][j] + 1).min(table[i][j - 1] + 1).min(table[i - 1][j - 1] + change);
                let swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
                if swapped { plain.min(table[i - 2][j - 2] + 1) } else { plain }
            };
        }
    }
    table[a.len()][b.len()]
}

#[test]
fn a_bound_changes_no_distance_within_it() {
    let word = |mut code: usize, length: usize| -> Vec<char> {
        let mut letters = Vec::new();
        for _ in 0..length {
            letters.push(['a', 'b', 'c'][code % 3]);
            code /= 3;
        }
        letters
    };
    for (length, other) in [(4, 4), (4, 3), (2, 4), (5, 2)] {
        for one in 0..3_usize.pow(length as u32) {
            for two in (0..3_usize.pow(other as u32)).step_by(2) {
                let (a, b) = (word(one, length), word(two, other));
                let whole = by_definition(&a, &b);
                for most in 0..=5 {
                    let expected = Some(whole).filter(|whole| *whole <= most);
                    assert_eq!(distance(&a, &b, most), expected, "{a:?} {b:?} {most}");
                }
            }
        }
    }
}

#[test]
fn only_near_names_are_suggested() {
    assert_eq!(nearest("capcity", ["capacity", "area"]), Some("capacity"));
    assert_eq!(nearest("x", ["capacity", "area"]), None);
    assert_eq!(nearest("G_bj", ["G_bi", "G_bh", "G_eh"]), Some("G_bi"));
    assert_eq!(nearest("board", []), None);
    assert_eq!(nearest("Board", ["bored", "board"]), Some("board"));
    assert_eq!(nearest("n", ["m", "no"]), Some("m"));
    assert_eq!(nearest(&"x".repeat(300), ["x"]), None);
}

#[test]
fn lists_say_how_many_more() {
    assert_eq!(listed(["a", "b", "c"], 8), "`a`, `b` and `c`");
    assert_eq!(listed(["a", "b", "c"], 2), "`a`, `b` and 1 more");
    assert_eq!((listed(["a"], 2), listed([], 2)), ("`a`".to_owned(), "none".to_owned()));
    assert!(listed([&*"a".repeat(100_000)], 2).len() < 100);
}
