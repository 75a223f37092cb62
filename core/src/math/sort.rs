//! Stable sorting by one copy of the algorithm. The standard library's is compiled anew for each comparison: some 2,500 lines of LLVM's
//! intermediate code each, a tenth of what is compiled for a diagnosis.

use std::cmp::Ordering;

/// Sorts a list; what compares as equal keeps its order. For lists of results, not for long arrays of numbers: each comparison
/// is an indirect call.
pub fn sort_by<T>(items: &mut [T], mut compare: impl FnMut(&T, &T) -> Ordering) {
    let order = sorted(items.len(), &mut |a, b| compare(&items[a], &items[b]));
    let mut target = vec![0; order.len()];
    for (place, &from) in order.iter().enumerate() {
        target[from] = place;
    }
    for place in 0..items.len() {
        while target[place] != place {
            let to = target[place];
            items.swap(place, to);
            target.swap(place, to);
        }
    }
}

/// The same by a key.
pub fn sort_by_key<T, K: Ord>(items: &mut [T], key: impl Fn(&T) -> K) {
    sort_by(items, |a, b| key(a).cmp(&key(b)));
}

/// The positions of so many things in their order.
fn sorted(count: usize, compare: &mut dyn FnMut(usize, usize) -> Ordering) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| compare(a, b));
    order
}
