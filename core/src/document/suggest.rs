//! The nearest valid name to a misspelt one.

/// Names farther away than this share of their length are no suggestion.
const NEAR: usize = 3;

/// Longer names are not compared and not listed whole, in characters.
const LONGEST: usize = 200;

/// Characters shown of a name that is longer.
const SHOWN: usize = 60;

/// Number of insertions, deletions, replacements and swaps of neighbours between two texts (optimal string
/// alignment; Damerau 1964), if it is at most `most`. The cost is the length of a text times `most`.
pub fn distance(a: &[char], b: &[char], most: usize) -> Option<usize> {
    if a.len().abs_diff(b.len()) > most {
        return None;
    }
    let beyond = a.len().max(b.len()) + 1;
    let mut before = vec![beyond; b.len() + 1];
    let mut above: Vec<usize> = (0..=b.len()).collect();
    let mut row = vec![beyond; b.len() + 1];
    for i in 1..=a.len() {
        // Farther from the diagonal than `most` there are more insertions or deletions than that alone.
        let (first, last) = (i.saturating_sub(most).max(1), i.saturating_add(most).min(b.len()));
        row[first - 1] = if first == 1 { i } else { beyond };
        let mut least = row[first - 1];
        for j in first..=last {
            let change = usize::from(a[i - 1] != b[j - 1]);
            let deleted = if j < i.saturating_add(most) { above[j] + 1 } else { beyond };
            row[j] = deleted.min(row[j - 1] + 1).min(above[j - 1] + change);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
            least = least.min(row[j]);
        }
        // The least of a row never falls again.
        if least > most {
            return None;
        }
        std::mem::swap(&mut before, &mut above);
        std::mem::swap(&mut above, &mut row);
    }
    Some(above[b.len()]).filter(|distance| *distance <= most)
}

/// Puts a text's characters in lower case into `out`.
fn lower(text: &str, out: &mut Vec<char>) {
    out.clear();
    out.extend(text.chars().flat_map(char::to_lowercase));
}

/// The candidate nearest to `name`, if one is near enough to be meant; the first of several equally near. Where a file
/// is read, [`Diagnostics::nearest`](super::Diagnostics::nearest) bounds how often this is asked.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let (mut letters, mut other) = (Vec::new(), Vec::new());
    if name.len() > 4 * LONGEST {
        return None;
    }
    lower(name, &mut letters);
    if letters.len() > LONGEST {
        return None;
    }
    let mut best: Option<(usize, &str)> = None;
    for candidate in candidates {
        // A character has at most four bytes, so this leaves out nothing that is near, and most of what is not at once.
        if candidate.len() > 8 * letters.len().max(1) || letters.len() > 2 * candidate.len().max(1) {
            continue;
        }
        lower(candidate, &mut other);
        let allowed = (letters.len().max(other.len()) / NEAR).max(1).min(letters.len().max(2) - 1);
        let most = match best {
            Some((0, _)) => break,
            Some((distance, _)) => allowed.min(distance - 1),
            None => allowed,
        };
        if let Some(distance) = distance(&letters, &other, most) {
            best = Some((distance, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

/// "`a`, `b` and `c`", at most `most` names, then how many more there are.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>, most: usize) -> String {
    let mut names = names.into_iter();
    let shown: Vec<String> = names.by_ref().take(most).map(quoted).collect();
    let more = names.count();
    match (shown.as_slice(), more) {
        ([], 0) => "none".to_owned(),
        ([one], 0) => one.clone(),
        ([first @ .., last], 0) => format!("{} and {last}", first.join(", ")),
        (_, more) => format!("{} and {more} more", shown.join(", ")),
    }
}

fn quoted(name: &str) -> String {
    match name.char_indices().nth(LONGEST) {
        None => format!("`{name}`"),
        Some(_) => format!("`{}...`", name.chars().take(SHOWN).collect::<String>()),
    }
}
