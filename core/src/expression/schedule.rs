//! The order of a program's instructions: like ones beside one another, so that a run of them is one loop.
//!
//! Only within windows, since what is computed together is read together while it is near. An instruction still comes after
//! its arguments, and none changes, so neither do the results.

use std::collections::VecDeque;

/// Instructions among which like ones are put together: their results in eight lanes are 32 KiB.
const WINDOW: usize = 512;

/// The instructions of a segment in their new order, by their old places. `kind` tells which are alike, as a small number;
/// `arguments` are the old places of an instruction's arguments within the segment.
pub fn order(
    count: usize,
    kind: impl Fn(usize) -> usize,
    arguments: impl Fn(usize) -> [Option<usize>; 2],
) -> Vec<usize> {
    let mut order = Vec::with_capacity(count);
    let mut from = 0;
    while from < count {
        let to = (from + WINDOW).min(count);
        window(from, to, &kind, &arguments, &mut order);
        from = to;
    }
    order
}

fn window(
    from: usize,
    to: usize,
    kind: &impl Fn(usize) -> usize,
    arguments: &impl Fn(usize) -> [Option<usize>; 2],
    order: &mut Vec<usize>,
) {
    let mut waits_for = vec![0_u32; to - from];
    let mut readers: Vec<Vec<usize>> = vec![Vec::new(); to - from];
    let mut ready: Vec<VecDeque<usize>> = Vec::new();
    for place in from..to {
        for argument in arguments(place).into_iter().flatten().filter(|argument| (from..to).contains(argument)) {
            waits_for[place - from] += 1;
            readers[argument - from].push(place);
        }
        let kind = kind(place);
        if kind >= ready.len() {
            ready.resize(kind + 1, VecDeque::new());
        }
        if waits_for[place - from] == 0 {
            ready[kind].push_back(place);
        }
    }
    let end = order.len() + (to - from);
    while order.len() < end {
        // The first of the kinds with the most.
        let Some(most) = (0..ready.len()).rev().max_by_key(|&kind| ready[kind].len()) else { break };
        // What becomes ready of this kind meanwhile goes along.
        while let Some(place) = ready[most].pop_front() {
            order.push(place);
            for &reader in &readers[place - from] {
                waits_for[reader - from] -= 1;
                if waits_for[reader - from] == 0 {
                    ready[kind(reader)].push_back(reader);
                }
            }
        }
    }
}
