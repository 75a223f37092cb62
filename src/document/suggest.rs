//! The nearest valid name to a misspelt one.

/// Names farther away than this share of their length are no suggestion.
const NEAR: usize = 3;

/// Number of insertions, deletions, replacements and swaps of neighbours between two texts (optimal string
/// alignment; Damerau 1964). Case is ignored.
pub fn distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().flat_map(char::to_lowercase).collect();
    let b: Vec<char> = b.chars().flat_map(char::to_lowercase).collect();
    let mut before = vec![0; b.len() + 1];
    let mut above: Vec<usize> = (0..=b.len()).collect();
    let mut row = vec![0; b.len() + 1];
    for i in 1..=a.len() {
        row[0] = i;
        for j in 1..=b.len() {
            let change = usize::from(a[i - 1] != b[j - 1]);
            row[j] = (above[j] + 1).min(row[j - 1] + 1).min(above[j - 1] + change);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        std::mem::swap(&mut before, &mut above);
        std::mem::swap(&mut above, &mut row);
    }
    above[b.len()]
}

/// The candidate nearest to `name`, if one is near enough to be meant; the first of several equally near.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Texts far longer than any name are not compared: the cost grows with the product of the lengths.
    let length = name.chars().count();
    if length > 200 {
        return None;
    }
    candidates
        .into_iter()
        .filter(|c| c.len() <= 400)
        .map(|c| (distance(name, c), c))
        .filter(|&(d, c)| d <= (length.max(c.chars().count()) / NEAR).max(1) && d < length.max(2))
        .min_by_key(|&(d, _)| d)
        .map(|(_, c)| c)
}

/// "`a`, `b` and `c`", at most `most` names, then how many more there are.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>, most: usize) -> String {
    let names: Vec<String> = names.into_iter().map(|n| format!("`{n}`")).collect();
    let shown = names.len().min(most);
    match (shown, names.len() - shown) {
        (0, 0) => "none".to_owned(),
        (1, 0) => names[0].clone(),
        (_, 0) => format!("{} and {}", names[..shown - 1].join(", "), names[shown - 1]),
        (_, more) => format!("{} and {more} more", names[..shown].join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_by_hand() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("nodse", "nodes"), 1);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("Board", "board"), 0);
    }

    #[test]
    fn only_near_names_are_suggested() {
        assert_eq!(nearest("capcity", ["capacity", "area"]), Some("capacity"));
        assert_eq!(nearest("x", ["capacity", "area"]), None);
        assert_eq!(nearest("G_bj", ["G_bi", "G_bh", "G_eh"]), Some("G_bi"));
        assert_eq!(nearest("board", []), None);
    }

    #[test]
    fn lists_say_how_many_more() {
        assert_eq!(listed(["a", "b", "c"], 8), "`a`, `b` and `c`");
        assert_eq!(listed(["a", "b", "c"], 2), "`a`, `b` and 1 more");
    }
}
