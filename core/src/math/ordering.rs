//! Approximate minimum degree ordering on a quotient graph (Amestoy, Davis & Duff 1996, SIAM J. Matrix Anal. Appl. 17, 886).
//!
//! Eliminated variables become elements; a variable's degree is bounded by the sum over its elements of the members
//! outside the newest element (their equation 2). Variables with equal lists merge, variables seen only by the newest
//! element go with it, elements inside the newest one are absorbed.

use std::collections::{BTreeMap, BTreeSet};

/// A variable with more neighbours than this times the square root of the size goes last: ordering it would be slow and
/// gain nothing.
const DENSE_FACTOR: f64 = 10.0;

/// An order of elimination with little fill for a symmetric graph (neighbour lists without loops): the k-th variable
/// eliminated is `order[k]`.
pub fn minimum_degree(neighbours: Vec<Vec<usize>>) -> Vec<usize> {
    let size = neighbours.len();
    let dense = (DENSE_FACTOR * (size as f64).sqrt()).max(16.0) as usize;
    let mut graph = QuotientGraph::new(neighbours, dense);
    while let Some(pivot) = graph.lowest() {
        graph.eliminate(pivot);
    }
    let mut order = Vec::with_capacity(size);
    for &pivot in &graph.sequence {
        graph.append(pivot, &mut order);
    }
    order.extend(graph.postponed);
    order
}

struct QuotientGraph {
    /// Variables adjacent to a variable by an original edge.
    variables: Vec<Vec<usize>>,
    /// Elements adjacent to a variable.
    elements: Vec<Vec<usize>>,
    /// Variables of an element (named by its pivot).
    members: Vec<Vec<usize>>,
    /// Variables that a variable stands for (0 once merged or eliminated).
    weight: Vec<usize>,
    /// Weight of an element's members; 0 once absorbed.
    element_weight: Vec<usize>,
    degree: Vec<usize>,
    /// Variables merged into a variable or eliminated with it.
    merged: Vec<Vec<usize>>,
    waiting: BTreeSet<(usize, usize)>,
    remaining: usize,
    sequence: Vec<usize>,
    postponed: Vec<usize>,
    mark: Vec<usize>,
    stamp: usize,
    outside: Vec<usize>,
    outside_stamp: Vec<usize>,
}

impl QuotientGraph {
    fn new(mut neighbours: Vec<Vec<usize>>, dense: usize) -> Self {
        let size = neighbours.len();
        let postponed: Vec<usize> = (0..size).filter(|&i| neighbours[i].len() > dense).collect();
        let mut weight = vec![1; size];
        for &i in &postponed {
            weight[i] = 0;
            neighbours[i].clear();
        }
        if !postponed.is_empty() {
            for list in &mut neighbours {
                list.retain(|&j| weight[j] > 0);
            }
        }
        let degree: Vec<usize> = neighbours.iter().map(Vec::len).collect();
        Self {
            waiting: (0..size).filter(|&i| weight[i] > 0).map(|i| (degree[i], i)).collect(),
            remaining: size - postponed.len(),
            variables: neighbours,
            elements: vec![Vec::new(); size],
            members: vec![Vec::new(); size],
            element_weight: vec![0; size],
            merged: vec![Vec::new(); size],
            sequence: Vec::with_capacity(size),
            mark: vec![0; size],
            stamp: 0,
            outside: vec![0; size],
            outside_stamp: vec![0; size],
            weight,
            degree,
            postponed,
        }
    }

    fn lowest(&mut self) -> Option<usize> {
        self.waiting.pop_first().map(|(_, variable)| variable)
    }

    /// Turns a variable into an element and updates its members.
    fn eliminate(&mut self, pivot: usize) {
        self.sequence.push(pivot);
        self.remaining -= self.weight[pivot];
        self.weight[pivot] = 0;
        self.stamp += 1;
        let stamp = self.stamp;
        let members = self.element_members(pivot);
        let mut total: usize = members.iter().map(|&i| self.weight[i]).sum();
        for &i in &members {
            self.waiting.remove(&(self.degree[i], i));
            for &element in &self.elements[i] {
                if self.outside_stamp[element] != stamp {
                    self.outside_stamp[element] = stamp;
                    self.outside[element] = self.element_weight[element];
                }
                self.outside[element] -= self.weight[i].min(self.outside[element]);
            }
        }
        let mut same_hash: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for &i in &members {
            let mut elements = std::mem::take(&mut self.elements[i]);
            elements.retain(|&e| {
                if self.element_weight[e] > 0 && self.outside[e] == 0 {
                    // All its members are in the new element.
                    self.element_weight[e] = 0;
                    self.members[e] = Vec::new();
                }
                self.element_weight[e] > 0
            });
            let mut variables = std::mem::take(&mut self.variables[i]);
            variables.retain(|&j| self.weight[j] > 0 && self.mark[j] != stamp);
            let beyond: usize = elements.iter().map(|&e| self.outside[e]).sum::<usize>()
                + variables.iter().map(|&j| self.weight[j]).sum::<usize>();
            if beyond == 0 {
                // Nothing but the new element sees it: eliminate it at once.
                self.remaining -= self.weight[i];
                total -= self.weight[i];
                self.weight[i] = 0;
                self.merged[pivot].push(i);
                continue;
            }
            // For now the degree without the new element's part, which is not yet final.
            self.degree[i] = beyond.min(self.degree[i]);
            elements.push(pivot);
            elements.sort_unstable();
            let hash = elements.iter().chain(&variables).fold(0_usize, |sum, &j| sum.wrapping_add(j));
            same_hash.entry(hash).or_default().push(i);
            self.elements[i] = elements;
            self.variables[i] = variables;
        }
        for candidates in same_hash.values() {
            self.merge_equal(candidates);
        }
        let members: Vec<usize> = members.into_iter().filter(|&i| self.weight[i] > 0).collect();
        for &i in &members {
            let inside = total - self.weight[i];
            self.degree[i] = (self.degree[i] + inside).min(self.remaining - self.weight[i]);
            self.waiting.insert((self.degree[i], i));
        }
        self.element_weight[pivot] = total;
        self.members[pivot] = members;
    }

    /// Live variables next to the pivot directly or through its elements, marked with the stamp; the elements are absorbed.
    fn element_members(&mut self, pivot: usize) -> Vec<usize> {
        let mut members = Vec::new();
        let mut add = |list: Vec<usize>, weight: &[usize], mark: &mut [usize], stamp: usize| {
            for j in list {
                if weight[j] > 0 && mark[j] != stamp {
                    mark[j] = stamp;
                    members.push(j);
                }
            }
        };
        add(std::mem::take(&mut self.variables[pivot]), &self.weight, &mut self.mark, self.stamp);
        for element in std::mem::take(&mut self.elements[pivot]) {
            self.element_weight[element] = 0;
            add(std::mem::take(&mut self.members[element]), &self.weight, &mut self.mark, self.stamp);
        }
        members.sort_unstable();
        members
    }

    /// Merges the variables among the candidates that have the same lists.
    fn merge_equal(&mut self, candidates: &[usize]) {
        for (position, &i) in candidates.iter().enumerate() {
            if self.weight[i] == 0 {
                continue;
            }
            for &j in &candidates[position + 1..] {
                if self.weight[j] > 0 && self.elements[i] == self.elements[j] && self.variables[i] == self.variables[j]
                {
                    self.weight[i] += self.weight[j];
                    self.weight[j] = 0;
                    self.variables[j] = Vec::new();
                    self.elements[j] = Vec::new();
                    self.merged[i].push(j);
                }
            }
        }
    }

    /// Appends a variable and everything that was merged into it.
    fn append(&self, variable: usize, order: &mut Vec<usize>) {
        let mut stack = vec![variable];
        while let Some(i) = stack.pop() {
            order.push(i);
            stack.extend(self.merged[i].iter().rev());
        }
    }
}
