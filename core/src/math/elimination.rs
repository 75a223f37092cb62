//! Symbolic elimination of a sparse matrix: elimination tree, fill, and the blocks (supernodes) of a multifrontal LU.
//!
//! The pattern of A + A' is eliminated along its diagonal in a minimum degree order, so `L` and `U'` have one pattern.
//! Tree and structures after Liu (1990, SIAM J. Matrix Anal. Appl. 11, 134); columns with one structure form a block
//! whose pivots are eliminated together in a dense frontal matrix (Duff & Reid 1983, ACM TOMS 9, 302).

use super::ordering::minimum_degree;
use super::sparse::Pattern;
use crate::math::sort::sort_by_key;

/// Neighbouring blocks merge when no more than this share of the merged front's factor entries are zeros.
const MERGE_ZERO_SHARE: f64 = 0.2;
/// Blocks of up to this many pivots merge even with up to half zeros: small fronts cost more to handle than to fill.
const SMALL_PIVOTS: usize = 4;

const NONE: usize = usize::MAX;

/// A block of pivots eliminated together, and where its numbers lie.
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// First pivot (in elimination order).
    pub first: usize,
    /// Number of pivots p.
    pub pivots: usize,
    /// Front size m: pivots and the rows below them.
    pub front: usize,
    /// Start of the block's row list (of length m) in [`Elimination::rows`].
    pub rows_start: usize,
    /// Start of the factor entries: p x m pivot rows, then (m - p) x p entries of `L` below.
    pub factor_start: usize,
    /// Blocks whose Schur complements enter this front, in elimination order.
    pub children: Vec<usize>,
    /// Where the rows below the pivots lie in the parent's front, ascending.
    pub in_parent: Vec<usize>,
}

/// What the pattern alone decides about an elimination.
#[derive(Clone, Debug)]
pub(super) struct Elimination {
    /// Original index of each elimination step.
    pub order: Vec<usize>,
    /// Blocks in elimination order.
    pub blocks: Vec<Block>,
    /// Row lists of all blocks.
    pub rows: Vec<usize>,
    /// Place of each value slot among the factor entries.
    pub places: Vec<usize>,
    /// Number of factor entries.
    pub factor_entries: usize,
    /// Largest length of the stack of Schur complements.
    pub stack_entries: usize,
    /// Multiplications of one factorisation.
    pub multiplications: f64,
}

/// A block while blocks are still merged.
struct Draft {
    first: usize,
    pivots: usize,
    /// Rows below the pivots, ascending.
    below: Vec<usize>,
    zeros: usize,
}

impl Draft {
    fn entries(&self) -> usize {
        self.pivots * (self.pivots + 2 * self.below.len())
    }
}

impl Elimination {
    pub fn new(pattern: &Pattern) -> Self {
        let neighbours = pattern.symmetric_neighbours();
        let order = minimum_degree(neighbours.clone());
        let parent = elimination_tree(&neighbours, &order);
        let postorder = postorder(&parent);
        let order: Vec<usize> = postorder.iter().map(|&k| order[k]).collect();
        let parent = elimination_tree(&neighbours, &order);
        let drafts = draft_blocks(&neighbours, &order, &parent);
        Self::lay_out(pattern, order, &drafts)
    }

    fn lay_out(pattern: &Pattern, order: Vec<usize>, drafts: &[Draft]) -> Self {
        let size = order.len();
        let mut block_of = vec![0; size];
        for (b, draft) in drafts.iter().enumerate() {
            block_of[draft.first..draft.first + draft.pivots].fill(b);
        }
        let mut blocks: Vec<Block> = Vec::with_capacity(drafts.len());
        let mut rows = Vec::new();
        let (mut factor_entries, mut multiplications) = (0, 0.0);
        for draft in drafts {
            let (p, m) = (draft.pivots, draft.pivots + draft.below.len());
            blocks.push(Block {
                first: draft.first,
                pivots: p,
                front: m,
                rows_start: rows.len(),
                factor_start: factor_entries,
                children: Vec::new(),
                in_parent: Vec::new(),
            });
            rows.extend(draft.first..draft.first + p);
            rows.extend(&draft.below);
            factor_entries += p * m + (m - p) * p;
            multiplications += (m - p + 1..=m).map(|k| (k * (k - 1)) as f64).sum::<f64>();
        }
        for (b, draft) in drafts.iter().enumerate() {
            let Some(&next) = draft.below.first() else { continue };
            let up = block_of[next];
            let front = &rows[blocks[up].rows_start..blocks[up].rows_start + blocks[up].front];
            blocks[b].in_parent = draft.below.iter().map(|&row| position(front, row)).collect();
            blocks[up].children.push(b);
        }
        let mut step = vec![0; size];
        for (k, &original) in order.iter().enumerate() {
            step[original] = k;
        }
        let mut places = vec![0; pattern.stored()];
        for column in 0..size {
            for slot in pattern.column(column) {
                let (i, j) = (step[pattern.rows()[slot]], step[column]);
                let block = &blocks[block_of[i.min(j)]];
                let front = &rows[block.rows_start..block.rows_start + block.front];
                let (p, m) = (block.pivots, block.front);
                let (i, j) = (position(front, i), position(front, j));
                places[slot] = block.factor_start + if i < p { i * m + j } else { p * m + (i - p) * p + j };
            }
        }
        let stack_entries = stack_entries(&blocks);
        Self { order, blocks, rows, places, factor_entries, stack_entries, multiplications }
    }
}

/// Position of a row that is known to be in an ascending list.
fn position(list: &[usize], row: usize) -> usize {
    list.partition_point(|&r| r < row)
}

/// Largest height of the stack when each block pushes its Schur complement before its children's are dropped.
fn stack_entries(blocks: &[Block]) -> usize {
    let complement = |block: &Block| (block.front - block.pivots) * (block.front - block.pivots);
    let (mut height, mut largest) = (0, 0);
    for block in blocks {
        let entries = complement(block);
        largest = largest.max(height + entries);
        height = height + entries - block.children.iter().map(|&c| complement(&blocks[c])).sum::<usize>();
    }
    largest
}

/// Parent of each step in the elimination tree (Liu 1990, algorithm 4.2, with path compression).
fn elimination_tree(neighbours: &[Vec<usize>], order: &[usize]) -> Vec<usize> {
    let size = order.len();
    let mut step = vec![0; size];
    for (k, &original) in order.iter().enumerate() {
        step[original] = k;
    }
    let mut parent = vec![NONE; size];
    let mut ancestor = vec![NONE; size];
    for (k, &original) in order.iter().enumerate() {
        for &neighbour in &neighbours[original] {
            let mut i = step[neighbour];
            while i < k {
                let next = ancestor[i];
                ancestor[i] = k;
                if next == NONE {
                    parent[i] = k;
                    break;
                }
                i = next;
            }
        }
    }
    parent
}

/// An order of the tree's steps in which each subtree is contiguous, its root last, the larger subtrees later.
fn postorder(parent: &[usize]) -> Vec<usize> {
    let size = parent.len();
    let mut weight = vec![1_usize; size];
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); size];
    let mut roots = Vec::new();
    for k in 0..size {
        if parent[k] == NONE {
            roots.push(k);
        } else {
            // A parent comes after its children, so that this child's weight is complete.
            weight[parent[k]] += weight[k];
            children[parent[k]].push(k);
        }
    }
    let mut order = Vec::with_capacity(size);
    // A preorder with the children from large to small, turned round, is the postorder from small to large.
    let mut stack = roots;
    while let Some(k) = stack.pop() {
        order.push(k);
        sort_by_key(&mut children[k], |&c| (weight[c], c));
        stack.extend(&children[k]);
    }
    order.reverse();
    order
}

/// Column structures, cut into blocks of equal structure and merged where that costs few zeros.
fn draft_blocks(neighbours: &[Vec<usize>], order: &[usize], parent: &[usize]) -> Vec<Draft> {
    let size = order.len();
    let mut step = vec![0; size];
    for (k, &original) in order.iter().enumerate() {
        step[original] = k;
    }
    let mut structures: Vec<Vec<usize>> = vec![Vec::new(); size];
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); size];
    let mut mark = vec![NONE; size];
    let mut drafts: Vec<Draft> = Vec::new();
    for k in 0..size {
        mark[k] = k;
        let mut below = Vec::new();
        let mut add = |row: usize| {
            if row > k && mark[row] != k {
                mark[row] = k;
                below.push(row);
            }
        };
        neighbours[order[k]].iter().for_each(|&i| add(step[i]));
        for child in std::mem::take(&mut children[k]) {
            std::mem::take(&mut structures[child]).into_iter().for_each(&mut add);
        }
        below.sort_unstable();
        if parent[k] != NONE {
            children[parent[k]].push(k);
        }
        structures[k] = below.clone();
        drafts.push(Draft { first: k, pivots: 1, below, zeros: 0 });
        merge_last(&mut drafts, parent, |_| 0.0);
    }
    let mut merged = Vec::new();
    for draft in drafts {
        merged.push(draft);
        merge_last(&mut merged, parent, |pivots| if pivots <= SMALL_PIVOTS { 0.5 } else { MERGE_ZERO_SHARE });
    }
    merged
}

/// Merges the last block with the one before it as long as that is its child and the share of zeros stays allowed.
fn merge_last(drafts: &mut Vec<Draft>, parent: &[usize], allowed_share: impl Fn(usize) -> f64) {
    while let [.., child, top] = drafts.as_slice() {
        if parent[top.first - 1] != top.first {
            return;
        }
        let pivots = child.pivots + top.pivots;
        let merged = pivots * (pivots + 2 * top.below.len());
        let zeros = merged - top.entries() - child.entries() + top.zeros + child.zeros;
        if zeros as f64 > allowed_share(pivots) * merged as f64 {
            return;
        }
        let first = child.first;
        if let (Some(top), Some(_)) = (drafts.pop(), drafts.pop()) {
            drafts.push(Draft { first, pivots, below: top.below, zeros });
        }
    }
}
